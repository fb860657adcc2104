/* Hypotheses: every effect of the catalogue, in the shapes in which a machine has it: all legs
 * alike, one leg, each leg its own. */
#ifndef HEXID_HYPOTHESIS_H
#define HEXID_HYPOTHESIS_H

#include "fit.h"

enum { SHAPE_ALL = -1, SHAPE_EACH = -2 }; /* or a leg, 0..5 */
enum { HYPOTHESES_MAX = EFFECTS_MAX * (2 + LEGS), HYPOTHESIS_VARIABLES = EFFECT_KEYS * LEGS };

struct hypothesis {
    int effect, shape;
    int variables;
    struct variable variable[HYPOTHESIS_VARIABLES];
};

/* All of them for this model but those of effects found and those that what is evaluated cannot
 * show; their priors are those of the configuration given. Returns their number. */
int hypotheses_list(const struct params *given, const struct params *model, const bool found[EFFECTS_MAX], enum residual_part evaluated,
                    struct hypothesis h[HYPOTHESES_MAX]);

enum residual_part hypothesis_parts(const struct hypothesis *h);

/* Every variable at this strength of its effect (effect_at). False: there is no such, as of the
 * other sign of what has one. */
bool hypothesis_at(const struct hypothesis *h, double strength, struct params *model);

/* Can a variable of the base be fitted beside this effect? The same thing, or nearly so: no, it
 * stays as it is given. Each leg's own where the effect has all legs alike: yes, drawn to what is
 * given, for what they have in common is the effect's. */
enum parallel { PARALLEL_NOT, PARALLEL_DRAWN, PARALLEL_SAME };
enum parallel hypothesis_parallel(const struct hypothesis *h, const struct variable *base);

/* The base's variable beside the effect, drawn as strongly as values anywhere in
 * its box scatter. */
void variable_draw(struct variable *base);

/* The first effect has the second one as a limit of its parameters: where both explain the same,
 * it is the second. */
bool hypothesis_contains(int effect, int other);

/* Can there be a machine of this model? */
bool hypothesis_possible(const struct params *model);

#endif
