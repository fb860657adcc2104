#include "csv_doubts.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "areas.h"
#include "force.h"
#include "params.h"
#include "units.h"

/* Share of a force's variation that friction of seals, the rod's own mass and noise may explain. */
static const double FORCE_APART = 0.2;

static double value_of(const struct cycle *cycle, int column) {
    return *(const double *)(const void *)((const char *)cycle + csv_columns[column].offset);
}

static void take_force(struct csv_range *range, const struct cycle *cycle) {
    double value[3];
    bool all = true;
    for (int i = 0; i < 3; i++) all = isfinite(value[i] = value_of(cycle, CSV_FORCE_COLUMN + i)) && all;
    for (int i = 0; i < 3 && all; i++) {
        range->sum[i] += value[i];
        for (int j = 0; j < 3; j++) range->product[i][j] += value[i] * value[j];
    }
    range->beside += all;
}

void csv_range_take(struct csv_range *range, const struct cycle *cycle) {
    for (int i = 0; i < CSV_COLUMNS; i++) {
        if (csv_columns[i].kind != CSV_REAL) continue;
        double value = value_of(cycle, i);
        /* fmin and fmax ignore NaN */
        range->low[i] = range->begun ? fmin(range->low[i], value) : value;
        range->high[i] = range->begun ? fmax(range->high[i], value) : value;
    }
    range->begun = true;
    take_force(range, cycle);
}

/* A unit, and the factor from it to SI. */
struct guess {
    const char *unit;
    double si;
};

static const struct guess lengths[] = {{"mm", 1e-3}, {"cm", 1e-2}, {"inches", 0.0254}, {NULL, 0.0}};
static const struct guess angles[] = {{"degrees", PI / 180.0}, {"mrad", 1e-3}, {NULL, 0.0}};
static const struct guess pressures[] = {{"MPa", 1e6}, {"bar", 1e5}, {"psi", 6894.76}, {"kPa", 1e3}, {NULL, 0.0}};
static const struct guess forces[] = {{"kN", 1e3}, {NULL, 0.0}};
static const struct guess valves[] = {{"percent", 0.01}, {NULL, 0.0}};

/* Range in which the largest magnitude, or the swing, of some columns lies on the configured
 * machine. */
struct expectation {
    bool swing;         /* true: the swing is judged, half the difference of greatest and least
                         * value; false: the largest magnitude is judged */
    double least, most; /* range of plausible values, SI */
    double usual;       /* usual value, SI; the message names the unit under which the value is
                         * nearest to it, by ratio */
    const char *si;
};

/* Neighbouring columns of one kind. Only the column with the largest value is judged, because
 * sensors of the other columns may be dead and read zero. */
struct group {
    int first, last;
    struct expectation expected;
};

/* Kinds of channels. All channels of a kind have the same unit in a recording. */
enum kind { LENGTH, ANGLE, PRESSURE, FORCE, VALVE, KINDS };
enum { GROUPS = 2 };

static const struct guess *const guesses[KINDS] = {
    [LENGTH] = lengths, [ANGLE] = angles, [PRESSURE] = pressures, [FORCE] = forces, [VALVE] = valves};

static const double TURN_MAX_RAD = 0.6;     /* largest angle that a platform reaches, about 35
                                             * degrees */
static const double OF_SUPPLY = 0.6;        /* usual largest pressure as a share of the supply
                                             * pressure; it lies between a half (light load) and
                                             * 1 */
static const double SUPPLY_MOST = 2.0;      /* largest pressure to which a load or the area ratio
                                             * can raise a chamber, over the supply pressure */
static const double OF_STROKE = 0.1;        /* usual swing of a length, as a share of the stroke, if
                                             * no amplitude is known */

static double size_of(const struct csv_range *r, int column, bool swing) {
    return swing ? 0.5 * (r->high[column] - r->low[column]) : fmax(fabs(r->low[column]), fabs(r->high[column]));
}

static double greatest(const double value[LEGS]) {
    double most = value[0];
    for (int i = 1; i < LEGS; i++) most = fmax(most, value[i]);
    return most;
}

static double least(const double value[LEGS]) {
    double low = value[0];
    for (int i = 1; i < LEGS; i++) low = fmin(low, value[i]);
    return low;
}

static struct expectation pressure_of(const struct params *p) {
    double supply_pa = p->hydraulics.supply_pa;
    return (struct expectation){
        .least = 2e-3 * supply_pa, .most = 3.0 * p->sensors.pressure_full_scale_pa, .usual = OF_SUPPLY * supply_pa, .si = "Pa"};
}

static struct expectation valve(void) { return (struct expectation){.most = 1.001, .usual = 0.5, .si = "of full opening"}; }

