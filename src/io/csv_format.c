#include "csv_format.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "params.h"
#include "units.h"

enum { CSV_NAME_SIZE = 40 };

#define REAL(name, member) {name, CSV_REAL, offsetof(struct cycle, member)}
#define SIX(before, after, member)                                                                                                \
    REAL(before "1" after, member[0]), REAL(before "2" after, member[1]), REAL(before "3" after, member[2]), \
    REAL(before "4" after, member[3]), REAL(before "5" after, member[4]), REAL(before "6" after, member[5])

const struct csv_column csv_columns[CSV_COLUMNS] = {
    REAL("t_s", test_time_s),
    REAL("ref_x_m", ref[DOF_X]),
    REAL("ref_y_m", ref[DOF_Y]),
    REAL("ref_z_m", ref[DOF_Z]),
    REAL("ref_phi_rad", ref[DOF_PHI]),
    REAL("ref_theta_rad", ref[DOF_THETA]),
    REAL("ref_psi_rad", ref[DOF_PSI]),
    SIX("l", "_m", in.length_m),
    SIX("p1_", "_pa", in.p1_pa),
    SIX("p2_", "_pa", in.p2_pa),
    SIX("u", "", out.valve),
    {"flags", CSV_FLAGS, offsetof(struct cycle, in.flags)},
    {"phase", CSV_PHASE, offsetof(struct cycle, phase)},
    REAL("position_m", in.length_m[0]),
    REAL("ref_m", ref[DOF_X]),
    REAL("force_n", force_n[0]),
    REAL("p1_pa", in.p1_pa[0]),
    REAL("p2_pa", in.p2_pa[0]),
    REAL("u", out.valve[0]),
};

bool csv_column_of(int column, const struct mechanism *mechanism) {
    int place = (column - 1) % 6; /* the columns between time and flags stand in sixes */
    if (column == CSV_T || column == CSV_FLAGS_COLUMN || column == CSV_PHASE_COLUMN) return true;
    if (column >= CSV_POSITION_COLUMN || mechanism->legs == 1) return column >= CSV_POSITION_COLUMN && mechanism->legs == 1;
    return place < (column < CSV_LENGTH_1_COLUMN ? mechanism->axes : mechanism->legs);
}

/* Units as users write them, in any case, with the equivalent in csv_columns' names ("" for
 * quantities without a unit there). */
static const struct {
    const char *name, *si;
    double factor;
} units[] = {
    {"s", "s", 1.0},   {"ms", "s", 1e-3},  {"us", "s", 1e-6},   {"m", "m", 1.0},       {"cm", "m", 1e-2},
    {"mm", "m", 1e-3}, {"um", "m", 1e-6},  {"rad", "rad", 1.0}, {"mrad", "rad", 1e-3}, {"deg", "rad", PI / 180.0},
    {"Pa", "pa", 1.0}, {"kPa", "pa", 1e3}, {"MPa", "pa", 1e6},  {"bar", "pa", 1e5},    {"psi", "pa", 6894.757293168},
    {"N", "n", 1.0},   {"kN", "n", 1e3},   {"%", "", 0.01},
};
enum { UNITS = sizeof units / sizeof *units };

/* Normalises a name: lower case, and "name_unit" for "name [unit]" and "name (unit)". */
static void plain_name(const char *name, char plain[CSV_NAME_SIZE]) {
    size_t used = 0;
    for (; *name && used < CSV_NAME_SIZE - 1; name++) {
        if (*name == ']' || *name == ')') break;
        bool unit = *name == '[' || *name == '(';
        while (unit && used > 0 && (plain[used - 1] == ' ' || plain[used - 1] == '_')) used--;
        plain[used++] = unit ? '_' : (char)tolower((unsigned char)*name);
    }
    plain[used] = '\0';
}

static int find_plain(const char *name) {
    int column = CSV_COLUMNS - 1;
    while (column >= 0 && strcmp(name, csv_columns[column].name) != 0) column--;
    return column;
}

