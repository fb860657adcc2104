#include "csv_units.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "units.h"

const struct csv_unit csv_unit_si = {.factor = 1.0};

enum dimension { SECONDS, METRES, RADIANS, METRES_PER_S, RADIANS_PER_S, PASCALS, NEWTONS, NEWTON_METRES, NUMBERS };

#define INCH 0.0254
#define POUND 4.4482216152605 /* pound-force, N: 0.45359237 kg at 9.80665 m/s2 */
#define KILOPOND 9.80665
#define TURN (2.0 * PI)

/* Units as users write them. If two differ in case alone, the case counts. */
static const struct {
    const char *name;
    enum dimension dimension;
    double factor;
} units[] = {
    {"s", SECONDS, 1.0},
    {"sec", SECONDS, 1.0},
    {"seconds", SECONDS, 1.0},
    {"ms", SECONDS, 1e-3},
    {"us", SECONDS, 1e-6},
    {"µs", SECONDS, 1e-6},
    {"ns", SECONDS, 1e-9},
    {"min", SECONDS, 60.0},
    {"m", METRES, 1.0},
    {"cm", METRES, 1e-2},
    {"mm", METRES, 1e-3},
    {"um", METRES, 1e-6},
    {"µm", METRES, 1e-6},
    {"in", METRES, INCH},
    {"inch", METRES, INCH},
    {"ft", METRES, 12.0 * INCH},
    {"rad", RADIANS, 1.0},
    {"mrad", RADIANS, 1e-3},
    {"deg", RADIANS, PI / 180.0},
    {"°", RADIANS, PI / 180.0},
    {"rev", RADIANS, TURN},
    {"m/s", METRES_PER_S, 1.0},
    {"cm/s", METRES_PER_S, 1e-2},
    {"mm/s", METRES_PER_S, 1e-3},
    {"um/s", METRES_PER_S, 1e-6},
    {"in/s", METRES_PER_S, INCH},
    {"ft/s", METRES_PER_S, 12.0 * INCH},
    {"m/min", METRES_PER_S, 1.0 / 60.0},
    {"mm/min", METRES_PER_S, 1e-3 / 60.0},
    {"rad/s", RADIANS_PER_S, 1.0},
    {"deg/s", RADIANS_PER_S, PI / 180.0},
    {"°/s", RADIANS_PER_S, PI / 180.0},
    {"rpm", RADIANS_PER_S, TURN / 60.0},
    {"rev/s", RADIANS_PER_S, TURN},
    {"Pa", PASCALS, 1.0},
    {"kPa", PASCALS, 1e3},
    {"MPa", PASCALS, 1e6},
    {"bar", PASCALS, 1e5},
    {"psi", PASCALS, POUND / (INCH * INCH)},
    {"mbar", PASCALS, 1e2},
    {"hPa", PASCALS, 1e2},
    {"ksi", PASCALS, 1e3 * POUND / (INCH * INCH)},
    {"N", NEWTONS, 1.0},
    {"kN", NEWTONS, 1e3},
    {"daN", NEWTONS, 10.0},
    {"MN", NEWTONS, 1e6},
    {"mN", NEWTONS, 1e-3},
    {"lbf", NEWTONS, POUND},
    {"klbf", NEWTONS, 1e3 * POUND},
    {"kip", NEWTONS, 1e3 * POUND},
    {"kips", NEWTONS, 1e3 * POUND},
    {"kgf", NEWTONS, KILOPOND},
    {"kp", NEWTONS, KILOPOND},
    {"N m", NEWTON_METRES, 1.0},
    {"Nm", NEWTON_METRES, 1.0},
    {"N*m", NEWTON_METRES, 1.0},
    {"N.m", NEWTON_METRES, 1.0},
    {"N·m", NEWTON_METRES, 1.0},
    {"mNm", NEWTON_METRES, 1e-3},
    {"N cm", NEWTON_METRES, 1e-2},
    {"Ncm", NEWTON_METRES, 1e-2},
    {"kN m", NEWTON_METRES, 1e3},
    {"kNm", NEWTON_METRES, 1e3},
    {"lbf in", NEWTON_METRES, POUND * INCH},
    {"lbf ft", NEWTON_METRES, 12.0 * POUND * INCH},
    {"%", NUMBERS, 0.01},
    {"1", NUMBERS, 1.0},
};
enum { UNITS = sizeof units / sizeof *units };

