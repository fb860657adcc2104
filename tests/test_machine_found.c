/* The configuration that an identification writes: each value is the mean given measurement and
 * configuration, and is written to the key that the control law reads. */
#include "support.h"

#include "config.h"
#include "machine_found.h"
#include "numeric.h"

static struct params machine;
static struct method_c method;
static struct estimate estimate;
static struct machine_found found;

/* Makes method C's result for a machine whose payload has these multiples of the configured mass
 * and inertia. The standard deviations are 1 % of the configured mass and of inertia_xx. */
static void find(double mass, double inertia) {
    config_default(&machine);
    memset(&method, 0, sizeof method), memset(&estimate, 0, sizeof estimate);
    const struct payload_params *p = &machine.payload;
    struct payload *load = &method.payload;
    *load = (struct payload){.evaluated = true, .whole = true, .possible = true};
    load->value[PAYLOAD_MASS] = mass * p->mass_kg, load->std[PAYLOAD_MASS] = 0.01 * p->mass_kg;
    const double diagonal[3] = {p->inertia_xx_kg_m2, p->inertia_yy_kg_m2, p->inertia_zz_kg_m2};
    for (int i = 0; i < 3; i++) load->std[PAYLOAD_CENTER + i] = 1e-3;
    for (int i = 0; i < 6; i++) {
        load->value[PAYLOAD_INERTIA + i] = i < 3 ? inertia * diagonal[i] : 0.0;
        load->std[PAYLOAD_INERTIA + i] = 0.01 * diagonal[0];
    }
    memcpy(load->nearest, load->value, sizeof load->nearest);
    for (int leg = 0; leg < LEGS; leg++) method.viscous[leg] = 2000.0, method.viscous_std[leg] = 50.0;
}

static void take(void) { machine_found(&machine, &method, &estimate, &found); }

static const char *note_of(const char *key) {
    for (int i = 0; i < found.notes; i++)
        if (!strcmp(found.note[i].key, key)) return found.note[i].text;
    return NULL;
}

/* The weighted mean has a smaller expected squared error than the measured or the configured value
 * alone, and it states its own error correctly. */
static void the_mean_has_the_least_expected_error(void **unused) {
    (void)unused;
    const double nominal = 100.0, most = 3.0, std = 2.0;
    double mean = 0.0, measured = 0.0, configured = 0.0, said = 0.0;
    enum { MACHINES = 20000 };
    uint64_t seed = 1;
    for (int i = 0; i < MACHINES; i++) {
        double truth = nominal + most * random_unit(&seed), noise = 0.0;
        for (int k = 0; k < 12; k++) noise += 0.5 * random_unit(&seed); /* variance 1 */
        struct found_value x = {truth + std * noise, std}, m = found_mean(x, nominal, most / sqrt(3.0));
        mean += square(m.value - truth), measured += square(x.value - truth), configured += square(nominal - truth);
        said = m.std;
    }
    assert_true(mean < 0.6 * measured && mean < 0.6 * configured);
    assert_close(sqrt(mean / MACHINES), said, 0.02 * said); /* tolerance: random error of 20000
                                                             * draws */
}

static void extremes_of_the_tolerance(void **unused) {
    (void)unused;
    struct found_value x = {7.0, 0.5}, exact = found_mean(x, 5.0, 0.0), unknown = found_mean(x, 5.0, (double)INFINITY);
    assert_true(exact.value == 5.0 && exact.std == 0.0);
    assert_true(unknown.value == 7.0 && unknown.std == 0.5);
}

/* A measured payload that deviates by less than the tolerance, with a standard deviation of 1 %,
 * has the weight t^2 / (t^2 + s^2) = 1/4. */
static void the_configured_payload_counts_within_its_tolerance(void **unused) {
    (void)unused;
    find(1.008, 1.0);
    take();
    assert_close(found.params.payload.mass_kg, 178.6 * 1.002, 0.01);
    assert_close(found.params.payload.inertia_xx_kg_m2, 13.6, 0.01);
    assert_non_null(note_of("payload.mass_kg"));
    assert_non_null(strstr(note_of("payload.mass_kg"), "was 178.6"));
    assert_int_equal(found.kept, 0);
}

