/* One leg's hydraulics: servo valve, two compressible chambers, end stops, friction. Pure, RT.
 * hydraulics.h joins six of them.
 *
 *  symbol  meaning                                            unit
 *  L, v    joint-to-joint length and its rate                 m, m/s
 *  P1, P2  chamber pressures, rodless and rod side, gauge     Pa
 *  x, o    spool position, -1..1, and the valve's opening     -
 *  u       valve command, -1..1                               -
 *  beta, c bulk modulus of the oil, leakage of the piston     Pa, m^3/(s Pa)
 *  V1, V2  chamber volumes: dead volume + A1 s, A2 (stroke-s) m^3   (s = stroke used)
 *
 *  xddot = w^2 (u + bias - x) - 2 zeta w xdot, |x| <= 1, |xdot| <= the servo's limit
 *  Q(o, dP) = valve_flow |o| sqrt(dP / valve_drop)
 *             o > 0: supply -> port A (P1), port B (P2) -> tank
 *             o < 0: supply -> port B (P2), port A (P1) -> tank
 *  P1dot = beta/V1 (Q1 - A1 v - c (P1 - P2)),  P2dot = beta/V2 (Q2 + A2 v + c (P1 - P2))
 *
 *  zdot = (v - |v| z) / d    z: relative deflection of the seals (Dahl); d: path over which they
 *                            deflect, at least the rod's path in 0.2 ms
 *
 * Below a drop of 10 kPa the orifice is laminar: an odd cubic that has the root's value and slope
 * at 10 kPa, so that nothing changes above it. This limit of 10 kPa rises for a wide-open valve on
 * a nearly empty chamber, so that no chamber fills faster than a substep of 0.25 ms resolves. Below
 * tank pressure air leaves the oil, and beta falls with the square of the pressure above vacuum. A
 * check valve admits oil from the tank within a millisecond: a chamber whose piston is pulled stays
 * between tank pressure and vacuum, as behind an anti-cavitation valve.
 *
 * A hose of length l and bore d between a port and its chamber is one cell: at the port its
 * capacitance V/beta (V = l pi d^2/4), then in series its inertance rho l/(pi d^2/4) and its
 * laminar resistance 128 mu l/(pi d^4), rho = 870 kg/m^3, mu/rho = 4e-5 m^2/s. The gauge sits at
 * the port. A hose below 0.2 m counts as 0.2 m. A too small inertance is raised, so that the
 * natural frequency with a chamber at a tenth of its stroke is at most 5000 rad/s, which steps of
 * 0.5 ms resolve. A short wide hose then acts like a mere volume of oil. */
#ifndef HEXID_CYLINDER_H
#define HEXID_CYLINDER_H

#include "machine.h"

struct cylinder_state {
    double p1_pa, p2_pa, spool, spool_rate;
    double deflection;        /* relative deflection z of the seals: towards -1 while the rod slides
                               * in, towards 1 while it slides out */
};

struct hose_state {
    double pressure_pa;       /* pressure at the valve's port */
    double flow_m3_per_s;     /* flow through the hose into the chamber */
};

enum { PORT_A, PORT_B, PORTS };

struct cylinder_model {        /* constants derived once from params and effects */
    struct machine machine;
    int first, legs;               /* range of simulated legs, first <= leg < legs: all legs of the
                                    * mechanism, or one leg */
    struct cylinder_leg {
        double a1_m2, a2_m2;
        double length_min_m, length_max_m; /* leg lengths at the end stops */
        double valve_gain[PORTS];   /* flow gain valve_flow / sqrt(valve_drop), scaled by effects */
        double valve_omega_squared, valve_damping_rate; /* w^2 and 2 zeta w of the spool */
        double valve_bias, valve_rate_per_s;
        double bulk_modulus_pa, leakage_m3_per_s_pa, dead_volume_m3[PORTS];
        double hose_volume_m3, hose_inertance, hose_resistance; /* constants of a port's hose, m^3,
                                                                 * kg/m^4, Pa s/m^3; volume 0: there
                                                                 * is no hose */
        double seal_distance_m;       /* path over which the seals deflect; 0: no deflection, they
                                       * slide at once */
        bool rate_limited;
    } leg[LEGS];
    double supply_share;       /* share of the supply pressure that acts; below 1 while the supply
                                * is switched on or off, 0 while it is off */
    bool extended;             /* the model has laws of the valves' openings, hoses, or flow
                                * resistances of the mains */
};

