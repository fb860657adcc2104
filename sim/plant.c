#include "plant.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine.h"
#include "params.h"
#include "power_unit.h"
#include "resolution.h"
#include "rigid.h"
#include "sensors.h"
#include "valve_line.h"
#include "vec.h"

struct plant {
    const struct params *params;
    struct cylinder_model cylinder;
    struct rigid_model rigid; /* rigid bodies, used only for the static balance */
    struct engine *engine;
    struct sensors sensors;
    struct valve_line valve_line;
    struct hydraulics_state state;
    struct power_unit power_unit;
    bool has_power_unit, life_sign;
    uint64_t cycles;          /* number of cycles so far; counting avoids rounding errors of the
                               * time */
    double forced_s;          /* sum of the times of all calls of plant_step_forced() */
};

static const struct engine_ops *const engines[] = {[ENGINE_ODE] = &engine_ode, [ENGINE_CLOSED_FORM] = &engine_closed_form};

static double substep_s(const struct plant *plant) { return plant->params->loop.period_s / plant->params->sim.substeps; }

static struct cylinder_state drained(const struct plant *plant) {
    double tank = plant->params->hydraulics.tank_pa;
    return (struct cylinder_state){.p1_pa = tank, .p2_pa = tank};
}

/* Computes the load on each end stop: the holding force of the leg less the push of tank pressure.
 * Returns false if the legs cannot hold the platform. */
static bool stop_loads(const struct plant *plant, const double pose[DOFS], double load_n[LEGS]) {
    struct cylinder_state tank = drained(plant);
    bool possible = rigid_holding_forces(&plant->rigid, pose, load_n);
    for (int k = 0; k < LEGS; k++) load_n[k] -= cylinder_hydraulic_force(&plant->cylinder, k, &tank);
    return possible;
}

/* Finds the distance of each rod with backlash ahead of its joint at rest; 0 without backlash. */
static void rest_ahead(const struct plant *plant, const double pose[DOFS], double ahead_m[LEGS]) {
    struct rigid_state s;
    struct rigid_legs legs;
    double holding_n[LEGS];
    rigid_rest(&s, pose);
    rigid_legs(&plant->rigid, &s, &legs);
    rigid_holding_forces(&plant->rigid, pose, holding_n);
    for (int k = 0; k < LEGS; k++) {
        double contact_n = holding_n[k] - rigid_rod_force(&plant->rigid, &legs, k, legs.length[k], 0.0);
        ahead_m[k] = machine_ahead(&plant->cylinder.machine, k, contact_n);
    }
}

/* Finds the pose at rest on the lower end stops by Newton's method on the lengths at which each
 * stop carries its load. Returns false if no pose of the machine has these lengths. */
static bool settled_pose(const struct plant *plant, double pose[DOFS]) {
    double stiffness = plant->params->hydraulics.stop_stiffness_n_per_m;
    for (int iteration = 0; iteration < 100; iteration++) {
        struct rigid_state s;
        struct rigid_legs legs;
        struct factor6 square = {0};
        double load[LEGS], ahead[LEGS], row[LEGS][DOFS], step[DOFS] = {0};
        rigid_rest(&s, pose);
        rigid_legs(&plant->rigid, &s, &legs);
        if (!stop_loads(plant, pose, load)) return false;
        rest_ahead(plant, pose, ahead);
        for (int k = 0; k < LEGS; k++) {
            rigid_row(&legs, k, row[k]);
            add6(plant->cylinder.leg[k].length_min_m - fmax(load[k], 0.0) / stiffness - ahead[k] - legs.length[k], row[k], step);
            for (int i = 0; i < DOFS; i++) add6(row[k][i], row[k], square.c[i]);
        }
        factor6(&square); /* step = (J'J)^-1 J' error */
        whiten6(&square, step);
        unwhiten6(&square, step);
        for (int i = 0; i < DOFS; i++) pose[i] += step[i];
        double size = sqrt(dot6(step, step));
        if (size < 1e-13) return true;
        if (!(size < 10.0)) return false;
    }
    return false;
}

/* Collects the exact values that the sensors read. */
static void exact_values(const struct plant *plant, struct exact *exact) {
    struct plant_truth truth;
    const struct hydraulics_state *s = &plant->state;
    plant->engine->ops->truth(plant->engine, s, &truth);
    for (int k = 0; k < LEGS; k++) {
        bool hose = plant->cylinder.leg[k].hose_volume_m3 > 0.0;
        exact->length_m[k] = truth.length_m[k];
        exact->p1_pa[k] = hose ? s->hose[k][PORT_A].pressure_pa : s->cylinder[k].p1_pa;
        exact->p2_pa[k] = hose ? s->hose[k][PORT_B].pressure_pa : s->cylinder[k].p2_pa;
    }
}

