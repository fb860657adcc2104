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

static bool finite_all(int count, const double *x) {
    double sum = 0.0;
    for (int i = 0; i < count; i++) sum += fabs(x[i]);
    return isfinite(sum);
}

static void take_forces(struct recording *r, const struct cycle *c, struct recording_sample *s) {
    struct cylinder_areas areas = cylinder_areas(&r->params->actuator);
    int legs = params_legs(r->params);
    bool pressures = finite_all(legs, s->p1_pa) && finite_all(legs, s->p2_pa);
    for (int k = 0; k < legs; k++) s->force_n[k] = pressures ? leg_force(&areas, s->p1_pa[k], s->p2_pa[k]) : c->force_n[k];
    r->measured.pressures = r->measured.pressures || pressures;
    r->measured.force = r->measured.force || finite_all(legs, s->force_n);
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
    int legs = params_legs(r->params), refs = legs < LEGS ? 1 : DOFS;
    *s = (struct recording_sample){.test_time_s = c->test_time_s, .clock_s = 1e-9 * (double)c->in.time_ns};
    memcpy(s->length_m, c->in.length_m, (size_t)legs * sizeof(double));
    memcpy(s->p1_pa, c->in.p1_pa, (size_t)legs * sizeof(double));
    memcpy(s->p2_pa, c->in.p2_pa, (size_t)legs * sizeof(double));
    memcpy(s->valve, c->out.valve, (size_t)legs * sizeof(double));
    memcpy(s->ref, c->ref, (size_t)refs * sizeof(double));
    take_forces(r, c, s);
    r->measured.valve = r->measured.valve || finite_all(legs, s->valve);
    r->measured.reference = r->measured.reference || finite_all(refs, s->ref);
    s->good = !c->in.flags && finite_all(legs, s->length_m) && finite_all(legs, s->force_n);
    if (c->phase == PHASE_EVALUATE) {
        if (t->first < 0) t->first = t->count - 1;
        t->end = t->count;
    }
    return STATUS_OK;
}

/* Amplitude of a sinusoid in a sequence of samples, over the evaluated part. */
static double lock_in_amplitude(const struct recording_test *t, double frequency_hz, const double *first, size_t stride) {
    double mean = 0.0, s = 0.0, c = 0.0;
    int n = t->end - t->first, good = 0;
    for (int i = 0; i < n; i++)
        if (t->sample[t->first + i].good) mean += first[(size_t)i * stride], good++;
    mean /= good;
    for (int i = 0; i < n; i++) {
        if (!t->sample[t->first + i].good) continue;
        double phase = 2.0 * PI * frequency_hz * t->sample[t->first + i].test_time_s, x = first[(size_t)i * stride] - mean;
        s += x * sin(phase), c += x * cos(phase);
    }
    return 2.0 * hypot(s, c) / good;
}

static const size_t STRIDE = sizeof(struct recording_sample) / sizeof(double);
_Static_assert(sizeof(struct recording_sample) % sizeof(double) == 0, "samples are addressed as doubles");

