/* Contents of `hexid report`: the identification from one log, or from several side by side. */
#ifndef HEXID_IDENTIFICATION_REPORT_H
#define HEXID_IDENTIFICATION_REPORT_H

#include "ident.h"
#include "identification_json.h"
#include "recording.h"
#include "verdict.h"

enum { REPORT_LOGS = 6 };
#define REPORT_SURE 1.96 /* standard deviations to either side: a 95 % interval */

/* A test that is not of a single axis: a multisine, a trajectory. */
struct identification_motion {
    bool there;
    const char *name;
    int64_t samples, excluded;
    double off_m, off_rad;        /* largest deviations from the reference on an axis */
    bool complete;
};

struct identification_log {
    const char *path;
    int64_t began_us;             /* since 1970; a run in virtual time counts from its start */
    int64_t cut;                  /* byte up to which the log could be read; -1: whole */
    const struct params *params;
    const char *config;           /* params as text */
    bool sinusoids;               /* one axis after another, for methods A and B */
    const struct identification *id;
    const struct verdict *verdict;
    struct loop_statistics loop;
    /* the complete tests, as method C used them: any motion cut into pieces */
    const struct recording *recording;
    struct identification_motion motion;
    const int64_t *flagged;       /* [SAMPLE_FLAGS], in the evaluated parts */
    const char *fault;            /* the first one; NULL: none */
};

struct identification_report {
    const char *version;          /* hexid's */
    int logs;                     /* 1 .. REPORT_LOGS */
    struct identification_log log[REPORT_LOGS];
};

/* Writes one page without scripts or other files; free *page. Returns -3 without memory (*page is
 * NULL), or if pictures could not be drawn (*page is complete but for them). */
int identification_html(const struct identification_report *report, char **page, struct error *error);

#endif
