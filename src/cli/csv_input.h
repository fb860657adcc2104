/* A directory of CSV files, or a single file, that is read according to -c, --set and --map. */
#ifndef HEXID_CSV_INPUT_H
#define HEXID_CSV_INPUT_H

#include "cli.h"
#include "csv.h"
#include "csv_map.h"

struct csv_input {
    struct csv_source source; /* points into the other members, so the struct must not move */
    struct csv_map map;
    char *base;
};

/* Prepares the source. Returns -2 for a wrong --map or configuration, and for -c or --set if the
 * directory has its own configuration; -3 without memory. */
int csv_input_begin(struct csv_input *input, const struct options *o, const char *directory, struct error *error);

void csv_input_end(struct csv_input *input);

#endif
