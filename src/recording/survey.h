/* What is in a recording, before anything is asked of it: sampling, pieces in time, and each kind
 * of channel. Judges no effect and refuses nothing. Ordinary threads; heap. */
#ifndef HEXID_SURVEY_H
#define HEXID_SURVEY_H

#include "pieces.h"
#include "sampling.h"

enum survey_kind { SURVEY_LENGTH, SURVEY_REFERENCE, SURVEY_P1, SURVEY_P2, SURVEY_FORCE, SURVEY_COMMAND, SURVEY_KINDS };
extern const char *const survey_names[SURVEY_KINDS]; /* "length", "reference", "p1", "p2",
                                                      * "force", "command" */

enum { SURVEY_NAME = 256 };

/* One kind of channel, all legs; of the reference all axes. */
struct survey_channel {
    int of;                  /* channels that the mechanism has: a platform no force */
    unsigned there;          /* those with a number in any sample, bits from leg 1's */
    unsigned dead, clipped;  /* never change (not of the reference); at the end of what they
                              * read (recording_clipped) */
    double low, high;        /* of all samples; NaN: none */
    double noise, step;      /* the largest rms; the smallest step of a sensor, 0: none is seen */
};

struct survey {
    char name[SURVEY_NAME];     /* the file's, or the axis's */
    struct recording_test test; /* all samples of the file, good: no flag and
                                 * all lengths are numbers */
    enum mechanism_kind mechanism;
    double stated_hz, stated_amplitude; /* NaN: no axis is tested */
    double measured_hz;         /* of the longest steady piece; NaN: none */
    double amplitude;           /* half the swing there, else in all: m or rad on the tested axis;
                                 * without one, m of the leg that moves most */
    int evaluated;              /* the first sample of the evaluated part; -1: none */
    double steady_s, ramp_least_s; /* where that is before the motion is steady: since when it is,
                                 * and what ramp_s must be at least; else NaN */
    int flagged;                /* samples with a flag */
    int not_a_number;           /* samples without a number where the channel has some */
    int unplaced;               /* without a time, or one that does not increase: left out */
    struct sampling sampling;
    struct pieces pieces;
    struct survey_channel channel[SURVEY_KINDS];
};

/* Empty, of a test of this axis as the configuration states it. */
void survey_init(struct survey *s, const struct params *params, enum dof dof, const char *name);

/* The next cycle. -3 without memory. */
int survey_add(struct survey *s, const struct params *params, const struct cycle *cycle, struct error *error);

/* After the last one. -3 without memory. */
int survey_end(struct survey *s, const struct params *params, struct error *error);

void survey_free(struct survey *s);

/* Value i of a kind in a sample, SI units. */
double survey_value(const struct recording_sample *sample, enum survey_kind kind, int i);

/* Seconds from the first sample to the last. */
double survey_seconds(const struct survey *s);

#endif
