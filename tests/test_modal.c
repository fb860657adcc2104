/* Feedback in modal coordinates (modal.h), against the modes that loop_model.h finds by another
 * derivation of the inertia. */
#include "support.h"

#include "loop_model.h"
#include "modal.h"

static const double neutral[DOFS] = {0};
static const char *const machines[] = {"config/tian2015.yaml", "config/desktop.yaml", "config/simulator.yaml"};
enum { MACHINES = 3 };

struct machine {
    struct params params;
    struct kinematics kinematics;
    struct modal modal;
};

static void open_machine(struct machine *m, const char *path, const char *setting) {
    struct error error;
    if (config_load(&m->params, path, &setting, setting != NULL, &error) || kinematics_init(&m->kinematics, &m->params, &error) ||
        modal_init(&m->modal, &m->params, &m->kinematics, &error))
        fail_msg("%s", error.text);
}

static void all_modes_have_the_same_gains_as_shipped(void **unused) {
    (void)unused;
    struct machine m;
    const double ref_m[LEGS] = {1.7, 1.8, 1.9, 1.7, 1.8, 1.9}, length_m[LEGS] = {1.701, 1.799, 1.9, 1.7003, 1.8, 1.8999};
    double seen_m[LEGS];
    for (int i = 0; i < MACHINES; i++) {
        open_machine(&m, machines[i], NULL);
        modal_lengths(&m.modal, ref_m, length_m, seen_m);
        assert_memory_equal(seen_m, length_m, sizeof seen_m);
        assert_true(modal_gain(&m.modal, length_m) == 1.0);
    }
}

/* The oil columns of a leg at mid-stroke are alike, so frequencies are as 1 / sqrt(mass). */
static void a_mode_has_its_frequency_for_its_gain(void **unused) {
    (void)unused;
    static const struct {
        const char *setting;
        double exponent;
    } cases[] = {{"control.modal=1", 1.0}, {"control.modal=0.4", 0.4}};
    struct machine m;
    struct loop_place place;
    for (int n = 0; n < 2 * MACHINES; n++) {
        open_machine(&m, machines[n / 2], cases[n % 2].setting);
        assert_true(loop_place_find(&place, &m.params, neutral, 0.0));
        for (int mode = 0; mode < DOFS; mode++) {
            double wanted = pow(place.mass_kg[0] / place.mass_kg[mode], 0.5 * cases[n % 2].exponent);
            assert_close(modal_gain(&m.modal, place.motion[mode]), wanted, 1e-3 * wanted);
            assert_true(fabs(place.mix[mode][mode] - modal_gain(&m.modal, place.motion[mode])) < 1e-3 * wanted);
        }
    }
}

/* An error along one mode stays along it, times the mode's gain. */
static void an_error_in_a_mode_stays_in_it(void **unused) {
    (void)unused;
    struct machine m;
    struct loop_place place;
    open_machine(&m, NULL, "control.modal=0.7");
    assert_true(loop_place_find(&place, &m.params, neutral, 0.0));
    for (int mode = 0; mode < DOFS; mode++) {
        double ref_m[LEGS], length_m[LEGS], seen_m[LEGS];
        for (int i = 0; i < LEGS; i++) ref_m[i] = 1.8, length_m[i] = 1.8 - 1e-3 * place.motion[mode][i];
        modal_lengths(&m.modal, ref_m, length_m, seen_m);
        for (int i = 0; i < LEGS; i++) assert_close(ref_m[i] - seen_m[i], place.mix[mode][mode] * (ref_m[i] - length_m[i]), 1e-6);
    }
}

/* No motion gets less than the slowest mode, or more than the fastest one. */
static void gains_lie_between_the_modes(void **unused) {
    (void)unused;
    struct machine m;
    struct loop_place place;
    open_machine(&m, NULL, "control.modal=1");
    assert_true(loop_place_find(&place, &m.params, neutral, 0.0));
    for (int n = 0; n < 1 << LEGS; n++) {
        double motion[LEGS];
        for (int i = 0; i < LEGS; i++) motion[i] = n >> i & 1 ? 1.0 : -1.0;
        double gain = modal_gain(&m.modal, motion);
        assert_true(gain > 1.0 - 1e-6 && gain < place.mix[DOFS - 1][DOFS - 1] * (1.0 + 1e-6));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_modes_have_the_same_gains_as_shipped),
        cmocka_unit_test(a_mode_has_its_frequency_for_its_gain),
        cmocka_unit_test(an_error_in_a_mode_stays_in_it),
        cmocka_unit_test(gains_lie_between_the_modes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
