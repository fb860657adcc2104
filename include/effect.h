/* Effects of the plant: properties of a real machine that the base model lacks. Each is one file in
 * sim/effects/, named after the effect; make collects them into effect_table, so that adding an
 * effect means adding one file. The simulator applies them with either engine, and `hexid gap`
 * diagnoses with the same files, so that the physics of an effect and its relations to others are
 * written once. All hooks are pure functions of their arguments, any thread, RT. Every effect is
 * off until one of its keys is set. */
#ifndef HEXID_EFFECT_H
#define HEXID_EFFECT_H

#include "types.h"

enum { EFFECT_KEYS = 6, EFFECT_TIES = 6, EFFECTS_MAX = 48 };

struct machine; /* sim/machine.h */

struct effect_key {
    const char *name;  /* name with the unit: force_extend_n */
    const char *unit;
    double min, max;
    double neutral;    /* value at which the effect adds nothing; for a key with shapes_law (a
                        * speed, a diameter) a usual value */
    double typical;    /* value in an ordinary machine that has the effect: large enough to be seen
                        * plainly, far from breaking the machine */
    bool per_leg;      /* the key may be a list of six values */
    bool shapes_law;   /* the key only shapes the law; another key sets the strength */
    bool reciprocal;   /* the effect grows with the reciprocal of the value, as with the corner
                        * frequency of a lag or the bulk modulus of oil with air */
};

/* Values of an effect's keys, value[key][leg]. All six values of a key are equal unless the
 * configuration gives a list. */
struct effect_values {
    bool on;
    double value[EFFECT_KEYS][LEGS];
};

/* Motion of a leg as a friction law sees it. */
struct leg_motion {
    int direction;      /* +1 extending, -1 retracting; at rest the direction in which the load
                         * would move it */
    double speed_mps;   /* speed of the motion, >= 0 */
    double p1_pa, p2_pa;
    double deflection;  /* deflection of the seals as a share of the deflection at which they slide:
                         * -1 retracting .. 1 extending; 0 if no seals are modelled */
    double a1_m2, a2_m2; /* piston areas, rodless and rod side */
};

/* Resistance to motion. All effects and the configuration add to the dry and to the viscous part;
 * both sums are >= 0. A body at rest stays at rest under any load up to the dry part; the viscous
 * part is 0 at rest. */
struct friction {
    double dry;     /* dry part: N along a leg, or N m about a joint's axis */
    double viscous; /* viscous part at this speed, in the unit of `dry`; not a coefficient */
    double elastic; /* force of deflected seals against extension, in the unit of `dry`; either
                     * sign */
};

/* An experiment that distinguishes an effect from another effect, or from a parameter of the base
 * model. */
struct effect_experiment {
    const struct effect *from; /* the other effect; NULL if `from_parameter` is set */
    const char *from_parameter; /* name of the base parameter, "axis.force_offset_n"; NULL if `from`
                                 * is set */
    const char *record;        /* instructions for the measurement, with the options of `hexid run`
                                * in backquotes; `hexid gap` reads the new log with the same --set
                                * options */
    const char *record_axis;   /* instructions for a machine of one axis, which hexid does not
                                * drive; NULL: `record` applies to such a machine, too */
    const char *shows;         /* reason why the measurement tells the two apart: "a delay's phase
                                * grows with frequency" */
};

/* Families of effects: parts of a machine whose effects imitate one another. If no law fits well
 * enough to be named, often the family can be named. */
enum effect_family {
    EFFECT_FRICTION, /* friction in the cylinders */
    EFFECT_JOINTS,   /* friction and play of the joints */
    EFFECT_BODIES,   /* masses, mass centres, inertias */
    EFFECT_LOAD,     /* forces that depend on position */
    EFFECT_VALVE,
    EFFECT_OIL,      /* oil, leakage and lines */
    EFFECT_SUPPLY,
    EFFECT_SENSORS,
    EFFECT_TIMING,
    EFFECT_GEOMETRY,
    EFFECT_FAMILIES
};
/* Name of a family in files, and its words for people: "friction in the cylinders". */
struct effect_family_words {
    const char *name, *words;
};
extern const struct effect_family_words effect_families[EFFECT_FAMILIES];

