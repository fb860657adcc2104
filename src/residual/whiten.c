#include "whiten.h"

#include <complex.h>
#include <math.h>
#include <string.h>

#include "cylinder.h"
#include "numeric.h"
#include "params.h"
#include "units.h"

/* Factor on the model error of mean pressures. The mean cycle lacks the commands' noise, but a real
 * spool that crosses zero rectifies this noise. */
static const double STATIC_ERROR = 3.0;
static const double UNSTEADY = 10.0; /* the state is unsteady if a mean pressure changes from cycle
                                      * to cycle by more than this times its noise */
static const double FORCE_SENSOR_ERROR = 5e-3; /* error of a force sensor, as a share of its
                                                * variation: accuracy class 0.5; the motor constant
                                                * of a drive is known no better */

enum { INSTANTS = 16 };                /* instants of a period at which chambers are linearised */
static const double STEP_PA = 1e3, STEP_MPS = 1e-4; /* steps of the difference quotients */

/* Replaces the lower triangle of the covariance C by the inverse of its Cholesky factor. */
static void invert3(double c[RESIDUALS][RESIDUALS]) {
    for (int j = 0; j < RESIDUALS; j++) {
        for (int k = 0; k < j; k++) c[j][j] -= square(c[j][k]);
        c[j][j] = sqrt(c[j][j]);
        for (int i = j + 1; i < RESIDUALS; i++) {
            for (int k = 0; k < j; k++) c[i][j] -= c[i][k] * c[j][k];
            c[i][j] /= c[j][j];
        }
    }
    for (int j = 0; j < RESIDUALS; j++) {
        c[j][j] = 1.0 / c[j][j];
        for (int i = j + 1; i < RESIDUALS; i++) {
            double sum = 0.0;
            for (int k = j; k < i; k++) sum -= c[i][k] * c[k][j];
            c[i][j] = sum / c[i][i];
        }
    }
}

/* A leg's chambers linearised about the measured motion, as a mean over the test's instants. */
struct chambers {
    double by_pressure[PORTS][PORTS]; /* change of each pressure's rate with each pressure, 1/s */
    double by_rate[PORTS];            /* change of each pressure's rate with the leg's rate, Pa/m */
};

/* Pressures and spool at an instant of the mean cycle. motion: set to the length and its rate. */
static struct cylinder_state at_instant(const struct residual_test *t, int leg, const double *basis, double bias, double motion[3]) {
    double pressure[PORTS][3], spool[3];
    const struct spectrum *s = &t->spectrum;
    spectrum_at(s->mean[CHANNEL_LENGTH][leg], t->harmonics, s->omega, basis, motion);
    spectrum_at(s->mean[CHANNEL_P1][leg], t->harmonics, s->omega, basis, pressure[PORT_A]);
    spectrum_at(s->mean[CHANNEL_P2][leg], t->harmonics, s->omega, basis, pressure[PORT_B]);
    spectrum_at(s->mean[CHANNEL_VALVE][leg], t->harmonics, s->omega, basis, spool);
    return (struct cylinder_state){.p1_pa = pressure[PORT_A][0], .p2_pa = pressure[PORT_B][0], .spool = spool[0] + bias};
}

/* Linearises a leg's chambers: oil, leakage, and flow through the valve's orifices. */
static struct chambers linearise(const struct residual_test *t, const struct cylinder_model *m, int leg) {
    struct mains mains = cylinder_mains(m);
    struct chambers mean = {0};
    for (int i = 0; i < INSTANTS; i++) {
        double motion[3];
        struct cylinder_state s = at_instant(t, leg, t->cycle + i * t->phases / INSTANTS * SPECTRUM_SIZE, m->leg[leg].valve_bias, motion);
        double opening = machine_opening(&m->machine, leg, s.spool);
        struct cylinder_state rate = cylinder_derivative(m, leg, &mains, &s, opening, motion[0], motion[1], s.spool), moved;
        for (int j = 0; j < PORTS; j++) {
            moved = s;
            *(j == PORT_A ? &moved.p1_pa : &moved.p2_pa) += STEP_PA;
            moved = cylinder_derivative(m, leg, &mains, &moved, opening, motion[0], motion[1], s.spool);
            mean.by_pressure[PORT_A][j] += (moved.p1_pa - rate.p1_pa) / STEP_PA / INSTANTS;
            mean.by_pressure[PORT_B][j] += (moved.p2_pa - rate.p2_pa) / STEP_PA / INSTANTS;
        }
        moved = cylinder_derivative(m, leg, &mains, &s, opening, motion[0], motion[1] + STEP_MPS, s.spool);
        mean.by_rate[PORT_A] += (moved.p1_pa - rate.p1_pa) / STEP_MPS / INSTANTS;
        mean.by_rate[PORT_B] += (moved.p2_pa - rate.p2_pa) / STEP_MPS / INSTANTS;
    }
    return mean;
}

