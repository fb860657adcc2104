/* A channel on its own clock: times and values, in the order of time. Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_SERIES_H
#define HEXID_CSV_SERIES_H

#include <stdbool.h>
#include <stdint.h>

/* Longest step across which values are interpolated, in multiples of the usual step; a longer step
 * is a hole. */
static const double CSV_HOLE = 2.5;

/* Samples of a channel; initialised to zero. */
struct csv_series {
    int64_t count, capacity;
    double *t_s, *value;
};

/* Appends a sample. Returns false without memory. */
bool csv_series_add(struct csv_series *series, double t_s, double value);

/* Returns the number of samples a second, over the steps that are shorter than twice the mean step;
 * 0 for fewer than two samples. */
double csv_series_rate(const struct csv_series *series);

/* Returns the value at t_s, by a cubic through four samples if their steps are even and none is a
 * hole, else along a straight line. at: index of the last sample that is not later than t_s; 0
 * if all are later. hole_s: longest step that is no hole. Returns NaN in a hole and beyond the
 * ends. */
double csv_series_at(const struct csv_series *series, int64_t at, double t_s, double hole_s);

void csv_series_free(struct csv_series *series);

#endif
