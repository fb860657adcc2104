#include "identification_tables.h"

#include <math.h>
#include <string.h>

#include "html.h"
#include "identification_table.h"
#include "numeric.h"
#include "params.h"
#include "words.h"

enum { COLUMNS = 3 };

struct quantity {
    double value, std;
};

typedef struct quantity quantity_of(const struct identification_log *log, int row);

/* A table with a row for each quantity, and for each log columns of configured and found values. */
struct comparison {
    const char *head;
    int rows;
    void (*label)(FILE *out, int row);
    const char *configured_name;
    quantity_of *configured;       /* NULL: there is no configured column */
    /* Returns the value that counts as 100 % of a difference. No percentage is written if this is
     * NULL or returns 0. */
    double (*whole)(const struct identification_log *log, int row);
    int methods;
    struct {
        const char *name;
        quantity_of *found;
    } method[COLUMNS];
};

/* Writes an estimate such as "272.36 ± 0.74", with two digits of `deviation`, half the width of the
 * 95 % interval; without a deviation, the value to three decimals. */
static void estimate(FILE *out, double value, double deviation) {
    bool known = deviation > 0.0 && isfinite(deviation);
    int decimals = known ? (int)fmin(fmax(1.0 - floor(log10(deviation)), 0.0), 9.0) : 3;
    html_print(out, "%.*f", decimals, value);
    if (known && isfinite(value)) fprintf(out, " ± %.*f", decimals, deviation);
}

static bool any_found(const struct identification_report *r, const struct comparison *c, int method) {
    for (int i = 0; i < r->logs; i++)
        for (int row = 0; row < c->rows; row++)
            if (isfinite(c->method[method].found(&r->log[i], row).value)) return true;
    return false;
}

static bool same_configured(const struct identification_report *r, const struct comparison *c) {
    for (int i = 1; i < r->logs; i++)
        for (int row = 0; row < c->rows; row++)
            if (c->configured(&r->log[i], row).value != c->configured(&r->log[0], row).value) return false;
    return true;
}

/* Writes a cell with an estimate, and "+0.13 %, 1.2 σ from log 1" below it. */
static void found_cell(FILE *out, const struct identification_report *r, const struct comparison *c, int method, int log, int row) {
    struct quantity x = c->method[method].found(&r->log[log], row), first = c->method[method].found(&r->log[0], row);
    struct quantity configured = c->configured ? c->configured(&r->log[log], row) : (struct quantity){(double)NAN, 0.0};
    double off = x.value - configured.value, apart = (x.value - first.value) / hypot(x.std, first.std);
    double whole = c->whole ? c->whole(&r->log[log], row) : 0.0;
    bool percent = whole > 0.0 && isfinite(off), compared = log > 0 && isfinite(apart);
    fprintf(out, "<td class=\"n%s%s\">", log || r->logs == 1 ? "" : " group", fabs(off) > NUMERIC_95 * x.std ? " off" : "");
    estimate(out, x.value, NUMERIC_95 * x.std);
    if (percent || compared) fputs("<small>", out);
    if (percent) fprintf(out, "%+.2f %%", 100.0 * off / whole);
    if (compared) fprintf(out, "%s%.1f σ from log 1", percent ? ", " : "", fabs(apart));
    fputs(percent || compared ? "</small></td>" : "</td>", out);
}

static void head_cells(FILE *out, const char *name, int columns) {
    if (columns > 1) fprintf(out, "<th class=\"group\" colspan=\"%d\">%s</th>", columns, name);
    else fprintf(out, "<th class=\"n\">%s</th>", name);
}

static void log_cells(FILE *out, int columns) {
    for (int i = 0; i < columns; i++) fprintf(out, columns > 1 ? "<th class=\"n%s\">log %d</th>" : "<th></th>", i ? "" : " group", i + 1);
}

/* Writes the table of a comparison. Returns false, with nothing written, if no method found
 * anything. */
