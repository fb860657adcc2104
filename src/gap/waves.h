/* Waveforms for figures: mean cycles and segments, as measured and as the model gives them
 * before and after the effects. Ordinary threads; heap. */
#ifndef HEXID_WAVES_H
#define HEXID_WAVES_H

#include "gap_result.h"
#include "spectrum.h"

/* One channel of one leg in one test: Fourier coefficients (spectrum.h), filled up with zeros; as
 * measured, and of the models before and after the effects. */
struct wave {
    double measured[SPECTRUM_SIZE], before[SPECTRUM_SIZE], after[SPECTRUM_SIZE];
    double noise;     /* rms of the measured samples about their mean cycle */
};

struct wave_test {
    int run, test;
    enum dof dof;
    double omega;
    double at_s, segment_s;     /* start and length of a segment of any motion; segment_s 0: a
                                 * steady sinusoid */
    double from_s, span_s;     /* start and length of the time to which the coefficients apply: one
                                * cycle, or the segment */
    struct wave wave[GAP_CHANNELS][LEGS];
};

struct waves {
    int tests, legs;
    struct wave_test *test;
    bool evaluated[GAP_CHANNELS];   /* the models' coefficients were computed; false: they are
                                     * copies of the measured ones */
    double variation[GAP_CHANNELS]; /* rms of the measured variation over all tests and legs */
};

/* Fills all channels from simulations in closed loop. */
void waves_closed_loop(struct waves *w, const struct recording *measured, const struct recording *before, const struct recording *after);

/* Fills force and pressures from the residuals under the measured motion. Returns 0 or a negative
 * status. */
int waves_motion(struct waves *w, const struct gap_result *result, const struct recording *measured, struct error *error);

void waves_free(struct waves *w);

/* Rms difference of two rows of coefficients over the cycle or the segment. */
double waves_distance(const struct wave_test *t, const double a[SPECTRUM_SIZE], const double b[SPECTRUM_SIZE]);

#endif
