#include "recording.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "force.h"
#include "kinematics.h"
#include "units.h"

enum { CYCLES_NEEDED = 6 }; /* three to fit and three to judge */

static const double NEUTRAL_TOLERANCE_M = 0.05;
static const char *const axis_names[DOFS] = {"x", "y", "z", "phi", "theta", "psi"};

void recording_init(struct recording *r, const struct params *params) { *r = (struct recording){.params = params}; }

void recording_free(struct recording *r) {
    for (int i = 0; i < r->tests; i++) free(r->test[i].sample);
    r->tests = 0;
}

/* The test that the cycle belongs to: the last one, or a new one. */
static struct recording_test *place(struct recording *r, const struct cycle *c) {
    struct recording_test *t = r->tests ? &r->test[r->tests - 1] : NULL;
    bool same = t && t->test == c->test && t->dof == c->dof && (!t->count || c->test_time_s > t->sample[t->count - 1].test_time_s);
    if (same) return t;
    if (r->tests == RECORDING_TESTS) return NULL;
    const struct test_params *p = &r->params->tests;
    t = &r->test[r->tests++];
    *t = (struct recording_test){.test = c->test, .dof = c->dof, .frequency_hz = p->frequency_hz,
                                 .amplitude = c->dof < DOF_PHI ? p->amplitude_m : p->amplitude_rad, .first = -1};
    return t;
}

static bool finite_all(const double *x) {
    double sum = 0.0;
    for (int i = 0; i < LEGS; i++) sum += fabs(x[i]);
    return isfinite(sum);
}

int recording_add(struct recording *r, const struct cycle *c, struct error *error) {
    if (c->dof == DOF_NONE || (c->phase != PHASE_RAMP_IN && c->phase != PHASE_EVALUATE)) return STATUS_OK;
    struct recording_test *t = place(r, c);
    if (!t) return error_set(error, STATUS_USAGE, "the log has more than %d tests", RECORDING_TESTS);
    if (t->count == t->capacity) {
        int capacity = t->capacity ? 2 * t->capacity : 4096;
        struct recording_sample *more = realloc(t->sample, (size_t)capacity * sizeof *more);
        if (!more) return error_set(error, STATUS_IO, "out of memory for the log's samples");
        t->sample = more, t->capacity = capacity;
    }
    struct recording_sample *s = &t->sample[t->count++];
    s->test_time_s = c->test_time_s;
    s->clock_s = 1e-9 * (double)c->in.time_ns;
    memcpy(s->length_m, c->in.length_m, sizeof s->length_m);
    memcpy(s->p1_pa, c->in.p1_pa, sizeof s->p1_pa);
    memcpy(s->p2_pa, c->in.p2_pa, sizeof s->p2_pa);
    memcpy(s->valve, c->out.valve, sizeof s->valve);
    memcpy(s->ref, c->ref, sizeof s->ref);
    s->good = !c->in.flags && finite_all(s->length_m) && finite_all(s->p1_pa) && finite_all(s->p2_pa) && finite_all(s->valve);
    if (c->phase == PHASE_EVALUATE) {
        if (t->first < 0) t->first = t->count - 1;
        t->end = t->count;
    }
    return STATUS_OK;
}

/* Amplitude of a sinusoid in a sequence of samples, over the evaluated part. */
static double lock_in_amplitude(const struct recording_test *t, double frequency_hz, const double *first, size_t stride) {
    double mean = 0.0, s = 0.0, c = 0.0;
    int n = t->end - t->first;
    for (int i = 0; i < n; i++) mean += first[(size_t)i * stride] / n;
    for (int i = 0; i < n; i++) {
        double phase = 2.0 * PI * frequency_hz * t->sample[t->first + i].test_time_s, x = first[(size_t)i * stride] - mean;
        s += x * sin(phase), c += x * cos(phase);
    }
    return 2.0 * hypot(s, c) / n;
}

static const size_t STRIDE = sizeof(struct recording_sample) / sizeof(double);
_Static_assert(sizeof(struct recording_sample) % sizeof(double) == 0, "samples are addressed as doubles");

static double deviation(const struct recording_test *t, const double *first) {
    double sum = 0.0, square = 0.0;
    int n = t->end - t->first;
    for (int i = 0; i < n; i++) {
        double x = first[(size_t)i * STRIDE] - first[0];
        sum += x, square += x * x;
    }
    return sqrt(fmax(square - sum * sum / n, 0.0) / n);
}

