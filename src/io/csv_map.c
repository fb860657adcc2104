#include "csv_map.h"

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
        if (other->column == a->column)
            return REFUSE("%s: given twice, as %.80s and as %.80s: leave one out", csv_columns[a->column].name, other->name, a->name);
        if (!strcmp(other->name, a->name))
            return REFUSE("%.80s: stands for %s and for %s: leave one out", a->name, csv_columns[other->column].name,
                          csv_columns[a->column].name);
    }
    return STATUS_OK;
}

/* Takes the unit after the last colon, or the one at the end of the name. */
static int take_unit(struct csv_alias *a, char *name, struct error *error) {
    char *colon = strrchr(name, ':'), *unit = colon ? trim(colon + 1) : NULL;
    const char *own = csv_columns[a->column].name;
    if (colon) *colon = '\0';
    name = trim(name);
    if (!*name) return REFUSE("%s: no name: %s", own, example);
    if (strlen(name) >= CSV_ALIAS_SIZE) return REFUSE("%s: %.80s...: a name has at most %d bytes", own, name, CSV_ALIAS_SIZE - 1);
    strcpy(a->name, name);
    if (!unit) a->unit = csv_unit_of(name, a->column);
    else if (*unit && !csv_unit_find(unit, a->column, &a->unit)) {
        char units[CSV_UNITS_SIZE];
        csv_units_list(a->column, units);
        return REFUSE("%s=%.80s: no unit for %s: %.20s; it takes %s", own, name, own, unit, units);
    }
    return STATUS_OK;
}

static int add(struct csv_map *map, char *pair, struct error *error) {
    struct csv_alias a = {.unit = 1.0};
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
    if (!status) status = check_twice(map, &a, error);
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

const struct csv_alias *csv_map_find(struct csv_map *map, const char *name) {
    for (int i = 0; map && i < map->count; i++) {
        if (strcmp(map->alias[i].name, name)) continue;
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
