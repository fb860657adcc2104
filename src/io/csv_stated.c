#include "csv_stated.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "csv_format.h"
#include "number_text.h"

const char csv_stated_kind[] = "stated";

static const char *const names[CSV_STATED_KEYS] = {"frequency_hz", "amplitude"};

const char *csv_stated_name(enum csv_stated_key key) { return names[key]; }

void csv_stated_text(const struct csv_stated *stated, char text[CSV_STATED_SIZE]) {
    char number[NUMBER_SIZE];
    snprintf(text, CSV_STATED_SIZE, "%s of %s: %s", names[stated->key], dof_names[stated->dof],
             isnan(stated->value) ? "nan" : number_shortest(stated->value, number));
}

static bool possible(const struct csv_stated *s) {
    if (isnan(s->value)) return true;
    if (s->key == CSV_STATED_FREQUENCY) return s->value >= TESTS_LEAST_HZ && s->value <= TESTS_MOST_HZ;
    return s->value >= TESTS_LEAST_AMPLITUDE && s->value <= (s->dof < DOF_PHI ? TESTS_MOST_M : TESTS_MOST_RAD);
}

bool csv_stated_decode(const void *data, int size, struct csv_stated *stated) {
    struct event event;
    char key[16], name[8];
    if (!event_decode(data, size, &event) || strcmp(event.kind, csv_stated_kind)) return false;
    if (sscanf(event.text, "%15[a-z_] of %7[a-z]: %lf", key, name, &stated->value) != 3) return false;
    for (int i = 0; i < CSV_STATED_KEYS; i++) {
        if (strcmp(key, names[i])) continue;
        stated->key = (enum csv_stated_key)i;
        return csv_dof_find(name, &stated->dof) && stated->dof != DOF_NONE && possible(stated);
    }
    return false;
}

void csv_stated_take(const struct csv_stated *stated, const struct test_params *own, struct test_params *tests) {
    bool frequency = stated->key == CSV_STATED_FREQUENCY;
    double *place = frequency ? &tests->hz[stated->dof] : &tests->amplitude[stated->dof];
    *place = !isnan(stated->value) ? stated->value : frequency ? own->hz[stated->dof] : own->amplitude[stated->dof];
}
