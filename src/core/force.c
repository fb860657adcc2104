#include "force.h"

#include "units.h"

struct cylinder_areas cylinder_areas(const struct actuator_params *actuator) {
    struct cylinder_areas areas;
    for (int leg = 0; leg < LEGS; leg++) {
        double piston = actuator->piston_diameter_m[leg], rod = actuator->rod_diameter_m[leg];
        areas.a1_m2[leg] = PI / 4 * piston * piston;
        areas.a2_m2[leg] = PI / 4 * (piston * piston - rod * rod);
    }
    return areas;
}
