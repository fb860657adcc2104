/* Reasons for which a sample, a segment, a cycle or a test is excluded from the evaluation. All
 * code that excludes uses this one list, which has a sentence for people and a remedy for each
 * reason. Whole recordings are refused by admit.h. `hexid doctor --refusals` prints the table for
 * the documentation. Pure. */
#ifndef HEXID_REFUSAL_H
#define HEXID_REFUSAL_H

#include <stdio.h>

#include "types.h"

/* clang-format off */
enum refusal {
    REFUSED_NOT, /* used */
    /* for samples: first the flags of types.h, in the order of their bits */
    REFUSED_STALE, REFUSED_LATE, REFUSED_DROPPED, REFUSED_INVALID, REFUSED_OVERRUN, REFUSED_IO,
    REFUSED_FOREIGN, REFUSED_OPEN, REFUSED_UNWRITTEN, REFUSED_TWIN,
    REFUSED_NO_NUMBER, REFUSED_NO_POSE, REFUSED_UNPLACED, REFUSED_OUTSIDE,
    REFUSED_SURPLUS, /* for samples and segments */
    /* for segments of any motion, or cycles of a sinusoid */
    REFUSED_GAP, REFUSED_TURN, REFUSED_REST, REFUSED_NOISE,
    /* for tests */
    REFUSED_EMPTY, REFUSED_INCOMPLETE,
    REFUSED_UNDETERMINED, /* for tests and cycles */
    REFUSALS
};
/* clang-format on */

struct refusal_row {
    const char *word;   /* reason in one word; where JSON has the reason, it uses this word */
    const char *what;   /* kind of thing that is excluded */
    const char *why;    /* sentence for people, without capital and full stop */
    const char *remedy; /* what to do about it */
};
extern const struct refusal_row refusals[REFUSALS]; /* the row of REFUSED_NOT is empty */

/* Returns the reason for which a cycle's sample is not used: its first flag, or a length of one of
 * the first `legs` legs that is no number. */
enum refusal refusal_of(const struct cycle *cycle, int legs);

/* Prints the table in Markdown. */
void refusal_print(FILE *out);

#endif
