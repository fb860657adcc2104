#include "csv_format.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "params.h"

enum { CSV_NAME_SIZE = 40 };

#define REAL(name, quantity, member) {name, CSV_REAL, quantity, offsetof(struct cycle, member)}
#define SIX(before, after, quantity, member)                                                              \
    REAL(before "1" after, quantity, member[0]), REAL(before "2" after, quantity, member[1]),         \
        REAL(before "3" after, quantity, member[2]), REAL(before "4" after, quantity, member[3]),     \
        REAL(before "5" after, quantity, member[4]), REAL(before "6" after, quantity, member[5])

const struct csv_column csv_columns[CSV_COLUMNS] = {
    REAL("t_s", CSV_TIME, test_time_s),
    REAL("ref_x_m", CSV_LENGTH, ref[DOF_X]),
    REAL("ref_y_m", CSV_LENGTH, ref[DOF_Y]),
    REAL("ref_z_m", CSV_LENGTH, ref[DOF_Z]),
    REAL("ref_phi_rad", CSV_ANGLE, ref[DOF_PHI]),
    REAL("ref_theta_rad", CSV_ANGLE, ref[DOF_THETA]),
    REAL("ref_psi_rad", CSV_ANGLE, ref[DOF_PSI]),
    SIX("l", "_m", CSV_LENGTH, in.length_m),
    SIX("p1_", "_pa", CSV_PRESSURE, in.p1_pa),
    SIX("p2_", "_pa", CSV_PRESSURE, in.p2_pa),
    SIX("u", "", CSV_SHARE, out.valve),
    {"flags", CSV_FLAGS, CSV_NO_QUANTITY, offsetof(struct cycle, in.flags)},
    {"phase", CSV_PHASE, CSV_NO_QUANTITY, offsetof(struct cycle, phase)},
    REAL("position_m", CSV_PLACE, in.length_m[0]),
    REAL("ref_m", CSV_PLACE, ref[DOF_X]),
    REAL("force_n", CSV_FORCE, force_n[0]),
    REAL("p1_pa", CSV_PRESSURE, in.p1_pa[0]),
    REAL("p2_pa", CSV_PRESSURE, in.p2_pa[0]),
    REAL("u", CSV_SHARE, out.valve[0]),
};

bool csv_column_of(int column, const struct mechanism *mechanism) {
    int place = (column - 1) % 6; /* columns between time and flags come in groups of six */
    if (column == CSV_T || column == CSV_FLAGS_COLUMN || column == CSV_PHASE_COLUMN) return true;
    if (column >= CSV_POSITION_COLUMN || mechanism->legs == 1) return column >= CSV_POSITION_COLUMN && mechanism->legs == 1;
    return place < (column < CSV_LENGTH_1_COLUMN ? mechanism->axes : mechanism->legs);
}

int csv_stem(int column) {
    const char *name = csv_columns[column].name, *end = strrchr(name, '_');
    return (int)(end && csv_unit_known(end + 1) ? end - name : (ptrdiff_t)strlen(name));
}

/* Finds hexid's column whose name, or name without its unit (`stem`), equals the first `length`
 * bytes of a name, in any case; -1 if there is none. */
static int find_name(const char *name, size_t length, bool stem) {
    int column = CSV_COLUMNS - 1;
    for (; column >= 0; column--) {
        const char *own = csv_columns[column].name;
        size_t size = stem ? (size_t)csv_stem(column) : strlen(own);
        if (size == length && !strncasecmp(own, name, size)) break;
    }
    return column;
}

/* Copies the text in the last brackets that begin before `end`. Returns the address of the bracket,
 * or NULL. */
static const char *in_brackets(const char *name, const char *end, char text[CSV_NAME_SIZE]) {
    const char *open = end;
    while (open > name && open[-1] != '[' && open[-1] != '(') open--;
    if (open == name) return NULL;
    size_t length = strcspn(open, "])");
    if (length >= CSV_NAME_SIZE) length = 0;
    snprintf(text, CSV_NAME_SIZE, "%.*s", (int)length, open);
    return open - 1;
}

int csv_column_find(const char *name, struct csv_unit *unit) {
    char text[CSV_NAME_SIZE];
    *unit = csv_unit_si;
    int column = find_name(name, strlen(name), false);
    if (column >= 0) return column;
    const char *end = in_brackets(name, name + strlen(name), text), *under = strrchr(name, '_');
    if (!end && under) end = under, snprintf(text, sizeof text, "%s", under + 1);
    size_t length = end ? (size_t)(end - name) : 0;
    while (length && (name[length - 1] == ' ' || name[length - 1] == '_')) length--;
    column = find_name(name, length, true);
    return column >= 0 && csv_unit_parse(text, csv_columns[column].quantity, unit) ? column : -1;
}

int csv_column_named(const char *name) {
    int column = find_name(name, strlen(name), false);
    return column >= 0 ? column : find_name(name, strlen(name), true);
}

enum csv_named_unit csv_unit_of(const char *name, enum csv_quantity quantity, struct csv_unit *unit) {
    char text[CSV_NAME_SIZE];
    bool brackets = false;
    *unit = csv_unit_si;
    for (const char *end = name + strlen(name); (end = in_brackets(name, end, text)); brackets = true)
        if (csv_unit_parse(text, quantity, unit)) return CSV_UNIT_FOUND;
    *unit = csv_unit_si;
    if (brackets) return quantity == CSV_NO_QUANTITY || quantity == CSV_SHARE ? CSV_UNIT_NONE : CSV_UNIT_WRONG;
    for (const char *end = name + strlen(name); end > name; end--) {
        if (!strchr("/_, ", end[-1]) || !csv_unit_known(end) || !csv_unit_parse(end, quantity, unit)) continue;
        return CSV_UNIT_FOUND;
    }
    *unit = csv_unit_si;
    return CSV_UNIT_NONE;
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

const char *csv_config_key(enum csv_key key, enum dof dof) {
    switch (key) {
    case CSV_FREQUENCY: return "tests.frequency_hz";
    case CSV_AMPLITUDE: return dof < DOF_PHI ? "tests.amplitude_m" : "tests.amplitude_rad";
    case CSV_SETTLE: return "tests.settle_s";
    case CSV_RAMP: return "tests.ramp_s";
    case CSV_DURATION: return "tests.duration_s";
    case CSV_RAMP_OUT: return "tests.ramp_out_s";
    default: return NULL;
    }
}

static int is_csv(const struct dirent *entry) {
    static const char *const ends[] = {".csv", ".tsv", ".mat", ".mcap"};
    const char *dot = strrchr(entry->d_name, '.');
    for (size_t i = 0; i < sizeof ends / sizeof *ends && dot && dot > entry->d_name; i++)
        if (!strcasecmp(dot, ends[i])) return 1;
    return 0;
}

int csv_list(const char *directory, struct dirent ***files) {
    *files = NULL;
    return scandir(directory, files, is_csv, versionsort);
}

void csv_list_free(struct dirent **files, int count) {
    for (int i = 0; i < count; i++) free(files[i]);
    free(files);
}
