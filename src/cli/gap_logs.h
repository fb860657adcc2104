/* Loads logs into the recording that hexid gap evaluates. */
#ifndef HEXID_GAP_LOGS_H
#define HEXID_GAP_LOGS_H

#include "cli.h"
#include "recording.h"

enum { GAP_LEFT_OUT_SIZE = 200 };

/* Tests of each log without any sample in the ramp-in or the evaluated part: "y, phi". */
typedef char gap_left_out[LOGS_MAX][GAP_LEFT_OUT_SIZE];

/* Adds all logs of one machine, each a run, to a recording initialised by recording_init(), and
 * checks it. The tests of each are found by log_params.h, with the --set of `o`. run: number in a
 * single log that holds several (log_runs.h), else 0. Returns a negative status with the log's
 * name and the reason. */
int gap_logs_load(const struct options *o, int logs, const char *const *path, int run, struct recording *r, gap_left_out left_out,
                  struct error *error);

#endif
