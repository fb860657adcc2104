/* Reads one CSV file: first its head, then row after row. Constant memory; errors name file,
 * line and column. Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_READER_H
#define HEXID_CSV_READER_H

#include "csv_format.h"
#include "csv_layout.h"
#include "csv_map.h"
#include "csv_text.h"
#include "mechanism.h"
#include "status.h"

enum { CSV_LIST_SIZE = 400, CSV_OPENED_SIZE = 40, CSV_CELL_NAME = 80, CSV_CELL_UNIT = 16 };

struct csv_head {
    char path[CSV_PATH_SIZE];
    char opened[CSV_OPENED_SIZE];  /* path of the CSV text that was made from another format; "":
                                    * `path` is the text */
    enum mechanism_kind mechanism;
    enum dof dof;                  /* axis of the test; a file of a single axis has x or none */
    bool has_dof;                  /* the head states dof */
    double value[CSV_KEYS];        /* value of each key in the head; NaN: not given */
    int line[CSV_KEYS];            /* line number of each key */
    int columns_line;              /* line number of the names; of the first row without names */
    bool has[CSV_COLUMNS];
    int clocks;                    /* number of columns of time that other columns use */
    int skipped;                   /* number of lines of text before the names */
    bool units;                    /* there is a line of units below the names */
    bool rising[CSV_CELLS_MAX];    /* columns whose numbers rise in the first rows, as time does */
    int unknown;                   /* index of a column to which the file gives a unit that hexid
                                    * does not know; 0: none */
    char unknown_name[CSV_CELL_NAME]; /* name of that column in the file */
    bool speed, turns, slides;     /* speed: the position is given as a speed; turns, slides:
                                    * position or force has a unit of an axis that turns, or of one
                                    * that slides */
    char missing[CSV_LIST_SIZE];   /* missing columns, "u1..u6, ref_x_m" */
    char ignored[CSV_LIST_SIZE];   /* unknown columns and keys */
};

/* Meaning of one cell of each row. */
struct csv_cell {
    int column;  /* index in csv_columns; -1: the column is unknown */
    int clock;   /* index of the cell's clock: of the last column of time at or before the cell, or
                  * of the first such column */
    struct csv_unit unit;
};

/* A column of time. Times of day continue after midnight. */
struct csv_clock {
    double time_s; /* time in the last row */
    double day_s;  /* added to a time of day, 12 h for each midnight or noon that passed */
    double before_s; /* last time of day, with day_s added */
};

struct csv_reader {
    struct csv_head head;
    struct csv_text in;
    int cells;                     /* number of cells in a row */
    struct csv_cell cell[CSV_CELLS_MAX];
    char name[CSV_CELLS_MAX][CSV_CELL_NAME]; /* names of the columns, and their units from the line
                                              * of units, truncated */
    char unit[CSV_CELLS_MAX][CSV_CELL_UNIT];
    struct csv_clock clock[CSV_CLOCKS];
    const struct csv_alias *counted; /* entry of the map (t=#0) that makes the row's number the
                                      * time; NULL: there is none */
    int64_t rows;
    int clock_of[CSV_COLUMNS];     /* clock of each column that is there */
    struct csv_map *map;           /* columns under the user's own names; NULL: there are none */
};

/* Remedy for units of an axis that turns beside those of one that slides. */
extern const char csv_one_kind[];

/* Opens the file and reads its head; marks in the map which of its names the file has. */
int csv_open(struct csv_reader **reader, const char *path, struct csv_map *map, struct error *error);

/* Opens the file that a head describes. part: the columns that every test must have may be in
 * another file. */
int csv_open_as(struct csv_reader **reader, const struct csv_head *head, bool part, struct csv_map *map, struct error *error);

/* Lists the columns that the head's mechanism could have and the file lacks. */
void csv_list_missing(struct csv_head *head);

/* Reads the next row that has a number in a known column other than the time. Returns 1 for a row,
 * 0 at the end, or a negative status. Values are in SI, NaN if missing; reader->clock has the
 * times. */
int csv_read_values(struct csv_reader *reader, double value[CSV_COLUMNS], struct error *error);

/* Fills a cycle from the values of a row, with state STATE_TESTING and the valves enabled. Numbers
 * of legs and axes that are missing are NaN, everything else is zero. */
void csv_fill_cycle(const double value[CSV_COLUMNS], struct cycle *cycle);

/* Reads a row of a file with one clock into a cycle, like csv_read_values(). */
int csv_read_row(struct csv_reader *reader, struct cycle *cycle, struct error *error);

void csv_close(struct csv_reader *reader);

/* Writes "file:line: column: reason" and returns -2. column: index in csv_columns. */
__attribute__((format(printf, 4, 5))) int csv_refuse(const struct csv_reader *reader, int column, struct error *error, const char *format,
                                                     ...);

#endif
