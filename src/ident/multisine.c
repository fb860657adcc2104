#include "multisine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "force.h"
#include "kinematics.h"
#include "params.h"
#include "units.h"

static const double PERIOD_S = 4.0, LOW_HZ = 1.0, HIGH_HZ = 32.0;
/* Frequency of the highest tone, as a share of the loop's rate: a delay of half a cycle is a fifth
 * of a radian there. */
static const double OF_RATE = 1.0 / 16.0;
/* Rms rate of the fastest leg, as a share of multisine_rate_limit_mps(); peaks are about four times
 * as high. */
static const double SHARE = 1.0 / 25.0;
static const double neutral[DOFS] = {0};

double multisine_rate_limit_mps(const struct params *p) {
    struct cylinder_areas a = cylinder_areas(&p->actuator);
    const struct hydraulics_params *h = &p->hydraulics;
    double least = p->limits.leg_rate_mps;
    for (int k = 0; k < LEGS; k++) {
        double a1 = a.a1_m2[k], a2 = a.a2_m2[k], cubes = a1 * a1 * a1 + a2 * a2 * a2;
        least = fmin(least, p->control.output_limit * h->valve_flow_m3_per_s[k] * sqrt(a2 * h->supply_pa / h->valve_drop_pa / cubes));
    }
    return least;
}

/* Gives all tones the same speed of their fastest leg, and scales the sum of the tones to SHARE of
 * multisine_rate_limit_mps(). */
static void scale(struct multisine *m, const struct params *params, double j[LEGS][DOFS]) {
    double most = 0.0, rate_mps = SHARE * multisine_rate_limit_mps(params);
    for (int i = 0; i < m->tones; i++) {
        double fastest = 0.0;
        for (int k = 0; k < LEGS; k++) fastest = fmax(fastest, fabs(j[k][m->tone[i].dof]));
        m->tone[i].amplitude = 1.0 / (2.0 * PI * m->tone[i].hz * fastest);
    }
    for (int k = 0; k < LEGS; k++) {
        double square = 0.0;
        for (int i = 0; i < m->tones; i++) square += 0.5 * pow(j[k][m->tone[i].dof] * m->tone[i].amplitude * 2.0 * PI * m->tone[i].hz, 2.0);
        most = fmax(most, square);
    }
    for (int i = 0; i < m->tones; i++) m->tone[i].amplitude *= rate_mps / sqrt(most);
}

/* Peak rate of the fastest leg. The motion is so small that the Jacobian at neutral suffices. */
static double find_peak(const struct multisine *m, double j[LEGS][DOFS]) {
    double most = 0.0;
    for (int n = 0; n < m->samples; n++) {
        double rate[LEGS] = {0};
        for (int i = 0; i < m->tones; i++) {
            const struct multisine_tone *l = &m->tone[i];
            double w = 2.0 * PI * l->hz, pose_rate = l->amplitude * w * cos(w * n * m->step_s + l->phase);
            for (int k = 0; k < LEGS; k++) rate[k] += j[k][l->dof] * pose_rate;
        }
        for (int k = 0; k < LEGS; k++) most = fmax(most, fabs(rate[k]));
    }
    return most;
}

int multisine_init(struct multisine *m, const struct params *params, struct error *error) {
    /* Axes of successive tones, ordered so that neighbouring tones move different legs. */
    static const enum dof turn[DOFS] = {DOF_X, DOF_PHI, DOF_Y, DOF_THETA, DOF_Z, DOF_PSI};
    struct kinematics k;
    double j[LEGS][DOFS], dt_s = params->loop.period_s;
    *m = (struct multisine){.step_s = dt_s, .samples = (int)lround(PERIOD_S / dt_s)};
    const char *refusal = params_mechanism(params)->refuses.survey;
    if (refusal) return error_set(error, STATUS_USAGE, "%s", refusal);
    int status = kinematics_init(&k, params, error);
    if (status) return status;
    m->period_s = m->samples * dt_s;
    int low = (int)lround(LOW_HZ * m->period_s), high = (int)(fmin(HIGH_HZ, OF_RATE / dt_s) * m->period_s), last = low - 1;
    for (int i = 0; i < MULTISINE_TONES && last < high; i++) {
        int harmonic = (int)lround(low * pow((double)high / low, (double)i / (MULTISINE_TONES - 1)));
        last = harmonic > last ? harmonic : last + 1;
        m->tone[m->tones++] = (struct multisine_tone){.dof = turn[i % DOFS], .hz = last / m->period_s};
    }
    if (m->tones < MULTISINE_TONES)
        return error_set(error, STATUS_USAGE, "--survey: loop.period_s %g is too slow: tones up to %.3g Hz only", dt_s, OF_RATE / dt_s);
    for (int i = 0; i < m->tones; i++) m->tone[i].phase = -PI * i * i / m->tones;
    ik_jacobian(&k, neutral, j);
    scale(m, params, j);
    m->peak_mps = find_peak(m, j);
    return STATUS_OK;
}

int multisine_trajectory(const struct multisine *m, struct trajectory *t, struct error *error) {
    *t = (struct trajectory){.knots = m->samples + 1, .passes = MULTISINE_PASSES};
    t->knot = calloc((size_t)t->knots, sizeof *t->knot);
    if (!t->knot) return error_set(error, STATUS_IO, "out of memory");
    for (int n = 0; n < t->knots; n++) {
        t->knot[n].time_s = n * m->step_s;
        for (int i = 0; i < m->tones; i++) {
            const struct multisine_tone *l = &m->tone[i];
            t->knot[n].pose[l->dof] += l->amplitude * sin(2.0 * PI * l->hz * (n % m->samples) * m->step_s + l->phase);
        }
    }
    return trajectory_bend(t) ? STATUS_OK : error_set(error, STATUS_IO, "out of memory");
}

