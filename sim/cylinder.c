#include "cylinder.h"

#include <math.h>

#include "engine.h"
#include "numeric.h"
#include "params.h"
#include "units.h"

static const double LAMINAR_PA = 1e4;
static const double FILL_TIME_S = 2e-4; /* shortest time constant with which port_flow() fills a
                                         * chamber or hose, so that even explicit Euler with
                                         * substeps of 0.25 ms is stable */
static const double SEAL_TIME_S = 2e-4; /* shortest time constant of the seals' deflection, however
                                         * fast the rod moves */
static const double MAKE_UP_TIME_S = 1e-3;
static const double VACUUM_PA = -101325.0;
static const double SOFTEST = 0.01;        /* lowest ratio of the pressure above vacuum to the tank
                                            * pressure above vacuum with which softening is
                                            * computed; at this ratio beta is 1e-4 of the oil's */
static const double DENSITY_KG_PER_M3 = 870.0, VISCOSITY_M2_PER_S = 4e-5;
static const double SHORTEST_HOSE_M = 0.2;
/* HOSE_TIME_S: reciprocal of 5000 rad/s, the highest natural frequency of a hose with a chamber,
 * which steps of 0.5 ms resolve. NEAR_END: share of the stroke for which the chamber's volume is
 * taken. */
static const double HOSE_TIME_S = 2e-4, NEAR_END = 0.1;

static void valve_init(struct cylinder_model *m, int leg, const struct hydraulics_params *h) {
    const struct machine *machine = &m->machine;
    const struct sensor_errors *errors = &machine->params->errors;
    double pipe_m3 = PI / 4.0 * square(h->pipe_bore_m) * (errors->pipe_m + errors->pipe_rest_m[leg]),
           dead_m3 = h->dead_volume_m3[leg] + pipe_m3;
    double omega = 2.0 * PI * machine->valve.frequency_hz[leg], gain = h->valve_flow_m3_per_s[leg] / sqrt(h->valve_drop_pa);
    m->leg[leg] = (struct cylinder_leg){
        .valve_gain = {gain * machine->valve.flow_scale[leg], gain * machine->valve.flow_scale[leg] * machine->valve.port_ratio[leg]},
        .valve_omega_squared = omega * omega,
        .valve_damping_rate = 2.0 * h->valve_damping[leg] * omega,
        .valve_bias = machine->valve.bias[leg],
        .valve_rate_per_s = machine->valve.rate_per_s[leg],
        .rate_limited = isfinite(machine->valve.rate_per_s[leg]),
        .bulk_modulus_pa = machine->oil.bulk_modulus_pa[leg],
        .leakage_m3_per_s_pa = machine->oil.leakage_m3_per_s_pa[leg],
        .seal_distance_m = machine->seals.distance_m[leg],
        .dead_volume_m3 = {dead_m3, dead_m3 + h->dead_volume_difference_m3[leg]},
    };
}

static void piston_init(struct cylinder_model *m, int leg, const struct actuator_params *a) {
    struct cylinder_leg *c = &m->leg[leg];
    double piston = a->piston_diameter_m[leg], rod = a->rod_diameter_m[leg], middle = m->machine.bodies.middle_length_m[leg];
    c->a1_m2 = PI / 4.0 * piston * piston;
    c->a2_m2 = PI / 4.0 * (piston * piston - rod * rod);
    c->length_min_m = middle - 0.5 * a->stroke_m[leg];
    c->length_max_m = middle + 0.5 * a->stroke_m[leg];
}

void cylinder_pipe(double length_m, double bore_m, double *inertance, double *resistance) {
    double area_m2 = PI / 4.0 * bore_m * bore_m;
    *inertance = DENSITY_KG_PER_M3 * length_m / area_m2;
    *resistance = 8.0 * PI * DENSITY_KG_PER_M3 * VISCOSITY_M2_PER_S * length_m / (area_m2 * area_m2);
}

