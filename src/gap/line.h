/* Tones off the harmonics of the motion. Ordinary threads; heap. */
#ifndef HEXID_LINE_H
#define HEXID_LINE_H

#include "gap.h"
#include "spectrum.h"

/* The strongest tone off the harmonics in one channel. */
struct line {
    double hz, rms;      /* rms over the legs */
    double power;        /* relative to the noise, mean of the legs; about 1 without a tone */
};
struct line line_in(const struct spectrum *s, const struct recording_test *test, enum channel channel);

/* The strongest tone of all tests and channels; 0 Hz if none exceeds share * (threshold power). */
struct gap_line line_find(const struct recording *recording, int threads, double share);

#endif
