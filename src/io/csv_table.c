#include "csv_table.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "csv_hold.h"
#include "csv_speed.h"

static const double SPARSE = 0.75;   /* least share of rows in which a channel has a value; with
                                      * less, the rows belong to several channels in turn */
static const double ALIKE = 0.95;    /* rates count as equal if their ratio is between this and 1 */
enum { SAMPLES_LEAST = 20 };

void csv_note(char notes[CSV_NOTES_SIZE], const char *format, ...) {
    size_t used = strlen(notes);
    va_list args;
    va_start(args, format);
    if (used && used + 3 < CSV_NOTES_SIZE) used += (size_t)sprintf(notes + used, "; ");
    vsnprintf(notes + used, CSV_NOTES_SIZE - used, format, args);
    va_end(args);
}

static bool is_command(int column) { return csv_columns[column].quantity == CSV_SHARE || csv_columns[column].kind != CSV_REAL; }

static bool is_reference(int column) { return column == CSV_POSITION_COLUMN + 1 || (column > CSV_T && column < CSV_LENGTH_1_COLUMN); }

static bool is_measured(int column) { return column != CSV_T && !is_command(column) && !is_reference(column); }

/* Returns the base name of a file, for messages. */
static const char *base_name(const struct csv_head *h) {
    const char *slash = strrchr(h->path, '/');
    return slash ? slash + 1 : h->path;
}

/* A test's channels before they are on one clock. */
struct gathering {
    struct csv_series series[CSV_COLUMNS];
    struct csv_hold *hold; /* array of CSV_COLUMNS */
    const struct csv_head *files;
    int count;
    bool keep;             /* this is the second pass, in which samples are kept */
    int64_t rows, unmeasured; /* all rows, and those in which nothing was measured */
    struct error *error;
};

static int add(struct gathering *g, const struct csv_reader *r, int column, double value) {
    double t_s = r->clock[r->clock_of[column]].time_s;
    struct csv_series *s = &g->series[column];
    if (!isfinite(value) || isnan(t_s)) return STATUS_OK;
    csv_hold_take(&g->hold[column], value);
    if (!g->keep) {
        s->count++;
        return STATUS_OK;
    }
    if (!isfinite(t_s) || (s->count && !(t_s > s->t_s[s->count - 1])))
        return csv_refuse(r, column, g->error, "at %.15g after %.15g: time must increase; sort the rows, leave doubles out", t_s,
                          s->count ? s->t_s[s->count - 1] : (double)NAN);
    return csv_series_add(s, t_s, value) ? STATUS_OK : error_set(g->error, STATUS_IO, "out of memory for the channels of a file");
}

static int gather_file(struct gathering *g, const struct csv_head *head, struct csv_map *map) {
    struct csv_reader *r;
    double value[CSV_COLUMNS];
    int got = 0, status = csv_open_as(&r, head, true, map, g->error);
    if (status) return status;
    while (!status && (got = csv_read_values(r, value, g->error)) > 0) {
        bool measured = false;
        for (int i = CSV_T + 1; i < CSV_COLUMNS && !status; i++) {
            measured = measured || (is_measured(i) && !isnan(value[i]));
            if (r->head.has[i]) status = add(g, r, i, value[i]);
        }
        g->rows++, g->unmeasured += !measured;
    }
    csv_close(r);
    return got < 0 ? got : status;
}

static int gather(struct gathering *g, bool keep, struct csv_map *map) {
    int status = STATUS_OK;
    g->keep = keep, g->rows = g->unmeasured = 0;
    memset(g->hold, 0, CSV_COLUMNS * sizeof *g->hold);
    for (int i = 0; i < CSV_COLUMNS; i++) g->series[i].count = 0;
    for (int i = 0; i < g->count && !status; i++) status = gather_file(g, &g->files[i], map);
    return status;
}

/* Returns true if there are several files, or if the rows of the single file cannot be used as they
 * are. Rows of hexid's own files always can. */
static bool needs_table(const struct gathering *g) {
    const struct csv_head *h = &g->files[0];
    if (g->count > 1 || h->clocks > 1 || h->speed) return true;
    if (h->has[CSV_FLAGS_COLUMN]) return false;
    for (int i = 0; i < CSV_COLUMNS; i++) {
        bool sparse = g->series[i].count >= SAMPLES_LEAST && (double)g->series[i].count < SPARSE * (double)g->rows;
        /* a sparse command needs no table, unless rows without any measured channel show that it
         * comes from another topic */
        if (sparse && (is_measured(i) || g->unmeasured)) return true;
        if (is_measured(i) && csv_hold_rows(&g->hold[i]) > 1.0) return true;
    }
    return false;
}

