/* Section `found` of the configuration (params.h): what was measured on this machine. The loop
 * ignores it. */
#ifndef HEXID_PARAMS_FOUND_H
#define HEXID_PARAMS_FOUND_H

#include "types.h"

struct found_params {
    /* Weighing of a known weight: change of the reading for a unit of each pressure's gain,
     * relative error of the reading, and standard deviation of that error; 0: nothing was
     * weighed. */
    double weight_p1[LEGS], weight_p2[LEGS], weight_error, weight_std;
    /* Readings of the legs on their lower end stops, less the lengths that they have there, and
     * the standard deviation of each; 0: not found. */
    double retracted_m[LEGS], retracted_std_m;
};

#endif
