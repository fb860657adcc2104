/* Tones off the harmonics of the motion, as from a pump or a loop that oscillates. Ordinary
 * threads; heap. */
#ifndef HEXID_TONE_H
#define HEXID_TONE_H

#include "gap_result.h"
#include "spectrum.h"

/* The strongest tone of a channel off the harmonics. */
struct tone {
    /* rms: of the tone, over all legs */
    double hz, rms;
    double power;        /* power of the tone as a multiple of the noise's, averaged over the legs;
                          * about 1 without a tone */
};
struct tone tone_in(const struct spectrum *s, const struct recording_test *test, enum channel channel);

/* Finds the strongest tone of all tests and channels. share: factor on the power that a tone must
 * exceed. Returns 0 Hz if no tone exceeds it. */
struct gap_tone tone_find(const struct recording *recording, int threads, double share);

#endif
