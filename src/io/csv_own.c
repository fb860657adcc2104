#include "csv_own.h"

#include <math.h>
#include <string.h>

int csv_own_column(const char *name) {
    int column = CYCLE_COLUMNS - 1;
    while (column >= 0 && strcmp(cycle_columns[column].name, name)) column--;
    return column;
}

/* Names of a single axis's columns in a CSV file, and in a whole export, where the axis is leg 1
 * and its reference is x. */
static const struct {
    const char *csv, *own;
} axis_names[] = {{"position_m", "l1_m"}, {"ref_m", "ref_x_m"}, {"force_n", "force_1_n"},
                  {"p1_pa", "p1_1_pa"},   {"p2_pa", "p2_1_pa"}, {"u", "u1"}};
enum { AXIS_NAMES = sizeof axis_names / sizeof *axis_names };

static double value_of(const double value[CYCLE_COLUMNS], const char *name) {
    int column = csv_own_column(name);
    return column < 0 ? (double)NAN : value[column];
}

/* Returns the whole export's column from which a CSV column takes its values; NULL: the text does
 * not have this CSV column. */
static const char *source_of(const struct csv_own *own, int column) {
    const char *name = csv_columns[column].name;
    if (column == CSV_T) return "test_time_s";
    if (column == CSV_FLAGS_COLUMN || column == CSV_PHASE_COLUMN) return name;
    if (!own->axis) return column < CSV_POSITION_COLUMN ? name : NULL;
    for (int i = 0; i < AXIS_NAMES; i++)
        if (!strcmp(name, axis_names[i].csv)) return axis_names[i].own;
    return NULL;
}

/* True if no leg but the first has a length or a pressure. A single reading that is missing does
 * not make a platform an axis. */
static bool first_leg_alone(const double value[CYCLE_COLUMNS]) {
    bool others = false;
    for (int leg = 2; leg <= LEGS; leg++) {
        char length[16], p1[16], p2[16];
        snprintf(length, sizeof length, "l%d_m", leg), snprintf(p1, sizeof p1, "p1_%d_pa", leg), snprintf(p2, sizeof p2, "p2_%d_pa", leg);
        others = others || !isnan(value_of(value, length)) || !isnan(value_of(value, p1)) || !isnan(value_of(value, p2));
    }
    return !others;
}

static FILE *begin_test(struct csv_own *own, struct csv_texts *texts, const double value[CYCLE_COLUMNS]) {
    FILE *file = csv_texts_next(texts);
    if (!file) return NULL;
    own->axis = first_leg_alone(value);
    bool named = own->dof >= 0 && own->dof < DOFS;
    if (own->axis) fputs("# mechanism: axis\n", file);
    fprintf(file, "# dof: %s\n", named ? dof_names[own->dof] : "none");
    for (int i = 0; i < CSV_COLUMNS; i++)
        if (source_of(own, i)) fprintf(file, "%s%s", i ? "," : "", csv_columns[i].name);
    fputc('\n', file);
    return file;
}

bool csv_own_row(struct csv_own *own, struct csv_texts *texts, const double value[CYCLE_COLUMNS]) {
    double test = value_of(value, "test"), dof = value_of(value, "dof"), time_s = value_of(value, "test_time_s");
    if (!(test >= 0.0 && test < 1e6) || isnan(time_s) || !(fabs(dof) <= DOFS)) return true;
    bool other = !texts->file || (int)test != own->test || (int)dof != own->dof || time_s <= own->time_s;
    own->test = (int)test, own->dof = (int)dof, own->time_s = time_s;
    FILE *file = other ? begin_test(own, texts, value) : texts->file;
    for (int i = 0; file && i < CSV_COLUMNS; i++) {
        const char *source = source_of(own, i);
        if (source) csv_texts_number(texts, i ? ',' : 0, value_of(value, source));
    }
    if (file) fputc('\n', file);
    return file && csv_texts_good(texts);
}