/* Number of values of a sample that are averaged. */
enum { VALUES = 4 * LEGS + DOFS };

static void values_of(const struct recording_sample *s, double value[VALUES]) {
    memcpy(value, s->length_m, sizeof s->length_m);
    memcpy(value + LEGS, s->p1_pa, sizeof s->p1_pa);
    memcpy(value + 2 * LEGS, s->p2_pa, sizeof s->p2_pa);
    memcpy(value + 3 * LEGS, s->valve, sizeof s->valve);
    memcpy(value + 4 * LEGS, s->ref, sizeof s->ref);
}

static void set_values(struct recording_sample *s, const double value[VALUES]) {
    memcpy(s->length_m, value, sizeof s->length_m);
    memcpy(s->p1_pa, value + LEGS, sizeof s->p1_pa);
    memcpy(s->p2_pa, value + 2 * LEGS, sizeof s->p2_pa);
    memcpy(s->valve, value + 3 * LEGS, sizeof s->valve);
    memcpy(s->ref, value + 4 * LEGS, sizeof s->ref);
    s->refused = REFUSED_NOT;
}

/* Sums over the passes at one instant of the pass. The first value at that instant is subtracted
 * from all to avoid cancellation. */
struct place {
    int count;
    double first[VALUES], sum[VALUES], square[VALUES];
};

static void add_sample(struct place *p, const struct recording_sample *s) {
    double value[VALUES];
    values_of(s, value);
    if (!p->count++) memcpy(p->first, value, sizeof value);
    for (int v = 0; v < VALUES; v++) p->sum[v] += value[v] - p->first[v], p->square[v] += pow(value[v] - p->first[v], 2.0);
}

/* Finds the mean sample of an instant of the pass, and adds the samples' squared differences from
 * it to `square`. */
static void take_mean(const struct place *p, double square[VALUES], struct recording_sample *mean) {
    double value[VALUES];
    for (int v = 0; v < VALUES; v++) {
        value[v] = p->first[v] + p->sum[v] / p->count;
        square[v] += fmax(p->square[v] - p->sum[v] * p->sum[v] / p->count, 0.0);
    }
    set_values(mean, value);
}

static void tabulate(struct multisine_mean *mean) {
    const struct multisine *m = mean->multisine;
    for (int i = 0; i < m->tones; i++) {
        long harmonic = lround(m->tone[i].hz * m->period_s);
        for (int n = 0; n < m->samples; n++) {
            double phase = 2.0 * PI * (double)(harmonic * n % m->samples) / m->samples;
            mean->wave[(size_t)i * (size_t)m->samples + (size_t)n] = CMPLX(2.0 / m->samples * cos(phase), -2.0 / m->samples * sin(phase));
        }
    }
}

int multisine_average(struct multisine_mean *mean, const struct multisine *m, const struct recording_test *test, double begin_s,
                      struct error *error) {
    size_t samples = (size_t)m->samples;
    struct place *place = calloc(samples, sizeof *place);
    double square[VALUES] = {0};
    int taken = 0, free_values = 0;
    *mean = (struct multisine_mean){
        .multisine = m, .sample = calloc(samples, sizeof *mean->sample), .wave = malloc((size_t)m->tones * samples * sizeof *mean->wave)};
    int status = place && mean->sample && mean->wave ? STATUS_OK : error_set(error, STATUS_IO, "out of memory");
    for (int i = 0; i < test->count && !status; i++) {
        long n = lround((test->sample[i].test_time_s - begin_s) / m->step_s);
        if (n >= m->samples && n < MULTISINE_PASSES * m->samples && !test->sample[i].refused)
            add_sample(&place[n % m->samples], &test->sample[i]);
    }
    for (int n = 0; n < m->samples && !status; n++) {
        if (!place[n].count)
            status = error_set(error, STATUS_USAGE,
                               "survey: samples are missing at %.3f s of every pass: lost, flagged or cut "
                               "off; run it again",
                               n * m->step_s);
        else take_mean(&place[n], square, &mean->sample[n]);
        mean->sample[n].test_time_s = n * m->step_s;
        taken += place[n].count, free_values += place[n].count - 1;
    }
    for (int k = 0; k < LEGS && !status; k++) {
        mean->noise_m[k] = free_values > 0 ? sqrt(square[k] / free_values) : (double)NAN;
        for (int c = 0; c < 2; c++) mean->noise_pa[c][k] = free_values > 0 ? sqrt(square[(1 + c) * LEGS + k] / free_values) : (double)NAN;
    }
    mean->passes = taken / m->samples;
    if (!status) tabulate(mean);
    free(place);
    return status;
}

void multisine_free(struct multisine_mean *mean) {
    free(mean->sample);
    free(mean->wave);
    *mean = (struct multisine_mean){0};
}

double complex multisine_amplitude(const struct multisine_mean *mean, int tone, const double *value) {
    const struct multisine *m = mean->multisine;
    const double complex *wave = mean->wave + (size_t)tone * (size_t)m->samples;
    double re = 0.0, im = 0.0;
    for (int n = 0; n < m->samples; n++) re += creal(wave[n]) * value[n], im += cimag(wave[n]) * value[n];
    return CMPLX(re, im);
}
