/* Proposes a --map for a file whose columns have names of their own. Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_PROPOSE_H
#define HEXID_CSV_PROPOSE_H

#include "csv_reader.h"

enum { CSV_PROPOSED_SIZE = 480 };

/* Writes "--map 't=Time [s],position=Stroke:?'" for the columns of an axis that the file lacks
 * under hexid's names, chosen by the words and units in its names. ? stands for an unknown unit.
 * Writes "" if no name is like those that people give to position, force or pressure, or if the
 * file has columns of a platform. */
void csv_propose(const struct csv_reader *reader, char text[CSV_PROPOSED_SIZE]);

#endif