static void hose_init(struct cylinder_model *m, int leg) {
    struct cylinder_leg *c = &m->leg[leg];
    double length_m = m->machine.hose.length_m[leg], bore_m = m->machine.hose.diameter_m[leg];
    if (!(length_m > 0.0)) return;
    double area_m2 = PI / 4.0 * bore_m * bore_m, stroke_m = NEAR_END * (c->length_max_m - c->length_min_m);
    length_m = fmax(length_m, SHORTEST_HOSE_M);
    c->hose_volume_m3 = area_m2 * length_m;
    double chamber_m3 = fmin(c->dead_volume_m3[PORT_A] + c->a1_m2 * stroke_m, c->dead_volume_m3[PORT_B] + c->a2_m2 * stroke_m);
    double least = HOSE_TIME_S * HOSE_TIME_S * c->bulk_modulus_pa * (1.0 / c->hose_volume_m3 + 1.0 / chamber_m3);
    cylinder_pipe(length_m, bore_m, &c->hose_inertance, &c->hose_resistance);
    c->hose_inertance = fmax(c->hose_inertance, least);
}

void cylinder_model_init(struct cylinder_model *m, const struct params *params) {
    *m = (struct cylinder_model){
        .legs = params_legs(params),
        .supply_share = 1.0,
    };
    machine_init(&m->machine, params);
    for (int leg = 0; leg < LEGS; leg++) {
        valve_init(m, leg, &params->hydraulics);
        piston_init(m, leg, &params->actuator);
        hose_init(m, leg);
        m->extended = m->extended || m->leg[leg].hose_volume_m3 > 0.0;
    }
    m->extended = m->extended || m->machine.opening.count > 0;
    m->extended = m->extended || m->machine.supply.resistance_pa_s_per_m3 > 0.0 || m->machine.supply.tank_resistance_pa_s_per_m3 > 0.0;
}

struct mains cylinder_mains(const struct cylinder_model *m) {
    double tank_pa = m->machine.supply.tank_pa;
    return (struct mains){.supply_pa = fmax(m->supply_share * m->machine.supply.pressure_pa, tank_pa), .tank_pa = tank_pa};
}

/* Returns sign(drop) sqrt|drop|; below laminar_pa the cubic of laminar flow (cylinder.h)
 * instead. */
static inline double signed_root(double drop_pa, double laminar_pa) {
    double size = fabs(drop_pa);
    if (size >= laminar_pa) return copysign(sqrt(size), drop_pa);
    double y = drop_pa / laminar_pa;
    return sqrt(laminar_pa) * y * (1.25 - 0.25 * y * y);
}

/* Returns the flow from a source into a volume; stiffness: beta / V of that volume. */
static inline double port_flow(double conductance, double stiffness, double source_pa, double pressure_pa) {
    /* the limit of laminar flow follows from: laminar slope x stiffness x FILL_TIME_S = 1 */
    double root = 1.25 * conductance * stiffness * FILL_TIME_S;
    double laminar_pa = root * root > LAMINAR_PA ? root * root : LAMINAR_PA;
    return conductance * signed_root(source_pa - pressure_pa, laminar_pa);
}

/* Returns the pressure rate of a chamber or hose. Below tank pressure the oil softens with the
 * square of the pressure above vacuum, and make-up flow draws the pressure back to the tank's with
 * the time constant MAKE_UP_TIME_S. */
static inline double pressure_rate(const struct machine *m, double pressure_pa, double stiffness, double inflow_m3_per_s) {
    double rate = stiffness * inflow_m3_per_s;
    if (pressure_pa >= m->supply.tank_pa) return rate;
    double left = (pressure_pa - VACUUM_PA) / (m->supply.tank_pa - VACUUM_PA);
    left = left > SOFTEST ? left : SOFTEST;
    return left * left * rate + (m->supply.tank_pa - pressure_pa) / MAKE_UP_TIME_S;
}

/* Orifices between a leg's two ports and the mains. extend: the spool is on the side that extends
 * the leg; the supply then acts on port A. */
struct ports {
    double conductance[PORTS], source_pa[PORTS];
    bool extend;
};

static inline struct ports ports_of(const struct cylinder_leg *c, const struct mains *mains, double signed_opening) {
    double opening = fabs(signed_opening) < 1.0 ? fabs(signed_opening) : 1.0;
    bool extend = signed_opening > 0.0;
    return (struct ports){
        .conductance = {c->valve_gain[PORT_A] * opening, c->valve_gain[PORT_B] * opening},
        .source_pa = {extend ? mains->supply_pa : mains->tank_pa, extend ? mains->tank_pa : mains->supply_pa},
        .extend = extend,
    };
}

