/* Files that are made anew and whole, or not at all: what is there is left alone, and what could
 * not be written to its end is taken away again, so that no part is taken for the whole.
 * Ordinary threads. */
#ifndef HEXID_NEW_FILE_H
#define HEXID_NEW_FILE_H

#include <stdio.h>

#include "status.h"

/* Open for writing; NULL and -3 with path, reason and remedy when it cannot be made, or
 * is there already. */
FILE *new_file(const char *path, struct error *error);

/* Closes it. failure: an errno of writing it, 0: none. -3 with path, reason and remedy when there
 * is one or closing has one; the file is gone then. */
int new_file_close(FILE *file, const char *path, int failure, struct error *error);

/* Removes what could not be written: -3 with path, reason and remedy. */
int new_file_fail(const char *path, int failure, struct error *error);

#endif
