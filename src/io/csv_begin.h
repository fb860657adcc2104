/* Where a test's ramp-in begins on a clock that began elsewhere. Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_BEGIN_H
#define HEXID_CSV_BEGIN_H

#include "csv_reader.h"

/* The file's t_s that is t = 0: its first row, or ramp_s before the steady motion (pieces.h)
 * where that is off by more than a cycle. 0, as the file has it, where the motion is steady from
 * a first row within the stated evaluated part on: the ramp-in was cut off. Heap. -2 or -3. */
int csv_begin_find(const struct csv_head *head, struct csv_map *map, const struct params *params, double *zero_s, struct error *error);

#endif