/* Computes the stiffness beta / V of both chambers. */
static inline void chambers(const struct cylinder_leg *c, double length_m, double stiffness[PORTS]) {
    double stroke_m = length_m - c->length_min_m, full_m = c->length_max_m - c->length_min_m;
    double bulk_pa = c->bulk_modulus_pa;
    stroke_m = stroke_m < 0.0 ? 0.0 : stroke_m > full_m ? full_m : stroke_m;
    stiffness[PORT_A] = bulk_pa / (c->dead_volume_m3[PORT_A] + c->a1_m2 * stroke_m);
    stiffness[PORT_B] = bulk_pa / (c->dead_volume_m3[PORT_B] + c->a2_m2 * (full_m - stroke_m));
}

static inline double spool_speed(const struct cylinder_leg *c, double rate) {
    if (!c->rate_limited || fabs(rate) <= c->valve_rate_per_s) return rate;
    return copysign(c->valve_rate_per_s, rate);
}

static inline double spool_acceleration(const struct cylinder_leg *c, double spool, double speed, double valve) {
    return c->valve_omega_squared * (valve + c->valve_bias - spool) - c->valve_damping_rate * speed;
}

/* Returns the rate of the seals' deflection by Dahl's law. The deflection takes at least
 * SEAL_TIME_S, however fast the rod is, so that the substeps resolve it. */
static inline double deflection_rate(const struct cylinder_leg *c, double deflection, double rate_mps) {
    double speed = fabs(rate_mps), least_m = SEAL_TIME_S * speed;
    if (!(c->seal_distance_m > 0.0)) return 0.0;
    return (rate_mps - speed * deflection) / (c->seal_distance_m > least_m ? c->seal_distance_m : least_m);
}

/* Returns the rate of the state for these flows into the chambers. */
static inline struct cylinder_state rates(const struct cylinder_model *m, const struct cylinder_leg *c, const struct cylinder_state *s,
                                          const double stiffness[PORTS], double flow1, double flow2, double rate_mps, double valve) {
    const struct machine *machine = &m->machine;
    double leakage = c->leakage_m3_per_s_pa * (s->p1_pa - s->p2_pa), speed = spool_speed(c, s->spool_rate);
    return (struct cylinder_state){
        .p1_pa = pressure_rate(machine, s->p1_pa, stiffness[PORT_A], flow1 - (c->a1_m2 * rate_mps + leakage)),
        .p2_pa = pressure_rate(machine, s->p2_pa, stiffness[PORT_B], flow2 - (-c->a2_m2 * rate_mps - leakage)),
        .spool = speed,
        .spool_rate = spool_acceleration(c, s->spool, speed, valve),
        .deflection = deflection_rate(c, s->deflection, rate_mps),
    };
}

/* Returns the rate of the state of a leg without hoses. */
static inline struct cylinder_state direct_rates(const struct cylinder_model *m, const struct cylinder_leg *c, const struct mains *mains,
                                                 const struct cylinder_state *s, double opening, const double stiffness[PORTS],
                                                 double rate_mps, double valve) {
    struct ports p = ports_of(c, mains, opening);
    double flow1 = port_flow(p.conductance[PORT_A], stiffness[PORT_A], p.source_pa[PORT_A], s->p1_pa);
    double flow2 = port_flow(p.conductance[PORT_B], stiffness[PORT_B], p.source_pa[PORT_B], s->p2_pa);
    return rates(m, c, s, stiffness, flow1, flow2, rate_mps, valve);
}

struct cylinder_state cylinder_derivative(const struct cylinder_model *m, int leg, const struct mains *mains,
                                          const struct cylinder_state *s, double opening, double length_m, double rate_mps, double valve) {
    double stiffness[PORTS];
    const struct cylinder_leg *c = &m->leg[leg];
    chambers(c, length_m, stiffness);
    return direct_rates(m, c, mains, s, opening, stiffness, rate_mps, valve);
}

/* Returns s + h rate. */
static inline struct cylinder_state advanced(const struct cylinder_state *s, double h, const struct cylinder_state *rate) {
    return (struct cylinder_state){s->p1_pa + h * rate->p1_pa, s->p2_pa + h * rate->p2_pa, s->spool + h * rate->spool,
                                   s->spool_rate + h * rate->spool_rate, s->deflection + h * rate->deflection};
}

