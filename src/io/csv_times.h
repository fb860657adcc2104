/* Maps the time stamps of a CSV file's rows to an even grid, whose step is that of most rows. The
 * next grid point after the previous row's belongs to the row if it is less than 0.75 of a step
 * away; otherwise the row gets the nearest point. The grid follows a drifting clock. Points without
 * a row are lost rows. Private to src/io. */
#ifndef HEXID_CSV_TIMES_H
#define HEXID_CSV_TIMES_H

#include <stdint.h>

#include "status.h"

/* Times of a file's rows; initialised to zero. */
struct csv_times {
    int64_t rows, capacity;
    double *t_s;     /* times as in the file, increasing */
    int64_t *place; /* place of each row on the grid, increasing; valid after csv_times_measure() */
    double step_s;   /* step of the grid; 0: fewer than two rows */
    double mean_s;   /* mean of all steps, gaps included */
};

/* Adds the next row, which must be later than the last. Returns -3 without memory. */
int csv_times_add(struct csv_times *times, double t_s, struct error *error);

/* Computes step and places; to be called after the last row. stated_s: the step that the file
 * states, NaN if it states none. The stated step is used instead of the step of most rows if that
 * more than halves the number of rows that do not directly follow their predecessor: stamps of 800
 * Hz in whole milliseconds look like 1000 Hz with lost rows. Returns -3 without memory. */
int csv_times_measure(struct csv_times *times, double stated_s, struct error *error);

/* Return the number of grid points from the first row to the last, and the number of those without
 * a row. */
int64_t csv_times_places(const struct csv_times *times);
int64_t csv_times_lost(const struct csv_times *times);

void csv_times_free(struct csv_times *times);

#endif
