/* The machine as a survey found it, for the linear loop: payload, viscous friction, and for each
 * leg the stiffness of its oil, the gain of its valve, its leakage, and the delay from the sample
 * of a command to its effect on the oil. A survey measures at neutral; in another pose each leg's
 * values are assumed to differ from the configuration's model by the same factors. Ordinary
 * threads, no heap. */
#ifndef HEXID_LOOP_FOUND_H
#define HEXID_LOOP_FOUND_H

#include "loop_model.h"
#include "loop_survey.h"

/* Returns the configuration with the payload that was found, or unchanged if a part of it is not
 * determined. */
struct params loop_found_params(const struct params *params, const struct loop_survey *survey);

/* Factors, and a difference of delays, that turn a leg of the configuration's model (struct
 * loop_leg) into the leg that was found. */
struct loop_found {
    struct found_leg {
        double push[2], open[2], sag[2], other[2], viscous;
        double later_s;          /* delay found less the configured one */
    } leg[LEGS];
};

/* Finds the factors from the model at neutral. A value that a survey did not determine, or that
 * differs from the configured one by more than LOOP_FOUND_MOST times, stays as configured. */
#define LOOP_FOUND_MOST 10.0
struct loop_found loop_found(const struct loop_place *neutral, const struct params *params, const struct loop_survey *survey);

/* Returns the factor from a configured value to a found one; NaN if the factor is not determined,
 * or not between 1 / LOOP_FOUND_MOST and LOOP_FOUND_MOST. */
double loop_found_factor(double found, double configured);

/* Corrects the legs of a place, and finds its modes anew. modal: the modes' weights. Returns false
 * if the modes cannot be computed. */
bool loop_found_correct(const struct loop_found *found, struct loop_place *place, const struct params *params, const struct modal *modal);

#endif
