/* One leg's hydraulics: servo valve, two compressible chambers, end stops, friction. Shared by both engines. Pure, RT.
 *
 *  symbol  meaning                                            unit
 *  L, v    joint-to-joint length and its rate                 m, m/s
 *  P1, P2  chamber pressures, rodless and rod side, gauge     Pa
 *  x       spool position, -1..1                              -
 *  V1, V2  chamber volumes: dead volume + A1 s, A2 (stroke-s) m^3   (s = stroke used)
 *
 *  xddot = w^2 (u - x) - 2 zeta w xdot, |x| <= 1
 *  Q(x, dP) = valve_flow |x| sqrt(dP / valve_drop); x > 0: supply -> port A (P1), port B (P2) -> tank; x < 0: the other way round
 *  P1dot = beta/V1 (Q1 - A1 v - c (P1 - P2)),  P2dot = beta/V2 (Q2 + A2 v + c (P1 - P2))
 *
 * Below a drop of 10 kPa the orifice is laminar: an odd cubic with the root's value and slope there, so that nothing moves above it. The
 * limit rises where the valve is wide open on a nearly empty chamber, so that no chamber fills faster than a substep of 0.25 ms resolves.
 * Below tank pressure air comes out of the oil, beta falls with the square of what is left above vacuum, and a check valve lets oil in
 * from the tank within a millisecond: a chamber torn open stays between tank pressure and vacuum, as behind an anti-cavitation valve. */
#ifndef HEXID_CYLINDER_H
#define HEXID_CYLINDER_H

#include "params.h"

struct cylinder_state {
    double p1_pa, p2_pa, spool, spool_rate;
};

struct cylinder_model {        /* constants derived once from params */
    const struct params *params;
    double a1_m2, a2_m2;
    double length_min_m, length_max_m; /* end stops */
    double valve_gain;         /* valve_flow / sqrt(valve_drop) */
    double valve_omega_squared, valve_damping_rate; /* w^2, 2 zeta w */
    int leg_effects;           /* how many effects with leg friction are on */
    struct {
        const struct effect *effect;
        const struct effect_values *values;
    } leg_effect[EFFECTS_MAX];
};

/* params must outlive the model. */
void cylinder_model_init(struct cylinder_model *m, const struct params *params);

/* Time derivative of the state under valve command u at length L and rate v. */
struct cylinder_state cylinder_derivative(const struct cylinder_model *m, const struct cylinder_state *s, double length_m, double rate_mps,
                                          double valve);

/* What the derivative cannot say: the spool stops dead at +-1, and no pressure is below vacuum. After every substep. */
void cylinder_limit(struct cylinder_state *s);

/* A1 P1 - A2 P2. */
double cylinder_hydraulic_force(const struct cylinder_model *m, const struct cylinder_state *s);

/* End stop: unilateral spring and damper, >= 0 at the lower one, <= 0 at the upper one, 0 between. */
double cylinder_stop_force(const struct cylinder_model *m, double length_m, double rate_mps);

/* Sum of the base's viscous friction and of every effect's leg friction for motion in a direction. */
struct friction cylinder_friction(const struct cylinder_model *m, int leg, const struct cylinder_state *s, int direction, double speed_mps);

/* Some leg may be held by dry friction: the engine has to look for stick. */
bool cylinder_can_stick(const struct cylinder_model *m);

/* Sum of every effect's friction about one axis of a universal joint of this leg. */
struct friction joint_friction(const struct params *params, int leg, double speed_radps);

/* Some effect with joint friction is on. */
bool joint_friction_present(const struct params *params);

#endif
