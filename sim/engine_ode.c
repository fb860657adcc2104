/* The ODE engine: bodies first, then the hydraulics over the motion just found.
 *
 * Time. ODE's semi-implicit Euler is a leapfrog: positions and pressures belong to the ends of a
 * substep, velocities to its middle. The leapfrog is of second order if each force is taken at the
 * substep's start, halfway between two velocities:
 *   position, pressure   taken as they are;
 *   velocity             extrapolated by half a substep, v + (v - v_before) / 2;
 *   given force          mean of this substep's and the previous one's (forced());
 *   start from rest      velocities start half a substep before the positions (start()).
 * Without extrapolation the engine would be of first order: viscous friction b would take dt/2 J'bJ
 * from the inertia, 0.44 % of mz and 0.54 % of Ixx at 0.25 ms. All substeps after a place() must
 * have the same length; dry friction is of first order at its reversals.
 *
 * Sticking is solved within ODE's complementarity problem: a leg is stuck if the force of its motor
 * is below the motor's limit. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hydraulics.h"
#include "ode_machine.h"
#include "params.h"
#include "surroundings.h"

/* Least mass (kg) and inertia (kg m^2) of a leg's part. With less, ODE computes inertia matrices
 * that are not positive definite. */
static const double LEAST_BODY = 1e-8;

/* A leg and its resistance at one instant. Forces act on the rod, except contact_n, and are
 * positive away from the base. */
struct leg {
    dVector3 axis;
    double length_m, rate_mps;
    double viscous_n;
    double passive_n; /* sum of viscous friction, seals, end stop, and the middle of the dry
                       * friction's range */
    double holding_n; /* half of the dry friction's range, which is the limit of the piston's
                       * motor */
    double contact_n; /* force of the rod on the platform; 0 without backlash */
};

struct engine_ode {
    struct engine base;
    struct cylinder_model model;
    struct ode_machine machine;
    struct surroundings surroundings;
    bool joints_rub;
    double pose[DOFS], ahead_m[LEGS]; /* arguments of the last call of place() */
    bool started;                   /* a substep has been made since place() */
    struct velocity before[BODIES]; /* velocities one substep ago */
    bool hydraulic;                 /* the hydraulics act; false: given forces replace them */
    double held_n[LEGS];          /* given forces of the previous substep; only if not
                                   * `hydraulic` */
    struct leg leg[LEGS];           /* legs at the start of the substep */
    double motor_n[LEGS];           /* force of each piston's motor: dry friction less the middle of
                                     * its range, which is in passive_n */
    bool stuck[LEGS];
};

/* Returns a body's velocity at the instant of the present positions. ODE's velocity belongs to half
 * a substep before that. */
static struct velocity velocity_now(const struct engine_ode *e, int body) {
    struct velocity v = ode_machine_velocity(&e->machine, body);
    for (int k = 0; k < 3; k++) {
        v.linear[k] += 0.5 * (v.linear[k] - e->before[body].linear[k]);
        v.angular[k] += 0.5 * (v.angular[k] - e->before[body].angular[k]);
    }
    return v;
}

/* Returns the contact force between rod and platform of a leg with backlash; 0 without. */
static double contact_now(const struct engine_ode *e, int i, const struct leg *leg) {
    const struct machine *machine = &e->model.machine;
    dVector3 joint, arm, turning;
    struct velocity platform = velocity_now(e, PLATFORM);
    if (!machine_has_play(machine, i)) return 0.0;
    ode_machine_joint(&e->machine, i, joint);
    dSubtractVectors3(arm, joint, dBodyGetPosition(e->machine.body[PLATFORM]));
    dCalcVectorCross3(turning, platform.angular, arm);
    double rate_mps = dCalcVectorDot3(platform.linear, leg->axis) + dCalcVectorDot3(turning, leg->axis);
    dSubtractVectors3(arm, joint, machine->bodies.lower_joint_m[i]);
    return machine_contact(machine, i, leg->length_m - dCalcVectorDot3(arm, leg->axis), leg->rate_mps - rate_mps);
}

/* Finds a leg and its resistance. Friction in the direction of motion is computed at the leg's
 * speed, friction in the other direction at zero speed, for the case that the leg reverses. So both
 * the force of a sliding leg and the range of forces that hold a leg are exact. */
