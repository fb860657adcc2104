/* What `hexid report` shows: the identification from one log, or from several side by side. */
#ifndef HEXID_IDENTIFICATION_REPORT_H
#define HEXID_IDENTIFICATION_REPORT_H

#include "ident.h"
#include "identification_json.h"
#include "recording.h"
#include "verdict.h"

enum { REPORT_LOGS = 6 };
#define REPORT_SURE 1.96 /* standard deviations to either side: a 95 % interval */

/* A test of no axis: a multisine, a trajectory. */
struct identification_motion {
    bool there;
    const char *name;
    int64_t samples, excluded;
    double off_m, off_rad;        /* farthest from the reference on an axis */
    bool complete;
};

struct identification_log {
    const char *path;
    int64_t began_us;             /* since 1970; a run in virtual time counts from its start */
    int64_t cut;                  /* byte up to which the log could be read; -1: whole */
    const struct params *params;
    const char *config;           /* the same as text */
    bool sinusoids;               /* of one axis after another: methods A and B */
    const struct identification *id;
    const struct verdict *verdict;
    struct loop_statistics loop;
    const struct recording *recording; /* of complete tests, as method C had it: any motion cut into
                                        * pieces */
    struct identification_motion motion;
    const int64_t *flagged;       /* [SAMPLE_FLAGS], in the evaluated parts */
    const char *fault;            /* the first one, NULL: none */
};

struct identification_report {
    const char *version;          /* of hexid */
    int logs;                     /* 1 .. REPORT_LOGS */
    struct identification_log log[REPORT_LOGS];
};

/* One page without scripts or other files; *page is to be freed. -3 without memory (*page NULL), or
 * where pictures could not be drawn (*page is there, without them). */
int identification_html(const struct identification_report *report, char **page, struct error *error);

#endif
