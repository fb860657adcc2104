/* Section `found` of the configuration (params.h): errors of this machine's sensors, as found by
 * `hexid identify -o`. The loop ignores them. */
#ifndef HEXID_PARAMS_FOUND_H
#define HEXID_PARAMS_FOUND_H

#include "types.h"

struct found_params {
    /* Weighing of a known weight: relative change of the weight's reading per relative change of
     * each pressure's gain, relative error of the reading (positive: too large), and standard
     * deviation of that error; weight_std 0: nothing was weighed. */
    double weight_p1[LEGS], weight_p2[LEGS], weight_error, weight_std;
    /* Readings of the legs on their lower end stops, less the true lengths there, and the standard
     * deviation of each; retracted_std_m 0: not found. */
    double retracted_m[LEGS], retracted_std_m;
};

#endif
