/* Section `found` of the configuration (params.h): errors of this machine's sensors, as found by
 * `hexid identify -o`. The loop ignores them. */
#ifndef HEXID_PARAMS_FOUND_H
#define HEXID_PARAMS_FOUND_H

#include "types.h"

struct found_params {
    /* Weighing of a known weight. weight_p1, weight_p2: relative change of the weight's reading per
     * relative change of the pressure's gain. weight_error: relative error of the reading,
     * positive if it is too large. weight_std: standard deviation of weight_error; 0: nothing
     * was weighed. */
    double weight_p1[LEGS], weight_p2[LEGS], weight_error, weight_std;
    /* retracted_m: reading of each leg on its lower end stop, less the true length there.
     * retracted_std_m: standard deviation of these differences; 0: not found. */
    double retracted_m[LEGS], retracted_std_m;
};

#endif
