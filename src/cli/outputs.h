/* The files that a command line reads and those that it writes. What is read is never written, and
 * nothing is written twice, whatever it is called: files are compared, not names (links, other
 * spellings, /dev/stdin, /proc/self/fd). Main thread. */
#ifndef HEXID_OUTPUTS_H
#define HEXID_OUTPUTS_H

#include "cli.h"
#include "output.h"

/* Kind of output that a subcommand's options name, beside --json. */
enum outputs_kind {
    OUTPUTS_NONE,  /* nothing */
    OUTPUTS_LOG,   /* --log: a log, or a directory for one */
    OUTPUTS_PAGE,  /* -o: a result */
    OUTPUTS_FILE,  /* -o: a log, or a new file, opened by whoever writes it */
    OUTPUTS_MODEL, /* -o: the directory of hexid gap */
    OUTPUTS_TESTS, /* -o: the directory of hexid export */
};

/* Before anything is run, read or moved: refuses with -2, naming both files, an output that is also
 * read (the configuration, the operands, the files of a directory that is one, --measured,
 * --validate, params' trajectory; params NULL: none) or written by another option, one that stands
 * where a recording is, and a directory of results that has recordings in it. Then prepares `json`
 * and, for OUTPUTS_PAGE, `page`: output_prepare(). Either may be NULL. -3. */
int outputs_open(const struct options *o, const struct params *params, enum outputs_kind kind, struct output *json, struct output *page,
                 struct error *error);

#endif
