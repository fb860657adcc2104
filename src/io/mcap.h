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

/* A new file. -3 with path and reason when it cannot be made; one that is there is left alone. */
int mcap_create(struct mcap_writer **writer, const char *path, struct error *error);

/* A topic whose messages are JSON of this JSON schema; at any time before its first message.
 * Returns the channel, from 0; at most MCAP_CHANNELS_MAX. */
int mcap_channel(struct mcap_writer *w, const char *topic, const char *schema_name, const char *schema);

/* time_ns: since 1970, not negative; in any order, but readers are quickest when it
 * does not run back. */
void mcap_message(struct mcap_writer *w, int channel, uint64_t time_ns, const void *data, size_t size);

/* Why nothing more can be written, an errno; 0: it can. What failed before stays failed. */
int mcap_failure(const struct mcap_writer *w);

/* Ends the file and frees. failure: an errno of the caller's, for which the file is not whole; 0:
 * none. -3 with path and reason when there is one, or anything could not be written, now or before;
 * the file is gone then. */
int mcap_close(struct mcap_writer *w, int failure, struct error *error);

#endif
