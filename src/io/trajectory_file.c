#include "trajectory_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "csv_text.h"
#include "units.h"

enum { COLUMNS = 1 + DOFS, CELLS_MAX = COLUMNS, KNOTS_MIN = 3, KNOTS_MAX = 500000 };

static const double longest_s = 3600.0, shortest_s = 0.01; /* limits of tests.duration_s, which
                                                            * the trajectory's time becomes */
static const double step_least_s = 1e-6;                   /* shorter steps are no real motion,
                                                            * and badly conditioned for a spline */
static const double farthest_m = 10.0;      /* largest coordinate, m; beyond it, or half a turn, the
                                             * file must have other units */
static const double closed_within = 1e-6;          /* largest difference between the last and the
                                                    * first pose of repeated passes, m or rad, that
                                                    * counts as rounding of the file's last digit */

static const char *const names[COLUMNS] = {"t_s", "x_m", "y_m", "z_m", "phi_rad", "theta_rad", "psi_rad"};

struct file {
    struct csv_text text;
    int cells, column[CELLS_MAX]; /* number of cells in a row, and index in `names` of each */
    double begin_s;               /* time in the first row */
    struct error *error;
};

static int find_column(const char *name) {
    for (int i = 0; i < COLUMNS; i++)
        if (!strcmp(names[i], name)) return i;
    return -1;
}

static int read_columns(struct file *f, char *line) {
    bool has[COLUMNS] = {false};
    int status = csv_text_columns(&f->text, line, f->error);
    while (!status && line) {
        const char *name = csv_text_trim(strsep(&line, ","));
        int column = find_column(name);
        if (column < 0)
            return csv_text_refuse(&f->text, f->error,
                                   "\"%.40s\" is no column of a trajectory: they are t_s, x_m, y_m, z_m, phi_rad, "
                                   "theta_rad, psi_rad",
                                   name);
        if (has[column]) return csv_text_refuse(&f->text, f->error, "%s stands there twice", names[column]);
        has[column] = true;
        f->column[f->cells++] = column;
    }
    if (!status && (!has[0] || f->cells < 2))
        return csv_text_refuse(&f->text, f->error, "no column %s: a trajectory has t_s and at least one axis, such as x_m",
                               has[0] ? "of an axis" : "t_s");
    return status;
}

static int read_head(struct file *f) {
    char *line;
    int got;
    do got = csv_text_line(&f->text, &line, f->error);
    while (got > 0 && line[0] == '#');
    if (got < 0) return got;
    return got ? read_columns(f, line)
               : csv_text_refuse(&f->text, f->error, "an empty file: the first line names the columns, t_s,x_m,...");
}

static int take_value(struct file *f, int column, double number, struct trajectory_knot *k) {
    double most = column <= 3 ? farthest_m : PI;
    if (column == 0) {
        k->time_s = number;
        return isfinite(number) ? STATUS_OK : csv_text_refuse(&f->text, f->error, "t_s: every row needs its time, a number");
    }
    k->pose[column - 1] = number;
    if (fabs(number) <= most) return STATUS_OK; /* this comparison is false for NaN */
    return csv_text_refuse(&f->text, f->error, "%s: %g: every row has a number within %.4g either way, in metres and radians",
                           names[column], number, most);
}

static int read_row(struct file *f, char *line, struct trajectory_knot *k) {
    *k = (struct trajectory_knot){0};
    for (int i = 0; i < f->cells; i++) {
        double number;
        char *end = csv_text_number(line, &number);
        if (!end)
            return csv_text_refuse(&f->text, f->error, "%s: %.*s is no number", names[f->column[i]],
                                   (int)fmin(40, (double)strcspn(line, ",")), line);
        int status = take_value(f, f->column[i], number, k);
        if (status) return status;
        if ((*end == '\0') != (i == f->cells - 1))
            return csv_text_refuse(&f->text, f->error, "more or fewer cells than the %d columns that are named", f->cells);
        line = end + 1;
    }
    return STATUS_OK;
}

