/* Writes the cycles of a file that hexid exported whole (`hexid export --format mat|mcap`) as CSV
 * texts, one for each test, like those of `hexid export -o DIR`. Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_OWN_H
#define HEXID_CSV_OWN_H

#include "csv_foreign.h"
#include "cycle_columns.h"

/* State of the conversion; initialised to zero. */
struct csv_own {
    int test, dof; /* test and its axis in the last row */
    double time_s; /* time of the last row */
    bool axis;     /* the current text is of a single axis */
};

/* Takes the next cycle, its values in the order of cycle_columns, NaN for none. Cycles outside
 * tests are left out. Returns false if the text cannot be written (csv_texts_refuse()). */
bool csv_own_row(struct csv_own *own, struct csv_texts *texts, const double value[CYCLE_COLUMNS]);

/* Returns the index in cycle_columns of a name, or -1. */
int csv_own_column(const char *name);

#endif
