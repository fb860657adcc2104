/* Checks the input and output files of a command line, so that no input is overwritten and no file
 * is written twice. It compares files, not names, because one file may have several names (links,
 * other spellings, /dev/stdin, /proc/self/fd). Main thread. */
#ifndef HEXID_OUTPUTS_H
#define HEXID_OUTPUTS_H

#include "cli.h"
#include "output.h"

/* Kind of output that a subcommand's options name, apart from --json. */
enum outputs_kind {
    OUTPUTS_NONE,  /* no option names an output */
    OUTPUTS_LOG,   /* --log names a log, or a directory for one */
    OUTPUTS_PAGE,  /* -o or --model names one result: a page or a configuration */
    OUTPUTS_FILE,  /* -o names a log, or a new file that its writer opens */
    OUTPUTS_MODEL, /* -o names the directory of hexid gap */
    OUTPUTS_TESTS, /* -o names the directory of hexid export */
};

/* Checks all outputs before anything is run, read or moved. Refuses with -2, naming both files: an
 * output that is also an input (the configuration, the operands, the files of an operand directory,
 * --measured, --validate, --baseline, the file of --hal sim:FILE, and the trajectory of params,
 * which may be NULL) or that another option writes; an output that would replace a recording; and a
 * results directory that contains recordings. Then prepares `json` and, for OUTPUTS_PAGE, `page` by
 * output_prepare(); either may be NULL. Returns -3 if that fails. */
int outputs_open(const struct options *o, const struct params *params, enum outputs_kind kind, struct output *json, struct output *page,
                 struct error *error);

#endif
