#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "areas.h"
#include "config.h"
#include "csv.h"
#include "csv_begin.h"
#include "csv_doubts.h"
#include "csv_foreign.h"
#include "csv_format.h"
#include "csv_stated.h"
#include "csv_table.h"
#include "csv_times.h"
#include "log.h"
#include "messages.h"
#include "number_text.h"
#include "output.h"
#include "params.h"
#include "units.h"

enum { EVENT_SIZE = 1 << 18 };

static const double rate_tolerance = 0.01;  /* largest relative difference between rate_hz and the
                                             * rate of t_s */
static const double rate_same = 1e-3; /* relative difference up to which two rates count as equal */
static const double step_least_s = 1e-4, step_most_s = 0.1; /* range of loop.period_s */
static const double gap_max_s = 3600.0;     /* longest gap between two rows: the limit of
                                             * tests.duration_s */

struct import {
    const struct csv_source *source;
    struct params params;
    bool configured;           /* a configuration was chosen: one in the directory, or
                                * csv_source.configured */
    int files;
    struct csv_head head[CSV_FILES_MAX];
    struct csv_head *part;     /* heads of the `parts` files that together are one test; NULL: each
                                * file is a test */
    int parts;
    struct csv_table *table[CSV_FILES_MAX]; /* table of a test whose rows cannot be taken as they
                                             * stand (csv_table.h); NULL: its rows are read from
                                             * the file */
    int test[CSV_FILES_MAX];   /* index of each file's test in the list of tests */
    struct csv_times times[CSV_FILES_MAX];
    struct csv_range range[CSV_FILES_MAX];
    int last_line[CSV_FILES_MAX];
    double zero_s[CSV_FILES_MAX]; /* t_s at which each file's ramp-in starts: 0, or found from the
                                   * motion */
    double evaluated_s;    /* shortest evaluated part of the files that do not state theirs */
    struct log_writer *log;
    uint64_t seq;          /* sequence number of the last cycle before the current file's first */
    int64_t start_ns;      /* start of the current file on the log's clock */
    struct csv_report *report;
    struct error *error;
};

static double period_s(const struct import *im) { return im->params.loop.period_s; }

/* Returns true if the head gives this key a value, and the value has a meaning: for a file without
 * a sinusoid only the rate has one. */
static bool gives(const struct csv_head *h, enum csv_key key) { return !isnan(h->value[key]) && (h->dof != DOF_NONE || key == CSV_RATE); }

/* Takes the mechanism from the first file; all others must agree. */
static int merge_mechanism(struct import *im, int file) {
    const struct csv_head *h = &im->head[file];
    const struct mechanism *has = mechanism_table[h->mechanism], *configured = params_mechanism(&im->params);
    if (has == configured) return STATUS_OK;
    if (file == 0 && configured->csv_column)
        return error_set(im->error, STATUS_USAGE, "%.200s:%d: no column %s: the configuration's mechanism is %s", h->path, h->columns_line,
                         configured->csv_column, configured->name);
    if (file == 0) {
        im->params.mechanism = h->mechanism;
        /* the configured diameters belong to another mechanism */
        im->params.actuator.stated.piston = im->params.actuator.stated.rod = false;
        return STATUS_OK;
    }
    return error_set(im->error, STATUS_USAGE, "%.200s:%d: %s, unlike %.60s: import them apart", h->path, h->columns_line,
                     has->words.machine, strrchr(im->head[0].path, '/') + 1);
}

/* Returns true if the axes a and b share the value of this key: the value in a file of one of them
 * then also counts for the other, unless a file of the other states its own. */
static bool shares(enum csv_key key, enum dof a, enum dof b) { return key == CSV_FREQUENCY || (a < DOF_PHI) == (b < DOF_PHI); }

/* Stores a value from a file's head. Files must agree, except on frequency and amplitude: the
 * configuration keeps those of the axis's first file, and hexid gap measures each test's own. */
