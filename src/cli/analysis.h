/* What is computed from a stream of cycles, live by the recorder or later from a log:
 * identification, loop statistics, verdict. One code for both, so that `hexid identify` repeats the
 * daemon's results to the last bit. One thread at a time; heap. */
#ifndef HEXID_ANALYSIS_H
#define HEXID_ANALYSIS_H

#include "failure.h"
#include "histogram.h"
#include "ident.h"
#include "identification_json.h"
#include "motion_result.h"
#include "output.h"
#include "parts.h"
#include "verdict.h"

struct analysis {
    const struct params *params;
    struct ident ident;
    struct motion_result motion;
    struct histogram wake, exec;
    struct cycle last;
    char fault[FAULT_LINE_SIZE];    /* of last, as a log's event had it; "": not heard */
    int64_t cycles, overruns, lost; /* lost: gaps in seq */
    int64_t unlogged;               /* cycles that came, and that the log has not */
    bool seen[DOFS];                /* a test of this axis has cycles */
    int64_t flagged[SAMPLE_FLAGS];  /* cycles of evaluated parts with this flag */
    int64_t missed, longest_ns;     /* deadlines missed in a row up to the last cycle, and the
                                     * longest delay among them */
    struct recording recording;     /* for method C: the beginning of each test, of an axis at most
                                     * a sixth of ANALYSIS_SAMPLES, */
    struct parts parts;             /* and the earlier parts of a motion that is longer than a
                                     * part; */
    int parts_test;                 /* that motion's place in the list of tests */
    struct equations equations;     /* method C's, of all that was recorded, and their solution */
    struct estimate estimate;
    struct error unrecorded;        /* why recording stopped; status 0: it did not */
    int64_t stalls, behind_ns;      /* wake-ups a period or more late, and the sum of the whole
                                     * periods they were late: what a paced clock stretches */
};

enum { ANALYSIS_SAMPLES = 300000 }; /* six tests of 100 s at 2 ms; up to 160 MB */
/* length of a part of a motion: bounds memory, and shows a machine that changes on the way */
#define ANALYSIS_PART_S 180.0

/* -2 with the key when params make no machine, -3. To be released by analysis_free(), also when
 * this failed. */
int analysis_init(struct analysis *a, const struct params *params, struct error *error);

/* Frees the recording; results stay. */
void analysis_free(struct analysis *a);

/* True when the cycle completed a test. */
bool analysis_take(struct analysis *a, const struct cycle *c);

/* The stream has ended. True when that closed a test under way. */
bool analysis_end(struct analysis *a);

/* Method C of all that was recorded: once, after the stream has ended. */
void analysis_identify(struct analysis *a);

/* Copies what is recorded of complete tests and of motions, for an estimate during the run; parts
 * already closed are not in it. -3: memory; `copy` is to be freed all the same. */
int analysis_copy(const struct analysis *a, struct recording *copy, struct error *error);

struct loop_statistics analysis_statistics(const struct analysis *a);

/* Solves what can be solved and judges it. */
struct verdict analysis_verdict(struct analysis *a);

/* The fault that the last cycle has, with what was measured of it; NULL: none. Good until the next
 * call. */
const char *analysis_fault(struct analysis *a);

/* Are the tests sinusoids, one axis after another, as methods A and B need them? */
bool analysis_sinusoids(const struct analysis *a);

/* 0 where there is a test of an axis, a matrix, or nothing at all; -2 with the reason for a
 * recording of other motions from which no matrix comes. */
int analysis_identifies(const struct analysis *a, const char *path, struct error *error);

/* Table, loop and verdict for people. */
void analysis_print(struct analysis *a, const struct verdict *verdict, FILE *out);

/* identification_json of it: to be freed by the caller; NULL without memory. */
char *analysis_json(const struct analysis *a, const struct verdict *verdict);

/* Writes the same as JSON to `to`, which was prepared. Returns -3 on failure. */
int analysis_write_json(struct analysis *a, const struct verdict *verdict, struct output *to, struct error *error);

#endif
