/* Can a recording be what the configuration says it is? One that cannot is refused with the reason:
 * a sensor's plug in the wrong socket is not to be explained by a physical effect. No real time;
 * heap. */
#ifndef HEXID_RECORDING_CHECK_H
#define HEXID_RECORDING_CHECK_H

#include "recording.h"

/* A steady sinusoid has so many whole cycles at least: three to fit and three to judge. */
enum { RECORDING_CYCLES = 6 };

/* Settles the recording (recording_settle) and cuts motions that are no steady sinusoid into pieces
 * (motion_cut); 0, or -2 with what is wrong: no test, too short, all zero, a sensor that stands
 * still or is clipped, another frequency than the run's, lengths that no pose of this machine has,
 * a leg's sign or two legs exchanged, forces against all reason; -3: memory. */
int recording_check(struct recording *r, struct error *error);

/* Of one that is checked, for what is judged by its residuals: pieces that are noise for the most
 * part are marked (noisy), and left out. -2: most tests or pieces of the last run are such; -3:
 * memory. */
int recording_check_noise(struct recording *r, struct error *error);

#endif