static bool compare(FILE *out, const struct identification_report *r, const struct comparison *c) {
    bool found[COLUMNS] = {0}, any = false;
    for (int m = 0; m < c->methods; m++) found[m] = any_found(r, c, m), any = any || found[m];
    if (!any) return false;
    /* Without a configured column (friction, springs) the columns belong together: if one has a
     * value, all are shown. */
    for (int m = 0; m < c->methods && !c->configured; m++) found[m] = true;
    int configured = !c->configured ? 0 : same_configured(r, c) ? 1 : r->logs;
    fprintf(out, "<div class=\"wide\"><table class=\"values\">\n<tr><th>%s</th>", c->head);
    if (configured) head_cells(out, c->configured_name, configured);
    for (int m = 0; m < c->methods; m++)
        if (found[m]) head_cells(out, c->method[m].name, r->logs);
    if (r->logs > 1) fputs("</tr>\n<tr><th></th>", out), log_cells(out, configured);
    for (int m = 0; m < c->methods && r->logs > 1; m++)
        if (found[m]) log_cells(out, r->logs);
    fputs("</tr>\n", out);
    for (int row = 0; row < c->rows; row++) {
        fputs("<tr><td>", out);
        c->label(out, row);
        fputs("</td>", out);
        for (int i = 0; i < configured; i++)
            fprintf(out, "<td class=\"n\">%.*f</td>", identification_decimals_of(c->configured(&r->log[i], row).value),
                    c->configured(&r->log[i], row).value);
        for (int m = 0; m < c->methods; m++)
            for (int i = 0; i < r->logs && found[m]; i++) found_cell(out, r, c, m, i, row);
        fputs("</tr>\n", out);
    }
    html_table_end(out);
    return true;
}

/* --- entries of the matrix */

static struct quantity entry_of(const struct method_result *m, int row) {
    const struct ident_entry *e = &ident_entries[row];
    if (!m->evaluated) return (struct quantity){(double)NAN, (double)NAN};
    return (struct quantity){m->mt[e->row][e->col], m->mt_std[e->row][e->col]};
}

static struct quantity entry_nominal(const struct identification_log *log, int row) {
    return (struct quantity){log->id->nominal_mt[ident_entries[row].row][ident_entries[row].col], 0.0};
}
static double entry_whole(const struct identification_log *log, int row) { return ident_scale(log->id->nominal_mt, &ident_entries[row]); }
static struct quantity entry_a(const struct identification_log *log, int row) { return entry_of(&log->id->method_a, row); }
static struct quantity entry_c(const struct identification_log *log, int row) { return entry_of(&log->id->method_c.matrix, row); }

static void unit_words(FILE *out, const char *unit) {
    for (; *unit; unit++) fputs(*unit == '^' ? "" : *unit == '2' ? "²" : (char[]){*unit, 0}, out);
}

static void entry_label(FILE *out, int row) {
    fprintf(out, "%s <span class=\"small\">", ident_entries[row].name);
    unit_words(out, ident_entries[row].unit);
    fputs("</span>", out);
}

void table_entries(FILE *out, const struct identification_report *r) {
    static const struct comparison entries = {"entry",       IDENT_ENTRIES, entry_label, "nominal",
                                              entry_nominal, entry_whole,   2,           {{"method C", entry_c}, {"method A", entry_a}}};
    if (!compare(out, r, &entries)) fputs("<p class=\"notice\">No matrix was identified: see the reasons above.</p>\n", out);
}

/* --- payload */

static double payload_scale(int row) { return row >= PAYLOAD_CENTER && row < PAYLOAD_INERTIA ? 1e3 : 1.0; }

static struct quantity payload_configured(const struct identification_log *log, int row) {
    const struct payload_params *p = &log->params->payload;
    const double value[PAYLOAD_VALUES] = {[PAYLOAD_MASS] = p->mass_kg, [PAYLOAD_INERTIA] = p->inertia_xx_kg_m2,
                                          p->inertia_yy_kg_m2,         p->inertia_zz_kg_m2,
                                          p->inertia_xy_kg_m2,         p->inertia_xz_kg_m2,
                                          p->inertia_yz_kg_m2};
    return (struct quantity){value[row], 0.0};
}

/* Returns the value that counts as 100 % of a payload parameter's difference. For a product of
 * inertia it is the geometric mean of the two moments; for the mass centre there is none (0). */
