/* Lines and cells of CSV files from any program: commas, semicolons or tabs, decimal commas,
 * quotes, CRLF, a byte order mark, comment lines. Constant memory; errors name file and line.
 * Private to src/io/. */
#ifndef HEXID_CSV_TEXT_H
#define HEXID_CSV_TEXT_H

#include <stdbool.h>
#include <stdio.h>

#include "status.h"

enum { CSV_WIDE = 'w' }; /* separator: two or more blanks, for names with single blanks in them */
enum { CSV_PATH_SIZE = 1024, CSV_LINE_SIZE = 16384 };

struct csv_text {
    char path[CSV_PATH_SIZE];
    FILE *file;
    int line;          /* number of the last line read, from 1 */
    char separator;    /* separator of cells: ',', or ';', tab or ' ' (any number of blanks), which
                        * allow decimal commas; 0: not known yet */
    char text[CSV_LINE_SIZE];
    char raw[CSV_LINE_SIZE]; /* last row as it stands in the file, for messages */
};

/* Opens the file. Returns -3 with the path if it cannot be read. */
int csv_text_open(struct csv_text *t, const char *path, struct error *error);
void csv_text_close(struct csv_text *t);

/* Reads the next line that is not blank, without its end. Once the separator is known, comment
 * lines are skipped, and the line is normalised: commas between cells, points in numbers, no
 * quotes. Returns 1, 0 at the end of the file, or a negative status. */
int csv_text_line(struct csv_text *t, char **line, struct error *error);

/* Takes the line with the columns' names: finds the separator from it and normalises it like later
 * lines. Returns 0 or -2. */
int csv_text_columns(struct csv_text *t, char *line, struct error *error);

/* Does what csv_text_columns() does, with a separator that is already known. */
int csv_text_separate(struct csv_text *t, char *line, char separator, struct error *error);

/* Returns the separator of a line of names: the first of comma, semicolon and tab that is in it,
 * outside quotes; a comma if there is none. */
char csv_text_separator(const char *line);

/* Normalises a line in place: commas between cells, points in numbers, no quotes. Returns false if
 * a quote is not closed. */
bool csv_text_normalise(char *text, char separator);

extern const char csv_text_mark[]; /* byte order mark that some programs put before UTF-8 */

/* Opens the text at `opened` under the name `path`. */
int csv_text_open_as(struct csv_text *t, const char *path, const char *opened, struct error *error);

/* Reads a number that ends at a comma or at the end of the text; NaN for an empty cell and for
 * words that mean an empty one (NULL, N/A). Returns the end of the number, or NULL if there is no
 * number. */
char *csv_text_number(char *text, double *number);

/* Reads a time of day, "12:00:01.5", with or without a date before it and AM or PM after it, as
 * seconds since midnight; with AM or PM, since midnight or noon. Returns like csv_text_number(). */
char *csv_text_time_of_day(char *text, double *seconds);

/* Returns the text of a cell of the last row, as it stands in the file, and its length. cell: from
 * 0. */
const char *csv_text_cell(const struct csv_text *t, int cell, int *length);

/* Removes blanks at both ends, and the line's end, in place. Returns the new beginning of the
 * text. */
char *csv_text_trim(char *text);

/* Writes "file:line: reason" and returns -2. */
__attribute__((format(printf, 3, 4))) int csv_text_refuse(const struct csv_text *t, struct error *error, const char *format, ...);

#endif
