#include "hydraulics.h"

#include <math.h>
#include <string.h>

static const double SUPPLY_LAG_S = 10e-3;
static const double BALANCED_PA = 1e-3;
enum { ITERATIONS = 60 };

void hydraulics_rest(struct hydraulics_state *s) {
    for (int k = 0; k < LEGS; k++) {
        s->hose[k][PORT_A] = (struct hose_state){.pressure_pa = s->cylinder[k].p1_pa};
        s->hose[k][PORT_B] = (struct hose_state){.pressure_pa = s->cylinder[k].p2_pa};
    }
    s->supply_m3_per_s = 0.0;
}

/* Sums the legs' flows from the supply and to the tank. */
static void flows(const struct cylinder_model *m, const struct hydraulics_state *s, const double length_m[LEGS], const struct mains *mains,
                  double *supply_m3_per_s, double *tank_m3_per_s) {
    *supply_m3_per_s = *tank_m3_per_s = 0.0;
    for (int k = m->first; k < m->legs; k++) {
        double supply, tank;
        bool hose = m->leg[k].hose_volume_m3 > 0.0;
        double opening = machine_opening(&m->machine, k, s->cylinder[k].spool);
        cylinder_flows(m, k, mains, &s->cylinder[k], hose ? s->hose[k] : NULL, opening, length_m[k], &supply, &tank);
        *supply_m3_per_s += supply;
        *tank_m3_per_s += tank;
    }
}

/* Finds the back pressure that the legs' flow causes in the return hose, by the Illinois rule. The
 * flow falls as the back pressure rises, so there is exactly one solution. */
static void balance_tank(const struct cylinder_model *m, const struct hydraulics_state *s, const double length_m[LEGS],
                         struct mains *mains) {
    double resistance = m->machine.supply.tank_resistance_pa_s_per_m3, base_pa = mains->tank_pa, supply, flow;
    if (!(resistance > 0.0)) return;
    flows(m, s, length_m, mains, &supply, &flow);
    double low = base_pa, low_error = -resistance * flow, high = base_pa - low_error, high_error;
    mains->tank_pa = high;
    flows(m, s, length_m, mains, &supply, &flow);
    high_error = high - base_pa - resistance * flow;
    for (int i = 0, side = 0; i < ITERATIONS && fabs(high - low) > BALANCED_PA && high_error != low_error; i++) {
        double at = high - high_error * (high - low) / (high_error - low_error);
        mains->tank_pa = at;
        flows(m, s, length_m, mains, &supply, &flow);
        double error = at - base_pa - resistance * flow;
        if (fabs(error) < BALANCED_PA) return;
        if ((error > 0.0) == (high_error > 0.0)) {
            high = at, high_error = error;
            if (side > 0) low_error *= 0.5;
            side = 1;
        } else {
            low = at, low_error = error;
            if (side < 0) high_error *= 0.5;
            side = -1;
        }
    }
}

static struct mains mains_now(const struct cylinder_model *m, const struct hydraulics_state *s, const double length_m[LEGS],
                              double *supply_m3_per_s2) {
    struct mains mains = cylinder_mains(m);
    double resistance = m->machine.supply.resistance_pa_s_per_m3, supply, tank;
    mains.supply_pa -= resistance * s->supply_m3_per_s;
    balance_tank(m, s, length_m, &mains);
    *supply_m3_per_s2 = 0.0;
    if (!(resistance > 0.0)) return mains; /* without resistance the flow causes no pressure drop */
    flows(m, s, length_m, &mains, &supply, &tank);
    *supply_m3_per_s2 = (supply - s->supply_m3_per_s) / SUPPLY_LAG_S;
    return mains;
}

static void extended(const struct cylinder_model *m, const struct hydraulics_state *s, const struct hydraulics_input *in,
                     struct hydraulics_state *rate) {
    struct mains mains = mains_now(m, s, in->length_m, &rate->supply_m3_per_s);
    for (int k = m->first; k < m->legs; k++) {
        double opening = machine_opening(&m->machine, k, s->cylinder[k].spool);
        memset(rate->hose[k], 0, sizeof rate->hose[k]);
        if (m->leg[k].hose_volume_m3 > 0.0)
            rate->cylinder[k] = cylinder_hose_derivative(m, k, &mains, &s->cylinder[k], s->hose[k], opening, in->length_m[k],
                                                         in->rate_mps[k], in->valve[k], rate->hose[k]);
        else
            rate->cylinder[k] = cylinder_derivative(m, k, &mains, &s->cylinder[k], opening, in->length_m[k], in->rate_mps[k], in->valve[k]);
    }
}

void hydraulics_derivative(const struct cylinder_model *m, const struct hydraulics_state *s, const struct hydraulics_input *in,
                           struct hydraulics_state *rate) {
    if (m->extended) {
        extended(m, s, in, rate);
        return;
    }
    struct mains mains = cylinder_mains(m);
    for (int k = m->first; k < m->legs; k++)
        rate->cylinder[k] = cylinder_derivative(m, k, &mains, &s->cylinder[k], s->cylinder[k].spool, in->length_m[k], in->rate_mps[k],
                                                in->valve[k]);
}

void hydraulics_limit(const struct cylinder_model *m, struct hydraulics_state *s) {
    for (int k = m->first; k < m->legs; k++) cylinder_limit(m, k, &s->cylinder[k]);
}

union values {
    struct hydraulics_state state;
    double value[sizeof(struct hydraulics_state) / sizeof(double)];
};
enum { VALUES = sizeof(struct hydraulics_state) / sizeof(double) };

/* Computes to = from + h rate. */
static void advance(double h, const union values *from, const union values *rate, union values *to) {
    for (int i = 0; i < VALUES; i++) to->value[i] = from->value[i] + h * rate->value[i];
}

static void extended_step(const struct cylinder_model *m, double dt_s, const struct hydraulics_input in[3], struct hydraulics_state *s) {
    static const double divisor[4] = {6.0, 3.0, 3.0, 6.0};
    union values start, at, k[4];
    memset(k, 0, sizeof k); /* the rates of legs that the mechanism lacks stay 0 */
    start.state = *s;
    extended(m, &start.state, &in[0], &k[0].state);
    advance(0.5 * dt_s, &start, &k[0], &at);
    extended(m, &at.state, &in[1], &k[1].state);
    advance(0.5 * dt_s, &start, &k[1], &at);
    extended(m, &at.state, &in[1], &k[2].state);
    advance(dt_s, &start, &k[2], &at);
    extended(m, &at.state, &in[2], &k[3].state);
    for (int i = 0; i < 4; i++) advance(dt_s / divisor[i], &start, &k[i], &start);
    *s = start.state;
    hydraulics_limit(m, s);
}

void hydraulics_step(const struct cylinder_model *m, double dt_s, const struct hydraulics_input in[3], struct hydraulics_state *s) {
    if (m->extended) {
        extended_step(m, dt_s, in, s);
        return;
    }
    for (int k = m->first; k < m->legs; k++) {
        struct cylinder_input leg[3];
        for (int i = 0; i < 3; i++) leg[i] = (struct cylinder_input){in[i].length_m[k], in[i].rate_mps[k], in[i].valve[k]};
        cylinder_step(m, k, dt_s, leg, &s->cylinder[k]);
    }
}
