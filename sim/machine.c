#include "machine.h"

#include <math.h>
#include <string.h>

#include "engine.h"
#include "params.h"

static const double FLANK_RADPS = 2500.0, FLANK_DAMPING = 0.25; /* natural frequency and damping
                                                                 * ratio of a rod on its flank */

static void base_bodies(struct machine *m, const struct params *params) {
    const struct payload_params *p = &params->payload;
    struct sim_geometry g;
    sim_geometry_init(&g, params);
    m->bodies.payload_kg = p->mass_kg;
    m->bodies.payload_inertia_kg_m2[0] = p->inertia_xx_kg_m2;
    m->bodies.payload_inertia_kg_m2[1] = p->inertia_yy_kg_m2;
    m->bodies.payload_inertia_kg_m2[2] = p->inertia_zz_kg_m2;
    m->bodies.payload_products_kg_m2[0] = p->inertia_xy_kg_m2;
    m->bodies.payload_products_kg_m2[1] = p->inertia_xz_kg_m2;
    m->bodies.payload_products_kg_m2[2] = p->inertia_yz_kg_m2;
    m->bodies.gravity_mps2 = p->gravity_mps2;
    m->bodies.down[2] = 1.0;
    memcpy(m->bodies.upper_joint_m, g.upper, sizeof g.upper);
    memcpy(m->bodies.lower_joint_m, g.lower, sizeof g.lower);
    for (int leg = 0; leg < LEGS; leg++) {
        m->bodies.neutral_length_m[leg] = g.neutral_length_m[leg];
        m->bodies.middle_length_m[leg] = g.neutral_length_m[leg] + params->actuator.mid_stroke_m[leg];
        m->bodies.upper_kg[leg] = params->actuator.upper_mass_kg[leg];
        m->bodies.lower_kg[leg] = params->actuator.lower_mass_kg[leg];
    }
    const struct mechanism *mechanism = params_mechanism(params);
    if (mechanism->constants) mechanism->constants(params, m);
}

static void base_hydraulics(struct machine *m, const struct hydraulics_params *h) {
    m->supply.pressure_pa = h->supply_pa;
    m->supply.tank_pa = h->tank_pa;
    for (int leg = 0; leg < LEGS; leg++) {
        m->oil.bulk_modulus_pa[leg] = h->bulk_modulus_pa[leg];
        m->oil.leakage_m3_per_s_pa[leg] = h->leakage_m3_per_s_pa[leg];
        m->valve.frequency_hz[leg] = h->valve_frequency_hz;
        m->valve.rate_per_s[leg] = (double)INFINITY;
        m->valve.flow_scale[leg] = m->valve.port_ratio[leg] = 1.0;
        m->hose.length_m[leg] = h->pipe_length_m;
        m->hose.diameter_m[leg] = h->pipe_bore_m;
    }
}

static void base_sensors(struct machine *m) {
    const struct sensor_path exact = {.scale = 1.0};
    for (int leg = 0; leg < LEGS; leg++) m->sensors.length[leg] = m->sensors.p1[leg] = m->sensors.p2[leg] = m->sensors.force[leg] = exact;
    for (int leg = 0; leg < LEGS; leg++) m->sensors.force[leg].lag_s = m->params->axis.force_lag_s;
    m->timing.clock_ratio = 1.0;
}

void machine_add_errors(struct machine *m, const struct sensor_errors *e) {
    for (int k = 0; k < LEGS; k++) {
        double lag_s = e->lag_s + e->lag_rest_s[k];
        m->sensors.p1[k].scale *= 1.0 + e->p1_gain[k];
        m->sensors.force[k].scale *= 1.0 + e->p1_gain[k];
        m->sensors.p2[k].scale *= 1.0 + e->p2_gain[k];
        m->sensors.p1[k].lag_s += lag_s;
        m->sensors.p2[k].lag_s += lag_s;
        m->sensors.force[k].lag_s += lag_s;
        double gain = m->sensors.length[k].scale * e->length_gain[k];
        m->sensors.length[k].scale += gain;
        m->sensors.length[k].offset += e->length_zero_m[k] - gain * m->bodies.neutral_length_m[k];
        m->sensors.length[k].delay_s += fmax(e->skew_s, 0.0);
        m->sensors.p1[k].delay_s += fmax(-e->skew_s, 0.0);
        m->sensors.p2[k].delay_s += fmax(-e->skew_s, 0.0);
        m->sensors.force[k].delay_s += fmax(-e->skew_s, 0.0);
    }
}

static void add(struct active *list, const struct effect *effect, const struct effect_values *values) {
    list->of[list->count].effect = effect;
    list->of[list->count++].values = values;
}

