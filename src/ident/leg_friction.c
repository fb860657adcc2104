#include "leg_friction.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "matrix_forces.h"
#include "nominal.h"
#include "params.h"

extern const struct effect external_stiffness;

/* Share of a segment's phases that is left out at either end, where neighbouring segments
 * contribute. */
static const double EDGE = 0.12;

struct work {
    struct params machine;              /* configuration without friction and effects
                                         * (matrix_bare_machine), with the springs that were
                                         * found */
    double more[DOFS][DOFS];            /* matrix that was found less the configured matrix; 0 for
                                         * entries that are not determined */
    struct inverse_dynamics dynamics;
};

static int begin(struct work *w, const struct recording *recording, const struct method_c *found, struct error *error) {
    static const double neutral[DOFS] = {0};
    double nominal[DOFS][DOFS];
    struct kinematics k;
    w->machine = *recording->params;
    matrix_bare_machine(&w->machine);
    int status = kinematics_init(&k, &w->machine, error);
    if (status) return status;
    nominal_matrix(&w->machine, &k, neutral, nominal);
    for (int i = 0; i < DOFS; i++)
        for (int c = 0; c < DOFS; c++) {
            double value = found->matrix.mt[i][c];
            w->more[i][c] = isfinite(value) ? value - nominal[i][c] : 0.0;
        }
    struct effect_values *springs = &w->machine.effects[effect_find(external_stiffness.name)];
    springs->on = found->springs;
    for (int i = 0; i < DOFS; i++) springs->value[i][0] = isfinite(found->spring[i]) ? found->spring[i] : 0.0;
    return STATUS_OK;
}

/* Finds the leg forces that the motion at a phase needs without friction, and the legs' rates.
 * Returns false if no pose has these lengths. */
static bool needed(struct work *w, const struct residual_test *t, int phase, double force_n[LEGS], double rate_mps[LEGS]) {
    const struct spectrum *s = &t->spectrum;
    const double *basis = t->cycle + phase * SPECTRUM_SIZE;
    struct rigid_legs legs;
    double j[LEGS][DOFS], acceleration[DOFS], leg[LEGS][3];
    for (int k = 0; k < LEGS; k++) spectrum_at(s->mean[CHANNEL_LENGTH][k], s->harmonics, s->omega, basis, leg[k]);
    if (!inverse_dynamics_bodies(&w->dynamics, (const double (*)[3])leg, &legs, j, acceleration, force_n)) return false;
    matrix_wrench(&legs, acceleration, w->machine.payload.gravity_mps2, (const double (*)[DOFS])w->more, force_n);
    for (int k = 0; k < LEGS; k++) rate_mps[k] = leg[k][1];
    return inverse_dynamics_along_legs(j, force_n);
}

/* Finds the friction at the phases of a test: the measured force less the force that the motion
 * needs without friction, both as coefficient rows (residual.h). Returns false if no pose has these
 * lengths. */
static bool find_test(struct work *w, const struct residual_test *t, struct leg_friction_test *f) {
    double row[LEGS][RESIDUAL_SIZE], rate_mps[PHASES][LEGS];
    if (!t->chambers || !residual_staircase(t, &w->machine, row)) memset(row, 0, sizeof row);
    for (int k = 0; k < LEGS; k++)
        for (int a = 0; a < t->size; a++) row[k][a] = t->row[CHANNEL_FORCE][k][a] - row[k][a];
    inverse_dynamics_init(&w->dynamics, &w->machine, 0.0, 0.0);
    for (int i = 0; i < t->phases; i++) {
        double force_n[LEGS];
        if (!needed(w, t, i, force_n, rate_mps[i])) return false;
        for (int k = 0; k < LEGS; k++)
            for (int a = 0; a < t->size; a++) row[k][a] -= t->project[i][a] * force_n[k];
    }
    f->of = t->of;
    f->cycle = t->spectrum.cycles > 0;
    int edge = f->cycle ? 0 : (int)(EDGE * t->phases);
    for (int i = edge; i < t->phases - edge; i++, f->points++)
        for (int k = 0; k < LEGS; k++) {
            f->rate_mps[k][f->points] = rate_mps[i][k];
            for (int a = 0; a < t->size; a++) f->force_n[k][f->points] += t->basis[i][a] * row[k][a];
        }
    return true;
}

int leg_friction_find(struct leg_friction *f, const struct recording *recording, const struct method_c *found, struct error *error) {
    struct work *w = malloc(sizeof *w);
    struct residual_data data = {0};
    *f = (struct leg_friction){0};
    int status = w ? begin(w, recording, found, error) : error_set(error, STATUS_IO, "out of memory");
    if (!status) status = residual_prepare(&data, recording, CYCLES_ALL, error);
    if (!status) f->test = calloc((size_t)data.tests + 1, sizeof *f->test);
    if (!status && !f->test) status = error_set(error, STATUS_IO, "out of memory");
    for (int i = 0; i < data.tests && !status; i++)
        if (!find_test(w, &data.test[i], &f->test[f->tests++]))
            status = error_set(error, STATUS_USAGE, "no pose of this machine has these lengths");
    residual_free(&data);
    free(w);
    return status;
}

void leg_friction_free(struct leg_friction *f) {
    free(f->test);
    *f = (struct leg_friction){0};
}
