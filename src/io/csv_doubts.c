#include "csv_doubts.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "areas.h"
#include "force.h"
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

/* Plausible range of a column's greatest value, or of its swing. */
struct expectation {
    bool swing;
    double least, most;
    const struct guess *guess;
};

static const double TURN_MAX_RAD = 0.6; /* limit of any platform's motion, 35 degrees */

static const struct expectation valve = {.least = 0.0, .most = 1.001, .guess = valves};

static struct expectation pressure_of(const struct params *p) {
    return (struct expectation){
        .least = 2e-3 * p->hydraulics.supply_pa, .most = 3.0 * p->sensors.pressure_full_scale_pa, .guess = pressures};
}

static double size_of(const struct csv_range *r, int column, bool swing) {
    return swing ? 0.5 * (r->high[column] - r->low[column]) : fmax(fabs(r->low[column]), fabs(r->high[column]));
}

static void doubt(const char *name, double size, const struct expectation *e, char words[CSV_LIST_SIZE]) {
    size_t used = strlen(words);
    const struct guess *g = e->guess;
    while (g->unit && !(size * g->si >= e->least && size * g->si <= e->most)) g++;
    snprintf(words + used, CSV_LIST_SIZE - used, "%s%s %s %.4g, %s%s?", used ? ", " : "", name, e->swing ? "swings by" : "is up to", size,
             g->unit ? "in " : "another unit or machine", g->unit ? g->unit : "");
}

/* Checks the largest of columns first..last, because a single one may be dead. */
static void check(const struct csv_head *h, const struct csv_range *r, int first, int last, const struct expectation *e,
                  char words[CSV_LIST_SIZE]) {
    double size = 0.0;
    int at = -1;
    for (int i = first; i <= last; i++)
        if (h->has[i] && size_of(r, i, e->swing) > size) size = size_of(r, i, e->swing), at = i;
    if (at >= 0 && !(size >= e->least && size <= e->most)) doubt(csv_columns[at].name, size, e, words);
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

static void check_legs(const struct csv_head *h, const struct csv_range *r, const struct params *p, char words[CSV_LIST_SIZE]) {
    enum { REF = 1, LENGTH = 7, P1 = 13, U = 25 };
    const double *a = p->tests.amplitude;
    double move_max = fmax(4.0 * fmax(a[DOF_X], fmax(a[DOF_Y], a[DOF_Z])), 0.5 * greatest(p->actuator.stroke_m));
    double turn_max = h->dof == DOF_NONE ? TURN_MAX_RAD : 4.0 * fmax(a[DOF_PHI], fmax(a[DOF_THETA], a[DOF_PSI]));
    const struct expectation length = {
        .least = least(p->limits.length_min_m) / 2.0, .most = greatest(p->limits.length_max_m) * 2.0, .guess = lengths};
    const struct expectation move = {.swing = true, .least = 0.0, .most = move_max, .guess = lengths};
    const struct expectation turn = {.swing = true, .least = 0.0, .most = turn_max, .guess = angles};
    const struct expectation pressure = pressure_of(p);
    check(h, r, LENGTH, LENGTH + 5, &length, words);
    check(h, r, REF, REF + 2, &move, words);
    check(h, r, REF + 3, REF + 5, &turn, words);
    check(h, r, P1, P1 + 11, &pressure, words);
    check(h, r, U, U + 5, &valve, words);
}

/* Compares a force with that of the pressures, A1 P1 - A2 P2. */
static void check_force(const struct csv_range *r, const struct params *p, char words[CSV_LIST_SIZE]) {
    struct cylinder_areas areas = cylinder_areas(&p->actuator);
    const double of[3] = {1.0, -areas.a1_m2[0], areas.a2_m2[0]};
    double apart = 0.0, all = r->product[0][0] - r->sum[0] * r->sum[0] / r->beside;
    size_t used = strlen(words);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) apart += of[i] * of[j] * (r->product[i][j] - r->sum[i] * r->sum[j] / r->beside);
    if (!areas_stated(p) || !(apart > FORCE_APART * FORCE_APART * all)) return;
    snprintf(words + used, CSV_LIST_SIZE - used,
             "%sforce_n differs from A1 P1 - A2 P2 by %.2g of its variation, other diameters, units or signs?", used ? ", " : "",
             sqrt(apart / all));
}

static void check_axis(const struct csv_head *h, const struct csv_range *r, const struct params *p, char words[CSV_LIST_SIZE]) {
    enum { POSITION = CSV_POSITION_COLUMN, REF, FORCE, P1, P2, U };
    double w = 2.0 * PI * p->tests.hz[DOF_X], inertia_n = p->axis.mass_kg * w * w * size_of(r, POSITION, true);
    double force_min_n = 0.1 * fmin(inertia_n, 1e3);
    const struct expectation move = {.swing = true, .least = 0.0, .most = 0.5 * p->actuator.stroke_m[0], .guess = lengths};
    const struct expectation force = {.swing = true, .least = force_min_n, .most = (double)INFINITY, .guess = forces};
    const struct expectation pressure = pressure_of(p);
    check(h, r, POSITION, REF, &move, words);
    check(h, r, FORCE, FORCE, &force, words);
    check(h, r, P1, P2, &pressure, words);
    check(h, r, U, U, &valve, words);
    check_force(r, p, words);
}

void csv_doubts(const struct csv_head *head, const struct csv_range *range, const struct params *params, char words[CSV_LIST_SIZE]) {
    words[0] = '\0';
    if (head->mechanism == MECHANISM_AXIS) check_axis(head, range, params, words);
    else check_legs(head, range, params, words);
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
