/* `hexid command set [KEY=VALUE]`: asks a daemon for its gains, or changes one of them while it
 * runs. SAFETY: the client computes the poles of the closed loop with the new gains, in every pose
 * where the platform may be held, and asks for them only if the loop is stable; the daemon checks
 * that client and daemon have the same machine, and by how much the gains change. Main thread. */
#ifndef HEXID_COMMAND_SET_H
#define HEXID_COMMAND_SET_H

#include "command_report.h"

struct params;

/* Returns 0, or -2 for a setting that is not of a gain; NULL asks, and is right. */
int command_set_check(const char *setting, struct error *error);

/* params: the client's configuration, which must be the daemon's. setting: "control.kp=45"; NULL:
 * only asks. Returns STATUS_OK; STATUS_UNSAFE if it is refused by the daemon or because the loop
 * would be unstable; -2 or -3. */
int command_set(struct command_client *c, const struct params *params, const char *setting, struct error *error);

#endif