static int merge(struct import *im, int file, enum csv_key key) {
    const struct csv_head *h = &im->head[file];
    double *place = csv_place(&im->params, key, h->dof);
    bool own = key == CSV_FREQUENCY || key == CSV_AMPLITUDE, first = own;
    for (int i = 0; i < file; i++) {
        const struct csv_head *other = &im->head[i];
        if (gives(other, key) && shares(key, h->dof, other->dof)) first = false;
        if (!gives(other, key) || csv_place(&im->params, key, other->dof) != place || other->value[key] == h->value[key]) continue;
        if (own) {
            im->report->several |= key == CSV_FREQUENCY;
            return STATUS_OK;
        }
        return error_set(im->error, STATUS_USAGE, "%.200s:%d: %s: %g, but %.60s has %g: the files of a run share it; import them apart",
                         h->path, h->line[key], csv_keys[key], h->value[key], strrchr(other->path, '/') + 1, other->value[key]);
    }
    for (int dof = DOF_X; dof < DOFS && first; dof++)
        if (shares(key, h->dof, (enum dof)dof)) *csv_place(&im->params, key, (enum dof)dof) = h->value[key];
    if (place) *place = h->value[key];
    return STATUS_OK;
}

/* Sets the loop's rate, keeps the step of the simulation, and raises limits.sensor_age_s to at
 * least one period. */
static void set_rate(struct params *p, double rate_hz) {
    double before_s = p->loop.period_s;
    if (!(fabs(rate_hz * before_s - 1.0) > 1e-6)) return; /* unchanged except for rounding */
    p->loop.period_s = 1.0 / rate_hz;
    p->sim.substeps = (int)ceil(p->sim.substeps * p->loop.period_s / before_s - 1e-9);
    p->limits.sensor_age_s = fmax(p->limits.sensor_age_s, p->loop.period_s);
}

/* Takes the rate from the time stamps if no rate is stated, or if the stated rate is off by up to
 * rate_tolerance; check_rate() refuses a larger difference. Rounded times look like lost rows of a
 * higher rate, so a stated rate is kept if its period lies between the usual and the mean step. A
 * rate outside a loop's range is not taken, because the unit of time must be wrong. */
static void take_rate(struct import *im) {
    const struct csv_times *t = &im->times[0];
    double now_s = period_s(im), off = now_s / t->step_s - 1.0;
    bool stated = gives(&im->head[0], CSV_RATE), between = now_s > t->step_s * (1.0 - rate_same) && now_s < t->mean_s * (1.0 + rate_same);
    bool keep = stated ? between || fabs(off) > rate_tolerance : fabs(off) <= rate_same;
    if (keep || !(t->step_s >= step_least_s && t->step_s <= step_most_s)) return;
    if (stated) im->report->stated_hz = im->head[0].value[CSV_RATE];
    set_rate(&im->params, 1.0 / t->step_s);
    im->report->rate_hz = 1.0 / t->step_s;
}

/* Appends "1_x.csv: words" to a list, after "; ", or nothing if there are no words. */
static void note(char *list, size_t size, const struct csv_head *h, const char *words) {
    size_t used = strlen(list);
    if (*words) snprintf(list + used, size - used, "%s%s: %s", used ? "; " : "", strrchr(h->path, '/') + 1, words);
}

static bool set_for(const struct import *im, enum csv_key key, enum dof dof) {
    const char *name = csv_config_key(key, dof);
    return name && config_sets(im->source->settings, im->source->setting_count, name);
}

/* Removes from the head the values that the command line also gives, and notes those that differ
 * from the command line's. */
static void overrule(struct import *im, struct csv_head *h) {
    char words[CSV_KEYS * (NUMBER_SIZE + 16)] = "", number[NUMBER_SIZE];
    for (int key = 0; key < CSV_KEYS; key++) {
        size_t used = strlen(words);
        if (!gives(h, (enum csv_key)key) || !set_for(im, (enum csv_key)key, h->dof)) continue;
        if (h->value[key] != *csv_place(&im->params, (enum csv_key)key, h->dof))
            snprintf(words + used, sizeof words - used, "%s%s %s", used ? ", " : "", csv_keys[key], number_shortest(h->value[key], number));
        h->value[key] = (double)NAN;
    }
    note(im->report->overruled, sizeof im->report->overruled, h, words);
}

static int merge_heads(struct import *im) {
    for (int file = 0; file < im->files; file++) {
        int status = merge_mechanism(im, file);
        if (status) return status;
        overrule(im, &im->head[file]);
        for (int key = 0; key < CSV_KEYS; key++) {
            struct csv_head *h = &im->head[file];
            status = gives(h, (enum csv_key)key) ? merge(im, file, (enum csv_key)key) : STATUS_OK;
            if (status) return status;
            if (key == CSV_RATE && gives(h, CSV_RATE)) set_rate(&im->params, h->value[key]);
        }
    }
    return STATUS_OK;
}

