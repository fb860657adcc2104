/* Splits a recording into pieces, segments in time: rest, steady repetition, and any other motion
 * (ramps, sweeps, steps). Only the measured lengths decide, whatever the file says of its motion.
 * For sampling rates from 100 Hz to 10 kHz. Ordinary threads; heap. */
#ifndef HEXID_PIECES_H
#define HEXID_PIECES_H

#include "recording.h"

enum piece_kind {
    /* For half a second or longer all legs stay within their noise, or within 0.3 % of their
     * range. */
    PIECE_REST,
    /* At least four cycles of one frequency and amplitude, which differ by noise and at most 5 %
     * (20 % if all differ so). */
    PIECE_STEADY,
    PIECE_MOVING, /* all other motion */
    PIECE_KINDS
};
extern const char *const piece_names[PIECE_KINDS]; /* "rest", "steady", "moving" */

struct piece {
    int first, end;      /* samples of the test: first <= i < end */
    enum piece_kind kind;
    double frequency_hz; /* repetition rate of a steady piece, with a relative error of at most
                          * 1e-3; otherwise NaN */
};

/* All pieces of a test in order, without gaps, from the first sample to the last. Neighbours differ
 * in kind or frequency. */
struct pieces {
    int count;
    struct piece *piece;
};

/* Splits all samples of the test, not only its evaluated part. Bad samples count as lost. Times
 * must increase. With fewer than ten good samples the result is one moving piece. Returns -3
 * without memory. */
int pieces_find(struct pieces *p, const struct recording_test *test, int legs, struct error *error);
void pieces_free(struct pieces *p);

/* The piece of this kind with the most samples, or NULL. */
const struct piece *pieces_longest(const struct pieces *p, enum piece_kind kind);

#endif
