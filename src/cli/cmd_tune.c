/* `hexid tune`: the first gains of a machine, from its configuration alone. */
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "config.h"
#include "hal.h"
#include "loop_tune.h"
#include "mechanism.h"
#include "outputs.h"
#include "params.h"
#include "tune_report.h"
#include "version.h"

/* Returns the whole configuration with the gains that were found. The caller frees it. */
static char *tuned_text(const struct params *params, const struct loop_tune *t) {
    struct params tuned = *params;
    tuned.control = t->gains;
    return config_text_noted(&tuned,
                             t->reached ? "hexid tune: gains from the configuration alone"
                                        : "hexid tune: gains from the configuration alone, short of the margins",
                             NULL, 0);
}

static bool found(const struct loop_tune *t) { return t->gains.kp > 0.0; }

static int write_all(const struct options *o, struct output *file, struct output *json, const struct params *params,
                     const struct loop_tune *t, bool bus, struct error *error) {
    char installed[PATH_MAX];
    const char *config = o->config ? o->config : options_default_config(installed);
    int status = STATUS_OK;
    if (!found(t)) output_discard(file);
    else if (o->output) status = output_made(file, tuned_text(params, t), error);
    if (!status && o->json) status = output_made(json, tune_report_json(t, version, config, bus), error);
    return status;
}

static bool to_stdout(const char *name) { return name && !strcmp(name, "-"); }

/* Prints the report, on standard error if a result goes to standard output. */
static void print(const struct options *o, const struct params *params, const struct loop_tune *t) {
    FILE *out = to_stdout(o->json) || to_stdout(o->output) ? stderr : stdout;
    char missed[TUNE_MISS_SIZE];
    tune_report_print(out, t, params);
    tune_report_missed(t, params, missed);
    if (*missed) fprintf(out, "not reached: %s\n", missed);
    if (found(t)) tune_report_section(out, t);
    if (found(t) && o->output) cli_say(out, "written   %s", o->output);
}

static int tune(const struct options *o, const struct params *params, bool bus, struct error *error) {
    struct output file, json;
    struct loop_tune t;
    int status = outputs_open(o, params, OUTPUTS_PAGE, &json, &file, error);
    if (!status) status = loop_tune(params, bus, true, &t, error);
    if (!status) status = write_all(o, &file, &json, params, &t, bus, error);
    if (status) return status;
    print(o, params, &t);
    return t.reached ? EXIT_PASSED : EXIT_CHECK_FAILED;
}

int cmd_tune(int argc, char **argv) {
    struct options o;
    struct params params;
    struct error error;
    if (options_parse(&o, argc, argv, "cHSjo", 0, &error) || options_params(&o, &params, &error)) return cli_fail(&error);
    const char *last = strrchr(o.hal, ';');
    const struct hal_ops *ops = hal_find(last ? last + 1 : o.hal);
    int status = STATUS_OK;
    if (!ops) status = error_set(&error, STATUS_USAGE, "--hal %.200s: no such back-end; `hexid run --help` lists them", o.hal);
    else if (params_mechanism(&params)->refuses.run) status = error_set(&error, STATUS_USAGE, "%s", params_mechanism(&params)->refuses.run);
    if (!status) status = tune(&o, &params, !ops->simulated, &error);
    return status < 0 ? cli_fail(&error) : status;
}
