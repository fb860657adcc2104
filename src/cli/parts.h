/* Evaluates a long motion part by part: while a part is recorded, the estimator's thread makes the
 * equations of the previous one and frees its samples. So a motion of an hour takes no more memory
 * than two parts. A machine that changes over time is noticed, because the parts are compared like
 * repeated logs (agreement.h). If there are more than PARTS parts, neighbouring parts are merged.
 * One thread makes all calls. */
#ifndef HEXID_PARTS_H
#define HEXID_PARTS_H

#include "agreement.h"
#include "estimator.h"

enum { PARTS = AGREEMENT_LOGS };

struct parts {
    struct estimator estimator;
    struct equations *part;  /* equations of the parts, an array of PARTS elements and one more for
                              * parts_take() */
    int count, joined;   /* number of elements of part[] in use; each but the last is the sum of
                          * `joined` parts; `joined` is a power of two */
    int in_last;             /* number of parts in the sum that is the last element in use */
    int all, left_out;       /* numbers of all parts, and of parts without equations (at rest, or
                              * too short) */
    bool dropped;            /* parts_clear() was called since the last part was closed, so that the
                              * equations of that part are to be dropped */
    struct error why;        /* reason why the first part without equations has none */
};

/* Starts the estimator. Returns -3 on failure. Call parts_free() even then. */
int parts_init(struct parts *p, struct error *error);
void parts_free(struct parts *p);

/* Gives a part to the estimator, which takes over the recording. Waits for the previous part. */
void parts_close(struct parts *p, struct recording *recording);

/* Discards all parts without waiting. */
void parts_clear(struct parts *p);

/* Adds the part that the estimator has finished, if any; `wait`: waits for the part in progress. */
void parts_take(struct parts *p, bool wait);

/* Adds a part: its equations or, if error->status is not 0, the reason why it is excluded. */
void parts_add(struct parts *p, const struct equations *e, const struct error *error);

/* Sums all parts and compares them (agreement->logs is 1 or 0 if there is nothing to compare;
 * agreement may be NULL). Returns a negative status with the reason if no part has equations; -3
 * without memory. */
int parts_sum(const struct parts *p, const struct params *configured, struct equations *sum, struct agreement *agreement,
              struct error *error);

#endif
