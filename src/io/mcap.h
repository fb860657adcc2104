/* Writer of MCAP files (mcap.dev/spec, version 0), as Foxglove, PlotJuggler and the library `mcap`
 * of PyPI read them: schemas and channels, messages in chunks of about 1 MiB that are compressed
 * with zstd and have an index of messages, then a summary with schemas, channels, statistics and an
 * index of chunks; checksums of each chunk, of the data and of the summary. Ordinary threads.
 *
 * Memory: two chunks, and 16 bytes a message of the chunk under way; what the summary holds grows
 * by about 100 bytes a chunk. */
#ifndef HEXID_MCAP_H
#define HEXID_MCAP_H

#include <stddef.h>
#include <stdint.h>

#include "status.h"

struct mcap_writer;

enum { MCAP_CHANNELS_MAX = 16 };

/* Creates a file; one that exists is never overwritten. -3 with path and reason. */
int mcap_create(struct mcap_writer **writer, const char *path, struct error *error);

/* Adds a topic of JSON messages with this JSON schema, at any time before its first message.
 * Returns its channel, from 0; at most MCAP_CHANNELS_MAX. */
int mcap_channel(struct mcap_writer *w, const char *topic, const char *schema_name, const char *schema);

/* time_ns: since 1970, in any order; readers are quickest when it never runs back. What fails is
 * kept for mcap_failure(). */
void mcap_message(struct mcap_writer *w, int channel, uint64_t time_ns, const void *data, size_t size);

/* The first failure, an errno, after which nothing more is written; 0: none. */
int mcap_failure(const struct mcap_writer *w);

/* Finishes the file and frees the writer. failure: an errno of the caller's that makes the file
 * incomplete; 0: none. -3 with path and reason for that, or when any write failed; the file is then
 * removed. */
int mcap_close(struct mcap_writer *w, int failure, struct error *error);

#endif
