/* Effects of the plant: one file each in sim/effects/, one table. The simulator applies them, the gap workflow diagnoses with them: the
 * physics of an effect is written once. An effect returns what it adds; each engine resolves stick itself. Pure functions, any thread,
 * RT. Every effect is off until one of its keys is set. */
#ifndef HEXID_EFFECT_H
#define HEXID_EFFECT_H

#include "types.h"

enum { EFFECT_KEYS = 6, EFFECTS_MAX = 48 };

struct effect_key {
    const char *name;  /* with its unit: force_extend_n */
    const char *unit;
    double min, max;
    double neutral;    /* the value that adds nothing */
    bool per_leg;      /* may be a list of six */
};

/* Values in use; value[k][leg], all six alike unless a list was given. */
struct effect_values {
    bool on;
    double value[EFFECT_KEYS][LEGS];
};

/* Motion of a leg as a friction law sees it. */
struct leg_motion {
    int direction;      /* +1 extending, -1 retracting; at rest: the direction the load would move it */
    double speed_mps;   /* >= 0 */
    double p1_pa, p2_pa;
};

/* Resistance to motion, both >= 0. The dry part also holds a body at rest against any load up to it; the viscous part vanishes there. */
struct friction {
    double dry;     /* N, or N m about a joint's axis */
    double viscous; /* the same */
};

struct effect {
    const char *name;
    const char *law;        /* one line, with the formula */
    const char *signature;  /* where it shows: channel, harmonic, feature */
    struct effect_key keys[EFFECT_KEYS]; /* ended by a NULL name */
    /* Any of these may be NULL. Each adds to *add. */
    void (*leg_friction)(const struct effect_values *v, int leg, const struct leg_motion *motion, struct friction *add);
    void (*joint_friction)(const struct effect_values *v, int leg, double speed_radps, struct friction *add);
};

/* All effects, ended by NULL; their order is that of params.effects. */
extern const struct effect *const effect_table[];

/* The effect's place in the table, or -1. */
int effect_find(const char *name);

#endif
