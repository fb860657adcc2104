/* Running least squares of several channels on [1, t, sin wt, cos wt, sin 2wt, cos 2wt, ...] (Tian 2015 Eqs. 14-15). No heap. */
#ifndef HEXID_HARMONICS_H
#define HEXID_HARMONICS_H

#include "types.h"

enum { HARMONICS_MAX = 6, REGRESSORS_MAX = 2 + 2 * HARMONICS_MAX, CHANNELS_MAX = 12 };

struct harmonics {
    int harmonics, channels, regressors;
    double omega;                 /* rad/s */
    double origin_s;              /* time is centred for the conditioning of the drift term */
    int64_t samples;
    double gram[REGRESSORS_MAX][REGRESSORS_MAX];      /* lower triangle */
    double moment[CHANNELS_MAX][REGRESSORS_MAX];
    double offset[CHANNELS_MAX];  /* first sample, taken off: no cancellation in large offsets */
    double square[CHANNELS_MAX];  /* sum of squares after that */
};

struct harmonics_fit {
    double constant[CHANNELS_MAX], drift_per_s[CHANNELS_MAX];
    double sine[CHANNELS_MAX][HARMONICS_MAX], cosine[CHANNELS_MAX][HARMONICS_MAX];
    double rms[CHANNELS_MAX];     /* residual */
    double std[CHANNELS_MAX];     /* of a fundamental coefficient, residual taken as white */
    double condition;
};

void harmonics_reset(struct harmonics *h, double omega, int harmonics, int channels);
void harmonics_add(struct harmonics *h, double t_s, const double *values);

/* False with too few samples or a singular fit. */
bool harmonics_solve(const struct harmonics *h, struct harmonics_fit *fit);

#endif
