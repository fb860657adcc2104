#include "friction_course.h"

#include <math.h>
#include <string.h>

#include "numeric.h"
#include "units.h"
#include "whiten.h"

enum { STRIBECKS = 6, SEALS = 5, SLOW = 2 };
enum { STRIBECK = 0, LOAD = STRIBECK + STRIBECKS, SLOW_SEAL = LOAD + 1, SEAL = SLOW_SEAL + SLOW * SEALS };
_Static_assert(SEAL + SEALS == (int)BASIS_SIZE, "every basis function is an unknown");

/* Speeds of the Stribeck functions. They are spaced so that a least squares fit of these functions,
 * a constant and v reproduces exp(-(v / s)^2) for any s between two of them to 2e-3, over a
 * sinusoid of 0.1 m/s. */
static const double LOW_MPS[STRIBECKS] = {0.005, 0.008, 0.0125, 0.02, 0.032, 0.05};
/* Presliding lengths. They are spaced so that their functions reproduce the function of any length
 * between two of them to 1e-3. */
static const double GIVE_M[SEALS] = {20e-6, 40e-6, 80e-6, 160e-6, 320e-6};
static const double SLOW_MPS[SLOW] = {0.0125, 0.032}; /* speeds of the functions by which presliding
                                                       * is multiplied */
static const double RESOLVED = 0.125; /* time that the series cannot resolve, in periods of its
                                       * highest harmonic */
static const double NO_DOUBT = 1e-9, TINY = 1e-300;

/* leg: position, rate and acceleration of each leg at each phase. variance: noise variance of each
 * leg's rate. */
struct motion {
    double leg[PHASES][LEGS][3], variance[LEGS];
    /* Rate at which the legs reverse: rms acceleration / rms speed, all legs together. */
    double turns_radps;
};

/* Finds the share of each harmonic of each leg's length that is motion, not noise (Wiener). The
 * mean square of the motion is a mean over all legs, and is not allowed to be less than that of any
 * higher harmonic. */
static void find_kept(const struct residual_test *t, double noise[LEGS][SPECTRUM_SIZE], double kept[LEGS][SPECTRUM_SIZE]) {
    const struct spectrum *s = &t->spectrum;
    double motion = 0.0;
    for (int h = s->harmonics; h > 0; h--) {
        double sum = 0.0;
        for (int k = 0; k < LEGS; k++)
            for (int a = 2 * h - 1; a <= 2 * h; a++) sum += square(s->mean[CHANNEL_LENGTH][k][a]) - noise[k][a];
        motion = fmax(motion, sum / (2 * LEGS));
        for (int k = 0; k < LEGS; k++)
            for (int a = 2 * h - 1; a <= 2 * h; a++) kept[k][a] = noise[k][a] > 0.0 ? motion / (motion + noise[k][a]) : 1.0;
    }
}

static void find_motion(struct motion *m, const struct residual_test *t) {
    const struct spectrum *s = &t->spectrum;
    double noise[LEGS][SPECTRUM_SIZE] = {{0}}, kept[LEGS][SPECTRUM_SIZE], row[SPECTRUM_SIZE];
    for (int k = 0; k < LEGS; k++)
        for (int a = 1; a < 1 + 2 * s->harmonics; a++)
            noise[k][a] = square(s->in_step[CHANNEL_LENGTH][k][a]) + square(s->std[CHANNEL_LENGTH][k][a]);
    find_kept(t, noise, kept);
    double rates = 0.0, accelerations = 0.0;
    for (int k = 0; k < LEGS; k++) {
        bool segment = s->cycles == 0; /* Wiener's shares are for independent coefficients; a
                                        * segment's are not independent */
        memcpy(row, s->mean[CHANNEL_LENGTH][k], sizeof row);
        m->variance[k] = segment ? square(s->speed_gain * s->noise[CHANNEL_LENGTH][k]) : 0.0;
        for (int a = 1; a < 1 + 2 * s->harmonics && !segment; a++) {
            row[a] *= kept[k][a];
            m->variance[k] += 0.5 * square((a + 1) / 2 * s->omega) * kept[k][a] * noise[k][a];
        }
        for (int i = 0; i < t->phases; i++) spectrum_at(row, s->harmonics, s->omega, t->cycle + i * SPECTRUM_SIZE, m->leg[i][k]);
        for (int i = 0; i < t->phases; i++) rates += square(m->leg[i][k][1]), accelerations += square(m->leg[i][k][2]);
    }
    m->turns_radps = rates > 0.0 ? sqrt(accelerations / rates) : 0.0;
}

static void find_direction(struct friction_course *c, const struct residual_test *t, const struct motion *m, int leg) {
    double resolution_s = RESOLVED * 2.0 * PI / (t->spectrum.omega * t->spectrum.harmonics),
           step_s = 2.0 * PI / (t->spectrum.omega * PHASES);
    double place[PHASES], at = 0.0;
    for (int i = 0; i < t->phases; i++) {
        double most_mps = resolution_s * m->leg[i][leg][2], lag_mps = t->spectrum.cycles ? 0.5 * most_mps : 0.0;
        double rate = m->leg[i][leg][1] + lag_mps;
        /* Variance of the sum of two errors, one uniform in +-(most - lag), the other in +-SLOW. */
        double uniform = (square(most_mps - lag_mps) + square(INVERSE_DYNAMICS_SLOW_MPS)) / 3.0;
        /* Twice the probability that the leg moves in the other direction. */
        double other = erfc(fabs(rate) / sqrt(2.0 * (m->variance[leg] + uniform)));
        c->rate_mps[i][leg] = m->leg[i][leg][1];
        c->direction[i][leg] = copysign(1.0 - other, rate);
        c->doubt[i][leg] = other * (2.0 - other);
        place[i] = copysign(0.5 * log((2.0 - other) / fmax(other, TINY)), rate);
    }
    for (int i = 0; i < t->phases; i++) {
        c->lasting[i][leg] = at;
        at += fabs(place[(i + 1) % t->phases] - place[i]) + m->turns_radps * step_s;
    }
    c->round[leg] = t->spectrum.cycles ? at : (double)INFINITY;
}