/* Changes of the pressures' residuals, Pa/m, for an error of a leg's length at this frequency:
 * minus the changes of the simulated pressures. 0 at frequency 0. */
static void stiffness(const struct chambers *c, double rate_radps, double complex pa_per_m[PORTS]) {
    const double (*p)[PORTS] = c->by_pressure;
    double complex rate = CMPLX(0.0, rate_radps), one = rate - p[PORT_A][PORT_A], other = rate - p[PORT_B][PORT_B];
    double complex both = one * other - p[PORT_A][PORT_B] * p[PORT_B][PORT_A]; /* determinant */
    pa_per_m[PORT_A] = rate_radps > 0.0 ? -rate * (c->by_rate[PORT_A] * other + p[PORT_A][PORT_B] * c->by_rate[PORT_B]) / both : 0.0;
    pa_per_m[PORT_B] = rate_radps > 0.0 ? -rate * (c->by_rate[PORT_B] * one + p[PORT_B][PORT_A] * c->by_rate[PORT_A]) / both : 0.0;
}

/* Index of the other coefficient of a harmonic: the cosine's for the sine's, and the reverse.
 * Returns a itself for a constant and for the coefficients of a segment, which have no other. */
static int quadrature(const struct residual_test *t, int a) { return !t->spectrum.cycles || !a ? a : a % 2 ? a + 1 : a - 1; }

/* Variance of the cycles' mean pressures about their drift, less the largest variance that still
 * counts as noise (UNSTEADY); 0 if the variance is smaller than that. A chamber whose valve stays
 * shut keeps its oil for seconds, and no steady state determines how much that is. */
static double wander(const struct spectrum *s, enum channel channel, int leg, int samples) {
    return fmax(square(s->std[channel][leg][0]) * s->cycles - square(UNSTEADY * s->noise[channel][leg]) / samples, 0.0);
}

void whitener_init(struct whitener *w, const struct residual_test *t, const struct params *model, double model_error) {
    const struct spectrum *s = &t->spectrum;
    struct cylinder_model cylinder;
    double lambda[LEGS][LEGS];
    cylinder_model_init(&cylinder, model);
    memset(w, 0, sizeof *w);
    w->values = t->legs * (t->chambers ? RESIDUALS : 1) * t->size;
    params_mechanism(model)->leg_mass(model, lambda);
    for (int k = 0; k < t->legs; k++) {
        const struct cylinder_leg *leg = &cylinder.leg[k];
        struct chambers chambers = {0};
        if (t->chambers) chambers = linearise(t, &cylinder, k);
        double a1 = leg->a1_m2, a2 = leg->a2_m2;
        double p1 = sqrt(residual_variation(t, CHANNEL_P1, k)), p2 = sqrt(residual_variation(t, CHANNEL_P2, k));
        double force = sqrt(residual_variation(t, CHANNEL_FORCE, k));
        for (int a = 0; a < t->size; a++) {
            double rate = t->rate[a], var[3], others = 0.0, (*c)[RESIDUALS] = w->inverse[k][a];
            for (int j = 0; j < t->legs; j++)
                if (j != k) others += square(lambda[k][j] * t->curve[a]) * square(t->std[CHANNEL_LENGTH][j][a]);
            var[0] = square(t->std[CHANNEL_P1][k][a]);
            var[1] = square(t->std[CHANNEL_P2][k][a]);
            var[2] = square(t->std[CHANNEL_LENGTH][k][a]);
            double length_var = square(t->std[CHANNEL_LENGTH][k][quadrature(t, a)]);
            double complex pa_per_m[PORTS] = {0.0};
            if (t->chambers) stiffness(&chambers, rate, pa_per_m);
            double complex from[RESIDUALS][3] = {{a1, -a2, lambda[k][k] * t->curve[a]}, {1.0, 0.0, pa_per_m[0]}, {0.0, 1.0, pa_per_m[1]}};
            double unsteady[RESIDUALS] = {0.0}, unsure = s->cycles ? a ? 1.0 : STATIC_ERROR : fmax(STATIC_ERROR / (2 * a + 1), 1.0);
            if (a == 0)
                unsteady[RESIDUAL_P1] = wander(s, CHANNEL_P1, k, t->measured),
                unsteady[RESIDUAL_P2] = wander(s, CHANNEL_P2, k, t->measured);
            double whole[RESIDUALS] = {hypot(a1 * p1, a2 * p2), p1, p2};
            if (!t->pressures) {
                whole[RESIDUAL_FORCE] = force * FORCE_SENSOR_ERROR / model_error;
                others += square(t->std[CHANNEL_FORCE][k][a]);
            }
            /* Sine and cosine of a harmonic are whitened separately: an error of length in
             * quadrature counts, but the covariance of the two is left out. */
            for (int i = 0; i < RESIDUALS; i++) {
                for (int j = 0; j <= i; j++) {
                    double sure = model_error * (i != RESIDUAL_FORCE ? unsure : 1.0);
                    double noise = i == j ? unsteady[i] + (i == 0 ? others : 0.0) : 0.0;
                    for (int n = 0; n < 3; n++) noise += creal(from[i][n]) * creal(from[j][n]) * var[n];
                    noise += cimag(from[i][2]) * cimag(from[j][2]) * length_var;
                    c[i][j] = noise + (i == j ? square(sure * whole[i]) + 1e-12 * square(whole[i]) : 0.0);
                    if (i == j) w->noise[k][a][i] = noise;
                }
            }
            if (t->chambers) invert3(c);
            else memset(c[1], 0, (RESIDUALS - 1) * sizeof c[1]), c[0][0] = 1.0 / sqrt(c[0][0]);
        }
    }
}

