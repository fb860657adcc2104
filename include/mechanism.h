/* Mechanisms: the kinds of machine that hexid knows. Each is one file in src/mechanism/, named as
 * the mechanism: what it has, what it refuses and in which words, and how its legs' forces follow
 * from its motion. All other code asks for one of these properties, never which mechanism it is, so
 * that a new mechanism is a new file and a row of mechanism_table. All functions are pure functions
 * of their arguments, any thread. */
#ifndef HEXID_MECHANISM_H
#define HEXID_MECHANISM_H

#include <stddef.h>

#include "types.h"

/* Value of the key `mechanism`, and place in mechanism_table. The first is that of the built-in
 * configuration, and of a CSV file that does not say. */
enum mechanism_kind { MECHANISM_STEWART, MECHANISM_AXIS };

enum { MECHANISM_NAME = 16, MECHANISM_MASSES = 8 };

struct params;                 /* params.h */
struct machine;                /* sim/machine.h */
struct rigid_legs;             /* sim/rigid.h */
struct inverse_dynamics;       /* src/residual/inverse_dynamics.h */
struct inverse_dynamics_input; /* src/residual/inverse_dynamics.h */

/* A mass or moment of inertia that the configuration states, within model.tolerance.mass. */
struct mechanism_mass {
    const char *name; /* configuration key */
    size_t offset;    /* offset in struct params of it, or of the first leg's; 0 ends a
                       * list */
    bool per_leg;     /* every leg has a value */
};

struct mechanism {
    char name[MECHANISM_NAME]; /* name in the configuration, in CSV files and in JSON */

    /* Properties. */
    int legs;                  /* number of its legs, at most LEGS; with one leg its texts name no
                                * leg, and its CSV columns no number */
    int axes;                  /* number of the axes of its reference, the first of dof_names; an
                                * effect that acts on the pose has as many keys */
    bool pose;                 /* its six legs carry a body on joints, so that their lengths
                                * determine a pose of six axes, and joints, inertias and geometry
                                * count; without a pose the length is the position on the axis */
    bool default_machine;      /* the built-in configuration is of this mechanism; on another one,
                                * the diameters of cylinders count only where they are stated */
    bool force_sensor;         /* its force may be measured instead of pressures (with the lag
                                * axis.force_lag_s), and has a constant of its own
                                * (axis.force_offset_n) */
    bool short_strokes;        /* its strokes are so short that instants about a reversal may be
                                * spared (inverse_dynamics.h, resolution_s) */
    struct mechanism_mass masses[MECHANISM_MASSES];
    const char *csv_column;    /* CSV column that its recordings always have, and no other
                                * mechanism's; NULL: there is none */

    /* Refusals: the reason and the remedy; NULL: it does not refuse. */
    struct {
        const char *run;       /* being driven by hexid; also means that the controller of its
                                * recordings is unknown */
        const char *survey;    /* `run --survey` */
        const char *identify;  /* an inertia matrix */
        const char *replay;    /* a simulation of the recorded tests in closed loop */
        const char *no_column; /* a CSV file without csv_column */
        const char *axis;      /* a CSV file of a test of an axis that it does not have */
    } refuses;

    /* Words. */
    struct {
        const char *machine;   /* the machine in one phrase: "a platform" */
        const char *legs;      /* the number of its legs: "six legs" */
        const char *length;    /* what its length sensors measure: "position" */
        const char *tone;      /* experiment that tells where a tone beside the tests comes from */
    } words;

    /* Replaces constants of a platform by its own: moving mass, gravity, lengths. NULL: it is a
     * platform. */
    void (*constants)(const struct params *params, struct machine *machine);
    /* Finds the force that the bodies need from each leg, friction of the legs left out. legs: set
     * to the legs' geometry if the mechanism has a pose. False: no pose has these lengths. */
    bool (*forces)(struct inverse_dynamics *d, const struct inverse_dynamics_input *in, struct rigid_legs *legs, double force_n[LEGS]);
    /* Finds the mass matrix in the space of the legs at neutral, kg: forces along the legs per
     * acceleration of the legs. */
    void (*leg_mass)(const struct params *params, double lambda[LEGS][LEGS]);
};

extern const struct mechanism mechanism_stewart, mechanism_axis;

/* All mechanisms and their names, ended by NULL, in the order of enum mechanism_kind. */
extern const struct mechanism *const mechanism_table[];
extern const char *const mechanism_names[];

/* Returns the place in the table of the mechanism with this name, or -1. */
int mechanism_find(const char *name);

/* The configured mechanism, and the number of its legs. */
const struct mechanism *params_mechanism(const struct params *params);
int params_legs(const struct params *params);

#endif
