#include "identification_table.h"

#include <math.h>

#include "identification_report.h"
#include "numeric.h"
#include "words.h"

enum { DECIMALS = 3, DECIMALS_MOST = 6 };

int identification_decimals_of(double value) {
    double size = fabs(value);
    return size > 0.0 && size < 1.0 ? (int)fmin(DECIMALS - floor(log10(size)), DECIMALS_MOST) : DECIMALS;
}

int identification_decimals(const double mt[DOFS][DOFS]) {
    double least = 1.0;
    for (int i = 0; i < DOFS; i++) least = fmin(least, fabs(mt[i][i])); /* fmin skips NaN */
    return identification_decimals_of(least);
}

/* Prints an entry of a method's matrix and its error in per cent. */
static void cell(FILE *out, const struct identification *id, const struct method_result *m, const struct ident_entry *e) {
    double value = m->mt[e->row][e->col], error = value - id->nominal_mt[e->row][e->col];
    fprintf(out, "  %8.*f %+7.2f", identification_decimals(id->nominal_mt), value, 100.0 * error / ident_scale(id->nominal_mt, e));
}

static void print_error_note(FILE *out) {
    fprintf(out, "errors in %% of the nominal value, of a coupling (Mt15 ...) in %% of sqrt(Mii Mjj); +-: 95 %% interval\n");
}

static void row(FILE *out, const char *what, int count, const double *value, const double *std, int stride, const char *unit) {
    fprintf(out, "%-24s", what);
    double most = NAN; /* largest standard deviation of the determined values */
    for (int k = 0; k < count; k++) {
        words_row(out, " %7.1f", value[k * stride]);
        most = fmax(most, std[k * stride]);
    }
    fprintf(out, " %s", unit);
    if (!isnan(most)) fprintf(out, ", +- %.1f at most", NUMERIC_95 * most);
    fprintf(out, "\n");
}

/* Prints `count` numbers of a payload, from `first` on, and their largest interval. */
static void group(FILE *out, const struct payload *p, int first, int count, double scale, int digits, const char *unit) {
    double most = NAN;
    for (int i = first; i < first + count; i++) {
        words_row(out, " %.*f", digits, p->value[i] * scale);
        most = fmax(most, p->std[i] * scale);
    }
    fprintf(out, " %s", unit);
    if (!isnan(most)) fprintf(out, ", +- %.2g at most", NUMERIC_95 * most);
    fprintf(out, "\n");
}

static int inertia_decimals(const struct payload *p) {
    double most = fmax(fmax(p->value[PAYLOAD_INERTIA], p->value[PAYLOAD_INERTIA + 1]), p->value[PAYLOAD_INERTIA + 2]);
    return identification_decimals_of(most);
}

static void print_payload(FILE *out, const struct payload *p) {
    fprintf(out, "payload, legs taken off: mass");
    group(out, p, PAYLOAD_MASS, 1, 1.0, 2, "kg");
    fprintf(out, "  mass centre from where it is configured");
    group(out, p, PAYLOAD_CENTER, 3, 1e3, 2, "mm");
    fprintf(out, "  inertia about it, xx yy zz xy xz yz");
    group(out, p, PAYLOAD_INERTIA, 6, 1.0, inertia_decimals(p), "kg m^2");
    if (p->whole && !p->possible) fprintf(out, "  no body of positive density has these: the nearest that one has are in the JSON\n");
}

/* Prints the systematic errors that the data show, and the causes that widen the diagonal's
 * intervals most. */
static void print_systematic(FILE *out, const struct method_c *c) {
    for (int i = 0; i < SYSTEMATICS; i++) {
        const struct systematic_found *e = &c->systematic[i];
        const struct systematic_words *words = &systematic_families[systematic_family(i)];
        char name[SYSTEMATIC_NAME];
        if (!method_c_found(e)) continue;
        systematic_name(i, name);
        fprintf(out, "found     %s: %+.3g +- %.2g %s\n", name, words->scale * e->value, NUMERIC_95 * words->scale * e->std, words->unit);
    }
    const char *before = "variance  most of it comes from ";
    for (int i = 0; i < DOFS; i++) {
        int most = 0;
        if (isnan(c->matrix.mt[i][i])) continue;
        for (int k = 1; k < CAUSES; k++) most = c->share[k][i][i] > c->share[most][i][i] ? k : most;
        fprintf(out, "%s%s: %s, %.0f %%", before, ident_entries[i].name, method_c_cause(most), 100.0 * c->share[most][i][i]);
        before = "; ";
    }
    fprintf(out, "%s", before[0] == ';' ? "\n" : "");
}