static int place_of(const struct test_params *t, enum dof dof) {
    for (int i = 0; i < t->count; i++)
        if (t->order[i] == dof) return i;
    return -1;
}

/* Gives each file its place in the list of tests. If the configuration's list lacks an axis of the
 * files, a new list is made from the files. Files without a sinusoid come last. */
static void place_tests(struct import *im) {
    struct test_params *t = &im->params.tests;
    int behind = DOFS;
    bool listed = true;
    for (int i = 0; i < im->files; i++) listed = listed && (im->head[i].dof == DOF_NONE || place_of(t, im->head[i].dof) >= 0);
    if (!listed) t->count = 0;
    for (int i = 0; i < im->files; i++) {
        enum dof dof = im->head[i].dof;
        if (dof != DOF_NONE && place_of(t, dof) < 0) t->order[t->count++] = dof;
        im->test[i] = dof == DOF_NONE ? behind++ : place_of(t, dof);
    }
    for (int i = t->count; i < DOFS; i++) t->order[i] = DOF_NONE;
}

/* Returns the phase at a time; boundaries are rounded to whole periods as in the reference, so that
 * exported tests come back with the same phases. */
static enum phase phase_at(const struct params *p, double t_s) {
    long long tick = llround(t_s / p->loop.period_s), ramp = llround(p->tests.ramp_s / p->loop.period_s);
    if (tick < 0) return PHASE_SETTLE;
    if (tick < ramp) return PHASE_RAMP_IN;
    return tick < ramp + llround(p->tests.duration_s / p->loop.period_s) ? PHASE_EVALUATE : PHASE_RAMP_OUT;
}

/* Compares the file's rate with the configuration's, which was taken from the head if it states
 * one. */
static int check_rate(struct import *im, int file) {
    const struct csv_head *h = &im->head[file];
    double step_s = im->times[file].step_s;
    bool given = !isnan(h->value[CSV_RATE]);
    if (!(step_s > 0.0) || fabs(step_s / period_s(im) - 1.0) <= rate_tolerance) return STATUS_OK;
    const char *unit = csv_time_unit(step_s, given ? period_s(im) : (double)NAN);
    const char *whose = given                       ? "rate_hz: "
                        : im->report->rate_hz > 0.0 ? "no rate_hz, and the first file's "
                                                    : "no rate_hz, and the configuration's ";
    return error_set(im->error, STATUS_USAGE, "%.200s:%d: %s%g Hz is not what t_s has: steps of %.6g s, %.6g Hz; %s", h->path,
                     given ? h->line[CSV_RATE] : h->columns_line, whose, 1.0 / period_s(im), step_s, 1.0 / step_s,
                     unit              ? unit
                     : im->table[file] ? "a channel is slower than the rows, and its clock is the log's: leave rate_hz out"
                                       : "give the true rate_hz");
}

static int add_time(struct import *im, int line, int file, double t_s) {
    struct csv_times *times = &im->times[file];
    const char *path = im->head[file].path;
    double last_s = times->rows ? times->t_s[times->rows - 1] : -HUGE_VAL;
    if (!isfinite(t_s)) return error_set(im->error, STATUS_USAGE, "%.180s:%d: t_s: %.15g: every row needs its time", path, line, t_s);
    if (!(t_s > last_s))
        return error_set(im->error, STATUS_USAGE,
                         "%.180s:%d: t_s: %.15g after %.15g: time must increase from row to row; sort the rows, leave doubles out", path,
                         line, t_s, last_s);
    if (times->rows && t_s - last_s > gap_max_s)
        return error_set(im->error, STATUS_USAGE, "%.180s:%d: t_s: %.15g after %.15g: too long a gap within one test", path, line, t_s,
                         last_s);
    return csv_times_add(times, t_s, im->error);
}

