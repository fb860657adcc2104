/* What a measured motion has beyond the Fourier series of its piece, where a rod turns sharply or
 * starts: lines fitted to what the series leaves of the lengths, under Hann windows all along the
 * piece, and cubics between them. Pure but for the heap. */
#ifndef HEXID_FAST_MOTION_H
#define HEXID_FAST_MOTION_H

#include "spectrum.h"

struct rods_motion {
    double length_m[LEGS], rate_mps[LEGS];
};

struct fast_motion {
    int lines;                   /* 0: there is nothing */
    double first_s, step_s;      /* test time of the first line, and from line to line */
    struct rods_motion *line;    /* value and slope there */
};

/* Over a gap among the good samples the cubic goes from line to line. False: no memory. To be freed
 * in any case. */
bool fast_motion_fit(struct fast_motion *f, const struct recording_test *test, const struct spectrum *series, double from_s,
                     double until_s);
void fast_motion_free(struct fast_motion *f);

/* Adds that of a leg at a test time, 1 / scale of it; before the first line and behind the last one
 * what these have. */
void fast_motion_add(const struct fast_motion *f, int leg, double t_s, double scale, double *length_m, double *rate_mps);

#endif
