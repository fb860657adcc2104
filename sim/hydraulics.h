/* The hydraulics of all legs as one system: the cylinders (cylinder.h), the hoses between valve and
 * chamber, and the mains that all valves share. Pure, RT.
 *
 * Mains: supply = Ps - Rs q with qdot = (Qs - q) / 10 ms if Rs is not 0; tank = Pt + Rt Qt at every
 * instant. Qs and Qt are sums over the legs. */
#ifndef HEXID_HYDRAULICS_H
#define HEXID_HYDRAULICS_H

#include "cylinder.h"

struct hydraulics_state {
    struct cylinder_state cylinder[LEGS];
    /* the members below are used only if the model is extended */
    struct hose_state hose[LEGS][PORTS];
    double supply_m3_per_s; /* flow from the supply after its lag */
};

/* Puts all hoses at the pressure of their chamber, without flow in them or from the supply. */
void hydraulics_rest(struct hydraulics_state *s);

/* Drive of pistons and valves: lengths and rates of the legs up to the rods' ends, and commands. */
struct hydraulics_input {
    const double *length_m, *rate_mps, *valve;
};

/* Computes the rate of the state; if the model is not extended, only the rate of cylinder[]. */
void hydraulics_derivative(const struct cylinder_model *m, const struct hydraulics_state *s, const struct hydraulics_input *in,
                           struct hydraulics_state *rate);

/* Applies cylinder_limit to each leg. Call after every substep. */
void hydraulics_limit(const struct cylinder_model *m, struct hydraulics_state *s);

/* Makes one RK4 step and applies hydraulics_limit; input at the step's start, middle and end. */
void hydraulics_step(const struct cylinder_model *m, double dt_s, const struct hydraulics_input in[3], struct hydraulics_state *s);

#endif
