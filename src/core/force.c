#include "force.h"

#include "params.h"
#include "units.h"

/* Stiffness of the oil, as a multiple of the stiffness at neutral, above which control.kpf is
 * reduced. No test of the shipped machines exceeds it. */
static const double stiffer_most = 1.5;

struct cylinder_areas cylinder_areas(const struct actuator_params *actuator) {
    struct cylinder_areas areas;
    for (int leg = 0; leg < LEGS; leg++) {
        double piston = actuator->piston_diameter_m[leg], rod = actuator->rod_diameter_m[leg];
        areas.a1_m2[leg] = PI / 4 * piston * piston;
        areas.a2_m2[leg] = PI / 4 * (piston * piston - rod * rod);
    }
    return areas;
}

static double over_bulk_modulus(const struct oil_column *c, double length_m) {
    double inside_m = length_m < c->least_m ? c->least_m : length_m > c->most_m ? c->most_m : length_m;
    double rodless_m3 = c->dead_m3[0] + c->area_m2[0] * (inside_m - c->least_m);
    double rod_m3 = c->dead_m3[1] + c->area_m2[1] * (c->most_m - inside_m);
    return c->area_m2[0] * c->area_m2[0] / rodless_m3 + c->area_m2[1] * c->area_m2[1] / rod_m3;
}

void oil_columns_init(struct oil_column column[LEGS], const struct params *params, const struct kinematics *k) {
    const struct hydraulics_params *h = &params->hydraulics;
    struct cylinder_areas areas = cylinder_areas(&params->actuator);
    for (int leg = 0; leg < LEGS; leg++) {
        struct stroke stroke = kinematics_stroke(k, &params->actuator, leg);
        double dead_m3 = h->dead_volume_m3[leg];
        column[leg] = (struct oil_column){.area_m2 = {areas.a1_m2[leg], areas.a2_m2[leg]},
                                          .dead_m3 = {dead_m3, dead_m3 + h->dead_volume_difference_m3[leg]},
                                          .least_m = stroke.least_m,
                                          .most_m = stroke.most_m};
        column[leg].most_stiff_per_m = stiffer_most * over_bulk_modulus(&column[leg], k->neutral_length_m[leg]);
    }
}

double oil_feedback_cut(const struct oil_column *column, double length_m) {
    double stiff = over_bulk_modulus(column, length_m);
    return stiff > column->most_stiff_per_m ? 1.0 - column->most_stiff_per_m / stiff : 0.0;
}
