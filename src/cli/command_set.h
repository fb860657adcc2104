/* `hexid command set [KEY=VALUE]`: asks a daemon for its gains, or changes one of them while it
 * runs. SAFETY: the client computes the closed loop with the new gains, in every pose where the
 * platform may be held, and sends no gains that make it unstable; gains that do not worsen a loop
 * which is already unstable pass with a warning. The daemon checks that client and daemon have the
 * same machine, and by how much the gains change. Main thread. */
#ifndef HEXID_COMMAND_SET_H
#define HEXID_COMMAND_SET_H

#include "command_report.h"

struct params;

/* Returns 0 if the setting changes a gain, or is NULL, which only asks; -2 otherwise. */
int command_set_check(const char *setting, struct error *error);

/* params: the client's configuration, which must be the daemon's except for the gains. setting:
 * "control.kp=45"; NULL: only asks. Returns STATUS_OK; STATUS_UNSAFE if the daemon or the check of
 * the loop refuses the gains; -2 or -3. */
int command_set(struct command_client *c, const struct params *params, const char *setting, struct error *error);

#endif
