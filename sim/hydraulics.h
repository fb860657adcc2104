/* The hydraulics of all six legs as one system: cylinder.h's legs, the lines between valve and
 * chamber, and the mains that all valves share. Pure, RT.
 *
 * Mains: supply = Ps - Rs q with qdot = (Qs - q) / 10 ms, where Rs is not 0; tank = Pt + Rt Qt at
 * every instant. Qs and Qt: sums over the legs.
 */
#ifndef HEXID_HYDRAULICS_H
#define HEXID_HYDRAULICS_H

#include "cylinder.h"

struct hydraulics_state {
    struct cylinder_state cylinder[LEGS];
    /* At work only in an extended model: */
    struct line_state line[LEGS][PORTS];
    double supply_m3_per_s; /* lagged */
};

/* Lines and gauges at chamber pressure, no flow. */
void hydraulics_rest(struct hydraulics_state *s);

/* What moves the pistons: lengths and rates of the legs, up to the rods' ends, and the valve
 * commands. */
struct hydraulics_input {
    const double *length_m, *rate_mps, *valve;
};

/* Rate of the state; of cylinder[] alone in a model that is not extended. */
void hydraulics_derivative(const struct cylinder_model *m, const struct hydraulics_state *s, const struct hydraulics_input *in,
                           struct hydraulics_state *rate);

/* What a derivative cannot say: cylinder_limit of each leg. After every substep. */
void hydraulics_limit(const struct cylinder_model *m, struct hydraulics_state *s);

/* One Runge-Kutta step of fourth order and hydraulics_limit; the input at its
 * start, middle and end. */
void hydraulics_step(const struct cylinder_model *m, double dt_s, const struct hydraulics_input in[3], struct hydraulics_state *s);

#endif
