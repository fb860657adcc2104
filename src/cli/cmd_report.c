/* hexid report: identification from logs as a page. */
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "config.h"
#include "failure.h"
#include "identification_report.h"
#include "log_analysis.h"
#include "log_set.h"
#include "outputs.h"
#include "version.h"

_Static_assert((int)REPORT_LOGS <= (int)OPERANDS_MAX, "an operand a log");

static struct identification_log summary(const struct log_analysis *l, const char *path, const char *config) {
    const struct analysis *a = &l->analysis;
    const struct motion_result *m = &a->motion;
    return (struct identification_log){
        .path = path,
        .began_us = l->began_us,
        .cut = l->cut,
        .params = &l->params,
        .config = config,
        .sinusoids = analysis_sinusoids(a),
        .id = &a->ident.result,
        .verdicts = &l->verdicts,
        .loop = analysis_statistics(a),
        .recording = a->measured.recording.tests ? &a->measured.recording : &a->recording,
        .motion = {.there = m->cycles > 0,
                   .name = tests_name(&l->params.tests, DOF_NONE),
                   .samples = m->samples,
                   .excluded = m->excluded,
                   .off_m = m->off_m,
                   .off_rad = m->off_rad,
                   .complete = m->complete},
        .refused = a->refused,
        .fault = a->last.first_fault ? a->fault : NULL, /* analysis_verdicts() has already written
                                                         * this text */
    };
}

/* Makes the page. Nothing is written until all logs have been read. */
static int report(const struct options *o, struct log_analysis *analysis, struct error *error) {
    struct identification_report r = {.version = version, .logs = o->operands};
    char *config[REPORT_LOGS] = {0}, *text;
    struct output page;
    int status = outputs_open(o, NULL, OUTPUTS_PAGE, NULL, &page, error), result = EXIT_PASSED;
    for (int i = 0; i < r.logs && !status; i++) status = log_set_new(i, o->operand, error);
    for (int i = 0; i < r.logs && !status; i++) {
        status = log_analysis_read(&analysis[i], o, o->operand[i], error);
        if (!status) config[i] = config_text(&analysis[i].params);
        if (!status && !config[i]) status = error_set(error, STATUS_IO, "out of memory");
        if (!status) r.log[i] = summary(&analysis[i], o->operand[i], config[i]);
    }
    FILE *out = !strcmp(o->output, "-") ? stderr : stdout;
    if (!status) {
        status = identification_html(&r, &text, error);
        status = output_page(&page, status, text, error);
    }
    for (int i = 0; i < r.logs && !status; i++) {
        cli_say(out, "%s: %s", o->operand[i], verdict_names[r.log[i].verdicts->run.status]);
        for (int j = 0; j < r.log[i].verdicts->run.reasons; j++) cli_say(out, "  %s", r.log[i].verdicts->run.reason[j]);
        if (r.log[i].verdicts->run.status != VERDICT_PASS) result = EXIT_CHECK_FAILED;
    }
    if (!status) cli_say(out, "page      %s", o->output);
    for (int i = 0; i < r.logs; i++) free(config[i]);
    return status ? status : result;
}

int cmd_report(int argc, char **argv) {
    struct options o;
    struct error error = {0};
    struct log_analysis *analysis = calloc(REPORT_LOGS, sizeof *analysis);
    int status = analysis ? options_parse(&o, argc, argv, "coSU", REPORT_LOGS, &error) : error_set(&error, STATUS_IO, "out of memory");
    if (!status && (!o.operands || !o.output))
        status = error_set(&error, STATUS_USAGE, "`hexid report` needs a log and -o PAGE.html; see `hexid report --help`");
    if (!status) status = report(&o, analysis, &error);
    for (int i = 0; analysis && i < REPORT_LOGS; i++) log_analysis_free(&analysis[i]);
    free(analysis);
    return status < 0 ? cli_fail(&error) : status;
}
