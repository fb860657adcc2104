#include "cylinder.h"

#include <math.h>

#include "engine.h"
#include "units.h"

static const double LAMINAR_PA = 1e4;
static const double FILL_TIME_S = 2e-4; /* shortest time constant of a chamber: even explicit Euler settles in a substep of 0.25 ms */
static const double MAKE_UP_TIME_S = 1e-3;
static const double VACUUM_PA = -101325.0;
static const double SOFTEST = 0.01;        /* beta of the gas that is left: 1e-4 of the oil's */

void cylinder_model_init(struct cylinder_model *m, const struct params *params) {
    const struct actuator_params *a = &params->actuator;
    const struct hydraulics_params *h = &params->hydraulics;
    struct sim_geometry geometry;
    sim_geometry_init(&geometry, params);
    double omega = 2.0 * PI * h->valve_frequency_hz;
    *m = (struct cylinder_model){
        .params = params,
        .a1_m2 = PI / 4.0 * a->piston_diameter_m * a->piston_diameter_m,
        .a2_m2 = PI / 4.0 * (a->piston_diameter_m * a->piston_diameter_m - a->rod_diameter_m * a->rod_diameter_m),
        .length_min_m = geometry.neutral_length_m - 0.5 * a->stroke_m,
        .length_max_m = geometry.neutral_length_m + 0.5 * a->stroke_m,
        .valve_gain = h->valve_flow_m3_per_s / sqrt(h->valve_drop_pa),
        .valve_omega_squared = omega * omega,
        .valve_damping_rate = 2.0 * h->valve_damping * omega,
    };
    for (int i = 0; effect_table[i]; i++) {
        if (!params->effects[i].on || !effect_table[i]->leg_friction) continue;
        m->leg_effect[m->leg_effects].effect = effect_table[i];
        m->leg_effect[m->leg_effects++].values = &params->effects[i];
    }
}

/* sign(drop) sqrt|drop|, laminar below the limit. */
static inline double signed_root(double drop_pa, double laminar_pa) {
    double size = fabs(drop_pa);
    if (size >= laminar_pa) return copysign(sqrt(size), drop_pa);
    double y = drop_pa / laminar_pa;
    return sqrt(laminar_pa) * y * (1.25 - 0.25 * y * y);
}

/* Pressure rate of a chamber joined to `source` through its port; outflow: what leaves by piston and leakage. */
static inline double chamber_rate(const struct cylinder_model *m, double pressure_pa, double source_pa, double opening, double volume_m3,
                                  double outflow_m3_per_s) {
    const struct hydraulics_params *h = &m->params->hydraulics;
    double stiffness = h->bulk_modulus_pa / volume_m3, conductance = m->valve_gain * opening;
    double root = 1.25 * conductance * stiffness * FILL_TIME_S; /* laminar slope x stiffness x this time = 1 */
    double laminar_pa = root * root > LAMINAR_PA ? root * root : LAMINAR_PA;
    double rate = stiffness * (conductance * signed_root(source_pa - pressure_pa, laminar_pa) - outflow_m3_per_s);
    if (pressure_pa >= h->tank_pa) return rate;
    double left = (pressure_pa - VACUUM_PA) / (h->tank_pa - VACUUM_PA);
    left = left > SOFTEST ? left : SOFTEST;
    return left * left * rate + (h->tank_pa - pressure_pa) / MAKE_UP_TIME_S;
}

