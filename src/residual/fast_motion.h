/* The part of a measured motion that is too fast for the Fourier series of its piece: a rod that
 * turns sharply or starts. The lengths less the series are fitted by straight lines under Hann
 * windows all along the piece, and cubics join the lines. Pure but for the heap. */
#ifndef HEXID_FAST_MOTION_H
#define HEXID_FAST_MOTION_H

#include "spectrum.h"

struct rods_motion {
    double length_m[LEGS], rate_mps[LEGS];
};

struct fast_motion {
    int lines;                   /* 0: no fast motion */
    double first_s, step_s;      /* test time of the first line; time between lines */
    struct rods_motion *line;    /* value and slope at the line's instant */
};

/* Fits from from_s to until_s. A gap among the good samples is bridged by the cubic. False: no
 * memory. Free in any case. */
bool fast_motion_fit(struct fast_motion *f, const struct recording_test *test, const struct spectrum *series, double from_s,
                     double until_s);
void fast_motion_free(struct fast_motion *f);

/* Adds 1 / scale of a leg's fast motion at a test time; its end values hold beyond the lines. */
void fast_motion_add(const struct fast_motion *f, int leg, double t_s, double scale, double *length_m, double *rate_mps);

#endif
