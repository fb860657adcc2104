/* Integrates a speed to a position. Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_SPEED_H
#define HEXID_CSV_SPEED_H

#include "csv_series.h"
#include "csv_table.h"

/* Integrates a speed in place, by trapezoids. The zero error of a speed sensor would make the
 * position run away, so it is measured and subtracted. It is the mean where the axis rests, in
 * pieces of half a second in which the speed stays within its noise. Without a rest it is the mean
 * speed under a window that falls to zero at both ends, which is right for a motion that returns to
 * its beginning. The middle of the position's range becomes middle_m. The notes report the zero,
 * and how far the speed's noise alone makes the position wander. */
void csv_speed_integrate(struct csv_series *series, double middle_m, char notes[CSV_NOTES_SIZE]);

#endif
