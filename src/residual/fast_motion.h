/* The part of a measured motion that is too fast for the Fourier series of its segment, for example
 * when a rod reverses sharply or starts to move. Straight lines under Hann windows are fitted to
 * the lengths less the series, at nodes all along the segment, and cubics join the nodes. Pure,
 * except for the heap. */
#ifndef HEXID_FAST_MOTION_H
#define HEXID_FAST_MOTION_H

#include "spectrum.h"

struct rods_motion {
    double length_m[LEGS], rate_mps[LEGS];
};

struct fast_motion {
    int nodes;                   /* number of nodes; 0: no fast motion */
    /* test time of the first node, and time from node to node */
    double first_s, step_s;
    struct rods_motion *node;    /* [nodes]: value and slope at each node, from a line fitted there,
                                  * or from a cubic across a gap */
};

/* Fits the fast motion between the test times from_s and until_s. sampling_s: sampling period.
 * Cubics bridge gaps between good samples. Returns false without memory. Call fast_motion_free() in
 * any case. */
bool fast_motion_fit(struct fast_motion *f, const struct recording_test *test, double sampling_s, const struct spectrum *series,
                     double from_s, double until_s);
void fast_motion_free(struct fast_motion *f);

/* Adds a leg's fast motion at a test time to its length and rate. scale: scale of the position
 * sensor, by which the motion is divided. Before the first node and after the last, length and rate
 * of the motion keep their end values. f->nodes must not be 0. */
void fast_motion_add(const struct fast_motion *f, int leg, double t_s, double scale, double *length_m, double *rate_mps);

#endif