/* Puts the plant at rest in a pose, with its present chamber pressures, as if it had been at rest
 * for so long that no part remembers an earlier motion. */
static void rest(struct plant *plant, const double pose[DOFS]) {
    struct exact exact;
    double ahead_m[LEGS];
    hydraulics_rest(&plant->state);
    rest_ahead(plant, pose, ahead_m);
    plant->engine->ops->place(plant->engine, pose, ahead_m);
    exact_values(plant, &exact);
    sensors_rest(&plant->sensors, &exact);
    valve_line_rest(&plant->valve_line);
}

static int settle(struct plant *plant, struct error *error) {
    double pose[DOFS] = {0}, load[LEGS];
    if (!settled_pose(plant, pose) || !stop_loads(plant, pose, load))
        return error_set(error, STATUS_USAGE, "the platform cannot come down to its end stops: check actuator.stroke_m and geometry");
    for (int k = 0; k < LEGS; k++)
        if (load[k] < 0.0)
            return error_set(error, STATUS_USAGE,
                             "the platform does not rest on the end stop of leg %d: check payload, geometry and "
                             "hydraulics.tank_pa",
                             k + 1);
    for (int k = 0; k < LEGS; k++) plant->state.cylinder[k] = drained(plant);
    rest(plant, pose);
    return resolution_check(&plant->cylinder, &plant->rigid, pose, substep_s(plant), error);
}

/* Returns dt^2 times the stiffness plus dt times the damping of the fastest oscillation of a rod,
 * kg. With backlash the rod swings between the oil, at its stiffest, and a flank, damped by viscous
 * friction. The seals' stiffness always counts; it doubles after a reversal, which the factor of
 * two in rods_resolved() covers. */
static double rings_kg(const struct plant *plant, int leg) {
    const struct machine *m = &plant->cylinder.machine;
    const struct cylinder_leg *c = &plant->cylinder.leg[leg];
    double dt_s = substep_s(plant), drag = plant->params->hydraulics.viscous_n_s_per_m[leg];
    double seals = m->seals.stiffness_n_per_m[leg], oil = fmax(cylinder_stiffness(&plant->cylinder, leg, c->length_min_m),
                                                               cylinder_stiffness(&plant->cylinder, leg, c->length_max_m));
    bool play = machine_has_play(m, leg);
    return dt_s * (dt_s * ((play ? oil + machine_flank(m, leg) : 0.0) + seals) + (play ? drag : 0.0));
}

/* Refuses a leg that moves too small a mass for the substeps: the mass of the rod plus, without
 * backlash, a sixth of the payload. The engines are stable down to half of the mass demanded
 * here. */
static int rods_resolved(const struct plant *plant, struct error *error) {
    const struct machine *m = &plant->cylinder.machine;
    for (int k = 0; k < LEGS; k++) {
        bool play = machine_has_play(m, k);
        double mass = m->bodies.upper_kg[k] + (play ? 0.0 : m->bodies.payload_kg / LEGS);
        if (!(rings_kg(plant, k) <= 2.0 * mass))
            return error_set(error, STATUS_USAGE,
                             "%s: what leg %d moves, %g kg, is too light for substeps of %g ms: raise sim.substeps or %s",
                             play ? "joint_backlash" : "cylinder_dahl_friction", k + 1, mass, 1e3 * substep_s(plant),
                             play ? "actuator.upper_mass_kg" : "distance_m");
    }
    return 0;
}

struct plant *plant_create(const struct params *params, uint64_t seed, struct error *error) {
    struct plant *plant = calloc(1, sizeof *plant);
    if (!plant) {
        error_set(error, STATUS_IO, "no memory for the simulated machine");
        return NULL;
    }
    plant->params = params;
    cylinder_model_init(&plant->cylinder, params);
    rigid_model_init(&plant->rigid, params);
    const struct machine *machine = &plant->cylinder.machine;
    valve_line_init(&plant->valve_line, machine);
    if (sensors_init(&plant->sensors, machine, seed) < 0) error_set(error, STATUS_IO, "no memory for the simulated machine's delays");
    else if (machine_check(machine, error) == 0 && rods_resolved(plant, error) == 0)
        plant->engine = engines[params->sim.engine]->create(params, error);
    if (plant->engine && settle(plant, error) == 0) return plant;
    plant_destroy(plant);
    return NULL;
}

