/* A directory of logs, named by the run's number and its start in UTC. A run has one file,
 * 000017_2026-11-23T14-05-00Z.lcm, or several parts, each a complete log,
 * 000017_2026-11-23T14-05-00Z.0001.lcm and so on. The number is one more than the largest in the
 * directory, so it gives the order of the runs even if the clock is reset. Names without a number,
 * from earlier versions, count as older than all others, in the order of their modification times.
 *
 * Only files with such names are ever deleted, the oldest first, and no part of a run in
 * progress: a writer locks its current file (output.h, log_keeper.h), and the lock ends with its
 * process. Not for threads that must not wait: a full directory takes time to delete. */
#ifndef HEXID_LOG_DIRECTORY_H
#define HEXID_LOG_DIRECTORY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "status.h"

enum { LOG_PARTS_MAX = 9999 };

/* Deletes the oldest logs until the rest take at most quota_bytes, but neither the newest one nor a
 * run that is being written. Continues after a failed deletion and returns STATUS_IO naming the
 * last such file. *left_bytes (may be NULL): size of the remaining logs. */
int log_directory_prune(const char *directory, int64_t quota_bytes, int64_t *left_bytes, struct error *error);

/* Creates an empty file named by the next number and the current time: the whole log or its first
 * part. Returns -3 if that is impossible. */
int log_directory_create(const char *directory, bool in_parts, char *path, size_t size, struct error *error);

/* Makes the path of another part; creates nothing. Returns -3 if there are too many parts. */
int log_directory_part(const char *first, int number, char *path, size_t size, struct error *error);

#endif
