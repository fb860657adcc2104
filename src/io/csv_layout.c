#include "csv_layout.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { LINES = 200, CELLS_LEAST = 2, ROWS_LEAST = 3 };

struct line {
    char *text; /* text of the line without its end; NULL: the line is blank */
    long at;
};

struct lines {
    int count;
    struct line line[LINES];
};

/* Number of cells of a line that is split at a separator, and how many of them are numbers, words
 * and units. */
struct shape {
    int cells, numbers, words, units;
};

static bool is_word(const char *cell) {
    static const char *const words[] = {"nan", "-nan", "null", "none", "na", "n/a", "#n/a", "inf", "-inf"};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (!strcasecmp(cell, words[i])) return true;
    return false;
}

/* Returns true for a number, a date or a time of day. */
static bool is_number(const char *cell) { return strpbrk(cell, "0123456789") && strspn(cell, "+-.,:/0123456789eEdDT ") == strlen(cell); }

static bool is_unit(const char *cell) {
    char text[24];
    size_t length = strlen(cell);
    bool brackets = length > 2 && (*cell == '[' || *cell == '(');
    snprintf(text, sizeof text, "%.*s", (int)(length - 2 * brackets), cell + brackets);
    return csv_unit_known(text) && strcmp(text, "1") != 0;
}

static void count_cell(struct shape *shape, const char *cell) {
    shape->cells++;
    if (!*cell) return;
    if (is_number(cell)) shape->numbers++;
    else if (!is_word(cell)) shape->words++;
    shape->units += is_unit(cell);
}

static struct shape shape_of(const char *text, char separator) {
    char copy[CSV_LINE_SIZE], *rest = copy;
    struct shape shape = {0};
    snprintf(copy, sizeof copy, "%s", text);
    if (!csv_text_normalise(copy, separator)) return shape;
    for (char *cell; (cell = strsep(&rest, ","));) count_cell(&shape, csv_text_trim(cell));
    return shape;
}

/* Returns true for a row of a table: it has more numbers than words. */
static bool is_row(struct shape s) { return s.cells >= CELLS_LEAST && s.numbers > s.words && s.numbers > 0; }

static int next_text(const struct lines *all, int i) {
    do i++;
    while (i < all->count && (!all->line[i].text || all->line[i].text[0] == '#'));
    return i;
}

/* Finds the first row that is followed by another row, or by the end of the file. */
static void find_data(struct csv_layout *layout, const struct lines *all) {
    static const char separators[] = "\t;, ";
    for (int i = next_text(all, -1); i < all->count; i = next_text(all, i)) {
        for (const char *separator = separators; *separator; separator++) {
            struct shape row = shape_of(all->line[i].text, *separator);
            int next = next_text(all, i);
            struct shape after = next < all->count ? shape_of(all->line[next].text, *separator) : row;
            if (!is_row(row) || !is_row(after) || abs(after.cells - row.cells) > 1) continue;
            layout->separator = *separator;
            layout->data_line = i + 1, layout->data_at = all->line[i].at, layout->cells = row.cells > after.cells ? row.cells : after.cells;
            return;
        }
    }
}

static bool names_time(const char *text, char separator, const struct csv_map *map) {
    char copy[CSV_LINE_SIZE], *rest = copy;
    struct csv_unit unit;
    bool mapped = csv_map_of(map, CSV_T), found = false;
    snprintf(copy, sizeof copy, "%s", text);
    if (!csv_text_normalise(copy, separator)) return false;
    for (char *cell; !found && (cell = strsep(&rest, ","));) {
        const char *name = csv_text_trim(cell);
        for (int i = 0; map && i < map->count; i++) found = found || (map->alias[i].column == CSV_T && !strcmp(map->alias[i].name, name));
        if (!mapped) found = found || csv_column_find(name, &unit) == CSV_T;
    }
    return found;
}

/* Finds the columns whose numbers rise, over the rows that were read. */
static void find_rising(struct csv_layout *layout, const struct lines *all) {
    double last[CSV_CELLS_MAX];
    int rows = 0;
    for (int i = layout->data_line - 1; i >= 0 && i < all->count; i = next_text(all, i), rows++) {
        char copy[CSV_LINE_SIZE], *rest = copy, *text;
        snprintf(copy, sizeof copy, "%s", all->line[i].text);
        csv_text_normalise(copy, layout->separator);
        for (int cell = 0; cell < CSV_CELLS_MAX && (text = strsep(&rest, ",")); cell++) {
            double number = (double)NAN;
            if (!csv_text_number(text, &number)) csv_text_time_of_day(text, &number);
            layout->rising[cell] = rows == 0 ? isfinite(number) : layout->rising[cell] && number > last[cell];
            last[cell] = number;
        }
    }
    if (rows < ROWS_LEAST) memset(layout->rising, 0, sizeof layout->rising);
}

