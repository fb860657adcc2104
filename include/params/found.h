/* Section `found` of the configuration (params.h): what was measured on this machine. The loop
 * reads past it. */
#ifndef HEXID_PARAMS_FOUND_H
#define HEXID_PARAMS_FOUND_H

#include "types.h"

struct found_params {
    /* A known weight's reading: its error for each unit of a gain's error, its relative error, and
     * the standard deviation of that; 0: nothing was weighed. */
    double weight_p1[LEGS], weight_p2[LEGS], weight_error, weight_std;
    /* Readings of the legs on their lower end stops, less the lengths that they have there, and
     * the standard deviation of each; 0: not found. */
    double retracted_m[LEGS], retracted_std_m;
};

#endif
