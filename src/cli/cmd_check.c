/* hexid check: examines a recording before it is used. */
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "analysis.h"
#include "areas.h"
#include "check_report.h"
#include "cli.h"
#include "config.h"
#include "csv_input.h"
#include "gap_logs.h"
#include "log.h"
#include "log_params.h"
#include "log_runs.h"
#include "messages.h"
#include "outputs.h"
#include "params.h"

enum { TESTS_MAX = CSV_FILES_MAX, PATH_SIZE = 64 };

/* A log that is checked: one named on the command line, or one imported from a directory or
 * file. */
struct input {
    const char *name;            /* the file's name on the command line */
    char copy[PATH_SIZE];        /* path of the imported log, an unnamed file that disappears with
                                  * the process; "": `name` itself is a log */
    struct csv_report csv;
};

struct check {
    struct options o;
    struct output json, page;
    int inputs;
    struct input *input;         /* array; a directory that is refused as a whole has one input for
                                  * each of its files */
    struct params params;        /* configuration of the current input */
    struct params first;         /* configuration of the first input */
    struct survey survey[TESTS_MAX];
    bool more;                   /* there are more tests than the TESTS_MAX that are kept */
    struct error refused;        /* why a directory is refused as a whole; status 0: it is not */
    struct check_report report;
    struct error *error;
};

static const char *path_of(const struct input *in) { return in->copy[0] ? in->copy : in->name; }

/* Removes the path of an unnamed log from a message, because the user gave no such path. */
static void without_path(const struct input *in, struct error *error) {
    size_t length = strlen(path_of(in));
    if (in->copy[0] && !strncmp(error->text, in->copy, length) && error->text[length] == ':')
        memmove(error->text, error->text + length + 2, strlen(error->text + length + 1));
}

static void join(char *list, size_t size, const char *more) {
    size_t used = strlen(list);
    if (*more) snprintf(list + used, size - used, "%s%s", used ? "; " : "", more);
}

static struct input *new_input(struct check *c, const char *name) {
    struct input *more = realloc(c->input, (size_t)(c->inputs + 1) * sizeof *more);
    if (!more) return NULL;
    c->input = more;
    more[c->inputs] = (struct input){.name = name};
    return &more[c->inputs++];
}

/* Imports a directory, or one of its files, into a temporary log that is unlinked at once, so that
 * no file remains even after a crash. */
static int import(struct check *c, const struct csv_source *source, int *found) {
    struct input *in = new_input(c, source->path);
    const char *directory = getenv("TMPDIR");
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%.4000s/hexid-check-XXXXXX", directory && *directory ? directory : "/tmp");
    int file = in ? mkstemp(path) : -1;
    if (file < 0 && in) c->inputs--;
    if (file < 0) return error_set(c->error, STATUS_IO, "%.300s: cannot be made, for the log of a directory", path);
    unlink(path);
    snprintf(in->copy, sizeof in->copy, "/proc/self/fd/%d", file);
    int status = csv_import(source, in->copy, &in->csv, c->error);
    *found = in->csv.found;
    if (status) {
        c->inputs--;
        close(file);
        return status;
    }
    cli_say_overruled(source->path, in->csv.overruled);
    if (in->csv.notes[0]) cli_say(stderr, "hexid: %s", in->csv.notes);
    join(c->report.zero, sizeof c->report.zero, in->csv.zero);
    join(c->report.missing, sizeof c->report.missing, in->csv.missing);
    join(c->report.ignored, sizeof c->report.ignored, in->csv.ignored);
    join(c->report.doubtful, sizeof c->report.doubtful, in->csv.doubtful);
    return STATUS_OK;
}

/* Imports each file of a directory by itself after the directory was refused as a whole, so that
 * one error, in a file or between two files, does not hide another. */
static int import_files(struct check *c, struct csv_source source, int files) {
    int unused, before = c->inputs;
    c->refused = *c->error;
    for (source.only = 1; source.only <= files; source.only++)
        if (import(c, &source, &unused)) cli_say(stderr, "hexid: %s", c->error->text);
    if (c->inputs > before && !csv_map_unseen(source.map)) return STATUS_OK;
    *c->error = c->refused;
    return c->refused.status;
}

static int import_directory(struct check *c, const char *name) {
    struct csv_input input;
    int found, status = csv_input_begin(&input, &c->o, name, c->error);
    if (status) return status;
    status = import(c, &input.source, &found);
    if (status == STATUS_USAGE && c->o.operands == 1 && found > 1) status = import_files(c, input.source, found);
    csv_input_end(&input);
    return status;
}

/* True for the name of a file that hexid import takes. */
static bool is_table(const char *name) {
    static const char *const ends[] = {".csv", ".tsv", ".txt", ".dat", ".mat", ".mcap"};
    const char *dot = strrchr(name, '.');
    for (size_t i = 0; i < sizeof ends / sizeof *ends && dot; i++)
        if (!strcasecmp(dot, ends[i])) return true;
    return false;
}

