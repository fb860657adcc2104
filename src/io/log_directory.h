/* A directory of logs, one file a run, named by its start in UTC: 2026-11-23T14-05-00Z.lcm. Only files named so are ever deleted, the
 * oldest first, and none that a run is writing: a writer holds a lock on its log (log_create()), which ends with its process.
 * Before a run only, for a full directory takes time to go. */
#ifndef HEXID_LOG_DIRECTORY_H
#define HEXID_LOG_DIRECTORY_H

#include <stddef.h>
#include <stdint.h>

#include "status.h"

/* Deletes the oldest logs until the rest takes at most so many bytes; the newest that is left stays whatever it takes. What cannot be
 * deleted stays, too: STATUS_IO, naming it, after all others were tried. */
int log_directory_prune(const char *directory, int64_t quota_bytes, struct error *error);

/* A new empty file in it, named by the time now; a second run of the same second gets another letter behind the Z. -3: none can be made. */
int log_directory_create(const char *directory, char *path, size_t size, struct error *error);

#endif
