/* One cycle as a row of numbers: all fields of a HEXID_STATE message under their CSV names.
 * Shared by the exports of whole logs (csv --all, mat, mcap); the CSV files of single tests have
 * the columns of csv_format.h. Ordinary threads. */
#ifndef HEXID_CYCLE_COLUMNS_H
#define HEXID_CYCLE_COLUMNS_H

#include <stddef.h>

#include "types.h"

/* Types of a column: double; int64_t or uint64_t; uint32_t; int or enum; bool. */
enum column_kind { COLUMN_REAL, COLUMN_INT64, COLUMN_UINT32, COLUMN_CODE, COLUMN_BOOL };

struct cycle_column {
    const char *name;
    const char *unit;      /* unit of the column; "": it has none */
    enum column_kind kind;
    size_t offset;         /* offset of the value in struct cycle */
};

enum { CYCLE_COLUMNS = 57 };
extern const struct cycle_column cycle_columns[CYCLE_COLUMNS];

static inline bool column_is_real(int column) { return cycle_columns[column].kind == COLUMN_REAL; }

/* Return the value of a column: column_real() if column_is_real() is true for it, column_integer()
 * if not. */
double column_real(const struct cycle *c, int column);
int64_t column_integer(const struct cycle *c, int column);

#endif