/* Writes a row; a grid point without a row leaves a gap in seq, as in hexid's own logs. */
static int write_row(struct import *im, int file, int64_t row, struct cycle *c) {
    unsigned char buffer[STATE_MESSAGE_MAX];
    const struct csv_head *h = &im->head[file];
    const struct csv_times *t = &im->times[file];
    c->seq = c->in.device_seq = im->seq + 1 + (uint64_t)(t->place[row] - t->place[0]);
    c->in.time_ns = im->start_ns + ns_from_seconds(t->t_s[row] - t->t_s[0]);
    c->test_time_s -= im->zero_s[file];
    c->test = im->test[file];
    c->dof = h->dof;
    if (!h->has[CSV_PHASE_COLUMN]) c->phase = h->dof == DOF_NONE ? PHASE_NONE : phase_at(&im->params, c->test_time_s);
    return log_write(im->log, c->in.time_ns / NS_PER_US, CHANNEL_STATE, buffer, state_encode(c, buffer), im->error);
}

/* Takes everything after the ramp-in as the evaluated part if the head does not state one. */
static int evaluate(struct import *im, int file) {
    const struct csv_head *h = &im->head[file];
    const struct csv_times *t = &im->times[file];
    double first_s = t->t_s[0] - im->zero_s[file], last_s = t->t_s[t->rows - 1] - im->zero_s[file];
    double begin_s = fmax(im->params.tests.ramp_s, first_s), evaluated_s = last_s + period_s(im) - begin_s;
    if (h->dof == DOF_NONE || !isnan(h->value[CSV_DURATION]) || h->has[CSV_PHASE_COLUMN]) return STATUS_OK;
    if (evaluated_s < period_s(im))
        return error_set(im->error, STATUS_USAGE, "%.250s:%d: nothing to evaluate: the last t_s is %g, and ramp_s is %g", h->path,
                         im->last_line[file], last_s, im->params.tests.ramp_s);
    im->evaluated_s = fmin(im->evaluated_s, evaluated_s);
    return STATUS_OK;
}

static int make_table(struct import *im, int file) {
    const struct csv_head one = im->head[file], *files = im->parts ? im->part : &one;
    int64_t empty;
    int status = csv_table_make(&im->table[file], &im->head[file], &empty, files, im->parts ? im->parts : 1, im->params.axis.middle_m,
                                im->source->map, im->report->notes, im->error);
    im->report->empty += empty;
    return status;
}

/* Reads a file to its last row. */
static int read_file(struct import *im, int file) {
    const struct csv_head *h = &im->head[file];
    struct csv_rows rows;
    struct cycle c;
    int got = 0, status = make_table(im, file);
    if (!status) status = csv_rows_open(&rows, h, im->table[file], im->source->map, im->error);
    if (status) return status;
    im->last_line[file] = h->columns_line;
    while (!status && (got = csv_rows_next(&rows, &c, im->error)) > 0) {
        if (rows.reader) im->last_line[file] = rows.reader->in.line;
        status = add_time(im, im->last_line[file], file, c.test_time_s);
        csv_range_take(&im->range[file], &c);
    }
    if (got < 0) status = got;
    csv_rows_close(&rows);
    if (!status && !im->times[file].rows)
        status = error_set(im->error, STATUS_USAGE, "%.250s:%d: no rows with a number follow the column names", h->path, h->columns_line);
    if (!status) status = csv_times_measure(&im->times[file], 1.0 / h->value[CSV_RATE], im->error);
    return status;
}

/* Finds t = 0, because a logger's time may start anywhere. If the times begin after the ramp-in or
 * end before it, the start is found from the motion. */
static int find_zero(struct import *im, int file) {
    const struct csv_head *h = &im->head[file];
    char words[40] = "";
    const struct csv_times *t = &im->times[file];
    bool own = t->t_s[0] <= im->params.tests.ramp_s && t->t_s[t->rows - 1] >= 0.0;
    if (h->dof == DOF_NONE || h->has[CSV_PHASE_COLUMN] || own) return STATUS_OK;
    int status = csv_begin_find(h, im->table[file], im->source->map, &im->params, &im->zero_s[file], im->error);
    if (im->zero_s[file] != 0.0) snprintf(words, sizeof words, "%.3f", im->zero_s[file]);
    if (!status) note(im->report->zero, sizeof im->report->zero, h, words);
    return status;
}

static int write_event(struct import *im, const char *kind, const char *text) {
    unsigned char *buffer = malloc(EVENT_SIZE);
    int size = buffer ? event_encode(im->start_ns, im->seq, kind, text, buffer, EVENT_SIZE) : -1;
    int status = size < 0 ? error_set(im->error, STATUS_IO, "out of memory")
                          : log_write(im->log, im->start_ns / NS_PER_US, CHANNEL_EVENT, buffer, size, im->error);
    free(buffer);
    return status;
}

