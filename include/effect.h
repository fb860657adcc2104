/* Effects of the plant: what a real machine has and the base model has not. One file each in
 * sim/effects/, named as the effect; make collects them into effect_table, so that a new effect is
 * a new file and nothing else. The simulator applies them with either engine, the gap workflow
 * diagnoses with them: the physics of an effect is written once, and so is what it has in common
 * with others. All hooks are pure functions of what they are given, any thread, RT. Every effect is
 * off until one of its keys is set. */
#ifndef HEXID_EFFECT_H
#define HEXID_EFFECT_H

#include <stddef.h>

#include "types.h"

enum { EFFECT_KEYS = 6, EFFECT_TIES = 6, EFFECTS_MAX = 48 };

struct machine; /* sim/machine.h */

struct effect_key {
    const char *name;  /* with its unit: force_extend_n */
    const char *unit;
    double min, max;
    double neutral;    /* the value that adds nothing; of a key that only shapes the law (a
                        * speed, a diameter), a usual one */
    double typical;    /* of an ordinary machine that has the effect: plain to see, and far
                        * from breaking the machine */
    bool per_leg;      /* may be a list of six */
    bool shape;        /* it only shapes the law, whose strength another key is */
    bool reciprocal;   /* it is the reciprocal that grows with the effect: a
                        * lowest frequency, a softest oil */
};

/* Values in use; value[k][leg], all six alike unless a list was given. */
struct effect_values {
    bool on;
    double value[EFFECT_KEYS][LEGS];
};

/* Motion of a leg as a friction law sees it. */
struct leg_motion {
    int direction;      /* +1 extending, -1 retracting; at rest: the
                         * direction the load would move it */
    double speed_mps;   /* >= 0 */
    double p1_pa, p2_pa;
    double deflection;  /* of its seals, from -1, sliding in, to 1, sliding out; 0 without */
    double a1_m2, a2_m2; /* piston areas, rodless and rod side */
};

/* Resistance to motion. Of all effects and the configuration together the dry and the viscous part
 * are >= 0. The dry part also holds a body at rest against any load up to it; the viscous part
 * vanishes there. */
struct friction {
    double dry;     /* N, or N m about a joint's axis */
    double viscous; /* the same: a force at this speed, no coefficient */
    double elastic; /* the same, against extension, either sign: of seals that are deflected */
};

/* A parameter of the base model by its place in struct params, which is never 0:
 * PARAMETER(payload.mass_kg). Of six legs: the first one's. Takes params.h. */
#define PARAMETER(member) offsetof(struct params, member)

/* The experiment that tells an effect from another one, or from a parameter of the base. */
struct effect_experiment {
    const struct effect *from; /* NULL: a parameter */
    size_t from_parameter;     /* 0: an effect */
    const char *record;        /* what to measure; options of `hexid run` in backquotes: the new log
                                * goes to `hexid gap` with the same --set */
    const char *record_axis;   /* the same for one axis, which hexid does not drive;
                                * NULL: in the same words */
    const char *shows;         /* why that tells: "a delay's phase grows with frequency" */
};

struct effect {
    const char *name;
    const char *plain;      /* what people call it: "air in the oil" */
    const char *law;        /* one line, with the formula */
    const char *signature;  /* where it shows: channel, harmonic, feature */
    double law_error;       /* how far the law of a real machine may be from this one, as a share of
                             * what the effect contributes */
    struct effect_key keys[EFFECT_KEYS]; /* ended by a NULL name */

    /* What it has in common with others; lists that zeros end. Another effect is named by its
     * object, declared in the file: the linker knows whether there is one. */

    /* Parameters of the base that do the same, or nearly so: none is fitted beside the effect
     * (src/gap/hypothesis.h). */
    size_t parallel_to[EFFECT_TIES];
    /* Effects that are a limit of this one's parameters: where both explain the same,
     * it is the other. */
    const struct effect *contains[EFFECT_TIES];
    /* A pair stands in one of its two files, that of the effect written later (of two written
     * together, the first by name): a new effect changes no other's file. A pair without an
     * experiment of its own gets a general advice (src/gap/experiment.h). */
    struct effect_experiment told_apart[EFFECT_TIES];

    /* What the effect does; any of these may be NULL. Values are of an effect that is on. */

    /* Changes the constants of the machine: masses, joint positions, gravity, valves, oil, seals,
     * pipes, sensors, timing. */
    void (*machine)(const struct effect_values *v, struct machine *m);
    /* Friction along a leg, added to *add. */
    void (*leg_friction)(const struct effect_values *v, int leg, const struct leg_motion *motion, struct friction *add);
    /* Friction about one axis of a universal joint of a leg, added to *add. */
    void (*joint_friction)(const struct effect_values *v, int leg, double speed_radps, struct friction *add);
    /* Wrench on the platform about the origin of {M}, in {B}, in a pose; added to wrench. */
    void (*wrench)(const struct effect_values *v, const double pose[DOFS], double wrench[DOFS]);
    /* How far the valve is open, -1..1, for a spool position -1..1. */
    double (*opening)(const struct effect_values *v, int leg, double spool);
    /* The command that reaches the spool's servo. *memory is the effect's own, of this leg, and
     * starts at 0. Called again while a command holds. */
    double (*command)(const struct effect_values *v, int leg, double command, double *memory);
};

/* All effects by name, ended by NULL; their order is that of params.effects. Made from
 * sim/effects/ by make. */
extern const struct effect *const effect_table[];

/* The effect's place in the table, or -1. */
int effect_find(const char *name);

/* The effect at a strength: 0 adds nothing, 1 is the typical one, in between and beyond in
 * proportion, within each key's range. */
void effect_at(const struct effect *effect, double strength, struct effect_values *values);

/* Are the values of all legs neutral? Has an effect any strength, whatever its shape? */
bool effect_neutral(const struct effect_key *key, const double value[LEGS]);
bool effect_acts(const struct effect *effect, const struct effect_values *values);

#endif
