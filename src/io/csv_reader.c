#include "csv_reader.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "params/tests.h"

int csv_refuse(const struct csv_reader *r, int column, struct error *error, const char *format, ...) {
    char reason[160];
    va_list args;
    va_start(args, format);
    vsnprintf(reason, sizeof reason, format, args);
    va_end(args);
    return csv_text_refuse(&r->in, error, "%s: %s", csv_columns[column].name, reason);
}

/* Appends a word to a list, unless the list is full. */
static void list(char text[CSV_LIST_SIZE], const char *word) {
    size_t used = strlen(text);
    if (used + strlen(word) + 3 < CSV_LIST_SIZE) sprintf(text + used, "%s%s", used ? ", " : "", word);
}

static int read_value(struct csv_reader *r, int key, char *text, struct error *error) {
    struct csv_head *h = &r->head;
    bool time = key == CSV_SETTLE || key == CSV_RAMP || key == CSV_RAMP_OUT; /* durations that may
                                                                              * be 0 */
    /* range of loop.period_s and of the keys of tests */
    double value, least = key == CSV_RATE ? 10.0 : time ? 0.0 : 1e-9, most = key == CSV_RATE ? 1e4 : 3600.0;
    if (key == CSV_FREQUENCY) least = TESTS_LEAST_HZ, most = TESTS_MOST_HZ;
    char *end = csv_text_number(text, &value);
    if (!isnan(h->value[key])) return csv_text_refuse(&r->in, error, "%s: given twice", csv_keys[key]);
    if (!end || *end || !(value >= least && value <= most))
        return csv_text_refuse(&r->in, error, "%s: %.40s: it takes a number from %g to %g", csv_keys[key], text, least, most);
    h->value[key] = value;
    h->line[key] = r->in.line;
    return STATUS_OK;
}

static int read_mechanism(struct csv_reader *r, const char *text, struct error *error) {
    char names[CSV_LIST_SIZE] = "";
    int kind = mechanism_find(text);
    for (int i = 0; mechanism_names[i]; i++) {
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", !i ? "" : mechanism_names[i + 1] ? ", " : " or ", mechanism_names[i]);
    }
    if (kind < 0) return csv_text_refuse(&r->in, error, "mechanism: %.40s: it takes %s", text, names);
    r->head.mechanism = (enum mechanism_kind)kind;
    return STATUS_OK;
}

static int read_key(struct csv_reader *r, char *comment, bool *has_dof, struct error *error) {
    char *colon = strchr(comment, ':');
    if (!colon) return STATUS_OK;
    *colon = '\0';
    char *name = csv_text_trim(comment), *text = csv_text_trim(colon + 1);
    if (strcmp(name, "mechanism") == 0) return read_mechanism(r, text, error);
    for (int key = 0; key < CSV_KEYS; key++)
        if (strcmp(name, csv_keys[key]) == 0) return read_value(r, key, text, error);
    if (strcmp(name, "dof") != 0) {
        list(r->head.ignored, name);
        return STATUS_OK;
    }
    if (*has_dof) return csv_text_refuse(&r->in, error, "dof: given twice");
    *has_dof = true;
    return csv_dof_find(text, &r->head.dof) ? STATUS_OK
                                            : csv_text_refuse(&r->in, error, "dof: %.40s: it takes x, y, z, phi, theta, psi or none", text);
}

static int read_column(struct csv_reader *r, const char *name, struct error *error) {
    double unit = 1.0;
    if (r->cells == CSV_CELLS_MAX) return csv_text_refuse(&r->in, error, "more than %d columns", CSV_CELLS_MAX);
    const struct csv_alias *alias = csv_map_find(r->map, name);
    int column = alias ? alias->column : csv_column_find(name, &unit);
    r->unit[r->cells] = alias ? alias->unit : unit;
    if (column < 0) list(r->head.ignored, *name ? name : "(no name)");
    else if (r->head.has[column])
        return csv_refuse(r, column, error, "stands there twice%s", r->map ? ", by --map or by its own name" : "");
    else r->head.has[column] = true;
    r->column[r->cells++] = column;
    return STATUS_OK;
}

