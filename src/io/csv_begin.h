/* Finds the start of a test's ramp-in in a file whose clock started elsewhere. Private to
 * src/io/csv_*.c. */
#ifndef HEXID_CSV_BEGIN_H
#define HEXID_CSV_BEGIN_H

#include "csv_table.h"

/* Finds which t_s of the file is t = 0, from its segments (segments.h):
 *
 *   rest, then steady motion   t = 0 is ramp_s / 2 before the middle between the end of the rest
 *                              and the start of the steady motion. As the ramp is smooth, the rest
 *                              seems to end too late and the steady motion to begin too early, by
 *                              the same time, which cancels out.
 *   no steady motion           t = 0 is the end of the first rest that motion follows; without a
 *                              rest it is the first row.
 *   no rest                    t = 0 is ramp_s before the steady motion, but not before the
 *                              first row.
 *   steady from the first row  The ramp-in was cut off. t_s is taken as right (0) if the first row
 *                              lies between 0 and the end of the stated evaluated part; otherwise
 *                              t = 0 is ramp_s before the steady motion.
 *
 * Heap. Returns -2 or -3 on failure. */
int csv_begin_find(const struct csv_head *head, const struct csv_table *table, struct csv_map *map, const struct params *params,
                   double *zero_s, struct error *error);

#endif