static struct leg leg_now(const struct engine_ode *e, int i, const struct hydraulics_state *s) {
    struct leg leg;
    struct velocity rod = velocity_now(e, ROD + i), cylinder = velocity_now(e, CYLINDER + i);
    ode_machine_axis(&e->machine, i, leg.axis);
    leg.length_m = ode_machine_length(&e->machine, i, leg.axis);
    leg.rate_mps = dCalcVectorDot3(rod.linear, leg.axis) - dCalcVectorDot3(cylinder.linear, leg.axis);
    struct friction extend = cylinder_friction(&e->model, i, &s->cylinder[i], 1, leg.rate_mps > 0.0 ? leg.rate_mps : 0.0);
    struct friction retract = cylinder_friction(&e->model, i, &s->cylinder[i], -1, leg.rate_mps < 0.0 ? -leg.rate_mps : 0.0);
    double stop_n = cylinder_stop_force(&e->model, i, leg.length_m, leg.rate_mps);
    leg.viscous_n = e->hydraulic ? retract.viscous - extend.viscous : 0.0;
    leg.passive_n = stop_n + 0.5 * (retract.dry - extend.dry) + leg.viscous_n + cylinder_seal_force(&e->model, i, &s->cylinder[i]);
    leg.holding_n = 0.5 * (retract.dry + extend.dry);
    leg.contact_n = contact_now(e, i, &leg);
    return leg;
}

static void look_at_legs(struct engine_ode *e, const struct hydraulics_state *s) {
    for (int i = 0; i < LEGS; i++) {
        e->leg[i] = leg_now(e, i, s);
        dJointSetPistonParam(e->machine.piston[i], dParamFMax, e->leg[i].holding_n);
    }
}

/* Pushes at the mass centres of cylinder and rod, which lie on the leg's axis, so that no moment
 * arises. */
static void push_leg(struct engine_ode *e, int i, double force_n) {
    const double *n = e->leg[i].axis;
    dBodyAddForce(e->machine.body[ROD + i], force_n * n[0], force_n * n[1], force_n * n[2]);
    dBodyAddForce(e->machine.body[CYLINDER + i], -force_n * n[0], -force_n * n[1], -force_n * n[2]);
}

static void push_platform(struct engine_ode *e, int i) {
    const double *n = e->leg[i].axis;
    double force_n = e->leg[i].contact_n;
    dVector3 joint;
    if (force_n == 0.0) return;
    ode_machine_joint(&e->machine, i, joint);
    dBodyAddForceAtPos(e->machine.body[PLATFORM], force_n * n[0], force_n * n[1], force_n * n[2], joint[0], joint[1], joint[2]);
    dBodyAddForce(e->machine.body[ROD + i], -force_n * n[0], -force_n * n[1], -force_n * n[2]);
}

/* Applies joint friction through a motor. omega: angular velocity of the motor's first body against
 * its second. */
static void rub_joint(struct engine_ode *e, int leg, dJointID motor, const dVector3 omega) {
    double moment[2];
    for (int k = 0; k < 2; k++) {
        dVector3 axis;
        dJointGetAMotorAxis(motor, k, axis);
        double rate = dCalcVectorDot3(omega, axis);
        struct friction friction = machine_joint_friction(&e->model.machine, leg, fabs(rate));
        dJointSetAMotorParam(motor, k ? dParamFMax2 : dParamFMax1, friction.dry);
        moment[k] = -copysign(friction.viscous, rate);
    }
    dJointAddAMotorTorques(motor, moment[0], moment[1], 0.0);
}

static void rub_joints(struct engine_ode *e) {
    struct velocity platform = velocity_now(e, PLATFORM);
    for (int i = 0; i < LEGS; i++) {
        struct velocity cylinder = velocity_now(e, CYLINDER + i), rod = velocity_now(e, ROD + i);
        dVector3 relative;
        dSubtractVectors3(relative, platform.angular, rod.angular);
        rub_joint(e, i, e->machine.lower_rub[i], cylinder.angular);
        rub_joint(e, i, e->machine.upper_rub[i], relative);
    }
}

static void kick(struct engine_ode *e, double dt_s, const double force_n[LEGS]) {
    for (int i = 0; i < LEGS; i++) push_leg(e, i, force_n[i] + e->leg[i].passive_n);
    for (int i = 0; i < LEGS; i++) push_platform(e, i);
    if (e->joints_rub) rub_joints(e);
    ode_machine_load(&e->machine);
    for (int b = 0; b < BODIES; b++) e->before[b] = ode_machine_velocity(&e->machine, b);
    dWorldStep(e->machine.world, dt_s);
}

/* Starts from rest. A trial step finds the velocities that a substep gains. Velocities belong to
 * half a substep before the positions, so they start at minus half of this gain, and those in
 * `before` at minus one and a half of it. */
