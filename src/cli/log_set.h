/* Checks of several logs on one command line: repeated runs, or different motions of one
 * machine. */
#ifndef HEXID_LOG_SET_H
#define HEXID_LOG_SET_H

#include "status.h"

struct params;

/* Checks that the log path[log] differs from path[0] to path[log - 1], because the same data would
 * count twice. Returns -2 if it is one of these files or a copy of one. */
int log_set_new(int log, const char *const *path, struct error *error);

/* Checks that two logs' configurations are equal as far as method C's model is concerned. Returns
 * -2 with the first key that differs and the remedy. */
int log_set_same_machine(const char *path, const struct params *params, const char *before, const struct params *params_before,
                         struct error *error);

#endif
