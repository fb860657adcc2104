#include "loop_survey.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kinematics.h"
#include "lin.h"
#include "modal.h"
#include "params.h"

/* Finds the response of the axes. Amplitudes of the lengths are converted to amplitudes of the pose
 * by the Jacobian at neutral, because the motions are small. */
static int find_follow(struct loop_survey *s, const struct multisine_mean *mean, const struct params *params, struct error *error) {
    static const double neutral[DOFS] = {0};
    const struct multisine *m = &s->multisine;
    struct kinematics k;
    double j[LEGS][DOFS], inverse[DOFS][LEGS], *series = malloc((size_t)m->samples * sizeof *series);
    int status = series ? kinematics_init(&k, params, error) : error_set(error, STATUS_IO, "out of memory");
    if (status) {
        free(series);
        return status;
    }
    ik_jacobian(&k, neutral, j);
    lin_inverse(DOFS, j[0], inverse[0]);
    for (int i = 0; i < m->tones && !status; i++) {
        for (int n = 0; n < m->samples; n++) series[n] = mean->sample[n].ref[m->tone[i].dof];
        double complex ref = multisine_amplitude(mean, i, series);
        for (int leg = 0; leg < LEGS; leg++) {
            for (int n = 0; n < m->samples; n++) series[n] = mean->sample[n].length_m[leg];
            double complex length = multisine_amplitude(mean, i, series);
            for (int dof = 0; dof < DOFS; dof++) s->follow[i][dof] += inverse[dof][leg] * length / ref;
        }
    }
    free(series);
    return status;
}

static void find_floor(struct loop_survey *s, const struct multisine_mean *mean) {
    memcpy(s->noise_m, mean->noise_m, sizeof s->noise_m);
    memcpy(s->noise_pa, mean->noise_pa, sizeof s->noise_pa);
    for (int k = 0; k < LEGS; k++)
        for (int n = 0; n < s->multisine.samples; n++) {
            s->mean_pa[0][k] += mean->sample[n].p1_pa[k] / s->multisine.samples;
            s->mean_pa[1][k] += mean->sample[n].p2_pa[k] / s->multisine.samples;
        }
}

static void find_modes(struct loop_survey *s, const struct params *params) {
    /* A matrix that was not evaluated is zero, and then nothing is determined. */
    struct method_result *matrix = &s->inertia.matrix;
    struct kinematics k;
    struct modal modal;
    kinematics_place(&k, params);
    s->determined = !modal_init(&modal, params, &k, &(struct error){0}) &&
                    oil_columns_modes(s->leg, params, matrix->mt, matrix->mt_std, s->mode);
    for (int i = 0; i < DOFS; i++)
        s->loop[i] = s->determined ? loop_poles(s->leg, &s->mode[i], modal_gain(&modal, s->mode[i].motion), s->inertia.viscous, params)
                                   : (struct loop_mode){.hz = (double)NAN, .damping = (double)NAN};
}

int loop_survey(struct loop_survey *s, const struct multisine *multisine, const struct recording *recording, const struct method_c *inertia,
                struct error *error) {
    struct multisine_mean mean;
    const struct params *params = recording->params;
    *s = (struct loop_survey){.multisine = *multisine, .inertia = *inertia};
    if (!recording->tests || !recording->measured.pressures || !recording->measured.valve)
        return error_set(error, STATUS_USAGE, "survey: nothing was recorded, or pressures or commands are missing");
    int status = multisine_average(&mean, &s->multisine, &recording->test[0], params->tests.ramp_s, error);
    if (!status) status = oil_columns_find(&mean, params, s->leg, error);
    if (!status) status = find_follow(s, &mean, params, error);
    if (!status) {
        find_floor(s, &mean);
        find_modes(s, params);
    }
    multisine_free(&mean);
    return status;
}

double loop_survey_oil_hz(const struct loop_survey *s) { return s->determined ? s->mode[0].hz : (double)NAN; }

double loop_survey_loop_hz(const struct loop_survey *s) {
    double least = NAN;
    for (int i = 0; i < DOFS; i++) least = fmin(least, s->loop[i].hz); /* fmin skips NaN */
    return least;
}

double complex loop_survey_response(const struct loop_survey *s, enum dof driven, enum dof dof, double hz) {
    int before = -1;
    for (int i = 0; i < s->multisine.tones; i++) {
        const struct multisine_tone *l = &s->multisine.tone[i];
        if (l->dof != driven) continue;
        if (l->hz >= hz && before < 0) return s->follow[i][dof];
        if (l->hz >= hz) {
            double from_hz = s->multisine.tone[before].hz, share = log(hz / from_hz) / log(l->hz / from_hz);
            return (1.0 - share) * s->follow[before][dof] + share * s->follow[i][dof];
        }
        before = i;
    }
    return before < 0 ? 0.0 : s->follow[before][dof];
}

double complex loop_survey_follow(const struct loop_survey *s, enum dof dof, double hz) { return loop_survey_response(s, dof, dof, hz); }
