/* Cycles of a file that hexid exported whole (`hexid export --format mat|mcap`) as CSV texts, one a
 * test, as `hexid export -o DIR` writes them. Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_OWN_H
#define HEXID_CSV_OWN_H

#include "csv_foreign.h"
#include "cycle_columns.h"

/* Initialised to zero. */
struct csv_own {
    int test, dof;
    double time_s; /* time of the last row */
    bool axis;
};

/* Takes the next cycle, its values in the order of cycle_columns, NaN for none. Cycles outside
 * tests are left out. Returns false if the text cannot be written (csv_texts_refuse()). */
bool csv_own_row(struct csv_own *own, struct csv_texts *texts, const double value[CYCLE_COLUMNS]);

/* Returns the index in cycle_columns of a name, or -1. */
int csv_own_column(const char *name);

#endif
