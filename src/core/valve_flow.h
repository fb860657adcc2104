/* The flow equations of a leg's valve and chambers, inverted: the opening that makes the leg force
 * change at a wanted rate while the piston moves. Derived independently of sim/cylinder.h. Pure,
 * RT.
 *
 *     V1 / beta P1' = Q1 - A1 v - c (P1 - P2),  V2 / beta P2' = Q2 + A2 v + c (P1 - P2)
 *     f' = A1 P1' - A2 P2'
 *     o > 0: Q1 = g1 o sqrt(Ps - P1), Q2 = -g2 o sqrt(P2 - Pt);  o < 0: Q1 = -g1 |o| sqrt(P1 - Pt),
 *            Q2 = g2 |o| sqrt(Ps - P2)
 *  => o = (f' + beta [(A1^2/V1 + A2^2/V2) v + (A1/V1 + A2/V2) c (P1 - P2)])
 *         / beta [A1/V1 g1 sqrt(drop 1) + A2/V2 g2 sqrt(drop 2)]
 *
 * with the pressure drops of the direction that the sign of the numerator gives. */
#ifndef HEXID_VALVE_FLOW_H
#define HEXID_VALVE_FLOW_H

#include <stdbool.h>

#include "types.h"

struct kinematics;
struct params;

struct valve_flow {
    double gain[2];              /* flow gains g1, g2 of the ports to the rodless and to the rod
                                  * side, fully open, m^3/(s sqrt Pa) */
    double area_m2[2], dead_m3[2]; /* areas and dead volumes of the rodless and of the rod side */
    double least_m, most_m;      /* leg lengths at the end stops */
    double bulk_modulus_pa, leakage_m3_per_s_pa, supply_pa, tank_pa;
    double null;                 /* command at which the spool is in its middle position */
    double delay_s;              /* delay from command to spool: lag of the spool plus dead time */
    double dead;                 /* half the width of the valve's dead band, as a share of full
                                  * opening */
};

/* Pressures in a leg's chambers, and length and rate of the leg. */
struct oil_state {
    double p1_pa, p2_pa, length_m, rate_mps;
};

/* Reads sections `actuator` and `hydraulics` and the effects valve_flow_gain, port_area_ratio,
 * valve_dead_band, valve_null_bias, valve_lag, command_delay and internal_leakage. */
void valve_flow_init(struct valve_flow *flow, int leg, const struct params *params, const struct kinematics *k);

/* Returns the opening, as a share of full opening, at which the leg force changes at this rate. A
 * result beyond +-1 is more than the valve can open. A pressure drop counts as at least a hundredth
 * of supply less tank pressure. */
double valve_flow_opening(const struct valve_flow *flow, const struct oil_state *oil, double force_rate_n_per_s);

/* Advances the pressures by time_s in one explicit Euler step at this opening, and limits them to
 * the range from tank to supply. */
void valve_flow_advance(const struct valve_flow *flow, struct oil_state *oil, double opening, double time_s);

/* Changes both pressures so that the leg has this force, as a small move of the piston with the
 * valve shut would; limits them to the range from tank to supply. length_m stays. */
void valve_flow_load(const struct valve_flow *flow, struct oil_state *oil, double force_n);

/* Returns the steady-state opening for a command: 0 within the dead band; NaN for NaN. */
double valve_flow_opened(const struct valve_flow *flow, double command);

/* Returns the command for an opening: adds the null, and the dead band in the direction of the
 * opening. For openings within +-0.002 the dead band is added in proportion, so that noise about
 * zero does not make the valve chatter. */
double valve_flow_command(const struct valve_flow *flow, double opening);

#endif
