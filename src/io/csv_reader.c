#include "csv_reader.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "csv_layout.h"
#include "csv_propose.h"
#include "params/tests.h"

const char csv_one_kind[] = "give both as angle and torque, or both as length and force, with a factor in --map";

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

static int read_key(struct csv_reader *r, char *comment, struct error *error) {
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
    if (r->head.has_dof) return csv_text_refuse(&r->in, error, "dof: given twice");
    r->head.has_dof = true;
    return csv_dof_find(text, &r->head.dof) ? STATUS_OK
                                            : csv_text_refuse(&r->in, error, "dof: %.40s: it takes x, y, z, phi, theta, psi or none", text);
}

/* Notes a column whose name is one of hexid's followed by brackets, if no unit in the brackets
 * suits the column. That is a mistake unless another column has the same name with a unit, such as
 * "Force (N)" beside "Force (V)". */
static void note_unknown_unit(struct csv_reader *r, const char *name) {
    char stem[CSV_ALIAS_SIZE];
    size_t length = strcspn(name, "[(");
    struct csv_unit unused;
    if (!name[length] || length >= sizeof stem || r->head.unknown) return;
    snprintf(stem, sizeof stem, "%.*s", (int)length, name);
    int column = csv_column_named(csv_text_trim(stem));
    if (column <= CSV_T || csv_columns[column].kind != CSV_REAL) return;
    if (csv_unit_of(name, csv_columns[column].quantity, &unused) != CSV_UNIT_WRONG) return;
    r->head.unknown = column;
    snprintf(r->head.unknown_name, sizeof r->head.unknown_name, "%s", name);
}

static int refuse_unknown_unit(const struct csv_reader *r, struct error *error) {
    const struct csv_head *h = &r->head;
    char units[CSV_UNITS_SIZE];
    csv_units_list(csv_columns[h->unknown].quantity, units);
    return csv_text_refuse(&r->in, error, "%.60s: no unit that hexid knows for it: it takes %s; others by --map %.*s=%.60s:FACTOR UNIT",
                           h->unknown_name, units, csv_stem(h->unknown), csv_columns[h->unknown].name, h->unknown_name);
}

/* Takes the unit of a column from the line of units, for a column whose unit neither the map nor
 * the name states. */
static int take_unit(const struct csv_reader *r, struct csv_cell *cell, const char *name, const char *text, struct error *error) {
    char units[CSV_UNITS_SIZE];
    enum csv_quantity quantity = csv_columns[cell->column].quantity;
    if (!*text || !strcmp(text, "-") || quantity == CSV_NO_QUANTITY || csv_unit_parse(text, quantity, &cell->unit)) return STATUS_OK;
    csv_units_list(quantity, units);
    return csv_text_refuse(&r->in, error,
                           "%.60s: the line of units has %.20s, no unit that hexid knows for %s: it takes %s; others by --map", name, text,
                           csv_columns[cell->column].name, units);
}

/* Keeps a column's name, and its unit without brackets. */
static void keep_name(struct csv_reader *r, const char *name, const char *unit) {
    size_t length = unit ? strlen(unit) : 0;
    bool brackets = length > 2 && (*unit == '[' || *unit == '(');
    snprintf(r->name[r->cells], CSV_CELL_NAME, "%s", name);
    if (unit) snprintf(r->unit[r->cells], CSV_CELL_UNIT, "%.*s", (int)(length - 2 * brackets), unit + brackets);
}

/* Finds the unit of a column that is in the map: the map's unit, else that in the name, else that
 * in the line of units. */
static int alias_unit(const struct csv_reader *r, struct csv_cell *cell, const struct csv_alias *alias, const char *name,
                      struct error *error) {
    struct csv_unit named;
    cell->unit = alias->unit;
    if (alias->stated) return STATUS_OK;
    if (csv_unit_of(name, csv_columns[alias->column].quantity, &named) == CSV_UNIT_FOUND) cell->unit = named;
    else return take_unit(r, cell, name, r->unit[r->cells], error);
    return STATUS_OK;
}

/* Notes whether the units of position and force are those of an axis that turns or slides, and
 * whether the position is given as a speed. */
static void note_axis(struct csv_head *h, int column, const struct csv_unit *unit) {
    bool place = csv_columns[column].quantity == CSV_PLACE, force = csv_columns[column].quantity == CSV_FORCE;
    if (column == CSV_POSITION_COLUMN) h->speed = unit->speed;
    if (place || force) *(unit->turns ? &h->turns : &h->slides) = true;
}

