#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "config.h"
#include "csv.h"
#include "csv_format.h"
#include "csv_stated.h"
#include "log.h"
#include "log_runs.h"
#include "messages.h"
#include "number_text.h"
#include "params.h"
#include "units.h"

enum { PATH_SIZE = 4096 };

struct export {
    const char *log_path, *directory;
    struct params params;
    bool configured;       /* params come from the log */
    struct test_params configured_tests;
    char *config;          /* text of the log's configuration; NULL: none has come yet */
    FILE *file;            /* file of the current test; NULL: there is none */
    char path[PATH_SIZE];
    struct cycle last;
    double step_s;         /* shortest step between two rows; a longer step may be due to lost
                            * records */
    struct csv_report *report;
    struct error *error;
};

static int unwritable(struct export *e) {
    return error_set(e->error, STATUS_IO, "%.250s: cannot be written: %s", e->path, strerror(errno));
}

/* Makes the directory. Refuses one with CSV files: nothing is overwritten, and an earlier export's
 * files would be taken for files of this export. */
static int make_directory(const char *directory, struct error *error) {
    struct dirent **files;
    if (mkdir(directory, 0777) && errno != EEXIST)
        return error_set(error, STATUS_IO, "%.250s: cannot make the directory: %s", directory, strerror(errno));
    int count = csv_list(directory, &files);
    csv_list_free(files, count);
    if (count < 0) return error_set(error, STATUS_IO, "%.250s: cannot be read: %s", directory, strerror(errno));
    return count ? error_set(error, STATUS_IO, "%.250s: has CSV files already; name a directory without", directory) : STATUS_OK;
}

static FILE *create(struct export *e) { return fopen(e->path, "wx"); }

/* Writes a file's head. It has a fixed length, so that it can be rewritten when the rate is
 * known. */
static void write_head(struct export *e) {
    char number[NUMBER_SIZE];
    double period_s = e->params.loop.period_s;
    double rate_hz = isfinite(e->step_s) ? 1.0 / e->step_s : 1.0 / period_s;
    if (e->params.mechanism) fprintf(e->file, "# mechanism: %s\n", params_mechanism(&e->params)->name);
    fprintf(e->file, "# dof: %s\n# rate_hz: %-24.10g\n", csv_dof_name(e->last.dof), rate_hz);
    for (int key = 0; key < CSV_KEYS && e->configured && e->last.dof != DOF_NONE; key++) {
        const double *value = csv_place(&e->params, (enum csv_key)key, e->last.dof);
        bool stated = value && config_states(e->config, strlen(e->config), csv_config_key((enum csv_key)key, e->last.dof));
        if (stated) fprintf(e->file, "# %s: %s\n", csv_keys[key], number_shortest(*value, number));
    }
}

static void write_row(struct export *e, const struct cycle *c) {
    char text[NUMBER_SIZE];
    for (int i = 0; i < CSV_COLUMNS; i++) {
        const void *value = (const char *)c + csv_columns[i].offset;
        if (!csv_column_of(i, params_mechanism(&e->params))) continue;
        if (i) fputc(',', e->file);
        switch (csv_columns[i].kind) {
        case CSV_REAL: fputs(number_shortest(*(const double *)value, text), e->file); break;
        case CSV_FLAGS: fprintf(e->file, "%u", *(const uint32_t *)value); break;
        case CSV_PHASE: fprintf(e->file, "%d", *(const enum phase *)value); break;
        }
    }
    fputc('\n', e->file);
}

static int end_test(struct export *e) {
    if (!e->file) return STATUS_OK;
    bool written = fseek(e->file, 0, SEEK_SET) == 0;
    write_head(e);
    written = !ferror(e->file) && written;
    written = fclose(e->file) == 0 && written;
    e->file = NULL;
    return written ? STATUS_OK : unwritable(e);
}

static int begin_test(struct export *e, const struct cycle *c) {
    int status = end_test(e);
    if (status) return status;
    if (e->report->files == CSV_FILES_MAX)
        return error_set(e->error, STATUS_IO, "%.250s: more than %d tests, or cycles that are not in the order of their time", e->log_path,
                         CSV_FILES_MAX);
    snprintf(e->path, sizeof e->path, "%.3000s/%d_%s.csv", e->directory, ++e->report->files, csv_dof_name(c->dof));
    e->file = create(e);
    if (!e->file) return unwritable(e);
    e->last = *c;
    e->step_s = (double)INFINITY;
    write_head(e);
    for (int i = 0; i < CSV_COLUMNS; i++)
        if (csv_column_of(i, params_mechanism(&e->params))) fprintf(e->file, "%s%s", i ? "," : "", csv_columns[i].name);
    fputc('\n', e->file);
    return STATUS_OK;
}

