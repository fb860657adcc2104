/* One leg's hydraulics: servo valve, two compressible chambers, end stops, friction. Pure, RT.
 * hydraulics.h joins six of them.
 *
 *  symbol  meaning                                            unit
 *  L, v    joint-to-joint length and its rate                 m, m/s
 *  P1, P2  chamber pressures, rodless and rod side, gauge     Pa
 *  x       spool position, -1..1; o its opening (valve laws)  -
 *  V1, V2  chamber volumes: dead volume + A1 s, A2 (stroke-s) m^3   (s = stroke used)
 *
 *  xddot = w^2 (u + bias - x) - 2 zeta w xdot, |x| <= 1, |xdot| <= the servo's limit
 *  Q(o, dP) = valve_flow |o| sqrt(dP / valve_drop)
 *             o > 0: supply -> port A (P1), port B (P2) -> tank; o < 0: the other way round
 *  P1dot = beta/V1 (Q1 - A1 v - c (P1 - P2)),  P2dot = beta/V2 (Q2 + A2 v + c (P1 - P2))
 *
 *  zdot = (v - |v| z) / d                                 z: deflection of the seals (Dahl),
 *             d at least what the rod moves in 0.2 ms
 *
 * Below a drop of 10 kPa the orifice is laminar: an odd cubic with the root's value and slope
 * there, so that nothing moves above it. The limit rises where the valve is wide open on a nearly
 * empty chamber, so that no chamber fills faster than a substep of 0.25 ms resolves. Below tank
 * pressure air comes out of the oil, beta falls with the square of what is left above vacuum, and a
 * check valve lets oil in from the tank within a millisecond: a chamber torn open stays between
 * tank pressure and vacuum, as behind an anti-cavitation valve.
 *
 * A line of length l and bore d between a port and its chamber is one cell: at the port its
 * capacitance V/beta (V = l pi d^2/4), then in series its inertance rho l/(pi d^2/4) and its
 * laminar resistance 128 mu l/(pi d^4), rho = 870 kg/m^3, mu/rho = 4e-5 m^2/s. The gauge sits at
 * the port. A line below 0.2 m counts as one of 0.2 m, and the inertance is at least what makes a
 * natural frequency of 5000 rad/s with a chamber at a tenth of its stroke, which steps of 0.5 ms
 * resolve: a short wide line is a volume of oil. */
#ifndef HEXID_CYLINDER_H
#define HEXID_CYLINDER_H

#include "machine.h"

struct cylinder_state {
    double p1_pa, p2_pa, spool, spool_rate;
    double deflection;        /* of the seals: -1 they slide in, 1 they slide out */
};

struct line_state {
    double pressure_pa;       /* at the port */
    double flow_m3_per_s;     /* into the chamber */
};

enum { PORT_A, PORT_B, PORTS };

struct cylinder_model {        /* constants derived once from params and effects */
    struct machine machine;
    int first, legs;               /* first <= leg < legs: those that the mechanism has, or the
                                    * one that is asked for */
    struct cylinder_leg {
        double a1_m2, a2_m2;
        double length_min_m, length_max_m; /* end stops */
        double valve_gain[PORTS];      /* valve_flow / sqrt(valve_drop) */
        double valve_omega_squared, valve_damping_rate; /* w^2, 2 zeta w */
        double valve_bias, valve_rate_per_s;
        double bulk_modulus_pa, leakage_m3_per_s_pa, dead_volume_m3[PORTS];
        double line_volume_m3, line_inertance, line_resistance; /* volume 0: no line */
        double seal_distance_m;        /* 0: seals slide at once */
        bool rate_limited;
    } leg[LEGS];
    double supply_share;       /* of the supply pressure that is there: 1, less
                                * while it comes and goes */
    bool extended;             /* valve laws, lines or resistance of the mains */
};

/* Pressures that the valves are fed with and drain to. */
struct mains {
    double supply_pa, tank_pa;
};

/* params must outlive the model. */
void cylinder_model_init(struct cylinder_model *m, const struct params *params);

/* Without drop in the lines to the power unit. */
struct mains cylinder_mains(const struct cylinder_model *m);

/* Time derivative of the state under valve command u at length L and rate v, chambers at the ports.
 * opening: of the valve, s->spool but for the laws of machine_opening. */
struct cylinder_state cylinder_derivative(const struct cylinder_model *m, int leg, const struct mains *mains,
                                          const struct cylinder_state *s, double opening, double length_m, double rate_mps, double valve);

/* The same behind lines. */
struct cylinder_state cylinder_line_derivative(const struct cylinder_model *m, int leg, const struct mains *mains,
                                               const struct cylinder_state *s, const struct line_state line[PORTS], double opening,
                                               double length_m, double rate_mps, double valve, struct line_state line_rate[PORTS]);

/* What the leg draws from the supply and gives to the tank; line NULL: none. */
void cylinder_flows(const struct cylinder_model *m, int leg, const struct mains *mains, const struct cylinder_state *s,
                    const struct line_state *line, double opening, double length_m, double *supply_m3_per_s, double *tank_m3_per_s);

/* What the derivative cannot say: the spool stops dead at +-1, no pressure is below vacuum, and no
 * seal is deflected further than it slides. After every substep. */
void cylinder_limit(const struct cylinder_model *m, int leg, struct cylinder_state *s);

/* What moves a piston and its valve. */
struct cylinder_input {
    double length_m, rate_mps, valve;
};

/* On by a Runge-Kutta step of fourth order, then cylinder_limit; the input at the step's start,
 * middle and end. Of a model that is not extended: its legs have nothing in common. */
void cylinder_step(const struct cylinder_model *m, int leg, double dt_s, const struct cylinder_input in[3], struct cylinder_state *s);

/* The spool alone, which nothing in the chambers moves: on by a step under this command. */
void cylinder_spool_step(const struct cylinder_model *m, int leg, double dt_s, double valve, struct cylinder_state *s);

/* By how much the hydraulic force falls per metre with both ports shut. */
double cylinder_stiffness(const struct cylinder_model *m, int leg, double length_m);

/* A1 P1 - A2 P2. */
double cylinder_hydraulic_force(const struct cylinder_model *m, int leg, const struct cylinder_state *s);

/* End stop: unilateral spring and damper, >= 0 at the lower one, <= 0 at the
 * upper one, 0 between. */
double cylinder_stop_force(const struct cylinder_model *m, int leg, double length_m, double rate_mps);

/* Of deflected seals, along the leg, whatever its motion. */
double cylinder_seal_force(const struct cylinder_model *m, int leg, const struct cylinder_state *s);

/* Sum of the base's viscous friction and of every effect's leg friction for
 * motion in a direction. */
struct friction cylinder_friction(const struct cylinder_model *m, int leg, const struct cylinder_state *s, int direction, double speed_mps);

/* Some leg may be held by dry friction: the engine has to look for stick. */
bool cylinder_can_stick(const struct cylinder_model *m);

#endif
