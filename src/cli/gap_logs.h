/* Logs as the recording that hexid gap stands on. */
#ifndef HEXID_GAP_LOGS_H
#define HEXID_GAP_LOGS_H

#include "recording.h"

/* All logs of one machine, each a run, into a recording that recording_init() has begun; checked.
 * Negative with the log's name and what is wrong with it. */
int gap_logs_load(int logs, const char *const *path, struct recording *r, struct error *error);

#endif