/* A channel of one leg: dead, or at the end of its range for a good part of the time. */
static int check_channel(const struct recording_test *t, const double *first, const char *name, int leg, double top, struct error *error) {
    int clipped = 0, n = t->end - t->first;
    for (int i = 0; i < n; i++) clipped += first[(size_t)i * STRIDE] >= top;
    if (!(deviation(t, first) > 0.0))
        return error_set(error, STATUS_USAGE, "test %s: %s of leg %d does not change: a dead sensor, or a column of zeros",
                         axis_names[t->dof], name, leg + 1);
    if (clipped > n / 50)
        return error_set(error, STATUS_USAGE, "test %s: %s of leg %d is clipped in %d %% of the samples", axis_names[t->dof], name, leg + 1,
                         100 * clipped / n);
    return STATUS_OK;
}

static int check_channels(const struct params *p, const struct recording_test *t, struct error *error) {
    const struct recording_sample *s = &t->sample[t->first];
    double top = p->sensors.pressure_full_scale_pa * 0.999;
    for (int k = 0; k < LEGS; k++) {
        int status = check_channel(t, &s->length_m[k], "length", k, HUGE_VAL, error);
        if (!status) status = check_channel(t, &s->p1_pa[k], "p1", k, top, error);
        if (!status) status = check_channel(t, &s->p2_pa[k], "p2", k, top, error);
        if (!status) status = check_channel(t, &s->valve[k], "valve command", k, HUGE_VAL, error);
        if (status) return status;
    }
    return STATUS_OK;
}

/* The frequency at which the legs move most, of the model's and its neighbours. */
static int check_frequency(const struct recording_test *t, struct error *error) {
    double here = 0.0, most = 0.0, at_hz = t->frequency_hz;
    for (double f = 0.25; f <= 40.0; f += 0.25) {
        double sum = 0.0;
        for (int k = 0; k < LEGS; k++) sum += lock_in_amplitude(t, f, &t->sample[t->first].length_m[k], STRIDE);
        if (fabs(f - t->frequency_hz) < 0.125) here = sum;
        if (sum > most) most = sum, at_hz = f;
    }
    if (most > 2.0 * here)
        return error_set(error, STATUS_USAGE, "test %s: the legs move at %.3g Hz, but tests.frequency_hz is %.3g", axis_names[t->dof], at_hz,
                         t->frequency_hz);
    return STATUS_OK;
}

/* Lengths about their neutral value, compared with what the reference asks for: signs, order and machine. */
struct leg_moments {
    double product[LEGS][LEGS], measured[LEGS], asked[LEGS]; /* sums over all tests */
};

static void add_test(const struct recording_test *t, const struct kinematics *k, struct leg_moments *m) {
    double mean[LEGS] = {0}, asked[LEGS];
    int n = t->end - t->first;
    for (int i = t->first; i < t->end; i++)
        for (int leg = 0; leg < LEGS; leg++) mean[leg] += t->sample[i].length_m[leg] / n;
    for (int i = t->first; i < t->end; i++) {
        ik_lengths(k, t->sample[i].ref, asked);
        for (int a = 0; a < LEGS; a++) {
            double x = t->sample[i].length_m[a] - mean[a], y = asked[a] - k->neutral_length_m;
            m->measured[a] += x * x, m->asked[a] += y * y;
            for (int b = 0; b < LEGS; b++) m->product[a][b] += x * (asked[b] - k->neutral_length_m);
        }
    }
}

static int check_legs(const struct recording *r, const struct kinematics *k, struct error *error) {
    struct leg_moments m = {0};
    for (int i = 0; i < r->tests; i++) add_test(&r->test[i], k, &m);
    for (int a = 0; a < LEGS; a++) {
        double own = m.product[a][a] / sqrt(m.measured[a] * m.asked[a]), best = own;
        int like = a;
        if (!isfinite(own)) return STATUS_OK; /* no reference: not evaluated */
        for (int b = 0; b < LEGS; b++) {
            double other = m.product[a][b] / sqrt(m.measured[a] * m.asked[b]);
            if (other > best + 0.2) best = other, like = b;
        }
        if (own < -0.5) return error_set(error, STATUS_USAGE, "the length of leg %d moves against its reference: its sign is wrong", a + 1);
        if (like != a && best > 0.8)
            return error_set(error, STATUS_USAGE, "the length of leg %d moves as leg %d should: two legs are exchanged", a + 1, like + 1);
        double scale = m.product[a][a] / m.asked[a];
        if (!(scale > 0.5 && scale < 2.0))
            return error_set(error, STATUS_USAGE, "leg %d moves %.3g times as far as the reference asks for: other units, or another machine",
                             a + 1, scale);
    }
    return STATUS_OK;
}