static void start(struct engine_ode *e, double dt_s, const double force_n[LEGS]) {
    kick(e, dt_s, force_n);
    ode_machine_place(&e->machine, e->pose, e->ahead_m);
    for (int b = 0; b < BODIES; b++) {
        struct velocity gained = ode_machine_velocity(&e->machine, b);
        ode_machine_set_velocity(&e->machine, b, &gained, -1.5);
        e->before[b] = ode_machine_velocity(&e->machine, b);
        ode_machine_set_velocity(&e->machine, b, &gained, -0.5);
    }
    e->started = true;
}

static void step_bodies(struct engine_ode *e, double dt_s, const double force_n[LEGS]) {
    if (!e->started) start(e, dt_s, force_n);
    kick(e, dt_s, force_n);
    for (int i = 0; i < LEGS; i++) {
        double limit_n = e->leg[i].holding_n;
        e->motor_n[i] = limit_n > 0.0 ? -dCalcVectorDot3(e->machine.feedback[i].f1, e->leg[i].axis) : 0.0;
        /* the solver sets a sliding motor to its limit, except for rounding */
        e->stuck[i] = fabs(e->motor_n[i]) < limit_n * (1.0 - 1e-9);
    }
}

/* Makes one RK4 step of the hydraulics, while each leg moves at constant speed from its old to its
 * new length. */
static void step_hydraulics(struct engine_ode *e, double dt_s, const double valve[LEGS], struct hydraulics_state *s) {
    double from_m[LEGS], middle_m[LEGS], to_m[LEGS], rate_mps[LEGS];
    for (int i = 0; i < LEGS; i++) {
        dVector3 axis;
        ode_machine_axis(&e->machine, i, axis);
        from_m[i] = e->leg[i].length_m;
        to_m[i] = ode_machine_length(&e->machine, i, axis);
        middle_m[i] = 0.5 * (from_m[i] + to_m[i]);
        rate_mps[i] = (to_m[i] - from_m[i]) / dt_s;
    }
    const struct hydraulics_input input[3] = {{from_m, rate_mps, valve}, {middle_m, rate_mps, valve}, {to_m, rate_mps, valve}};
    hydraulics_step(&e->model, dt_s, input, s);
}

/* Makes a substep of base and pump. In the frame of the moving base, the bodies feel its
 * acceleration reversed. */
static void yield(struct engine_ode *e, double dt_s) {
    struct surroundings *s = &e->surroundings;
    double momentum[3] = {0}, mass_kg = 0.0, pull[3];
    for (int b = 0; b < BODIES; b++) {
        dMass mass;
        dBodyGetMass(e->machine.body[b], &mass);
        struct velocity v = ode_machine_velocity(&e->machine, b);
        mass_kg += mass.mass;
        for (int i = 0; i < 3; i++) momentum[i] += mass.mass * v.linear[i];
    }
    surroundings_step(s, dt_s, mass_kg, momentum);
    for (int i = 0; i < 3; i++) pull[i] = e->model.machine.bodies.gravity_mps2 * e->model.machine.bodies.down[i] - s->acceleration_mps2[i];
    ode_machine_pull(&e->machine, pull);
    e->model.machine.supply.pressure_pa = surroundings_supply(s);
}

static void substep(struct engine *base, double dt_s, const double valve[LEGS], struct hydraulics_state *s) {
    struct engine_ode *e = (struct engine_ode *)base;
    double force_n[LEGS];
    e->hydraulic = true;
    look_at_legs(e, s);
    for (int i = 0; i < LEGS; i++) force_n[i] = cylinder_hydraulic_force(&e->model, i, &s->cylinder[i]);
    step_bodies(e, dt_s, force_n);
    if (surroundings_yield(e->surroundings.params)) yield(e, dt_s);
    step_hydraulics(e, dt_s, valve, s);
}

static const struct hydraulics_state no_pressure;

static void forced(struct engine *base, double dt_s, const double force_n[LEGS]) {
    struct engine_ode *e = (struct engine_ode *)base;
    double mean_n[LEGS];
    e->hydraulic = false;
    look_at_legs(e, &no_pressure);
    for (int i = 0; i < LEGS; i++) {
        mean_n[i] = e->started ? 0.5 * (e->held_n[i] + force_n[i]) : force_n[i];
        e->held_n[i] = force_n[i];
    }
    step_bodies(e, dt_s, mean_n);
}

