/* Evaluates a long motion part by part: while a part is recorded, the estimator's thread makes the
 * equations of the previous one and frees its samples. So an hour takes no more memory than two
 * parts. A machine that changes over time is noticed, because the parts are compared like repeated
 * logs (agreement.h). Beyond PARTS, neighbouring parts are merged. One thread makes all calls. */
#ifndef HEXID_PARTS_H
#define HEXID_PARTS_H

#include "agreement.h"
#include "estimator.h"

enum { PARTS = AGREEMENT_LOGS };

struct parts {
    struct estimator estimator;
    struct equations *part;  /* equations of each part, an array of PARTS, and room for one more */
    int count, joined;   /* each part[] but the last is the sum of `joined` parts, a power of two */
    int in_last;             /* number of parts that the last part[] sums up */
    int all, left_out;       /* number of parts closed, and of parts without equations (at rest, or
                              * too short) */
    bool dropped;            /* parts_clear() was called since the last part was closed, so the
                              * equations of that part are dropped */
    struct error why;        /* why the first excluded part has no equations */
};

/* Starts the estimator. Returns -3 on failure. Call parts_free() even then. */
int parts_init(struct parts *p, struct error *error);
void parts_free(struct parts *p);

/* Gives a part to the estimator, which takes over the recording. Waits for the previous part. */
void parts_close(struct parts *p, struct recording *recording);

/* Discards all parts without waiting. */
void parts_clear(struct parts *p);

/* Takes finished equations from the estimator; `wait`: waits for those in progress. */
void parts_take(struct parts *p, bool wait);

/* Adds a part: its equations or, if error->status is not 0, the reason why it is excluded. */
void parts_add(struct parts *p, const struct equations *e, const struct error *error);

/* Sums all parts and compares them (agreement->logs is 1 or 0 if there is nothing to compare;
 * agreement may be NULL). Returns a negative status with the reason if there is no sum; -3: no
 * memory. */
int parts_sum(const struct parts *p, const struct params *configured, struct equations *sum, struct agreement *agreement,
              struct error *error);

#endif
