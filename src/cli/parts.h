/* A long motion, part by part: the estimator's thread makes each part's equations while the next
 * is recorded, and samples are not kept. So an hour takes no more memory than a part, and a
 * machine that changes over time is noticed, because the parts are repeats. Beyond PARTS,
 * neighbouring parts are merged. All calls from one thread. */
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
    bool dropped;            /* the estimator's current motion was cleared */
    struct error why;        /* why the first part that was excluded has no equations */
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

/* Adds a part whose equations the caller made, or which is excluded for this error. */
void parts_add(struct parts *p, const struct equations *e, const struct error *error);

/* Sums all parts and compares them (agreement->logs is 1 or 0 if there is nothing to compare;
 * agreement may be NULL). Returns a negative status with the reason if there is no sum; -3: no
 * memory. */
int parts_sum(const struct parts *p, const struct params *configured, struct equations *sum, struct agreement *agreement,
              struct error *error);

#endif