static int refuse_twice(const struct csv_reader *r, int column, const char *name, struct error *error) {
    return csv_refuse(r, column, error, "stands there twice, again as %.60s in column %d%s; name one by its number: --map %.*s=#%d:UNIT",
                      name, r->cells + 1, r->map ? ", by --map or by its own name" : "", csv_stem(column), csv_columns[column].name,
                      r->cells + 1);
}

/* Takes a column by its name. unit: its unit in the line of units; NULL: there is no such line. */
static int read_column(struct csv_reader *r, const char *name, const char *unit, struct error *error) {
    struct csv_cell *cell = &r->cell[r->cells];
    if (r->cells == CSV_CELLS_MAX) return csv_text_refuse(&r->in, error, "more than %d columns", CSV_CELLS_MAX);
    const struct csv_alias *alias = csv_map_find(r->map, name, r->cells + 1);
    keep_name(r, name, unit);
    cell->column = alias ? alias->column : csv_column_find(name, &cell->unit);
    int status = alias ? alias_unit(r, cell, alias, name, error) : STATUS_OK;
    if (!alias && cell->column < 0) note_unknown_unit(r, name);
    /* a time in the map overrules a column with hexid's name for the time */
    if (!alias && cell->column == CSV_T && csv_map_of(r->map, CSV_T)) cell->column = -1;
    if (cell->column < 0) list(r->head.ignored, *name ? name : "(no name)");
    else if (r->head.has[cell->column] && cell->column != CSV_T) return refuse_twice(r, cell->column, name, error);
    else {
        r->head.has[cell->column] = true;
        note_axis(&r->head, cell->column, &cell->unit);
    }
    r->cells++;
    return status;
}

/* Lists six missing columns of a kind together, as "u1..u6". Flags and phase exist only in hexid's
 * own files and are not listed. */
void csv_list_missing(struct csv_head *h) {
    char six[64];
    h->missing[0] = '\0';
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
    char text[CSV_MAP_TEXT], proposed[CSV_PROPOSED_SIZE] = "";
    if (!r->map) csv_propose(r, proposed);
    if (!alias && *proposed) return csv_text_refuse(&r->in, error, "%.*s; try %s", (int)strcspn(reason, ":"), reason, proposed);
    if (!alias && *r->head.ignored) return csv_text_refuse(&r->in, error, "%s; not understood: %.300s", reason, r->head.ignored);
    if (!alias) return csv_text_refuse(&r->in, error, "%s", reason);
    csv_map_unknown(alias, "the file has no column of that name", r->head.ignored, text);
    return csv_text_refuse(&r->in, error, "%s", text);
}

static int own_column(const struct mechanism *mechanism) { return mechanism->csv_column ? csv_column_named(mechanism->csv_column) : -1; }

static int refuse_clocks(const struct csv_reader *r, struct error *error) {
    return csv_text_refuse(&r->in, error, "more than %d columns of time: give those that the channels need by number: --map t=#1:s,t=#5:s",
                           CSV_CLOCKS);
}

/* Gives each column its clock, and drops clocks that no column uses. */
static int set_clocks(struct csv_reader *r, struct error *error) {
    int clock = r->counted ? 0 : -1, used[CSV_CLOCKS] = {0}, place[CSV_CLOCKS] = {0}, clocks = 0;
    for (int i = 0; i < r->cells; i++) {
        if (r->cell[i].column == CSV_T && ++clock == CSV_CLOCKS) return refuse_clocks(r, error);
        r->cell[i].clock = clock < 0 ? 0 : clock;
        if (r->cell[i].column > CSV_T) used[r->cell[i].clock] = 1;
    }
    bool none = true;
    for (int i = 0; i <= clock; i++) none = none && !used[i];
    for (int i = 0; i <= clock; i++) place[i] = used[i] || (none && i == 0) ? clocks++ : -1;
    if (r->counted && place[0] < 0) r->counted = NULL;
    for (int i = 0; i < r->cells; i++) {
        struct csv_cell *cell = &r->cell[i];
        cell->clock = clock < 0 ? 0 : place[cell->clock];
        if (cell->clock < 0) cell->column = -1, cell->clock = 0;
        else if (cell->column >= 0) r->clock_of[cell->column] = cell->clock;
    }
    r->head.clocks = clocks;
    return STATUS_OK;
}

/* Reads the names and, if there is a line of units, the units. A separator at the end makes no
 * column. */
static int read_names(struct csv_reader *r, char *names, char *units, struct error *error) {
    while (names) {
        const char *name = csv_text_trim(strsep(&names, ",")), *unit = units ? csv_text_trim(strsep(&units, ",")) : NULL;
        if (!names && !*name && r->cells > 0) break;
        int status = read_column(r, name, unit, error);
        if (status) return status;
    }
    return STATUS_OK;
}

