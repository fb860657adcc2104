/* Every mechanism of the table is complete, and the statements in its file agree with each
 * other. */
#include "support.h"

#include <string.h>

#include "config_keys.h"
#include "csv_format.h"
#include "inverse_dynamics.h"
#include "mechanism.h"

static void the_configuration_names_it(void **unused) {
    (void)unused;
    struct params params;
    struct error error;
    char text[64];
    config_default(&params);
    assert_true(mechanism_table[0]->default_machine && params_mechanism(&params) == mechanism_table[0]);
    for (int i = 0; mechanism_table[i]; i++) {
        snprintf(text, sizeof text, "mechanism: %s\n", mechanism_table[i]->name);
        assert_int_equal(config_parse(&params, text, strlen(text), "text", &error), STATUS_OK);
        assert_ptr_equal(params_mechanism(&params), mechanism_table[i]);
        assert_int_equal(mechanism_find(mechanism_table[i]->name), i);
        assert_string_equal(mechanism_names[i], mechanism_table[i]->name);
    }
    assert_int_equal(mechanism_find("crane"), -1);
}

static void it_is_within_the_arrays_and_has_its_words(void **unused) {
    (void)unused;
    for (const struct mechanism *const *m = mechanism_table; *m; m++) {
        assert_in_range((*m)->legs, 1, LEGS);
        assert_in_range((*m)->axes, 1, DOFS);
        assert_true(!(*m)->pose || ((*m)->legs == LEGS && (*m)->axes == DOFS));
        assert_true((*m)->words.machine && (*m)->words.legs && (*m)->words.length && (*m)->words.tone);
        assert_true((*m)->forces && (*m)->leg_mass);
    }
}

/* A mechanism that is not driven has no survey and no closed loop; one without a pose has no
 * inertia matrix. The commands for these must refuse it, because the table has no functions for
 * them. */
static void its_refusals_are_complete(void **unused) {
    (void)unused;
    for (const struct mechanism *const *m = mechanism_table; *m; m++) {
        bool driven = !(*m)->refuses.run;
        assert_true(driven || ((*m)->refuses.survey && (*m)->refuses.replay));
        assert_true((*m)->pose || ((*m)->refuses.identify && (*m)->refuses.run));
        assert_true((*m)->axes == DOFS || (*m)->refuses.axis);
        assert_true(!(*m)->csv_column == !(*m)->refuses.no_column);
    }
}

static void its_masses_are_keys_of_the_configuration(void **unused) {
    (void)unused;
    for (const struct mechanism *const *m = mechanism_table; *m; m++) {
        int count = 0;
        for (; count < MECHANISM_MASSES && (*m)->masses[count].offset; count++) {
            const struct mechanism_mass *mass = &(*m)->masses[count];
            struct config_key key;
            assert_true(config_key_find(mass->name, &key));
            assert_int_equal(key.offset, mass->offset);
            assert_int_equal(key.count, mass->per_leg ? LEGS : 1);
        }
        assert_in_range(count, 1, MECHANISM_MASSES - 1);
    }
}

/* A CSV column belongs to numbered legs or to one leg; the column that marks a mechanism belongs to
 * no other one. */
static void its_columns_are_its_own(void **unused) {
    (void)unused;
    for (const struct mechanism *const *m = mechanism_table; *m; m++) {
        int legs = 0, of = (*m)->csv_column ? csv_column_named((*m)->csv_column) : -1;
        for (int column = 0; column < CSV_COLUMNS; column++) {
            bool length = csv_columns[column].offset >= offsetof(struct cycle, in.length_m) &&
                          csv_columns[column].offset < offsetof(struct cycle, in.length_m) + sizeof(double[LEGS]);
            legs += length && csv_column_of(column, *m);
        }
        assert_int_equal(legs, (*m)->legs);
        for (const struct mechanism *const *other = mechanism_table; *other && (*m)->csv_column; other++)
            assert_int_equal(csv_column_of(of, *other), other == m);
    }
}

/* At rest at neutral, the force for an acceleration of one leg is that leg's column of the mass
 * matrix. The two are derived differently: by Newton's pose and the bodies' equations, and by
 * factors of the matrix. */
static void its_forces_are_its_mass_times_acceleration(void **unused) {
    (void)unused;
    for (int i = 0; mechanism_table[i]; i++) {
        const struct mechanism *m = mechanism_table[i];
        struct params params;
        struct inverse_dynamics d;
        struct rigid_legs legs;
        double mass[LEGS][LEGS], rest_n[LEGS], force_n[LEGS];
        config_default(&params);
        params.mechanism = (enum mechanism_kind)i;
        inverse_dynamics_init(&d, &params, 1e-3, 0.0);
        m->leg_mass(&params, mass);
        struct inverse_dynamics_input in = {0};
        for (int k = 0; k < LEGS; k++) in.leg[k][0] = d.cylinder.machine.bodies.neutral_length_m[k];
        assert_true(m->forces(&d, &in, &legs, rest_n));
        for (int l = 0; l < m->legs; l++) {
            in.leg[l][2] = 1.0;
            assert_true(m->forces(&d, &in, &legs, force_n));
            in.leg[l][2] = 0.0;
            /* tolerance: rounding of forces of 1e3 N, and of a pose known to 1e-12 m */
            for (int k = 0; k < m->legs; k++) assert_close(force_n[k] - rest_n[k], mass[k][l], 1e-7);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_configuration_names_it), cmocka_unit_test(it_is_within_the_arrays_and_has_its_words),
        cmocka_unit_test(its_refusals_are_complete),  cmocka_unit_test(its_masses_are_keys_of_the_configuration),
        cmocka_unit_test(its_columns_are_its_own),    cmocka_unit_test(its_forces_are_its_mass_times_acceleration),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
