/* Checks that values are plausible for the columns' names. Millimetres under l1_m, bar under
 * p1_1_pa, degrees under ref_phi_rad or percent under u1 are reported with the probable unit.
 * Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_DOUBTS_H
#define HEXID_CSV_DOUBTS_H

#include "csv.h"
#include "csv_reader.h"

/* Least and greatest value of each column, and moments of a single axis's force and pressures;
 * initialised to zero. */
struct csv_range {
    bool begun;
    double low[CSV_COLUMNS], high[CSV_COLUMNS];
    double beside, sum[3], product[3][3]; /* number, sums and sums of products of the rows that have
                                           * force, p1 and p2 */
};

void csv_range_take(struct csv_range *range, const struct cycle *cycle);

/* Writes "1_x.csv and 5 more: p1_3_pa is up to 82, in bar?", once for each kind of channel over all
 * files of a recording, with the unit under which all implausible values fit the configured machine
 * best (supply, lengths, amplitudes). If no unit fits, the text says what values are possible
 * instead. Then names each file whose force contradicts its pressures. Writes "" if all values are
 * plausible. */
void csv_doubts(int files, const struct csv_head *head, const struct csv_range *range, const struct params *params,
                char list[CSV_DOUBTS_SIZE]);

/* Returns "t_s looks like milliseconds" and the remedy, if the steps differ from the stated one by
 * a factor of 1000 or a million; else NULL. stated_s NaN: no step is stated, so the steps are
 * compared with those that a loop can have. */
const char *csv_time_unit(double step_s, double stated_s);

#endif