int csv_column_find(const char *name, double *unit) {
    char plain[CSV_NAME_SIZE], si[CSV_NAME_SIZE + 8];
    plain_name(name, plain);
    char *end = strrchr(plain, '_');
    *unit = 1.0;
    int column = find_plain(plain);
    for (int i = 0; i < UNITS && end && column < 0; i++) {
        if (strcasecmp(end + 1, units[i].name) != 0) continue;
        *unit = units[i].factor;
        snprintf(si, sizeof si, "%.*s_%s", (int)(end - plain), plain, units[i].si);
        column = find_plain(si);
    }
    return column;
}

/* Returns the unit in a column's name, "m" of position_m; "" if it has none. */
static const char *si_of(int column) {
    const char *end = strrchr(csv_columns[column].name, '_');
    for (int i = 0; i < UNITS && end; i++)
        if (!strcmp(end + 1, units[i].si)) return units[i].si;
    return "";
}

int csv_column_named(const char *name) {
    char plain[CSV_NAME_SIZE];
    plain_name(name, plain);
    for (int i = 0; i < CSV_COLUMNS; i++) {
        const char *own = csv_columns[i].name, *si = si_of(i);
        size_t stem = strlen(own) - (*si ? strlen(si) + 1 : 0);
        if (!strcmp(plain, own) || (strlen(plain) == stem && !strncmp(plain, own, stem))) return i;
    }
    return -1;
}

bool csv_unit_find(const char *unit, int column, double *factor) {
    char plain[CSV_NAME_SIZE];
    plain_name(unit, plain);
    for (int i = 0; i < UNITS; i++) {
        if (strcasecmp(plain, units[i].name) || strcmp(si_of(column), units[i].si) || csv_columns[column].kind != CSV_REAL) continue;
        *factor = units[i].factor;
        return true;
    }
    return false;
}

double csv_unit_of(const char *name, int column) {
    double factor = 1.0;
    const char *end = strpbrk(name, "[(");
    for (const char *more = end; more; more = strpbrk(more + 1, "[(")) end = more;
    if (!end) end = strrchr(name, '_');
    return end && csv_unit_find(end + 1, column, &factor) ? factor : 1.0;
}

void csv_units_list(int column, char words[CSV_UNITS_SIZE]) {
    words[0] = '\0';
    for (int i = 0; i < UNITS; i++) {
        size_t used = strlen(words);
        if (csv_columns[column].kind != CSV_REAL || strcmp(units[i].si, si_of(column))) continue;
        snprintf(words + used, CSV_UNITS_SIZE - used, "%s%s", used ? ", " : "", units[i].name);
    }
    if (!words[0]) strcpy(words, "none");
}

const char *const csv_keys[CSV_KEYS] = {"frequency_hz", "amplitude", "rate_hz", "settle_s", "ramp_s", "duration_s", "ramp_out_s"};

const char *csv_dof_name(enum dof dof) { return dof == DOF_NONE ? "none" : dof_names[dof]; }

bool csv_dof_find(const char *name, enum dof *dof) {
    *dof = DOF_NONE;
    for (int i = 0; i < DOFS; i++)
        if (strcmp(name, dof_names[i]) == 0) *dof = (enum dof)i;
    return *dof != DOF_NONE || strcmp(name, "none") == 0;
}

double *csv_place(struct params *params, enum csv_key key, enum dof dof) {
    struct test_params *t = &params->tests;
    switch (key) {
    case CSV_FREQUENCY: return &t->hz[dof];
    case CSV_AMPLITUDE: return &t->amplitude[dof];
    case CSV_SETTLE: return &t->settle_s;
    case CSV_RAMP: return &t->ramp_s;
    case CSV_DURATION: return &t->duration_s;
    case CSV_RAMP_OUT: return &t->ramp_out_s;
    default: return NULL;
    }
}

static int is_csv(const struct dirent *entry) {
    size_t length = strlen(entry->d_name);
    return length > 4 && strcmp(entry->d_name + length - 4, ".csv") == 0;
}

int csv_list(const char *directory, struct dirent ***files) {
    *files = NULL;
    return scandir(directory, files, is_csv, versionsort);
}

void csv_list_free(struct dirent **files, int count) {
    for (int i = 0; i < count; i++) free(files[i]);
    free(files);
}