static int place(struct file *f, const struct trajectory *t, struct trajectory_knot *k) {
    if (!t->knots) f->begin_s = k->time_s;
    k->time_s -= f->begin_s;
    double before_s = t->knots ? t->knot[t->knots - 1].time_s : -1.0;
    if (!(k->time_s - before_s >= step_least_s))
        return csv_text_refuse(&f->text, f->error, "t_s: %.10g after %.10g: time must increase from row to row, by %g s at least",
                               k->time_s + f->begin_s, before_s + f->begin_s, step_least_s);
    if (k->time_s * t->passes <= longest_s) return STATUS_OK;
    return csv_text_refuse(&f->text, f->error, "%.6g s, %d times: a run's motion is at most %g s long; cut it, or repeat it less",
                           k->time_s, t->passes, longest_s);
}

static int append(struct file *f, struct trajectory *t, int *room, const struct trajectory_knot *k) {
    if (t->knots == KNOTS_MAX)
        return csv_text_refuse(&f->text, f->error, "more than %d rows: give fewer, they are joined by splines", KNOTS_MAX);
    if (t->knots == *room) {
        int larger = *room ? 2 * *room : 1024;
        struct trajectory_knot *more = realloc(t->knot, (size_t)larger * sizeof *more);
        if (!more) return error_set(f->error, STATUS_IO, "%.250s: out of memory", f->text.path);
        t->knot = more, *room = larger;
    }
    t->knot[t->knots++] = *k;
    return STATUS_OK;
}

static int read_rows(struct file *f, struct trajectory *t) {
    struct trajectory_knot k;
    char *line;
    int got, status = STATUS_OK, room = 0;
    while (!status && (got = csv_text_line(&f->text, &line, f->error)) != 0) {
        status = got < 0 ? got : read_row(f, line, &k);
        if (!status) status = place(f, t, &k);
        if (!status) status = append(f, t, &room, &k);
    }
    return status;
}

/* Joins the passes: the end must equal the beginning except for rounding, which is removed. */
static int join_passes(struct file *f, struct trajectory *t) {
    struct trajectory_knot *last = &t->knot[t->knots - 1];
    for (int i = 0; i < DOFS; i++)
        if (!(fabs(last->pose[i] - t->knot->pose[i]) <= closed_within))
            return csv_text_refuse(&f->text, f->error,
                                   "%s: ends at %g, began at %g: what is repeated must end where it began; add rows that "
                                   "lead back, or run it once",
                                   names[i + 1], last->pose[i], t->knot->pose[i]);
    memcpy(last->pose, t->knot->pose, sizeof last->pose);
    return STATUS_OK;
}

static int finish(struct file *f, struct trajectory *t) {
    if (t->knots < KNOTS_MIN) return csv_text_refuse(&f->text, f->error, "%d rows: a trajectory has at least %d", t->knots, KNOTS_MIN);
    if (trajectory_s(t) < shortest_s)
        return csv_text_refuse(&f->text, f->error, "%g s: too short, at least %g s", trajectory_s(t), shortest_s);
    int status = t->passes > 1 ? join_passes(f, t) : STATUS_OK;
    if (status) return status;
    return trajectory_bend(t) ? STATUS_OK : error_set(f->error, STATUS_IO, "%.250s: out of memory", f->text.path);
}

int trajectory_load(struct trajectory *t, const char *path, int passes, struct error *error) {
    struct file *f = calloc(1, sizeof *f);
    *t = (struct trajectory){.passes = passes};
    if (!f) return error_set(error, STATUS_IO, "%.250s: out of memory", path);
    f->error = error;
    int status = csv_text_open(&f->text, path, error);
    if (!status) status = read_head(f);
    if (!status) status = read_rows(f, t);
    if (!status) status = finish(f, t);
    csv_text_close(&f->text);
    free(f);
    return status;
}

void trajectory_free(struct trajectory *t) {
    free(t->knot);
    *t = (struct trajectory){0};
}
