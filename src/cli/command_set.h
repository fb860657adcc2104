/* `hexid command set [KEY=VALUE]`: asks a daemon for its gains, or changes one of them while it
 * runs. SAFETY: the client computes the closed loop with the new gains, in every pose where the
 * platform may be held, and does not send gains that make it unstable; if the loop is unstable
 * already, gains that do not worsen it are sent with a warning. The daemon checks that client and
 * daemon have the same configuration, and the size of the change. Main thread. */
#ifndef HEXID_COMMAND_SET_H
#define HEXID_COMMAND_SET_H

#include "command_report.h"

struct params;

/* Returns 0 if the setting changes a gain, or is NULL (ask for the gains only); -2 otherwise. */
int command_set_check(const char *setting, struct error *error);

/* params: the client's configuration, which must be the daemon's except for the gains. setting:
 * "control.kp=45"; NULL: asks for the gains only. Returns STATUS_OK; STATUS_UNSAFE if the daemon or
 * the check of the loop refuses the gains; -2 or -3. */
int command_set(struct command_client *c, const struct params *params, const char *setting, struct error *error);

#endif
