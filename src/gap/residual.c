#include "residual.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cylinder.h"
#include "dense.h"
#include "inverse_dynamics.h"
#include "units.h"

static const double SETTLE_CYCLES = 2.0; /* the start, the measured pressures, is forgotten after: chambers settle in some 30 ms */
static const double SUBSTEP_S = 0.5e-3;   /* RK4: 1e-4 of a 100 Hz spool's lag */

/* Samples to coefficients, by least squares: exact also where a cycle is no whole number of samples. */
static bool project(struct residual_test *t) {
    int size = 1 + 2 * t->harmonics;
    double product[RESIDUAL_SIZE][RESIDUAL_SIZE] = {0}, basis[RESIDUAL_SIZE];
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < t->fitted; i++) {
            double t_s = t->first_s + (t->samples - t->fitted + i) * t->step_s;
            spectrum_basis(t->spectrum.omega * t_s, t->harmonics, basis);
            if (pass) dense_solve(size, RESIDUAL_SIZE, product[0], basis);
            for (int a = 0; a < size; a++) {
                if (pass) t->projection[a * t->fitted + i] = basis[a];
                else for (int b = 0; b <= a; b++) product[a][b] += basis[a] * basis[b];
            }
        }
        if (!pass && !dense_factor(size, RESIDUAL_SIZE, product[0])) return false;
    }
    return true;
}

static void tabulate(struct residual_test *t) {
    const struct spectrum *s = &t->spectrum;
    int nodes = 2 * t->substeps * t->samples + 1;
    double value[3];
    for (int k = 0; k < LEGS; k++) {
        for (int i = 0; i < nodes; i++) {
            double t_s = t->first_s + i * t->step_s / (2 * t->substeps);
            spectrum_value(s->mean[CHANNEL_LENGTH][k], t->harmonics, s->omega, t_s, value);
            memcpy(t->motion + 2 * ((size_t)k * (size_t)nodes + (size_t)i), value, 2 * sizeof *value);
        }
        for (int i = 0; i < t->samples; i++) {
            spectrum_value(s->mean[CHANNEL_VALVE][k], s->harmonics, s->omega, t->first_s + i * t->step_s, value);
            t->valve[k * t->samples + i] = value[0];
        }
        for (int i = 0; i < PHASES; i++) {
            spectrum_value(s->mean[CHANNEL_LENGTH][k], t->harmonics, s->omega, 2.0 * PI * i / PHASES / s->omega, value);
            memcpy(t->phase + 3 * (i * LEGS + k), value, sizeof value);
        }
    }
}

static int prepare(struct residual_test *t, const struct recording_test *test, enum cycles which, struct error *error) {
    if (!spectrum_measure(&t->spectrum, test, which))
        return error_set(error, STATUS_USAGE, "test %d: fewer than two whole cycles of %g Hz without a bad sample", test->test + 1,
                         test->frequency_hz);
    t->harmonics = t->spectrum.harmonics < RESIDUAL_HARMONICS ? t->spectrum.harmonics : RESIDUAL_HARMONICS;
    t->first_s = test->sample[test->first].test_time_s;
    t->step_s = (test->sample[test->end - 1].test_time_s - t->first_s) / (test->end - 1 - test->first);
    double cycle = 1.0 / test->frequency_hz / t->step_s;
    t->fitted = (int)ceil(cycle - 1e-6);
    t->samples = (int)ceil(SETTLE_CYCLES * cycle) + t->fitted;
    t->substeps = (int)ceil(t->step_s / SUBSTEP_S - 1e-6);
    size_t nodes = (size_t)(2 * t->substeps * t->samples + 1);
    t->motion = malloc(LEGS * nodes * 2 * sizeof(double));
    t->valve = malloc((size_t)(LEGS * t->samples) * sizeof(double));
    t->projection = malloc((size_t)(RESIDUAL_SIZE * t->fitted) * sizeof(double));
    t->phase = malloc(PHASES * LEGS * 3 * sizeof(double));
    if (!t->motion || !t->valve || !t->projection || !t->phase) return error_set(error, STATUS_IO, "out of memory");
    if (!project(t)) return error_set(error, STATUS_USAGE, "test %d: too few samples a cycle", test->test + 1);
    tabulate(t);
    return STATUS_OK;
}

int residual_prepare(struct residual_data *d, const struct recording *recording, enum cycles which, struct error *error) {
    *d = (struct residual_data){.test = calloc((size_t)recording->tests + 1, sizeof *d->test)};
    if (!d->test) return error_set(error, STATUS_IO, "out of memory");
    for (int i = 0; i < recording->tests; i++) {
        d->tests++;
        int status = prepare(&d->test[i], &recording->test[i], which, error);
        if (status) return status;
    }
    return STATUS_OK;
}

void residual_free(struct residual_data *d) {
    for (int i = 0; i < d->tests; i++) {
        free(d->test[i].motion);
        free(d->test[i].valve);
        free(d->test[i].projection);
        free(d->test[i].phase);
    }
    free(d->test);
    *d = (struct residual_data){0};
}

