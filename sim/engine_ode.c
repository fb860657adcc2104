/* The ODE engine: bodies first, then the hydraulics over the motion just found.
 *
 * Time. ODE's semi-implicit Euler is used as the leapfrog it is: positions and pressures belong to the substep's ends, velocities to its
 * middle. That makes it second order, if each force is the one at the substep's start, halfway between two velocities:
 *   of position and pressure  as they are;
 *   of velocity               at the velocity extrapolated by half a substep, v + (v - v_before) / 2;
 *   held over substeps        the mean of this substep's and the one's before;
 *   and from rest             the velocities start half a substep before the positions (start()).
 * With the velocity as it is the engine would be of first order: viscous friction b would take dt/2 J'bJ from the inertia, 0.44 % of mz and
 * 0.54 % of Ixx at 0.25 ms. All substeps after a place() are to be of one length; dry friction is of first order at its reversals.
 *
 * Stick is part of ODE's complementarity problem: a leg is stuck when its motor needed less than its limit. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ode_machine.h"

/* A leg at an instant and what resists its motion. Forces act on the rod, away from the base positive. */
struct leg {
    dVector3 axis;
    double length_m, rate_mps;
    double passive_n; /* viscous, end stop, middle of the dry friction's range */
    double holding_n; /* half of that range: the motor's limit */
};

struct engine_ode {
    struct engine base;
    const struct params *params;
    struct cylinder_model model;
    struct ode_machine machine;
    bool joints_rub;
    double pose[DOFS];              /* of the last place() */
    bool started;                   /* a substep has been made since */
    struct velocity before[BODIES]; /* one substep ago */
    bool viscous;                   /* the cylinders' viscous friction counts: not when forced */
    double held_n[LEGS];            /* forced: of the substep before */
    struct leg leg[LEGS];           /* at the start of the substep */
    double motor_n[LEGS];           /* the rest of the dry friction */
    bool stuck[LEGS];
};

/* At the present positions: half a substep after ODE's. */
static struct velocity velocity_now(const struct engine_ode *e, int body) {
    struct velocity v = ode_machine_velocity(&e->machine, body);
    for (int k = 0; k < 3; k++) {
        v.linear[k] += 0.5 * (v.linear[k] - e->before[body].linear[k]);
        v.angular[k] += 0.5 * (v.angular[k] - e->before[body].angular[k]);
    }
    return v;
}

/* One of the two directions has speed, the other meets the leg should it turn round: a sliding force is exact, and so is the range of
 * forces that hold. */
static struct leg leg_now(const struct engine_ode *e, int i, const struct cylinder_state *s) {
    struct leg leg;
    struct velocity rod = velocity_now(e, ROD + i), cylinder = velocity_now(e, CYLINDER + i);
    ode_machine_axis(&e->machine, i, leg.axis);
    leg.length_m = ode_machine_length(&e->machine, i, leg.axis);
    leg.rate_mps = dCalcVectorDot3(rod.linear, leg.axis) - dCalcVectorDot3(cylinder.linear, leg.axis);
    struct friction extend = cylinder_friction(&e->model, i, s, 1, leg.rate_mps > 0.0 ? leg.rate_mps : 0.0);
    struct friction retract = cylinder_friction(&e->model, i, s, -1, leg.rate_mps < 0.0 ? -leg.rate_mps : 0.0);
    leg.passive_n = cylinder_stop_force(&e->model, leg.length_m, leg.rate_mps) + 0.5 * (retract.dry - extend.dry);
    if (e->viscous) leg.passive_n += retract.viscous - extend.viscous;
    leg.holding_n = 0.5 * (extend.dry + retract.dry);
    return leg;
}

static void look_at_legs(struct engine_ode *e, const struct cylinder_state cylinder[LEGS]) {
    for (int i = 0; i < LEGS; i++) {
        e->leg[i] = leg_now(e, i, &cylinder[i]);
        dJointSetPistonParam(e->machine.piston[i], dParamFMax, e->leg[i].holding_n);
    }
}

