#include "csv_stated.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "csv_format.h"
#include "number_text.h"
#include "params/tests.h"

const char csv_stated_kind[] = "stated";

void csv_stated_text(enum dof dof, double hz, char text[CSV_STATED_SIZE]) {
    char number[NUMBER_SIZE];
    snprintf(text, CSV_STATED_SIZE, "frequency_hz of %s: %s", dof_names[dof], isnan(hz) ? "nan" : number_shortest(hz, number));
}

bool csv_stated_decode(const void *data, int size, enum dof *dof, double *hz) {
    struct event event;
    char name[8];
    if (!event_decode(data, size, &event) || strcmp(event.kind, csv_stated_kind)) return false;
    if (sscanf(event.text, "frequency_hz of %7[a-z]: %lf", name, hz) != 2) return false;
    bool possible = isnan(*hz) || (*hz >= TESTS_LEAST_HZ && *hz <= TESTS_MOST_HZ);
    return csv_dof_find(name, dof) && *dof != DOF_NONE && possible;
}
