/* Reads a whole log for `hexid identify` and `hexid report`: configuration and analysis of its
 * cycles. */
#ifndef HEXID_LOG_ANALYSIS_H
#define HEXID_LOG_ANALYSIS_H

#include "analysis.h"
#include "cli.h"
#include "params.h"

struct log_analysis {
    struct params params;        /* configuration with which the log is evaluated (log_params.h) */
    struct test_params configured; /* tests of -c, or without -c those of the log's configuration,
                                    * with --set applied */
    struct analysis analysis;    /* analysis of all cycles, including method C */
    struct verdicts verdicts;
    int64_t began_us;            /* time of the log's first event on the log's clock, us since 1970,
                                  * or in virtual time since the start of the run */
    int64_t cut;                 /* byte up to which the log was readable; -1: the whole log */
};

/* Reads and analyses a log. The caller calls log_analysis_free(), also after a failure. Returns -3
 * if the log cannot be read, or if neither the log nor -c has a configuration; -2 for an impossible
 * configuration, an unknown run, or if there is nothing to identify. A damaged log is evaluated up
 * to the damage, with a warning. */
int log_analysis_read(struct log_analysis *l, const struct options *o, const char *path, struct error *error);
void log_analysis_free(struct log_analysis *l);

#endif
