#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "combination.h"
#include "config.h"
#include "log_analysis.h"
#include "log_set.h"
#include "model_file.h"
#include "outputs.h"

_Static_assert((int)OPERANDS_MAX <= (int)AGREEMENT_LOGS, "each operand is a log");

/* Identifies from one log and frees its samples. survey: gets the results if the log is of a
 * survey; NULL: they are not needed. */
static int identify(const struct options *o, const char *path, struct log_analysis *i, struct loop_survey *survey, struct error *error) {
    struct multisine motion;
    int status = log_analysis_read(i, o, path, error);
    survey = survey && machine_found_is_survey(&i->params) ? survey : NULL;
    if (!status && survey) status = multisine_init(&motion, &i->params, error);
    if (!status && survey) status = loop_survey(survey, &motion, &i->analysis.recording, &i->analysis.ident.result.method_c, error);
    log_analysis_free(i);
    return status;
}

static FILE *out_of(const struct options *o) { return o->json && !strcmp(o->json, "-") ? stderr : stdout; }

static int exit_status(const struct verdict *v) { return v->status == VERDICT_PASS ? EXIT_PASSED : EXIT_CHECK_FAILED; }

/* Compares a known weight with the readings of two logs, i[0] without and i[1] with it, and
 * identifies i[0] again with the sensor errors that the weight shows. */
static int weigh(const struct options *o, struct log_analysis *i, struct error *error) {
    static const char *const machine[] = {"mechanism", "geometry", "actuator", NULL};
    const struct identification *first = &i[0].analysis.ident.result;
    struct config_difference d;
    const struct weighing_log log[] = {{&i[0].analysis.weighing, &first->rest},
                                       {&i[1].analysis.weighing, &i[1].analysis.ident.result.rest}};
    struct weighing_found found;
    if (!first->method_c.matrix.evaluated)
        return error_set(error, STATUS_USAGE, "--weight: %.100s gives no matrix: %.200s", o->operand[0], first->no_method_c.text);
    int status = log_set_new(1, o->operand, error);
    if (!status) status = identify(o, o->operand[1], &i[1], NULL, error);
    if (!status && config_difference(&i[0].params, &i[1].params, machine, &d))
        status = error_set(error, STATUS_USAGE, "%.100s: is of another machine than %.100s: %s is %.60s there", o->operand[0],
                           o->operand[1], d.key, d.b);
    if (!status)
        status = weighing_find(&log[0], &log[1], &i[0].params, (struct weight){o->weight_kg, o->weight_std_kg},
                               &i[0].analysis.ident.result.method_c, &found, error);
    if (status) return status;
    analysis_weigh(&i[0].analysis, &found);
    i[0].verdicts = analysis_verdicts(&i[0].analysis);
    return STATUS_OK;
}

/* Returns the configuration, corrected by the sensor errors that were found, as YAML, which the
 * caller frees. Its tests are log_analysis.configured, not the tests with which the log was
 * evaluated. NULL: out of memory. */
static char *calibrated_text(const struct log_analysis *i) {
    struct params *calibrated = malloc(sizeof *calibrated);
    if (!calibrated) return NULL;
    *calibrated = i->analysis.calibrated;
    calibrated->tests = i->configured;
    char *text = config_text(calibrated);
    free(calibrated);
    return text;
}

/* Evaluates one log. With --weight a second log of the same machine is used for the weighing
 * only. */
static int one_log(const struct options *o, struct log_analysis *i, struct output *json, struct output *config, struct error *error) {
    struct method_c *found = &i->analysis.ident.result.method_c;
    struct loop_survey survey = {0};
    const struct log_analysis *l = i;
    int status = identify(o, o->operand[0], i, o->model ? &survey : NULL, error);
    if (!status && o->weight_kg > 0.0) status = weigh(o, i, error);
    if (!status && o->pose_given) status = method_c_at_pose(found, &i->params, o->pose, error);
    if (status) return status;
    analysis_print(&i->analysis, &i->verdicts, false, out_of(o));
    status = output_made(json, analysis_json(&i->analysis, &i->verdicts), error);
    if (!status && o->model)
        status = model_file_write(&(struct model_file){.name = o->model,
                                                       .log = o->operand[0],
                                                       .params = &l->analysis.calibrated,
                                                       .tests = &l->configured,
                                                       .method_c = found,
                                                       .estimate = &l->analysis.estimate,
                                                       .survey = survey.multisine.tones ? &survey : NULL,
                                                       .verdict = &l->verdicts.run},
                                  config, out_of(o), error);
    else if (!status && o->output) status = output_made(config, calibrated_text(i), error);
    return status ? status : exit_status(&i->verdicts.run);
}

/* Evaluates each log; all must be of one machine and give a matrix. survey: gets the results of the
 * last log that is of a survey. */
