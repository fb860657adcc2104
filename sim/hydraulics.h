/* The hydraulics of all legs as one system: the cylinders (cylinder.h), the hoses between valve and
 * chamber, and the mains that all valves share. Pure, RT.
 *
 * Mains: Qs and Qt are the sums of the legs' flows from the supply and to the tank. The supply
 * pressure is Ps - Rs q, where q is Qs after a lag of 10 ms: qdot = (Qs - q) / 10 ms. The tank
 * pressure is Pt + Rt Qt, without a lag. */
#ifndef HEXID_HYDRAULICS_H
#define HEXID_HYDRAULICS_H

#include "cylinder.h"

struct hydraulics_state {
    struct cylinder_state cylinder[LEGS];
    /* the members below are used only if cylinder_model.extended is true */
    struct hose_state hose[LEGS][PORTS];
    double supply_m3_per_s; /* flow from the supply after its lag */
};

/* Puts every hose at the pressure of its chamber, without flow in the hoses or from the supply. */
void hydraulics_rest(struct hydraulics_state *s);

/* Inputs of each leg: its length up to the rod's end, the rate of that length, and the valve's
 * command, -1..1. */
struct hydraulics_input {
    const double *length_m, *rate_mps, *valve;
};

/* Computes the rate of the state; for a model that is not extended, only that of cylinder[]. */
void hydraulics_derivative(const struct cylinder_model *m, const struct hydraulics_state *s, const struct hydraulics_input *in,
                           struct hydraulics_state *rate);

/* Applies cylinder_limit to each leg. Call after every substep. */
void hydraulics_limit(const struct cylinder_model *m, struct hydraulics_state *s);

/* Makes one RK4 step and applies hydraulics_limit(). in: input at the step's start, middle and
 * end. */
void hydraulics_step(const struct cylinder_model *m, double dt_s, const struct hydraulics_input in[3], struct hydraulics_state *s);

#endif
