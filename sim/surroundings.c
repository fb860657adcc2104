#include "surroundings.h"

#include <math.h>
#include <string.h>

#include "params.h"
#include "units.h"

static const double DAMPING_RATIO = 0.05;

bool surroundings_yield(const struct params *params) { return params->sim.base_hz > 0.0 || params->sim.ripple_pa > 0.0; }

void surroundings_step(struct surroundings *s, double dt_s, double mass_kg, const double momentum[3]) {
    double w = 2.0 * PI * s->params->sim.base_hz, all_kg = s->params->sim.base_mass_kg + mass_kg;
    for (int i = 0; i < 3 && w > 0.0; i++) {
        double push_n = s->moved ? (momentum[i] - s->momentum[i]) / dt_s : 0.0;
        s->acceleration_mps2[i] = -push_n / all_kg - w * w * s->position_m[i] - 2.0 * DAMPING_RATIO * w * s->rate_mps[i];
        s->rate_mps[i] += dt_s * s->acceleration_mps2[i];
        s->position_m[i] += dt_s * s->rate_mps[i];
    }
    memcpy(s->momentum, momentum, sizeof s->momentum);
    s->moved = true;
    s->time_s += dt_s;
}

double surroundings_supply(const struct surroundings *s) {
    const struct sim_params *p = &s->params->sim;
    return s->params->hydraulics.supply_pa + p->ripple_pa * sin(2.0 * PI * p->ripple_hz * s->time_s);
}
