/* Turns MAT and MCAP files into CSV texts in memory, which are then read like CSV files. Private to
 * src/io/csv_*.c. */
#ifndef HEXID_CSV_FOREIGN_H
#define HEXID_CSV_FOREIGN_H

#include "csv_reader.h"

enum { CSV_TEXTS_MAX = 100 };

/* Largest total size of a file's texts, bytes, about 50 million numbers. Texts are held in
 * memory. */
static const int64_t CSV_TEXTS_BYTES = 1 << 30;

/* Texts made from a file. Initialised to zero. */
struct csv_texts {
    int count;
    int64_t bytes;                               /* number of bytes of all texts */
    bool full;                                   /* there were more tests than CSV_TEXTS_MAX */
    bool cut;                                    /* the file has no end: its writer was stopped */
    char opened[CSV_TEXTS_MAX][CSV_OPENED_SIZE]; /* paths, valid until csv_foreign_close() */
    FILE *file;                                  /* text that is being written */
};

/* Size of the first line of a text, which has the columns' names. Initialised to zero. */
struct csv_width {
    int columns;
    size_t bytes;
};

/* Makes the texts of a MAT (csv_mat.h) or MCAP file (csv_mcap.h). Any other file is itself the
 * text: texts->count is then 1, and the path "". Returns -2 or -3 with the file's name. */
int csv_foreign_open(const char *path, const struct csv_map *map, struct csv_texts *texts, struct error *error);

/* Frees the text with this path; does nothing for "". */
void csv_foreign_close(const char *opened);

/* Ends the last text and begins another. Returns the new text's stream, or NULL on failure, which
 * csv_texts_refuse() reports. */
FILE *csv_texts_next(struct csv_texts *texts);

/* Writes a separator (0: none), then a number in its shortest form. NaN becomes an empty cell: only
 * the separator is written. */
void csv_texts_number(struct csv_texts *texts, char separator, double number);

/* Writes a name with _ in place of each character that could end a cell or begin a comment. */
void csv_texts_name(FILE *file, const char *name);

/* Returns false once a write has failed or the texts are larger than CSV_TEXTS_BYTES. */
bool csv_texts_good(const struct csv_texts *texts);

/* Writes why a text could not be written, with the remedy, and returns the status. */
int csv_texts_refuse(const struct csv_texts *texts, const char *path, struct error *error);

/* Adds one more name. Returns false once the names are too many or too long for a line of CSV. */
bool csv_width_add(struct csv_width *width, const char *name);

/* Refuses a file with too many columns; returns -2. */
int csv_width_refuse(const struct csv_width *width, const char *path, struct error *error);

/* Returns true if the map gives all its columns by their names (or the row's number, #0), so that
 * the other columns of a wide file can be left out. A column that is given by its number is found
 * only if no column is left out. */
bool csv_map_names(const struct csv_map *map);

/* Returns true if the map, or hexid's own name, gives the column a meaning. */
bool csv_is_wanted(const struct csv_map *map, const char *name);

#endif
