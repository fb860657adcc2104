/* Inventory of a recording before it is evaluated: sampling, pieces in time, and each kind of
 * channel. It judges no effect and refuses nothing. Ordinary threads; heap. */
#ifndef HEXID_SURVEY_H
#define HEXID_SURVEY_H

#include "pieces.h"
#include "sampling.h"

enum survey_kind { SURVEY_LENGTH, SURVEY_REFERENCE, SURVEY_P1, SURVEY_P2, SURVEY_FORCE, SURVEY_COMMAND, SURVEY_KINDS };
/* "length", "reference", "p1", "p2", "force", "command" */
extern const char *const survey_names[SURVEY_KINDS];

enum { SURVEY_NAME = 256 };

/* One kind of channel over all legs; the reference over all axes. */
struct survey_channel {
    int of;                  /* channels that the mechanism has; a platform has no force channels */
    unsigned there;          /* channels with a number in any sample, bit 0 is leg 1 */
    unsigned dead, clipped;  /* never change (references excepted); saturate (recording_clipped) */
    double low, high;        /* extremes of all samples; NaN if there are none */
    double noise, step;      /* largest noise rms; smallest resolution, 0 if none is seen */
};

struct survey {
    char name[SURVEY_NAME];     /* the file's, or the axis's */
    struct recording_test test; /* all samples of the file; good: no flag, all lengths finite */
    enum mechanism_kind mechanism;
    double stated_hz, stated_amplitude; /* NaN if no axis is tested */
    double measured_hz;         /* frequency of the longest steady piece; NaN without one */
    /* Half the swing in that piece, or in all samples without one: m or rad on the tested axis;
     * without an axis, m of the leg that moves most. */
    double amplitude;
    int evaluated;              /* first sample of the evaluated part; -1 without one */
    /* If the evaluated part begins too early: when the motion gets steady, and the least
     * tests.ramp_s that would do. Else NaN. */
    double steady_s, ramp_least_s;
    int flagged;                /* samples with a flag */
    int not_a_number;           /* samples that lack a number in a channel that has some */
    int unplaced; /* samples dropped because their time is missing or does not increase */
    struct sampling sampling;
    struct pieces pieces;
    struct survey_channel channel[SURVEY_KINDS];
};

/* Starts an empty survey of a test of this axis, as the configuration states it. */
void survey_init(struct survey *s, const struct params *params, enum dof dof, const char *name);

/* Adds the next cycle. Returns -3 without memory. */
int survey_add(struct survey *s, const struct params *params, const struct cycle *cycle, struct error *error);

/* Evaluates after the last cycle. Returns -3 without memory. */
int survey_end(struct survey *s, const struct params *params, struct error *error);

void survey_free(struct survey *s);

/* Value i of a kind in a sample, SI units. */
double survey_value(const struct recording_sample *sample, enum survey_kind kind, int i);

/* Seconds from the first sample to the last. */
double survey_seconds(const struct survey *s);

#endif
