/* Mean cycles, and pieces of any motion, for pictures: what was measured, and what the model gives
 * before and after the effects. Ordinary threads; heap. */
#ifndef HEXID_WAVES_H
#define HEXID_WAVES_H

#include "gap.h"
#include "spectrum.h"

/* One channel of one leg in one test. Coefficient rows (spectrum.h), padded with zeros. */
struct wave {
    double measured[SPECTRUM_SIZE], before[SPECTRUM_SIZE], after[SPECTRUM_SIZE];
    double noise;     /* rms of the measured samples about their mean cycle */
};

struct wave_test {
    int run, test;
    enum dof dof;
    double omega;
    double at_s, piece_s;       /* any motion: the piece's start and length; 0: a steady sinusoid */
    double from_s, span_s;      /* what the rows are good for: a cycle, or the piece */
    struct wave wave[GAP_CHANNELS][LEGS];
};

struct waves {
    int tests, legs;
    struct wave_test *test;
    bool evaluated[GAP_CHANNELS];   /* false: the model's rows are not there */
    double variation[GAP_CHANNELS]; /* rms of what was measured about its mean,
                                     * over all tests and legs */
};

/* Of the closed loop, all channels: of runs like the measured one. */
void waves_closed_loop(struct waves *w, const struct recording *measured, const struct recording *before, const struct recording *after);

/* Of the equations under the measured motion: force and pressures. */
int waves_motion(struct waves *w, const struct gap_result *result, const struct recording *measured, struct error *error);

void waves_free(struct waves *w);

/* Rms over the cycle or the piece of the difference of two rows. */
double waves_distance(const struct wave_test *t, const double a[SPECTRUM_SIZE], const double b[SPECTRUM_SIZE]);

#endif
