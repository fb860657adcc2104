/* The tests of a log as plain arrays of samples. Not real-time; uses the heap. */
#ifndef HEXID_RECORDING_H
#define HEXID_RECORDING_H

#include <stdint.h>

#include "params.h"
#include "status.h"

enum { RECORDING_TESTS = 96, RECORDING_RUNS = 4 };
#define RECORDING_CLOCK_TOLERANCE 1e-4 /* relative error between the crystals of two clocks */
#define RECORDING_FASTEST_HZ 40.0 /* no platform is moved faster */

struct recording_sample {
    double test_time_s;  /* controller's clock, from the start of the test */
    double clock_s;      /* recorder's clock */
    double length_m[LEGS], p1_pa[LEGS], p2_pa[LEGS];
    double force_n[LEGS];/* A1 P1 - A2 P2; without pressures, from a force sensor or a drive */
    double valve[LEGS];  /* command computed from this sample, held to the next */
    double ref[DOFS];
    bool good;           /* no flag, and every measured value is finite */
};

struct recording_test {
    int run;             /* run that it belongs to, from 0 */
    int test;            /* place in the list of tests, counted through all runs */
    enum dof dof;
    double frequency_hz; /* as stated; recording_check() puts the legs' own here if it differs */
    double stated_hz, amplitude;
    double piece_s, start_s; /* this piece of any motion; 0 for a steady sinusoid */
    int piece;           /* number of the piece, from 0 */
    int count, capacity;
    int64_t offered;     /* samples offered so far; a long test drops blocks of 25000 */
    int thinned; /* times that every other block was dropped; the gaps look like lost samples */
    struct recording_sample *sample;
    bool borrowed;       /* another piece owns the samples */
    bool noisy;          /* the piece is mostly noise and not evaluated */
    int first, end;      /* the evaluated part: first <= i < end */
};

/* Signals that the log has, beside the lengths, which are always there. A missing signal is zero in
 * every sample, as are legs that the mechanism does not have. */
struct recording_measured {
    bool force, pressures, valve, reference;
};

/* One machine, recorded in one or several runs; each run has its own tests: frequencies,
 * amplitudes, axes. */
struct recording {
    const struct params *params; /* the model's parameters */
    struct recording_measured measured; /* last run's; recording_check() requires that all runs
                                         * agree */
    struct recording_measured measured_before;
    int runs;
    struct test_params run[RECORDING_RUNS];
    int tests;
    struct recording_test test[RECORDING_TESTS];
};

/* Starts a recording of one run with the model's tests. */
void recording_init(struct recording *r, const struct params *params);
void recording_free(struct recording *r);

/* Starts a new run with these tests: cycles added after this call belong to it. Returns -2 if there
 * are RECORDING_RUNS already. */
int recording_begin(struct recording *r, const struct test_params *tests, struct error *error);

/* Takes one cycle: keeps those of ramp-in and of the evaluated part of every test, which must come
 * in order. A long motion is thinned evenly to at most 125 MB. Returns -3 without memory. */
int recording_add(struct recording *r, const struct cycle *cycle, struct error *error);

void recording_remove(struct recording *r, int test);

/* A cycle's values as a sample, which is good if no flag is set and time, lengths and forces are
 * finite. */
struct recording_sample recording_sample_of(const struct params *params, const struct cycle *cycle);

/* Appends a sample to a test; times must increase. Returns -3 without memory. */
int recording_append(struct recording_test *test, const struct recording_sample *sample, struct error *error);

/* Finishes the recording after the last cycle: samples stay good only if all signals of the log are
 * finite, and missing signals become zero. */
void recording_settle(struct recording *r);

/* Index of the first sample at or after this time; count if all are earlier. */
int recording_at(const struct recording_test *t, double test_time_s);

/* Mean sampling period of a test's evaluated part, gaps left out. */
double recording_step_s(const struct recording_test *t);

/* The first test of this axis in this run, or NULL. */
const struct recording_test *recording_find(const struct recording *r, int run, enum dof dof);

/* Rate of the recorder's clock over the controller's, fitted to all evaluated parts, and its
 * standard deviation. NaN unless there are two clocks. */
double recording_clock(const struct recording *r, double *std);

#endif