static void place(struct engine *base, const double pose[DOFS], const double ahead_m[LEGS]) {
    static const struct velocity rest = {0};
    struct engine_ode *e = (struct engine_ode *)base;
    memcpy(e->pose, pose, sizeof e->pose);
    memcpy(e->ahead_m, ahead_m, sizeof e->ahead_m);
    e->started = e->hydraulic = false;
    ode_machine_place(&e->machine, pose, ahead_m);
    for (int b = 0; b < BODIES; b++) {
        ode_machine_set_velocity(&e->machine, b, &rest, 0.0);
        e->before[b] = rest;
    }
    look_at_legs(e, &no_pressure);
    for (int i = 0; i < LEGS; i++) {
        e->motor_n[i] = 0.0;
        e->stuck[i] = e->leg[i].holding_n > 0.0;
    }
}

static double kinetic_energy(const struct engine_ode *e, int body) {
    struct velocity v = velocity_now(e, body);
    dVector3 omega, spin;
    dMass mass;
    dBodyGetMass(e->machine.body[body], &mass);
    dBodyVectorFromWorld(e->machine.body[body], v.angular[0], v.angular[1], v.angular[2], omega);
    dMultiply0_331(spin, mass.I, omega);
    return 0.5 * (mass.mass * dCalcVectorDot3(v.linear, v.linear) + dCalcVectorDot3(omega, spin));
}

static void truth(const struct engine *base, const struct hydraulics_state *s, struct plant_truth *truth) {
    const struct engine_ode *e = (const struct engine_ode *)base;
    struct velocity platform = velocity_now(e, PLATFORM);
    ode_machine_pose(&e->machine, truth->pose);
    ode_machine_twist(&platform, &e->machine, truth->twist);
    for (int i = 0; i < LEGS; i++) {
        struct leg leg = leg_now(e, i, s);
        truth->length_m[i] = leg.length_m;
        truth->rate_mps[i] = leg.rate_mps;
        truth->friction_n[i] = leg.passive_n + e->motor_n[i];
        truth->stuck[i] = e->stuck[i];
    }
    truth->kinetic_j = 0.0;
    for (int b = 0; b < BODIES; b++) truth->kinetic_j += kinetic_energy(e, b);
    truth->potential_j = ode_machine_potential(&e->machine);
}

static void supply(struct engine *base, double share) { ((struct engine_ode *)base)->model.supply_share = share; }

/* Refuses legs whose parts have too little mass or inertia, because ODE's assertions would fail.
 * The closed-form engine accepts legs without mass. */
static int bodies_check(const struct params *params, struct error *error) {
    struct machine m;
    machine_init(&m, params);
    for (int k = 0; k < LEGS; k++) {
        const struct {
            const char *key;
            double value;
        } parts[] = {{"upper_mass_kg", m.bodies.upper_kg[k]},
                     {"lower_mass_kg", m.bodies.lower_kg[k]},
                     {"upper_inertia_kg_m2", params->actuator.upper_inertia_kg_m2[k]},
                     {"lower_inertia_kg_m2", params->actuator.lower_inertia_kg_m2[k] + m.bodies.transverse_kg_m2[k]}};
        for (int i = 0; i < 4; i++)
            if (!(parts[i].value >= LEAST_BODY))
                return error_set(error, STATUS_USAGE,
                                 "actuator.%s of leg %d is %g with all effects: sim.engine ode needs %g or more; give it that, or set "
                                 "sim.engine to closed_form, which takes legs without mass",
                                 parts[i].key, k + 1, parts[i].value, LEAST_BODY);
    }
    return STATUS_OK;
}

static struct engine *create(const struct params *params, struct error *error) {
    static const double neutral[DOFS] = {0}, level[LEGS] = {0};
    if (bodies_check(params, error)) return NULL;
    struct engine_ode *e = calloc(1, sizeof *e);
    if (!e || ode_machine_init(&e->machine, params) < 0) {
        free(e);
        error_set(error, STATUS_IO, "sim.engine ode: no memory for ODE's world, or no body has the masses and inertias (effects)");
        return NULL;
    }
    e->base.ops = &engine_ode;
    cylinder_model_init(&e->model, params);
    e->surroundings.params = params;
    e->joints_rub = e->model.machine.joint_friction.count > 0;
    place(&e->base, neutral, level);
    return &e->base;
}

static void destroy(struct engine *base) {
    struct engine_ode *e = (struct engine_ode *)base;
    ode_machine_free(&e->machine);
    free(e);
}

const struct engine_ops engine_ode = {.name = "ode",
                                      .create = create,
                                      .destroy = destroy,
                                      .place = place,
                                      .substep = substep,
                                      .forced = forced,
                                      .supply = supply,
                                      .truth = truth};
