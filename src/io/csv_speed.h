/* Integrates a speed to a position. Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_SPEED_H
#define HEXID_CSV_SPEED_H

#include "csv_series.h"
#include "csv_table.h"

/* Integrates a speed in place, by trapezoids. The zero error of the speed sensor would make the
 * position drift, so it is estimated and subtracted: as the mean speed at rest, over intervals of
 * half a second in which the speed stays within its noise; without a rest, as the mean speed under
 * a Hann window, which is right for a motion that returns to its beginning. The middle of the
 * position's range becomes middle_m. The notes report the zero error and, if there was a rest, the
 * drift that the speed's noise alone causes. */
void csv_speed_integrate(struct csv_series *series, double middle_m, char notes[CSV_NOTES_SIZE]);

#endif