/* Returns true if a column of the quantity can have a unit of the dimension. Sets unit->speed and
 * unit->turns. */
static bool suits(enum dimension dimension, enum csv_quantity quantity, struct csv_unit *unit) {
    bool place = quantity == CSV_PLACE;
    unit->speed = place && (dimension == METRES_PER_S || dimension == RADIANS_PER_S);
    unit->turns = (place && (dimension == RADIANS || dimension == RADIANS_PER_S)) || (quantity == CSV_FORCE && dimension == NEWTON_METRES);
    switch (quantity) {
    case CSV_TIME: return dimension == SECONDS;
    case CSV_LENGTH: return dimension == METRES;
    case CSV_ANGLE: return dimension == RADIANS;
    case CSV_PLACE: return dimension == METRES || dimension == RADIANS || unit->speed;
    case CSV_PRESSURE: return dimension == PASCALS;
    case CSV_FORCE: return dimension == NEWTONS || dimension == NEWTON_METRES;
    case CSV_SHARE: return dimension == NUMBERS;
    default: return false;
    }
}

/* Finds a unit by its exact name, else by a name in another case, unless two such units differ (MN,
 * mN). Returns -1 if there is none. */
static int find(const char *name, size_t length) {
    int found = -1;
    for (int i = 0; i < UNITS; i++) {
        if (strlen(units[i].name) != length) continue;
        if (!strncmp(units[i].name, name, length)) return i;
        if (!strncasecmp(units[i].name, name, length)) found = found < 0 || units[found].factor == units[i].factor ? i : UNITS;
    }
    return found == UNITS ? -1 : found;
}

/* Reads a number before or after a unit; blanks may follow its sign. Returns the text after it, or
 * `text` if there is no number. */
static const char *number(const char *text, double *value) {
    const char *digits = text + (*text == '+' || *text == '-');
    char *end;
    digits += strspn(digits, " ");
    double read = strtod(digits, &end);
    if (!strspn(digits, "0123456789.") || end == digits || !isfinite(read)) return text;
    *value = *text == '-' ? -read : read;
    return end + strspn(end, " ");
}

bool csv_unit_parse(const char *text, enum csv_quantity quantity, struct csv_unit *unit) {
    double scale = 1.0, shift = 0.0;
    size_t length = strlen(text);
    const char *name = number(text, &scale), *end = name + strcspn(name, "+-");
    if (end > name && *end && number(end, &shift) != text + length) return false;
    while (end > name && end[-1] == ' ') end--;
    if (end == name && name > text)
        name = "1", end = name + 1; /* a number without a unit, which
                                                                 * only a share can have */
    int found = find(name, (size_t)(end - name));
    *unit = csv_unit_si;
    if (found < 0 || scale == 0.0 || !suits(units[found].dimension, quantity, unit)) return false;
    unit->factor = scale * units[found].factor;
    unit->offset = shift * units[found].factor;
    return true;
}

bool csv_unit_known(const char *text) { return *text && find(text, strlen(text)) >= 0; }

void csv_units_list(enum csv_quantity quantity, char words[CSV_UNITS_SIZE]) {
    struct csv_unit unused;
    words[0] = '\0';
    for (int i = 0; i < UNITS; i++) {
        size_t used = strlen(words);
        if (suits(units[i].dimension, quantity, &unused) && used + 12 < CSV_UNITS_SIZE)
            snprintf(words + used, CSV_UNITS_SIZE - used, "%s%s", used ? ", " : "", units[i].name);
    }
    if (!words[0]) strcpy(words, "none");
}
