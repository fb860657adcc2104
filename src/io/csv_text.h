/* Lines and cells of a CSV file that any program may have written: commas, semicolons or tabs,
 * decimal commas, quotes, CRLF, a byte order mark, comment lines. Constant memory; errors name file
 * and line. Private to src/io/. */
#ifndef HEXID_CSV_TEXT_H
#define HEXID_CSV_TEXT_H

#include <stdio.h>

#include "status.h"

enum { CSV_PATH_SIZE = 1024, CSV_LINE_SIZE = 8192 };

struct csv_text {
    char path[CSV_PATH_SIZE];
    FILE *file;
    int line;          /* the one read last, from 1 */
    char separator;    /* of cells: ',', or ';' or a tab, and then numbers may have
                        * decimal commas; 0: not known yet */
    char text[CSV_LINE_SIZE];
    char raw[CSV_LINE_SIZE]; /* a row as the file has it, for messages */
};

/* -3 with the path when it cannot be read. */
int csv_text_open(struct csv_text *t, const char *path, struct error *error);
void csv_text_close(struct csv_text *t);

/* The next line that is not blank, without its end: 1, 0 at the end of the file, or negative.
 * Once the separator is known: without comment lines, commas between cells, points in
 * numbers, no quotes. */
int csv_text_line(struct csv_text *t, char **line, struct error *error);

/* This line has the names of the columns: it tells the separator, and becomes as those that
 * follow. 0 or -2. */
int csv_text_columns(struct csv_text *t, char *line, struct error *error);

/* A number that ends at a comma or at the end of the text; NaN for an empty cell. NULL when it is
 * none, else where it ends. */
char *csv_text_number(char *text, double *number);

/* Cell of the row read last, from 0, as the file has it; length: of its text. */
const char *csv_text_cell(const struct csv_text *t, int cell, int *length);

/* Without blanks at both ends, in place. */
char *csv_text_trim(char *text);

/* "file:line: reason", -2. */
__attribute__((format(printf, 3, 4))) int csv_text_refuse(const struct csv_text *t, struct error *error, const char *format, ...);

#endif
