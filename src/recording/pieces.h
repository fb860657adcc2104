/* Splits a recording into pieces, segments in time: rest, steady repetition, and any other motion
 * (ramps, sweeps, steps). Uses the measured lengths alone, whatever the file says of its motion.
 * For sampling rates of 100 Hz to 10 kHz. Ordinary threads; heap. */
#ifndef HEXID_PIECES_H
#define HEXID_PIECES_H

#include "recording.h"

enum piece_kind {
    /* For half a second or longer all legs stay within their noise, or within 0.3 % of their
     * range. */
    PIECE_REST,
    /* At least four cycles of one frequency and amplitude, alike but for noise and 5 % (20 % if all
     * differ so). */
    PIECE_STEADY,
    PIECE_MOVING, /* everything else */
    PIECE_KINDS
};
extern const char *const piece_names[PIECE_KINDS]; /* "rest", "steady", "moving" */

struct piece {
    int first, end;      /* samples of the test: first <= i < end */
    enum piece_kind kind;
    double frequency_hz; /* steady: repetition rate, to 1e-3 or better; else NaN */
};

/* The pieces in order, without gaps, from the first sample to the last; neighbours differ in kind
 * or frequency. */
struct pieces {
    int count;
    struct piece *piece;
};

/* Splits all samples of the test, not only its evaluated part; bad samples count as lost. Times
 * must increase. With fewer than ten good samples the result is one piece, moving. Returns -3
 * without memory. */
int pieces_find(struct pieces *p, const struct recording_test *test, int legs, struct error *error);
void pieces_free(struct pieces *p);

/* The longest piece of a kind, or NULL. */
const struct piece *pieces_longest(const struct pieces *p, enum piece_kind kind);

#endif
