/* Loads logs into the recording that hexid gap evaluates. */
#ifndef HEXID_GAP_LOGS_H
#define HEXID_GAP_LOGS_H

#include "recording.h"

enum { GAP_LEFT_OUT_SIZE = 200 };

/* Adds all logs of one machine, each a run, to a recording that recording_init() has begun, and
 * checks it. left_out: "y, phi", tests of which no sample is in the ramp-in or the evaluated part.
 * Negative with the log's name and what is wrong with it. */
int gap_logs_load(int logs, const char *const *path, struct recording *r, char left_out[GAP_LEFT_OUT_SIZE], struct error *error);

#endif