/* Keeps the samples of a repeated channel at which its value is new. If a value stays for longer
 * than hold_rows, it was measured again without a change, and that sample is kept, too. */
static void thin(struct csv_series *s, double hold_rows) {
    int64_t kept = 0, since = 0;
    for (int64_t i = 0; i < s->count; i++) {
        bool begins = i == 0, changed = i > 0 && s->value[i] != s->value[kept - 1];
        if (!begins && !changed && (double)++since < ceil(hold_rows - 0.01)) continue;
        s->t_s[kept] = s->t_s[i], s->value[kept++] = s->value[i];
        since = 0;
    }
    s->count = kept;
}

static void thin_repeated(struct gathering *g, char notes[CSV_NOTES_SIZE]) {
    for (int i = 0; i < CSV_COLUMNS; i++) {
        double rows = csv_hold_rows(&g->hold[i]), before_hz = csv_series_rate(&g->series[i]);
        if (!(rows > 1.0) || is_command(i)) continue;
        double late_ms = 500.0 * (rows - 1.0) / before_hz;
        thin(&g->series[i], rows);
        csv_note(
            notes,
            "%s is repeated %.3g times, at %.4g Hz in rows of %.4g Hz: it counts where it is new, so without the mean delay of %.3g ms",
            csv_columns[i].name, rows, csv_series_rate(&g->series[i]), before_hz, late_ms);
    }
}

/* Returns the channel whose samples become the rows; -1 if nothing was measured. */
static int slowest(const struct gathering *g) {
    bool pressures = g->series[CSV_P1_COLUMN].count && g->series[CSV_P2_COLUMN].count;
    int best = -1;
    double best_hz = (double)INFINITY;
    for (int i = CSV_COLUMNS - 1; i >= 0; i--) {
        double hz = csv_series_rate(&g->series[i]);
        if (!is_measured(i) || g->series[i].count < 2 || (i == CSV_FORCE_COLUMN && pressures)) continue;
        if (hz < ALIKE * best_hz) best = i, best_hz = hz;
    }
    return best;
}

/* Fills a column of the table. */
static bool fill(struct csv_table *t, int column, const struct csv_series *s, bool held) {
    double *value = t->value[column] = malloc((size_t)t->rows * sizeof *value);
    double hole_s = CSV_HOLE / csv_series_rate(s);
    int64_t at = 0;
    for (int64_t row = 0; value && row < t->rows; row++) {
        while (at + 1 < s->count && s->t_s[at + 1] <= t->t_s[row]) at++;
        value[row] = held ? (s->t_s[at] <= t->t_s[row] ? s->value[at] : (double)NAN) : csv_series_at(s, at, t->t_s[row], hole_s);
    }
    return value != NULL;
}

/* Returns the number of rows within the time that all measured channels cover; *first returns the
 * index of the first of these rows. */
static int64_t overlap(const struct gathering *g, const struct csv_series *base, int64_t *first) {
    double begin_s = -HUGE_VAL, end_s = HUGE_VAL;
    for (int i = 0; i < CSV_COLUMNS; i++) {
        const struct csv_series *s = &g->series[i];
        if (!is_measured(i) || !s->count) continue;
        begin_s = fmax(begin_s, s->t_s[0]), end_s = fmin(end_s, s->t_s[s->count - 1]);
    }
    *first = 0;
    while (*first < base->count && base->t_s[*first] < begin_s) ++*first;
    int64_t end = base->count;
    while (end > *first && base->t_s[end - 1] > end_s) end--;
    return end - *first;
}

static int refuse_apart(const struct gathering *g, struct error *error) {
    char spans[300] = "";
    for (int i = 0; i < CSV_COLUMNS; i++) {
        size_t used = strlen(spans);
        const struct csv_series *s = &g->series[i];
        if (is_measured(i) && s->count)
            snprintf(spans + used, sizeof spans - used, "%s%s from %.10g to %.10g s", used ? ", " : "", csv_columns[i].name, s->t_s[0],
                     s->t_s[s->count - 1]);
    }
    return error_set(error, STATUS_USAGE,
                     "%.200s: its channels have no time in common: %s; one clock must be shifted onto the other: --map t=NAME:s+SECONDS",
                     base_name(g->files), spans);
}

