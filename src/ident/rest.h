/* Readings of the sensors while the platform rests before its supply comes on: both chambers are at
 * the tank's pressure, so that a pressure sensor reads its zero, and the legs are on their lower
 * end stops. Samples count from a log's beginning until the first state other than `init` or
 * `settled`. Later rests do not count, because a chamber may keep its pressure for long. A log that
 * does not begin with the loop's first cycle has no such samples. Ordinary threads; no heap. */
#ifndef HEXID_REST_H
#define HEXID_REST_H

#include "types.h"

struct params;

enum { REST_LEAST = 25 }; /* least number of samples of a rest */

struct rest {
    bool begun, over;
    int64_t samples;
    /* Readings of the first sample, which are subtracted from all before they are summed. */
    struct hal_sample first;
    double length[LEGS], p1[LEGS], p2[LEGS], square[2][LEGS];
};

struct rest_found {
    int64_t samples;              /* number of samples; with fewer than REST_LEAST nothing is
                                   * found */
    double length_m[LEGS];        /* mean reading of each leg */
    double zero_pa[2][LEGS], zero_std_pa[2][LEGS]; /* zeros of P1 and of P2, mean reading less the
                                                    * tank's pressure; and their standard
                                                    * deviations */
};

/* Takes the next cycle of a log. */
void rest_take(struct rest *r, const struct cycle *c);

struct rest_found rest_find(const struct rest *r, const struct params *params);

/* Writes the errors of the legs' readings on their stops, reading less actuator.retracted_m, into
 * the section `found`. Does nothing if actuator.retracted_std_m is 0 or the rest was too short. */
void rest_note_stops(const struct rest_found *r, struct params *params);

#endif
