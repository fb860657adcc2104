/* Can a recording be what the configuration says it is? What cannot is refused, with what is
 * wrong with it: no physical effect is to explain a sensor's plug in the wrong socket. No
 * real time; heap. */
#ifndef HEXID_RECORDING_CHECK_H
#define HEXID_RECORDING_CHECK_H

#include "recording.h"

/* Settles, then 0; or -2 with what is wrong: no test, too short, all zero, a sensor that stands
 * still or is clipped, another frequency than the run's, lengths that no pose of this machine has,
 * a leg's sign or two legs exchanged, forces against all reason. */
int recording_check(struct recording *r, struct error *error);

#endif
