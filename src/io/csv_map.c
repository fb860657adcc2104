#include "csv_map.h"

#include <stdlib.h>
#include <string.h>

#include "edit_distance.h"

#define REFUSE(...) error_set(error, STATUS_USAGE, "--map " __VA_ARGS__)

static const char example[] = "write it as position=Weg:mm,t=Zeit:s";

static char *trim(char *text) {
    text += strspn(text, " \t");
    for (size_t n = strlen(text); n > 0 && (text[n - 1] == ' ' || text[n - 1] == '\t'); n--) text[n - 1] = '\0';
    return text;
}

static int check_twice(const struct csv_map *map, const struct csv_alias *a, struct error *error) {
    for (const struct csv_alias *other = map->alias; other < map->alias + map->count; other++) {
        if (other->column == a->column && a->column != CSV_T)
            return REFUSE("%s: given twice, as %.80s and as %.80s: leave one out", csv_columns[a->column].name, other->name, a->name);
        if (!strcmp(other->name, a->name))
            return REFUSE("%.80s: stands for %s and for %s: leave one out", a->name, csv_columns[other->column].name,
                          csv_columns[a->column].name);
    }
    return STATUS_OK;
}

static int refuse_unit(const struct csv_alias *a, const char *unit, struct error *error) {
    char units[CSV_UNITS_SIZE];
    const char *own = csv_columns[a->column].name;
    csv_units_list(csv_columns[a->column].quantity, units);
    return REFUSE("%s=%.80s: no unit for %s: %.20s; it takes %s, and a number of them: force=Strom:85.2 N", own, a->name, own, unit, units);
}

/* Takes the unit after the last colon, or the one at the end of the name. */
static int take_unit(struct csv_alias *a, char *name, struct error *error) {
    char *colon = strrchr(name, ':'), *unit = colon ? trim(colon + 1) : NULL;
    const char *own = csv_columns[a->column].name;
    const enum csv_quantity quantity = csv_columns[a->column].quantity;
    if (colon) *colon = '\0';
    name = trim(name);
    if (!*name) return REFUSE("%s: no name: %s", own, example);
    if (strlen(name) >= CSV_ALIAS_SIZE) return REFUSE("%s: %.80s...: a name has at most %d bytes", own, name, CSV_ALIAS_SIZE - 1);
    strcpy(a->name, name);
    if (unit) {
        a->stated = *unit;
        return !*unit || csv_unit_parse(unit, quantity, &a->unit) ? STATUS_OK : refuse_unit(a, unit, error);
    }
    enum csv_named_unit named = csv_unit_of(name, quantity, &a->unit);
    a->stated = named == CSV_UNIT_FOUND;
    if (named != CSV_UNIT_WRONG) return STATUS_OK;
    char units[CSV_UNITS_SIZE];
    csv_units_list(quantity, units);
    return REFUSE("%s=%.80s: what stands in brackets is no unit for %s: give one behind a colon, %.60s:%s; it takes %s", own, name, own,
                  name, quantity == CSV_FORCE ? "kN" : "mm", units);
}

/* Reads the number of a name such as #3. */
static int take_cell(struct csv_alias *a, struct error *error) {
    char *end;
    a->cell = -1;
    if (a->name[0] != '#' || !a->name[1]) return STATUS_OK;
    long number = strtol(a->name + 1, &end, 10);
    if (*end || a->name[1] < '0' || a->name[1] > '9') return STATUS_OK;
    if (number > 9999 || (number == 0 && a->column != CSV_T))
        return REFUSE("%s=%.20s: columns have numbers from 1; #0 is the number of the row, for t alone", csv_columns[a->column].name,
                      a->name);
    a->cell = (int)number;
    return STATUS_OK;
}

static int add(struct csv_map *map, char *pair, struct error *error) {
    struct csv_alias a = {.unit = csv_unit_si};
    char *equals = strchr(pair, '=');
    if (!equals) return REFUSE("%.100s: no \"=\": %s", pair, example);
    *equals = '\0';
    const char *own = trim(pair);
    a.column = csv_column_named(own);
    if (a.column < 0)
        return REFUSE("%.80s=: hexid has no column of that name; it has t, position, ref, force, p1, p2, u of an axis, and t, l1..l6, "
                      "p1_1..p2_6, u1..u6, ref_x..ref_psi of a platform",
                      own);
    int status = take_unit(&a, equals + 1, error);
    if (!status) status = take_cell(&a, error);
    if (!status) status = check_twice(map, &a, error);
    if (!status && map->count == CSV_COLUMNS + CSV_CLOCKS) return REFUSE("more than %d columns of time", CSV_CLOCKS);
    if (!status) map->alias[map->count++] = a;
    return status;
}

int csv_map_parse(struct csv_map *map, const char *text, struct error *error) {
    char copy[8192], *rest = copy;
    int status = STATUS_OK;
    *map = (struct csv_map){0};
    if (strlen(text) >= sizeof copy) return REFUSE("more than %d bytes", (int)sizeof copy - 1);
    strcpy(copy, text);
    for (char *pair; !status && (pair = strsep(&rest, ","));) status = add(map, pair, error);
    return status;
}

static void note_near(struct csv_alias *a, const char *name) {
    int best = *a->nearest ? edit_distance(a->name, a->nearest) : edit_distance_too_far(a->name);
    if (edit_distance(a->name, name) < best) snprintf(a->nearest, sizeof a->nearest, "%s", name);
}

const struct csv_alias *csv_map_find(struct csv_map *map, const char *name, int cell) {
    for (int i = 0; map && i < map->count; i++) {
        if (map->alias[i].cell >= 0 ? map->alias[i].cell != cell : strcmp(map->alias[i].name, name) != 0) continue;
        map->alias[i].seen = true;
        return &map->alias[i];
    }
    for (int i = 0; map && i < map->count; i++) note_near(&map->alias[i], name);
    return NULL;
}

void csv_map_unknown(const struct csv_alias *a, const char *what, const char *left, char text[CSV_MAP_TEXT]) {
    bool near = *a->nearest;
    snprintf(text, CSV_MAP_TEXT, "--map %s=%.80s: %s; %s%.80s%sleft over are: %.200s", csv_columns[a->column].name, a->name, what,
             near ? "did you mean " : "", a->nearest, near ? "? " : "", *left ? left : "none");
}

const struct csv_alias *csv_map_of(const struct csv_map *map, int column) {
    for (int i = 0; map && i < map->count; i++)
        if (map->alias[i].column == column) return &map->alias[i];
    return NULL;
}

const struct csv_alias *csv_map_unseen(const struct csv_map *map) {
    for (int i = 0; map && i < map->count; i++)
        if (!map->alias[i].seen) return &map->alias[i];
    return NULL;
}
