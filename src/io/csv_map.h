/* Columns under the user's own names: "position=Weg:mm,force=Kraft [kN],t=Zeit:s". On the left is
 * hexid's name of a column (csv.h), with or without its unit. On the right is the name in the file,
 * or #3 for the third column whatever its name, and, after a colon, its unit (csv_units.h):
 * "force=Strom:85.2 N" is a current, one ampere of which stands for 85.2 N. Without a colon the
 * unit at the end of the name counts ("Weg [mm]", "Weg_mm"), then that of a line of units below the
 * names, else SI. Brackets that contain no unit are refused. "t=#0:2 ms" makes the time 2 ms times
 * the row's number. t may be given several times, as a file may have several clocks. Names have no
 * comma; a name that contains a colon must be followed by another colon, with or without a unit.
 * Pure; any thread. */
#ifndef HEXID_CSV_MAP_H
#define HEXID_CSV_MAP_H

#include "csv_format.h"
#include "status.h"

enum { CSV_ALIAS_SIZE = 120, CSV_CLOCKS = 16 };

struct csv_alias {
    char name[CSV_ALIAS_SIZE]; /* name as it stands in the file */
    int column;                /* index of the column in csv_columns */
    struct csv_unit unit;
    bool stated;               /* true: the map gives the unit, behind a colon or at the end of the
                                * name; false: the file may state it */
    int cell;                  /* number of the column, from 1, for #1, #2 ...; 0: number of the
                                * row; -1: the column has a name */
    bool seen;                 /* the name was found in some file */
    char nearest[CSV_ALIAS_SIZE]; /* the most similar name in the files; "": no name is similar */
};

struct csv_map {
    int count;
    struct csv_alias alias[CSV_COLUMNS + CSV_CLOCKS];
};

/* Parses the map. Returns -2 with the name and the remedy: unknown column, impossible unit, or a
 * repeated name. */
int csv_map_parse(struct csv_map *map, const char *text, struct error *error);

/* Finds the map's entry for a column of a file, by the column's name or number (cell, from 1), and
 * marks the entry as seen. Returns NULL if there is no such entry, or no map. */
const struct csv_alias *csv_map_find(struct csv_map *map, const char *name, int cell);

/* Returns the user's name for one of hexid's columns, or NULL. */
const struct csv_alias *csv_map_of(const struct csv_map *map, int column);

/* Writes a message about a missing name, with the name probably meant. what: the problem, "the file
 * has no column of that name"; left: the columns of the file that have no meaning yet, "" if there
 * are none. */
enum { CSV_MAP_TEXT = 500 };
void csv_map_unknown(const struct csv_alias *alias, const char *what, const char *left, char text[CSV_MAP_TEXT]);

/* Returns the first name that no file had, or NULL. */
const struct csv_alias *csv_map_unseen(const struct csv_map *map);

#endif
