/* Contents of `hexid report`: the identification from one log, or the identifications from several
 * logs side by side. */
#ifndef HEXID_IDENTIFICATION_REPORT_H
#define HEXID_IDENTIFICATION_REPORT_H

#include "ident.h"
#include "identification_json.h"
#include "recording.h"
#include "verdict.h"

enum { REPORT_LOGS = 6 };

/* A motion that is no single-axis test: a multisine or a trajectory. */
struct identification_motion {
    bool there;                   /* false: the log has no such motion */
    const char *name;
    int64_t samples, excluded;    /* numbers of samples used and excluded in the evaluated part */
    double off_m, off_rad;        /* largest deviations from the reference, of any position and of
                                   * any angle */
    bool complete;                /* the evaluated part came to its end */
};

struct identification_log {
    const char *path;
    int64_t began_us;             /* time when the log begins, us since 1970; in virtual time since
                                   * the run's start */
    int64_t cut;                  /* byte up to which the log could be read; -1: to its end */
    const struct params *params;
    const char *config;           /* the parameters, as text of a configuration */
    bool sinusoids;               /* the tests are sinusoids of one axis after another, which
                                   * methods A and B require */
    const struct identification *id;
    const struct verdicts *verdicts;
    struct loop_statistics loop;
    /* complete tests, as method C used them; any other motion is cut into segments. If a long
     * motion was evaluated in parts, only what came after its last full part is here. */
    const struct recording *recording;
    struct identification_motion motion;
    const int64_t *refused;       /* [REFUSALS]: number of samples in the evaluated parts that were
                                   * excluded for each reason */
    const char *fault;            /* name of the first fault, with its measured value if known;
                                   * NULL: there was none */
};

struct identification_report {
    const char *version;          /* version of hexid */
    int logs;                     /* number of logs, 1 .. REPORT_LOGS */
    struct identification_log log[REPORT_LOGS];
};

/* Writes the report as one page without scripts or other files; the caller frees *page. Returns -3
 * without memory (*page is NULL), or if pictures could not be drawn (*page is complete except for
 * the pictures). */
int identification_html(const struct identification_report *report, char **page, struct error *error);

#endif
