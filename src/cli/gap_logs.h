/* Loads logs into the recording that hexid gap evaluates. */
#ifndef HEXID_GAP_LOGS_H
#define HEXID_GAP_LOGS_H

#include "cli.h"
#include "admit.h"

enum { GAP_LEFT_OUT_SIZE = 200 };

/* For each log, the tests that have no sample in the ramp-in and the evaluated part: "y, phi". */
typedef char gap_left_out[LOGS_MAX][GAP_LEFT_OUT_SIZE];

/* Logs as they were read, and as they were measured and admitted. */
struct gap_logs {
    struct recording raw;
    struct measured_recording measured;
    struct admission admission;
};

/* Starts with no log; params must outlive it. */
void gap_logs_init(struct gap_logs *g, const struct params *params);
void gap_logs_free(struct gap_logs *g);

/* Adds logs of one machine, each as a run of the recording, measures and admits them. log_params.h
 * finds the tests of each log, with the --set of `o`. run: number of the run, if a single log holds
 * several (log_runs.h), else 0. Returns a negative status with the log's name and the reason. */
int gap_logs_load(const struct options *o, int logs, const char *const *path, int run, struct gap_logs *g, gap_left_out left_out,
                  struct error *error);

#endif
