#include "resolution.h"

#include <math.h>

#include "vec.h"

/* Limits of the check, below the stability limits of the explicit steps: rate^2 dt^2 < 4 for a
 * spring (leapfrog; RK4: 8), rate dt < 1 for a damper (velocities extrapolated by half a substep;
 * RK4: 2.8), rate dt < 2.8 for a chamber (RK4). */
static const double SPRING_MOST = 3.5, DAMPER_MOST = 0.9, LEAK_MOST = 2.5;
enum { ITERATIONS = 60 };

/* Finds, by the power method, the largest eigenvalue of the sum of of[k] w[k] w[k]' over the
 * legs k. w[k]: row of leg k, scaled by the platform's inertia. of[k]: stiffness or damping
 * along leg k. */
static double fastest(const double of[LEGS], double w[LEGS][DOFS]) {
    double x[DOFS] = {1.0, 0.9, 0.8, 0.7, 0.6, 0.5}, value = 0.0;
    for (int n = 0; n < ITERATIONS; n++) {
        double y[DOFS] = {0};
        for (int k = 0; k < LEGS; k++) add6(of[k] * dot6(w[k], x), w[k], y);
        value = sqrt(dot6(y, y));
        if (!(value > 0.0)) return value;
        for (int i = 0; i < DOFS; i++) x[i] = y[i] / value;
    }
    return value;
}

/* Scales the legs' rows by the platform's inertia: the dot product of w[k] and w[l] is then the
 * acceleration of leg l for a unit force along leg k. */
static void whiten_legs(const struct rigid_model *rigid, const double pose[DOFS], struct rigid_legs *legs, double w[LEGS][DOFS]) {
    struct rigid_state s;
    struct factor6 mass = {0};
    double load[DOFS];
    rigid_rest(&s, pose);
    rigid_legs(rigid, &s, legs);
    rigid_dynamics(rigid, &s, legs, mass.c, load);
    factor6(&mass);
    for (int k = 0; k < LEGS; k++) {
        rigid_row(legs, k, w[k]);
        whiten6(&mass, w[k]);
    }
}

static double viscous(const struct cylinder_model *m, int leg) {
    const struct cylinder_state rest = {0};
    return fmax(cylinder_friction(m, leg, &rest, 1, 1.0).viscous, cylinder_friction(m, leg, &rest, -1, 1.0).viscous);
}

/* Returns the rate, 1/s, at which leakage evens out the pressures of the leg's chambers. */
static double leak_rate(const struct cylinder_leg *c, double length_m) {
    double stroke_m = c->length_max_m - c->length_min_m, in_m = fmin(fmax(length_m - c->length_min_m, 0.0), stroke_m);
    double one_m3 = c->dead_volume_m3[PORT_A] + c->a1_m2 * in_m, other_m3 = c->dead_volume_m3[PORT_B] + c->a2_m2 * (stroke_m - in_m);
    return c->leakage_m3_per_s_pa * c->bulk_modulus_pa * (1.0 / one_m3 + 1.0 / other_m3);
}

int resolution_check(const struct cylinder_model *cylinder, const struct rigid_model *rigid, const double pose[DOFS], double dt_s,
                     struct error *error) {
    struct rigid_legs legs;
    double w[LEGS][DOFS], spring[LEGS], damper[LEGS], leak = 0.0;
    whiten_legs(rigid, pose, &legs, w);
    for (int k = 0; k < LEGS; k++) {
        spring[k] = cylinder_stiffness(cylinder, k, legs.length[k]);
        damper[k] = viscous(cylinder, k);
        leak = fmax(leak, leak_rate(&cylinder->leg[k], legs.length[k]) * dt_s);
    }
    double springs = fastest(spring, w) * dt_s * dt_s, dampers = fastest(damper, w) * dt_s;
    const struct {
        const char *what;
        double times;
    } found[] = {
        {"the masses on the legs' oil (actuator.piston_diameter_m, hydraulics.dead_volume_m3, bulk_modulus_pa) ring",
         sqrt(springs / SPRING_MOST)},
        {"hydraulics.viscous_n_s_per_m, with all effects, stops the masses on the legs", dampers / DAMPER_MOST},
        {"hydraulics.leakage_m3_per_s_pa, with all effects, evens out the chambers", leak / LEAK_MOST},
    };
    for (int i = 0; i < 3; i++)
        if (!(found[i].times <= 1.0))
            return error_set(error, STATUS_USAGE, "%s faster than substeps of %.3g ms: raise sim.substeps %.0f times, or correct that",
                             found[i].what, dt_s * 1e3, ceil(found[i].times));
    return STATUS_OK;
}
