/* Sampling and spectra of a test or a segment. They are measured once, and all later stages read
 * them here. No real time; heap. */
#ifndef HEXID_MEASURED_H
#define HEXID_MEASURED_H

#include "motion.h"
#include "spectrum.h"

struct measured {
    double step_s;       /* sampling period of the evaluated part */
    double command_s;    /* time between commands: the sampling period, or the controller's period
                          * where the recording is slower */
    bool in_step;        /* every sample falls on a command's instant */
    /* Only for segments. first_s: time of the first simulated sample, a run-up before the segment.
     * until_s: end of the segment's margin. inverse: inverse of the normal equations
     * (spectrum_cut). */
    double first_s, until_s;
    double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE];
    bool sufficient[CYCLES_ALL]; /* whether the samples suffice for each of the spectra */
    struct spectrum spectrum[];  /* spectra of the even, the odd and all cycles of a steady
                                  * sinusoid, or the single spectrum of a segment */
};

/* Share of a segment's length by which its window overlaps each neighbour. */
#define MEASURED_OVERLAP 0.15
/* Period of a segment's series, as a multiple of the time to which the series is fitted. */
#define MEASURED_STRETCH 1.2
#define MEASURED_SETTLE_S 0.1 /* run-up of the simulated chambers. They start with the measured
                               * pressures, and have forgotten this start after 30 ms */

/* Measurements of a test of the raw recording as a whole. */
struct measured_record {
    bool lasts, lengths; /* lasts: the test has an evaluated part. lengths: at least one of its
                          * samples has the lengths of all legs */
    int good;            /* number of its samples that are used */
    bool sinusoid;       /* a steady sinusoid; otherwise it was cut into segments */
    double frequency_hz; /* frequency of a steady sinusoid; 0 for any other motion */
    struct motion_cut cut;
};

/* A raw recording as it was measured. */
struct measured_recording {
    /* The tests that are evaluated, with their measured frequencies; a motion that is no steady
     * sinusoid is replaced by its segments. The samples belong to the raw recording, which must
     * outlive this one. */
    struct recording recording;
    struct measured_record record[RECORDING_TESTS]; /* by the index of the test in the raw
                                                     * recording */
    int first;           /* index of the last run's first test in `recording` */
    double noise;        /* median share of noise in the rms variation of the last run's tests; set
                          * by measured_noise() */
};

/* Measures the last run of a raw recording and adds it to m, which must be zero before the first
 * run. Returns -2 if there is no room for its tests, or -3 without memory. */
int measured_add(struct measured_recording *m, const struct recording *raw, struct error *error);
void measured_free(struct measured_recording *m);

/* Marks those segments of the last run that are mostly noise (REFUSED_NOISE), so that residuals
 * exclude them. Call it after measured_add(), for a recording that is admitted. Returns -2 or -3 as
 * residual_prepare() does. */
int measured_noise(struct measured_recording *m, struct error *error);

/* Measures sampling and spectra of a recording's tests and segments, from index `first` on, and
 * cuts no test into segments. Returns -3 without memory. */
int measured_make(struct recording *r, int first, struct error *error);

/* Returns the spectrum of a measured test over these cycles, or the only spectrum of a segment;
 * NULL if fewer than two such cycles are complete, or if too many samples of the segment are
 * missing. */
const struct spectrum *measured_spectrum(const struct recording_test *test, enum cycles which);

#endif