static bool axis_stated(const struct import *im, enum dof dof, enum csv_key key) {
    for (int i = 0; i < im->files; i++)
        if (im->head[i].dof == dof && gives(&im->head[i], key)) return true;
    return false;
}

/* Writes the file's own frequency and amplitude into the log before its rows. If the file states
 * none but another file of its axis does, it writes NaN, so that an earlier file's value no longer
 * counts. */
static int write_stated(struct import *im, const struct csv_head *h) {
    static const enum csv_key key_of[CSV_STATED_KEYS] = {CSV_FREQUENCY, CSV_AMPLITUDE};
    char text[CSV_STATED_SIZE];
    int status = STATUS_OK;
    for (int i = 0; i < CSV_STATED_KEYS && !status; i++) {
        if (h->dof == DOF_NONE || !axis_stated(im, h->dof, key_of[i])) continue;
        csv_stated_text(&(struct csv_stated){(enum csv_stated_key)i, h->dof, h->value[key_of[i]]}, text);
        status = write_event(im, csv_stated_kind, text);
    }
    return status;
}

static int write_file(struct import *im, int file) {
    struct csv_rows rows;
    const struct csv_times *t = &im->times[file];
    struct cycle c;
    int status = csv_rows_open(&rows, &im->head[file], im->table[file], im->source->map, im->error);
    if (status) return status;
    status = write_stated(im, &im->head[file]);
    for (int64_t row = 0; row < t->rows && !status; row++) {
        int got = csv_rows_next(&rows, &c, im->error);
        status = got > 0 ? write_row(im, file, row, &c)
                 : got   ? got
                         : error_set(im->error, STATUS_IO, "%.250s: has become shorter meanwhile", im->head[file].path);
    }
    csv_rows_close(&rows);
    im->report->file[file].rows = t->rows;
    im->report->rows += t->rows, im->report->lost += csv_times_lost(t);
    im->seq += (uint64_t)csv_times_places(t);
    im->start_ns += ns_from_seconds(t->t_s[t->rows - 1] - t->t_s[0] + period_s(im));
    return status;
}

/* Takes a single axis's file that is too short for the ramp and two periods as any motion (dof
 * none), not as a test. As a test, its short evaluated part would make the configuration invalid,
 * and all other files would be refused, too. */
static void take_short(struct import *im, int file) {
    struct csv_head *h = &im->head[file];
    const struct csv_times *t = &im->times[file];
    const struct test_params *tests = &im->params.tests;
    bool stated = h->has_dof || gives(h, CSV_FREQUENCY) || h->has[CSV_PHASE_COLUMN] || mechanism_table[h->mechanism]->pose;
    if (stated || t->rows < 2 || t->t_s[t->rows - 1] - t->t_s[0] >= tests->ramp_s + 2.0 / tests->hz[DOF_X]) return;
    h->dof = DOF_NONE;
    csv_note(im->report->notes, "%.100s: shorter than tests.ramp_s, %g s, and two periods of tests.frequency_hz: taken as any motion",
             strrchr(h->path, '/') + 1, tests->ramp_s);
}

static int check_files(struct import *im) {
    int status = STATUS_OK;
    for (int i = 0; i < im->files && !status; i++) status = read_file(im, i);
    if (status) return status;
    csv_doubts(im->files, im->head, im->range, &im->params, im->report->doubtful);
    take_rate(im);
    for (int i = 0; i < im->files && !status; i++) {
        status = check_rate(im, i);
        take_short(im, i);
        if (!status) status = find_zero(im, i);
        if (!status) status = evaluate(im, i);
    }
    return status;
}

/* Reads the head of a text that was made from a file or, if `opened` is "", of the file itself. The
 * text may be only a part of a test. */
static int read_text_head(struct import *im, const char *path, const char *opened, const char *name) {
    struct csv_reader *reader;
    struct csv_head *h = &im->head[im->files];
    *h = (struct csv_head){0};
    snprintf(h->path, sizeof h->path, "%s", path);
    snprintf(h->opened, sizeof h->opened, "%s", opened);
    int status = csv_open_as(&reader, h, true, im->source->map, im->error);
    if (status) return status;
    *h = reader->head;
    csv_close(reader);
    snprintf(im->report->file[im->files].name, sizeof im->report->file->name, "%s", name);
    im->report->files = ++im->files;
    return STATUS_OK;
}

