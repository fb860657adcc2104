/* Evaluates a stream of cycles, live in the recorder or later from a log: identification, loop
 * statistics, verdict. The code is the same for both, so that `hexid identify` repeats the
 * daemon's results to the last bit. One thread at a time; heap. */
#ifndef HEXID_ANALYSIS_H
#define HEXID_ANALYSIS_H

#include "failure.h"
#include "histogram.h"
#include "ident.h"
#include "identification_json.h"
#include "method_c_verdict.h"
#include "motion_result.h"
#include "output.h"
#include "params.h"
#include "parts.h"
#include "verdict.h"

struct analysis {
    const struct params *params;
    struct ident ident;
    struct motion_result motion;
    struct rest rest;
    struct weighing weighing;       /* zeroed: nothing is weighed */
    struct params calibrated;       /* the configuration, corrected by the sensor errors that rests
                                     * and a known weight show; method C is solved with it */
    struct histogram wake, exec;
    struct cycle last;
    char fault[FAULT_LINE_SIZE];    /* text of the latest fault, from a log's event or written by
                                     * analysis_verdicts(); "": none */
    int64_t cycles, overruns, lost; /* numbers of cycles; `lost` is counted from gaps in seq */
    int64_t unlogged;               /* number of cycles received but not in the log */
    bool seen[DOFS];                /* there are cycles of a test of this axis */
    struct gains driven[DOFS];      /* gains of the latest test of each axis seen; a log's cycles
                                     * have none */
    int64_t refused[REFUSALS];      /* number of cycles in evaluated parts by their flags, or
                                     * without flags by the reason why methods A and B exclude
                                     * them */
    int64_t missed, longest_ns;     /* number of deadlines missed in a row up to the last cycle,
                                     * and the longest delay among them */
    struct recording recording;     /* recording for method C: the beginning of each test; for an
                                     * axis at most a sixth of ANALYSIS_SAMPLES */
    struct parts parts;             /* earlier parts of a motion longer than one part */
    int parts_test;             /* index in the list of tests of the motion in `parts` */
    struct equations equations;     /* method C's equations of the recording */
    struct estimate estimate; /* solution of the equations */
    struct error unrecorded;        /* why recording stopped; status 0: it did not */
    int64_t stalls, behind_ns;      /* number of wake-ups late by at least a period, and the sum of
                                     * the whole periods, by which a paced clock is stretched */
};

/* most samples kept: six tests of 100 s at 2 ms; up to 160 MB */
enum { ANALYSIS_SAMPLES = 300000 };
/* length of a part of a motion, s; limits memory, and reveals a machine that changes over time */
#define ANALYSIS_PART_S 180.0

/* Returns -2 with the key if no machine has these params, -3 without memory or thread. Call
 * analysis_free() even then. */
int analysis_init(struct analysis *a, const struct params *params, struct error *error);

/* Frees the recording; results remain. */
void analysis_free(struct analysis *a);

/* Takes a cycle. Returns true if it completed a test. */
bool analysis_take(struct analysis *a, const struct cycle *c);

/* Ends the stream. Returns true if that completed a test. */
bool analysis_end(struct analysis *a);

/* Runs method C on everything recorded; once, after the stream has ended. */
void analysis_identify(struct analysis *a);

/* Copies the recording of complete tests and of motions, without closed parts, for an estimate
 * during the run. Returns -3 without memory; `copy` must be freed even then. */
int analysis_copy(const struct analysis *a, struct recording *copy, struct error *error);

/* Takes a known weight's reading, and solves method C's equations again with it. */
void analysis_weigh(struct analysis *a, const struct weighing_found *found);

struct loop_statistics analysis_statistics(const struct analysis *a);

/* Solves methods A and B, and judges all methods and the run. Method C takes part if
 * analysis_identify() has run. */
struct verdicts analysis_verdicts(struct analysis *a);

/* Returns true if the tests are sinusoids, one axis after another, as methods A and B need. */
bool analysis_sinusoids(const struct analysis *a);

/* Returns 0 if there is a test of an axis, a matrix, or nothing at all; -2 with the reason if other
 * motions were recorded but give no matrix. */
int analysis_identifies(const struct analysis *a, const char *path, struct error *error);

/* Prints the table of results, the loop's statistics and the verdict as text; brief: about eight
 * lines of them. */
void analysis_print(struct analysis *a, const struct verdicts *verdicts, bool brief, FILE *out);

/* Returns identification_json's text, to be freed by the caller; NULL without memory. */
char *analysis_json(const struct analysis *a, const struct verdicts *verdicts);

#endif