/* Names the columns of a file without names by their numbers. */
static int read_numbers(struct csv_reader *r, int cells, struct error *error) {
    int status = STATUS_OK;
    for (int i = 1; i <= cells && !status; i++) {
        char name[16];
        snprintf(name, sizeof name, "#%d", i);
        status = read_column(r, name, NULL, error);
    }
    return status;
}

/* Lets the number of the row be the time, if the map says so (t=#0). */
static void count_rows(struct csv_reader *r) {
    for (int i = 0; r->map && i < r->map->count; i++) {
        if (r->map->alias[i].cell != 0) continue;
        r->map->alias[i].seen = true;
        r->counted = &r->map->alias[i];
        r->head.has[CSV_T] = true;
    }
}

static int check_turning(const struct csv_reader *r, struct error *error) {
    if (!r->head.turns || !r->head.slides) return STATUS_OK;
    return csv_text_refuse(&r->in, error,
                           "a column has the unit of an axis that turns (rad, deg, N m), another that of one that slides (m, N): %s",
                           csv_one_kind);
}

/* Returns true if there are columns of an axis and none of a platform, even without a position: a
 * file with the force alone is an axis, too. */
static bool is_axis(const struct csv_head *h) {
    bool axis = false;
    for (int i = CSV_T + 1; i < CSV_FLAGS_COLUMN; i++)
        if (h->has[i]) return false;
    for (int i = CSV_POSITION_COLUMN; i < CSV_COLUMNS; i++) axis = axis || h->has[i];
    return axis && !h->has_dof;
}

static int finish_columns(struct csv_reader *r, struct error *error) {
    count_rows(r);
    int status = set_clocks(r, error);
    if (status) return status;
    if (!r->head.has[CSV_T])
        return refuse_missing(
            r, CSV_T, "no column t_s: the line after the head names the columns, t_s among them; names of your own take --map t=NAME:s",
            error);
    for (int i = 0; mechanism_table[i]; i++) {
        int own = own_column(mechanism_table[i]);
        if (own >= 0 && (r->head.has[own] || csv_map_of(r->map, own))) r->head.mechanism = (enum mechanism_kind)i;
    }
    if (is_axis(&r->head)) r->head.mechanism = MECHANISM_AXIS;
    const struct mechanism *mechanism = mechanism_table[r->head.mechanism];
    for (int i = 0; i < r->cells; i++) {
        if (r->cell[i].column < 0 || csv_column_of(r->cell[i].column, mechanism)) continue;
        list(r->head.ignored, csv_columns[r->cell[i].column].name);
        r->head.has[r->cell[i].column] = false;
        r->cell[i].column = -1;
    }
    csv_list_missing(&r->head);
    return check_turning(r, error);
}

/* Refuses a file that lacks a column or key that every test must have: position and axis. */
static int check_whole(const struct csv_reader *r, struct error *error) {
    const struct csv_head *h = &r->head;
    const struct mechanism *mechanism = mechanism_table[h->mechanism];
    int own = own_column(mechanism);
    if (h->unknown && !h->has[h->unknown]) return refuse_unknown_unit(r, error);
    if (own >= 0 && !h->has[own]) return refuse_missing(r, own, mechanism->refuses.no_column, error);
    if (!h->has_dof && mechanism->axes != 1)
        return refuse_missing(r, CSV_POSITION_COLUMN,
                              "no line \"# dof: x\" (or y, z, phi, theta, psi, none) before the names of the columns, and no "
                              "column position_m of an axis (names of your own take --map position=NAME:mm)",
                              error);
    if (h->dof >= mechanism->axes) return csv_text_refuse(&r->in, error, "dof: %s: %s", csv_dof_name(h->dof), mechanism->refuses.axis);
    return STATUS_OK;
}

/* Reads the line of names and, if there is one, the line of units after it. The names may be in a
 * comment. */
static int read_names_and_units(struct csv_reader *r, const struct csv_layout *layout, char *line, struct error *error) {
    static const char mark[] = "#";
    char names[CSV_LINE_SIZE], *units = NULL;
    snprintf(names, sizeof names, "%s", line + (line[0] == *mark));
    r->head.columns_line = r->in.line;
    int got,
        status = csv_text_separate(&r->in, names, layout->names_separator ? layout->names_separator : csv_text_separator(names), error);
    if (layout->separator) r->in.separator = layout->separator;
    if (!status && layout->units_line) {
        if ((got = csv_text_line(&r->in, &units, error)) < 0) return got;
        r->head.units = true;
    }
    return status ? status : read_names(r, names, units, error);
}

