/* Reads the numbers of an MCAP file into CSV text. Private to src/io/csv_*.c.
 *
 * A file of hexid's own (`hexid export --format mcap`) becomes its tests. In any other file every
 * topic of JSON messages becomes columns "topic.field" ("/axis.state.position", "/joint.effort.2"),
 * with a row for each message and the time at which it was logged in the column "log_time_s", in
 * the order of time. An array gives its first 64 numbers. A file without a topic of JSON is
 * refused, with the encodings that it has and the remedy. Chunks may be plain or compressed with
 * zstd. If there are more columns than a CSV text can have, only columns with a name in --map or
 * one of hexid's own are taken; without names in --map the file is refused. */
#ifndef HEXID_CSV_MCAP_H
#define HEXID_CSV_MCAP_H

#include "csv_foreign.h"

/* Returns -2 for a file that cannot be used, -3 for one that cannot be read. */
int csv_mcap_read(const char *path, const struct csv_map *map, struct csv_texts *texts, struct error *error);

#endif