static int each_log(const struct options *o, struct log_analysis *i, struct loop_survey *survey, struct error *error) {
    int status = STATUS_OK;
    for (int l = 0; l < o->operands && !status; l++) status = log_set_new(l, o->operand, error);
    for (int l = 0; l < o->operands && !status; l++) {
        const struct identification *r = &i[l].analysis.ident.result;
        status = identify(o, o->operand[l], &i[l], survey, error);
        if (!status && l) status = log_set_same_machine(o->operand[l], &i[l].params, o->operand[0], &i[0].params, error);
        if (!status && !r->method_c.matrix.evaluated)
            status = error_set(error, STATUS_USAGE, "%.100s: cannot be combined with others: %.200s; leave it out", o->operand[l],
                               r->no_method_c.text);
    }
    return status;
}

/* Solves method C with the equations of all logs, and compares the logs' own solutions. all: gets
 * the common solution. */
static int combine(struct combination *c, const struct log_analysis *i, struct estimate *all, struct error *error) {
    struct equations *sum = calloc(1, sizeof *sum);
    struct agreement_log log[AGREEMENT_LOGS];
    int status = sum ? STATUS_OK : error_set(error, STATUS_IO, "out of memory");
    for (int l = 0; l < c->logs && !status; l++) {
        equations_add(sum, &i[l].analysis.equations);
        log[l] = (struct agreement_log){
            .equations = &i[l].analysis.equations, .estimate = &i[l].analysis.estimate, .result = &i[l].analysis.ident.result.method_c};
    }
    if (!status) status = method_c_solve(sum, &i[0].analysis.calibrated, all, &c->all, error);
    if (!status)
        c->method_c = method_c_verdict(&(struct method_c_findings){
            .result = &c->all, .equations = sum, .estimate = all, .nominal = i[0].analysis.ident.result.nominal_mt});
    if (!status) c->common_gain = calibration_common_gain(&i[0].analysis.calibrated, sum->systematic);
    if (!status) status = agreement_find(c->logs, log, &i[0].analysis.calibrated, &c->agreement, error);
    free(sum);
    return status;
}

static int several_logs(const struct options *o, struct log_analysis *i, struct output *json, struct output *config, struct error *error) {
    struct combination c = {.logs = o->operands};
    struct loop_survey survey = {0};
    struct estimate *all = calloc(1, sizeof *all);
    int status = all ? each_log(o, i, &survey, error) : error_set(error, STATUS_IO, "out of memory");
    for (int l = 0; l < c.logs && !status; l++)
        c.log[l] = (struct combination_log){.path = o->operand[l],
                                            .id = &i[l].analysis.ident.result,
                                            .verdicts = &i[l].verdicts,
                                            .loop = analysis_statistics(&i[l].analysis)};
    if (!status) status = combine(&c, i, all, error);
    if (!status && o->pose_given) status = method_c_at_pose(&c.all, &i[0].params, o->pose, error);
    if (!status) {
        c.verdict = combination_verdict(&c);
        combination_table_print(out_of(o), &c);
        status = output_made(json, combination_json(&c), error);
    }
    if (!status && o->model)
        status = model_file_write(&(struct model_file){.name = o->model,
                                                       .log = o->operand[0],
                                                       .params = &i[0].analysis.calibrated,
                                                       .tests = &i[0].configured,
                                                       .method_c = &c.all,
                                                       .estimate = all,
                                                       .survey = survey.multisine.tones ? &survey : NULL,
                                                       .verdict = &c.verdict},
                                  config, out_of(o), error);
    free(all);
    return status ? status : exit_status(&c.verdict);
}

int cmd_identify(int argc, char **argv) {
    struct options o;
    struct output json, config;
    struct error error;
    int status = options_parse(&o, argc, argv, "cSjPUwoO", OPERANDS_MAX, &error);
    if (!status && !o.operands) status = error_set(&error, STATUS_USAGE, "identify: name a log; see `hexid identify --help`");
    bool several = o.operands > 1 && !(o.weight_kg > 0.0);
    if (!status && several && o.output)
        status = error_set(&error, STATUS_USAGE, "identify: -o takes what one log found about its sensors, or two with --weight");
    if (!status && o.model && o.output)
        status = error_set(&error, STATUS_USAGE, "identify: -o and --model: one of them; --model writes what -o writes, and more");
    if (!status && o.model) o.output = o.model;
    if (!status) status = outputs_open(&o, NULL, o.output ? OUTPUTS_PAGE : OUTPUTS_NONE, &json, &config, &error);
    struct log_analysis *i = status ? NULL : calloc((size_t)o.operands, sizeof *i);
    if (!status && !i) status = error_set(&error, STATUS_IO, "out of memory");
    if (!status) status = several ? several_logs(&o, i, &json, &config, &error) : one_log(&o, i, &json, &config, &error);
    free(i);
    return status < 0 ? cli_fail(&error) : status;
}
