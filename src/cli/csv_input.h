/* A directory of CSV files, read as -c, --set and --map say. */
#ifndef HEXID_CSV_INPUT_H
#define HEXID_CSV_INPUT_H

#include "cli.h"
#include "csv.h"
#include "csv_map.h"

struct csv_input {
    struct csv_source source; /* points into the other members */
    struct csv_map map;
    char *base;
};

/* -2 for a wrong --map, and for -c or --set beside a directory that has a
 * configuration of its own. */
int csv_input_begin(struct csv_input *input, const struct options *o, const char *directory, struct error *error);
void csv_input_end(struct csv_input *input);

#endif
