/* Writes the configuration of a machine with what an identification found (machine_found.h), for
 * `hexid run -c`. */
#ifndef HEXID_MODEL_FILE_H
#define HEXID_MODEL_FILE_H

#include <stdio.h>

#include "machine_found.h"
#include "output.h"
#include "verdict.h"

struct model_file {
    const char *name, *log;             /* the file, and the (first) log */
    const struct params *params;        /* configuration with what was found about the sensors */
    const struct test_params *tests;    /* tests to write: those of the configuration, not of the
                                         * log */
    const struct method_c *method_c;
    const struct estimate *estimate;
    const struct loop_survey *survey;   /* NULL: the log is of no survey */
    const struct verdict *verdict;
};

/* Writes the file and says on `out` what stays as configured. With a verdict of fail, and without a
 * result, it writes nothing and says why. Returns 0; -2 if no machine is as found, -3 if the file
 * was not written. */
int model_file_write(const struct model_file *m, struct output *to, FILE *out, struct error *error);

#endif