/* Fills the groups of one kind; returns their number. */
static int platform_groups(enum kind kind, const struct csv_head *h, const struct params *p, struct group g[GROUPS]) {
    enum { REF = 1, LEG = 7, P1 = 13, U = 25 };
    const double *a = p->tests.amplitude;
    double stroke_m = greatest(p->actuator.stroke_m), far_m = greatest(p->limits.length_max_m), near_m = least(p->limits.length_min_m);
    double move_max = fmax(4.0 * fmax(a[DOF_X], fmax(a[DOF_Y], a[DOF_Z])), 0.5 * stroke_m);
    double turn_max = h->dof == DOF_NONE ? TURN_MAX_RAD : 4.0 * fmax(a[DOF_PHI], fmax(a[DOF_THETA], a[DOF_PSI]));
    bool moves = h->dof != DOF_NONE && h->dof < DOF_PHI, turns = h->dof != DOF_NONE && !moves;
    double move = moves ? a[h->dof] : OF_STROKE * stroke_m, turn = turns ? a[h->dof] : turn_max / 4.0;
    switch (kind) {
    case LENGTH:
        g[0] = (struct group){LEG, LEG + 5, {.least = near_m / 2.0, .most = far_m * 2.0, .usual = sqrt(near_m * far_m), .si = "m"}};
        g[1] = (struct group){REF, REF + 2, {.swing = true, .most = move_max, .usual = move, .si = "m"}};
        return 2;
    case ANGLE: g[0] = (struct group){REF + 3, REF + 5, {.swing = true, .most = turn_max, .usual = turn, .si = "rad"}}; return 1;
    case PRESSURE: g[0] = (struct group){P1, P1 + 11, pressure_of(p)}; return 1;
    case VALVE: g[0] = (struct group){U, U + 5, valve()}; return 1;
    default: return 0;
    }
}

static int axis_groups(enum kind kind, const struct csv_head *h, const struct csv_range *r, const struct params *p,
                       struct group g[GROUPS]) {
    enum { POSITION = CSV_POSITION_COLUMN, REF, AT_FORCE, P1, P2, U };
    double w = 2.0 * PI * p->tests.hz[DOF_X], inertia_n = p->axis.mass_kg * w * w * size_of(r, POSITION, true);
    double force_min_n = 0.1 * fmin(inertia_n, 1e3), stroke_m = p->actuator.stroke_m[0];
    double move_m = h->dof == DOF_NONE ? OF_STROKE * stroke_m : p->tests.amplitude[DOF_X];
    switch (kind) {
    case LENGTH: g[0] = (struct group){POSITION, REF, {.swing = true, .most = 0.5 * stroke_m, .usual = move_m, .si = "m"}}; return 1;
    case FORCE:
        g[0] = (struct group){
            AT_FORCE, AT_FORCE, {.swing = true, .least = force_min_n, .most = (double)INFINITY, .usual = 10.0 * force_min_n, .si = "N"}};
        return 1;
    case PRESSURE: g[0] = (struct group){P1, P2, pressure_of(p)}; return 1;
    case VALVE: g[0] = (struct group){U, U, valve()}; return 1;
    default: return 0;
    }
}

/* Groups of one kind with implausible values over all files, each with its largest value. */
struct doubted {
    int files;                /* number of files with implausible values */
    int file;                 /* first of these files */
    struct {
        int column;           /* column of the largest value; -1: all are plausible */
        double size;
        struct expectation expected;
    } group[GROUPS];
};

static void judge(struct doubted *d, int at, const struct group *g, const struct csv_head *h, const struct csv_range *r, bool *any) {
    const struct expectation *e = &g->expected;
    double size = 0.0;
    int column = -1;
    for (int i = g->first; i <= g->last; i++)
        if (h->has[i] && size_of(r, i, e->swing) > size) size = size_of(r, i, e->swing), column = i;
    if (column < 0 || (size >= e->least && size <= e->most)) return;
    *any = true;
    if (d->group[at].column >= 0 && !(size > d->group[at].size)) return;
    d->group[at].column = column, d->group[at].size = size, d->group[at].expected = *e;
}

static struct doubted doubt(enum kind kind, int files, const struct csv_head *h, const struct csv_range *r, const struct params *p) {
    struct doubted d = {.group = {{.column = -1}, {.column = -1}}};
    for (int file = 0; file < files; file++) {
        struct group g[GROUPS];
        bool any = false;
        int groups = mechanism_table[h[file].mechanism]->pose ? platform_groups(kind, &h[file], p, g)
                                                              : axis_groups(kind, &h[file], &r[file], p, g);
        for (int at = 0; at < groups; at++) judge(&d, at, &g[at], &h[file], &r[file], &any);
        if (any && !d.files++) d.file = file;
    }
    return d;
}

/* Returns how far the values of the doubted groups, read in a unit, are from the usual values: the
 * sum of the magnitudes of log(value / usual value); infinite if a value is impossible. si: factor
 * from the unit to SI; most_factor: largest possible value over the usual one. */
static double misfit(const struct doubted *d, double si, double most_factor) {
    double sum = 0.0;
    for (int i = 0; i < GROUPS; i++) {
        const struct expectation *e = &d->group[i].expected;
        double read = d->group[i].size * si;
        if (d->group[i].column < 0) continue;
        if (!(read >= e->least && read <= fmin(e->most, most_factor * e->usual))) return HUGE_VAL;
        sum += fabs(log(read / e->usual));
    }
    return sum;
}

