#include "oil_columns.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "force.h"
#include "kinematics.h"
#include "lin.h"
#include "numeric.h"
#include "params.h"
#include "units.h"

enum { PUSH, GAIN, OWN, OTHER, NULL_BIAS, UNKNOWNS };
enum { PASSES = 3, DELAYS = 24, REFINEMENTS = 16, REFITS = 4 };
/* Step of the delays that are tried. 24 steps are 12 ms: a valve of 20 Hz, or three cycles of 2 ms
 * on a bus. */
static const double DELAY_STEP_S = 0.5e-3;
static const double FLOW_ERROR = 0.02;     /* largest error of the square-root law, as a share of
                                            * the piston's flow */
static const double NULL_STD = 0.02;       /* prior of a valve's null, as a share of full opening;
                                            * data sheets allow 2 to 3 % */
static const double STIFFNESS_STD_MOST = 0.05, MISFIT_MOST = 2.0, NULL_MOST = 0.04;
static const double GOLDEN = 0.61803398874989485;

/* Data of one leg: amplitudes of its tones, and series over one pass. */
struct leg_data {
    const struct multisine_mean *mean;
    const struct params *params;
    int leg;
    double complex length[MULTISINE_TONES], pressure[2][MULTISINE_TONES];
    double *flow;           /* [samples]: flow into the chamber; also scratch for other series */
    double *opening;        /* [samples]: delayed command */
    /* Null (opening without a command) and error of the square-root law of each chamber, as found
     * so far. */
    double null_bias[2], flow_error[2];
};

static double root(double drop_pa) { return sqrt(fmax(drop_pa, 0.0)); }

typedef double flow_law(const struct hydraulics_params *h, int chamber, double opening, double pressure_pa);

/* Flow q into a chamber (oil_columns.h), by the square-root law. */
static double flow_of(const struct hydraulics_params *h, int chamber, double opening, double pressure_pa) {
    double filling = root(h->supply_pa - pressure_pa), emptying = root(pressure_pa - h->tank_pa);
    double extends = fmax(opening, 0.0), retracts = fmin(opening, 0.0);
    return chamber ? -extends * emptying - retracts * filling : extends * filling + retracts * emptying;
}

/* Derivative of flow_of() by the opening. */
static double slope_of(const struct hydraulics_params *h, int chamber, double opening, double pressure_pa) {
    double filling = root(h->supply_pa - pressure_pa), emptying = root(pressure_pa - h->tank_pa);
    return chamber ? -(opening > 0.0 ? emptying : filling) : opening > 0.0 ? filling : emptying;
}

static double pressure_of(const struct recording_sample *s, int chamber, int leg) { return chamber ? s->p2_pa[leg] : s->p1_pa[leg]; }

static void delay_command(struct leg_data *d, double delay_s) {
    int n = d->mean->multisine->samples;
    double ago = delay_s / d->mean->multisine->step_s, part = ago - floor(ago);
    for (int i = 0; i < n; i++) {
        int later = (i - (int)floor(ago) + n) % n, earlier = (later - 1 + n) % n;
        d->opening[i] = (1.0 - part) * d->mean->sample[later].valve[d->leg] + part * d->mean->sample[earlier].valve[d->leg];
    }
}

/* Standard deviation of either component of an amplitude. Noise is reduced by the mean over the
 * passes; rounding is not, because it may be the same in all passes. */
static double amplitude_std(const struct multisine_mean *mean, double noise, double step) {
    return hypot(noise / sqrt(mean->passes), step / sqrt(12.0)) * sqrt(2.0 / mean->multisine->samples);
}

/* Standard deviation of a tone's equation, Pa/s: noise of both sensors, and error of the
 * square-root law. */
static double row_std(const struct leg_data *d, int chamber, int tone, double push, double complex rate) {
    const struct sensor_params *s = &d->params->sensors;
    double w = 2.0 * PI * d->mean->multisine->tone[tone].hz, step_m = s->enabled ? s->position_resolution_m : 0.0;
    double pressure = w * amplitude_std(d->mean, d->mean->noise_pa[chamber][d->leg], 0.0);
    double piston = w * push * amplitude_std(d->mean, d->mean->noise_m[d->leg], step_m);
    return hypot(hypot(pressure, piston), d->flow_error[chamber] * push * cabs(rate));
}

/* Fills a chamber's equation at a tone, as complex numbers: coefficients of the unknowns, then the
 * right-hand side. The unknown NULL_BIAS is the correction of the null times the gain. */