/* Both mass centres lie on the leg's axis: no moment. */
static void push_leg(struct engine_ode *e, int i, double force_n) {
    const double *n = e->leg[i].axis;
    dBodyAddForce(e->machine.body[ROD + i], force_n * n[0], force_n * n[1], force_n * n[2]);
    dBodyAddForce(e->machine.body[CYLINDER + i], -force_n * n[0], -force_n * n[1], -force_n * n[2]);
}

/* omega: of the motor's first body against its second. */
static void rub_joint(struct engine_ode *e, int leg, dJointID motor, const dVector3 omega) {
    double moment[2];
    for (int k = 0; k < 2; k++) {
        dVector3 axis;
        dJointGetAMotorAxis(motor, k, axis);
        double rate = dCalcVectorDot3(omega, axis);
        struct friction friction = joint_friction(e->params, leg, fabs(rate));
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
    if (e->joints_rub) rub_joints(e);
    for (int b = 0; b < BODIES; b++) e->before[b] = ode_machine_velocity(&e->machine, b);
    dWorldStep(e->machine.world, dt_s);
}

/* A trial step tells what a substep adds to the velocities; half of it belongs before the start. */
static void start(struct engine_ode *e, double dt_s, const double force_n[LEGS]) {
    kick(e, dt_s, force_n);
    ode_machine_place(&e->machine, e->pose);
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
        e->stuck[i] = fabs(e->motor_n[i]) < limit_n * (1.0 - 1e-9); /* the solver sets a sliding motor to its limit, but for rounding */
    }
}

static struct cylinder_state moved(const struct cylinder_state *s, const struct cylinder_state *rate, double dt_s) {
    return (struct cylinder_state){.p1_pa = s->p1_pa + dt_s * rate->p1_pa,
                                   .p2_pa = s->p2_pa + dt_s * rate->p2_pa,
                                   .spool = s->spool + dt_s * rate->spool,
                                   .spool_rate = s->spool_rate + dt_s * rate->spool_rate};
}

/* Runge-Kutta of fourth order while the leg moves from one length to the other. */
static void step_hydraulics(const struct cylinder_model *m, struct cylinder_state *s, double dt_s, double from_m, double to_m, double valve) {
    double rate_mps = (to_m - from_m) / dt_s, middle_m = 0.5 * (from_m + to_m);
    struct cylinder_state k1 = cylinder_derivative(m, s, from_m, rate_mps, valve), at = moved(s, &k1, 0.5 * dt_s);
    struct cylinder_state k2 = cylinder_derivative(m, &at, middle_m, rate_mps, valve);
    at = moved(s, &k2, 0.5 * dt_s);
    struct cylinder_state k3 = cylinder_derivative(m, &at, middle_m, rate_mps, valve);
    at = moved(s, &k3, dt_s);
    struct cylinder_state k4 = cylinder_derivative(m, &at, to_m, rate_mps, valve);
    *s = moved(s, &k1, dt_s / 6.0);
    *s = moved(s, &k2, dt_s / 3.0);
    *s = moved(s, &k3, dt_s / 3.0);
    *s = moved(s, &k4, dt_s / 6.0);
}

static void substep(struct engine *base, double dt_s, const double valve[LEGS], struct cylinder_state cylinder[LEGS]) {
    struct engine_ode *e = (struct engine_ode *)base;
    double force_n[LEGS];
    e->viscous = true;
    look_at_legs(e, cylinder);
    for (int i = 0; i < LEGS; i++) force_n[i] = cylinder_hydraulic_force(&e->model, &cylinder[i]);
    step_bodies(e, dt_s, force_n);
    for (int i = 0; i < LEGS; i++) {
        dVector3 axis;
        ode_machine_axis(&e->machine, i, axis);
        step_hydraulics(&e->model, &cylinder[i], dt_s, e->leg[i].length_m, ode_machine_length(&e->machine, i, axis), valve[i]);
    }
}

