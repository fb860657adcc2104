/* Finds the start of a test's ramp-in in a file whose clock started elsewhere. Private to
 * src/io/csv_*.c. */
#ifndef HEXID_CSV_BEGIN_H
#define HEXID_CSV_BEGIN_H

#include "csv_reader.h"

/* Finds the t_s of the file that is t = 0 from its segments (segments.h). The transition between
 * rest and steady motion has the same centre as the ramp-in, because its smooth ends are
 * detected late and early by the same amount. Without steady motion: the end of the first rest
 * that motion follows. Without a rest: the first row, or, if that is too early, ramp_s before
 * the steady motion. Steady from the first row on: the ramp-in was cut off, and t_s is taken as
 * right (0) if that row lies within the stated evaluated part. Heap. Returns -2 or -3 on
 * failure. */
int csv_begin_find(const struct csv_head *head, struct csv_map *map, const struct params *params, double *zero_s, struct error *error);

#endif
