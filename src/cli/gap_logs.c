#include "gap_logs.h"

#include <stdlib.h>
#include <string.h>

#include "areas.h"
#include "log.h"
#include "log_params.h"
#include "log_runs.h"
#include "log_set.h"
#include "messages.h"
#include "params.h"

_Static_assert((int)LOGS_MAX <= (int)RECORDING_RUNS, "a run a log");

/* Puts the log's name before the message of an error. */
static int of_log(const char *path, int status, struct error *error) {
    if (!status) return STATUS_OK;
    struct error reason = *error;
    return error_set(error, status, "%.100s: %.280s", path, reason.text);
}

/* Reads the log's own configuration, checks that its mechanism is that of -c, and begins a run with
 * the log's tests. The first log may lack a configuration, or have one that cannot be read. */
static int begin(const struct options *o, const char *path, const struct log_event *event, struct recording *r, struct error *error) {
    struct params *own = calloc(1, sizeof *own);
    if (!own) return error_set(error, STATUS_IO, "%.250s: out of memory", path);
    int status = log_params_own(path, event, "which tests it has is not known", own, error);
    if (!status && own->mechanism != r->params->mechanism)
        status = error_set(error, STATUS_USAGE, "%.250s: is of %s, the configuration of -c of %s (mechanism)", path,
                           params_mechanism(own)->words.legs, params_mechanism(r->params)->words.legs);
    else if (!r->tests) status = STATUS_OK;
    if (!status) {
        *own = *r->params;
        status = log_params_tests(o, path, event, own, error);
    }
    if (!status && r->tests) status = of_log(path, recording_begin(r, &own->tests, error), error);
    else if (!status) r->run[0] = own->tests;
    free(own);
    return status;
}

struct test {
    struct cycle last; /* last cycle of the current test; last.test -1: none */
    int recorded;      /* number of tests in the recording before the current one */
};

/* Adds a test to the list of excluded ones if the recording has no sample of it. */
static void end_test(const struct test *t, const struct recording *r, char left_out[GAP_LEFT_OUT_SIZE]) {
    size_t used = strlen(left_out);
    if (t->last.test < 0 || t->last.dof == DOF_NONE || r->tests > t->recorded) return;
    snprintf(left_out + used, GAP_LEFT_OUT_SIZE - used, "%s%s", used ? ", " : "", dof_names[t->last.dof]);
}

/* Notes the end of a test if this cycle belongs to another one. To be called before the recording
 * takes the cycle. */
static void follow_test(struct test *t, const struct cycle *c, const struct recording *r, char left_out[GAP_LEFT_OUT_SIZE]) {
    bool same = c->test == t->last.test && c->dof == t->last.dof && c->test_time_s > t->last.test_time_s;
    if (!same) end_test(t, r, left_out), t->recorded = r->tests;
    t->last = *c;
}

static int add(const struct options *o, const char *path, int run, struct recording *r, char left_out[GAP_LEFT_OUT_SIZE],
               struct error *error) {
    struct test test = {.last.test = -1};
    struct test_params own = {0};
    struct log_reader *log;
    struct log_event event;
    struct cycle cycle;
    int64_t offset;
    int status = log_open_run(&log, path, run, error);
    if (status) return status;
    for (bool first = true; !status && log_next(log, &event); first = false) {
        if (first) status = begin(o, path, &event, r, error);
        if (!status && first) own = r->run[r->runs - 1];
        if (!status) log_params_follow(o, path, &event, &own, &r->run[r->runs - 1]);
        if (status || strcmp(event.channel, CHANNEL_STATE) || !state_decode(event.data, event.size, &cycle)) continue;
        follow_test(&test, &cycle, r, left_out);
        status = of_log(path, recording_add(r, &cycle, error), error);
    }
    end_test(&test, r, left_out);
    if (!status && log_cut(log, &offset)) cli_warn_cut(path, offset);
    log_release(log);
    recording_settle(r);
    return status;
}

/* Refuses pressures if the cylinder's diameters are not stated, because wrong areas would make
 * every force wrong. */
static int check_areas(const char *path, const struct recording *r, struct error *error) {
    char areas[AREAS_TEXT_SIZE];
    if (!r->measured.pressures || areas_stated(r->params)) return STATUS_OK;
    areas_text(r->params, areas);
    return error_set(error, STATUS_USAGE,
                     "%.100s: forces are to come from pressures, and %s (or leave p1_pa and p2_pa out where there is a force_n)", path,
                     areas);
}

void gap_logs_init(struct gap_logs *g, const struct params *params) {
    *g = (struct gap_logs){0};
    recording_init(&g->raw, params);
}

void gap_logs_free(struct gap_logs *g) {
    measured_free(&g->measured);
    recording_free(&g->raw);
}

/* Measures and admits the last log. */
static int measure(struct gap_logs *g, struct error *error) {
    int status = measured_add(&g->measured, &g->raw, error);
    if (!status) status = admit(&g->raw, &g->measured, &g->admission, error);
    if (!status) status = measured_noise(&g->measured, error);
    return status ? status : admit_noise(&g->measured, error);
}

int gap_logs_load(const struct options *o, int logs, const char *const *path, int run, struct gap_logs *g, gap_left_out left_out,
                  struct error *error) {
    struct recording *r = &g->raw;
    memset(left_out, 0, sizeof(gap_left_out));
    for (int i = 0; i < logs; i++) {
        int tests = r->tests, status = log_set_new(i, path, error);
        if (!status) status = add(o, path[i], run, r, left_out[i], error);
        if (!status && r->tests == tests)
            status = error_set(error, STATUS_USAGE, "%.200s: %s%s%.100s", path[i],
                               left_out[i][0] ? refusals[REFUSED_EMPTY].why : "no sinusoidal test in the log",
                               left_out[i][0] ? ": test " : "", left_out[i]);
        if (!status) status = check_areas(path[i], r, error);
        if (!status) status = of_log(path[i], measure(g, error), error);
        if (status) return status;
    }
    return STATUS_OK;
}
