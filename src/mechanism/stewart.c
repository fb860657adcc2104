#include <math.h>
#include <string.h>

#include "inverse_dynamics.h"
#include "joint_axes.h"
#include "mechanism.h"
#include "params.h"
#include "vec.h"

/* Adds to `wrench` the part that overcomes joint friction. */
static void push_joints(const struct inverse_dynamics *d, const struct rigid_legs *legs, const double acceleration[DOFS],
                        double wrench[DOFS]) {
    struct joint_axes axes;
    joint_axes(&d->rigid, &d->state, legs, &axes);
    for (int k = 0; k < JOINT_AXES; k++) {
        double rate = dot6(axes.row[k], d->state.twist), turn = dot6(axes.row[k], acceleration) + axes.bias[k];
        struct friction f = machine_joint_friction(&d->cylinder.machine, k / JOINT_AXES_PER_LEG, fabs(rate));
        double moment = inverse_dynamics_direction(rate, turn, d->window_s) * f.dry + copysign(f.viscous, rate);
        add6(moment, axes.row[k], wrench);
    }
}

static bool forces(struct inverse_dynamics *d, const struct inverse_dynamics_input *in, struct rigid_legs *legs, double force_n[LEGS]) {
    double j[LEGS][DOFS], acceleration[DOFS];
    if (!inverse_dynamics_bodies(d, in->leg, legs, j, acceleration, force_n)) return false;
    if (d->joints) push_joints(d, legs, acceleration, force_n);
    if (!inverse_dynamics_along_legs(j, force_n)) return false;
    for (int k = 0; k < LEGS; k++) force_n[k] += d->rigid.upper_mass[k] * in->ahead[k][2];
    return true;
}

/* Computes the inertia matrix in leg coordinates, (J M^-1 J')^-1; J M^-1 J' maps forces along the
 * legs to accelerations along the legs. */
static void leg_mass(const struct params *params, double lambda[LEGS][LEGS]) {
    struct rigid_model rigid;
    struct rigid_state s;
    struct rigid_legs legs;
    double mass[DOFS][DOFS], load[DOFS], row[LEGS][DOFS];
    struct factor6 factor, mobility = {0};
    rigid_model_init(&rigid, params);
    rigid_rest(&s, (const double[DOFS]){0});
    rigid_legs(&rigid, &s, &legs);
    rigid_dynamics(&rigid, &s, &legs, mass, load);
    memcpy(factor.c, mass, sizeof factor.c);
    factor6(&factor);
    for (int k = 0; k < LEGS; k++) {
        rigid_row(&legs, k, row[k]);
        whiten6(&factor, row[k]);
    }
    for (int i = 0; i < LEGS; i++)
        for (int j = 0; j <= i; j++) mobility.c[i][j] = dot6(row[i], row[j]);
    factor6(&mobility);
    for (int i = 0; i < LEGS; i++) {
        double unit[LEGS] = {0};
        unit[i] = 1.0;
        whiten6(&mobility, unit);
        unwhiten6(&mobility, unit);
        memcpy(lambda[i], unit, sizeof unit);
    }
}

#define MASS(member) #member, offsetof(struct params, member)

const struct mechanism mechanism_stewart = {
    .name = "stewart",
    .legs = LEGS,
    .axes = DOFS,
    .pose = true,
    .default_machine = true,
    .short_strokes = true,
    .masses = {{MASS(payload.mass_kg), false},
               {MASS(payload.inertia_xx_kg_m2), false},
               {MASS(payload.inertia_yy_kg_m2), false},
               {MASS(payload.inertia_zz_kg_m2), false},
               {MASS(actuator.upper_mass_kg), true},
               {MASS(actuator.lower_mass_kg), true}},
    .words = {.machine = "a platform",
              .legs = "six legs",
              .length = "length",
              .tone = "hold the platform still: a pump's line stays, with the pump's speed; a loop's goes when control.kp is lowered"},
    .forces = forces,
    .leg_mass = leg_mass,
};
