/* Finds where the table of a CSV file begins: separator, line of names, line of units, first row.
 * Instruments write lines of their own before it. Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_LAYOUT_H
#define HEXID_CSV_LAYOUT_H

#include "csv_map.h"
#include "csv_text.h"

enum { CSV_CELLS_MAX = 512 };

struct csv_layout {
    char separator;  /* ',', ';', tab, or ' ' for any number of blanks; 0: none was found */
    char names_separator; /* separator of the names: that of the numbers, or CSV_WIDE */
    bool rising[CSV_CELLS_MAX]; /* columns whose numbers rise from row to row */
    int names_line;  /* line of the columns' names; 0: there is none */
    int units_line;  /* line of units after the names; 0: there is none */
    int data_line;   /* line of the first row; 0: none was found */
    long data_at;    /* offset of the first row in the file */
    int cells;       /* number of cells in the first or second row, whichever has more */
    int skipped;     /* number of lines of text before the names */
};

/* Finds the parts of the table. The names are the first line that names the time, as hexid or the
 * map does; else the last line of text, or comment, with as many cells as the first two rows of
 * numbers. Looks at the first 200 lines and leaves the file at its beginning. Returns -3 without
 * memory. */
int csv_layout_find(struct csv_layout *layout, struct csv_text *text, const struct csv_map *map, struct error *error);

#endif
