/* Are the values what their names say? Millimetres under l1_m, bar under p1_1_pa, degrees under
 * ref_phi_rad, percent under u1: what cannot be is named, with the unit that it might be. Private
 * to src/io/csv_*.c. */
#ifndef HEXID_CSV_DOUBTS_H
#define HEXID_CSV_DOUBTS_H

#include "csv_reader.h"

/* Least and greatest value of each column, and an axis's force beside its pressures; begins as
 * zero. */
struct csv_range {
    bool begun;
    double low[CSV_COLUMNS], high[CSV_COLUMNS];
    double beside, sum[3], product[3][3]; /* rows that have force, p1 and p2, and their moments */
};

void csv_range_take(struct csv_range *range, const struct cycle *cycle);

/* "l1_m is up to 1840: mm?", one a kind, and a force that is not that of the pressures; "" without
 * doubt. */
void csv_doubts(const struct csv_head *head, const struct csv_range *range, const struct params *params, char words[CSV_LIST_SIZE]);

/* "t_s looks like milliseconds" and what to do, where the steps are a thousand times what is
 * stated, or a thousandth of it; NaN: nothing is, and no loop has such; else NULL. */
const char *csv_time_unit(double step_s, double stated_s);

#endif
