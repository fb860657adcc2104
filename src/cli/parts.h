/* A long motion, part by part: each part's equations are made by the estimator's thread while the
 * next is recorded, and its samples are not kept. So an hour takes no more memory than a part, and
 * a machine that changes on the way is seen, because parts are repeats. Beyond PARTS of them,
 * neighbours are joined. All calls from one thread. */
#ifndef HEXID_PARTS_H
#define HEXID_PARTS_H

#include "agreement.h"
#include "estimator.h"

enum { PARTS = AGREEMENT_LOGS };

struct parts {
    struct estimator estimator;
    struct equations *part;  /* [PARTS] */
    int count, joined;       /* each part[] but the last is the sum of `joined` parts, a power of
                              * two, */
    int in_last;             /* and the last of so many */
    int all, left_out;       /* parts closed; those without equations: at rest, too short */
    bool dropped;            /* the estimator works on a motion that was cleared */
    struct error why;        /* of the first part that was left out */
};

/* -3. To be freed also after a failure. */
int parts_init(struct parts *p, struct error *error);
void parts_free(struct parts *p);

/* Gives a part to the estimator, which takes the recording over. Waits for the part before. */
void parts_close(struct parts *p, struct recording *recording);

/* Drops all of them, without waiting. */
void parts_clear(struct parts *p);

/* Takes the equations that the estimator has ready; `wait`: waits for those under way. */
void parts_take(struct parts *p, bool wait);

/* Adds a part whose equations the caller made, or left out for this error. */
void parts_add(struct parts *p, const struct equations *e, const struct error *error);

/* The sum of all parts, and whether they agree (agreement->logs is 1 or 0 where there is nothing to
 * compare; NULL: not asked). Negative, and why, where there is none; -3: memory. */
int parts_sum(const struct parts *p, const struct params *configured, struct equations *sum, struct agreement *agreement,
              struct error *error);

#endif
