/* Columns by the user's own names: "position=Weg:mm,force=Kraft [kN],t=Zeit:s". Left hexid's
 * name of a column (csv.h), its unit may be left out; right the name as the file has it, then,
 * after a colon, its unit. Without that the name's own end counts ("Weg [mm]", "Weg_mm"), else
 * SI. Names have no comma; one with a colon in it ends with another, its unit or nothing behind
 * that. Pure; any thread. */
#ifndef HEXID_CSV_MAP_H
#define HEXID_CSV_MAP_H

#include "csv_format.h"
#include "status.h"

enum { CSV_ALIAS_SIZE = 120 };

struct csv_alias {
    char name[CSV_ALIAS_SIZE]; /* as the file has it */
    int column;                /* of csv_columns */
    double unit;               /* what its values are multiplied by */
    bool seen;                 /* some file had it */
    char nearest[CSV_ALIAS_SIZE]; /* of the names that files had, the one that may be meant; "" none
                                   * is near */
};

struct csv_map {
    int count;
    struct csv_alias alias[CSV_COLUMNS];
};

/* -2 with the name and the remedy: no column of ours, a unit that it cannot have, a name twice. */
int csv_map_parse(struct csv_map *map, const char *text, struct error *error);

/* The column of this name, seen from now on; NULL: none, or no map. */
const struct csv_alias *csv_map_find(struct csv_map *map, const char *name);

/* What this column of ours is called, or NULL. */
const struct csv_alias *csv_map_of(const struct csv_map *map, int column);

/* What is refused of a name that is not there: what ("the file has no column of that name"), which
 * one may be meant, and what is left over, "" if nothing. */
enum { CSV_MAP_TEXT = 500 };
void csv_map_unknown(const struct csv_alias *alias, const char *what, const char *left, char text[CSV_MAP_TEXT]);

/* The first that no file had, or NULL. */
const struct csv_alias *csv_map_unseen(const struct csv_map *map);

#endif
