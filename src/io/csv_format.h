/* Names and units that import and export share: the keys of a CSV file's head, and its columns.
 * Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_FORMAT_H
#define HEXID_CSV_FORMAT_H

#include <dirent.h>
#include <stddef.h>

#include "csv_units.h"
#include "mechanism.h"

enum { CSV_T = 0, CSV_FLAGS_COLUMN = 31, CSV_PHASE_COLUMN = 32, CSV_POSITION_COLUMN = 33, CSV_COLUMNS = 39 };

/* Columns of the first of six legs, then columns of a single axis: force and pressures. */
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
    enum csv_quantity quantity;
    size_t offset; /* offset of the value in struct cycle */
};

extern const struct csv_column csv_columns[CSV_COLUMNS];

/* Returns true if the mechanism has this column; all mechanisms have time, flags and phase. The
 * columns of a mechanism with one leg have no leg number in their names. */
bool csv_column_of(int column, const struct mechanism *mechanism);

/* Finds a column by hexid's own name for it; returns -1 if there is none. The name may end in
 * another unit than SI's, after _ or in brackets ("p1_3_bar", "t [ms]"). */
int csv_column_find(const char *name, struct csv_unit *unit);

/* Finds a column by its name, with the SI unit or without a unit ("position", "p1_3"); returns -1
 * if there is none. */
int csv_column_named(const char *name);

enum csv_named_unit { CSV_UNIT_NONE, CSV_UNIT_FOUND, CSV_UNIT_WRONG };

/* Finds the unit that is part of a foreign name: "Weg [mm]", "Weg (mm)", "Weg / mm", "Weg_mm".
 * Returns CSV_UNIT_WRONG if the name has brackets without a unit that the quantity can have; for a
 * share, or a column without a quantity, it then returns CSV_UNIT_NONE. *unit is SI if none is
 * found. */
enum csv_named_unit csv_unit_of(const char *name, enum csv_quantity quantity, struct csv_unit *unit);

/* Returns the length of a column's name without its unit: 8 for "position_m". */
int csv_stem(int column);

/* Keys of a head that have a number; dof, which has a name, is not among them. */
enum csv_key { CSV_FREQUENCY, CSV_AMPLITUDE, CSV_RATE, CSV_SETTLE, CSV_RAMP, CSV_DURATION, CSV_RAMP_OUT, CSV_KEYS };

extern const char *const csv_keys[CSV_KEYS];

/* Returns the address of a key's value in the configuration; NULL for the rate, which is stored as
 * a period. Frequency and amplitude belong to an axis, so dof must name one. */
double *csv_place(struct params *params, enum csv_key key, enum dof dof);

/* Returns the configuration key of csv_place(): "tests.amplitude_rad"; NULL for the rate. */
const char *csv_config_key(enum csv_key key, enum dof dof);

/* Returns the name of an axis: "x" ... "psi", "none". */
const char *csv_dof_name(enum dof dof);

/* Finds an axis by its name. Returns false for an unknown name. */
bool csv_dof_find(const char *name, enum dof *dof);

/* Lists a directory's files that end in .csv, .tsv, .mat or .mcap, in the order of the numbers in
 * their names. Returns how many there are; -1 and errno if the directory cannot be read. */
int csv_list(const char *directory, struct dirent ***files);
void csv_list_free(struct dirent **files, int count);

#endif
