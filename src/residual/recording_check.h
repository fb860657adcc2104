/* Refuses a recording that cannot be from the configured machine, with the reason, so that a plug
 * in the wrong socket is not explained by a physical effect. No real time; heap. */
#ifndef HEXID_RECORDING_CHECK_H
#define HEXID_RECORDING_CHECK_H

#include "recording.h"

/* Fewest whole cycles of a steady sinusoid: three to fit and three to judge. */
enum { RECORDING_CYCLES = 6 };

/* Settles the recording (recording_settle), sets the tests' frequencies to those measured and cuts
 * motions that are no steady sinusoid into pieces (motion_cut). 0, or -2 with the reason: no test,
 * too short, all zero, a sensor that stands still or is clipped, lengths that no pose of this
 * machine has, a leg's sign or two legs exchanged, forces out of all proportion; -3: memory. */
int recording_check(struct recording *r, struct error *error);

/* For a checked recording that residuals are to judge: marks pieces that are mostly noise (noisy),
 * so that they are left out. -2: most tests or pieces of the last run are mostly noise; -3:
 * memory. */
int recording_check_noise(struct recording *r, struct error *error);

#endif
