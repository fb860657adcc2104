/* Do several logs of one machine agree? Each value of a log is compared with that of all the others
 * together, in standard deviations of the difference: the noise of both, and what two errors that
 * all logs share (equations.h), joints within their tolerance and attenuation, do to one motion and
 * not to the other. As a whole: generalised least squares fits one set of values, with one set of
 * these errors, to all logs' estimates; the sum of squares left is chi-square where only noise
 * differs. Only what is determined is compared. Ordinary threads; heap. */
#ifndef HEXID_AGREEMENT_H
#define HEXID_AGREEMENT_H

#include "method_c.h"

enum { AGREEMENT_LOGS = 16 };
/* Entries, viscous and dry friction, springs: equations.h. */
enum { AGREEMENT_VALUES = UNKNOWN_SHAPE };
/* a lower probability is disagreement: a false alarm in a thousand sets of logs that differ by
 * noise alone */
#define AGREEMENT_PROBABILITY 1e-3

struct agreement {
    int logs;
    double deviation[AGREEMENT_LOGS][AGREEMENT_VALUES]; /* NaN: not compared */
    bool apart[AGREEMENT_LOGS][AGREEMENT_VALUES];       /* less probable, among so many, than
                                                         * AGREEMENT_PROBABILITY */
    int compared;                                       /* number of deviations */
    double chi_square;
    int degrees;
    double probability;                                 /* of so large a chi-square by noise alone;
                                                         * 1 where nothing is compared */
    bool evaluated;                                     /* there was something to compare, and the
                                                         * comparison succeeded */
    bool agree;                                         /* as a whole, and no value is apart */
};

struct agreement_log {
    const struct equations *equations;
    const struct estimate *estimate;
    const struct method_c *result;  /* NaN where not determined */
};

/* 2 to AGREEMENT_LOGS logs of a machine configured like this. -3: memory. */
int agreement_find(int logs, const struct agreement_log *log, const struct params *configured, struct agreement *a, struct error *error);

/* The largest deviation among those not `used` yet, and marks it used; false: none is left. */
struct agreement_place {
    int log, value;
};
bool agreement_worst(const struct agreement *a, bool used[AGREEMENT_LOGS][AGREEMENT_VALUES], struct agreement_place *place);

/* Probability of a chi-square of so many degrees of freedom above x. */
double agreement_chi_square_above(double x, int degrees);

#endif
