/* Units of columns: their spellings, the quantity that they measure, and their conversion to SI.
 *
 * A unit may be scaled and shifted: "85.2 N" (a value of 1, such as an ampere, a count or a volt,
 * is 85.2 N), "bar-1.013" (a number in this unit is added, for absolute pressure), "-1 kN" (the
 * sign is changed).
 *
 * The unit decides how a column is used. A position in a unit of speed is integrated (csv_speed.h).
 * A position in a unit of angle and a force in a unit of torque belong to an axis that rotates, and
 * are read as if they acted at a lever of 1 m: rad as m, N m as N, and kg m2 as kg. Pure; any
 * thread. */
#ifndef HEXID_CSV_UNITS_H
#define HEXID_CSV_UNITS_H

#include <stdbool.h>

enum csv_quantity {
    CSV_NO_QUANTITY, /* flags, phases */
    CSV_TIME,
    CSV_LENGTH,      /* length of a platform's leg, or a length of its reference */
    CSV_ANGLE,
    CSV_PLACE,       /* position of an axis: a length, an angle, or the rate of either */
    CSV_PRESSURE,
    CSV_FORCE,       /* a force or a torque */
    CSV_SHARE        /* share of full opening */
};

struct csv_unit {
    double factor, offset; /* SI = factor * value + offset */
    bool speed;            /* the value is the rate of the column's quantity */
    bool turns;            /* the column is an axis's position or force, and the value an angle, its
                            * rate or a torque */
};

extern const struct csv_unit csv_unit_si;

/* Parses a unit of the quantity: "mm", "85.2 N" or "bar-1.013". Returns false for anything else. */
bool csv_unit_parse(const char *text, enum csv_quantity quantity, struct csv_unit *unit);

/* Returns true if the text is a unit of any quantity. */
bool csv_unit_known(const char *text);

/* Lists the units that csv_unit_parse() accepts: "m, cm, mm, um". */
enum { CSV_UNITS_SIZE = 200 };
void csv_units_list(enum csv_quantity quantity, char words[CSV_UNITS_SIZE]);

#endif