void whiten_force_std(const struct residual_test *t, const struct params *model, double std_n[LEGS]) {
    struct whitener w;
    whitener_init(&w, t, model, 1.0); /* any model_error serves, because w.noise excludes it */
    for (int k = 0; k < LEGS; k++) {
        double variance = 0.0;
        for (int a = 0; a < t->size; a++) variance += t->weight[a] * w.noise[k][a][RESIDUAL_FORCE];
        std_n[k] = sqrt(variance);
    }
}

/* Mean square deviation of a sinusoid of random phase from a chord that spans `radians` of it,
 * divided by the sinusoid's mean square and by radians^4. */
static double off_line(double radians) {
    if (radians < 0.3) return 1.0 / 120.0;
    double c = cos(radians);
    return (5.0 / 3.0 + c / 3.0 - 4.0 * (1.0 - c) / square(radians)) / pow(radians, 4.0);
}

void whiten_play_noise(const struct residual_test *t, const struct params *model, struct play_noise *noise) {
    struct cylinder_model cylinder;
    double step_s = 2.0 * PI / t->spectrum.omega / PHASES;
    cylinder_model_init(&cylinder, model);
    memset(noise, 0, sizeof *noise);
    for (int a = 0; a < t->size; a++) {
        double push[LEGS], length[LEGS];
        for (int k = 0; k < t->legs; k++) {
            double a1 = cylinder.leg[k].a1_m2, a2 = cylinder.leg[k].a2_m2;
            push[k] = square(a1 * t->std[CHANNEL_P1][k][a]) + square(a2 * t->std[CHANNEL_P2][k][a]);
            if (!t->pressures) push[k] = square(t->std[CHANNEL_FORCE][k][a]);
            length[k] = pow(t->rate[a], 4.0) * square(t->std[CHANNEL_LENGTH][k][a]);
        }
        for (int steps = 1; steps <= PHASES; steps++) {
            double span_s = steps * step_s, twice_s4 = t->weight[a] * off_line(t->rate[a] * span_s) * pow(span_s, 4.0);
            for (int k = 0; k < t->legs; k++) {
                noise->push_n2s4[steps][k] += twice_s4 * push[k];
                noise->length_m2[steps][k] += twice_s4 * length[k];
            }
        }
    }
}

void whiten(const struct whitener *w, residual_row row) {
    for (int k = 0; k < LEGS; k++)
        for (int a = 0; a < RESIDUAL_SIZE; a++) {
            const double (*c)[RESIDUALS] = w->inverse[k][a];
            for (int i = RESIDUALS - 1; i >= 0; i--) {
                double sum = 0.0;
                for (int j = 0; j <= i; j++) sum += c[i][j] * row[k][j][a];
                row[k][i][a] = sum;
            }
        }
}