void plant_destroy(struct plant *plant) {
    if (!plant) return;
    if (plant->engine) plant->engine->ops->destroy(plant->engine);
    sensors_free(&plant->sensors);
    free(plant);
}

/* Returns chamber pressures for a leg force: P1 at half the supply, or the nearest that keeps P2
 * between tank and supply. */
static struct cylinder_state holding_state(const struct cylinder_model *m, int leg, double force_n) {
    struct mains mains = cylinder_mains(m);
    double a1_m2 = m->leg[leg].a1_m2, a2_m2 = m->leg[leg].a2_m2;
    double p1 = 0.5 * mains.supply_pa;
    double p2 = fmin(fmax((a1_m2 * p1 - force_n) / a2_m2, mains.tank_pa), mains.supply_pa);
    return (struct cylinder_state){.p1_pa = (force_n + a2_m2 * p2) / a1_m2, .p2_pa = p2};
}

void plant_place(struct plant *plant, const double pose[DOFS]) {
    double force[LEGS];
    bool possible = rigid_holding_forces(&plant->rigid, pose, force);
    assert(possible);
    (void)possible;
    for (int k = 0; k < LEGS; k++) plant->state.cylinder[k] = holding_state(&plant->cylinder, k, force[k]);
    rest(plant, pose);
}

/* Limits a command to -1..1. NaN counts as no signal, at which a valve amplifier centres its
 * valve. */
static double command(double valve) {
    if (isnan(valve)) return 0.0;
    return fmin(fmax(valve, -1.0), 1.0);
}

static void follow(struct plant *plant) {
    struct exact exact;
    exact_values(plant, &exact);
    sensors_follow(&plant->sensors, substep_s(plant), &exact);
}

void plant_add_power_unit(struct plant *plant, double hold_s) {
    power_unit_init(&plant->power_unit, hold_s);
    plant->has_power_unit = true;
    plant->engine->ops->supply(plant->engine, 0.0);
}

void plant_life_sign(struct plant *plant, bool level) { plant->life_sign = level; }

static void power(struct plant *plant) {
    power_unit_step(&plant->power_unit, plant->life_sign, plant->params->loop.period_s);
    plant->engine->ops->supply(plant->engine, plant->power_unit.share);
}

void plant_step(struct plant *plant, const double valve[LEGS]) {
    double dt_s = substep_s(plant), clamped[LEGS];
    for (int k = 0; k < LEGS; k++) clamped[k] = command(valve[k]);
    valve_line_send(&plant->valve_line, clamped);
    if (plant->has_power_unit) power(plant);
    for (int i = 0; i < plant->params->sim.substeps; i++) {
        double arrived[LEGS];
        valve_line_receive(&plant->valve_line, i, arrived);
        plant->engine->ops->substep(plant->engine, dt_s, arrived, &plant->state);
        if (plant->sensors.history) follow(plant);
    }
    plant->cycles++;
}

void plant_step_forced(struct plant *plant, double dt_s, const double force_n[LEGS]) {
    plant->engine->ops->forced(plant->engine, dt_s, force_n);
    plant->forced_s += dt_s;
}

void plant_measure(struct plant *plant, struct hal_sample *sample) {
    struct exact exact, reading;
    exact_values(plant, &exact);
    sensors_read(&plant->sensors, substep_s(plant), &exact, &reading);
    memcpy(sample->length_m, reading.length_m, sizeof sample->length_m);
    memcpy(sample->p1_pa, reading.p1_pa, sizeof sample->p1_pa);
    memcpy(sample->p2_pa, reading.p2_pa, sizeof sample->p2_pa);
    bool pressure = !plant->has_power_unit || plant->power_unit.pressure;
    sample->inputs = pressure ? INPUTS_ALL : INPUTS_ALL & ~(uint32_t)INPUT_SUPPLY;
}

double plant_clock_ratio(const struct plant *plant) { return plant->cylinder.machine.timing.clock_ratio; }

void plant_get_truth(const struct plant *plant, struct plant_truth *truth) {
    plant->engine->ops->truth(plant->engine, &plant->state, truth);
    truth->time_s = (double)plant->cycles * plant->params->loop.period_s + plant->forced_s;
    for (int k = 0; k < LEGS; k++) {
        truth->p1_pa[k] = plant->state.cylinder[k].p1_pa;
        truth->p2_pa[k] = plant->state.cylinder[k].p2_pa;
        truth->spool[k] = plant->state.cylinder[k].spool;
        truth->hydraulic_n[k] = cylinder_hydraulic_force(&plant->cylinder, k, &plant->state.cylinder[k]);
    }
}
