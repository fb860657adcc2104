/* The hydraulics of all six legs as one system: cylinder.h's legs, the lines between valve and
 * chamber, the play of the joints at the legs' ends, and the mains that all valves share. Pure, RT.
 *
 * Mains: supply = Ps - Rs q with qdot = (Qs - q) / 10 ms, where Rs is not 0; tank = Pt + Rt Qt at
 * every instant. Qs and Qt: sums over the legs.
 *
 * Joint play y: the piston stands y ahead of the joint, |y| <= clearance/2; chambers, leg friction
 * and length sensor belong to the piston, the rod's mass and the end stops to the joint. The piston
 * itself has no mass: off the joint's flanks it runs at the speed at which the hydraulic force
 * equals its friction and the drag of the oil film in the joint, so thick that the chambers'
 * springs come to rest in it within 0.2 ms (2 kN s/m at mid-stroke); at a flank it moves with the
 * joint, for as long as it is pressed against it. So the joint is at the flank that the leg's force
 * points to, and crosses over when that force changes sign. Not modelled: bouncing (no mass, no
 * bounce), play across the leg. */
#ifndef HEXID_HYDRAULICS_H
#define HEXID_HYDRAULICS_H

#include "cylinder.h"

struct hydraulics_state {
    struct cylinder_state cylinder[LEGS];
    /* At work only in an extended model: */
    struct line_state line[LEGS][PORTS];
    double play_m[LEGS];
    double supply_m3_per_s; /* lagged */
};

/* Lines and gauges at chamber pressure, no flow; joints pressed to the flank that these forces
 * along the legs point to. */
void hydraulics_rest(const struct cylinder_model *m, const double force_n[LEGS], struct hydraulics_state *s);

/* What moves the legs: joint to joint lengths and rates, and the valve commands. */
struct hydraulics_input {
    const double *length_m, *rate_mps, *valve;
};

/* Rate of the state; of cylinder[] alone in a model that is not extended. */
void hydraulics_derivative(const struct cylinder_model *m, const struct hydraulics_state *s, const struct hydraulics_input *in,
                           struct hydraulics_state *rate);

/* What a derivative cannot say: cylinder_limit, and the flanks of the joints.
 * After every substep. */
void hydraulics_limit(const struct cylinder_model *m, const double length_m[LEGS], struct hydraulics_state *s);

/* One Runge-Kutta step of fourth order and hydraulics_limit; the input at its
 * start, middle and end. */
void hydraulics_step(const struct cylinder_model *m, double dt_s, const struct hydraulics_input in[3], struct hydraulics_state *s);

/* Drag of the oil film in a leg's joint, N s/m, piston at this length. */
double hydraulics_film(const struct cylinder_model *m, int leg, double length_m);

/* What a leg gives to its joint. */
struct leg_push {
    bool loose;            /* off the flanks: no friction of the leg reaches the joint */
    double piston_mps;     /* speed of the piston where loose, else the joint's */
    double force_n;        /* where loose: on the joint, instead of hydraulic force and friction */
    double least_n, most_n;/* else: bounds of hydraulic force and friction
                            * together; infinite without play */
};

struct leg_push hydraulics_push(const struct cylinder_model *m, int leg, const struct hydraulics_state *s, double length_m,
                                double rate_mps);

#endif
