#include "log_analysis.h"

#include <string.h>

#include "log.h"
#include "log_params.h"
#include "log_runs.h"
#include "messages.h"
#include "printable.h"

static void feed(struct analysis *a, const struct log_event *event) {
    struct cycle cycle;
    struct event said;
    if (!strcmp(event->channel, CHANNEL_STATE) && state_decode(event->data, event->size, &cycle)) analysis_take(a, &cycle);
    else if (!strcmp(event->channel, CHANNEL_EVENT) && event_decode(event->data, event->size, &said) && !strcmp(said.kind, "fault"))
        text_printable(said.text, a->fault, sizeof a->fault);
}

static int read_events(struct log_analysis *l, const struct options *o, const char *path, struct log_reader *log, struct error *error) {
    struct log_event event;
    if (!log_next(log, &event)) return error_set(error, STATUS_IO, "%s: not a log: no event in it", path);
    l->began_us = event.utime_us;
    int status = log_params(o, path, &event, &l->params, &l->configured, error);
    if (!status) status = analysis_init(&l->analysis, &l->params, error);
    if (status) return status;
    if (o->weight_kg > 0.0) weighing_init(&l->analysis.weighing, &l->params);
    const struct test_params own = l->params.tests;
    do {
        log_params_follow(o, path, &event, &own, &l->params.tests);
        feed(&l->analysis, &event);
    } while (log_next(log, &event));
    analysis_end(&l->analysis);
    if (log_cut(log, &l->cut)) cli_warn_cut(path, l->cut);
    else l->cut = -1;
    analysis_identify(&l->analysis);
    return analysis_identifies(&l->analysis, path, error);
}

int log_analysis_read(struct log_analysis *l, const struct options *o, const char *path, struct error *error) {
    struct log_reader *log;
    memset(l, 0, sizeof *l);
    int status = log_open_run(&log, path, o->run, error);
    if (status) return status;
    status = read_events(l, o, path, log, error);
    log_release(log);
    if (!status) l->verdicts = analysis_verdicts(&l->analysis);
    return status;
}

void log_analysis_free(struct log_analysis *l) { analysis_free(&l->analysis); }
