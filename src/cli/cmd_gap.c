/* hexid gap: reads logs, makes the diagnosis, writes its files. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"
#include "gap.h"
#include "gap_files.h"
#include "gap_logs.h"
#include "gap_text.h"
#include "log_set.h"
#include "outputs.h"

static void progress(void *context, const char *step, double share) {
    (void)context;
    if (isatty(STDERR_FILENO)) fprintf(stderr, "\r\033[Kgap: %3.0f %% %s%s", 100.0 * share, step, share >= 1.0 ? "\r\033[K" : "");
    else fprintf(stderr, "gap: %s\n", step);
}

static int options(struct options *o, struct gap_options *g, int argc, char **argv, struct error *error) {
    int status = options_parse(o, argc, argv, "cSjoMvRU", LOGS_MAX, error);
    if (!status) status = options_measured(o, error);
    if (status) return status;
    if (!o->measured_count || !o->config || !o->output)
        return error_set(error, STATUS_USAGE, "`hexid gap` needs a LOG, -c FILE and -o DIR; see `hexid gap --help`");
    *g = (struct gap_options){.replay = GAP_AS_KNOWN, .simulate = true, .progress = progress};
    g->threads = (int)sysconf(_SC_NPROCESSORS_ONLN);
    if (!o->replay) return STATUS_OK;
    g->replay = !strcmp(o->replay, "motion") ? GAP_MOTION : GAP_CLOSED_LOOP;
    if (g->replay == GAP_MOTION || !strcmp(o->replay, "closed-loop")) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "--replay %s: choose closed-loop or motion", o->replay);
}

static int load(const struct options *o, int logs, const char *const *path, int run, struct gap_logs *g, struct error *error) {
    gap_left_out left_out;
    int status = gap_logs_load(o, logs, path, run, g, left_out, error);
    for (int i = 0; i < logs && !status; i++)
        if (left_out[i][0])
            cli_say(stderr, "hexid: warning: %.250s: excluded, because %s: test %s", path[i], refusals[REFUSED_EMPTY].why, left_out[i]);
    const struct admission *a = &g->admission;
    if (!status && a->excluded)
        cli_say(stderr, "hexid: warning: %d record%s of several excluded: %s", a->excluded, a->excluded == 1 ? "" : "s", a->exclusion.text);
    return status;
}

/* Refuses the log of --validate if it is one of the measured logs or a copy of one, because those
 * are fitted. */
static int other_log(const struct options *o, struct error *error) {
    const char *all[LOGS_MAX + 1];
    memcpy(all, o->measured, sizeof o->measured);
    all[o->measured_count] = o->validate;
    return log_set_new(o->measured_count, all, error);
}

static int run(int argc, char **argv, struct params *params, struct gap_logs *measured, struct gap_logs *validate,
               struct gap_result *result, struct waves *closed_loop, struct error *error) {
    struct options o;
    struct gap_options g;
    struct output json;
    int status = options(&o, &g, argc, argv, error);
    if (!status) status = options_params(&o, params, error);
    gap_logs_init(measured, params);
    gap_logs_init(validate, params);
    const struct recording *recording = &measured->measured.recording, *other = &validate->measured.recording;
    if (!status) status = outputs_open(&o, NULL, OUTPUTS_MODEL, NULL, NULL, error);
    if (!status && o.validate) status = other_log(&o, error);
    if (!status) status = load(&o, o.measured_count, o.measured, o.run, measured, error);
    if (!status && o.validate) status = load(&o, 1, &o.validate, 0, validate, error);
    if (!status) status = gap_files_check(&o, &json, error);
    if (!status) status = gap_solve(params, recording, o.validate ? other : NULL, &g, result, closed_loop, error);
    if (status) return status;
    progress(NULL, "drawing the report", 0.95);
    status = gap_files_write(&o, &json, result, recording, closed_loop, error);
    progress(NULL, status ? "not reported" : "reported", 1.0);
    gap_files_publish(params, result);
    FILE *out = o.json && !strcmp(o.json, "-") ? stderr : stdout;
    gap_text_print(out, result);
    if (!status) cli_say(out, "  report    %s/report.html", o.output);
    if (!status) cli_say(out, "  model     %s/model.yaml", o.output);
    return status;
}

int cmd_gap(int argc, char **argv) {
    struct error error;
    struct params *params = calloc(1, sizeof *params);
    struct gap_result *result = calloc(1, sizeof *result);
    struct gap_logs *logs = calloc(2, sizeof *logs);
    struct waves closed_loop = {0};
    int status = error_set(&error, STATUS_IO, "out of memory");
    if (params && result && logs) status = run(argc, argv, params, &logs[0], &logs[1], result, &closed_loop, &error);
    if (logs) gap_logs_free(&logs[0]), gap_logs_free(&logs[1]);
    waves_free(&closed_loop);
    free(params);
    free(result);
    free(logs);
    return status ? cli_fail(&error) : EXIT_PASSED;
}
