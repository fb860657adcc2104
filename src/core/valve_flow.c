#include "valve_flow.h"

#include <assert.h>
#include <math.h>

#include "force.h"
#include "params.h"
#include "units.h"

/* Smallest pressure drop that counts, as a share of supply less tank pressure. */
static const double LEAST_DROP = 0.01;
/* Opening below which the dead band is added in proportion: a few times the noise of the command,
 * which comes from the sensors. */
static const double SMALL_OPENING = 0.002;

/* Returns the value of an effect's first key on a leg, or `without` if the effect is off. */
static double found(const struct params *params, const char *name, int leg, double without) {
    int effect = effect_find(name);
    assert(effect >= 0);
    return params->effects[effect].on ? params->effects[effect].value[0][leg] : without;
}

void valve_flow_init(struct valve_flow *flow, int leg, const struct params *params, const struct kinematics *k) {
    const struct hydraulics_params *h = &params->hydraulics;
    struct cylinder_areas areas = cylinder_areas(&params->actuator);
    struct stroke stroke = kinematics_stroke(k, &params->actuator, leg);
    double gain = h->valve_flow_m3_per_s[leg] / sqrt(h->valve_drop_pa) * found(params, "valve_flow_gain", leg, 1.0);
    double hz = fmin(h->valve_frequency_hz, found(params, "valve_lag", leg, (double)INFINITY)), dead_m3 = h->dead_volume_m3[leg];
    *flow = (struct valve_flow){.gain = {gain, gain * found(params, "port_area_ratio", leg, 1.0)},
                                .area_m2 = {areas.a1_m2[leg], areas.a2_m2[leg]},
                                .dead_m3 = {dead_m3, dead_m3 + h->dead_volume_difference_m3[leg]},
                                .least_m = stroke.least_m,
                                .most_m = stroke.most_m,
                                .bulk_modulus_pa = h->bulk_modulus_pa[leg],
                                .leakage_m3_per_s_pa = h->leakage_m3_per_s_pa[leg] * found(params, "internal_leakage", leg, 1.0),
                                .supply_pa = h->supply_pa,
                                .tank_pa = h->tank_pa,
                                .null = -found(params, "valve_null_bias", leg, 0.0),
                                .delay_s = h->valve_damping[leg] / (PI * hz) + found(params, "command_delay", leg, 0.0),
                                .dead = found(params, "valve_dead_band", leg, 0.0)};
}

static double clamp(double x, double least, double most) { return x < least ? least : x > most ? most : x; }

static double root_of_drop(const struct valve_flow *f, double drop_pa) {
    return sqrt(fmax(drop_pa, LEAST_DROP * (f->supply_pa - f->tank_pa)));
}

/* A1/V1 and A2/V2. */
struct chambers {
    double rodless_per_m, rod_per_m;
};

static struct chambers chambers_at(const struct valve_flow *f, double leg_m) {
    double length_m = clamp(leg_m, f->least_m, f->most_m);
    return (struct chambers){f->area_m2[0] / (f->dead_m3[0] + f->area_m2[0] * (length_m - f->least_m)),
                             f->area_m2[1] / (f->dead_m3[1] + f->area_m2[1] * (f->most_m - length_m))};
}

/* Magnitudes of the flows through both ports at full opening in one direction, m^3/s. */
struct port_flows {
    double rodless, rod;
};

static struct port_flows flows_at(const struct valve_flow *f, const struct oil_state *oil, bool extends) {
    double drop_1 = extends ? f->supply_pa - oil->p1_pa : oil->p1_pa - f->tank_pa;
    double drop_2 = extends ? oil->p2_pa - f->tank_pa : f->supply_pa - oil->p2_pa;
    return (struct port_flows){f->gain[0] * root_of_drop(f, drop_1), f->gain[1] * root_of_drop(f, drop_2)};
}

double valve_flow_opening(const struct valve_flow *f, const struct oil_state *oil, double force_rate_n_per_s) {
    struct chambers c = chambers_at(f, oil->length_m);
    double leak = f->leakage_m3_per_s_pa * (oil->p1_pa - oil->p2_pa);
    double wanted = force_rate_n_per_s / f->bulk_modulus_pa +
                    (c.rodless_per_m * f->area_m2[0] + c.rod_per_m * f->area_m2[1]) * oil->rate_mps +
                    (c.rodless_per_m + c.rod_per_m) * leak;
    struct port_flows flow = flows_at(f, oil, wanted > 0.0);
    return wanted / (c.rodless_per_m * flow.rodless + c.rod_per_m * flow.rod);
}

void valve_flow_advance(const struct valve_flow *f, struct oil_state *oil, double opening, double time_s) {
    struct chambers c = chambers_at(f, oil->length_m);
    struct port_flows flow = flows_at(f, oil, opening > 0.0);
    double leak = f->leakage_m3_per_s_pa * (oil->p1_pa - oil->p2_pa);
    double into_1 = opening * flow.rodless - f->area_m2[0] * oil->rate_mps - leak;
    double into_2 = -opening * flow.rod + f->area_m2[1] * oil->rate_mps + leak;
    oil->p1_pa += time_s * f->bulk_modulus_pa * c.rodless_per_m / f->area_m2[0] * into_1;
    oil->p2_pa += time_s * f->bulk_modulus_pa * c.rod_per_m / f->area_m2[1] * into_2;
    oil->p1_pa = clamp(oil->p1_pa, f->tank_pa, f->supply_pa);
    oil->p2_pa = clamp(oil->p2_pa, f->tank_pa, f->supply_pa);
}

void valve_flow_load(const struct valve_flow *f, struct oil_state *oil, double force_n) {
    struct chambers c = chambers_at(f, oil->length_m);
    double excess_n = f->area_m2[0] * oil->p1_pa - f->area_m2[1] * oil->p2_pa - force_n;
    double way = excess_n / (c.rodless_per_m * f->area_m2[0] + c.rod_per_m * f->area_m2[1]);
    oil->p1_pa = clamp(oil->p1_pa - way * c.rodless_per_m, f->tank_pa, f->supply_pa);
    oil->p2_pa = clamp(oil->p2_pa + way * c.rod_per_m, f->tank_pa, f->supply_pa);
}

double valve_flow_opened(const struct valve_flow *f, double command) {
    double spool = command - f->null;
    return fabs(spool) <= f->dead ? 0.0 : spool - copysign(f->dead, spool);
}

double valve_flow_command(const struct valve_flow *f, double opening) {
    return opening + f->null + f->dead * clamp(opening / SMALL_OPENING, -1.0, 1.0);
}