static int read_head(struct import *im, const char *directory, const char *name) {
    char path[CSV_PATH_SIZE];
    struct csv_texts texts;
    if (snprintf(path, sizeof path, "%s/%s", directory, name) >= (int)sizeof path)
        return error_set(im->error, STATUS_USAGE, "%.250s: too long a path", im->source->path);
    int status = csv_foreign_open(path, im->source->map, &texts, im->error);
    if (status) return status;
    if (im->files + texts.count > CSV_FILES_MAX)
        status = error_set(im->error, STATUS_USAGE, "%.250s: more than %d tests", im->source->path, CSV_FILES_MAX);
    if (texts.cut) csv_note(im->report->notes, "%.100s: cut off: read up to there", name);
    for (int i = 0; i < texts.count; i++) {
        if (!status) status = read_text_head(im, path, texts.opened[i], name);
        if (status) csv_foreign_close(texts.opened[i]);
    }
    return status;
}

/* Adds the columns and keys of a part of a test to those of the whole. */
static void unite(struct csv_head *whole, const struct csv_head *part) {
    if (part->has_dof) whole->dof = part->dof, whole->has_dof = true;
    if (part->mechanism == MECHANISM_AXIS) whole->mechanism = MECHANISM_AXIS;
    whole->speed |= part->speed, whole->turns |= part->turns, whole->slides |= part->slides;
    for (int i = 0; i < CSV_COLUMNS; i++) whole->has[i] = whole->has[i] || part->has[i];
    for (int i = 0; i < CSV_KEYS; i++)
        if (isnan(whole->value[i])) whole->value[i] = part->value[i], whole->line[i] = part->line[i];
    csv_list_missing(whole);
}

static bool has_channel(const struct csv_head *h) {
    bool any = false;
    for (int i = CSV_T + 1; i < CSV_COLUMNS; i++) any = any || h->has[i];
    return any;
}

static bool have_in_common(const struct csv_head *a, const struct csv_head *b) {
    bool both = a->mechanism != b->mechanism;
    for (int i = CSV_T + 1; i < CSV_COLUMNS; i++) both = both || (a->has[i] && b->has[i]);
    return both;
}

/* Returns true if the files are parts of one test: no two share a column except the time, and
 * together they have the position or, of a platform, the length of leg 1 and dof. whole: their
 * columns and keys together. */
static bool are_parts(const struct import *im, struct csv_head *whole) {
    int parts = 0;
    for (int file = 0; file < im->files; file++) {
        if (!has_channel(&im->head[file])) continue;
        if (parts && have_in_common(whole, &im->head[file])) return false;
        if (parts++) unite(whole, &im->head[file]);
        else *whole = im->head[file];
    }
    bool axis = parts && whole->mechanism == MECHANISM_AXIS;
    return parts > 1 && whole->has[axis ? CSV_POSITION_COLUMN : CSV_LENGTH_1_COLUMN] && (axis || whole->has_dof);
}

static int unite_parts(struct import *im) {
    struct csv_head whole;
    if (!are_parts(im, &whole)) return STATUS_OK;
    im->parts = im->files;
    im->part = malloc((size_t)im->parts * sizeof *im->part);
    if (!im->part) return error_set(im->error, STATUS_IO, "out of memory");
    memcpy(im->part, im->head, (size_t)im->parts * sizeof *im->part);
    im->head[0] = whole;
    im->report->files = im->files = 1;
    return STATUS_OK;
}

/* Refuses parts of a test if one has units of an axis that turns, another those of one that
 * slides. */
static int check_kinds(const struct import *im) {
    const struct csv_head *turning = im->part, *sliding = im->part;
    if (!im->head[0].turns || !im->head[0].slides) return STATUS_OK;
    while (!turning->turns) turning++;
    while (!sliding->slides) sliding++;
    return error_set(im->error, STATUS_USAGE,
                     "%.200s:%d: has the unit of an axis that turns (rad, deg, N m), %.60s of one that slides (m, N): %s", turning->path,
                     turning->columns_line, strrchr(sliding->path, '/') + 1, csv_one_kind);
}

/* Refuses a file that is neither a test nor a part of one, and a part with a channel in a unit that
 * hexid does not know, if no other part has the channel. */
