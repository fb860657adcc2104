/* A motion that is long, part by part: each part's equations are made by the estimator's thread
 * while the next is recorded, and its samples are not kept. So an hour takes no more memory than
 * a part, and a machine that changes on the way is seen: parts are repeats. Of many parts
 * neighbours are joined. */
#ifndef HEXID_PARTS_H
#define HEXID_PARTS_H

#include "agreement.h"
#include "estimator.h"

enum { PARTS = AGREEMENT_LOGS };

struct parts {
    struct estimator estimator;
    struct equations *part;  /* [PARTS] */
    int count, joined;       /* each of the first parts is so many, a power of two,
                              * the last may be of fewer */
    int in_last;
    int all, left_out;       /* that were closed; without equations: at rest, too short */
    bool dropped;            /* what the estimator has is of a motion that was cleared */
    struct error why;        /* of the first that was left out */
};

/* Also to be freed after a failure. */
int parts_init(struct parts *p, struct error *error);
void parts_free(struct parts *p);

/* Gives a part away: takes the recording over. Waits for the part before. */
void parts_close(struct parts *p, struct recording *recording);

/* Drops all of them, without waiting. */
void parts_clear(struct parts *p);

/* Takes what the estimator has ready, or waits for what it has. */
void parts_take(struct parts *p, bool wait);

/* One more, whose equations the caller made. */
void parts_add(struct parts *p, const struct equations *e, const struct error *error);

/* The sum of all, and whether they agree (agreement->logs is 1 or 0 where there is nothing to
 * compare; NULL: not asked). -2 where there is none, and why. */
int parts_sum(const struct parts *p, const struct params *configured, struct equations *sum, struct agreement *agreement,
              struct error *error);

#endif