static void fill_row(const struct leg_data *d, int chamber, int tone, double complex flow, double complex slope,
                     double complex row[UNKNOWNS + 1]) {
    double complex jw = CMPLX(0.0, 2.0 * PI * d->mean->multisine->tone[tone].hz), rate = jw * d->length[tone];
    row[PUSH] = chamber ? rate : -rate;
    row[GAIN] = flow;
    row[NULL_BIAS] = slope;
    row[OWN] = -d->pressure[chamber][tone];
    row[OTHER] = d->pressure[!chamber][tone];
    row[UNKNOWNS] = jw * d->pressure[chamber][tone];
}

struct fit {
    /* squares: weighted sum of squared residuals. scatter: rms residual as a multiple of the rms
     * that the weights predict. covariance: scaled by scatter^2 */
    double value[UNKNOWNS], covariance[UNKNOWNS][UNKNOWNS], squares, scatter;
};

/* Standard deviation of the quotient of two unknowns. */
static double quotient_std(const struct fit *f, int over, int under) {
    double q = f->value[over] / f->value[under];
    double variance = f->covariance[over][over] - 2.0 * q * f->covariance[over][under] + q * q * f->covariance[under][under];
    return sqrt(fmax(variance, 0.0)) / fabs(f->value[under]);
}

/* Solves the least squares. Columns are first scaled to unit length, because their units differ
 * widely. */
static bool solve(int rows, double a[][UNKNOWNS + 1], struct fit *fit) {
    double size[UNKNOWNS] = {0}, product[UNKNOWNS][UNKNOWNS] = {{0}}, x[UNKNOWNS] = {0};
    for (int c = 0; c < UNKNOWNS; c++) {
        for (int r = 0; r < rows; r++) size[c] += a[r][c] * a[r][c];
        size[c] = sqrt(size[c]);
    }
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < UNKNOWNS; c++) {
            x[c] += a[r][c] / size[c] * a[r][UNKNOWNS];
            for (int e = 0; e < UNKNOWNS; e++) product[c][e] += a[r][c] / size[c] * a[r][e] / size[e];
        }
    if (!dense_factor(UNKNOWNS, UNKNOWNS, product[0])) return false;
    dense_solve(UNKNOWNS, UNKNOWNS, product[0], x);
    fit->squares = 0.0;
    for (int r = 0; r < rows; r++) {
        double rest = a[r][UNKNOWNS];
        for (int c = 0; c < UNKNOWNS; c++) rest -= a[r][c] / size[c] * x[c];
        fit->squares += rest * rest;
    }
    fit->scatter = sqrt(fit->squares / (rows - UNKNOWNS));
    for (int c = 0; c < UNKNOWNS; c++) {
        double unit[UNKNOWNS] = {0};
        unit[c] = 1.0;
        dense_solve(UNKNOWNS, UNKNOWNS, product[0], unit);
        for (int e = 0; e < UNKNOWNS; e++) fit->covariance[e][c] = unit[e] / (size[e] * size[c]) * square(fit->scatter);
        fit->value[c] = x[c] / size[c];
    }
    return isfinite(fit->squares);
}

/* Amplitudes of a flow into the chamber, by flow_of() or slope_of(). */
static void find_flow(struct leg_data *d, int chamber, flow_law *law, double complex flow[MULTISINE_TONES]) {
    const struct multisine *m = d->mean->multisine;
    for (int i = 0; i < m->samples; i++)
        d->flow[i] = law(&d->params->hydraulics, chamber, d->opening[i] + d->null_bias[chamber],
                         pressure_of(&d->mean->sample[i], chamber, d->leg));
    for (int i = 0; i < m->tones; i++) flow[i] = multisine_amplitude(d->mean, i, d->flow);
}

/* Fits a chamber. The first pass has no null, because the prior needs the gain. solve() scales all
 * standard deviations by the scatter; the prior's row is multiplied by the scatter, so that the
 * prior's standard deviation stays as stated. */
static bool fit_chamber(struct leg_data *d, int chamber, struct fit *fit) {
    int tones = d->mean->multisine->tones;
    double rows[2 * MULTISINE_TONES + 1][UNKNOWNS + 1];
    double complex row[UNKNOWNS + 1], flow[MULTISINE_TONES], slope[MULTISINE_TONES];
    find_flow(d, chamber, flow_of, flow), find_flow(d, chamber, slope_of, slope);
    *fit = (struct fit){0};
    for (int pass = 0; pass < PASSES; pass++) {
        double *prior = rows[2 * tones];
        for (int i = 0; i < tones; i++) {
            fill_row(d, chamber, i, flow[i], pass ? slope[i] : 0.0, row);
            double std = row_std(d, chamber, i, fit->value[PUSH], row[PUSH]);
            for (int c = 0; c <= UNKNOWNS; c++) rows[2 * i][c] = creal(row[c]) / std, rows[2 * i + 1][c] = cimag(row[c]) / std;
        }
        memset(prior, 0, sizeof rows[0]);
        prior[NULL_BIAS] = pass ? fit->scatter / (NULL_STD * fit->value[GAIN]) : 1.0;
        prior[UNKNOWNS] = pass ? -d->null_bias[chamber] * fit->scatter / NULL_STD : 0.0;
        if (!solve(2 * tones + 1, rows, fit)) return false;
    }
    return true;
}

