/* A recording's pieces in time, by the measured lengths alone, whatever the file says of its
 * motion: where the machine rests, where it repeats one motion, where it moves otherwise (ramps,
 * sweeps, steps, anything). For any motion and 100 Hz to 10 kHz. Ordinary threads; heap. */
#ifndef HEXID_PIECES_H
#define HEXID_PIECES_H

#include "recording.h"

enum piece_kind {
    PIECE_REST,   /* for half a second at least all legs stay within their noise, or
                   * within 0.3 % of how far they go */
    PIECE_STEADY, /* four cycles at least, alike but for noise and 5 % (20 % where all differ so),
                   * of one frequency and amplitude */
    PIECE_MOVING, /* all else */
    PIECE_KINDS
};
extern const char *const piece_names[PIECE_KINDS]; /* "rest", "steady", "moving" */

struct piece {
    int first, end;      /* samples of the test: first <= i < end */
    enum piece_kind kind;
    double frequency_hz; /* steady: of the whole motion's repetition, 1e-3 or better; else NaN */
};

/* In order, without gaps, from the first sample to the last; neighbours differ. */
struct pieces {
    int count;
    struct piece *piece;
};

/* Of all samples of the test, not the evaluated part alone; what is not good counts as lost. Times
 * increase. Fewer than ten good samples: one piece, moving. -3 without memory. */
int pieces_find(struct pieces *p, const struct recording_test *test, int legs, struct error *error);
void pieces_free(struct pieces *p);

/* The longest piece of a kind, or NULL. */
const struct piece *pieces_longest(const struct pieces *p, enum piece_kind kind);

#endif
