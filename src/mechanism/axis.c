#include <string.h>

#include "inverse_dynamics.h"
#include "mechanism.h"
#include "params.h"

static void constants(const struct params *params, struct machine *machine) {
    machine->bodies.payload_kg = params->axis.mass_kg;
    machine->bodies.gravity_mps2 = params->axis.gravity_mps2;
    for (int leg = 0; leg < LEGS; leg++)
        machine->bodies.neutral_length_m[leg] = machine->bodies.middle_length_m[leg] = params->axis.middle_m;
}

/* Finds the force that accelerates the mass, carries its weight and overcomes the effects that act
 * on it (springs, a lever load). */
static bool forces(struct inverse_dynamics *d, const struct inverse_dynamics_input *in, struct rigid_legs *legs, double force_n[LEGS]) {
    const struct machine *m = &d->cylinder.machine;
    double pose[DOFS] = {in->leg[0][0] - d->params->axis.middle_m}, wrench[DOFS] = {0};
    (void)legs;
    memset(force_n, 0, LEGS * sizeof *force_n);
    machine_wrench(m, pose, wrench);
    force_n[0] = m->bodies.payload_kg * (in->leg[0][2] + m->bodies.gravity_mps2) - wrench[0];
    return true;
}

static void leg_mass(const struct params *params, double lambda[LEGS][LEGS]) {
    struct machine machine;
    machine_init(&machine, params);
    memset(lambda, 0, LEGS * sizeof lambda[0]);
    lambda[0][0] = machine.bodies.payload_kg;
}

const struct mechanism mechanism_axis = {
    .name = "axis",
    .legs = 1,
    .axes = 1,
    .force_sensor = true,
    .masses = {{"axis.mass_kg", offsetof(struct params, axis.mass_kg), false}},
    .csv_column = "position_m",
    .refuses = {.run = "mechanism: axis: hexid moves six legs; what one axis did is read by hexid import and gap",
                .survey = "--survey: for the six-leg platform; mechanism is axis",
                .identify = "mechanism: axis: one axis has no inertia matrix to identify; `hexid gap` reads it",
                .replay = "mechanism: axis: what drove it is not known, so it cannot be run again in closed loop; use --replay motion",
                .no_column = "no column position_m: without it an axis has nothing that can be evaluated",
                .axis = "an axis has none but x"},
    .words =
        {.machine = "one axis",
         .legs = "one axis",
         .length = "position",
         .tone = "hold the axis still: a pump's line stays, with the pump's speed; a loop's goes when its controller's gain is lowered"},
    .constants = constants,
    .forces = forces,
    .leg_mass = leg_mass,
};
