/* Where a test's ramp-in begins on a clock that began elsewhere. Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_BEGIN_H
#define HEXID_CSV_BEGIN_H

#include "csv_reader.h"

/* The file's t_s that is t = 0, by its pieces (pieces.h). What lies between rest and steady motion
 * has its middle where the ramp-in has its own: the ends of both are smooth and seen too late and
 * too soon. Without steady motion: the end of the first rest that motion follows. Without a rest:
 * the first row, or where that is too early ramp_s before the steady motion. Steady from the first
 * row on: the ramp-in was cut off, and t_s may be right, 0, if that row is within the stated
 * evaluated part. Heap. -2 or -3. */
int csv_begin_find(const struct csv_head *head, struct csv_map *map, const struct params *params, double *zero_s, struct error *error);

#endif