void cylinder_step(const struct cylinder_model *m, int leg, double dt_s, const struct cylinder_input in[3], struct cylinder_state *s) {
    static const int node[4] = {0, 1, 1, 2};
    static const double reach[4] = {0.0, 0.5, 0.5, 1.0}, divisor[4] = {6.0, 3.0, 3.0, 6.0};
    const struct cylinder_leg *c = &m->leg[leg];
    struct mains mains = cylinder_mains(m);
    struct cylinder_state start = *s, rate = {0};
    double stiffness[3][PORTS];
    for (int i = 0; i < 3; i++) chambers(c, in[i].length_m, stiffness[i]);
    for (int i = 0; i < 4; i++) {
        int j = node[i];
        struct cylinder_state at = advanced(&start, reach[i] * dt_s, &rate);
        rate = direct_rates(m, c, &mains, &at, at.spool, stiffness[j], in[j].rate_mps, in[j].valve);
        *s = advanced(s, dt_s / divisor[i], &rate);
    }
    cylinder_limit(m, leg, s);
}

/* Returns the stiffness beta / V of a hose. */
static double hose_stiffness(const struct cylinder_leg *c) { return c->bulk_modulus_pa / c->hose_volume_m3; }

struct cylinder_state cylinder_hose_derivative(const struct cylinder_model *m, int leg, const struct mains *mains,
                                               const struct cylinder_state *s, const struct hose_state hose[PORTS], double opening,
                                               double length_m, double rate_mps, double valve, struct hose_state hose_rate[PORTS]) {
    const struct cylinder_leg *c = &m->leg[leg];
    const double chamber_pa[PORTS] = {s->p1_pa, s->p2_pa};
    double stiffness[PORTS], own = hose_stiffness(c);
    struct ports p = ports_of(c, mains, opening);
    chambers(c, length_m, stiffness);
    for (int i = 0; i < PORTS; i++) {
        double in = port_flow(p.conductance[i], own, p.source_pa[i], hose[i].pressure_pa), through = hose[i].flow_m3_per_s;
        hose_rate[i].pressure_pa = pressure_rate(&m->machine, hose[i].pressure_pa, own, in - through);
        hose_rate[i].flow_m3_per_s = (hose[i].pressure_pa - chamber_pa[i] - c->hose_resistance * through) / c->hose_inertance;
    }
    return rates(m, c, s, stiffness, hose[PORT_A].flow_m3_per_s, hose[PORT_B].flow_m3_per_s, rate_mps, valve);
}

void cylinder_flows(const struct cylinder_model *m, int leg, const struct mains *mains, const struct cylinder_state *s,
                    const struct hose_state *hose, double opening, double length_m, double *supply_m3_per_s, double *tank_m3_per_s) {
    double stiffness[PORTS], pressure_pa[PORTS] = {s->p1_pa, s->p2_pa}, flow[PORTS];
    const struct cylinder_leg *c = &m->leg[leg];
    struct ports p = ports_of(c, mains, opening);
    chambers(c, length_m, stiffness);
    for (int i = 0; i < PORTS; i++) {
        if (hose) stiffness[i] = hose_stiffness(c), pressure_pa[i] = hose[i].pressure_pa;
        flow[i] = port_flow(p.conductance[i], stiffness[i], p.source_pa[i], pressure_pa[i]);
    }
    *supply_m3_per_s = p.extend ? flow[PORT_A] : flow[PORT_B];
    *tank_m3_per_s = p.extend ? -flow[PORT_B] : -flow[PORT_A];
}

void cylinder_limit(const struct cylinder_model *m, int leg, struct cylinder_state *s) {
    s->spool_rate = spool_speed(&m->leg[leg], s->spool_rate);
    if (fabs(s->spool) >= 1.0) {
        s->spool = copysign(1.0, s->spool);
        if (s->spool * s->spool_rate > 0.0) s->spool_rate = 0.0;
    }
    if (fabs(s->deflection) > 1.0) s->deflection = copysign(1.0, s->deflection);
    s->p1_pa = s->p1_pa > VACUUM_PA ? s->p1_pa : VACUUM_PA;
    s->p2_pa = s->p2_pa > VACUUM_PA ? s->p2_pa : VACUUM_PA;
}

