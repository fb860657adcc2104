/* Sends stop or park to the named machine, or to all machines of this host; also over LCM if a
 * machine does not answer or may not have been found. Main thread. */
#ifndef HEXID_COMMAND_STOP_H
#define HEXID_COMMAND_STOP_H

#include "command_report.h"

/* Sends the command and prints each machine's answer. STATUS_OK: all have obeyed, or have ended
 * with the supply off. STATUS_UNSAFE: one has refused. STATUS_IO, whatever others answered: one
 * could not be reached or did not answer. If error->status is 0, the reason is already printed.
 * SAFETY: STATUS_IO also if a machine may not have been found. */
int command_stop(const struct asked *q, struct error *error);

#endif
