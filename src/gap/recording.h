/* What was measured: the tests of a log as plain arrays, and whether they can be what the configuration says they are. A recording that
 * cannot be is refused, with what is wrong with it: no physical effect is to explain a sensor's plug in the wrong socket. No real time. */
#ifndef HEXID_RECORDING_H
#define HEXID_RECORDING_H

#include "params.h"
#include "status.h"

enum { RECORDING_TESTS = 24 };

struct recording_sample {
    double test_time_s;  /* the controller's clock, from the start of the test */
    double clock_s;      /* the recorder's */
    double length_m[LEGS], p1_pa[LEGS], p2_pa[LEGS];
    double valve[LEGS];  /* computed from this sample, held to the next */
    double ref[DOFS];
    bool good;           /* no flag, all finite */
};

struct recording_test {
    int test;            /* place in the list of tests */
    enum dof dof;
    double frequency_hz, amplitude;
    int count, capacity;
    struct recording_sample *sample;
    int first, end;      /* the evaluated part: first <= i < end */
};

struct recording {
    const struct params *params; /* the model's */
    int tests;
    struct recording_test test[RECORDING_TESTS];
};

void recording_init(struct recording *r, const struct params *params);
void recording_free(struct recording *r);

/* Takes the cycles of ramp-in and evaluation of every test, in order. -3 without memory. */
int recording_add(struct recording *r, const struct cycle *cycle, struct error *error);

/* 0; or -2 with what is wrong: no test, too short, all zero, a sensor that stands still or is clipped, another frequency than the
 * model's, lengths that no pose of this machine has, a leg's sign or two legs exchanged. */
int recording_check(const struct recording *r, struct error *error);

/* Recorder's clock over the controller's, over all evaluated parts, and the standard deviation of that. NaN without two clocks. */
double recording_clock(const struct recording *r, double *std);

#endif