static int check_whole(struct import *im, const struct csv_head *h) {
    struct csv_reader *reader;
    bool whole = !im->parts, unknown = h->unknown && !im->head[0].has[h->unknown];
    if (!whole && !unknown) return STATUS_OK;
    int status = csv_open_as(&reader, h, false, im->source->map, im->error);
    if (!status) csv_close(reader);
    return status;
}

/* Notes for the report what a file's head reveals: missing columns, an axis that rotates, text
 * before the names, and a line of units. */
static void note_head(struct import *im, int file) {
    const struct csv_head *h = &im->head[file];
    const struct mechanism *mechanism = mechanism_table[h->mechanism];
    const char *name = strrchr(h->path, '/') + 1;
    for (int i = 0; i < mechanism->legs && !mechanism->csv_column; i++)
        im->report->no_lengths = im->report->no_lengths || !h->has[CSV_LENGTH_1_COLUMN + i];
    im->report->turns = im->report->turns || h->turns;
    if (h->skipped)
        csv_note(im->report->notes, "%.100s: %d line%s of text before the names left out", name, h->skipped, h->skipped == 1 ? "" : "s");
    if (h->units) csv_note(im->report->notes, "%.100s: line %d has the units", name, h->columns_line + 1);
    note(im->report->missing, sizeof im->report->missing, h, h->missing);
}

static int finish_heads(struct import *im) {
    int status = unite_parts(im);
    if (!status && im->parts) status = check_kinds(im);
    for (int i = 0; i < (im->parts ? im->parts : im->files) && !status; i++)
        status = check_whole(im, im->parts ? &im->part[i] : &im->head[i]);
    for (int i = 0; i < im->files && !status; i++) note(im->report->ignored, sizeof im->report->ignored, &im->head[i], im->head[i].ignored);
    return status;
}

/* Reads the head of a single file, whatever the file's name. */
static int read_file_head(struct import *im) {
    char directory[CSV_PATH_SIZE];
    const char *slash = strrchr(im->source->path, '/');
    int before = slash ? (int)(slash - im->source->path) : 1;
    snprintf(directory, sizeof directory, "%.*s", before, slash ? im->source->path : ".");
    im->report->found = 1;
    return read_head(im, directory, slash ? slash + 1 : im->source->path);
}

static int read_heads(struct import *im) {
    struct dirent **files;
    int count = csv_list(im->source->path, &files), status = STATUS_OK;
    if (count < 0 && errno == ENOTDIR) return read_file_head(im);
    if (count < 0) return error_set(im->error, STATUS_IO, "%.250s: cannot be read: %s", im->source->path, strerror(errno));
    if (count == 0) status = error_set(im->error, STATUS_USAGE, "%.250s: has no CSV file", im->source->path);
    if (count > CSV_FILES_MAX)
        status = error_set(im->error, STATUS_USAGE, "%.250s: more than %d CSV files", im->source->path, CSV_FILES_MAX);
    im->report->found = count;
    for (int i = 0; !status && i < count; i++)
        if (!im->source->only || i == im->source->only - 1) status = read_head(im, im->source->path, files[i]->d_name);
    csv_list_free(files, count);
    return status;
}

/* Refuses a name of --map that no file has: it must be a typing error. */
static int check_map(const struct import *im) {
    const struct csv_alias *unseen = csv_map_unseen(im->source->map);
    if (!unseen || im->source->only) return STATUS_OK;
    char text[CSV_MAP_TEXT];
    csv_map_unknown(unseen, "no file has a column of that name", im->report->ignored, text);
    return error_set(im->error, STATUS_USAGE, "%s", text);
}

static int base_params(struct import *im) {
    char path[CSV_PATH_SIZE + 16];
    snprintf(path, sizeof path, "%.*s/config.yaml", CSV_PATH_SIZE, im->source->path);
    im->configured = im->source->configured || access(path, F_OK) == 0;
    if (access(path, F_OK) == 0) return config_load(&im->params, path, NULL, 0, im->error);
    if (errno != ENOENT && errno != ENOTDIR) return error_set(im->error, STATUS_IO, "%.250s: cannot be read: %s", path, strerror(errno));
    const char *base = im->source->base;
    if (base) return config_parse(&im->params, base, strlen(base), "base configuration", im->error);
    config_default(&im->params);
    return STATUS_OK;
}