void identification_common_gain_print(FILE *out, const struct common_gain *gain) {
    if (!gain->sensors) return;
    fprintf(out,
            "gain      that all %s have in common: no motion shows it, so masses, inertias and friction are as exact as it,\n"
            "          +- %.2g %% by model.tolerance.pressure_gain (the mean of %d, +- %.2g %% each); a known weight finds it (--weight)\n",
            gain->pressures ? "pressures" : "force sensors", 100.0 * NUMERIC_95 * gain->std, gain->sensors,
            100.0 * NUMERIC_95 * gain->tolerance);
}

/* Prints the largest zero that a pressure shows at rest, with its interval; nothing with too few
 * samples. */
static void print_rest(FILE *out, const struct rest_found *r) {
    int most[2] = {0, 0};
    if (r->samples < REST_LEAST) return;
    for (int side = 0; side < 2; side++)
        for (int k = 0; k < LEGS; k++)
            if (fabs(r->zero_pa[side][k]) > fabs(r->zero_pa[most[0]][most[1]])) most[0] = side, most[1] = k;
    fprintf(out, "at rest   before the supply came on, %lld samples: largest zero of a pressure: P%d of leg %d, %+.4f +- %.4f MPa\n",
            (long long)r->samples, most[0] + 1, most[1] + 1, 1e-6 * r->zero_pa[most[0]][most[1]],
            NUMERIC_95 * 1e-6 * r->zero_std_pa[most[0]][most[1]]);
}

static void print_weighed(FILE *out, const struct weighing_found *w) {
    if (!(w->stated_kg > 0.0)) return;
    fprintf(out, "weight    %g kg read %.2f +- %.2f kg, %+.2f %%, mean of %d tests; zeros of the pressures drifted by %+.2f +- %.2f kg\n",
            w->stated_kg, w->reading_kg, NUMERIC_95 * w->std_kg, 100.0 * (w->reading_kg / w->stated_kg - 1.0), w->tests, w->drift_kg,
            NUMERIC_95 * w->drift_std_kg);
}

static void print_matrix(FILE *out, const double m[DOFS][DOFS]) {
    int decimals = identification_decimals(m);
    double least = 0.5 * pow(10.0, -decimals); /* smaller values are printed as 0, without a sign */
    for (int i = 0; i < DOFS; i++) {
        fprintf(out, "  %-6s", dof_names[i]);
        for (int j = 0; j < DOFS; j++) words_row(out, " %9.*f", decimals, fabs(m[i][j]) < least ? 0.0 : m[i][j]);
        fprintf(out, "\n");
    }
}

void identification_at_pose_print(FILE *out, const struct matrix_at_pose *at) {
    const double *p = at->pose;
    if (!at->asked) return;
    fprintf(out, "Mt at %g %g %g m, %g %g %g rad, from the payload found and the legs as configured", p[0], p[1], p[2], p[3], p[4], p[5]);
    fprintf(out, at->determined ? "\n" : ": not determined, as the payload is not\n");
    if (at->determined) print_matrix(out, at->mt);
}

/* Marks the axes that must move more to determine an entry: the axes of its row and its column
 * whose own inertia (diagonal entry) is not determined, or both axes if both inertias are
 * determined. */
static void note_missing(const struct method_c *c, int row, int column, bool missing[DOFS]) {
    bool still[2] = {isnan(c->matrix.mt[row][row]), isnan(c->matrix.mt[column][column])}, none = !still[0] && !still[1];
    missing[row] = missing[row] || still[0] || none;
    missing[column] = missing[column] || still[1] || none;
}

