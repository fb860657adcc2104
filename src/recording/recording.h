/* The tests of a log as plain arrays of samples. Ordinary threads; heap. */
#ifndef HEXID_RECORDING_H
#define HEXID_RECORDING_H

#include <stdint.h>

#include "params/tests.h"
#include "refusal.h"
#include "status.h"

struct measured;
struct params;

enum { RECORDING_TESTS = 96, RECORDING_RUNS = 4 };
#define RECORDING_CLOCK_TOLERANCE 1e-4 /* largest relative difference between two clocks that their
                                        * crystals explain */
#define RECORDING_FASTEST_HZ 40.0 /* fastest motion that any platform makes */

struct recording_sample {
    double test_time_s;  /* controller's clock, s from the start of the test */
    double clock_s;      /* recorder's clock, s */
    double length_m[LEGS], p1_pa[LEGS], p2_pa[LEGS];
    double force_n[LEGS];/* A1 P1 - A2 P2; without pressures, the reading of a force sensor or a
                          * drive */
    double valve[LEGS];  /* valve commands, -1..1, that were computed from this sample and held
                          * until the next */
    double ref[DOFS];
    enum refusal refused;/* reason why the sample is not used: a flag, or a measured value that is
                          * no number */
};

struct recording_test {
    int run;             /* index of the run that the test belongs to */
    int test;            /* number of the test, from 0, counted on from one run to the next */
    enum dof dof;
    double frequency_hz; /* frequency of the motion: at first the stated one, which measured_add()
                          * replaces by the measured one if the two differ; NaN for a segment or
                          * several axes */
    double stated_hz, amplitude;
    double segment_s, start_s; /* length and start of a segment of any motion; segment_s is 0 for a
                                * whole test */
    int segment;         /* number of the segment among those of all records, from 0 */
    int count, capacity;
    int64_t offered;     /* number of samples offered so far, including those that were dropped to
                          * thin a long test */
    int thinned; /* number of times that every other block of samples was dropped; the gaps look
                  * like lost samples */
    struct recording_sample *sample;
    bool borrowed;       /* the samples belong to another test or recording, which frees them */
    enum refusal refused;/* REFUSED_NOISE if a segment is mostly noise and therefore not
                          * evaluated */
    int first, end;      /* the evaluated part: samples first <= i < end; first is -1 if there is
                          * none */
    struct measured *measured; /* results of measured_make(); NULL before that call */
};

/* Signals that the log has, beside the lengths, which it always has. After recording_settle()
 * missing pressures and commands are zero in every sample, as are legs that the mechanism does not
 * have; a missing reference may be NaN. */
struct recording_measured {
    bool force, pressures, valve, reference;
};

/* One machine, recorded in one or several runs. Each run has tests with frequencies, amplitudes and
 * axes of its own. */
struct recording {
    const struct params *params; /* parameters of the configured model */
    struct recording_measured measured; /* signals of the last run; admit() requires that
                                         * all runs have the same */
    struct recording_measured measured_before; /* signals of the run before */
    int runs;
    struct test_params run[RECORDING_RUNS];
    int tests;
    struct recording_test test[RECORDING_TESTS];
};

/* Starts a recording of one run with the tests of the configured model; params must outlive it. */
void recording_init(struct recording *r, const struct params *params);
void recording_free(struct recording *r);

/* Starts a new run with these tests: cycles added after this call belong to it. Returns -2 if there
 * are RECORDING_RUNS runs already. */
int recording_begin(struct recording *r, const struct test_params *tests, struct error *error);

/* Adds one cycle. Cycles must come in the order of their time: one with another test or axis, or
 * with a time that does not increase, begins a new test. Cycles of a test's ramp-in and evaluated
 * part are kept, and all cycles of a test without a tested axis; other cycles are ignored. A long
 * motion is thinned evenly to at most 125 MB. Returns -2 if there are too many tests, -3 without
 * memory. */
int recording_add(struct recording *r, const struct cycle *cycle, struct error *error);

void recording_remove(struct recording *r, int test);

/* A cycle's values as a sample. It is refused if refusal_of() gives a reason, or if its time or
 * force is no number. */
struct recording_sample recording_sample_of(const struct params *params, const struct cycle *cycle);

/* Appends a sample to a test; times must increase. Returns -3 without memory. */
int recording_append(struct recording_test *test, const struct recording_sample *sample, struct error *error);

/* Finishes the recording after the last cycle. A sample is refused if a pressure or a command that
 * the log has is no number in it; pressures or commands that the log lacks become zero. */
void recording_settle(struct recording *r);

/* Index of the first sample at or after this time; t->count if all are earlier. */
int recording_at(const struct recording_test *t, double test_time_s);

/* Name of a test's axis, for messages; "none" if no axis is tested. */
const char *recording_test_name(const struct recording_test *t);

/* Index of the first test of the last run. Runs are checked one by one, because a mean over all
 * runs would hide a plug that was in the wrong socket in one run. */
int recording_first_of_run(const struct recording *r);

/* True for a test that is no segment, and for the first segment of a record. */
bool recording_begins(const struct recording *r, int test);

/* First test of this axis in this run, or NULL. */
const struct recording_test *recording_find(const struct recording *r, int run, enum dof dof);

/* Rate of the recorder's clock relative to the controller's, fitted to the evaluated parts of all
 * tests; every test must have one. std: receives the standard deviation of the rate. NaN if the
 * recorder's time stamps stand still. */
double recording_clock(const struct recording *r, double *std);

#endif
