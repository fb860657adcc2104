/* Do several logs of one machine agree? Each value of a log is compared with its estimate from all
 * the other logs together, in standard deviations of the difference. These standard deviations
 * include the noise of both estimates, and the effect of the errors that all logs share (systematic
 * errors and attenuation, equations.h), as far as this effect differs between the motions. For the
 * overall test, generalised least squares fits one set of values, and one set of shared errors, to
 * the estimates of all logs; if the logs differ by noise alone, the remaining sum of squares is
 * chi-square distributed. Only determined values are compared. Ordinary threads; heap. */
#ifndef HEXID_AGREEMENT_H
#define HEXID_AGREEMENT_H

#include "method_c.h"

enum { AGREEMENT_LOGS = 16 };
/* Number of compared values: entries of the matrix, viscous and dry friction, and springs
 * (equations.h). */
enum { AGREEMENT_VALUES = UNKNOWN_SYSTEMATIC };
/* Level of significance: a difference counts as disagreement if the probability that noise alone
 * makes a difference as large is below this level. The overall test and the test of single values
 * each give a false alarm for one set of logs in a thousand. */
#define AGREEMENT_PROBABILITY 1e-3

struct agreement {
    int logs;
    double deviation[AGREEMENT_LOGS][AGREEMENT_VALUES]; /* log less all others, in standard
                                                         * deviations; NaN: not compared */
    /* true: the deviation is significant at the level AGREEMENT_PROBABILITY, corrected for the
     * number of compared values (Bonferroni) */
    bool apart[AGREEMENT_LOGS][AGREEMENT_VALUES];
    int compared;                                       /* number of deviations that are not NaN */
    double chi_square;
    int degrees;
    /* Probability that noise alone makes a chi_square of this size or larger; 1 if nothing is
     * compared. */
    double probability;
    /* At least one value was compared, and the overall test was made. */
    bool evaluated;
    bool agree;                                         /* the overall test finds agreement, and no
                                                         * value is apart */
};

struct agreement_log {
    const struct equations *equations;
    const struct estimate *estimate;
    const struct method_c *result;  /* values by method C; NaN if not determined */
};

/* Compares 2 to AGREEMENT_LOGS logs of one machine, all with this configuration. Returns 0, or -3
 * if memory is short. */
int agreement_find(int logs, const struct agreement_log *log, const struct params *configured, struct agreement *a, struct error *error);

/* Place of a deviation. agreement_worst() finds the largest deviation that is not yet `used`, and
 * marks it as used. It returns false if no deviation is left. */
struct agreement_place {
    int log, value;
};
bool agreement_worst(const struct agreement *a, bool used[AGREEMENT_LOGS][AGREEMENT_VALUES], struct agreement_place *place);

/* Probability that a chi-square of `degrees` degrees of freedom exceeds x. */
double agreement_chi_square_above(double x, int degrees);

#endif
