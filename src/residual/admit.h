/* Refuses a recording that cannot be from the configured machine, and says why, so that a plug in
 * the wrong socket is not explained by a physical effect. It reads the measured recording and does
 * not change it. No real time; heap. */
#ifndef HEXID_ADMIT_H
#define HEXID_ADMIT_H

#include "measured.h"

/* Least number of whole cycles of a steady sinusoid: three to fit and three to judge. */
enum { RECORDING_CYCLES = 6 };

/* Results of the checks, beside the reason of a refusal. */
struct admission {
    bool refuted;           /* lengths, forces or reference contradict the configured machine */
    int excluded;           /* number of records left out because others can be evaluated */
    struct error exclusion; /* reason why the last of these records is left out */
};

/* Checks the last run of a raw recording that was measured; call it after each run, with an
 * admission that is zero at the start. Returns 0, or -2 with the reason, for example: no test, too
 * short, all zero, a sensor that does not change or is clipped, lengths that no pose of this
 * machine has, a leg's sign wrong, two legs exchanged, or forces out of all proportion; -3: no
 * memory. */
int admit(const struct recording *raw, const struct measured_recording *measured, struct admission *admission, struct error *error);

/* Refuses (-2) a recording if most tests or segments of the last run are mostly noise
 * (measured_noise). */
int admit_noise(const struct measured_recording *measured, struct error *error);

#endif
