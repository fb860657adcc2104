/* What is measured of a test or a segment, each quantity once: the sampling and the spectra. What
 * needs one of them reads it here and measures nothing again. No real time; heap. */
#ifndef HEXID_MEASURED_H
#define HEXID_MEASURED_H

#include "spectrum.h"

struct measured {
    double step_s;       /* sampling period of the evaluated part */
    double command_s;    /* time between commands: the sampling period, or the controller's period
                          * where the recording is slower */
    bool in_step;        /* every sample falls on a command's instant */
    /* For segments. first_s: first simulated sample, a run-up before the segment. until_s: end of
     * the segment's margin. inverse: that of spectrum_cut(). */
    double first_s, until_s;
    double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE];
    bool sufficient[CYCLES_ALL]; /* whether the samples suffice for each of the spectra */
    struct spectrum spectrum[];  /* of a steady sinusoid those of the even, the odd, and all cycles;
                                  * of a segment a single one */
};

/* Share of a segment's length by which its window overlaps each neighbour. */
#define MEASURED_OVERLAP 0.15
/* Period of a segment's series, as a multiple of the time to which the series is fitted. */
#define MEASURED_STRETCH 1.2
#define MEASURED_SETTLE_S 0.1 /* run-up of the simulated chambers. They start with the measured
                               * pressures, and have forgotten this start after 30 ms */

/* Measures the tests and segments of a recording from number `first` on. Returns -3 without
 * memory. */
int measured_make(struct recording *r, int first, struct error *error);

/* Spectrum of a measured test over these cycles; of a segment its only one. NULL if fewer than two
 * such cycles are complete, or if too many samples of the segment are missing. */
const struct spectrum *measured_spectrum(const struct recording_test *test, enum cycles which);

#endif