static int write_log(struct import *im, const char *log_path, const char *config) {
    struct error unsaid;
    int file = output_log(log_path, im->report->aside, im->error), closed;
    int status = file < 0 ? file : log_on_file(&im->log, file, log_path, im->error);
    if (status) return status;
    status = write_event(im, "config", config);
    for (int i = 0; i < im->files && !status; i++) status = write_file(im, i);
    closed = log_close(im->log, status ? &unsaid : im->error);
    return status ? status : closed;
}

/* Returns the text of the configuration without the frequency and the amplitudes that nobody
 * stated, so that a later configuration may state them. */
static char *stated_text(const struct import *im) {
    static const struct {
        enum csv_key key;
        enum dof from, to;
    } of[] = {{CSV_FREQUENCY, DOF_X, DOF_PSI}, {CSV_AMPLITUDE, DOF_X, DOF_Z}, {CSV_AMPLITUDE, DOF_PHI, DOF_PSI}};
    const char *left_out[sizeof of / sizeof *of + 1] = {NULL};
    int count = 0;
    struct params built_in;
    struct config_difference difference;
    config_default(&built_in);
    for (size_t i = 0; i < sizeof of / sizeof *of && !im->configured; i++) {
        const char *key = csv_config_key(of[i].key, of[i].from);
        /* a value that differs from the built-in one counts as stated: the user has edited the
         * default configuration */
        bool stated = set_for(im, of[i].key, of[i].from) ||
                      config_difference(&im->params, &built_in, (const char *const[]){key, NULL}, &difference);
        for (int file = 0; file < im->files; file++) {
            const struct csv_head *h = &im->head[file];
            stated = stated || (gives(h, of[i].key) && h->dof >= of[i].from && h->dof <= of[i].to);
        }
        if (!stated) left_out[count++] = key;
    }
    return config_text_without(&im->params, left_out);
}

/* Checks that hexid would accept the configuration with the heads' values, then writes the log. */
static int check_and_write(struct import *im, const char *log_path) {
    struct params checked;
    char name[CSV_PATH_SIZE + 64], *config = stated_text(im);
    snprintf(name, sizeof name, "%s (configuration with the values of its files)", im->source->path);
    int status = config ? config_parse(&checked, config, strlen(config), name, im->error)
                        : error_set(im->error, STATUS_IO, "out of memory");
    if (!status) status = write_log(im, log_path, config);
    free(config);
    return status;
}

static bool has_pressures(const struct csv_head *h) {
    bool one = mechanism_table[h->mechanism]->legs == 1;
    return h->has[one ? CSV_P1_COLUMN : CSV_P1_1_COLUMN] && h->has[one ? CSV_P2_COLUMN : CSV_P2_1_COLUMN];
}

static void note_areas(struct import *im) {
    bool pressures = false;
    for (int i = 0; i < im->files; i++) pressures = pressures || has_pressures(&im->head[i]);
    if (!pressures) return;
    areas_text(&im->params, im->report->areas);
    config_defaults(&im->params, im->report->defaults);
    im->report->no_areas = !areas_stated(&im->params);
}

static int import(struct import *im, const char *log_path) {
    int status = base_params(im);
    if (!status) status = read_heads(im);
    if (!status) status = finish_heads(im);
    if (!status) status = check_map(im);
    if (!status) status = merge_heads(im);
    if (status) return status;
    im->evaluated_s = (double)INFINITY;
    status = check_files(im);
    if (status) return status;
    place_tests(im);
    for (int i = 0; i < im->files; i++) note_head(im, i);
    note_areas(im);
    if (isfinite(im->evaluated_s)) im->params.tests.duration_s = im->evaluated_s;
    return check_and_write(im, log_path);
}

int csv_import(const struct csv_source *source, const char *log_path, struct csv_report *report, struct error *error) {
    struct import *im = calloc(1, sizeof *im);
    *report = (struct csv_report){0};
    if (!im) return error_set(error, STATUS_IO, "out of memory");
    im->source = source;
    im->report = report;
    im->error = error;
    int status = import(im, log_path);
    for (int i = 0; i < CSV_FILES_MAX; i++) {
        csv_times_free(&im->times[i]);
        csv_table_free(im->table[i]);
    }
    for (int i = 0; i < (im->parts ? im->parts : im->files); i++) csv_foreign_close((im->parts ? im->part : im->head)[i].opened);
    free(im->part);
    free(im);
    return status;
}