struct cylinder_state cylinder_derivative(const struct cylinder_model *m, const struct cylinder_state *s, double length_m, double rate_mps,
                                          double valve) {
    const struct hydraulics_params *h = &m->params->hydraulics;
    double stroke_m = length_m - m->length_min_m, full_m = m->length_max_m - m->length_min_m;
    stroke_m = stroke_m < 0.0 ? 0.0 : stroke_m > full_m ? full_m : stroke_m;
    double leakage = h->leakage_m3_per_s_pa * (s->p1_pa - s->p2_pa);
    double opening = fabs(s->spool) < 1.0 ? fabs(s->spool) : 1.0;
    bool extend = s->spool > 0.0;
    double source1_pa = extend ? h->supply_pa : h->tank_pa, source2_pa = extend ? h->tank_pa : h->supply_pa;
    double volume1_m3 = h->dead_volume_m3 + m->a1_m2 * stroke_m, volume2_m3 = h->dead_volume_m3 + m->a2_m2 * (full_m - stroke_m);
    return (struct cylinder_state){
        .p1_pa = chamber_rate(m, s->p1_pa, source1_pa, opening, volume1_m3, m->a1_m2 * rate_mps + leakage),
        .p2_pa = chamber_rate(m, s->p2_pa, source2_pa, opening, volume2_m3, -m->a2_m2 * rate_mps - leakage),
        .spool = s->spool_rate,
        .spool_rate = m->valve_omega_squared * (valve - s->spool) - m->valve_damping_rate * s->spool_rate,
    };
}

void cylinder_limit(struct cylinder_state *s) {
    if (fabs(s->spool) >= 1.0) {
        s->spool = copysign(1.0, s->spool);
        if (s->spool * s->spool_rate > 0.0) s->spool_rate = 0.0;
    }
    s->p1_pa = s->p1_pa > VACUUM_PA ? s->p1_pa : VACUUM_PA;
    s->p2_pa = s->p2_pa > VACUUM_PA ? s->p2_pa : VACUUM_PA;
}

double cylinder_hydraulic_force(const struct cylinder_model *m, const struct cylinder_state *s) {
    return m->a1_m2 * s->p1_pa - m->a2_m2 * s->p2_pa;
}

/* A damper alone would pull on the way out: the stop only pushes. */
static double stop_push(const struct hydraulics_params *h, double depth_m, double speed_in_mps) {
    if (depth_m <= 0.0) return 0.0;
    double push = h->stop_stiffness_n_per_m * depth_m + h->stop_damping_n_s_per_m * speed_in_mps;
    return push > 0.0 ? push : 0.0;
}

double cylinder_stop_force(const struct cylinder_model *m, double length_m, double rate_mps) {
    const struct hydraulics_params *h = &m->params->hydraulics;
    return stop_push(h, m->length_min_m - length_m, -rate_mps) - stop_push(h, length_m - m->length_max_m, rate_mps);
}

struct friction cylinder_friction(const struct cylinder_model *m, int leg, const struct cylinder_state *s, int direction,
                                  double speed_mps) {
    struct friction sum = {.viscous = m->params->hydraulics.viscous_n_s_per_m * speed_mps};
    struct leg_motion motion = {.direction = direction, .speed_mps = speed_mps, .p1_pa = s->p1_pa, .p2_pa = s->p2_pa};
    for (int i = 0; i < m->leg_effects; i++) m->leg_effect[i].effect->leg_friction(m->leg_effect[i].values, leg, &motion, &sum);
    double smooth_mps = m->params->sim.smooth_friction_mps;
    if (smooth_mps > 0.0) sum = (struct friction){.viscous = sum.viscous + sum.dry * tanh(speed_mps / smooth_mps)};
    return sum;
}

/* Asks the effects themselves, under pressure: some hold only then. */
bool cylinder_can_stick(const struct cylinder_model *m) {
    struct cylinder_state loaded = {.p1_pa = m->params->hydraulics.supply_pa, .p2_pa = m->params->hydraulics.supply_pa};
    for (int leg = 0; leg < LEGS; leg++)
        if (cylinder_friction(m, leg, &loaded, 1, 0.0).dry > 0.0 || cylinder_friction(m, leg, &loaded, -1, 0.0).dry > 0.0) return true;
    return false;
}

struct friction joint_friction(const struct params *params, int leg, double speed_radps) {
    struct friction sum = {0};
    for (int i = 0; effect_table[i]; i++)
        if (params->effects[i].on && effect_table[i]->joint_friction)
            effect_table[i]->joint_friction(&params->effects[i], leg, speed_radps, &sum);
    return sum;
}

bool joint_friction_present(const struct params *params) {
    for (int i = 0; effect_table[i]; i++)
        if (params->effects[i].on && effect_table[i]->joint_friction) return true;
    return false;
}
