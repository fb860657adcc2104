/* One CSV file: its head, then row after row. Constant memory; errors name file, line and column.
 * Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_READER_H
#define HEXID_CSV_READER_H

#include "csv_format.h"
#include "csv_map.h"
#include "csv_text.h"
#include "status.h"

enum { CSV_CELLS_MAX = 128, CSV_LIST_SIZE = 240 };

struct csv_head {
    char path[CSV_PATH_SIZE];
    enum mechanism_kind mechanism;
    enum dof dof;                  /* of an axis: x, or none */
    double value[CSV_KEYS];        /* NaN: not given */
    int line[CSV_KEYS];            /* where it is given */
    int columns_line;
    bool has[CSV_COLUMNS];
    char missing[CSV_LIST_SIZE];   /* columns that are not there, "u1..u6 ref_x_m" */
    char ignored[CSV_LIST_SIZE];   /* columns and keys that are not known */
};

struct csv_reader {
    struct csv_head head;
    struct csv_text in;
    int cells;                     /* in a row */
    int column[CSV_CELLS_MAX];     /* of each cell, -1: not known */
    double unit[CSV_CELLS_MAX];    /* SI units in the column's own */
    int64_t empty;                 /* cells so far that have no number */
    struct csv_map *map;           /* names of the user's own; NULL: none */
};

/* Opens it and reads the head; notes in the map which of its names are there. */
int csv_open(struct csv_reader **reader, const char *path, struct csv_map *map, struct error *error);

/* 1 a row, 0 the end, or negative. Fills the cycle's columns; what else a cycle
 * has is NaN or none. */
int csv_read_row(struct csv_reader *reader, struct cycle *cycle, struct error *error);

void csv_close(struct csv_reader *reader);

/* "file:line: column: reason", -2. column: CSV_T or another of csv_columns. */
__attribute__((format(printf, 4, 5))) int csv_refuse(const struct csv_reader *reader, int column, struct error *error, const char *format,
                                                     ...);

#endif
