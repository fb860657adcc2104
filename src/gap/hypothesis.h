/* Hypotheses: each effect of the catalogue with each choice of legs, which is one value for all
 * legs, one leg alone, or a value for each leg. */
#ifndef HEXID_HYPOTHESIS_H
#define HEXID_HYPOTHESIS_H

#include "effect.h"
#include "fit.h"

enum { PATTERN_ALL = -1, PATTERN_EACH = -2 }; /* a pattern of 0..5 is that leg alone */
enum { HYPOTHESES_MAX = EFFECTS_MAX * (2 + LEGS), HYPOTHESIS_VARIABLES = EFFECT_KEYS * LEGS };

struct hypothesis {
    int effect, pattern;
    bool symmetric; /* both directions have the same value, so that the effect is not parallel to a
                     * constant force */
    int variables;
    struct variable variable[HYPOTHESIS_VARIABLES];
};

/* Lists all hypotheses for this model, except for effects that were found already and effects that
 * the evaluated residuals cannot show. Priors and ranges come from the given configuration. Returns
 * the number of hypotheses. */
int hypotheses_list(const struct params *given, const struct params *model, const bool found[EFFECTS_MAX],
                    enum residual_equations evaluated, struct hypothesis h[HYPOTHESES_MAX]);

enum residual_equations hypothesis_equations(const struct hypothesis *h);

/* Sets all variables of a hypothesis to the given strength of its effect (effect_at), within their
 * bounds. Returns false if the resulting model is the one without the effect. */
bool hypothesis_at(const struct hypothesis *h, double strength, struct params *model);

/* Returns whether a base variable can be fitted beside an effect. PARALLEL_NOT: it can.
 * PARALLEL_SAME: it cannot, because variable and effect do (nearly) the same; the variable stays at
 * its given value. PARALLEL_DRAWN: it can, but with a prior about its given value, so that the
 * effect takes what all legs have in common and the variables take the differences between the
 * legs. */
enum parallel { PARALLEL_NOT, PARALLEL_DRAWN, PARALLEL_SAME };
enum parallel hypothesis_parallel(const struct hypothesis *h, const struct variable *base);

/* Gives a friction one value for both directions, for a machine with an unknown constant force.
 * Returns false if the effect has no pair of directions, or if the pattern is not PATTERN_ALL. */
bool hypothesis_make_symmetric(struct hypothesis *h);

/* True if the strength of a friction is a force. A dry friction that is stronger in one direction
 * looks like a symmetric one beside a constant force, except where the leg is at rest. */
bool hypothesis_is_dry(const struct hypothesis *h);

/* Gives a base variable the prior that it has beside a parallel effect: mean in the middle of the
 * variable's range, standard deviation of a uniform distribution over the range. The error of a
 * sensor keeps the prior that it has. */
void variable_add_prior(struct variable *base);

/* True if the second effect is a special case of the first, and therefore preferred if it explains
 * as much. */
bool hypothesis_contains(int effect, int other);

/* True if a machine with these parameters can exist (machine_check). */
bool hypothesis_possible(const struct params *model);

#endif