/* Integrates Dahl's law, dz = (direction - z) |dx| / give, over each step of the motion. z:
 * friction as a share of the sliding friction, -1..1. A cycle starts from its periodic state, a
 * segment from the state of a sliding leg. */
static void find_seal(const struct residual_test *t, const struct motion *m, int leg, double give_m, double z[PHASES]) {
    int n = t->phases;
    bool cycle = t->spectrum.cycles > 0;
    double toward[PHASES], step[PHASES], left = 1.0, gained = 0.0;
    for (int i = 0; i < n; i++) {
        double dx = cycle || i > 0 ? m->leg[i][leg][0] - m->leg[(i + n - 1) % n][leg][0] : 0.0;
        toward[i] = (dx > 0.0) - (dx < 0.0), step[i] = -expm1(-fabs(dx) / give_m);
        left *= 1.0 - step[i], gained += (toward[i] - gained) * step[i];
    }
    double rate = m->leg[0][leg][1], state = (rate > 0.0) - (rate < 0.0);
    if (cycle) state = left < 1.0 ? gained / (1.0 - left) : 0.0;
    for (int i = 0; i < n; i++) z[i] = state += (toward[i] - state) * step[i];
}

/* Fills the basis functions of a leg's dry friction: higher at low speed (Stribeck); proportional
 * to the pressures; and presliding, the transition from one direction to the other while the seal
 * deforms. Presliding is fitted alone and times functions of speed, because the two effects
 * multiply if the bristles of the LuGre model carry more force at low speed, or are damped. */
static void find_basis(struct friction_course *c, const struct residual_test *t, double load_pa, const struct motion *m, int leg) {
    const struct spectrum *s = &t->spectrum;
    const double *row1 = s->mean[CHANNEL_P1][leg], *row2 = s->mean[CHANNEL_P2][leg];
    double z[SEALS][PHASES], p1[3], p2[3];
    for (int j = 0; j < SEALS; j++) find_seal(t, m, leg, GIVE_M[j], z[j]);
    for (int i = 0; i < t->phases; i++) {
        const double *basis = t->cycle + i * SPECTRUM_SIZE;
        double direction = c->direction[i][leg], rate = c->rate_mps[i][leg];
        spectrum_at(row1, s->harmonics, s->omega, basis, p1);
        spectrum_at(row2, s->harmonics, s->omega, basis, p2);
        for (int j = 0; j < STRIBECKS; j++) c->basis[STRIBECK + j][i][leg] = direction * exp(-square(rate / LOW_MPS[j]));
        c->basis[LOAD][i][leg] = load_pa > 0.0 ? direction * ((p1[0] + p2[0]) / load_pa - 1.0) : 0.0;
        for (int j = 0; j < SEALS; j++) {
            c->basis[SEAL + j][i][leg] = z[j][i] - direction;
            for (int n = 0; n < SLOW; n++)
                c->basis[SLOW_SEAL + n * SEALS + j][i][leg] = (z[j][i] - direction) * exp(-square(rate / SLOW_MPS[n]));
        }
    }
}

double friction_course_load(const struct residual_data *d) {
    double sum_pa = 0.0, count = 0.0;
    for (int i = 0; i < d->tests; i++)
        for (int k = 0; k < LEGS && d->test[i].pressures; k++, count++)
            sum_pa += d->test[i].spectrum.mean[CHANNEL_P1][k][0] + d->test[i].spectrum.mean[CHANNEL_P2][k][0];
    return count > 0.0 ? sum_pa / count : 0.0;
}

void friction_course_find(struct friction_course *c, const struct residual_test *t, double load_pa) {
    struct motion m;
    find_motion(&m, t);
    for (int k = 0; k < LEGS; k++) {
        find_direction(c, t, &m, k);
        find_basis(c, t, load_pa, &m, k);
    }
}

void friction_course_covariance(const struct friction_course *c, const struct residual_test *t, int leg,
                                double covariance[RESIDUAL_SIZE][RESIDUAL_SIZE]) {
    memset(covariance, 0, RESIDUAL_SIZE * sizeof covariance[0]);
    for (int i = 0; i < t->phases; i++) {
        /* covariance of each coefficient of the row with the error at phase i */
        double alike[RESIDUAL_SIZE] = {0};
        if (c->doubt[i][leg] < NO_DOUBT) continue;
        for (int j = 0; j < t->phases; j++) {
            double apart = fabs(c->lasting[i][leg] - c->lasting[j][leg]);
            if (c->doubt[j][leg] < NO_DOUBT) continue;
            double both = sqrt(c->doubt[i][leg] * c->doubt[j][leg]) * exp(-fmin(apart, c->round[leg] - apart));
            for (int a = 0; a < t->size; a++) alike[a] += both * t->project[j][a];
        }
        for (int a = 0; a < t->size; a++)
            for (int b = 0; b < t->size; b++) covariance[a][b] += t->project[i][a] * alike[b];
    }
}
