#include "identification_table.h"

static void cell(FILE *out, const struct identification *id, const struct method_result *m, const struct ident_entry *e) {
    fprintf(out, "  %8.3f %+7.2f", m->mt[e->row][e->col], ident_error_pct(id, m, e));
}

void identification_table_print(FILE *out, const struct identification *id) {
    if (!id->method_a.evaluated) {
        fprintf(out, "\nmatrix    not evaluated: needs complete tests of all six axes\n");
        return;
    }
    fprintf(out, "\n%-4s %-6s %8s  %16s  %16s  %16s %7s\n", "", "unit", "nominal", "method A error %", "modif. A error %",
            "method B error %", "std A");
    for (int i = 0; i < IDENT_ENTRIES; i++) {
        const struct ident_entry *e = &ident_entries[i];
        fprintf(out, "%-4s %-6s %8.3f", e->name, e->unit, id->nominal_mt[e->row][e->col]);
        cell(out, id, &id->method_a, e);
        cell(out, id, &id->modified_a, e);
        cell(out, id, &id->method_b, e);
        fprintf(out, " %7.3f\n", id->method_a.mt_std[e->row][e->col]);
    }
    fprintf(out, "\ndiagonal of Bt: %.1f %.1f %.1f N s/m, %.2f %.2f %.2f N m s\n\n", id->method_a.bt[0][0], id->method_a.bt[1][1],
            id->method_a.bt[2][2], id->method_a.bt[3][3], id->method_a.bt[4][4], id->method_a.bt[5][5]);
}
