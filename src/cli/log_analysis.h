/* Reads a log from beginning to end for `hexid identify` and `hexid report`: its configuration, and
 * what is computed from its cycles. */
#ifndef HEXID_LOG_ANALYSIS_H
#define HEXID_LOG_ANALYSIS_H

#include "analysis.h"
#include "cli.h"

struct log_analysis {
    struct params params;        /* the log's own, changed by --set; or of -c */
    struct analysis analysis;    /* with method C */
    struct verdict verdict;
    int64_t began_us;            /* of the log's clock: since 1970, in virtual time since the run's
                                  * start */
    int64_t cut;                 /* byte up to which it could be read; -1: whole */
};

/* To be released by log_analysis_free(), also when this failed: -3 no log; -2 no
 * machine, or nothing in it to identify. A log that is cut off is warned about, and
 * evaluated as far as it goes. */
int log_analysis_read(struct log_analysis *l, const struct options *o, const char *path, struct error *error);
void log_analysis_free(struct log_analysis *l);

#endif
