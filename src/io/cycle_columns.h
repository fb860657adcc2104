/* One cycle as a row of numbers: everything that a HEXID_STATE message has, in the names of the CSV
 * files. What all formats of a whole log have in common. Ordinary threads. */
#ifndef HEXID_CYCLE_COLUMNS_H
#define HEXID_CYCLE_COLUMNS_H

#include <stddef.h>

#include "types.h"

/* double; (u)int64_t, uint32_t, int or enum, bool */
enum column_kind { COLUMN_REAL, COLUMN_INT64, COLUMN_UINT32, COLUMN_CODE, COLUMN_BOOL };

struct cycle_column {
    const char *name;
    const char *unit;      /* "" where it has none */
    enum column_kind kind;
    size_t offset;         /* in struct cycle */
};

enum { CYCLE_COLUMNS = 57 };
extern const struct cycle_column cycle_columns[CYCLE_COLUMNS];

static inline bool column_is_real(int column) { return cycle_columns[column].kind == COLUMN_REAL; }

/* The value of a column of reals, and of any other. */
double column_real(const struct cycle *c, int column);
int64_t column_integer(const struct cycle *c, int column);

#endif
