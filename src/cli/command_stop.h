/* Sends `hexid command stop` and `park` to the named machine, or to all of this host; also over LCM
 * if one does not answer. Main thread. */
#ifndef HEXID_COMMAND_STOP_H
#define HEXID_COMMAND_STOP_H

#include "command_report.h"

/* Sends the command and prints each machine's answer. STATUS_OK: all have obeyed, or have ended
 * with the supply off. STATUS_IO (the worse) or STATUS_UNSAFE: one has not; that was printed, or
 * stands in error. SAFETY: STATUS_IO also if the command may not have reached every machine. */
int command_stop(const struct asked *q, struct error *error);

#endif