static void another_payload_owes_nothing_to_the_configured_one(void **unused) {
    (void)unused;
    find(1.3, 1.3);
    take();
    assert_close(found.params.payload.mass_kg, 1.3 * 178.6, 0.05); /* the value is rounded to a
                                                                    * tenth */
    assert_close(found.params.payload.inertia_zz_kg_m2, 1.3 * 23.92, 0.01);
}

/* Method C's centre is relative to the configured one. Its z points down, while the configured
 * height is counted upwards. */
static void the_centre_moves_from_where_it_was(void **unused) {
    (void)unused;
    find(1.3, 1.3);
    method.payload.nearest[PAYLOAD_CENTER] = 0.02, method.payload.nearest[PAYLOAD_CENTER + 2] = 0.03;
    machine.payload.center_x_m = 0.1;
    take();
    assert_close(found.params.payload.center_x_m, 0.12, 1e-4);
    assert_close(found.params.payload.center_height_m, 0.13, 1e-4);
}

static void what_is_not_determined_stays_as_configured(void **unused) {
    (void)unused;
    find(1.3, 1.3);
    method.payload.whole = false;
    for (int i = PAYLOAD_INERTIA; i < PAYLOAD_VALUES; i++) method.payload.value[i] = method.payload.std[i] = NAN;
    method.viscous[2] = method.viscous_std[2] = NAN;
    take();
    assert_close(found.params.payload.mass_kg, 1.3 * 178.6, 0.05); /* the value is rounded to a
                                                                    * tenth */
    assert_true(found.params.payload.inertia_xx_kg_m2 == 13.6);
    assert_null(note_of("payload.inertia_xx_kg_m2"));
    assert_true(found.params.hydraulics.viscous_n_s_per_m[2] == 2000.0);
    assert_int_equal(found.kept, 1);
    method.payload.evaluated = false;
    take();
    assert_true(found.params.payload.mass_kg == 178.6);
}

static void set_dry(int leg, double extend_n, double retract_n, double std) {
    int unknown = UNKNOWN_DRY + 2 * leg;
    estimate.value[unknown] = extend_n, estimate.value[unknown + 1] = retract_n;
    estimate.noise[unknown][unknown] = estimate.noise[unknown + 1][unknown + 1] = square(std);
}

/* A constant force of 40 N, such as a pressure sensor's offset causes, is not friction. */
static void dry_friction_is_that_of_both_directions(void **unused) {
    (void)unused;
    int effect = effect_find("cylinder_coulomb_friction");
    find(1.0, 1.0);
    for (int leg = 0; leg < LEGS; leg++) set_dry(leg, 140.0, 60.0, 3.0);
    take();
    assert_true(found.params.effects[effect].on);
    for (int key = 0; key < 2; key++) assert_close(found.params.effects[effect].value[key][4], 100.0, 0.2);
}

/* Friction that a log did not determine is neither noise nor found. */
static void dry_friction_that_is_not_determined_stays_as_configured(void **unused) {
    (void)unused;
    int effect = effect_find("cylinder_coulomb_friction");
    for (int known = 0; known <= LEGS; known += 3) {
        find(1.0, 1.0);
        machine.effects[effect].on = true;
        for (int leg = 0; leg < LEGS; leg++) {
            for (int way = 0; way < 2; way++) machine.effects[effect].value[way][leg] = 100.0;
            set_dry(leg, 60.0, 60.0, leg < known ? 2.0 : 1e5);
            if (leg >= known) method.dry_std[leg][0] = method.dry_std[leg][1] = NAN;
        }
        take();
        assert_true(found.params.effects[effect].on);
        for (int leg = 0; leg < LEGS; leg++) assert_close(found.params.effects[effect].value[1][leg], leg < known ? 60.0 : 100.0, 0.2);
        assert_int_equal(found.kept, known < LEGS);
    }
}

