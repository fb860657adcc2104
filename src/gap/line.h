/* Lines off the harmonics of the motion. Ordinary threads; heap. */
#ifndef HEXID_LINE_H
#define HEXID_LINE_H

#include "gap.h"
#include "spectrum.h"

/* The strongest line off the harmonics in one channel: what is periodic, but not in step
 * with the motion. */
struct line {
    double hz, rms;      /* rms: root mean square over the legs */
    double power;        /* per leg, of the noise's: 1 on average without a line */
};
struct line line_in(const struct spectrum *s, const struct recording_test *test, enum channel channel);

/* The strongest line of all tests and channels; 0 Hz where none is so much above the noise. share:
 * of the power that makes a line. */
struct gap_line line_find(const struct recording *recording, int threads, double share);

#endif