static struct cylinder_state along(const struct cylinder_state *s, double h, const struct cylinder_state *d) {
    return (struct cylinder_state){s->p1_pa + h * d->p1_pa, s->p2_pa + h * d->p2_pa, s->spool + h * d->spool,
                                   s->spool_rate + h * d->spool_rate};
}

/* One substep with the motion given at its start, middle and end. */
static void rk4(const struct cylinder_model *m, struct cylinder_state *s, const double *motion, double h, double valve) {
    struct cylinder_state d1 = cylinder_derivative(m, s, motion[0], motion[1], valve), at = along(s, 0.5 * h, &d1);
    struct cylinder_state d2 = cylinder_derivative(m, &at, motion[2], motion[3], valve);
    at = along(s, 0.5 * h, &d2);
    struct cylinder_state d3 = cylinder_derivative(m, &at, motion[2], motion[3], valve);
    at = along(s, h, &d3);
    struct cylinder_state d4 = cylinder_derivative(m, &at, motion[4], motion[5], valve);
    *s = along(s, h / 6.0, &d1);
    *s = along(s, h / 3.0, &d2);
    *s = along(s, h / 3.0, &d3);
    *s = along(s, h / 6.0, &d4);
    cylinder_limit(s);
}

static void pressures(const struct residual_test *t, const struct cylinder_model *m, int leg, double p[2][RESIDUAL_SIZE]) {
    const struct spectrum *s = &t->spectrum;
    const double *motion = t->motion + 2 * (size_t)leg * (size_t)(2 * t->substeps * t->samples + 1), *valve = t->valve + leg * t->samples;
    double h = t->step_s / t->substeps, p1[3], p2[3];
    spectrum_value(s->mean[CHANNEL_P1][leg], t->harmonics, s->omega, t->first_s, p1);
    spectrum_value(s->mean[CHANNEL_P2][leg], t->harmonics, s->omega, t->first_s, p2);
    struct cylinder_state state = {.p1_pa = p1[0], .p2_pa = p2[0], .spool = valve[0]};
    memset(p, 0, 2 * sizeof p[0]);
    for (int i = 0; i < t->samples; i++) {
        int place = i - (t->samples - t->fitted);
        for (int a = 0; place >= 0 && a < 1 + 2 * t->harmonics; a++) {
            double weight = t->projection[a * t->fitted + place];
            p[0][a] += weight * state.p1_pa;
            p[1][a] += weight * state.p2_pa;
        }
        for (int j = 0; j < t->substeps; j++, motion += 4) rk4(m, &state, motion, h, valve[i]);
    }
}

bool residual_required(const struct residual_test *t, const struct params *model, double force_n[LEGS][RESIDUAL_SIZE]) {
    struct inverse_dynamics inverse;
    double basis[RESIDUAL_SIZE], force[LEGS], p1_pa[LEGS], p2_pa[LEGS], value[3];
    const struct spectrum *s = &t->spectrum;
    inverse_dynamics_init(&inverse, model, 2.0 * PI / s->omega / PHASES);
    memset(force_n, 0, LEGS * sizeof force_n[0]);
    for (int i = 0; i < PHASES; i++) {
        double phase = 2.0 * PI * i / PHASES;
        for (int k = 0; k < LEGS; k++) {
            spectrum_value(s->mean[CHANNEL_P1][k], t->harmonics, s->omega, phase / s->omega, value);
            p1_pa[k] = value[0];
            spectrum_value(s->mean[CHANNEL_P2][k], t->harmonics, s->omega, phase / s->omega, value);
            p2_pa[k] = value[0];
        }
        if (!inverse_dynamics_step(&inverse, (double(*)[3])(t->phase + 3 * LEGS * i), p1_pa, p2_pa, force)) return false;
        spectrum_basis(phase, t->harmonics, basis);
        for (int k = 0; k < LEGS; k++)
            for (int a = 0; a < 1 + 2 * t->harmonics; a++) force_n[k][a] += (a ? 2.0 : 1.0) / PHASES * basis[a] * force[k];
    }
    return true;
}

bool residual_evaluate(const struct residual_test *t, const struct params *model, enum residual_part parts, residual_row row) {
    const struct spectrum *s = &t->spectrum;
    struct cylinder_model cylinder;
    double p[2][RESIDUAL_SIZE], force[LEGS][RESIDUAL_SIZE];
    cylinder_model_init(&cylinder, model);
    for (int k = 0; k < LEGS && (parts & PART_PRESSURE); k++) {
        pressures(t, &cylinder, k, p);
        for (int a = 0; a < RESIDUAL_SIZE; a++) {
            row[k][RESIDUAL_P1][a] = s->mean[CHANNEL_P1][k][a] - p[0][a];
            row[k][RESIDUAL_P2][a] = s->mean[CHANNEL_P2][k][a] - p[1][a];
        }
    }
    if (!(parts & PART_FORCE)) return true;
    if (!residual_required(t, model, force)) return false;
    for (int k = 0; k < LEGS; k++)
        for (int a = 0; a < RESIDUAL_SIZE; a++)
            row[k][RESIDUAL_FORCE][a] = cylinder.a1_m2 * s->mean[CHANNEL_P1][k][a] - cylinder.a2_m2 * s->mean[CHANNEL_P2][k][a] - force[k][a];
    return true;
}