static double fit_delayed(struct leg_data *d, double delay_s, struct fit fit[2]) {
    delay_command(d, delay_s);
    return fit_chamber(d, 0, &fit[0]) && fit_chamber(d, 1, &fit[1]) ? fit[0].squares + fit[1].squares : HUGE_VAL;
}

/* Finds the delay that fits both chambers best together, because they share one spool. */
static double find_delay(struct leg_data *d, struct fit fit[2]) {
    double best_s = 0.0, least = HUGE_VAL;
    for (int i = 0; i <= DELAYS; i++) {
        double square = fit_delayed(d, i * DELAY_STEP_S, fit);
        if (square < least) least = square, best_s = i * DELAY_STEP_S;
    }
    double low = fmax(best_s - DELAY_STEP_S, 0.0), high = best_s + DELAY_STEP_S;
    for (int i = 0; i < REFINEMENTS; i++) {
        double left = high - GOLDEN * (high - low), right = low + GOLDEN * (high - low);
        if (fit_delayed(d, left, fit) < fit_delayed(d, right, fit)) high = right;
        else low = left;
    }
    fit_delayed(d, 0.5 * (low + high), fit);
    return isfinite(least) ? 0.5 * (low + high) : (double)NAN;
}

/* Fits a chamber again about the null found so far, because the law is not linear in the null. The
 * error of the square-root law is then estimated from the residuals. */
static void refit(struct leg_data *d, int chamber, struct fit *fit) {
    for (int i = 0; i < REFITS; i++) {
        d->null_bias[chamber] += fit->value[NULL_BIAS] / fit->value[GAIN];
        d->flow_error[chamber] = fmin(d->flow_error[chamber] * fit->scatter, FLOW_ERROR);
        if (fit_chamber(d, chamber, fit)) continue;
        *fit = (struct fit){0};
        return;
    }
}

/* Finds the slopes of a chamber's law at the mean command and pressures. */
static void linearise(const struct leg_data *d, int chamber, struct oil_chamber *c) {
    const struct hydraulics_params *h = &d->params->hydraulics;
    double opening = 0.0, pressure_pa = 0.0, step = 1e-3, step_pa = 1e3;
    int n = d->mean->multisine->samples;
    for (int i = 0; i < n; i++) {
        opening += d->mean->sample[i].valve[d->leg] / n;
        pressure_pa += pressure_of(&d->mean->sample[i], chamber, d->leg) / n;
    }
    opening += d->null_bias[chamber];
    c->open = c->gain * (flow_of(h, chamber, opening + step, pressure_pa) - flow_of(h, chamber, opening - step, pressure_pa)) /
              (2.0 * step);
    c->sag = c->own - c->gain *
                          (flow_of(h, chamber, opening, pressure_pa + step_pa) - flow_of(h, chamber, opening, pressure_pa - step_pa)) /
                          (2.0 * step_pa);
}

/* Finds the oil of one leg. The stiffness's deviation is the sum of both chambers' deviations:
 * their errors are correlated, because the chambers share length and delay. */
