/* hexid gap: logs in, diagnosis, files out. */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli.h"
#include "gap.h"
#include "gap_files.h"
#include "gap_text.h"
#include "log.h"
#include "messages.h"

_Static_assert((int)LOGS_MAX <= (int)RECORDING_RUNS, "a run a log");

/* What a recording has to say, of which log it says it. */
static int of_log(const char *path, int status, struct error *error) {
    if (!status) return STATUS_OK;
    struct error reason = *error;
    return error_set(error, status, "%.100s: %.280s", path, reason.text);
}

/* The log's own configuration: it tells a platform from an axis, and another log's tests, whose frequency and amplitudes are not the model's.
 * The first log may have none, or one that is no longer understood. */
static int begin(const char *path, const struct log_event *event, struct recording *r, struct error *error) {
    static const char *const machine[] = {[MECHANISM_STEWART] = "six legs", [MECHANISM_AXIS] = "one axis"};
    struct params *own = calloc(1, sizeof *own);
    if (!own) return error_set(error, STATUS_IO, "%.250s: out of memory", path);
    int status = cli_log_params(path, event, "which tests it has is not known", own, error);
    if (!status && own->mechanism != r->params->mechanism)
        status = error_set(error, STATUS_USAGE, "%.250s: is of %s, the configuration of -c of %s (mechanism)", path,
                           machine[own->mechanism], machine[r->params->mechanism]);
    else if (!r->tests) status = STATUS_OK;
    else if (!status) status = of_log(path, recording_begin(r, &own->tests, error), error);
    free(own);
    return status;
}

static int add(const char *path, struct recording *r, struct error *error) {
    struct log_reader *log;
    struct log_event event;
    struct cycle cycle;
    int64_t offset;
    int status = log_open(&log, path, error);
    if (status) return status;
    for (bool first = true; !status && log_next(log, &event); first = false) {
        if (first) status = begin(path, &event, r, error);
        if (!status && !strcmp(event.channel, CHANNEL_STATE) && state_decode(event.data, event.size, &cycle))
            status = of_log(path, recording_add(r, &cycle, error), error);
    }
    if (!status && log_cut(log, &offset)) cli_warn_cut(path, offset);
    log_release(log);
    return status;
}

/* The same data twice would count twice. */
static bool given_before(int logs, const char *const *path) {
    struct stat now, before;
    bool same = false;
    for (int i = 0; i < logs && !stat(path[logs], &now); i++)
        same = same || (!stat(path[i], &before) && before.st_dev == now.st_dev && before.st_ino == now.st_ino);
    return same;
}

/* All logs of one machine. */
static int load(int logs, const char *const *path, struct recording *r, struct error *error) {
    for (int i = 0; i < logs; i++) {
        if (given_before(i, path)) return error_set(error, STATUS_USAGE, "--measured %.250s: given twice; name each log once", path[i]);
        int tests = r->tests, status = add(path[i], r, error);
        if (!status && r->tests == tests) status = error_set(error, STATUS_USAGE, "%.250s: no sinusoidal test in the log", path[i]);
        if (!status) status = of_log(path[i], recording_check(r, error), error);
        if (status) return status;
    }
    return STATUS_OK;
}

static void progress(void *context, const char *step, double share) {
    (void)context;
    if (isatty(STDERR_FILENO)) fprintf(stderr, "\r\033[Kgap: %3.0f %% %s%s", 100.0 * share, step, share >= 1.0 ? "\r\033[K" : "");
    else fprintf(stderr, "gap: %s\n", step);
}

static int options(struct options *o, struct gap_options *g, int argc, char **argv, struct error *error) {
    int status = options_parse(o, argc, argv, "cSjoMvR", 0, error);
    if (status) return status;
    if (!o->measured_count || !o->config || !o->output)
        return error_set(error, STATUS_USAGE, "`hexid gap` needs --measured LOG, -c FILE and -o DIR; see `hexid gap --help`");
    *g = (struct gap_options){.replay = GAP_CLOSED_LOOP, .simulate = true, .progress = progress};
    g->threads = (int)sysconf(_SC_NPROCESSORS_ONLN);
    if (!o->replay || !strcmp(o->replay, "closed-loop")) return STATUS_OK;
    g->replay = GAP_MOTION;
    if (!strcmp(o->replay, "motion")) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "--replay %s: choose closed-loop or motion", o->replay);
}

static int run(int argc, char **argv, struct params *params, struct recording *measured, struct recording *validate,
               struct gap_result *result, struct error *error) {
    struct options o;
    struct gap_options g;
    int status = options(&o, &g, argc, argv, error);
    if (!status) status = options_params(&o, params, error);
    recording_init(measured, params);
    recording_init(validate, params);
    if (!status) status = load(o.measured_count, o.measured, measured, error);
    if (!status && o.validate) status = load(1, &o.validate, validate, error);
    if (!status) status = gap_files_check(&o, error);
    if (!status) status = gap_solve(params, measured, o.validate ? validate : NULL, &g, result, error);
    if (status) return status;
    progress(NULL, "drawing the report", 0.95);
    status = gap_files_write(&o, result, measured, error);
    progress(NULL, status ? "not reported" : "reported", 1.0);
    gap_files_publish(params, result);
    FILE *out = o.json && !strcmp(o.json, "-") ? stderr : stdout;
    gap_text_print(out, result);
    if (!status) fprintf(out, "  report    %s/report.html\n  model     %s/model.yaml\n", o.output, o.output);
    return status;
}

int cmd_gap(int argc, char **argv) {
    struct error error;
    struct params *params = calloc(1, sizeof *params);
    struct gap_result *result = calloc(1, sizeof *result);
    struct recording *recording = calloc(2, sizeof *recording);
    int status = error_set(&error, STATUS_IO, "out of memory");
    if (params && result && recording) status = run(argc, argv, params, &recording[0], &recording[1], result, &error);
    if (recording) recording_free(&recording[0]), recording_free(&recording[1]);
    free(params);
    free(result);
    free(recording);
    return status ? cli_fail(&error) : EXIT_PASSED;
}
