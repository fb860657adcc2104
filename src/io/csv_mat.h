/* Reads the numbers of a MAT file of format 5 (MATLAB: save -v6 or -v7) into CSV text. Private to
 * src/io/csv_*.c.
 *
 * Every real vector becomes a column, also vectors in structs ("run.force"), in arrays of structs
 * ("signals.2.values") and the columns of a matrix ("data.3"). Vectors of the same length in one
 * struct stand together, after their time. The time is the vector that --map gives for t; without
 * one in --map, a vector that rises and is named t or tout or has the word time in its name.
 * Vectors without a time in their struct share the time of other vectors of their length; if there
 * is no such time either, they are left out. If the file has no time at all, the vectors of the
 * greatest length are taken. A file of hexid's own (`hexid export --format mat`) becomes its tests.
 * Format 7.3, which is HDF5, is refused with the remedy. If there are more vectors than a CSV text
 * can have columns, or the table would be too large, only times and the vectors with a name in
 * --map or one of hexid's own are taken. Without names in --map, a file with too many vectors or
 * too large a text is refused. */
#ifndef HEXID_CSV_MAT_H
#define HEXID_CSV_MAT_H

#include "csv_foreign.h"

/* Returns -2 for a file that cannot be used, -3 for one that cannot be read. */
int csv_mat_read(const char *path, const struct csv_map *map, struct csv_texts *texts, struct error *error);

#endif