/* Lists missing columns; six of a kind together, as "u1..u6". Flags and phase exist only in hexid's
 * own files and are not listed. */
static void list_missing(struct csv_head *h) {
    char six[64];
    for (int i = CSV_T + 1; i < CSV_COLUMNS; i++) {
        int last = i;
        if (i == CSV_FLAGS_COLUMN || i == CSV_PHASE_COLUMN || !csv_column_of(i, mechanism_table[h->mechanism])) continue;
        while (i < CSV_FLAGS_COLUMN && last < i + 5 && (i - 1) % 6 == 0 && !h->has[i] && !h->has[last + 1]) last++;
        if (last == i + 5) {
            snprintf(six, sizeof six, "%s..%s", csv_columns[i].name, csv_columns[last].name);
            list(h->missing, six);
            i = last;
        } else if (!h->has[i]) {
            list(h->missing, csv_columns[i].name);
        }
    }
}

static int refuse_missing(const struct csv_reader *r, int column, const char *reason, struct error *error) {
    const struct csv_alias *alias = csv_map_of(r->map, column);
    char text[CSV_MAP_TEXT];
    if (!alias && *r->head.ignored) return csv_text_refuse(&r->in, error, "%s; not understood: %.300s", reason, r->head.ignored);
    if (!alias) return csv_text_refuse(&r->in, error, "%s", reason);
    csv_map_unknown(alias, "the file has no column of that name", r->head.ignored, text);
    return csv_text_refuse(&r->in, error, "%s", text);
}

static int own_column(const struct mechanism *mechanism) { return mechanism->csv_column ? csv_column_named(mechanism->csv_column) : -1; }

static int read_columns(struct csv_reader *r, char *line, struct error *error) {
    r->head.columns_line = r->in.line;
    int separated = csv_text_columns(&r->in, line, error);
    if (separated) return separated;
    while (line) {
        char *cell = strsep(&line, ",");
        int status = read_column(r, csv_text_trim(cell), error);
        if (status) return status;
    }
    if (!r->head.has[CSV_T])
        return refuse_missing(
            r, CSV_T, "no column t_s: the line after the head names the columns, t_s among them; names of your own take --map t=NAME:s",
            error);
    for (int i = 0; mechanism_table[i]; i++) {
        int own = own_column(mechanism_table[i]);
        if (own >= 0 && (r->head.has[own] || csv_map_of(r->map, own))) r->head.mechanism = (enum mechanism_kind)i;
    }
    const struct mechanism *mechanism = mechanism_table[r->head.mechanism];
    int own = own_column(mechanism);
    if (own >= 0 && !r->head.has[own]) return refuse_missing(r, own, mechanism->refuses.no_column, error);
    for (int i = 0; i < r->cells; i++) {
        if (r->column[i] < 0 || csv_column_of(r->column[i], mechanism)) continue;
        list(r->head.ignored, csv_columns[r->column[i]].name);
        r->head.has[r->column[i]] = false;
        r->column[i] = -1;
    }
    list_missing(&r->head);
    return STATUS_OK;
}

static int read_head(struct csv_reader *r, struct error *error) {
    char *line;
    bool has_dof = false;
    int got, status = STATUS_OK;
    while ((got = csv_text_line(&r->in, &line, error)) > 0 && line[0] == '#')
        if ((status = read_key(r, line + 1, &has_dof, error))) return status;
    if (got < 0) return got;
    if (!got && has_dof) return csv_text_refuse(&r->in, error, "the file ends before the names of the columns");
    if (got && (status = read_columns(r, line, error))) return status;
    const struct mechanism *mechanism = mechanism_table[r->head.mechanism];
    if (!has_dof && mechanism->axes == 1) r->head.dof = DOF_X;
    else if (!has_dof)
        return refuse_missing(r, CSV_POSITION_COLUMN,
                              "no line \"# dof: x\" (or y, z, phi, theta, psi, none) before the names of the columns, and no "
                              "column position_m of an axis (names of your own take --map position=NAME:mm)",
                              error);
    if (r->head.dof >= mechanism->axes)
        return csv_text_refuse(&r->in, error, "dof: %s: %s", csv_dof_name(r->head.dof), mechanism->refuses.axis);
    return STATUS_OK;
}

