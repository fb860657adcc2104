/* Every effect of the catalogue against the equations: a rig with the effect leaves no residual
 * under a model with the same effect. */
#include "support.h"

#include <stdlib.h>

#include "diagnose.h"
#include "gap_rig.h"

static struct params params;

static int setup(void **state) {
    (void)state;
    config_default(&params);
    params.sensors.enabled = false;
    return 0;
}

static void rig(struct recording *out, const struct params *machine) {
    struct error error;
    if (gap_rig(&params, machine, DOFS, out, &error)) fail_msg("%s", error.text);
}

/* Returns the mean normalised square of a model's residual; the model error is a thousandth of each
 * channel. */
static double left(const struct recording *recording, const struct params *model) {
    struct residual_data data;
    struct fit_data fit;
    struct error error;
    assert_int_equal(residual_prepare(&data, recording, CYCLES_ALL, &error), 0);
    fit_data_init(&fit, &data, &params, 1);
    double *white = malloc((size_t)fit.values * sizeof *white), square = INFINITY;
    if (fit_residual(&fit, model, white)) square = fit_square(fit.values, white) / fit.values;
    free(white);
    fit_data_free(&fit);
    residual_free(&data);
    return square;
}

/* Every sixth effect, or in `make test-long` every one. */
static void an_effect_in_rig_and_model_leaves_no_residual(void **state) {
    (void)state;
    slow_sweep();
    if (SANITIZED) skip_because(MINUTES_UNDER_SANITIZERS);
    for (int i = 0; effect_table[i]; i++) {
        if (!more_cases() && i % 6) continue;
        struct params machine = params;
        struct recording recording;
        effect_at(effect_table[i], 1.0, &machine.effects[i]);
        rig(&recording, &machine);
        double without = left(&recording, &params), with = left(&recording, &machine);
        recording_free(&recording);
        /* limits in units of a thousandth of the channel: a machine without any effect leaves 0.1,
         * because of the harmonics. The remainder is due to stiction, whose times are found with a
         * finite resolution, and to jumps of valve and flow beyond the harmonics. For backlash the
         * time of a knock is found from forces that are no faster. */
        double share = strcmp(effect_table[i]->name, "joint_backlash") ? 3e-4 : pow(effect_table[i]->law_error, 2.0);
        if (!(with < 0.7 + share * without)) fail_msg("%s: %g with it in the model, %g without", effect_table[i]->name, with, without);
        bool seen = without > 1.3 * with;
        /* these effects act on time stamps alone, or on sensors that the rig lacks */
        assert_true(seen || !strcmp(effect_table[i]->name, "clock_skew") || !strncmp(effect_table[i]->name, "force_sensor", 12));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test_setup(an_effect_in_rig_and_model_leaves_no_residual, setup)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
