/* `hexid qualify`: the motion system's quality, from a log of `hexid run --qualify`. */
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "log.h"
#include "log_params.h"
#include "log_runs.h"
#include "messages.h"
#include "outputs.h"
#include "params.h"
#include "quality_report.h"
#include "version.h"

static int read_params(const struct options *o, const struct log_event *event, struct params *params, struct error *error) {
    const char *path = o->operand[0];
    int status = log_params(o, path, event, params, NULL, error);
    if (!status && !o->config && strcmp(params->tests.trajectory, QUALITY_MOTION) != 0)
        status = error_set(error, STATUS_USAGE, "%.300s: its motion is none of `hexid run --qualify`, but %.200s", path,
                           params->tests.trajectory[0] ? params->tests.trajectory : "tests on sinusoids");
    return status;
}

static int read_log(const struct options *o, struct params *params, struct quality_plan *plan, struct quality_record *record,
                    struct error *error) {
    struct log_reader *log;
    struct log_event event;
    struct cycle cycle;
    int64_t offset;
    int status = log_open_run(&log, o->operand[0], o->run, error);
    if (status) return status;
    if (!log_next(log, &event)) status = error_set(error, STATUS_IO, "%s: not a log: no event in it", o->operand[0]);
    if (!status) status = read_params(o, &event, params, error);
    if (!status) status = quality_plan(plan, params, false, error);
    if (!status) status = quality_record_init(record, plan, error);
    while (!status && log_next(log, &event))
        if (!strcmp(event.channel, CHANNEL_STATE) && state_decode(event.data, event.size, &cycle) && cycle.test >= 0)
            quality_record_take(record, plan, params->tests.ramp_s, &cycle);
    if (log_cut(log, &offset)) cli_warn_cut(o->operand[0], offset);
    log_release(log);
    return status;
}

static int measure(const struct options *o, struct quality_report *r, struct error *error) {
    struct params params;
    struct quality_plan plan;
    struct quality_record record = {0};
    int status = o->baseline ? quality_json_read(o->baseline, &r->before, error) : STATUS_OK;
    if (!status) status = read_log(o, &params, &plan, &record, error);
    if (!status) status = quality_record_settle(&record, &plan, params.checks.excluded_pct, error);
    if (!status) status = quality_measure(&r->quality, &plan, &record, &params, error);
    quality_record_free(&record);
    if (status) return status;
    r->version = version, r->log = o->operand[0], r->law = params.control.law == CONTROL_MODEL ? "model" : "pid";
    r->baseline = o->baseline, r->limits = params.qualify;
    quality_judge(&r->quality, o->baseline ? &r->before : NULL, &params.qualify, r->check);
    return STATUS_OK;
}

static int report(const struct options *o, struct quality_report *r, struct error *error) {
    struct output json, page;
    struct error undrawn = {0};
    char *text;
    int status = outputs_open(o, NULL, OUTPUTS_PAGE, &json, &page, error);
    if (!status) status = measure(o, r, error);
    if (status) return status;
    bool taken = (o->json && !strcmp(o->json, "-")) || (o->output && !strcmp(o->output, "-"));
    quality_text(r, taken ? stderr : stdout);
    status = output_made(&json, quality_json(r), error);
    if (!status && o->output) {
        int drawn = quality_html(r, &text, &undrawn);
        status = output_page(&page, drawn, text, &undrawn);
        if (status) *error = undrawn;
    }
    if (status) return status;
    for (int i = 0; i < QUALITY_CHECKS; i++)
        if (r->check[i].limit > 0.0 && r->check[i].status != VERDICT_PASS) return EXIT_CHECK_FAILED;
    return EXIT_PASSED;
}

int cmd_qualify(int argc, char **argv) {
    struct options o;
    struct error error;
    struct quality_report *r = calloc(1, sizeof *r);
    int status = r ? options_parse(&o, argc, argv, "coSjzU", 1, &error) : error_set(&error, STATUS_IO, "out of memory");
    if (!status && !o.operands)
        status = error_set(&error, STATUS_USAGE, "qualify: name a log of `hexid run --qualify`; see `hexid qualify --help`");
    if (!status) status = report(&o, r, &error);
    free(r);
    return status < 0 ? cli_fail(&error) : status;
}
