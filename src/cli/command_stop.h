/* `hexid command stop` and `park`: to the machine that is named, or to all of this host, and over
 * LCM, too, where one did not answer. Main thread. */
#ifndef HEXID_COMMAND_STOP_H
#define HEXID_COMMAND_STOP_H

#include "command_report.h"

/* Tells them and prints what each answered. STATUS_OK: all have obeyed, or have ended with the
 * supply off. STATUS_IO, the worse, and STATUS_UNSAFE: one did not; it has been said, or stands in
 * error. SAFETY: STATUS_IO, too, when there may be a machine that could not be told. */
int command_stop(const struct asked *q, struct error *error);

#endif
