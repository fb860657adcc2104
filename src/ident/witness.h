/* Are a test's readings consistent with each other, leg by leg? A plausible reading may still be
 * wrong, and would make the matrix silently wrong. On a sound machine two things are true, whatever
 * its inertia:
 *
 *   - No pressure, and no length of a leg that is to move, stands still for a whole period of the
 *     motion. (Else: a dead transducer, or a leg held by friction.)
 *   - The fundamentals of a leg's length and force are the same in every period, and its mean force
 *     is the same in every period and test, because the motion is steady and the load at rest is
 *     the load in the neutral pose; the mean length may still settle. (Else: a sensor jumped or
 *     drifts, sensors were exchanged, a valve or a sample stuck for a while; a length that drifts
 *     moves the platform away, and the weight shifts between the legs.)
 *
 * Periods are joined into blocks of at least 100 samples, so that the sensors' noise averages out
 * at low sampling rates, too. Signals are integrated over time, so that lost rows and a recorder of
 * another rate than the controller change nothing; a longer gap leaves its blocks out. Pure, no
 * heap. */
#ifndef HEXID_WITNESS_H
#define HEXID_WITNESS_H

#include "types.h"

/* Readings of a leg: length, P1, P2. Terms of a block: mean, sine and cosine. */
enum { WITNESS_READINGS = 3, WITNESS_TERMS = 3 };

/* Change of one signal, a length or a force less its first value, from block to block. */
struct wander {
    double value, begin;         /* last value, and the one at the current block's beginning */
    /* sum: integrals over the current block. low, high: extremes over whole blocks. */
    double sum[WITNESS_TERMS], low[WITNESS_TERMS], high[WITNESS_TERMS];
};

struct witness {
    double omega, block_s;
    bool moves[LEGS];
    double last[LEGS][WITNESS_READINGS], last_n[LEGS]; /* last good readings and force of each
                                                        * leg */
    double first_m[LEGS], first_n[LEGS]; /* first good lengths and forces */
    int64_t same[LEGS][WITNESS_READINGS], longest[LEGS];
    int64_t samples;
    double last_s, step_s;       /* time of the last sample, and its distance from the one before */
    double shortest_s;           /* shortest step so far */
    double base[WITNESS_TERMS];  /* functions of the terms at last_s */
    /* Number of the block under way. It is a double, because times from a log may exceed any
     * integer type. */
    double block;
    bool whole;                  /* the block under way has no gap so far */
    int64_t blocks;              /* number of whole blocks that have ended */
    struct wander length[LEGS], force[LEGS];
    double total_n[LEGS];
};

struct testimony {
    int still_leg, length_leg, force_leg; /* legs with the largest still_samples, length_m and
                                           * force_n, 0..5 */
    int64_t still_samples;       /* largest number of successive samples with the same reading */
    bool compared;               /* there are two whole blocks; if not, length_m and force_n are
                                  * 0 */
    double length_m;             /* largest change of a length's fundamental between two whole
                                  * blocks, m */
    double force_n;              /* largest change of a force's mean or fundamental between two
                                  * whole blocks, N */
    double mean_n[LEGS];         /* mean force of each leg over the whole test; NaN without a
                                  * sample */
};

/* Starts a test. period_s: the controller's cycle. moves: legs whose length must change in every
 * period; lengths of other legs may stand still. */
void witness_reset(struct witness *w, double frequency_hz, double period_s, const bool moves[LEGS]);

/* Adds one evaluated sample, since_s after the first one. In place of a bad sample (not `good`) the
 * last good one counts again. This distorts the block's mean and fundamental, so that a fault shows
 * as a change between blocks although its samples are excluded. */
void witness_add(struct witness *w, double since_s, const struct hal_sample *sample, const double force_n[LEGS], bool good);

struct testimony witness_says(const struct witness *w);

#endif