int csv_open(struct csv_reader **reader, const char *path, struct csv_map *map, struct error *error) {
    struct csv_reader *r = calloc(1, sizeof *r);
    *reader = NULL;
    if (!r) return error_set(error, STATUS_IO, "out of memory");
    snprintf(r->head.path, sizeof r->head.path, "%s", path);
    for (int key = 0; key < CSV_KEYS; key++) r->head.value[key] = (double)NAN;
    r->head.dof = DOF_NONE;
    r->map = map;
    int status = csv_text_open(&r->in, path, error);
    if (!status) status = read_head(r, error);
    if (status == STATUS_OK) *reader = r;
    else csv_close(r);
    return status;
}

void csv_close(struct csv_reader *r) {
    csv_text_close(&r->in);
    free(r);
}

static struct cycle blank(void) {
    struct cycle c = {.state = STATE_TESTING, .out.enable = true};
    for (int i = 0; i < LEGS; i++) {
        c.in.length_m[i] = c.in.p1_pa[i] = c.in.p2_pa[i] = c.out.valve[i] = c.force_n[i] = (double)NAN;
        c.ref[i] = c.pose[i] = (double)NAN;
    }
    return c;
}

static bool store(struct cycle *c, const struct csv_column *column, double number) {
    void *place = (char *)c + column->offset;
    double most = column->kind == CSV_FLAGS ? UINT32_MAX : PHASE_RAMP_OUT;
    if (column->kind == CSV_REAL) {
        *(double *)place = number;
        return true;
    }
    if (!(number >= 0.0 && number <= most && number == floor(number))) return false;
    if (column->kind == CSV_FLAGS) *(uint32_t *)place = (uint32_t)number;
    else *(enum phase *)place = (enum phase)(int)number;
    return true;
}

/* Refuses the content of a cell; cell: its index, from 0. */
static int refuse_cell(const struct csv_reader *r, int cell, struct error *error) {
    int length;
    const char *text = csv_text_cell(&r->in, cell, &length);
    return csv_refuse(r, r->column[cell], error,
                      "%.*s is no number that it takes: digits and a decimal point%s, no unit, no thousands separator",
                      length < 40 ? length : 40, text, r->in.separator == ',' ? "" : " or comma");
}

/* Refuses a row with the wrong number of cells; rest is the text after the last cell that was
 * read. */
static int refuse_count(const struct csv_reader *r, int cells, const char *rest, struct error *error) {
    for (; *rest; rest++) cells += *rest == ',';
    return csv_text_refuse(&r->in, error, "%d cells, but line %d names %d columns", cells, r->head.columns_line, r->cells);
}

int csv_read_row(struct csv_reader *r, struct cycle *cycle, struct error *error) {
    char *cell;
    int got = csv_text_line(&r->in, &cell, error);
    if (got <= 0) return got;
    *cycle = blank();
    for (int i = 0; i < r->cells; i++) {
        const struct csv_column *column = r->column[i] >= 0 ? &csv_columns[r->column[i]] : NULL;
        double number;
        char *end = column ? csv_text_number(cell, &number) : cell + strcspn(cell, ",");
        if (!end || (column && !store(cycle, column, number * r->unit[i]))) return refuse_cell(r, i, error);
        r->empty += column && isnan(number);
        if ((*end == '\0') != (i == r->cells - 1)) return refuse_count(r, i + 1, end, error);
        cell = end + 1;
    }
    return 1;
}
