/* New files, whole or not at all: one that exists is never overwritten, and one that could not be
 * written to its end is removed, so that no part is taken for the whole. Ordinary threads. */
#ifndef HEXID_NEW_FILE_H
#define HEXID_NEW_FILE_H

#include <stdio.h>

#include "status.h"

/* Opens it for writing. NULL, and -3 with path, reason and remedy in *error, when it cannot be made
 * or exists already. */
FILE *new_file(const char *path, struct error *error);

/* Closes it. failure: errno of an earlier write, 0: none. -3 with path, reason and remedy for that
 * or when closing fails; the file is then removed. */
int new_file_close(FILE *file, const char *path, int failure, struct error *error);

/* Removes a file that could not be written. Always -3, with path, reason and remedy. */
int new_file_fail(const char *path, int failure, struct error *error);

#endif
