/* The time stamps of a CSV file's rows: the even grid that they lie on, and each row's place on it.
 * The step is that of most rows; what stamps are off the grid by, up to 0.4 of a step, is jitter;
 * places without a row are lost; the grid follows a clock that wanders. Private to src/io. */
#ifndef HEXID_CSV_TIMES_H
#define HEXID_CSV_TIMES_H

#include <stdint.h>

#include "status.h"

/* Begins as zero. */
struct csv_times {
    int64_t rows, capacity;
    double *t_s;     /* as the file has them, increasing */
    int64_t *place;  /* on the grid, increasing; after csv_times_measure() */
    double step_s;   /* of the grid; 0: fewer than two rows */
    double mean_s;   /* of all steps, holes among them */
};

/* The next row, later than the one before. -3 without memory. */
int csv_times_add(struct csv_times *times, double t_s, struct error *error);

/* After the last row: step and places. stated_s: the step that the file states, NaN if none; of
 * that and of most rows' it is taken where it has less than half as many rows that are not in the
 * place behind their predecessor's, for stamps of 800 Hz in whole milliseconds look like 1000 Hz
 * with rows lost. -3 without memory. */
int csv_times_measure(struct csv_times *times, double stated_s, struct error *error);

/* Places from the first row to the last, and how many of them have no row. */
int64_t csv_times_places(const struct csv_times *times);
int64_t csv_times_lost(const struct csv_times *times);

void csv_times_free(struct csv_times *times);

#endif
