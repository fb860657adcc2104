/* Makes the next file of a log that is written in parts. A separate process creates it and keeps
 * the directory within its quota, because opening and deleting files take time and the confined
 * daemon may do neither (confine.h). The recorder sends a request and goes on; later it receives a
 * descriptor of the new file. The process is limited to one directory and one name, accepts only
 * that request, and ends when its socket is closed. Ordinary threads. */
#ifndef HEXID_LOG_KEEPER_H
#define HEXID_LOG_KEEPER_H

#include <limits.h>
#include <stdbool.h>
#include <stdint.h>

#include "status.h"

struct log_keeper {
    int socket;
    bool asked;           /* a request has not been answered yet */
    bool gone;            /* the process has ended, so that no more parts will come */
};

struct log_part {
    int file;             /* descriptor of the part: empty, open for writing, locked as described in
                           * log_directory.h */
    char path[PATH_MAX];
    bool over;            /* the directory exceeds its quota: each remaining file is the newest,
                           * belongs to a run in progress or cannot be deleted */
};

/* Starts the process. first: path of the first part, from log_directory_create(). quota_bytes 0: no
 * quota. To be called before confine(). Starting and stopping wait for the process, for seconds at
 * most. Returns -3 with the reason on an error. */
int log_keeper_start(struct log_keeper *k, const char *first, int64_t quota_bytes, struct error *error);
void log_keeper_stop(struct log_keeper *k);

/* Requests the next part; does nothing if a request is unanswered. Never waits. */
void log_keeper_ask(struct log_keeper *k);

/* Takes the part that was requested. Returns 1: the part is there; 0: not yet, after at most
 * wait_ms, or nothing was requested; -3 with the reason: the request failed, and another may follow
 * unless k->gone is set. */
int log_keeper_take(struct log_keeper *k, int wait_ms, struct log_part *part, struct error *error);

#endif