void identification_determined_print(FILE *out, const struct method_c *c, const double nominal_mt[DOFS][DOFS]) {
    double best_pct = NAN, worst_pct = NAN, std;
    bool missing[DOFS] = {false};
    int row, column, known = 0;
    for (int i = 0; i < MATRIX_ENTRIES; i++) {
        equations_entry(i, &row, &column);
        if (isnan(method_c_value(c, i, &std))) {
            note_missing(c, row, column, missing);
            continue;
        }
        double pct = 100.0 * std / sqrt(nominal_mt[row][row] * nominal_mt[column][column]);
        best_pct = fmin(best_pct, pct), worst_pct = fmax(worst_pct, pct);
        known++;
    }
    fprintf(out, "data      determine %d of %d entries of Mt, +- %.2g to %.2g %% of sqrt(Mii Mjj); condition number %.3g\n", known,
            MATRIX_ENTRIES, NUMERIC_95 * best_pct, NUMERIC_95 * worst_pct, c->matrix.condition_number);
    if (known == MATRIX_ENTRIES) return;
    fprintf(out, "          not determined:");
    for (int i = 0; i < MATRIX_ENTRIES; i++) {
        equations_entry(i, &row, &column);
        if (isnan(c->matrix.mt[row][column])) fprintf(out, " Mt%d%d", row + 1, column + 1);
    }
    fprintf(out, "\n          for these it takes motion, or more of it, of");
    for (int i = 0; i < DOFS; i++)
        if (missing[i]) fprintf(out, " %s", dof_names[i]);
    fprintf(out, "\n");
}

/* Prints the parts of a long motion, and whether the machine changed from part to part. */
static void print_parts(FILE *out, const struct identification *id) {
    const struct agreement *a = &id->over_time;
    bool used[AGREEMENT_LOGS][AGREEMENT_VALUES] = {{0}};
    struct agreement_place worst;
    char name[EQUATIONS_NAME];
    if (!id->parts) return;
    fprintf(out, "parts     %d of the motion, %d excluded", id->parts, id->parts_left_out);
    if (a->logs > 1) {
        fprintf(out, "; %d groups %s over time: chi-square %.1f of %d degrees of freedom, probability %.2g", a->logs,
                !a->evaluated ? "cannot be compared"
                : a->agree    ? "agree"
                              : "DISAGREE",
                a->chi_square, a->degrees, a->probability);
        if (a->evaluated && !a->agree && agreement_worst(a, used, &worst)) {
            equations_name(worst.value, name);
            fprintf(out, "\n          most: %s of group %d is %+.1f standard deviations from the others", name, worst.log + 1,
                    a->deviation[worst.log][worst.value]);
        }
    }
    fprintf(out, "\n");
}

static void print_method_c(FILE *out, const struct identification *id) {
    const struct method_c *c = &id->method_c;
    int decimals = identification_decimals(id->nominal_mt);
    if (!c->matrix.evaluated) {
        if (id->no_method_c.status) fprintf(out, "method C  not evaluated: %s\n\n", id->no_method_c.text);
        identification_at_pose_print(out, &c->at_pose);
        return;
    }
    identification_determined_print(out, c, id->nominal_mt);
    print_parts(out, id);
    fprintf(out, "%-4s %-6s %8s  %16s %7s\n", "", "unit", "nominal", "method C error %", "+-");
    for (int i = 0; i < IDENT_ENTRIES - 2; i++) { /* the matrix is symmetric: Mt42 is Mt24, Mt51 is
                                                   * Mt15 */
        const struct ident_entry *e = &ident_entries[i];
        fprintf(out, "%-4s %-6s %8.*f", e->name, e->unit, decimals, id->nominal_mt[e->row][e->col]);
        if (isnan(c->matrix.mt[e->row][e->col])) fprintf(out, "  not determined by these tests");
        else cell(out, id, &c->matrix, e), fprintf(out, " %7.*f", decimals, NUMERIC_95 * c->matrix.mt_std[e->row][e->col]);
        fprintf(out, "\n");
    }
    print_error_note(out);
    row(out, "legs 1..6: viscous", LEGS, c->viscous, c->viscous_std, 1, "N s/m");
    row(out, "dry, extending", LEGS, c->dry[0], c->dry_std[0], 2, "N");
    row(out, "dry, retracting", LEGS, c->dry[0] + 1, c->dry_std[0] + 1, 2, "N");
    if (c->springs) {
        row(out, "springs on x, y, z", 3, c->spring, c->spring_std, 1, "N/m");
        row(out, "on phi, theta, psi", 3, c->spring + 3, c->spring_std + 3, 1, "N m/rad");
    }
    if (c->payload.evaluated) print_payload(out, &c->payload);
    print_systematic(out, c);
    identification_common_gain_print(out, &id->common_gain);
    print_rest(out, &id->rest);
    print_weighed(out, &id->weighed);
    fprintf(out, "Mt by method C, kg, kg m, kg m^2 (-: not determined)\n");
    print_matrix(out, c->matrix.mt);
    fprintf(out, "nominal Mt, from the configuration\n");
    print_matrix(out, id->nominal_mt);
    identification_at_pose_print(out, &c->at_pose);
    fprintf(out, "\n");
}