/* Returns the unit under which all doubted groups of a kind fit the machine best; NULL if none
 * fits. */
static const char *unit_of(enum kind kind, const struct doubted *d) {
    double most_factor = kind == PRESSURE ? SUPPLY_MOST / OF_SUPPLY : HUGE_VAL, best = HUGE_VAL;
    const char *unit = NULL;
    for (const struct guess *g = guesses[kind]; g->unit; g++) {
        double off = misfit(d, g->si, most_factor);
        if (off < best) best = off, unit = g->unit;
    }
    return unit;
}

__attribute__((format(printf, 2, 3))) static void append(char list[CSV_DOUBTS_SIZE], const char *format, ...) {
    size_t used = strlen(list);
    va_list args;
    va_start(args, format);
    vsnprintf(list + used, CSV_DOUBTS_SIZE - used, format, args);
    va_end(args);
}

static void append_file(char list[CSV_DOUBTS_SIZE], const struct csv_head *h, int others) {
    append(list, "%s%s", *list ? "; " : "", strrchr(h->path, '/') + 1);
    if (others) append(list, " and %d more", others);
    append(list, ": ");
}

/* Reports a kind's doubted groups with the unit that fits them together; if none does, each group
 * by itself. */
static void say(char list[CSV_DOUBTS_SIZE], enum kind kind, const struct doubted *d, const struct csv_head *h) {
    const char *unit = unit_of(kind, d), *comma = "";
    if (!unit && d->group[0].column >= 0 && d->group[1].column >= 0) {
        for (int i = 0; i < GROUPS; i++) {
            struct doubted one = *d;
            one.group[!i].column = -1;
            say(list, kind, &one, h);
        }
        return;
    }
    append_file(list, &h[d->file], d->files - 1);
    for (int i = 0; i < GROUPS; i++) {
        const struct expectation *e = &d->group[i].expected;
        if (d->group[i].column < 0) continue;
        append(list, "%s%s %s %.4g", comma, csv_columns[d->group[i].column].name, e->swing ? "swings by" : "is up to", d->group[i].size);
        if (!unit) append(list, " (possible: %.3g to %.3g %s)", e->least, e->most, e->si);
        comma = ", ";
    }
    if (unit) append(list, ", in %s?", unit);
    else append(list, ", and no unit fits: another machine, or another signal?");
}

/* Compares a force with the force of the pressures, A1 P1 - A2 P2. */
static void check_force(const struct csv_head *h, const struct csv_range *r, const struct params *p, char list[CSV_DOUBTS_SIZE]) {
    struct cylinder_areas areas = cylinder_areas(&p->actuator);
    const double of[3] = {1.0, -areas.a1_m2[0], areas.a2_m2[0]};
    double apart = 0.0, all = r->product[0][0] - r->sum[0] * r->sum[0] / r->beside;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) apart += of[i] * of[j] * (r->product[i][j] - r->sum[i] * r->sum[j] / r->beside);
    if (!areas_stated(p) || !(apart > FORCE_APART * FORCE_APART * all)) return;
    append_file(list, h, 0);
    append(list, "force_n differs from A1 P1 - A2 P2 by %.2g of its variation, other diameters, units or signs?", sqrt(apart / all));
}

void csv_doubts(int files, const struct csv_head *head, const struct csv_range *range, const struct params *params,
                char list[CSV_DOUBTS_SIZE]) {
    list[0] = '\0';
    for (int kind = 0; kind < KINDS; kind++) {
        struct doubted d = doubt((enum kind)kind, files, head, range, params);
        if (d.files) say(list, (enum kind)kind, &d, head);
    }
    for (int i = 0; i < files; i++)
        if (mechanism_table[head[i].mechanism]->force_sensor) check_force(&head[i], &range[i], params, list);
}

const char *csv_time_unit(double step_s, double stated_s) {
    double ratio = step_s / stated_s;
    bool stated = isfinite(ratio);
    if (stated ? fabs(ratio / 1e3 - 1.0) < 0.05 : step_s > 0.1 && step_s <= 100.0)
        return "t_s looks like milliseconds, t_ms: name the column so";
    if (stated ? fabs(ratio / 1e6 - 1.0) < 0.05 : step_s > 100.0) return "t_s looks like microseconds, t_us: name the column so";
    if (stated ? fabs(ratio * 1e3 - 1.0) < 0.05 : step_s < 1e-4 && step_s >= 1e-7)
        return "the unit of time looks a thousand times too small (ms for s, or us for ms?): correct it in the column's name or in --map";
    if (stated ? fabs(ratio * 1e6 - 1.0) < 0.05 : step_s < 1e-7)
        return "the unit of time looks a million times too small (us for s?): correct it in the column's name or in --map";
    return NULL;
}
