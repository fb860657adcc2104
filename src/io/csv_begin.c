#include "csv_begin.h"

#include <math.h>
#include <stdlib.h>

#include "params.h"
#include "sampling.h"
#include "segments.h"

static int read_test(struct recording_test *test, struct csv_rows *rows, const struct params *params, struct error *error) {
    struct cycle c;
    int got = 1, status = STATUS_OK;
    while (!status && (got = csv_rows_next(rows, &c, error)) > 0) {
        struct recording_sample s = recording_sample_of(params, &c);
        s.refused = refusal_of(&c, params_legs(params)); /* a sample without a force counts, too,
                                                          * because only the motion matters here */
        status = recording_append(test, &s, error);
    }
    return got < 0 ? got : status;
}

/* Returns the t_s at which the ramp-in starts. duration_s: duration of the evaluated part as
 * stated; NaN if it is not stated. */
static double zero_of(const struct recording_test *test, const struct segments *p, double duration_s, double ramp_s) {
    const struct segment *end = p->segment + p->count, *rest = NULL, *steady = p->segment;
    while (steady < end && steady->kind != SEGMENT_STEADY) steady++;
    for (const struct segment *i = p->segment; i < steady && i < end - 1; i++)
        if (i->kind == SEGMENT_REST && (steady < end || !rest)) rest = i;
    double first_s = test->sample[0].test_time_s, rest_s = rest ? test->sample[rest->end - 1].test_time_s : first_s;
    if (steady == end) return rest_s;
    double steady_s = test->sample[steady->first].test_time_s;
    if (rest) return 0.5 * (rest_s + steady_s - ramp_s);
    if ((steady_s - first_s) * steady->frequency_hz > 1.0) return fmax(first_s, steady_s - ramp_s);
    return first_s > 0.0 && first_s < ramp_s + duration_s ? 0.0 : steady_s - ramp_s;
}

int csv_begin_find(const struct csv_head *head, const struct csv_table *table, struct csv_map *map, const struct params *params,
                   double *zero_s, struct error *error) {
    struct csv_rows rows;
    struct recording_test test = {.dof = head->dof, .first = -1};
    struct segments segments = {0};
    int status = csv_rows_open(&rows, head, table, map, error);
    if (!status) status = read_test(&test, &rows, params, error);
    csv_rows_close(&rows);
    if (!status) status = segments_find(&segments, &test, sampling_step_s(&test, 0, test.count), params_legs(params), error);
    if (!status) *zero_s = zero_of(&test, &segments, head->value[CSV_DURATION], params->tests.ramp_s);
    segments_free(&segments);
    free(test.sample);
    return status;
}