static double payload_whole(const struct identification_log *log, int row) {
    const struct payload_params *p = &log->params->payload;
    const double moment[3] = {p->inertia_xx_kg_m2, p->inertia_yy_kg_m2, p->inertia_zz_kg_m2};
    static const int of[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
    if (row == PAYLOAD_MASS) return p->mass_kg;
    return row < PAYLOAD_INERTIA ? 0.0 : sqrt(moment[of[row - PAYLOAD_INERTIA][0]] * moment[of[row - PAYLOAD_INERTIA][1]]);
}

static struct quantity payload_found(const struct identification_log *log, int row) {
    const struct payload *p = &log->id->method_c.payload;
    if (!log->id->method_c.matrix.evaluated || !p->evaluated) return (struct quantity){(double)NAN, (double)NAN};
    return (struct quantity){payload_scale(row) * p->value[row], payload_scale(row) * p->std[row]};
}

static void payload_label(FILE *out, int row) {
    static const char *const name[PAYLOAD_VALUES] = {"mass",       "mass centre x", "mass centre y", "mass centre z", "inertia xx",
                                                     "inertia yy", "inertia zz",    "inertia xy",    "inertia xz",    "inertia yz"};
    fprintf(out, "%s <span class=\"small\">%s</span>", name[row], row == PAYLOAD_MASS ? "kg" : row < PAYLOAD_INERTIA ? "mm" : "kg m²");
}

bool table_payload(FILE *out, const struct identification_report *r) {
    static const struct comparison payload = {
        "payload", PAYLOAD_VALUES, payload_label, "configured", payload_configured, payload_whole, 1, {{"method C", payload_found}}};
    return compare(out, r, &payload);
}

/* --- friction */

static struct quantity friction_of(const struct method_c *c, double value, double std) {
    return c->matrix.evaluated ? (struct quantity){value, std} : (struct quantity){(double)NAN, (double)NAN};
}
static struct quantity viscous(const struct identification_log *log, int leg) {
    const struct method_c *c = &log->id->method_c;
    return friction_of(c, c->viscous[leg], c->viscous_std[leg]);
}
static struct quantity extending(const struct identification_log *log, int leg) {
    const struct method_c *c = &log->id->method_c;
    return friction_of(c, c->dry[leg][0], c->dry_std[leg][0]);
}
static struct quantity retracting(const struct identification_log *log, int leg) {
    const struct method_c *c = &log->id->method_c;
    return friction_of(c, c->dry[leg][1], c->dry_std[leg][1]);
}

static void leg_label(FILE *out, int row) { fprintf(out, "%d", row + 1); }

bool table_friction(FILE *out, const struct identification_report *r) {
    static const struct comparison friction = {
        "leg", LEGS, leg_label, NULL,
        NULL,  NULL, 3,         {{"viscous, N s/m", viscous}, {"dry, extending, N", extending}, {"dry, retracting, N", retracting}}};
    return compare(out, r, &friction);
}

static struct quantity spring(const struct identification_log *log, int i) {
    const struct method_c *c = &log->id->method_c;
    return c->springs ? friction_of(c, c->spring[i], c->spring_std[i]) : (struct quantity){(double)NAN, (double)NAN};
}

static void spring_label(FILE *out, int row) {
    fprintf(out, "%s <span class=\"small\">%s</span>", words_axes[row], row < 3 ? "N/m" : "N m/rad");
}

bool table_springs(FILE *out, const struct identification_report *r) {
    static const struct comparison springs = {"spring on", DOFS, spring_label, NULL, NULL, NULL, 1, {{"method C", spring}}};
    return compare(out, r, &springs);
}

/* --- matrices */

static void matrix(FILE *out, const char *name, const double mt[DOFS][DOFS], const double std[DOFS][DOFS]) {
    int decimals = identification_decimals(mt);
    double least = 0.5 * pow(10.0, -decimals); /* smaller values are written as 0, to avoid
                                                * "-0.000" */
    fprintf(out, "<div><h3>%s</h3>\n", name);
    html_table(out, "matrix", "|>x|>y|>z|>φ|>θ|>ψ");
    for (int i = 0; i < DOFS; i++) {
        fprintf(out, "<tr><th>%s</th>", words_axes[i]);
        for (int j = 0; j < DOFS; j++) {
            html_print(out, "<td class=\"n\">%.*f", decimals, fabs(mt[i][j]) < least ? 0.0 : mt[i][j]);
            if (std && isfinite(std[i][j])) fprintf(out, "<small>± %.*f</small>", decimals, NUMERIC_95 * std[i][j]);
            fputs("</td>", out);
        }
        fputs("</tr>\n", out);
    }
    html_table_end(out);
    fputs("</div>\n", out);
}

static void method(FILE *out, const char *name, const struct method_result *m) {
    if (m->evaluated) matrix(out, name, m->mt, m->mt_std);
}

void table_matrices(FILE *out, const struct identification *id) {
    fputs("<div class=\"two\">\n", out);
    matrix(out, "Nominal", id->nominal_mt, NULL);
    method(out, "Method C", &id->method_c.matrix);
    method(out, "Method A", &id->method_a);
    method(out, "Modified A", &id->modified_a);
    method(out, "Method B", &id->method_b);
    fputs("</div>\n", out);
}