static int take_input(struct check *c, const char *name) {
    struct stat s;
    bool csv = is_table(name);
    if (!stat(name, &s) && (S_ISDIR(s.st_mode) || csv)) return import_directory(c, name);
    if (c->o.map) return error_set(c->error, STATUS_USAGE, "--map is for CSV files, and %.250s is none", name);
    return new_input(c, name) ? STATUS_OK : error_set(c->error, STATUS_IO, "out of memory");
}

/* Finds the configuration of an input. An imported log's own configuration already includes -c and
 * --set. */
static int read_params(struct check *c, const struct input *in, const struct log_event *event) {
    if (in->copy[0]) return log_params_own(in->name, event, "give one with -c FILE", &c->params, c->error);
    return log_params(&c->o, in->name, event, &c->params, NULL, c->error);
}

/* Place of the current cycle, and the survey (survey.h) that takes it. Each file of a directory, or
 * each test of a log, has a survey. */
struct place {
    int file;
    int64_t rows;      /* number of rows of the current file so far */
    int test;
    struct survey *survey;
};

static int begin_survey(struct check *c, const struct input *in, const struct cycle *cycle, struct place *p) {
    char name[SURVEY_NAME];
    const char *slash = strrchr(in->name, '/'), *axis = cycle->dof == DOF_NONE ? "none" : dof_names[cycle->dof];
    int status = p->survey ? survey_end(p->survey, &c->params, c->error) : STATUS_OK;
    p->survey = NULL;
    c->more = c->more || c->report.surveys == TESTS_MAX;
    if (status || c->more) return status;
    if (in->copy[0]) snprintf(name, sizeof name, "%s", in->csv.file[p->file].name);
    else if (c->o.operands == 1) snprintf(name, sizeof name, "%s", axis);
    else snprintf(name, sizeof name, "%s %.200s", axis, slash ? slash + 1 : in->name);
    p->survey = &c->survey[c->report.surveys++];
    survey_init(p->survey, &c->params, cycle->dof, name);
    return STATUS_OK;
}

/* Returns true if the test's time begins anew, as in a log of several files of one axis. That is
 * assumed if the time goes back by more than half of the test; single rows out of order go back
 * less. */
static bool begins_anew(const struct recording_test *t, const struct cycle *cycle) {
    enum { ROWS_LEAST = 10 };
    if (t->count < ROWS_LEAST) return false;
    double first_s = t->sample[0].test_time_s, last_s = t->sample[t->count - 1].test_time_s;
    return 2.0 * (last_s - cycle->test_time_s) > last_s - first_s;
}

static int add_cycle(struct check *c, const struct input *in, const struct cycle *cycle, struct place *p) {
    const struct recording_test *t = p->survey ? &p->survey->test : NULL;
    bool other = !t || cycle->test != p->test || cycle->dof != t->dof || begins_anew(t, cycle);
    if (cycle->test < 0) return STATUS_OK;
    if (in->copy[0]) {
        bool last = p->rows == in->csv.file[p->file].rows;
        if (last) p->file++, p->rows = 0;
        other = !t || last;
        p->rows++;
    }
    int status = other ? begin_survey(c, in, cycle, p) : STATUS_OK;
    p->test = cycle->test;
    return status || !p->survey ? status : survey_add(p->survey, &c->params, cycle, c->error);
}

static int read_cycles(struct check *c, const struct input *in, struct log_reader *log, struct analysis *analysis) {
    struct log_event event;
    struct cycle cycle;
    struct place place = {0};
    int64_t offset;
    if (!log_next(log, &event)) return error_set(c->error, STATUS_IO, "%s: not a log: no event in it", in->name);
    int status = read_params(c, in, &event);
    bool identifies = !status && !analysis_init(analysis, &c->params, &c->report.identify);
    if (!status && in == c->input) c->first = c->params;
    const struct test_params own = c->params.tests;
    do {
        /* NULL: nothing is reported here, because ask_gap() reports what --set overrules */
        log_params_follow(&c->o, NULL, &event, &own, &c->params.tests);
        if (status || strcmp(event.channel, CHANNEL_STATE) || !state_decode(event.data, event.size, &cycle)) continue;
        status = add_cycle(c, in, &cycle, &place);
        if (identifies) analysis_take(analysis, &cycle);
    } while (!status && log_next(log, &event));
    if (!status && place.survey) status = survey_end(place.survey, &c->params, c->error);
    if (identifies) analysis_end(analysis);
    if (log_cut(log, &offset)) cli_warn_cut(in->name, offset);
    if (status || !identifies || c->report.identify.status) return status;
    analysis_identify(analysis);
    if (analysis_identifies(analysis, in->name, &c->report.identify)) return STATUS_OK;
    struct verdict v = analysis_verdicts(analysis).run;
    const char *reason = v.reasons ? v.reason[0] : verdict_names[v.status];
    if (v.status == VERDICT_NOT_EVALUATED) error_set(&c->report.identify, STATUS_USAGE, "%s", reason);
    if (v.status == VERDICT_FAIL) snprintf(c->report.identify.text, sizeof c->report.identify.text, "verdict fail: %s", reason);
    return status;
}

