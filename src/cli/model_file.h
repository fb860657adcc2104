/* Writes a configuration for `hexid run -c` with the values that an identification found
 * (machine_found.h). */
#ifndef HEXID_MODEL_FILE_H
#define HEXID_MODEL_FILE_H

#include <stdio.h>

#include "machine_found.h"
#include "output.h"
#include "verdict.h"

struct model_file {
    const char *name, *log;             /* name of the file to write, and of the log (the first of
                                         * several) */
    const struct params *params;        /* configuration, corrected by the sensor errors that were
                                         * found */
    const struct test_params *tests;    /* tests to write, `configured` of log_analysis.h */
    const struct method_c *method_c;
    const struct estimate *estimate;
    const struct loop_survey *survey;   /* NULL: the log is of no survey */
    const struct verdict *verdict;
};

/* Writes the file and reports on `out` which values stay as configured. With a verdict of fail, or
 * without a result of method C, it writes nothing, reports why and returns 0. Returns -2 if the
 * values found are no possible configuration, -3 without memory or if writing fails. */
int model_file_write(const struct model_file *m, struct output *to, FILE *out, struct error *error);

#endif
