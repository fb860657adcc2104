/* Brings channels that have clocks of their own onto one clock, in rows: several columns of time in
 * a file, rows that have only some of the channels, channels that are repeated, several files of
 * one test, and a position that is integrated from a speed.
 *
 * Each channel is a series of times and values. The rows are the samples of the slowest measured
 * channel (position, lengths, force, pressures; if several are equally slow, the force or a
 * pressure), because a channel's values between its samples are unknown. At the times of the rows,
 * the other channels are interpolated by a cubic through four samples; commands, which a machine
 * holds, have their last value. A repeated channel counts only in rows in which its value is new,
 * so that it has its own rate and no mean delay. Private to src/io/csv_*.c. */
#ifndef HEXID_CSV_TABLE_H
#define HEXID_CSV_TABLE_H

#include "csv_reader.h"

enum { CSV_NOTES_SIZE = 1200 };

struct csv_table {
    int64_t rows;
    double *t_s;
    double *value[CSV_COLUMNS]; /* values in SI; NULL: the column is missing */
};

/* Looks through the files of a test. If there is a single file whose rows can be used as they are,
 * sets *table to NULL, removes columns without any number from the head `whole`, and sets *empty to
 * the number of cells without a number in the remaining columns. Otherwise makes the table, sets
 * *empty to 0 and notes what was changed. middle_m: middle of the range of a position that is
 * integrated. Heap. Returns -2 or -3 on failure. */
int csv_table_make(struct csv_table **table, struct csv_head *whole, int64_t *empty, const struct csv_head *files, int count,
                   double middle_m, struct csv_map *map, char notes[CSV_NOTES_SIZE], struct error *error);

void csv_table_free(struct csv_table *table);

/* Appends a sentence to the notes, after "; ". */
__attribute__((format(printf, 2, 3))) void csv_note(char notes[CSV_NOTES_SIZE], const char *format, ...);

/* Rows of a test, from its table if there is one, else from its file. */
struct csv_rows {
    struct csv_reader *reader; /* reader of the file; NULL: rows come from the table */
    const struct csv_table *table;
    int64_t next;
};

int csv_rows_open(struct csv_rows *rows, const struct csv_head *head, const struct csv_table *table, struct csv_map *map,
                  struct error *error);

/* Returns 1 for a row, 0 at the end, or a negative status. */
int csv_rows_next(struct csv_rows *rows, struct cycle *cycle, struct error *error);

void csv_rows_close(struct csv_rows *rows);

#endif
