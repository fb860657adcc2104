/* What was measured: the tests of a log as plain arrays. No real time; heap. */
#ifndef HEXID_RECORDING_H
#define HEXID_RECORDING_H

#include <stdint.h>

#include "params.h"
#include "status.h"

enum { RECORDING_TESTS = 96, RECORDING_RUNS = 4 };
#define RECORDING_CLOCK_TOLERANCE 1e-4 /* relative, between the crystals of two clocks */

struct recording_sample {
    double test_time_s;  /* the controller's clock, from the start of the test */
    double clock_s;      /* the recorder's */
    double length_m[LEGS], p1_pa[LEGS], p2_pa[LEGS];
    double force_n[LEGS];/* A1 P1 - A2 P2; without pressures what a force sensor or a drive says */
    double valve[LEGS];  /* computed from this sample, held to the next */
    double ref[DOFS];
    bool good;           /* no flag, and all that is measured is finite */
};

struct recording_test {
    int run;             /* of the recording, from 0 */
    int test;            /* place in the list of tests, counted through all runs */
    enum dof dof;
    double frequency_hz; /* as stated; after recording_check() as the legs
                          * move, where that is another */
    double stated_hz, amplitude;
    double piece_s, start_s; /* any motion: this piece of it, from start_s on; 0: a steady
                              * sinusoid */
    int piece;           /* its place, from 0 */
    int count, capacity;
    int64_t offered;     /* samples so far; of a long one, blocks of 25000 were left out */
    int thinned;         /* so many times, every other one of those that were left; they look like
                          * samples lost */
    struct recording_sample *sample;
    bool borrowed;       /* the samples are another piece's */
    bool noisy;          /* of a piece: noise for the most part, and left out */
    int first, end;      /* the evaluated part: first <= i < end */
};

/* What the log has at all. Lengths are always there; what is not is zero in every sample, as are
 * the legs that the mechanism has not. */
struct recording_measured {
    bool force, pressures, valve, reference;
};

/* One machine, recorded in one run or in several, each with tests of its own: frequency,
 * amplitude, axes. */
struct recording {
    const struct params *params; /* the model's */
    struct recording_measured measured; /* by the last run; those before must have the
                                         * same (recording_check) */
    struct recording_measured measured_before;
    int runs;
    struct test_params run[RECORDING_RUNS];
    int tests;
    struct recording_test test[RECORDING_TESTS];
};

/* One run, with the model's tests. */
void recording_init(struct recording *r, const struct params *params);
void recording_free(struct recording *r);

/* What is added from now on is of another run, with these tests. -2 when there
 * are RECORDING_RUNS. */
int recording_begin(struct recording *r, const struct test_params *tests, struct error *error);

/* Takes the cycles of ramp-in and evaluation of every test, in order; of a long motion no more than
 * 125 MB, from all over it. -3 without memory. */
int recording_add(struct recording *r, const struct cycle *cycle, struct error *error);

/* Takes a test out again. */
void recording_remove(struct recording *r, int test);

/* A cycle's values as a sample; good: no flag, and time, lengths and forces are numbers. */
struct recording_sample recording_sample_of(const struct params *params, const struct cycle *cycle);

/* One more sample of a test, in the order of time. -3 without memory. */
int recording_append(struct recording_test *test, const struct recording_sample *sample, struct error *error);

/* After the last cycle: samples are good where all is finite that the log has; what it
 * has not is zero. */
void recording_settle(struct recording *r);

/* The first sample that is no earlier; count where all are. */
int recording_at(const struct recording_test *t, double test_time_s);

/* Sampling of a test's evaluated part, lost samples apart. */
double recording_step_s(const struct recording_test *t);

/* The first test of this axis in this run, or NULL. */
const struct recording_test *recording_find(const struct recording *r, int run, enum dof dof);

/* Recorder's clock over the controller's, over all evaluated parts, and the standard deviation of
 * that. NaN without two clocks. */
double recording_clock(const struct recording *r, double *std);

#endif
