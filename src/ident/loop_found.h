/* The machine as a survey found it, for the linear loop: payload and viscous friction, and of each
 * leg the stiffness of its oil, the gain of its valve, its leakage, and the delay from sample to
 * oil. A survey measures at neutral; in another pose each leg's numbers differ from the
 * configuration's model by the same factors. Ordinary threads, no heap. */
#ifndef HEXID_LOOP_FOUND_H
#define HEXID_LOOP_FOUND_H

#include "loop_model.h"
#include "loop_survey.h"

/* The configuration with the payload that was found, if all of it is determined. */
struct params loop_found_params(const struct params *params, const struct loop_survey *survey);

/* Factors from a leg of the configuration's model to the leg that was found. */
struct loop_found {
    struct found_leg {
        double push[2], open[2], sag[2], other[2], viscous;
        double later_s;          /* delay found less the configured one */
    } leg[LEGS];
};

/* Finds the factors from the model at neutral. What a survey did not determine, or found beyond a
 * factor of LOOP_FOUND_MOST, stays as configured. */
#define LOOP_FOUND_MOST 10.0
struct loop_found loop_found(const struct loop_place *neutral, const struct params *params, const struct loop_survey *survey);

/* Corrects the legs in a place, and its modes. Returns false without modes. */
bool loop_found_correct(const struct loop_found *found, struct loop_place *place, const struct params *params);

#endif
