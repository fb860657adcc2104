/* Refuses a recording that cannot be from the configured machine, and says why, so that a plug in
 * the wrong socket is not explained by a physical effect. No real time; heap. */
#ifndef HEXID_RECORDING_CHECK_H
#define HEXID_RECORDING_CHECK_H

#include "recording.h"

/* Least number of whole cycles of a steady sinusoid: three to fit and three to judge. */
enum { RECORDING_CYCLES = 6 };

/* Checks the last run; call it after each run. It settles the recording (recording_settle), sets
 * the tests' frequencies to the measured ones and cuts motions that are not steady sinusoids into
 * segments (motion_cut). Returns 0, or -2 with the reason, for example: no test, too short, all
 * zero, a sensor that does not change or is clipped, lengths that no pose of this machine has, a
 * leg's sign wrong, two legs exchanged, or forces out of all proportion; -3: no memory. */
int recording_check(struct recording *r, struct error *error);

/* Marks those segments of the last run that are mostly noise (REFUSED_NOISE), so that residuals
 * exclude them. Call it after recording_check(). -2: most tests or segments of the last run are
 * mostly noise; -3: no memory. */
int recording_check_noise(struct recording *r, struct error *error);

#endif
