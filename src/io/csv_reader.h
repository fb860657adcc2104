/* Reads one CSV file: first its head, then row after row. Constant memory; errors name file,
 * line and column. Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_READER_H
#define HEXID_CSV_READER_H

#include "csv_format.h"
#include "csv_map.h"
#include "csv_text.h"
#include "mechanism.h"
#include "status.h"

enum { CSV_CELLS_MAX = 128, CSV_LIST_SIZE = 240 };

struct csv_head {
    char path[CSV_PATH_SIZE];
    enum mechanism_kind mechanism;
    enum dof dof;                  /* axis of the test; a file of a single axis has x or none */
    double value[CSV_KEYS];        /* value of each key in the head; NaN: not given */
    int line[CSV_KEYS];            /* line number of each key */
    int columns_line;
    bool has[CSV_COLUMNS];
    char missing[CSV_LIST_SIZE];   /* missing columns, "u1..u6 ref_x_m" */
    char ignored[CSV_LIST_SIZE];   /* unknown columns and keys */
};

struct csv_reader {
    struct csv_head head;
    struct csv_text in;
    int cells;                     /* number of cells in a row */
    int column[CSV_CELLS_MAX];     /* column of each cell; -1: the column is unknown */
    double unit[CSV_CELLS_MAX];    /* factor that converts each cell to SI */
    int64_t empty;                 /* number of cells without a number so far */
    struct csv_map *map;           /* columns under the user's own names; NULL: there are none */
};

/* Opens the file and reads its head; marks in the map which of its names the file has. */
int csv_open(struct csv_reader **reader, const char *path, struct csv_map *map, struct error *error);

/* Returns 1 for a row, 0 at the end, or a negative status. Fills the cycle's columns; all else
 * in the cycle is NaN or zero. */
int csv_read_row(struct csv_reader *reader, struct cycle *cycle, struct error *error);

void csv_close(struct csv_reader *reader);

/* Writes "file:line: column: reason" and returns -2. column: index in csv_columns. */
__attribute__((format(printf, 4, 5))) int csv_refuse(const struct csv_reader *reader, int column, struct error *error, const char *format,
                                                     ...);

#endif