static void apply(struct machine *m, const struct effect *e, const struct effect_values *values) {
    if (e->machine) e->machine(values, m);
    if (e->leg_friction) add(&m->leg_friction, e, values);
    if (e->joint_friction) add(&m->joint_friction, e, values);
    if (e->wrench) add(&m->wrench, e, values);
    if (e->opening) add(&m->opening, e, values);
    if (e->command) add(&m->command, e, values);
}

void machine_init(struct machine *m, const struct params *params) {
    memset(m, 0, sizeof *m);
    m->params = params;
    base_bodies(m, params);
    base_hydraulics(m, &params->hydraulics);
    base_sensors(m);
    for (int i = 0; effect_table[i]; i++)
        if (params->effects[i].on) apply(m, effect_table[i], &params->effects[i]);
    machine_add_errors(m, &params->errors);
}

/* Returns true if the inertia matrix is positive definite, by its leading minors. */
static bool turns(const double square[3], const double product[3]) {
    double xx = square[0], yy = square[1], zz = square[2], xy = product[0], xz = product[1], yz = product[2];
    double determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    return xx > 0.0 && xx * yy - xy * xy > 0.0 && determinant > 0.0;
}

/* Returns true if the viscous friction at 1 m/s in this direction is negative, so that it would
 * drive the leg. */
static bool drives(const struct machine *m, int leg, int direction) {
    const struct leg_motion motion = {.speed_mps = 1.0, .direction = direction};
    struct friction sum = {.viscous = m->params->hydraulics.viscous_n_s_per_m[leg]};
    for (int i = 0; i < m->leg_friction.count; i++)
        m->leg_friction.of[i].effect->leg_friction(m->leg_friction.of[i].values, leg, &motion, &sum);
    return sum.viscous < 0.0;
}

int machine_check(const struct machine *m, struct error *error) {
    bool payload = m->bodies.payload_kg > 0.0 && turns(m->bodies.payload_inertia_kg_m2, m->bodies.payload_products_kg_m2);
    if (!payload) return error_set(error, STATUS_USAGE, "effects leave no mass or no inertia of the payload: make them smaller");
    for (int k = 0; k < LEGS; k++)
        if (m->bodies.upper_kg[k] < 0.0 || m->bodies.lower_kg[k] < 0.0 ||
            m->params->actuator.lower_inertia_kg_m2[k] + m->bodies.transverse_kg_m2[k] < 0.0)
            return error_set(error, STATUS_USAGE, "effects leave less than no mass or inertia of leg %d: make them smaller", k + 1);
    for (int k = 0; k < LEGS; k++)
        if (drives(m, k, 1) || drives(m, k, -1))
            return error_set(error, STATUS_USAGE, "effects leave less than no viscous friction of leg %d: make them smaller", k + 1);
    return 0;
}

struct friction machine_joint_friction(const struct machine *m, int leg, double speed_radps) {
    struct friction sum = {0};
    for (int i = 0; i < m->joint_friction.count; i++)
        m->joint_friction.of[i].effect->joint_friction(m->joint_friction.of[i].values, leg, speed_radps, &sum);
    return sum;
}

bool machine_has_play(const struct machine *m, int leg) { return params_mechanism(m->params)->pose && m->bodies.clearance_m[leg] > 0.0; }

double machine_flank(const struct machine *m, int leg) { return m->bodies.upper_kg[leg] * FLANK_RADPS * FLANK_RADPS; }

double machine_contact(const struct machine *m, int leg, double ahead_m, double ahead_mps) {
    double deep_m = fabs(ahead_m) - 0.5 * m->bodies.clearance_m[leg], side = copysign(1.0, ahead_m);
    if (!(deep_m > 0.0)) return 0.0;
    double push_n = machine_flank(m, leg) * (deep_m + 2.0 * FLANK_DAMPING / FLANK_RADPS * side * ahead_mps);
    return push_n > 0.0 ? side * push_n : 0.0;
}

double machine_ahead(const struct machine *m, int leg, double contact_n) {
    if (!machine_has_play(m, leg)) return 0.0;
    return copysign(0.5 * m->bodies.clearance_m[leg] + fabs(contact_n) / machine_flank(m, leg), contact_n);
}

void machine_wrench(const struct machine *m, const double pose[DOFS], double wrench[DOFS]) {
    for (int i = 0; i < m->wrench.count; i++) m->wrench.of[i].effect->wrench(m->wrench.of[i].values, pose, wrench);
}

double machine_opening(const struct machine *m, int leg, double spool) {
    for (int i = 0; i < m->opening.count; i++) spool = m->opening.of[i].effect->opening(m->opening.of[i].values, leg, spool);
    return spool;
}
