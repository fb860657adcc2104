/* Tones that are no harmonics of the motion, such as those of a pump or of a loop that oscillates.
 * Ordinary threads; heap. */
#ifndef HEXID_TONE_H
#define HEXID_TONE_H

#include "gap_result.h"
#include "measured.h"

/* The strongest tone of a channel off the harmonics. */
struct tone {
    /* rms: of the tone, over all legs, in the unit of the channel */
    double hz, rms;
    double power;        /* power of the tone, averaged over the legs, as a multiple of the mean
                          * power of all bins; white noise gives about 1 in a bin */
};
struct tone tone_in(const struct spectrum *s, const struct recording_test *test, double sampling_s, enum channel channel);

/* Finds the strongest tone of all tests and channels. share: factor on the least power that a tone
 * needs. Returns 0 Hz if no tone has that power. */
struct gap_tone tone_find(const struct recording *recording, int threads, double share);

#endif