/* Pressures of the supply and of the tank at the valves. */
struct mains {
    double supply_pa, tank_pa;
};

/* Prepares a model; params must outlive it. */
void cylinder_model_init(struct cylinder_model *m, const struct params *params);

/* Finds the inertance, kg/m^4, and the laminar resistance, Pa s/m^3, of the oil in a pipe. */
void cylinder_pipe(double length_m, double bore_m, double *inertance, double *resistance);

/* Returns the pressures of the mains, without the pressure drop in the hoses to the power unit. */
struct mains cylinder_mains(const struct cylinder_model *m);

/* Computes the time derivative of the state of a leg without hoses. opening: opening of the valve;
 * it equals s->spool unless machine_opening() changes it. valve: command of the valve. */
struct cylinder_state cylinder_derivative(const struct cylinder_model *m, int leg, const struct mains *mains,
                                          const struct cylinder_state *s, double opening, double length_m, double rate_mps, double valve);

/* Computes the time derivative of the state of a leg with hoses. */
struct cylinder_state cylinder_hose_derivative(const struct cylinder_model *m, int leg, const struct mains *mains,
                                               const struct cylinder_state *s, const struct hose_state hose[PORTS], double opening,
                                               double length_m, double rate_mps, double valve, struct hose_state hose_rate[PORTS]);

/* Computes the leg's flow from the supply and its flow to the tank. hose: NULL for a leg without
 * hoses. */
void cylinder_flows(const struct cylinder_model *m, int leg, const struct mains *mains, const struct cylinder_state *s,
                    const struct hose_state *hose, double opening, double length_m, double *supply_m3_per_s, double *tank_m3_per_s);

/* Applies limits that the derivative cannot express: the spool stops at +-1 and keeps its speed
 * limit, no chamber pressure is below vacuum, and no seal is deflected beyond sliding. To be called
 * after every substep. */
void cylinder_limit(const struct cylinder_model *m, int leg, struct cylinder_state *s);

/* Input of a piston and its valve. */
struct cylinder_input {
    double length_m, rate_mps, valve;
};

/* Makes one RK4 step and applies cylinder_limit(). in: input at the step's start, middle and end.
 * Only for a model that is not extended, because its legs are independent. */
void cylinder_step(const struct cylinder_model *m, int leg, double dt_s, const struct cylinder_input in[3], struct cylinder_state *s);

/* Makes a step of the spool alone; its motion does not depend on the chamber pressures. */
void cylinder_spool_step(const struct cylinder_model *m, int leg, double dt_s, double valve, struct cylinder_state *s);

/* Returns the stiffness of the oil: loss of hydraulic force per metre of extension with both ports
 * shut, N/m. */
double cylinder_stiffness(const struct cylinder_model *m, int leg, double length_m);

/* Returns A1 P1 - A2 P2. */
double cylinder_hydraulic_force(const struct cylinder_model *m, int leg, const struct cylinder_state *s);

/* Returns the force of the end stops on the rod. A stop is a spring and damper that only pushes:
 * the force is >= 0 at the lower stop, <= 0 at the upper one, 0 between. */
double cylinder_stop_force(const struct cylinder_model *m, int leg, double length_m, double rate_mps);

/* Returns the force of the deflected seals on the rod, positive away from the base; it depends on
 * their deflection, not on the present motion. */
double cylinder_seal_force(const struct cylinder_model *m, int leg, const struct cylinder_state *s);

/* Returns the friction for motion in a direction, +1 or -1: the viscous part of the base model plus
 * the leg friction of all effects. With sim.smooth_friction_mps the dry part is added to the
 * viscous part. */
struct friction cylinder_friction(const struct cylinder_model *m, int leg, const struct cylinder_state *s, int direction, double speed_mps);

/* Returns true if dry friction can hold any leg, so that the engine must look for legs that
 * stick. */
bool cylinder_can_stick(const struct cylinder_model *m);

#endif
