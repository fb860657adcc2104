#include "model_file.h"

#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "config.h"

/* Sets tests.duration_s to its default, because a survey's log has the duration of the survey in
 * its place, and the configured duration is not known. */
static void forget_survey(struct machine_found *found) {
    struct params built_in;
    config_default(&built_in);
    found->params.tests.duration_s = built_in.tests.duration_s;
}

/* Checks that the configuration can be read again, because the values that were found may be
 * impossible. text: NULL if memory ran out. */
static int check(const char *text, const char *name, struct error *error) {
    struct params again;
    return text ? config_parse(&again, text, strlen(text), name, error) : error_set(error, STATUS_IO, "out of memory");
}

static void say_written(const struct model_file *m, const struct machine_found *found, FILE *out) {
    cli_say(out, "model     %s: %d keys found, each with its interval%s", m->name, found->notes,
            found->params.control.law == CONTROL_MODEL ? "" : "; --set control.law=model drives with them");
    for (int i = 0; i < found->kept; i++) cli_say(out, "          as configured: %s", found->kept_why[i]);
    if (!m->survey)
        cli_say(out, "          as configured: oil, valves' gains, leakage and delay, which a log of `hexid run --survey` shows");
}

static int write_found(const struct model_file *m, struct machine_found *found, struct output *to, FILE *out, struct error *error) {
    char head[300];
    machine_found(m->params, m->method_c, m->estimate, found);
    found->params.tests = *m->tests;
    bool of_survey = machine_found_is_survey(&found->params);
    if (m->survey) machine_found_survey(m->survey, found);
    if (of_survey) forget_survey(found);
    snprintf(head, sizeof head, "hexid identify %.200s --model: +- is a 95 %% interval", m->log);
    for (char *c = head; *c; c++)
        if ((unsigned char)*c < ' ') *c = '?'; /* the log's name must not end the YAML comment */
    char *text = config_text_noted(&found->params, head, found->note, found->notes);
    int status = check(text, m->name, error);
    if (status) {
        free(text);
        output_discard(to);
        return status;
    }
    status = output_made(to, text, error);
    if (!status) say_written(m, found, out);
    return status;
}

int model_file_write(const struct model_file *m, struct output *to, FILE *out, struct error *error) {
    if (m->verdict->status == VERDICT_FAIL || !m->method_c->matrix.evaluated) {
        cli_say(out, "model     %s not written: %s", m->name,
                m->verdict->status == VERDICT_FAIL ? "the verdict is fail, and nothing is driven with what failed"
                                                   : "method C has no result");
        output_discard(to);
        return STATUS_OK;
    }
    struct machine_found *found = malloc(sizeof *found);
    int status = found ? write_found(m, found, to, out, error) : error_set(error, STATUS_IO, "out of memory");
    free(found);
    return status;
}
