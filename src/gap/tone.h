/* Tones off the harmonics of the motion, as from a pump or a loop that oscillates. Ordinary
 * threads; heap. */
#ifndef HEXID_TONE_H
#define HEXID_TONE_H

#include "gap_result.h"
#include "spectrum.h"

/* The strongest tone of a channel off the harmonics. */
struct tone {
    /* rms: over all legs */
    double hz, rms;
    double power;        /* power as a multiple of the noise's, in the mean of the legs; about 1
                          * without a tone */
};
struct tone tone_in(const struct spectrum *s, const struct recording_test *test, enum channel channel);

/* The strongest tone of all tests and channels. share: factor on the power that a tone must exceed;
 * 0 Hz: none does. */
struct gap_tone tone_find(const struct recording *recording, int threads, double share);

#endif
