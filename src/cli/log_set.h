/* Several logs on one command line: repeats of a run, or other motions of the same machine. */
#ifndef HEXID_LOG_SET_H
#define HEXID_LOG_SET_H

#include "params.h"
#include "status.h"

/* Is the log at `path[log]` none of those before it? The same data twice would count twice. -2: the
 * same file, or a copy of it. */
int log_set_new(int log, const char *const *path, struct error *error);

/* Are both logs of machines that are configured alike, as far as method C's model goes? -2 with the
 * first key that differs, and the remedy. */
int log_set_same_machine(const char *path, const struct params *params, const char *before, const struct params *params_before,
                         struct error *error);

#endif
