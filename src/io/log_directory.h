/* A directory of logs, named by the number of the run in it and its start in UTC: one file a run,
 * 000017_2026-11-23T14-05-00Z.lcm, or parts of it, each a log by itself,
 * 000017_2026-11-23T14-05-00Z.0001.lcm and so on. The number is one more than the largest there: it
 * is the order of the runs, which no clock that is set can turn round. Names without it, of earlier
 * versions, are older than all others, in the order in which they were written.
 *
 * Only files named so are ever deleted, the oldest first, and no part of a run that is in progress:
 * a writer holds a lock on the file that it is at (output.h, log_keeper.h), which ends with its
 * process. Not where anybody waits, for a full directory takes time to go. */
#ifndef HEXID_LOG_DIRECTORY_H
#define HEXID_LOG_DIRECTORY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "status.h"

enum { LOG_PARTS_MAX = 9999 };

/* Deletes the oldest logs until the rest takes at most so many bytes; the newest that is left stays
 * whatever it takes. What cannot be deleted stays, too: STATUS_IO, naming it, after all others were
 * tried. *left_bytes, where it is not NULL: what the rest takes. */
int log_directory_prune(const char *directory, int64_t quota_bytes, int64_t *left_bytes, struct error *error);

/* A new empty file in it, named by the next number and the time now, the whole log or its first
 * part. -3: none can be made. */
int log_directory_create(const char *directory, bool in_parts, char *path, size_t size, struct error *error);

/* The path of another part. -3: there are too many. Nothing is made. */
int log_directory_part(const char *first, int number, char *path, size_t size, struct error *error);

#endif
