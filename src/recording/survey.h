/* Inventory of a recording before it is evaluated: its sampling, its segments in time, and each
 * kind of channel. It judges no effect and refuses nothing. Ordinary threads; heap. */
#ifndef HEXID_SURVEY_H
#define HEXID_SURVEY_H

#include "mechanism.h"
#include "sampling.h"
#include "segments.h"

enum survey_kind { SURVEY_LENGTH, SURVEY_REFERENCE, SURVEY_P1, SURVEY_P2, SURVEY_FORCE, SURVEY_COMMAND, SURVEY_KINDS };
/* "length", "reference", "p1", "p2", "force", "command" */
extern const char *const survey_names[SURVEY_KINDS];

enum { SURVEY_NAME = 256 };

/* One kind of channel, over all legs, or, for the reference, over all axes. */
struct survey_channel {
    int of;                  /* number of channels that the mechanism has; a platform has no force
                              * channels */
    unsigned there;          /* bits of the channels that have a number in at least one sample: bit
                              * 0 is leg 1, or the first axis */
    /* bits, as in `there`. dead: channels that never change (not references). clipped: channels
     * that saturate (recording_clipped). */
    unsigned dead, clipped;
    double low, high;        /* extremes of all samples; NaN if there are none */
    /* noise: largest rms noise of a channel, NaN if none is known. step: smallest resolution of a
     * channel, 0 if none is seen. */
    double noise, step;
};

struct survey {
    char name[SURVEY_NAME];     /* name of the file, or of the axis */
    struct recording_test test; /* all samples of the file; they are refused by refusal_of() alone,
                                 * because only the lengths are needed */
    const struct mechanism *mechanism;
    double stated_hz, stated_amplitude; /* as the configuration states them; NaN if no axis is
                                         * tested */
    double measured_hz;         /* frequency of the longest steady segment; NaN if there is none */
    /* Half the range of the motion in the longest steady segment, or, without such a segment, in
     * all samples: m or rad on the tested axis; without a tested axis, m of the leg that moves
     * most. */
    double amplitude;
    int evaluated;              /* first sample of the evaluated part; -1 if there is none */
    /* If the evaluated part begins before the motion is steady: time at which the motion becomes
     * steady, from the start of the test, and least tests.ramp_s that is long enough. Otherwise
     * NaN. */
    double steady_s, ramp_least_s;
    int flagged;                /* number of samples with a flag */
    int not_a_number;           /* number of samples that lack a number in a channel that has
                                 * numbers */
    int unplaced; /* number of samples that were dropped because their time is missing or does not
                   * increase */
    struct sampling sampling;
    struct segments segments;
    struct survey_channel channel[SURVEY_KINDS];
};

/* Starts an empty survey of a test of this axis, with the configured frequency and amplitude as
 * stated ones. */
void survey_init(struct survey *s, const struct params *params, enum dof dof, const char *name);

/* Adds the next cycle. Returns -3 without memory. */
int survey_add(struct survey *s, const struct params *params, const struct cycle *cycle, struct error *error);

/* Evaluates the survey after the last cycle. Returns -3 without memory. */
int survey_end(struct survey *s, const struct params *params, struct error *error);

void survey_free(struct survey *s);

/* Value of channel i of a kind in a sample, SI units. */
double survey_value(const struct recording_sample *sample, enum survey_kind kind, int i);

/* Seconds from the first sample to the last. */
double survey_seconds(const struct survey *s);

#endif