/* Method C's payload is the configured one and what effects add to it. */
static void effects_of_the_payload_do_not_count_twice(void **unused) {
    (void)unused;
    int effect = effect_find("payload_mass");
    find(1.05, 1.0);
    machine.effects[effect].on = true;
    machine.effects[effect].value[0][0] = 0.05 * 178.6;
    take();
    assert_false(found.params.effects[effect].on);
    assert_close(found.params.payload.mass_kg, 1.05 * 178.6, 0.05);
    method.payload.whole = false;
    take();
    assert_true(found.params.effects[effect].on && found.params.payload.mass_kg == 178.6);
    assert_int_equal(found.kept, 1);
}

/* The dry friction of six legs is only noise here: its mean square does not exceed its variance. */
static void friction_that_is_noise_is_not_driven_against(void **unused) {
    (void)unused;
    static const double noise_n[LEGS] = {3.0, -5.0, 1.0, -2.0, 4.0, -1.0};
    int effect = effect_find("cylinder_coulomb_friction");
    find(1.0, 1.0);
    machine.effects[effect].on = true;
    for (int leg = 0; leg < LEGS; leg++) set_dry(leg, noise_n[leg] + 20.0, noise_n[leg] - 20.0, 8.0);
    take();
    assert_false(found.params.effects[effect].on);
}

/* Method C's viscous constant contains the viscous friction of an effect and replaces it. If
 * there is a law of friction that method C's constants cannot replace, all friction stays as
 * configured. */
static void other_laws_of_friction_are_kept(void **unused) {
    (void)unused;
    int viscous = effect_find("cylinder_viscous_friction"), stribeck = effect_find("cylinder_stribeck_friction");
    find(1.0, 1.0);
    effect_at(effect_table[viscous], 1.0, &machine.effects[viscous]);
    machine.effects[viscous].on = true;
    for (int leg = 0; leg < LEGS; leg++) method.viscous[leg] = 3000.0;
    take();
    assert_false(found.params.effects[viscous].on);
    assert_true(found.params.hydraulics.viscous_n_s_per_m[0] > 2000.0);
    machine.effects[stribeck].on = true;
    take();
    assert_true(found.params.effects[viscous].on);
    assert_true(found.params.hydraulics.viscous_n_s_per_m[0] == 2000.0);
    assert_int_equal(found.kept, 1);
}

static void the_file_reads_back_with_its_notes(void **unused) {
    (void)unused;
    struct params again;
    struct error error;
    find(1.3, 1.3);
    take();
    char *text = config_text_noted(&found.params, "head", found.note, found.notes);
    assert_non_null(text);
    assert_int_equal(config_parse(&again, text, strlen(text), "it", &error), 0);
    assert_memory_equal(&again, &found.params, sizeof again);
    assert_memory_equal(text, "# head\n", 7);
    assert_non_null(strstr(text, "# +- 3.5 (95 %); was 178.6; ["));
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_mean_has_the_least_expected_error),
        cmocka_unit_test(extremes_of_the_tolerance),
        cmocka_unit_test(the_configured_payload_counts_within_its_tolerance),
        cmocka_unit_test(another_payload_owes_nothing_to_the_configured_one),
        cmocka_unit_test(the_centre_moves_from_where_it_was),
        cmocka_unit_test(what_is_not_determined_stays_as_configured),
        cmocka_unit_test(dry_friction_is_that_of_both_directions),
        cmocka_unit_test(dry_friction_that_is_not_determined_stays_as_configured),
        cmocka_unit_test(effects_of_the_payload_do_not_count_twice),
        cmocka_unit_test(friction_that_is_noise_is_not_driven_against),
        cmocka_unit_test(other_laws_of_friction_are_kept),
        cmocka_unit_test(the_file_reads_back_with_its_notes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