/* Exports a cycle. A cycle outside every test ends the current file. Another test or axis, or a
 * time that does not increase (a second run), begins another file. */
static int take(struct export *e, const struct cycle *c) {
    bool same = e->file && c->test == e->last.test && c->dof == e->last.dof && c->test_time_s > e->last.test_time_s;
    int status = c->test < 0 ? end_test(e) : same ? STATUS_OK : begin_test(e, c);
    if (status || c->test < 0) return status;
    if (same) e->step_s = fmin(e->step_s, c->test_time_s - e->last.test_time_s);
    if (same && c->seq > e->last.seq) e->report->lost = add_saturated(e->report->lost, cycles_between(e->last.seq, c->seq));
    e->last = *c;
    e->report->rows++;
    write_row(e, c);
    return ferror(e->file) ? unwritable(e) : STATUS_OK;
}

/* Writes the configuration. Joined parts of a run repeat it, since each part begins with it. */
static int take_config(struct export *e, const char *text, size_t length) {
    /* if the text cannot be parsed, because another version wrote it, it is exported all the same,
     * but the files' heads lack its values */
    struct error ignored;
    if (e->config && strlen(e->config) == length && !memcmp(e->config, text, length)) return STATUS_OK;
    if (e->config)
        return error_set(e->error, STATUS_IO, "%.250s: has two configurations, so it is of two runs: export each by itself", e->log_path);
    if (!(e->config = strndup(text, length))) return error_set(e->error, STATUS_IO, "out of memory");
    e->configured = config_parse(&e->params, text, length, "config.yaml", &ignored) == STATUS_OK;
    e->configured_tests = e->params.tests;
    snprintf(e->path, sizeof e->path, "%.3000s/config.yaml", e->directory);
    FILE *file = create(e);
    if (!file) return unwritable(e);
    bool written = fwrite(text, 1, length, file) == length;
    written = fclose(file) == 0 && written;
    return written ? STATUS_OK : unwritable(e);
}

/* Takes the frequency or amplitude that an imported file stated, which goes into the head of the
 * new file again. */
static int take_stated(struct export *e, const struct log_event *event) {
    struct csv_stated stated;
    if (!csv_stated_decode(event->data, event->size, &stated)) return STATUS_OK;
    int status = end_test(e);
    csv_stated_take(&stated, &e->configured_tests, &e->params.tests);
    return status;
}

static int take_event(struct export *e, const struct log_event *event) {
    struct cycle cycle;
    const char *text;
    size_t length;
    if (strcmp(event->channel, CHANNEL_EVENT) == 0 && event_decode_config(event->data, event->size, &text, &length))
        return take_config(e, text, length);
    if (strcmp(event->channel, CHANNEL_EVENT) == 0) return take_stated(e, event);
    if (strcmp(event->channel, CHANNEL_STATE) != 0) return STATUS_OK;
    if (state_decode(event->data, event->size, &cycle)) return take(e, &cycle);
    e->report->unreadable++;
    return STATUS_OK;
}

static int export_events(struct export *e, struct log_reader *log, const char *log_path) {
    struct log_event event;
    int status = STATUS_OK, ended;
    while (!status && log_next(log, &event)) status = take_event(e, &event);
    ended = end_test(e);
    e->report->cut = log_cut(log, &e->report->cut_offset);
    if (status || ended) return status ? status : ended;
    if (e->report->files) return STATUS_OK;
    return error_set(e->error, STATUS_IO, "%.250s: has no test in it, so there is nothing to export", log_path);
}

int csv_export(const char *log_path, int run, const char *directory, struct csv_report *report, struct error *error) {
    struct log_reader *log;
    struct export e = {.log_path = log_path, .directory = directory, .report = report, .error = error};
    *report = (struct csv_report){0};
    config_default(&e.params);
    int status = log_open_run(&log, log_path, run, error);
    if (status) return status;
    status = make_directory(directory, error);
    if (!status) status = export_events(&e, log, log_path);
    free(e.config);
    log_release(log);
    return status;
}
