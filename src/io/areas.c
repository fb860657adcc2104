#include "areas.h"

#include <stdio.h>

#include "force.h"
#include "params.h"

bool areas_stated(const struct params *params) {
    return params_mechanism(params)->default_machine || (params->actuator.stated.piston && params->actuator.stated.rod);
}

static bool alike(const struct params *p, const double value[LEGS]) {
    for (int i = 1; i < params_legs(p); i++)
        if (value[i] < value[0] || value[i] > value[0]) return false;
    return true;
}

void areas_text(const struct params *params, char text[AREAS_TEXT_SIZE]) {
    const struct actuator_params *a = &params->actuator;
    const char *missing = a->stated.piston ? "actuator.rod_diameter_m" : a->stated.rod ? "actuator.piston_diameter_m" : NULL;
    struct cylinder_areas areas = cylinder_areas(a);

    if (!areas_stated(params))
        snprintf(text, AREAS_TEXT_SIZE, "the configuration does not state the cylinder's areas: give it %s beside mechanism: %s",
                 missing ? missing : "actuator.piston_diameter_m and actuator.rod_diameter_m", params_mechanism(params)->name);
    else if (!alike(params, a->piston_diameter_m) || !alike(params, a->rod_diameter_m))
        snprintf(text, AREAS_TEXT_SIZE, "each leg's own (actuator.piston_diameter_m, rod_diameter_m)");
    else
        snprintf(text, AREAS_TEXT_SIZE, "%.4g cm^2 on the rodless side, %.4g cm^2 on the rod side (piston %g mm, rod %g mm)",
                 1e4 * areas.a1_m2[0], 1e4 * areas.a2_m2[0], 1e3 * a->piston_diameter_m[0], 1e3 * a->rod_diameter_m[0]);
}
