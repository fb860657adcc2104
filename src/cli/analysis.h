/* Evaluates a stream of cycles: identification, loop statistics, verdict. The recorder uses this
 * code live, and commands such as `hexid identify` use it on logs, so that they repeat the daemon's
 * results to the last bit. One thread at a time; heap. */
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
    struct weighing weighing;       /* readings of a known weight; zeroed: nothing is weighed */
    struct params calibrated;       /* the configuration, corrected by the sensor errors that rests
                                     * and a known weight show; method C is solved with it */
    struct histogram wake, exec;
    struct cycle last;
    char fault[FAULT_LINE_SIZE];    /* text of the latest fault, taken from a log's event or written
                                     * by analysis_verdicts(); "": none */
    int64_t cycles, overruns, lost; /* numbers of cycles; `lost` is counted from gaps in seq */
    int64_t unlogged;               /* number of cycles received but not in the log */
    bool seen[DOFS];                /* there are cycles of a test of this axis */
    struct gains driven[DOFS];      /* gains of the latest test of each axis that was seen; the
                                     * cycles of a log carry no gains */
    int64_t refused[REFUSALS];      /* numbers of cycles in evaluated parts: by each flag; without
                                     * flags by the reason why methods A and B exclude them, or
                                     * REFUSED_NOT */
    int64_t missed, longest_ns;     /* number of deadlines missed in a row up to the last cycle,
                                     * and the longest delay among them */
    struct recording recording;     /* recording for method C: the first samples of each test; at
                                     * most ANALYSIS_SAMPLES / 6 of a test of an axis */
    struct parts parts;             /* earlier parts of a motion that is longer than
                                     * ANALYSIS_PART_S */
    int parts_test;             /* index, in the list of tests, of the last motion of which a part
                                 * is in `parts` */
    struct measured_recording measured; /* frequencies and spectra of the recording; filled by
                                         * analysis_identify() */
    struct admission admission;
    struct equations equations;     /* method C's equations of the recording */
    struct estimate estimate; /* solution of the equations */
    struct error unrecorded;        /* why recording stopped; status 0: it did not */
    int64_t stalls, behind_ns;      /* number of wake-ups that were late by at least a period, and
                                     * the sum of the whole periods by which they were late; a paced
                                     * clock is stretched by that sum */
};

/* largest number of samples kept: six tests of 100 s at 2 ms; up to 160 MB */
enum { ANALYSIS_SAMPLES = 300000 };
/* length of the parts into which a longer motion is cut, s; parts limit memory, and their
 * comparison reveals a machine that changes over time */
#define ANALYSIS_PART_S 180.0

/* Returns -2 with the key if the params describe no possible machine, -3 without memory or thread.
 * Call analysis_free() even then. */
int analysis_init(struct analysis *a, const struct params *params, struct error *error);

/* Frees the recording; results remain. */
void analysis_free(struct analysis *a);

/* Takes a cycle. Returns true if it completed a test. */
bool analysis_take(struct analysis *a, const struct cycle *c);

/* Ends the stream. Returns true if that completed a test. */
bool analysis_end(struct analysis *a);

/* Runs method C on everything recorded. To be called once, after analysis_end(). */
void analysis_identify(struct analysis *a);

/* Copies those recorded samples that belong to complete tests or to a motion of no axis, for an
 * estimate during the run; closed parts are not copied. Returns -3 without memory; `copy` must be
 * freed even then. */
int analysis_copy(const struct analysis *a, struct recording *copy, struct error *error);

/* Takes the reading of a known weight, and solves method C's equations again with the sensor errors
 * that it shows. */
void analysis_weigh(struct analysis *a, const struct weighing_found *found);

struct loop_statistics analysis_statistics(const struct analysis *a);

/* Solves methods A and B, and judges all methods and the run. Method C takes part if
 * analysis_identify() has run. */
struct verdicts analysis_verdicts(struct analysis *a);

/* Returns true if the tests are sinusoids, one axis after another, as methods A and B require. */
bool analysis_sinusoids(const struct analysis *a);

/* Returns -2 with the reason if a motion of no axis was recorded, no test of an axis was evaluated
 * and method C gives no matrix; otherwise 0, also if nothing was recorded. */
int analysis_identifies(const struct analysis *a, const char *path, struct error *error);

/* Prints the table of results, the loop's statistics and the verdict as text; brief: only about
 * eight lines. */
void analysis_print(struct analysis *a, const struct verdicts *verdicts, bool brief, FILE *out);

/* Returns identification_json's text, to be freed by the caller; NULL without memory. */
char *analysis_json(const struct analysis *a, const struct verdicts *verdicts);

#endif