/* Counts the names in a line. *separator is normally the rows' separator. If that is a blank and
 * gives more names than a row has cells, the names may contain blanks; *separator is then CSV_WIDE,
 * provided that it gives as many names as cells. */
static struct shape names_shape(const struct csv_layout *layout, const char *text, char *separator) {
    struct shape shape = shape_of(text, layout->separator), wide = shape_of(text, CSV_WIDE);
    bool blanks = layout->separator == ' ' && shape.cells > layout->cells && wide.cells == layout->cells;
    *separator = blanks ? CSV_WIDE : layout->separator;
    return blanks ? wide : shape;
}

/* Returns true if the numbers of names and of cells differ by at most `apart`. A difference of 1 is
 * normal: often only one of the two lines ends in a separator. */
static bool fits(const struct csv_layout *layout, struct shape shape, int apart) { return abs(shape.cells - layout->cells) <= apart; }

/* Finds the first line that names the time: among lines with as many names as a row has cells; else
 * among those with one more or less; else among all lines, each split at a separator of its own. */
static void find_named(struct csv_layout *layout, const struct lines *all, const struct csv_map *map) {
    int end = layout->data_line ? layout->data_line - 1 : all->count;
    enum { OWN = 2 };
    for (int apart = layout->data_line ? 0 : OWN; apart <= OWN && !layout->names_line; apart++) {
        for (int i = next_text(all, -1); i < end && !layout->names_line; i = next_text(all, i)) {
            const char *text = all->line[i].text;
            char separator = csv_text_separator(text);
            if (apart < OWN && !fits(layout, names_shape(layout, text, &separator), apart)) continue;
            if (!names_time(text, separator, map)) continue;
            layout->names_line = i + 1, layout->names_separator = separator;
            if (apart == OWN) layout->separator = separator;
        }
    }
}

/* Finds the last line of text, or comment, with as many cells as a row, one more or one less; and
 * the line of units, if it is directly above the first row. */
static void find_shaped(struct csv_layout *layout, const struct lines *all) {
    for (int i = layout->data_line - 2; i >= 0 && !layout->names_line; i--) {
        const char *text = all->line[i].text;
        if (!text) continue;
        char separator;
        struct shape shape = names_shape(layout, text + (*text == '#'), &separator);
        bool units = shape.units > 0 && 2 * shape.units >= shape.words && i + 1 == layout->data_line - 1;
        if (shape.words == 0 || !fits(layout, shape, 1) || shape.cells < CELLS_LEAST) continue;
        if (units && !layout->units_line) layout->units_line = i + 1;
        else layout->names_line = i + 1, layout->names_separator = separator;
    }
    if (!layout->names_line) layout->names_line = layout->units_line, layout->units_line = 0;
}

/* Finds the line of units, which is the next line after the names and contains no number. */
static void find_units(struct csv_layout *layout, const struct lines *all) {
    int i = next_text(all, layout->names_line - 1);
    if (layout->units_line || !layout->names_line || i >= all->count || (layout->data_line && i + 1 >= layout->data_line)) return;
    struct shape shape = shape_of(all->line[i].text, layout->separator);
    if (shape.units > 0 && shape.numbers == 0) layout->units_line = i + 1;
}

static int read_lines(struct lines *all, struct csv_text *text, struct error *error) {
    char line[CSV_LINE_SIZE];
    for (long at = 0; all->count < LINES && fgets(line, sizeof line, text->file); at = ftell(text->file)) {
        const char *trimmed = csv_text_trim(line + (at == 0 && !strncmp(line, csv_text_mark, 3) ? 3 : 0));
        struct line *to = &all->line[all->count++];
        to->at = at;
        to->text = *trimmed ? strdup(trimmed) : NULL;
        if (*trimmed && !to->text) return error_set(error, STATUS_IO, "out of memory");
    }
    rewind(text->file);
    return STATUS_OK;
}

int csv_layout_find(struct csv_layout *layout, struct csv_text *text, const struct csv_map *map, struct error *error) {
    struct lines all = {0};
    *layout = (struct csv_layout){0};
    int status = read_lines(&all, text, error);
    if (!status) {
        find_data(layout, &all);
        find_rising(layout, &all);
        find_named(layout, &all, map);
        if (!layout->names_line && layout->data_line) find_shaped(layout, &all);
        find_units(layout, &all);
        if (!layout->names_separator) layout->names_separator = layout->separator;
        int end = layout->names_line ? layout->names_line : layout->data_line;
        for (int i = next_text(&all, -1); i < end - 1; i = next_text(&all, i)) layout->skipped++;
    }
    for (int i = 0; i < all.count; i++) free(all.line[i].text);
    return status;
}
