#include <math.h>
#include <string.h>

#include "engine.h"
#include "params.h"
#include "units.h"

/* Places three pairs of legs, 120 degrees apart. The upper joints of a pair are at +-alpha from the
 * pair's axis, its lower joints at +-(60 degrees - beta). */
static void on_circles(struct sim_geometry *g, const struct geometry_params *p) {
    for (int leg = 0; leg < LEGS; leg++) {
        double axis = 2.0 * PI / 3.0 * (leg / 2), side = leg % 2 ? 1.0 : -1.0;
        double upper = axis + side * p->upper_half_angle_rad, lower = axis + side * (PI / 3.0 - p->lower_half_angle_rad);
        g->upper[leg][0] = p->upper_radius_m * cos(upper), g->upper[leg][1] = p->upper_radius_m * sin(upper);
        g->lower[leg][0] = p->lower_radius_m * cos(lower), g->lower[leg][1] = p->lower_radius_m * sin(lower);
    }
}

static void as_given(const struct leg_vectors *given, double point[LEGS][3]) {
    if (given->given) memcpy(point, given->leg, sizeof given->leg);
}

/* Computes the first axis of a joint: as configured, or else tangential to the joint circle. */
static void first_axis(const struct leg_vectors *given, int leg, const double joint[3], double axis[3]) {
    double angle = atan2(joint[1], joint[0]);
    const double tangent[3] = {-sin(angle), cos(angle), 0.0}, *v = given->given ? given->leg[leg] : tangent;
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; i++) axis[i] = v[i] / length;
}

void sim_geometry_init(struct sim_geometry *g, const struct params *params) {
    const struct payload_params *p = &params->payload;
    double height_m = params->geometry.height_m;
    memset(g, 0, sizeof *g);
    on_circles(g, &params->geometry);
    as_given(&params->geometry.upper, g->upper);
    as_given(&params->geometry.lower, g->lower);
    for (int leg = 0; leg < LEGS; leg++) {
        double *a = g->upper[leg], *b = g->lower[leg];
        first_axis(&params->geometry.upper_axis, leg, a, g->upper_axis[leg]);
        first_axis(&params->geometry.lower_axis, leg, b, g->lower_axis[leg]);
        g->neutral_length_m[leg] = sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                                        (a[2] - b[2] - height_m) * (a[2] - b[2] - height_m));
        /* From here on positions are relative to the mass centre, not to the drawing's origin: z is
         * down, and the joints are below the mass centre. */
        a[0] -= p->center_x_m, a[1] -= p->center_y_m, a[2] += p->center_height_m;
        b[0] -= p->center_x_m, b[1] -= p->center_y_m, b[2] += p->center_height_m + height_m;
    }
}
