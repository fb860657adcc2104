/* Hypotheses: each effect of the catalogue with each choice of legs: one value for all legs, one
 * leg alone, a value for each leg. */
#ifndef HEXID_HYPOTHESIS_H
#define HEXID_HYPOTHESIS_H

#include "fit.h"

enum { SHAPE_ALL = -1, SHAPE_EACH = -2 }; /* or one leg, 0..5 */
enum { HYPOTHESES_MAX = EFFECTS_MAX * (2 + LEGS), HYPOTHESIS_VARIABLES = EFFECT_KEYS * LEGS };

struct hypothesis {
    int effect, shape;
    int variables;
    struct variable variable[HYPOTHESIS_VARIABLES];
};

/* Lists all hypotheses for this model, except effects already found and effects that the
 * evaluated residuals cannot show. Priors come from the given configuration. Returns their
 * number. */
int hypotheses_list(const struct params *given, const struct params *model, const bool found[EFFECTS_MAX], enum residual_part evaluated,
                    struct hypothesis h[HYPOTHESES_MAX]);

enum residual_part hypothesis_parts(const struct hypothesis *h);

/* Sets every variable to this strength of its effect (effect_at). Returns false if the effect
 * does not exist with this sign: the model is unchanged. */
bool hypothesis_at(const struct hypothesis *h, double strength, struct params *model);

/* Can a base variable be fitted beside this effect? PARALLEL_SAME: no, they are (nearly) the
 * same, and the variable stays at its given value. PARALLEL_DRAWN: yes, but with a prior about
 * its given value: the effect takes what all legs have in common, each leg's own variable the
 * rest. */
enum parallel { PARALLEL_NOT, PARALLEL_DRAWN, PARALLEL_SAME };
enum parallel hypothesis_parallel(const struct hypothesis *h, const struct variable *base);

/* Gives a base variable the prior it has beside a parallel effect: mean at the middle of its
 * box, standard deviation of a uniform distribution over the box. */
void variable_draw(struct variable *base);

/* True if the second effect is a special case of the first: then the second is preferred. */
bool hypothesis_contains(int effect, int other);

/* True if a machine with this model can exist (machine_check). */
bool hypothesis_possible(const struct params *model);

#endif
