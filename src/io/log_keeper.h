/* The next file of a log that is in parts. A process of its own makes it, and keeps the directory
 * within its quota: opening and deleting take time, and the confined daemon may do neither
 * (confine.h). Who records asks and goes on; the file comes as a descriptor when it is there. The
 * process knows one directory and one name, takes nothing but the question, and ends when the other
 * end is closed. Ordinary threads. */
#ifndef HEXID_LOG_KEEPER_H
#define HEXID_LOG_KEEPER_H

#include <limits.h>
#include <stdbool.h>
#include <stdint.h>

#include "status.h"

struct log_keeper {
    int socket;
    bool asked;           /* and no answer yet */
};

struct log_part {
    int file;             /* to write, empty, locked as log_directory.h wants it */
    char path[PATH_MAX];
    bool over;            /* the directory takes more than its quota, and all that is left belongs
                           * to runs in progress, or is the newest */
};

/* first: the first part, of log_directory_create(). quota_bytes 0: none. Before confine(). Either
 * waits for the process, for seconds at most. */
int log_keeper_start(struct log_keeper *k, const char *first, int64_t quota_bytes, struct error *error);
void log_keeper_stop(struct log_keeper *k);

/* Asks for the next part, once. Never waits. */
void log_keeper_ask(struct log_keeper *k);

/* 1: it has come. 0: not yet, after at most so long. -3: there will be none, and why; it can be
 * asked for again. */
int log_keeper_take(struct log_keeper *k, int wait_ms, struct log_part *part, struct error *error);

#endif
