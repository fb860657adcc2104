#include <math.h>

#include "engine.h"
#include "units.h"

/* Three pairs of legs, 120 degrees apart. A pair's upper joints lie alpha either side of its axis of symmetry, its lower joints spread to
 * within beta of the midway line to the next pair. */
void sim_geometry_init(struct sim_geometry *g, const struct params *params) {
    const struct geometry_params *p = &params->geometry;
    double upper_z = params->payload.center_height_m; /* z is down: the joints lie below the mass centre */
    for (int leg = 0; leg < LEGS; leg++) {
        double axis = 2.0 * PI / 3.0 * (leg / 2), side = leg % 2 ? 1.0 : -1.0;
        g->upper_angle[leg] = axis + side * p->upper_half_angle_rad;
        g->lower_angle[leg] = axis + side * (PI / 3.0 - p->lower_half_angle_rad);
        g->upper[leg][0] = p->upper_radius_m * cos(g->upper_angle[leg]);
        g->upper[leg][1] = p->upper_radius_m * sin(g->upper_angle[leg]);
        g->upper[leg][2] = upper_z;
        g->lower[leg][0] = p->lower_radius_m * cos(g->lower_angle[leg]);
        g->lower[leg][1] = p->lower_radius_m * sin(g->lower_angle[leg]);
        g->lower[leg][2] = upper_z + p->height_m;
    }
    /* Law of cosines in plan, Pythagoras up. */
    double spread = PI / 3.0 - p->lower_half_angle_rad - p->upper_half_angle_rad;
    double plan_squared = p->upper_radius_m * p->upper_radius_m + p->lower_radius_m * p->lower_radius_m -
                          2.0 * p->upper_radius_m * p->lower_radius_m * cos(spread);
    g->neutral_length_m = sqrt(plan_squared + p->height_m * p->height_m);
}
