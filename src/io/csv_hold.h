/* Detects a channel that is repeated: the file has a row for each value of one device, and the last
 * value of a slower device is written again in each row (zero-order hold).
 *
 * A sensor of coarse resolution repeats values, too, while the signal moves by less than one step
 * of the resolution per row. But such a reading then changes by at most about one step for each row
 * that has passed. So only changes larger than that count, and only if the change before was larger
 * than that, too. If the gap between two such changes is several rows, and nearly always the same
 * number of rows, the channel is repeated. The sensor's step is the smallest change, if nearly all
 * other changes are multiples of it. */
#ifndef HEXID_CSV_HOLD_H
#define HEXID_CSV_HOLD_H

#include <stdbool.h>
#include <stdint.h>

enum { CSV_CHANGES = 8192, CSV_GAPS = 512 };

/* State of the detection; initialised to zero. */
struct csv_hold {
    int64_t rows, changed_at;
    double last;
    int changes;                /* number of changes kept; only the first CSV_CHANGES are */
    double change[CSV_CHANGES]; /* sizes of the changes, and numbers of rows since the change before
                                 * each */
    int gap[CSV_CHANGES];
};

/* Takes the channel's next value. The caller leaves out values that are no number. */
void csv_hold_take(struct csv_hold *hold, double value);

/* Returns the mean number of rows for which a value is repeated; 1 if the channel is not
 * repeated. */
double csv_hold_rows(const struct csv_hold *hold);

#endif
