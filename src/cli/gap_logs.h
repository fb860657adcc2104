/* Loads logs into the recording that hexid gap evaluates. */
#ifndef HEXID_GAP_LOGS_H
#define HEXID_GAP_LOGS_H

#include "cli.h"
#include "recording.h"

enum { GAP_LEFT_OUT_SIZE = 200 };

/* For each log, the tests that have no sample in the ramp-in and the evaluated part: "y, phi". */
typedef char gap_left_out[LOGS_MAX][GAP_LEFT_OUT_SIZE];

/* Adds logs of one machine to a recording initialised by recording_init(), each log as a run of it,
 * and checks the recording. log_params.h finds the tests of each log, with the --set of `o`. run:
 * number of the run, if a single log holds several (log_runs.h), else 0. Returns a negative status
 * with the log's name and the reason. */
int gap_logs_load(const struct options *o, int logs, const char *const *path, int run, struct recording *r, gap_left_out left_out,
                  struct error *error);

#endif
