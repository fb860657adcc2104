/* Do several logs of one machine agree? Each log's values against those of all the others together,
 * in standard deviations of that difference: of the noise alone, but for what joints within their
 * tolerance, and attenuation (equations.h), do to one log's motion and not to another's. As a
 * whole: generalised least squares of one set of values, of joints and of attenuation, to all logs'
 * estimates; the sum of squares left is chi-square where only noise differs. Only what is
 * determined is compared. Ordinary threads; heap. */
#ifndef HEXID_AGREEMENT_H
#define HEXID_AGREEMENT_H

#include "method_c.h"

enum { AGREEMENT_LOGS = 16 };
enum { AGREEMENT_VALUES = UNKNOWN_SHAPE }; /* entries, viscous and dry friction: equations.h */
/* less is disagreement: once in a thousand sets of logs that differ by noise alone */
#define AGREEMENT_PROBABILITY 1e-3

struct agreement {
    int logs;
    double deviation[AGREEMENT_LOGS][AGREEMENT_VALUES]; /* NaN: not compared */
    bool apart[AGREEMENT_LOGS][AGREEMENT_VALUES];       /* by more than AGREEMENT_PROBABILITY
                                                         * allows among so many */
    int compared;                                       /* deviations */
    double chi_square;
    int degrees;
    double probability;                                 /* of so large a chi-square by noise alone;
                                                         * 1 where nothing is compared */
    bool evaluated;                                     /* there was something to compare,
                                                         * and it could be */
    bool agree;                                         /* as a whole, and no value is apart */
};

struct agreement_log {
    const struct equations *equations;
    const struct estimate *estimate;
    const struct method_c *result;  /* what it determines */
};

/* 2 to AGREEMENT_LOGS logs of the machine that is configured so. -3: memory. */
int agreement_find(int logs, const struct agreement_log *log, const struct params *configured, struct agreement *a, struct error *error);

/* The value that compares worst, of those that are not `used` yet; false: none is
 * left. Marks it used. */
struct agreement_place {
    int log, value;
};
bool agreement_worst(const struct agreement *a, bool used[AGREEMENT_LOGS][AGREEMENT_VALUES], struct agreement_place *place);

/* Probability of a chi-square of so many degrees of freedom above x. */
double agreement_chi_square_above(double x, int degrees);

#endif
