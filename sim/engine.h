/* A rigid-body engine with its coupling to the hydraulics. There are two, derived independently:
 *
 *   sim/engine_ode.c          13 bodies in ODE; ODE's semi-implicit Euler is used as a leapfrog.
 *                             First the bodies are stepped, then the hydraulics by RK4 over the
 *                             motion of the bodies.
 *   sim/engine_closed_form.c  6 degrees of freedom; RK4 over bodies and hydraulics together. The
 *                             instants at which legs stick are located inside the substep.
 *
 * RT, no heap after create.
 *
 * Universal joints of both engines: at each end of a leg the first axis is fixed in the base (or
 * the platform) and the second in the cylinder (or rod); joint friction acts about both axes. The
 * first axis is as configured, or else horizontal at neutral and tangential to the joint circle:
 * (-sin angle, cos angle, 0), with the joint's angle about z of the drawing. */
#ifndef HEXID_ENGINE_H
#define HEXID_ENGINE_H

#include "hydraulics.h"
#include "plant.h"

/* Joint positions and axes by the configured geometry (docs/method.md, 1), computed in sim
 * independently of src/core. */
struct sim_geometry {
    double upper[LEGS][3];       /* joints on the platform, m, in {M} */
    double upper_axis[LEGS][3];  /* first axes of the upper universal joints, unit vectors in {M} */
    double lower[LEGS][3];       /* joints on the base, m, in {B} */
    double lower_axis[LEGS][3];  /* first axes of the lower universal joints, unit vectors in {B} */
    double neutral_length_m[LEGS];
};
void sim_geometry_init(struct sim_geometry *g, const struct params *params);

struct engine; /* each engine embeds this as its first member */

struct engine_ops {
    const char *name;
    struct engine *(*create)(const struct params *params, struct error *error);
    void (*destroy)(struct engine *e);
    /* Puts the bodies at rest in this pose: legs with dry friction are stuck. ahead_m: distance of
     * each rod ahead of its joint (machine_ahead()); 0 without backlash. */
    void (*place)(struct engine *e, const double pose[DOFS], const double ahead_m[LEGS]);
    /* Makes one substep of bodies and hydraulics together, with hydraulics_limit(). The valve
     * commands are constant over the substep. */
    void (*substep)(struct engine *e, double dt_s, const double valve[LEGS], struct hydraulics_state *hydraulics);
    /* Makes one substep of the bodies alone under these forces along the legs
     * (plant_step_forced()). */
    void (*forced)(struct engine *e, double dt_s, const double force_n[LEGS]);
    /* Sets the share of the supply pressure that acts from now on, 0..1. */
    void (*supply)(struct engine *e, double share);
    /* Fills in pose, twist, length, rate, friction, stuck and the energies. */
    void (*truth)(const struct engine *e, const struct hydraulics_state *hydraulics, struct plant_truth *truth);
};

struct engine {
    const struct engine_ops *ops;
};

extern const struct engine_ops engine_ode, engine_closed_form;

#endif