static void find_leg(struct leg_data *d, struct fit fit[2], struct oil_leg *leg) {
    struct cylinder_areas area = cylinder_areas(&d->params->actuator);
    double a1 = area.a1_m2[d->leg], a2 = area.a2_m2[d->leg];
    const struct multisine_mean *mean = d->mean;
    int tones = mean->multisine->tones;
    memset(fit, 0, 2 * sizeof *fit);
    for (int i = 0; i < mean->multisine->samples; i++) d->flow[i] = mean->sample[i].length_m[d->leg];
    for (int i = 0; i < tones; i++) d->length[i] = multisine_amplitude(mean, i, d->flow);
    for (int c = 0; c < 2; c++) {
        for (int i = 0; i < mean->multisine->samples; i++) d->flow[i] = pressure_of(&mean->sample[i], c, d->leg);
        for (int i = 0; i < tones; i++) d->pressure[c][i] = multisine_amplitude(mean, i, d->flow);
    }
    leg->delay_s = find_delay(d, fit);
    leg->misfit = sqrt((fit[0].squares + fit[1].squares) / (2.0 * (2 * tones + 1 - UNKNOWNS)));
    for (int c = 0; c < 2; c++) refit(d, c, &fit[c]);
    for (int c = 0; c < 2; c++) {
        struct oil_chamber *o = &leg->chamber[c];
        *o = (struct oil_chamber){.push = fit[c].value[PUSH],
                                  .push_std = sqrt(fit[c].covariance[PUSH][PUSH]),
                                  .gain = fit[c].value[GAIN],
                                  .flow_std = quotient_std(&fit[c], GAIN, PUSH) * fabs(fit[c].value[PUSH] / fit[c].value[GAIN]),
                                  .own = fit[c].value[OWN],
                                  .other = fit[c].value[OTHER]};
        linearise(d, c, o);
    }
    leg->stiffness = a1 * leg->chamber[0].push + a2 * leg->chamber[1].push;
    leg->stiffness_std = a1 * leg->chamber[0].push_std + a2 * leg->chamber[1].push_std;
    bool known = leg->stiffness_std < STIFFNESS_STD_MOST * leg->stiffness && leg->delay_s < DELAYS * DELAY_STEP_S &&
                 leg->misfit < MISFIT_MOST && fabs(d->null_bias[0]) < NULL_MOST && fabs(d->null_bias[1]) < NULL_MOST;
    if (!known) leg->stiffness = leg->stiffness_std = NAN;
}

/* Variance, about zero, of the leakage (a - b) A / c between a chamber and supply or tank (a
 * valve's lap, a seal); a tight valve has zero. The variance is the mean square of the estimates
 * over the legs, less the mean square of their errors (empirical Bayes), because valves and seals
 * of all legs are of one make. */
static double variance_of_lap(const struct cylinder_areas *area, struct fit fit[LEGS][2], const struct oil_leg leg[LEGS]) {
    double sum = 0.0;
    int chambers = 0;
    for (int k = 0; k < LEGS; k++)
        for (int c = 0; c < 2 && !isnan(leg[k].stiffness); c++) {
            const struct fit *f = &fit[k][c];
            double unit = (c ? area->a2_m2[k] : area->a1_m2[k]) / f->value[PUSH];
            double variance = f->covariance[OWN][OWN] - 2.0 * f->covariance[OWN][OTHER] + f->covariance[OTHER][OTHER];
            sum += square(unit) * (square(f->value[OWN] - f->value[OTHER]) - variance), chambers++;
        }
    return chambers ? fmax(sum / chambers, 0.0) : 0.0;
}

/* Corrects all values by the prior that OWN - OTHER is 0 with the variance `prior`. Then replaces
 * OWN by the mean of OWN and OTHER, the leakage that a difference of the pressures drives. */
static void join(struct fit *f, double prior) {
    double along[UNKNOWNS], apart = f->value[OWN] - f->value[OTHER];
    for (int i = 0; i < UNKNOWNS; i++) along[i] = f->covariance[i][OWN] - f->covariance[i][OTHER];
    double variance = along[OWN] - along[OTHER] + prior;
    for (int i = 0; i < UNKNOWNS; i++) {
        f->value[i] -= along[i] * apart / variance;
        for (int j = 0; j < UNKNOWNS; j++) f->covariance[i][j] -= along[i] * along[j] / variance;
    }
    f->value[OWN] = 0.5 * (f->value[OWN] + f->value[OTHER]);
    for (int i = 0; i < UNKNOWNS; i++) f->covariance[OWN][i] = 0.5 * (f->covariance[OWN][i] + f->covariance[OTHER][i]);
    for (int i = 0; i < UNKNOWNS; i++) f->covariance[i][OWN] = 0.5 * (f->covariance[i][OWN] + f->covariance[i][OTHER]);
}

/* Finds the leakage of each leg from both chambers, weighted by their precision. */
static void find_leakage(const struct cylinder_areas *area, struct fit fit[LEGS][2], struct oil_leg leg[LEGS]) {
    double lap = variance_of_lap(area, fit, leg);
    for (int k = 0; k < LEGS; k++) {
        double value[2], std[2];
        for (int c = 0; c < 2; c++) {
            double unit = c ? area->a2_m2[k] : area->a1_m2[k];
            join(&fit[k][c], lap * square(fit[k][c].value[PUSH] / unit));
            value[c] = unit * fit[k][c].value[OWN] / fit[k][c].value[PUSH], std[c] = unit * quotient_std(&fit[k][c], OWN, PUSH);
        }
        double first = square(std[1]) / (square(std[0]) + square(std[1]));
        bool known = !isnan(leg[k].stiffness);
        leg[k].leakage = known ? first * value[0] + (1.0 - first) * value[1] : (double)NAN;
        leg[k].leakage_std = known ? first * std[0] + (1.0 - first) * std[1] : (double)NAN;
    }
}