/* Says why methods A and B have no matrix. */
static void print_no_matrix(FILE *out, const struct identification *id) {
    fprintf(out, "matrix    not evaluated: %s\n",
            id->refuted ? "the recording contradicts the configured machine" : "needs complete tests of all six axes");
}

static void print_methods_a_b(FILE *out, const struct identification *id) {
    int decimals = identification_decimals(id->nominal_mt);
    if (!id->method_a.evaluated) {
        print_no_matrix(out, id);
        return;
    }
    fprintf(out, "%-4s %-6s %8s  %16s  %16s  %16s %7s\n", "", "unit", "nominal", "method A error %", "modif. A error %", "method B error %",
            "+- A");
    for (int i = 0; i < IDENT_ENTRIES; i++) {
        const struct ident_entry *e = &ident_entries[i];
        fprintf(out, "%-4s %-6s %8.*f", e->name, e->unit, decimals, id->nominal_mt[e->row][e->col]);
        cell(out, id, &id->method_a, e);
        cell(out, id, &id->modified_a, e);
        cell(out, id, &id->method_b, e);
        fprintf(out, " %7.*f\n", decimals, NUMERIC_95 * id->method_a.mt_std[e->row][e->col]);
    }
    print_error_note(out);
    fprintf(out, "\ndiagonal of Bt: %.1f %.1f %.1f N s/m, %.2f %.2f %.2f N m s\n\n", id->method_a.bt[0][0], id->method_a.bt[1][1],
            id->method_a.bt[2][2], id->method_a.bt[3][3], id->method_a.bt[4][4], id->method_a.bt[5][5]);
}

void identification_table_print(FILE *out, const struct identification *id, bool sinusoids) {
    bool c_first = id->method_c.matrix.evaluated;
    fprintf(out, "\n");
    if (c_first) print_method_c(out, id);
    if (sinusoids) print_methods_a_b(out, id);
    if (!c_first) print_method_c(out, id);
}

/* Prints a row of the brief table: a number for each entry of the diagonal. format: conversion of a
 * number, with `*` for its decimals. */
static void brief_row(FILE *out, const char *name, const double value[DOFS], const char *format, int decimals, const char *unit) {
    fprintf(out, "%-9s", name);
    for (int i = 0; i < DOFS; i++) words_row(out, format, decimals, value[i]);
    fprintf(out, "%s\n", unit);
}

static bool all_determined(const struct method_c *c) {
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < DOFS; j++)
            if (isnan(c->matrix.mt[i][j])) return false;
    return true;
}

void identification_brief_print(FILE *out, const struct identification *id, bool sinusoids) {
    const struct method_c *c = &id->method_c;
    double nominal[DOFS], found[DOFS], error_pct[DOFS], interval_pct[DOFS];
    fputc('\n', out);
    if (sinusoids && !id->method_a.evaluated) print_no_matrix(out, id);
    if (!c->matrix.evaluated) {
        if (id->no_method_c.status) fprintf(out, "method C  not evaluated: %s\n\n", id->no_method_c.text);
        return;
    }
    fprintf(out, "%-9s", "");
    for (int i = 0; i < DOFS; i++) { /* the first DOFS of ident_entries are the diagonal */
        nominal[i] = id->nominal_mt[i][i], found[i] = c->matrix.mt[i][i];
        error_pct[i] = 100.0 * (found[i] / nominal[i] - 1.0);
        interval_pct[i] = isnan(found[i]) ? (double)NAN : 100.0 * NUMERIC_95 * c->matrix.mt_std[i][i] / nominal[i];
        fprintf(out, " %9s", ident_entries[i].name);
    }
    int decimals = identification_decimals(id->nominal_mt);
    fputc('\n', out);
    brief_row(out, "nominal", nominal, " %9.*f", decimals, " kg, kg m^2");
    brief_row(out, "method C", found, " %9.*f", decimals, "");
    brief_row(out, "error", error_pct, " %+9.*f", 2, " %");
    brief_row(out, "+- 95 %", interval_pct, " %9.*f", 2, " %");
    if (!all_determined(c)) identification_determined_print(out, c, id->nominal_mt);
    print_parts(out, id);
}
