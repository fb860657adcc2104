/* The base of the gap workflow: variables whose columns are the slopes of the residuals. */
#include "support.h"

#include <stdlib.h>

#include "base.h"
#include "fit.h"
#include "gap_rig.h"
#include "numeric.h"

enum { TESTS = 2 };

/* The friction of a leg that is held follows the balance of forces up to its limit. A step of a
 * pressure zero that is large beside this limit leaves the range in which it follows. The fit then
 * ends where no step succeeds, short of the best values, and states too little uncertainty. */
static void columns_are_slopes_beside_dry_friction(void **state) {
    (void)state;
    slow_case();
    struct params params, machine;
    struct recording r;
    struct residual_data data;
    struct fit_data fit;
    struct variable v[FIT_VARIABLES], fine[FIT_VARIABLES];
    struct error error;
    config_default(&params);
    machine = params;
    struct effect_values *friction = &machine.effects[effect_find("cylinder_coulomb_friction")];
    friction->on = true;
    for (int k = 0; k < LEGS; k++) friction->value[0][k] = friction->value[1][k] = 100.0;
    if (gap_rig(&params, &machine, TESTS, &r, &error)) fail_msg("%s", error.text);
    assert_int_equal(residual_prepare(&data, &r, CYCLES_ALL, &error), STATUS_OK);
    fit_data_init(&fit, &data, &machine, 1);
    int n = base_variables(&machine, data.equations, v);
    memcpy(fine, v, sizeof v);
    for (int i = 0; i < n; i++) fine[i].step *= 0.1;

    size_t values = (size_t)fit.values;
    double *raw = calloc(values, sizeof *raw), *column = calloc((size_t)n * values, sizeof *column),
           *slope = calloc((size_t)n * values, sizeof *slope);
    assert_true(fit_raw(&fit, &machine, raw));
    assert_true(fit_columns(&fit, &machine, raw, n, v, NULL, column) && fit_columns(&fit, &machine, raw, n, fine, NULL, slope));
    for (int i = 0; i < n; i++) {
        double off = 0.0, size = 0.0;
        for (size_t a = (size_t)i * values; a < (size_t)(i + 1) * values; a++)
            off += square(column[a] - slope[a]), size += square(slope[a]);
        if (!(off < square(0.03) * size + 1e-12)) fail_msg("%s of leg %d: column is off by %g", v[i].name, v[i].leg + 1, sqrt(off / size));
    }
    free(raw);
    free(column);
    free(slope);
    fit_data_free(&fit);
    residual_free(&data);
    recording_free(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(columns_are_slopes_beside_dry_friction),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