int oil_columns_find(const struct multisine_mean *mean, const struct params *params, struct oil_leg leg[LEGS], struct error *error) {
    struct leg_data *d = calloc(1, sizeof *d);
    size_t samples = (size_t)mean->multisine->samples;
    double *series = malloc(2 * samples * sizeof *series);
    struct fit fit[LEGS][2];
    int status = d && series ? STATUS_OK : error_set(error, STATUS_IO, "out of memory");
    for (int k = 0; k < LEGS && !status; k++) {
        *d = (struct leg_data){
            .mean = mean, .params = params, .leg = k, .flow = series, .opening = series + samples, .flow_error = {FLOW_ERROR, FLOW_ERROR}};
        find_leg(d, fit[k], &leg[k]);
    }
    struct cylinder_areas area = cylinder_areas(&params->actuator);
    if (!status) find_leakage(&area, fit, leg);
    free(series);
    free(d);
    return status;
}

/* Scales a mode so that its largest axis is 1, and finds the legs' motion in it. */
static void describe(struct oil_mode *mode, const struct kinematics *k, double j[LEGS][DOFS]) {
    double most = 0.0;
    for (int i = 0; i < DOFS; i++) {
        double size = fabs(mode->shape[i]) * (i < DOF_PHI ? 1.0 : k->arm_m);
        if (size > most) most = size, mode->dof = (enum dof)i;
    }
    double unit = mode->shape[mode->dof];
    for (int i = 0; i < DOFS; i++) mode->shape[i] /= unit;
    for (int leg = 0; leg < LEGS; leg++) {
        mode->motion[leg] = 0.0;
        for (int i = 0; i < DOFS; i++) mode->motion[leg] += j[leg][i] * mode->shape[i];
    }
}

/* Finds a mode's mass, its frequency, and the standard deviation of the frequency to first order.
 * The squared frequency is a quotient of two quadratic forms in the mode's shape, so the shape's
 * error has no effect in first order. */
static void measure(struct oil_mode *mode, const struct oil_leg leg[LEGS], double mt[DOFS][DOFS], double mt_std[DOFS][DOFS]) {
    double mass = 0.0, mass_variance = 0.0, spring = 0.0, spring_variance = 0.0, motion = 0.0;
    for (int i = 0; i < DOFS; i++)
        for (int c = 0; c <= i; c++) {
            double share = (c < i ? 2.0 : 1.0) * mode->shape[i] * mode->shape[c];
            mass += share * mt[i][c], mass_variance += pow(share * mt_std[i][c], 2.0);
        }
    for (int k = 0; k < LEGS; k++) {
        double square = mode->motion[k] * mode->motion[k];
        motion += square, spring += square * leg[k].stiffness, spring_variance += pow(square * leg[k].stiffness_std, 2.0);
    }
    mode->mass_kg = mass / motion;
    mode->hz = sqrt(spring / mass) / (2.0 * PI);
    mode->hz_std = 0.5 * mode->hz * hypot(sqrt(mass_variance) / mass, sqrt(spring_variance) / spring);
}

bool oil_columns_modes(const struct oil_leg leg[LEGS], const struct params *params, double mt[DOFS][DOFS], double mt_std[DOFS][DOFS],
                       struct oil_mode mode[DOFS]) {
    static const double neutral[DOFS] = {0};
    struct kinematics k;
    struct error ignored;
    double j[LEGS][DOFS], spring[DOFS][DOFS] = {{0}}, value[DOFS], shape[DOFS][DOFS];
    for (int i = 0; i < DOFS; i++) mode[i] = (struct oil_mode){.hz = (double)NAN, .hz_std = (double)NAN};
    if (kinematics_init(&k, params, &ignored)) return false;
    ik_jacobian(&k, neutral, j);
    for (int l = 0; l < LEGS; l++)
        for (int r = 0; r < DOFS; r++)
            for (int c = 0; c < DOFS; c++) spring[r][c] += leg[l].stiffness * j[l][r] * j[l][c];
    if (lin_eigenvectors(DOFS, spring[0], mt[0], value, shape[0])) return false;
    for (int i = 0; i < DOFS; i++) {
        memcpy(mode[i].shape, shape[i], sizeof shape[i]);
        describe(&mode[i], &k, j);
        measure(&mode[i], leg, mt, mt_std);
    }
    return true;
}
