/* Several logs on one command line: repeated runs, or different motions of one machine. */
#ifndef HEXID_LOG_SET_H
#define HEXID_LOG_SET_H

#include "status.h"

struct params;

/* Checks that the log at `path[log]` differs from all before it, because the same data would count
 * twice. Returns -2 for the same file, or a copy of it. */
int log_set_new(int log, const char *const *path, struct error *error);

/* Checks that two logs' configurations are equal as far as method C's model is concerned. Returns
 * -2 with the first key that differs, and the remedy. */
int log_set_same_machine(const char *path, const struct params *params, const char *before, const struct params *params_before,
                         struct error *error);

#endif