static int survey_input(struct check *c, const struct input *in) {
    struct log_reader *log;
    struct analysis *analysis = calloc(1, sizeof *analysis);
    int status = analysis ? log_open_run(&log, path_of(in), in->copy[0] ? 0 : c->o.run, c->error)
                          : error_set(c->error, STATUS_IO, "out of memory");
    if (!status) {
        status = read_cycles(c, in, log, analysis);
        analysis_free(analysis);
        log_release(log);
    }
    free(analysis);
    return status;
}

/* Notes which tests were excluded, with the log's name if there are several logs. */
static void note_left_out(struct check *c, const struct input *in, const char *tests) {
    char words[CHECK_LIST_SIZE];
    snprintf(words, sizeof words, "%.250s: %.*s", in->name, GAP_LEFT_OUT_SIZE, tests);
    if (*tests) join(c->report.left_out, sizeof c->report.left_out, c->inputs > 1 ? words : tests);
}

/* Loads the logs as `hexid gap` does, and stores in c->report.gap whether it would refuse them. */
static void ask_gap(struct check *c) {
    gap_left_out left_out;
    const char *paths[LOGS_MAX];
    struct gap_logs *logs = calloc(1, sizeof *logs);
    if (!logs) {
        error_set(&c->report.gap, STATUS_IO, "out of memory");
        return;
    }
    gap_logs_init(logs, &c->first);
    for (int i = 0; i < c->inputs && i < LOGS_MAX; i++) paths[i] = path_of(&c->input[i]);
    if (gap_logs_load(&c->o, c->inputs, paths, c->o.run, logs, left_out, &c->report.gap) == STATUS_OK) c->report.gap = (struct error){0};
    for (int i = 0; i < c->inputs; i++) note_left_out(c, &c->input[i], left_out[i]);
    for (int i = 0; i < c->inputs; i++) without_path(&c->input[i], &c->report.gap);
    gap_logs_free(logs);
    free(logs);
}

static void note_areas(struct check *c) {
    bool pressures = false;
    for (int i = 0; i < c->report.surveys; i++)
        pressures = pressures || (c->survey[i].channel[SURVEY_P1].there && c->survey[i].channel[SURVEY_P2].there);
    if (!pressures) return;
    areas_text(&c->first, c->report.areas);
    config_defaults(&c->first, c->report.defaults);
}

static int report(struct check *c) {
    struct check_report *r = &c->report;
    note_areas(c);
    r->source = c->o.operand, r->sources = c->o.operands;
    if (c->refused.status) r->gap = r->identify = c->refused;
    else ask_gap(c);
    check_text_print(c->o.json && !strcmp(c->o.json, "-") ? stderr : stdout, r);
    if (c->more) cli_say(stderr, "hexid: warning: more than %d tests: the others are not shown", TESTS_MAX);
    int status = c->o.json ? output_made(&c->json, check_json(r), c->error) : STATUS_OK;
    if (!c->o.output) return status;
    struct error unsaid, *error = status ? &unsaid : c->error;
    char *page;
    int drawn = check_html(r, &page, error);
    drawn = output_page(&c->page, drawn, page, error);
    return status ? status : drawn;
}

static int check(struct check *c, int argc, char **argv) {
    struct options *o = &c->o;
    int status = options_parse(o, argc, argv, "coSjaU", LOGS_MAX, c->error);
    if (!status && !o->operands)
        status = error_set(c->error, STATUS_USAGE, "check: name a log or a directory of CSV files; see `hexid check --help`");
    if (!status) status = outputs_open(o, NULL, OUTPUTS_PAGE, &c->json, &c->page, c->error);
    for (int i = 0; i < o->operands && !status; i++) status = take_input(c, o->operand[i]);
    for (int i = 0; i < c->inputs && !status; i++) status = survey_input(c, &c->input[i]);
    if (!status && !c->report.surveys)
        status = error_set(c->error, STATUS_USAGE, "%.250s: no test in the log: nothing was recorded but what lies between tests",
                           o->operand[0]);
    return status ? status : report(c);
}

int cmd_check(int argc, char **argv) {
    struct error error = {0};
    struct check *c = calloc(1, sizeof *c);
    int status = error_set(&error, STATUS_IO, "out of memory");
    if (c) {
        c->error = &error;
        c->report.survey = c->survey;
        status = check(c, argc, argv);
    }
    int taken = c && !c->report.gap.status ? EXIT_PASSED : EXIT_CHECK_FAILED;
    for (int i = 0; c && i < c->report.surveys; i++) survey_free(&c->survey[i]);
    if (c) free(c->input);
    free(c);
    return status ? cli_fail(&error) : taken;
}
