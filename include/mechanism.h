/* Mechanisms: the kinds of machine that hexid supports. Each is one file in src/mechanism/, named
 * after the mechanism: its properties, its refusals in words, and the forces of its legs for a
 * motion. All other code but the CSV import asks for one of these properties, never for the
 * mechanism's name, so that a new mechanism is a new file, a mechanism_kind and a row of
 * mechanism_table (docs/extending.md has the exceptions). Functions change nothing but their
 * arguments; any thread, with arguments of its own. */
#ifndef HEXID_MECHANISM_H
#define HEXID_MECHANISM_H

#include <stddef.h>

#include "types.h"

/* Value of the key `mechanism`, and index in mechanism_table. The first mechanism is that of the
 * built-in configuration, and of a CSV file that does not tell its mechanism by its head or
 * columns. */
enum mechanism_kind { MECHANISM_STEWART, MECHANISM_AXIS };

enum { MECHANISM_NAME = 16, MECHANISM_MASSES = 8 };

struct params;                 /* params.h */
struct machine;                /* sim/machine.h */
struct rigid_legs;             /* sim/rigid.h */
struct inverse_dynamics;       /* src/residual/inverse_dynamics.h */
struct inverse_dynamics_input; /* src/residual/inverse_dynamics.h */

/* A mass or moment of inertia that the configuration states. Its tolerance is
 * model.tolerance.mass. */
struct mechanism_mass {
    const char *name; /* configuration key */
    size_t offset;    /* offset of the value in struct params, or of the first leg's value; 0 ends a
                       * list */
    bool per_leg;     /* every leg has a value of its own */
};

struct mechanism {
    char name[MECHANISM_NAME]; /* name in the configuration, in CSV files and in JSON */

    /* Properties. */
    int legs;                  /* number of legs, at most LEGS; if there is only one, messages name
                                * no leg, and the names of CSV columns have no leg number */
    int axes;                  /* number of axes of the reference, which are the first ones of
                                * dof_names; of an effect that has a key for each axis, only the
                                * keys of these axes are used */
    bool pose;                 /* the six legs carry a body on joints, so that their lengths
                                * determine a pose of six axes; joints, inertias and geometry then
                                * count. false: the length of the only leg is the position on the
                                * axis */
    bool default_machine;      /* the built-in configuration describes this mechanism; for any other
                                * mechanism, cylinder diameters count only if the configuration
                                * states them */
    bool force_sensor;         /* recordings may have a measured force in place of the pressures;
                                * the force sensor has a lag (axis.force_lag_s) and a constant error
                                * (axis.force_offset_n) */
    bool short_strokes;        /* the strokes are so short that the evaluation may leave out
                                * instants near a reversal (inverse_dynamics.h, resolution_s) */
    struct mechanism_mass masses[MECHANISM_MASSES];
    const char *csv_column;    /* CSV column that every recording of this mechanism has, and no
                                * recording of another mechanism; NULL: there is none */

    /* Messages, with reason and remedy, by which the mechanism refuses a use; NULL: it allows this
     * use. */
    struct {
        const char *run;       /* driving the machine with hexid; a mechanism that refuses this has
                                * recordings of an unknown controller */
        const char *survey;    /* `run --survey` */
        const char *identify;  /* identification of an inertia matrix */
        const char *replay;    /* a simulation of the recorded tests in closed loop */
        const char *no_column; /* a CSV file without csv_column */
        const char *axis;      /* a CSV file of a test on an axis that this mechanism lacks */
    } refuses;

    /* Words. */
    struct {
        const char *machine;   /* the machine in one phrase: "a platform" */
        const char *legs;      /* the number of its legs: "six legs" */
        const char *length;    /* quantity that the length sensors measure: "position" */
        const char *tone;      /* experiment that finds the source of a tone that the tests do not
                                * cause */
    } words;

    /* Replaces a platform's constants by those of this mechanism: moving mass, gravity, lengths.
     * NULL: a platform's constants stay. */
    void (*constants)(const struct params *params, struct machine *machine);
    /* Finds the force that the bodies need from each leg, N, without the legs' friction. legs: set
     * to the legs' geometry if the mechanism has a pose. Returns false if no pose has these
     * lengths. */
    bool (*forces)(struct inverse_dynamics *d, const struct inverse_dynamics_input *in, struct rigid_legs *legs, double force_n[LEGS]);
    /* Computes the mass matrix in leg coordinates at neutral, kg: leg forces per leg
     * acceleration. */
    void (*leg_mass)(const struct params *params, double lambda[LEGS][LEGS]);
};

extern const struct mechanism mechanism_stewart, mechanism_axis;

/* All mechanisms and their names, ended by NULL, in the order of enum mechanism_kind. */
extern const struct mechanism *const mechanism_table[];
extern const char *const mechanism_names[];

/* Returns the index in mechanism_table of the mechanism with this name, or -1. */
int mechanism_find(const char *name);

/* Return the configured mechanism, and the number of its legs. */
const struct mechanism *params_mechanism(const struct params *params);
int params_legs(const struct params *params);

#endif
