#include "rest.h"

#include <math.h>

#include "numeric.h"
#include "params.h"

static bool finite_sample(const struct hal_sample *s) {
    double sum = 0.0;
    for (int k = 0; k < LEGS; k++) sum += s->length_m[k] + s->p1_pa[k] + s->p2_pa[k];
    return isfinite(sum);
}

void rest_take(struct rest *r, const struct cycle *c) {
    const struct hal_sample *s = &c->in;
    r->over = r->over || (!r->begun && c->seq > 0) || c->test >= 0 || (c->state != STATE_INIT && c->state != STATE_SETTLED);
    r->begun = true;
    if (r->over || s->flags || !finite_sample(s)) return;
    if (!r->samples++) r->first = *s;
    for (int k = 0; k < LEGS; k++) {
        double p1 = s->p1_pa[k] - r->first.p1_pa[k], p2 = s->p2_pa[k] - r->first.p2_pa[k];
        r->length[k] += s->length_m[k] - r->first.length_m[k];
        r->p1[k] += p1, r->p2[k] += p2;
        r->square[0][k] += square(p1), r->square[1][k] += square(p2);
    }
}

/* Standard deviation of a mean reading. With noise the converter's rounding error differs from
 * sample to sample and averages out; in a reading that stands still it stays the same. */
static double std_of_mean(double sum, double squares, double count, double step) {
    double variance = fmax((squares - sum * sum / count) / (count - 1.0), 0.0), rounding = square(step) / 12.0;
    return sqrt(variance > 0.0 ? (variance + rounding) / count : rounding);
}

struct rest_found rest_find(const struct rest *r, const struct params *params) {
    const struct sensor_params *s = &params->sensors;
    struct rest_found found = {.samples = r->samples};
    double n = (double)r->samples, step_pa = s->enabled ? 2.0 * s->pressure_full_scale_pa / exp2(s->adc_bits) : 0.0;
    for (int k = 0; k < LEGS && r->samples >= REST_LEAST; k++) {
        found.length_m[k] = r->first.length_m[k] + r->length[k] / n;
        found.zero_pa[0][k] = r->first.p1_pa[k] + r->p1[k] / n - params->hydraulics.tank_pa;
        found.zero_pa[1][k] = r->first.p2_pa[k] + r->p2[k] / n - params->hydraulics.tank_pa;
        found.zero_std_pa[0][k] = std_of_mean(r->p1[k], r->square[0][k], n, step_pa);
        found.zero_std_pa[1][k] = std_of_mean(r->p2[k], r->square[1][k], n, step_pa);
    }
    return found;
}

void rest_note_stops(const struct rest_found *r, struct params *params) {
    const struct actuator_params *a = &params->actuator;
    double rounding_m = params->sensors.enabled ? params->sensors.position_resolution_m / sqrt(12.0) : 0.0;
    if (!(a->retracted_std_m > 0.0) || r->samples < REST_LEAST) return;
    params->found.retracted_std_m = hypot(a->retracted_std_m, rounding_m);
    for (int k = 0; k < LEGS; k++) params->found.retracted_m[k] = r->length_m[k] - a->retracted_m[k];
}
