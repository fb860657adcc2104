/* Proposes a --map for a file whose columns have names of their own. Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_PROPOSE_H
#define HEXID_CSV_PROPOSE_H

#include "csv_reader.h"

enum { CSV_PROPOSED_SIZE = 480 };

/* Writes "--map 't=Time [s],position=Stroke:?'" for the columns of an axis that the file lacks
 * under hexid's names, chosen by the words and units in the file's names, then the names of its
 * unknown columns. ? stands for an unknown unit, or for a needed column that was not found. Writes
 * "" if the file has columns of a platform, or if the map has more than 240 bytes. */
void csv_propose(const struct csv_reader *reader, char text[CSV_PROPOSED_SIZE]);

#endif