static int build(struct csv_table *t, struct gathering *g, char notes[CSV_NOTES_SIZE]) {
    int base = slowest(g);
    if (base < 0) return error_set(g->error, STATUS_USAGE, "%.200s: no position, length, force or pressure has two values", g->files->path);
    const struct csv_series *s = &g->series[base];
    int64_t first;
    t->rows = overlap(g, s, &first);
    if (t->rows < 2) return refuse_apart(g, g->error);
    t->t_s = malloc((size_t)t->rows * sizeof *t->t_s);
    bool there = t->t_s != NULL;
    if (there) memcpy(t->t_s, s->t_s + first, (size_t)t->rows * sizeof *t->t_s);
    for (int i = CSV_T + 1; i < CSV_COLUMNS && there; i++)
        if (g->series[i].count) there = fill(t, i, &g->series[i], is_command(i));
    csv_note(notes, "rows are those of %s, %.4g Hz; other channels are interpolated there", csv_columns[base].name, csv_series_rate(s));
    return there ? STATUS_OK : error_set(g->error, STATUS_IO, "out of memory for the channels of a file");
}

static int finish(struct csv_table **table, struct gathering *g, double middle_m, struct csv_map *map, char notes[CSV_NOTES_SIZE]) {
    int status = gather(g, true, map);
    if (status) return status;
    thin_repeated(g, notes);
    bool speed = false;
    for (int i = 0; i < g->count; i++) speed = speed || g->files[i].speed;
    if (speed) csv_speed_integrate(&g->series[CSV_POSITION_COLUMN], middle_m, notes);
    if (!(*table = calloc(1, sizeof **table))) return error_set(g->error, STATUS_IO, "out of memory");
    return build(*table, g, notes);
}

/* Takes columns without any number out of the head; returns the number of empty cells in the
 * remaining columns. */
static int64_t drop_empty(const struct gathering *g, struct csv_head *whole) {
    int64_t empty = 0;
    for (int i = CSV_T + 1; i < CSV_COLUMNS; i++) {
        int64_t count = g->series[i].count;
        if (whole->has[i] && count) empty += g->rows - count;
        whole->has[i] = whole->has[i] && (count || !g->rows);
    }
    csv_list_missing(whole);
    return empty;
}

int csv_table_make(struct csv_table **table, struct csv_head *whole, int64_t *empty, const struct csv_head *files, int count,
                   double middle_m, struct csv_map *map, char notes[CSV_NOTES_SIZE], struct error *error) {
    struct gathering g = {.files = files, .count = count, .error = error, .hold = calloc(CSV_COLUMNS, sizeof *g.hold)};
    char made[CSV_NOTES_SIZE] = "";
    *table = NULL, *empty = 0;
    if (!g.hold) return error_set(error, STATUS_IO, "out of memory");
    int status = gather(&g, false, map);
    bool needed = !status && needs_table(&g);
    if (!status && !needed) *empty = drop_empty(&g, whole);
    if (needed) status = finish(table, &g, middle_m, map, made);
    if (*made) csv_note(notes, "%s%s: %s", base_name(files), count > 1 ? " and the others" : "", made);
    for (int i = 0; i < CSV_COLUMNS; i++) csv_series_free(&g.series[i]);
    free(g.hold);
    if (status) csv_table_free(*table), *table = NULL;
    return status;
}

void csv_table_free(struct csv_table *t) {
    for (int i = 0; t && i < CSV_COLUMNS; i++) free(t->value[i]);
    if (t) free(t->t_s);
    free(t);
}

int csv_rows_open(struct csv_rows *rows, const struct csv_head *head, const struct csv_table *table, struct csv_map *map,
                  struct error *error) {
    *rows = (struct csv_rows){.table = table};
    return table ? STATUS_OK : csv_open_as(&rows->reader, head, false, map, error);
}

int csv_rows_next(struct csv_rows *rows, struct cycle *cycle, struct error *error) {
    if (rows->reader) return csv_read_row(rows->reader, cycle, error);
    const struct csv_table *t = rows->table;
    double value[CSV_COLUMNS];
    if (rows->next == t->rows) return 0;
    for (int i = 0; i < CSV_COLUMNS; i++)
        value[i] = t->value[i] ? t->value[i][rows->next] : csv_columns[i].kind == CSV_REAL ? (double)NAN : 0.0;
    for (int i = CSV_FLAGS_COLUMN; i <= CSV_PHASE_COLUMN; i++)
        if (isnan(value[i])) value[i] = 0.0;
    csv_fill_cycle(value, cycle);
    cycle->test_time_s = t->t_s[rows->next++];
    return 1;
}

void csv_rows_close(struct csv_rows *rows) {
    if (rows->reader) csv_close(rows->reader);
    rows->reader = NULL;
}
