/* Compares the measurement of `hexid qualify` with the operator's limits and with an earlier
 * measurement. Pure, no heap. */
#ifndef HEXID_QUALITY_CHECK_H
#define HEXID_QUALITY_CHECK_H

#include "params/qualify.h"
#include "quality.h"
#include "verdict.h"

enum { QUALITY_CHECKS = 15 };

struct quality_check {
    const char *key, *unit, *what;  /* key in the section `qualify`; what is measured, for people */
    bool least;                     /* true: `limit` is the least accepted value; false: the
                                     * largest */
    double value, limit;            /* the worst value, NaN: not measured; limit 0: none */
    bool lacks;                     /* an axis or a tone has no value */
    enum verdict_status status;     /* VERDICT_NOT_EVALUATED if there is no limit or no value, or if
                                     * `lacks` and the check would pass */
    int dof;                        /* axis of the worst value; -1: none */
    double hz;                      /* frequency of the worst value; NaN: none */
};

/* Difference of a tone from the same tone of an earlier measurement. */
struct quality_change {
    double gain_pct, phase_deg;     /* change on the tone's own axis. All members are NaN if the
                                     * other measurement has no tone of this frequency and
                                     * amplitude */
    double mps2;                    /* the change of the response as an acceleration, at the tone's
                                     * amplitude */
    double of_noise;                /* the change of the response, divided by the standard deviation
                                     * that the noise of both measurements gives it */
};

/* Compares with an earlier measurement, by axis and number of the tone. */
struct quality_change quality_change(const struct quality *now, const struct quality *before, int dof, int tone);

/* Root mean square of quality_change.of_noise over all tones: about 1 if nothing but noise differs.
 * NaN: no tone is in both measurements, or there is no noise. */
double quality_change_of_noise(const struct quality *now, const struct quality *before);

/* Makes all checks. before: the earlier measurement (baseline), or NULL. */
void quality_judge(const struct quality *q, const struct quality *before, const struct qualify_params *limits,
                   struct quality_check check[QUALITY_CHECKS]);

/* FAIL if any check fails; else NOT_EVALUATED if no check has a limit, or if one that has a limit
 * was not evaluated; else PASS. */
enum verdict_status quality_verdict(const struct quality_check check[QUALITY_CHECKS]);

/* Rms acceleration at rest from 0.2 to 20 Hz, m/s^2 or rad/s^2. */
double quality_rest(const struct quality *q, int dof);

#endif
