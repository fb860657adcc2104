#include "loop_found.h"

#include <math.h>

#include "params.h"

struct params loop_found_params(const struct params *params, const struct loop_survey *survey) {
    struct params p = *params;
    const struct payload *found = &survey->inertia.payload;
    if (found->evaluated && found->whole && found->nearest[PAYLOAD_MASS] > 0.0) payload_configure(found->nearest, &p.payload);
    return p;
}

double loop_found_factor(double found, double configured) {
    double by = found / configured;
    return by > 1.0 / LOOP_FOUND_MOST && by < LOOP_FOUND_MOST ? by : (double)NAN;
}

/* Factor from the configured value to the found one; 1 if the factor is no number, or if the two
 * differ by more than LOOP_FOUND_MOST times. */
static double factor(double found, double configured) {
    double by = loop_found_factor(found, configured);
    return isnan(by) ? 1.0 : by;
}

static struct found_leg compare(const struct loop_leg *model, const struct oil_leg *found, double viscous, double dt_s) {
    double delay_s = 2.0 * model->spool_damping / model->spool_radps + 0.5 * dt_s + model->command_delay_s;
    struct found_leg f = {.viscous = factor(viscous, model->viscous), .later_s = isfinite(found->delay_s) ? found->delay_s - delay_s : 0.0};
    for (int i = 0; i < 2; i++) {
        f.push[i] = factor(found->chamber[i].push, model->chamber[i].push);
        f.open[i] = factor(found->chamber[i].open, model->chamber[i].open);
        f.sag[i] = factor(found->chamber[i].sag, model->chamber[i].sag);
        f.other[i] = factor(found->chamber[i].other, model->chamber[i].other);
    }
    return f;
}

/* Corrects a leg. If the delay found is longer than the configured one, the excess is added to the
 * commands' delay; if it is shorter, the spool becomes faster. */
static void correct(struct loop_leg *leg, const struct found_leg *f) {
    double spool_s = 2.0 * leg->spool_damping / leg->spool_radps;
    leg->viscous *= f->viscous;
    if (f->later_s >= 0.0) leg->command_delay_s += f->later_s;
    else leg->spool_radps *= spool_s / fmax(spool_s + f->later_s, spool_s / LOOP_FOUND_MOST);
    for (int i = 0; i < 2; i++) {
        struct oil_chamber *c = &leg->chamber[i];
        c->push *= f->push[i], c->open *= f->open[i], c->sag *= f->sag[i], c->other *= f->other[i];
    }
}

struct loop_found loop_found(const struct loop_place *neutral, const struct params *params, const struct loop_survey *survey) {
    struct loop_found f;
    for (int k = 0; k < LEGS; k++) f.leg[k] = compare(&neutral->leg[k], &survey->leg[k], survey->inertia.viscous[k], params->loop.period_s);
    return f;
}

bool loop_found_correct(const struct loop_found *found, struct loop_place *place, const struct params *params, const struct modal *modal) {
    for (int k = 0; k < LEGS; k++) {
        const struct found_leg *f = &found->leg[k];
        double faster = 0.5 * (f->open[0] / f->push[0] + f->open[1] / f->push[1]);
        correct(&place->leg[k], f);
        place->out_mps[k] *= faster, place->in_mps[k] *= faster;
    }
    return loop_place_modes(place, params, modal);
}