/* Continues with the rows of a file without names. */
static int begin_unnamed(struct csv_reader *r, const struct csv_layout *layout, struct error *error) {
    if (fseek(r->in.file, layout->data_at, SEEK_SET)) return error_set(error, STATUS_IO, "%.250s: cannot be read", r->in.path);
    r->in.line = layout->data_line - 1;
    r->in.separator = layout->separator;
    r->head.columns_line = layout->data_line;
    return read_numbers(r, layout->cells, error);
}

/* Returns true if the line just read comes before the names: a key, or other text. */
static bool before_names(const struct csv_reader *r, const struct csv_layout *layout, const char *line) {
    return layout->names_line ? r->in.line < layout->names_line : layout->data_line ? r->in.line < layout->data_line : line[0] == '#';
}

static int read_head(struct csv_reader *r, struct error *error) {
    struct csv_layout layout;
    char *line;
    int got, status = csv_layout_find(&layout, &r->in, r->map, error);
    if (status) return status;
    while ((got = csv_text_line(&r->in, &line, error)) > 0 && before_names(r, &layout, line))
        if (line[0] == '#' && (status = read_key(r, line + 1, error))) return status;
    if (got < 0) return got;
    r->head.skipped = layout.skipped;
    memcpy(r->head.rising, layout.rising, sizeof r->head.rising);
    if (!got && r->head.has_dof) return csv_text_refuse(&r->in, error, "the file ends before the names of the columns");
    if (got) {
        bool unnamed = !layout.names_line && layout.data_line;
        status = unnamed ? begin_unnamed(r, &layout, error) : read_names_and_units(r, &layout, line, error);
    }
    if (status || !got) return status;
    int line_now = r->in.line;
    r->in.line = r->head.columns_line + (layout.units_line ? 1 : 0); /* line named in messages */
    status = finish_columns(r, error);
    r->in.line = line_now;
    return status;
}

int csv_open_as(struct csv_reader **reader, const struct csv_head *head, bool part, struct csv_map *map, struct error *error) {
    struct csv_reader *r = calloc(1, sizeof *r);
    *reader = NULL;
    if (!r) return error_set(error, STATUS_IO, "out of memory");
    snprintf(r->head.path, sizeof r->head.path, "%s", head->path);
    snprintf(r->head.opened, sizeof r->head.opened, "%s", head->opened);
    for (int key = 0; key < CSV_KEYS; key++) r->head.value[key] = (double)NAN;
    r->head.dof = DOF_NONE;
    r->map = map;
    int status = csv_text_open_as(&r->in, head->path, *head->opened ? head->opened : head->path, error);
    if (!status) status = read_head(r, error);
    if (!status && !part) status = check_whole(r, error);
    if (!status && !r->head.has_dof && mechanism_table[r->head.mechanism]->axes == 1) r->head.dof = DOF_X;
    if (status == STATUS_OK) *reader = r;
    else csv_close(r);
    return status;
}

