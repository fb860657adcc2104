/* The configuration of the machine as an identification found it: payload and friction by method C,
 * and by a survey the stiffness of the oil, the valves' gains, the leakage and the delay.
 *
 * The error of a feed-forward is linear in these parameters, so its mean square is least if each
 * parameter is set to its mean given all that is known. A parameter was measured as x with the
 * variance s^2. The configuration says n, uniform within a tolerance (model.tolerance), with the
 * variance t^2. The mean is then n + w (x - n) with w = t^2 / (t^2 + s^2), and its variance is w
 * s^2. Method C's payload and friction and a survey's oil do not depend on the configured values,
 * so n is not counted twice.
 *
 * A stated tolerance may be wrong. The sum of (x - n)^2 / (s^2 + t^2) over a group (the values of
 * the payload, or one parameter of all legs) is a chi-square if the tolerance is right. If the
 * probability of so large a chi-square is below FOUND_CONTRADICTED, the configuration describes
 * another payload, oil or seal, and w = 1 for the group. A value that is not determined stays as
 * configured.
 *
 * Dry friction has no tolerance. The mean over both directions is used, because a constant error of
 * a leg's force (a pressure's zero, the weight) cancels in the mean. The six legs' seals are of one
 * make, so their frictions have one unknown rms size a: w = a^2 / (a^2 + s^2), a^2 the mean of x^2
 * - s^2 (empirical Bayes). So friction that is only noise is not compensated. Pure. */
#ifndef HEXID_MACHINE_FOUND_H
#define HEXID_MACHINE_FOUND_H

#include "config_note.h"
#include "loop_survey.h"
#include "params.h"

#define FOUND_CONTRADICTED 1e-3

struct found_value {
    double value, std;
};

/* The mean and standard deviation of a parameter that was measured and that the configuration
 * states. tolerance_std 0: the configuration is exact; infinite: it says nothing. */
struct found_value found_mean(struct found_value measured, double nominal, double tolerance_std);

/* Capacities: notes, reasons in kept_why, and bytes of a reason. */
enum { FOUND_NOTES = 24, FOUND_KEPT = 12, FOUND_KEPT_SIZE = 200 };

struct machine_found {
    struct params params;               /* the configuration with what was found */
    int notes;
    struct config_note note[FOUND_NOTES]; /* 95 % intervals and earlier values, key by key */
    int kept;
    char kept_why[FOUND_KEPT][FOUND_KEPT_SIZE]; /* what stays as configured, and why; one sentence
                                                 * each */
};

/* Fills `found` from method C's result and solution for a machine with this configuration. */
void machine_found(const struct params *configured, const struct method_c *c, const struct estimate *estimate, struct machine_found *found);

/* True if a log with this configuration is that of a survey (hexid run --survey). */
bool machine_found_is_survey(const struct params *params);

/* Adds a survey's oil, valves, leakage and delay to `found`; call it after machine_found(). The
 * configuration of a survey's run states the survey's motion in place of the tests'; this motion is
 * removed, so that the tests are back. */
void machine_found_survey(const struct loop_survey *survey, struct machine_found *found);

#endif
