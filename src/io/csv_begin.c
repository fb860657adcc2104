#include "csv_begin.h"

#include <math.h>
#include <stdlib.h>

#include "pieces.h"

static int read_test(struct recording_test *test, const struct csv_head *head, struct csv_map *map, const struct params *params,
                     struct error *error) {
    struct csv_reader *reader;
    struct cycle c;
    int got = 1, status = csv_open(&reader, head->path, map, error);
    if (status) return status;
    while (!status && (got = csv_read_row(reader, &c, error)) > 0) {
        struct recording_sample s = recording_sample_of(params, &c);
        s.good = !c.in.flags;
        for (int k = 0; k < params_legs(params); k++) s.good = s.good && isfinite(s.length_m[k]);
        status = recording_append(test, &s, error);
    }
    csv_close(reader);
    return got < 0 ? got : status;
}

static const struct piece *first_steady(const struct pieces *p) {
    for (int i = 0; i < p->count; i++)
        if (p->piece[i].kind == PIECE_STEADY) return &p->piece[i];
    return NULL;
}

/* duration_s: NaN where it is not stated. */
static double zero_of(const struct recording_test *test, const struct piece *steady, double duration_s, double ramp_s) {
    double first_s = test->sample[0].test_time_s;
    if (!steady) return first_s;
    double steady_s = test->sample[steady->first].test_time_s, cycle_s = 1.0 / steady->frequency_hz;
    if (steady_s - first_s <= cycle_s && first_s < ramp_s + duration_s) return 0.0;
    return fabs(steady_s - ramp_s - first_s) > cycle_s ? steady_s - ramp_s : first_s;
}

int csv_begin_find(const struct csv_head *head, struct csv_map *map, const struct params *params, double *zero_s, struct error *error) {
    struct recording_test test = {.dof = head->dof, .first = -1};
    struct pieces pieces = {0};
    int status = read_test(&test, head, map, params, error);
    if (!status) status = pieces_find(&pieces, &test, params_legs(params), error);
    const struct piece *steady = status ? NULL : first_steady(&pieces);
    if (!status) *zero_s = zero_of(&test, steady, head->value[CSV_DURATION], params->tests.ramp_s);
    pieces_free(&pieces);
    free(test.sample);
    return status;
}
