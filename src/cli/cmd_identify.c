#include <string.h>

#include "analysis.h"
#include "cli.h"
#include "config.h"
#include "log.h"
#include "messages.h"

/* The configuration in the log's first event, changed by --set; or the file given by -c. */
static int log_params(const struct options *o, const struct log_event *event, struct params *params, struct error *error) {
    if (o->config) return options_params(o, params, error);
    int status = cli_log_params(o->operand[0], event, "give one with -c FILE", params, error);
    return status ? status : config_override(params, o->operand[0], o->settings, o->setting_count, error);
}

static void feed(struct analysis *a, const struct log_event *event) {
    struct cycle cycle;
    if (!strcmp(event->channel, CHANNEL_STATE) && state_decode(event->data, event->size, &cycle)) analysis_take(a, &cycle);
}

static int identify(const struct options *o, struct log_reader *log, struct params *params, struct analysis *analysis,
                    struct error *error) {
    struct log_event event;
    int64_t offset;
    if (!log_next(log, &event)) return error_set(error, STATUS_IO, "%s: not a log: no event in it", o->operand[0]);
    int status = log_params(o, &event, params, error);
    if (!status) status = analysis_init(analysis, params, error);
    if (status) return status;
    do feed(analysis, &event);
    while (log_next(log, &event));
    analysis_end(analysis);
    if (log_cut(log, &offset)) cli_warn_cut(o->operand[0], offset);
    analysis_identify(analysis);
    if ((status = analysis_identifies(analysis, o->operand[0], error))) return status;
    struct verdict verdict = analysis_verdict(analysis);
    analysis_print(analysis, &verdict, o->json && !strcmp(o->json, "-") ? stderr : stdout);
    status = analysis_write_json(analysis, &verdict, o->json, error);
    return status ? status : verdict.status == VERDICT_PASS ? EXIT_PASSED : EXIT_CHECK_FAILED;
}

int cmd_identify(int argc, char **argv) {
    struct options o;
    struct error error;
    struct log_reader *log;
    struct params params;
    struct analysis analysis = {0};
    int status = options_parse(&o, argc, argv, "cSj", 1, &error);
    if (!status && !o.operands) status = error_set(&error, STATUS_USAGE, "identify: name a log; see `hexid identify --help`");
    if (!status) status = log_open(&log, o.operand[0], &error);
    if (!status) {
        status = identify(&o, log, &params, &analysis, &error);
        analysis_free(&analysis);
        log_release(log);
    }
    return status < 0 ? cli_fail(&error) : status;
}
