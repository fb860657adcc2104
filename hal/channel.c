#include "channel.h"

#include <math.h>

#include "params/field.h"

double channel_si(const struct channel_params *c, int leg, double raw) {
    double part = (raw - c->raw_min[leg]) / (c->raw_max[leg] - c->raw_min[leg]);
    double si = c->si_min[leg] + part * (c->si_max[leg] - c->si_min[leg]) + c->offset[leg];
    return si >= c->low[leg] && si <= c->high[leg] ? si : (double)NAN;
}

int32_t channel_raw(const struct channel_params *c, int leg, double si, int32_t limit) {
    double part = (si - c->offset[leg] - c->si_min[leg]) / (c->si_max[leg] - c->si_min[leg]);
    double raw = round(c->raw_min[leg] + part * (c->raw_max[leg] - c->raw_min[leg]));
    if (isnan(raw)) return -limit - 1;
    return (int32_t)fmin(fmax(raw, -(double)limit), (double)limit);
}
