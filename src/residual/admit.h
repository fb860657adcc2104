/* Refuses a recording that cannot be from the configured machine, and says why, so that a plug in
 * the wrong socket is not explained by a physical effect. The checks read the measured recording
 * and do not change it. No real time; heap. */
#ifndef HEXID_ADMIT_H
#define HEXID_ADMIT_H

#include "measured.h"

/* Least number of whole cycles of a steady sinusoid: three to fit and three to judge. */
enum { RECORDING_CYCLES = 6 };

/* Results of the checks, beside the reason of a refusal. */
struct admission {
    bool refuted;           /* the lengths, the order of the legs, the reference, or the force of a
                             * single axis contradict the configured machine */
    int excluded;           /* number of records that are left out; the run has others */
    struct error exclusion; /* reason why the last of these records is left out */
};

/* Checks the last run of a raw recording after measured_add() has measured it. *admission must be
 * zero before the first run. Returns 0, -3 without memory, or -2 with the reason, for example: no
 * test, too short, all zero, a sensor that does not change or is clipped, lengths that no pose of
 * this machine has, a leg's sign wrong, two legs exchanged, or forces out of all proportion. */
int admit(const struct recording *raw, const struct measured_recording *measured, struct admission *admission, struct error *error);

/* Refuses (-2) a recording if most tests or segments of the last run are mostly noise. Call it
 * after measured_noise(). */
int admit_noise(const struct measured_recording *measured, struct error *error);

#endif
