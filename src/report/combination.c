#include "combination.h"

#include <math.h>

#include "identification_table.h"
#include "numeric.h"
#include "printable.h"
#include "words.h"

enum { NAMED = 8 /* most values that the verdict names */, COLUMN = 12 };

/* Returns the unit of a matrix entry, a friction or a spring. value: its index in the equations. */
static const char *unit_of(int value) {
    static const char *const of_entries[] = {"kg", "kg m", "kg m^2"};
    int row, column;
    if (value >= UNKNOWN_SPRING) return value < UNKNOWN_SPRING + 3 ? "N/m" : "N m/rad";
    if (value >= UNKNOWN_DRY) return "N";
    if (value >= UNKNOWN_VISCOUS) return "N s/m";
    equations_entry(value, &row, &column);
    return of_entries[(row >= 3) + (column >= 3)];
}

static void judge_agreement(const struct agreement *a, struct verdict *v) {
    bool used[AGREEMENT_LOGS][AGREEMENT_VALUES] = {{0}};
    struct agreement_place place;
    char name[EQUATIONS_NAME];
    if (a->agree) return;
    if (!a->evaluated) {
        verdict_add(v, VERDICT_NOT_EVALUATED, "the logs determine nothing in common that could be compared");
        return;
    }
    verdict_add(v, VERDICT_FAIL, "the logs disagree: chi-square %.1f of %d degrees of freedom, by noise alone with probability %.1g",
                a->chi_square, a->degrees, a->probability);
    for (int i = 0; i < NAMED && agreement_worst(a, used, &place); i++) {
        /* The worst value is named even if only the overall test finds disagreement. */
        if (i && !a->apart[place.log][place.value]) return;
        equations_name(place.value, name);
        verdict_add(v, VERDICT_FAIL, "%s of log %d is %+.1f standard deviations from the others", name, place.log + 1,
                    a->deviation[place.log][place.value]);
    }
}

struct verdict combination_verdict(const struct combination *c) {
    struct verdict v = {.status = VERDICT_PASS,
                        .scope = "do the logs agree, has no log failed its own checks, is method C's result from all of them possible "
                                 "(combined.method_c.verdict), is every entry determined; not the error against the nominal matrix"};
    int open = 0;
    double std;
    judge_agreement(&c->agreement, &v);
    for (int l = 0; l < c->logs; l++)
        if (c->log[l].verdicts->run.status == VERDICT_FAIL)
            verdict_add(&v, VERDICT_FAIL, "log %d: %.100s", l + 1, c->log[l].verdicts->run.reason[0]);
    verdict_join(&v, &c->method_c);
    for (int i = 0; i < MATRIX_ENTRIES; i++) open += isnan(method_c_value(&c->all, i, &std));
    if (open) verdict_add(&v, VERDICT_NOT_EVALUATED, "%d of %d entries are not determined by all logs together", open, MATRIX_ENTRIES);
    return v;
}

static void cell(FILE *out, double value, int digits, bool apart) {
    words_row(out, "%*.*f%c", COLUMN - 1, digits, value, apart ? '*' : ' ');
}

static void print_values(FILE *out, const struct combination *c) {
    int decimals = identification_decimals(c->log[0].id->nominal_mt);
    for (int i = 0; i < AGREEMENT_VALUES; i++) {
        char name[EQUATIONS_NAME];
        int digits = i < UNKNOWN_VISCOUS ? decimals : 1;
        double std;
        if (i >= UNKNOWN_SPRING && !c->all.springs) break;
        equations_name(i, name);
        fprintf(out, "%-22s %-7s", name, unit_of(i));
        for (int l = 0; l < c->logs; l++) cell(out, method_c_value(&c->log[l].id->method_c, i, &std), digits, c->agreement.apart[l][i]);
        cell(out, method_c_value(&c->all, i, &std), digits, false);
        cell(out, NUMERIC_95 * std, digits, false);
        fprintf(out, "\n");
    }
}

static void print_payload(FILE *out, const struct combination *c) {
    int decimals = identification_decimals(c->log[0].id->nominal_mt);
    for (int i = 0; i < PAYLOAD_VALUES; i++) {
        int digits = i >= PAYLOAD_CENTER && i < PAYLOAD_INERTIA ? 5 : decimals;
        fprintf(out, "payload %-21s", payload_names[i]);
        for (int l = 0; l <= c->logs; l++) {
            const struct payload *p = l < c->logs ? &c->log[l].id->method_c.payload : &c->all.payload;
            cell(out, p->evaluated ? p->value[i] : (double)NAN, digits, false);
        }
        cell(out, c->all.payload.evaluated ? NUMERIC_95 * c->all.payload.std[i] : (double)NAN, digits, false);
        fprintf(out, "\n");
    }
}

void combination_table_print(FILE *out, const struct combination *c) {
    const struct agreement *a = &c->agreement;
    fprintf(out, "\n");
    for (int l = 0; l < c->logs; l++) {
        char path[1024];
        text_printable(c->log[l].path, path, sizeof path);
        fprintf(out, "log %-2d    %s: %s\n", l + 1, path, verdict_names[c->log[l].verdicts->run.status]);
        for (int i = 0; i < c->log[l].verdicts->run.reasons; i++) fprintf(out, "          %s\n", c->log[l].verdicts->run.reason[i]);
    }
    identification_determined_print(out, &c->all, c->log[0].id->nominal_mt);
    fprintf(out, "\n%-29s", "");
    for (int l = 0; l < c->logs; l++) fprintf(out, "%*s%-2d ", COLUMN - 3, "log ", l + 1);
    fprintf(out, "%*s %*s\n", COLUMN - 1, "all", COLUMN - 1, "+- 95 %");
    print_values(out, c);
    print_payload(out, c);
    identification_common_gain_print(out, &c->common_gain);
    identification_at_pose_print(out, &c->all.at_pose);
    fprintf(out, "\nagreement chi-square %.1f of %d degrees of freedom, by noise alone with probability %.2g: %s\n", a->chi_square,
            a->degrees, a->probability,
            !a->evaluated ? "nothing to compare"
            : a->agree    ? "the logs agree"
                          : "the logs disagree");
    verdict_print(&c->verdict, out);
}
