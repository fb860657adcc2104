/* What import and export agree on: the keys of a CSV file's head and its columns. Private
 * to src/io/csv_*.c. */
#ifndef HEXID_CSV_FORMAT_H
#define HEXID_CSV_FORMAT_H

#include <dirent.h>
#include <stddef.h>

#include "params.h"

enum { CSV_T = 0, CSV_FLAGS_COLUMN = 31, CSV_PHASE_COLUMN = 32, CSV_POSITION_COLUMN = 33, CSV_COLUMNS = 39 };

/* Of six legs, the first's; then of an axis: its force, and the pressures behind it. */
enum {
    CSV_LENGTH_1_COLUMN = 7,
    CSV_P1_1_COLUMN = 13,
    CSV_P2_1_COLUMN = 19,
    CSV_FORCE_COLUMN = CSV_POSITION_COLUMN + 2,
    CSV_P1_COLUMN,
    CSV_P2_COLUMN
};

enum csv_kind { CSV_REAL, CSV_FLAGS, CSV_PHASE };

struct csv_column {
    const char *name;
    enum csv_kind kind;
    size_t offset; /* in struct cycle */
};

extern const struct csv_column csv_columns[CSV_COLUMNS];

/* Time, flags and phase belong to every mechanism. */
bool csv_column_of(int column, enum mechanism_kind mechanism);

/* The column of this name, -1: none. The name's unit may be another than SI's, after _ or in
 * brackets ("p1_3_bar", "t [ms]"): unit is then what its values are multiplied by. */
int csv_column_find(const char *name, double *unit);

/* The column of this name in SI units, or of this name without its unit ("position",
 * "p1_3"); -1: none. */
int csv_column_named(const char *name);

/* Is this a unit of the column's values? What they are multiplied by. */
bool csv_unit_find(const char *unit, int column, double *factor);

/* The unit at a foreign name's end, "Weg [mm]" or "Weg_mm": what a column's values are multiplied
 * by; 1 where there is none. */
double csv_unit_of(const char *name, int column);

/* "m, cm, mm, um": what csv_unit_find() takes. */
enum { CSV_UNITS_SIZE = 80 };
void csv_units_list(int column, char words[CSV_UNITS_SIZE]);

/* Keys with a number, besides dof. */
enum csv_key { CSV_FREQUENCY, CSV_AMPLITUDE, CSV_RATE, CSV_SETTLE, CSV_RAMP, CSV_DURATION, CSV_RAMP_OUT, CSV_KEYS };

extern const char *const csv_keys[CSV_KEYS];

/* Where the configuration keeps a key's value; NULL for the rate, which it keeps as a period.
 * Frequency and amplitude are the axis's own; there must be one. */
double *csv_place(struct params *params, enum csv_key key, enum dof dof);

/* "x" ... "psi", "none". */
const char *csv_dof_name(enum dof dof);

/* False when it is no such name. */
bool csv_dof_find(const char *name, enum dof *dof);

/* The CSV files of a directory in the order of the numbers in their names; -1 and errno when
 * it cannot be read. */
int csv_list(const char *directory, struct dirent ***files);
void csv_list_free(struct dirent **files, int count);

#endif