static double deviation(const struct recording_test *t, const double *first) {
    double sum = 0.0, square = 0.0, zero = NAN;
    int n = 0;
    for (int i = t->first; i < t->end; i++) {
        if (!t->sample[i].good) continue;
        double value = first[(size_t)(i - t->first) * STRIDE];
        if (!n++) zero = value;
        sum += value - zero, square += (value - zero) * (value - zero);
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

static int check_channels(const struct recording *r, const struct recording_test *t, struct error *error) {
    const struct recording_sample *s = &t->sample[t->first];
    const struct recording_measured *m = &r->measured;
    double top = r->params->sensors.pressure_full_scale_pa * 0.999;
    for (int k = 0; k < params_legs(r->params); k++) {
        int status = check_channel(t, &s->length_m[k], "length", k, HUGE_VAL, error);
        if (!status && m->pressures) status = check_channel(t, &s->p1_pa[k], "p1", k, top, error);
        if (!status && m->pressures) status = check_channel(t, &s->p2_pa[k], "p2", k, top, error);
        if (!status && !m->pressures) status = check_channel(t, &s->force_n[k], "force", k, HUGE_VAL, error);
        if (!status && m->valve) status = check_channel(t, &s->valve[k], "valve command", k, HUGE_VAL, error);
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

/* A machine of one axis, positions as reading. */
static int check_stroke(const struct params *p, const struct recording_test *t, struct error *error) {
    double low = HUGE_VAL, high = -HUGE_VAL, middle = p->axis.middle_m, half = 0.5 * p->actuator.stroke_m;
    for (int i = t->first; i < t->end; i++) {
        if (!t->sample[i].good) continue;
        low = fmin(low, t->sample[i].length_m[0]), high = fmax(high, t->sample[i].length_m[0]);
    }
    if (low >= middle - half && high <= middle + half) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "the position runs from %.4g to %.4g m, outside a stroke of %g m about %g m (actuator.stroke_m, "
                     "axis.middle_m): other units, or another zero", low, high, p->actuator.stroke_m, middle);
}

/* Force against motion over the evaluated parts: mean power, and the mass that the force in step with the acceleration would move. */
struct drive {
    double power, effort; /* F v, and the product of their amplitudes */
    double mass_kg;
};

static double axis_force(const struct recording *r, const struct recording_sample *s, bool exchanged) {
    struct cylinder_areas areas = cylinder_areas(&r->params->actuator);
    return exchanged ? leg_force(&areas, s->p2_pa[0], s->p1_pa[0]) : s->force_n[0];
}

/* Of the fundamental. */
static void add_drive(const struct recording *r, const struct recording_test *t, bool exchanged, double sum[5]) {
    double w = 2.0 * PI * t->frequency_hz, x[3] = {0}, f[3] = {0}, n = 0.0;
    for (int pass = 0; pass < 2; pass++)
        for (int i = t->first; i < t->end; i++) {
            const struct recording_sample *s = &t->sample[i];
            if (!s->good) continue;
            double basis[3] = {1.0, sin(w * s->test_time_s), cos(w * s->test_time_s)};
            double position = s->length_m[0] - x[0] / n, force = axis_force(r, s, exchanged) - f[0] / n;
            if (!pass) n += 1.0, x[0] += s->length_m[0], f[0] += axis_force(r, s, exchanged);
            for (int a = 1; a < 3 && pass; a++) x[a] += 2.0 * basis[a] * position / n, f[a] += 2.0 * basis[a] * force / n;
        }
    double v[2] = {-w * x[2], w * x[1]}, acceleration[2] = {-w * w * x[1], -w * w * x[2]};
    for (int q = 0; q < 2; q++) {
        sum[0] += f[q + 1] * v[q], sum[1] += f[q + 1] * acceleration[q];
        sum[2] += acceleration[q] * acceleration[q], sum[3] += f[q + 1] * f[q + 1], sum[4] += v[q] * v[q];
    }
}

static struct drive drive_of(const struct recording *r, bool exchanged) {
    double sum[5] = {0};
    for (int i = 0; i < r->tests; i++) add_drive(r, &r->test[i], exchanged, sum);
    return (struct drive){.power = sum[0], .effort = sqrt(sum[3] * sum[4]), .mass_kg = sum[1] / sum[2]};
}

/* Whatever the friction, the force drives the motion, and a mass is positive. */
static bool drives(const struct drive *d, double mass_kg) { return d->power > -0.2 * d->effort && d->mass_kg > -0.5 * mass_kg; }

static int check_axis(const struct recording *r, struct error *error) {
    double mass_kg = r->params->axis.mass_kg;
    struct drive d = drive_of(r, false), other = drive_of(r, true);
    bool exchanged = r->measured.pressures && drives(&other, mass_kg);
    if (!drives(&d, mass_kg))
        return error_set(error, STATUS_USAGE, "the force works against the motion, as if the mass were %.3g kg: %s", d.mass_kg,
                         exchanged ? "p1 and p2 are exchanged, or the position's sign is wrong" : "the sign of force or position is wrong");
    if (d.mass_kg > 10.0 * mass_kg)
        return error_set(error, STATUS_USAGE, "force and motion would go together if the mass were %.3g kg; the model has %.3g (axis.mass_kg): "
                         "other units, or another machine", d.mass_kg, mass_kg);
    return STATUS_OK;
}

/* Samples are good where all is finite that the log has; what it has not is zero. */
static void settle(struct recording *r) {
    const struct recording_measured *m = &r->measured;
    int legs = params_legs(r->params);
    for (int i = 0; i < r->tests; i++)
        for (int j = 0; j < r->test[i].count; j++) {
            struct recording_sample *s = &r->test[i].sample[j];
            if (m->pressures) s->good = s->good && finite_all(legs, s->p1_pa) && finite_all(legs, s->p2_pa);
            else memset(s->p1_pa, 0, sizeof s->p1_pa), memset(s->p2_pa, 0, sizeof s->p2_pa);
            if (m->valve) s->good = s->good && finite_all(legs, s->valve);
            else memset(s->valve, 0, sizeof s->valve);
        }
}

int recording_check(struct recording *r, struct error *error) {
    struct kinematics k;
    bool axis = r->params->mechanism == MECHANISM_AXIS;
    int status = kinematics_init(&k, r->params, error);
    if (status) return status;
    if (!r->tests) return error_set(error, STATUS_USAGE, "no sinusoidal test in the log");
    if (!r->measured.force)
        return error_set(error, STATUS_USAGE, "neither pressures nor forces in the log: there is nothing to hold against the motion");
    settle(r);
    for (int i = 0; i < r->tests; i++) {
        const struct recording_test *t = &r->test[i];
        double seconds = t->first < 0 ? 0.0 : t->sample[t->end - 1].test_time_s - t->sample[t->first].test_time_s;
        if (seconds * t->frequency_hz < CYCLES_NEEDED - 0.1)
            return error_set(error, STATUS_USAGE, "test %s: %.3g s evaluated, too short: at least %d cycles of %g Hz are needed",
                             axis_names[t->dof], seconds, CYCLES_NEEDED, t->frequency_hz);
        status = check_channels(r, t, error);
        if (!status) status = axis ? check_stroke(r->params, t, error) : check_machine(t, &k, error);
        if (!status) status = check_frequency(t, error);
        if (status) return status;
    }
    if (axis) return check_axis(r, error);
    status = check_legs(r, &k, error);
    return status || !r->measured.pressures ? status : check_pressures(r, error);
}

double recording_step_s(const struct recording_test *t) {
    double first_s = t->sample[t->first].test_time_s, step_s = (t->sample[t->end - 1].test_time_s - first_s) / (t->end - 1 - t->first);
    for (int pass = 0; pass < 3; pass++) { /* the mean of steps that are not gaps */
        double sum = 0.0;
        int steps = 0;
        for (int i = t->first + 1; i < t->end; i++) {
            double step = t->sample[i].test_time_s - t->sample[i - 1].test_time_s;
            if (step < 1.5 * step_s) sum += step, steps++;
        }
        step_s = sum / steps;
    }
    return step_s;
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
