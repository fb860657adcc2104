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
    double beside, sum[3], product[3][3]; /* number of rows with force, p1 and p2, and their
                                           * moments */
};

void csv_range_take(struct csv_range *range, const struct cycle *cycle);

/* "1_x.csv and 5 more: p1_3_pa is up to 82, in bar?", once for each kind of channel over all files
 * of a recording: the unit under which all that is implausible fits the configured machine best
 * (supply, lengths, amplitudes). Where none fits it says what is possible instead. Then forces that
 * contradict their pressures. "" if all is plausible. */
void csv_doubts(int files, const struct csv_head *head, const struct csv_range *range, const struct params *params,
                char list[CSV_DOUBTS_SIZE]);

/* "t_s looks like milliseconds" and the remedy, if the steps differ from the stated one by a
 * factor of 1000 or a million. stated_s NaN: none is stated, so the steps are compared with
 * those that a loop can have. Else NULL. */
const char *csv_time_unit(double step_s, double stated_s);

#endif