static const struct cylinder_state no_pressure[LEGS];

static void forced(struct engine *base, double dt_s, const double force_n[LEGS]) {
    struct engine_ode *e = (struct engine_ode *)base;
    double mean_n[LEGS];
    e->viscous = false;
    look_at_legs(e, no_pressure);
    for (int i = 0; i < LEGS; i++) {
        mean_n[i] = e->started ? 0.5 * (e->held_n[i] + force_n[i]) : force_n[i];
        e->held_n[i] = force_n[i];
    }
    step_bodies(e, dt_s, mean_n);
}

static void place(struct engine *base, const double pose[DOFS]) {
    static const struct velocity rest = {0};
    struct engine_ode *e = (struct engine_ode *)base;
    memcpy(e->pose, pose, sizeof e->pose);
    e->started = false;
    ode_machine_place(&e->machine, pose);
    for (int b = 0; b < BODIES; b++) {
        ode_machine_set_velocity(&e->machine, b, &rest, 0.0);
        e->before[b] = rest;
    }
    look_at_legs(e, no_pressure);
    for (int i = 0; i < LEGS; i++) {
        e->motor_n[i] = 0.0;
        e->stuck[i] = e->leg[i].holding_n > 0.0;
    }
}

static double kinetic_energy(const struct engine_ode *e, int body) {
    struct velocity v = velocity_now(e, body);
    dVector3 omega;
    dMass mass;
    dBodyGetMass(e->machine.body[body], &mass);
    dBodyVectorFromWorld(e->machine.body[body], v.angular[0], v.angular[1], v.angular[2], omega);
    double turning = mass.I[0] * omega[0] * omega[0] + mass.I[5] * omega[1] * omega[1] + mass.I[10] * omega[2] * omega[2];
    return 0.5 * (mass.mass * dCalcVectorDot3(v.linear, v.linear) + turning);
}

static void truth(const struct engine *base, const struct cylinder_state cylinder[LEGS], struct plant_truth *truth) {
    const struct engine_ode *e = (const struct engine_ode *)base;
    struct velocity platform = velocity_now(e, PLATFORM);
    ode_machine_pose(&e->machine, truth->pose);
    memcpy(truth->twist, platform.linear, 3 * sizeof(double));
    memcpy(truth->twist + 3, platform.angular, 3 * sizeof(double));
    for (int i = 0; i < LEGS; i++) {
        struct leg leg = leg_now(e, i, &cylinder[i]);
        truth->length_m[i] = leg.length_m;
        truth->rate_mps[i] = leg.rate_mps;
        truth->friction_n[i] = leg.passive_n + e->motor_n[i];
        truth->stuck[i] = e->stuck[i];
    }
    truth->kinetic_j = 0.0;
    for (int b = 0; b < BODIES; b++) truth->kinetic_j += kinetic_energy(e, b);
    truth->potential_j = ode_machine_potential(&e->machine);
}

static struct engine *create(const struct params *params, struct error *error) {
    static const double neutral[DOFS] = {0};
    struct engine_ode *e = calloc(1, sizeof *e);
    if (!e || ode_machine_init(&e->machine, params) < 0) {
        free(e);
        error_set(error, STATUS_IO, "sim.engine ode: no memory for ODE's world");
        return NULL;
    }
    e->base.ops = &engine_ode;
    e->params = params;
    e->joints_rub = joint_friction_present(params);
    cylinder_model_init(&e->model, params);
    place(&e->base, neutral);
    return &e->base;
}

static void destroy(struct engine *base) {
    struct engine_ode *e = (struct engine_ode *)base;
    ode_machine_free(&e->machine);
    free(e);
}

const struct engine_ops engine_ode = {
    .name = "ode", .create = create, .destroy = destroy, .place = place, .substep = substep, .forced = forced, .truth = truth};