void cylinder_spool_step(const struct cylinder_model *m, int leg, double dt_s, double valve, struct cylinder_state *s) {
    static const double at[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    const struct cylinder_leg *c = &m->leg[leg];
    double speed = 0.0, acceleration = 0.0, moved = 0.0, gained = 0.0;
    for (int i = 0; i < 4; i++) {
        double spool = s->spool + at[i] * dt_s * speed;
        speed = spool_speed(c, s->spool_rate + at[i] * dt_s * acceleration);
        acceleration = spool_acceleration(c, spool, speed, valve);
        moved += weight[i] * dt_s * speed, gained += weight[i] * dt_s * acceleration;
    }
    s->spool += moved;
    s->spool_rate += gained;
    cylinder_limit(m, leg, s);
}

double cylinder_stiffness(const struct cylinder_model *m, int leg, double length_m) {
    const struct cylinder_leg *c = &m->leg[leg];
    double stiffness[PORTS];
    chambers(c, length_m, stiffness);
    return c->a1_m2 * c->a1_m2 * stiffness[PORT_A] + c->a2_m2 * c->a2_m2 * stiffness[PORT_B];
}

double cylinder_hydraulic_force(const struct cylinder_model *m, int leg, const struct cylinder_state *s) {
    return m->leg[leg].a1_m2 * s->p1_pa - m->leg[leg].a2_m2 * s->p2_pa;
}

/* Returns the force of an end stop, which only pushes: its damper alone would pull when the rod
 * moves away. */
static double stop_push(const struct hydraulics_params *h, double depth_m, double speed_in_mps) {
    if (depth_m <= 0.0) return 0.0;
    double push = h->stop_stiffness_n_per_m * depth_m + h->stop_damping_n_s_per_m * speed_in_mps;
    return push > 0.0 ? push : 0.0;
}

double cylinder_stop_force(const struct cylinder_model *m, int leg, double length_m, double rate_mps) {
    const struct cylinder_leg *c = &m->leg[leg];
    const struct hydraulics_params *h = &m->machine.params->hydraulics;
    return stop_push(h, c->length_min_m - length_m, -rate_mps) - stop_push(h, length_m - c->length_max_m, rate_mps);
}

double cylinder_seal_force(const struct cylinder_model *m, int leg, const struct cylinder_state *s) {
    return m->leg[leg].seal_distance_m > 0.0 ? -cylinder_friction(m, leg, s, 1, 0.0).elastic : 0.0;
}

struct friction cylinder_friction(const struct cylinder_model *m, int leg, const struct cylinder_state *s, int direction,
                                  double speed_mps) {
    const struct active *laws = &m->machine.leg_friction;
    struct friction sum = {.viscous = m->machine.params->hydraulics.viscous_n_s_per_m[leg] * speed_mps};
    if (laws->count == 0) return sum;
    struct leg_motion motion = {.direction = direction,
                                .speed_mps = speed_mps,
                                .p1_pa = s->p1_pa,
                                .p2_pa = s->p2_pa,
                                .deflection = s->deflection,
                                .a1_m2 = m->leg[leg].a1_m2,
                                .a2_m2 = m->leg[leg].a2_m2};
    for (int i = 0; i < laws->count; i++) laws->of[i].effect->leg_friction(laws->of[i].values, leg, &motion, &sum);
    double smooth_mps = m->machine.params->sim.smooth_friction_mps;
    if (smooth_mps > 0.0) sum.viscous += sum.dry * tanh(speed_mps / smooth_mps), sum.dry = 0.0;
    return sum;
}

/* Evaluates the friction with supply pressure in both chambers, because some friction depends on
 * pressure. */
bool cylinder_can_stick(const struct cylinder_model *m) {
    struct cylinder_state loaded = {.p1_pa = m->machine.supply.pressure_pa, .p2_pa = m->machine.supply.pressure_pa};
    for (int leg = 0; leg < LEGS; leg++)
        if (cylinder_friction(m, leg, &loaded, 1, 0.0).dry > 0.0 || cylinder_friction(m, leg, &loaded, -1, 0.0).dry > 0.0) return true;
    return false;
}
