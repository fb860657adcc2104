/* Makes the next file of a log that is written in parts. A separate process creates it and keeps
 * the directory within its quota, because opening and deleting files take time and the confined
 * daemon may do neither (confine.h). The recorder asks and goes on; the file comes as a descriptor
 * once it is there. The process knows one directory and one name, takes nothing but that request,
 * and ends when the other end is closed. Ordinary threads. */
#ifndef HEXID_LOG_KEEPER_H
#define HEXID_LOG_KEEPER_H

#include <limits.h>
#include <stdbool.h>
#include <stdint.h>

#include "status.h"

struct log_keeper {
    int socket;
    bool asked;           /* a request is without its answer */
    bool gone;            /* the process has ended: no part comes any more */
};

struct log_part {
    int file;             /* to write, empty, locked as log_directory.h wants it */
    char path[PATH_MAX];
    bool over;            /* the directory is over its quota, though every file left belongs to a
                           * run in progress or is the newest */
};

/* first: path of the first part, from log_directory_create(). quota_bytes 0: none. To be called
 * before confine(). Both wait for the process, for seconds at most. -3 with the reason. */
int log_keeper_start(struct log_keeper *k, const char *first, int64_t quota_bytes, struct error *error);
void log_keeper_stop(struct log_keeper *k);

/* Asks for the next part; does nothing while an answer is due. Never waits. */
void log_keeper_ask(struct log_keeper *k);

/* 1: the part has come. 0: not yet, after at most wait_ms, or nothing was asked. -3: there will be
 * none, with the reason; it may be asked for again. */
int log_keeper_take(struct log_keeper *k, int wait_ms, struct log_part *part, struct error *error);

#endif
