#include "force.h"

#include "units.h"

struct cylinder_areas cylinder_areas(const struct actuator_params *actuator) {
    double piston = actuator->piston_diameter_m, rod = actuator->rod_diameter_m;
    return (struct cylinder_areas){.a1_m2 = PI / 4 * piston * piston, .a2_m2 = PI / 4 * (piston * piston - rod * rod)};
}