struct effect {
    const char *name;
    enum effect_family family;
    const char *plain;      /* everyday name of the effect: "a tilt of the base" */
    const char *law;        /* the effect's law in one line, with the formula */
    const char *signature;  /* signs of the effect in the data: channel, harmonic, feature */
    double law_error;       /* expected error of this law on a real machine, as a share of what the
                             * effect contributes */
    bool one_axis;          /* hexid gap looks for the effect only if the machine has one axis */
    struct effect_key keys[EFFECT_KEYS]; /* keys of the effect; a key with a NULL name ends the
                                          * list */

    /* Relations to other effects; zeros end each list. Other effects are named by the addresses of
     * their objects, so that the linker refuses an effect that does not exist. */

    /* Parameters of the base model whose changes look nearly the same as this effect, by their
     * names in src/gap/base.c and src/residual/systematic.c. hypothesis_parallel()
     * (src/gap/hypothesis.h) decides which of them are fitted together with the effect. */
    const char *parallel_to[EFFECT_TIES];
    /* Effects that are limiting cases of this one. A limiting case that explains the data equally
     * well is preferred. */
    const struct effect *contains[EFFECT_TIES];
    /* Experiments that distinguish this effect from others. If two effects were written at
     * different times, their experiment stands in the file of the later one, so that a new effect
     * changes no other file; if they were written together, in the file that comes first by name. A
     * pair without an experiment gets general advice (src/gap/experiment.h). */
    struct effect_experiment told_apart[EFFECT_TIES];

    /* Hooks; any may be NULL. They are called only while the effect is on. */

    /* Changes constants of the machine: masses, joint positions, gravity, valves, oil, seals,
     * hoses, sensors, timing. */
    void (*machine)(const struct effect_values *v, struct machine *m);
    /* Adds friction along a leg to *add. */
    void (*leg_friction)(const struct effect_values *v, int leg, const struct leg_motion *motion, struct friction *add);
    /* Adds friction about one axis of a universal joint of a leg to *add. */
    void (*joint_friction)(const struct effect_values *v, int leg, double speed_radps, struct friction *add);
    /* Adds a wrench on the platform in a pose, about the origin of {M}, in {B}. */
    void (*wrench)(const struct effect_values *v, const double pose[DOFS], double wrench[DOFS]);
    /* Returns the opening of the valve, -1..1, for a spool position -1..1. */
    double (*opening)(const struct effect_values *v, int leg, double spool);
    /* Returns the command that reaches the spool's servo. *memory belongs to this effect and leg
     * and starts at 0. The hook is called in every substep, also while the command stays the
     * same. */
    double (*command)(const struct effect_values *v, int leg, double command, double *memory);
};

/* All effects in alphabetical order, ended by NULL; params.effects has the same order. make
 * generates it from sim/effects/. */
extern const struct effect *const effect_table[];

/* Returns the effect's index in effect_table, or -1. */
int effect_find(const char *name);

/* Switches the effect on and sets its values for a strength: 0 is neutral, 1 is typical. For other
 * strengths the value (or the reciprocal of the value, if the key is `reciprocal`) is linear in the
 * strength. A value outside the key's range is moved to the nearer end of the range. */
void effect_at(const struct effect *effect, double strength, struct effect_values *values);

/* effect_neutral() returns true if the key is neutral on all legs. effect_acts() returns true if
 * some key that sets the strength is not neutral. */
bool effect_neutral(const struct effect_key *key, const double value[LEGS]);
bool effect_acts(const struct effect *effect, const struct effect_values *values);

#endif