static int check_machine(const struct recording_test *t, const struct kinematics *k, struct error *error) {
    for (int leg = 0; leg < LEGS; leg++) {
        double mean = 0.0;
        for (int i = t->first; i < t->end; i++) mean += t->sample[i].length_m[leg] / (t->end - t->first);
        if (fabs(mean - k->neutral_length_m) > NEUTRAL_TOLERANCE_M)
            return error_set(error, STATUS_USAGE, "test %s: leg %d is %.4g m long at its middle, the model's %.4g: other units, or another machine",
                             axis_names[t->dof], leg + 1, mean, k->neutral_length_m);
    }
    return STATUS_OK;
}

/* Forces against the weight: the sum of what the legs hold must be the machine's, each pressure on its own side. */
static int check_pressures(const struct recording *r, struct error *error) {
    const struct params *p = r->params;
    struct cylinder_areas areas = cylinder_areas(&p->actuator);
    const struct recording_test *t = &r->test[0];
    double direct[LEGS] = {0}, exchanged = 0.0, sum = 0.0, weight = (p->payload.mass_kg + LEGS * p->actuator.upper_mass_kg) * p->payload.gravity_mps2;
    int n = t->end - t->first;
    for (int i = t->first; i < t->end; i++)
        for (int k = 0; k < LEGS; k++) {
            direct[k] += leg_force(&areas, t->sample[i].p1_pa[k], t->sample[i].p2_pa[k]) / n;
            exchanged += leg_force(&areas, t->sample[i].p2_pa[k], t->sample[i].p1_pa[k]) / n;
        }
    for (int k = 0; k < LEGS; k++) sum += direct[k];
    for (int k = 0; k < LEGS; k++)
        if (fabs(direct[k] - (sum - direct[k]) / (LEGS - 1)) > 2.0 * weight)
            return error_set(error, STATUS_USAGE, "the mean force of leg %d is %.3g N, the others' %.3g: p1 and p2 exchanged there, or a sign wrong",
                             k + 1, direct[k], (sum - direct[k]) / (LEGS - 1));
    if (!(sum > 0.2 * weight && sum < 5.0 * weight))
        return error_set(error, STATUS_USAGE, "the legs hold %.3g N in all, a machine of this weight needs about %.3g: %s", sum, 1.2 * weight,
                         exchanged > 0.2 * weight && exchanged < 5.0 * weight ? "p1 and p2 are exchanged" : "other units, or another machine");
    return STATUS_OK;
}

int recording_check(const struct recording *r, struct error *error) {
    struct kinematics k;
    int status = kinematics_init(&k, r->params, error);
    if (status) return status;
    if (!r->tests) return error_set(error, STATUS_USAGE, "no sinusoidal test in the log");
    for (int i = 0; i < r->tests; i++) {
        const struct recording_test *t = &r->test[i];
        double seconds = t->first < 0 ? 0.0 : t->sample[t->end - 1].test_time_s - t->sample[t->first].test_time_s;
        if (seconds * t->frequency_hz < CYCLES_NEEDED - 0.1)
            return error_set(error, STATUS_USAGE, "test %s: %.3g s evaluated, too short: at least %d cycles of %g Hz are needed",
                             axis_names[t->dof], seconds, CYCLES_NEEDED, t->frequency_hz);
        status = check_channels(r->params, t, error);
        if (!status) status = check_machine(t, &k, error);
        if (!status) status = check_frequency(t, error);
        if (status) return status;
    }
    status = check_legs(r, &k, error);
    return status ? status : check_pressures(r, error);
}

double recording_clock(const struct recording *r, double *std) {
    double xx = 0.0, xy = 0.0, yy = 0.0;
    int n = 0;
    for (int i = 0; i < r->tests; i++) {
        const struct recording_test *t = &r->test[i];
        double x = 0.0, y = 0.0;
        int count = t->end - t->first;
        for (int j = t->first; j < t->end; j++) x += t->sample[j].test_time_s / count, y += (t->sample[j].clock_s - t->sample[t->first].clock_s) / count;
        for (int j = t->first; j < t->end; j++) {
            double dx = t->sample[j].test_time_s - x, dy = t->sample[j].clock_s - t->sample[t->first].clock_s - y;
            xx += dx * dx, xy += dx * dy, yy += dy * dy;
        }
        n += count - 1;
    }
    double ratio = xy / xx;
    *std = sqrt(fmax(yy - ratio * xy, 0.0) / (n - 1) / xx);
    return ratio;
}