int csv_open(struct csv_reader **reader, const char *path, struct csv_map *map, struct error *error) {
    struct csv_head head;
    snprintf(head.path, sizeof head.path, "%s", path);
    head.opened[0] = '\0';
    return csv_open_as(reader, &head, false, map, error);
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

/* Returns true if the column can have this number. */
static bool possible(int column, double number) {
    enum csv_kind kind = csv_columns[column].kind;
    double most = kind == CSV_FLAGS ? UINT32_MAX : PHASE_RAMP_OUT;
    return kind == CSV_REAL || (number >= 0.0 && number <= most && number == floor(number));
}

/* Refuses the content of a cell; cell: its index, from 0. */
static int refuse_cell(const struct csv_reader *r, int cell, struct error *error) {
    int length;
    const char *text = csv_text_cell(&r->in, cell, &length);
    return csv_refuse(r, r->cell[cell].column, error,
                      "%.*s is no number that it takes: digits and a decimal point%s, no unit, no thousands separator",
                      length < 40 ? length : 40, text, r->in.separator == ',' ? "" : " or comma");
}

/* Refuses a row with the wrong number of cells; rest is the text after the last cell that was
 * read. */
static int refuse_count(const struct csv_reader *r, int cells, const char *rest, struct error *error) {
    for (; *rest; rest++) cells += *rest == ',';
    return csv_text_refuse(&r->in, error, "%d cells, but line %d names %d columns", cells, r->head.columns_line, r->cells);
}

/* Reads a time of day. A step back by more than six hours means that midnight or noon has
 * passed. */
static char *read_time_of_day(struct csv_clock *clock, char *text, double *seconds) {
    enum { HOURS_6 = 21600, HOURS_12 = 43200 };
    char *end = csv_text_time_of_day(text, seconds);
    if (!end) return NULL;
    while (*seconds + clock->day_s < clock->before_s - HOURS_6) clock->day_s += HOURS_12;
    *seconds += clock->day_s;
    clock->before_s = *seconds;
    return end;
}

/* Reads a cell of a known column. Returns the end of the cell's text, or NULL if the column cannot
 * have this content. */
static char *read_cell(struct csv_reader *r, const struct csv_cell *cell, char *text, double value[CSV_COLUMNS]) {
    double number = (double)NAN;
    char *end = csv_text_number(text, &number);
    if (!end && cell->column == CSV_T) end = read_time_of_day(&r->clock[cell->clock], text, &number);
    if (!end) return NULL;
    if (isnan(number) && csv_columns[cell->column].kind != CSV_REAL) return NULL;
    double si = number * cell->unit.factor;
    if (cell->unit.offset != 0.0) si += cell->unit.offset; /* adding zero would turn -0 into 0 */
    *(cell->column == CSV_T ? &r->clock[cell->clock].time_s : &value[cell->column]) = si;
    return cell->column == CSV_T || possible(cell->column, number) ? end : NULL;
}

/* Returns true if the rest is one empty cell, as after a separator at the end of every row. */
static bool only_end(const char *rest) { return rest[0] == ',' && rest[1] == '\0'; }

/* Returns true if this cell and all after it are of unknown columns: a row may end before them. */
static bool none_known(const struct csv_reader *r, int cell) {
    while (cell < r->cells && r->cell[cell].column < 0) cell++;
    return cell == r->cells;
}

/* Returns true if no known column but the time has a number in the row, as in tables of several
 * topics. Rows of hexid's own files are never empty: their flags record that no reading came. */
static bool is_empty(const struct csv_reader *r, const double value[CSV_COLUMNS]) {
    bool any = r->head.has[CSV_FLAGS_COLUMN];
    for (int i = CSV_T + 1; i < CSV_COLUMNS && !any; i++) any = csv_columns[i].kind == CSV_REAL && !isnan(value[i]);
    return !any;
}

/* Reads the next row, also an empty one. */
static int read_row(struct csv_reader *r, double value[CSV_COLUMNS], struct error *error) {
    char *text;
    int got = csv_text_line(&r->in, &text, error);
    if (got <= 0) return got;
    for (int i = 0; i < CSV_COLUMNS; i++) value[i] = (double)NAN;
    value[CSV_FLAGS_COLUMN] = value[CSV_PHASE_COLUMN] = 0.0;
    for (int i = 0; i < r->cells; i++) {
        char *end = r->cell[i].column >= 0 ? read_cell(r, &r->cell[i], text, value) : text + strcspn(text, ",");
        bool last = i == r->cells - 1;
        if (!end) return refuse_cell(r, i, error);
        if (*end == '\0' && none_known(r, i + 1)) break;
        if ((*end == '\0') != last && !(last && only_end(end))) return refuse_count(r, i + 1, end, error);
        text = end + 1;
    }
    if (r->counted) r->clock[0].time_s = r->counted->unit.factor * (double)r->rows + r->counted->unit.offset;
    r->rows++;
    value[CSV_T] = r->clock[0].time_s;
    return 1;
}

int csv_read_values(struct csv_reader *r, double value[CSV_COLUMNS], struct error *error) {
    int got = read_row(r, value, error);
    while (got > 0 && is_empty(r, value)) got = read_row(r, value, error);
    return got;
}

void csv_fill_cycle(const double value[CSV_COLUMNS], struct cycle *cycle) {
    *cycle = blank();
    for (int i = 0; i < CSV_COLUMNS; i++) {
        void *place = (char *)cycle + csv_columns[i].offset;
        /* columns of an axis and of a platform share members: a column without a value leaves the
         * member alone */
        if (csv_columns[i].kind == CSV_FLAGS) *(uint32_t *)place = (uint32_t)value[i];
        else if (csv_columns[i].kind == CSV_PHASE) *(enum phase *)place = (enum phase)(int)value[i];
        else if (!isnan(value[i])) *(double *)place = value[i];
    }
}

int csv_read_row(struct csv_reader *r, struct cycle *cycle, struct error *error) {
    double value[CSV_COLUMNS];
    int got = csv_read_values(r, value, error);
    if (got > 0) csv_fill_cycle(value, cycle);
    if (got > 0) cycle->test_time_s = value[CSV_T];
    return got;
}
