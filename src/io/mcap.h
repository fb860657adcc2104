/* Writes MCAP files (mcap.dev/spec, version 0) that Foxglove, PlotJuggler and PyPI's `mcap` read:
 * schemas and channels; messages in chunks of about 1 MiB, compressed with zstd, with message
 * indexes; a summary with schemas, channels, statistics and an index of chunks; checksums of
 * chunks, data and summary. Ordinary threads.
 *
 * Memory: two chunks, and 16 bytes for each message of the current chunk; the summary grows by
 * about 100 bytes a chunk. */
#ifndef HEXID_MCAP_H
#define HEXID_MCAP_H

#include <stddef.h>
#include <stdint.h>

#include "status.h"

struct mcap_writer;

enum { MCAP_CHANNELS_MAX = 16 };

/* Creates a file; never overwrites one. Returns -3 with path and reason, or -2 if the path is no
 * file in a directory ("-"). */
int mcap_create(struct mcap_writer **writer, const char *path, struct error *error);

/* Adds a topic of JSON messages with this JSON schema; to be called before the topic's first
 * message. Returns its channel, from 0; at most MCAP_CHANNELS_MAX. */
int mcap_channel(struct mcap_writer *w, const char *topic, const char *schema_name, const char *schema);

/* Appends a message. time_ns: since 1970, in any order; readers are fastest if it never
 * decreases. mcap_failure() reports failures. */
void mcap_message(struct mcap_writer *w, int channel, uint64_t time_ns, const void *data, size_t size);

/* Returns the first failure as an errno, after which nothing is written; 0: none. */
int mcap_failure(const struct mcap_writer *w);

/* Finishes the file and frees the writer. failure: errno of a failure of the caller's that makes
 * the file incomplete; 0: none. After such a failure, or one of writing, removes the file and
 * returns -3 with path and reason. */
int mcap_close(struct mcap_writer *w, int failure, struct error *error);

#endif
