/* Wrong orders of legs, each found from lengths and forces, with and without a reference, as tests
 * of an axis and as any motion; and symmetries of the machine, which only the reference reveals. */
#include "ident_rig.h"

#include <time.h>

#include "leg_order.h"
#include "admit_rig.h"

enum { DURATION_S = 2, ORDERS = 27 };
enum target { OF_LENGTHS, OF_FORCES, OF_BOTH, TARGETS };

static struct rig *rig;

/* Writes to place[k] where leg k stands. Numbers 1 .. 15 exchange two legs, 16 .. 20 begin with
 * another leg, 21 .. 26 count backwards. */
static void order_of(int number, int place[LEGS]) {
    int n = 1;
    for (int k = 0; k < LEGS; k++) place[k] = k;
    for (int a = 0; a < LEGS; a++)
        for (int b = a + 1; b < LEGS; b++, n++)
            if (n == number) place[a] = b, place[b] = a;
    for (int k = 0; k < LEGS; k++) {
        if (number >= 21) place[k] = (number - 21 + LEGS - k) % LEGS;
        else if (number >= 16) place[k] = (k + number - 15) % LEGS;
    }
}

/* True for orders of lengths and forces together that leave this machine as it is, because it has
 * three equal pairs of legs. */
static bool symmetry(int number) { return number == 0 || number == 17 || number == 19 || number == 22 || number == 24 || number == 26; }

static void put(const double from[LEGS], const int place[LEGS], double to[LEGS]) {
    for (int k = 0; k < LEGS; k++) to[place[k]] = from[k];
}

/* Returns a sample of the rig in which both pressures of every leg vary, without a change of its
 * force. */
static struct cycle sample(int d, int i) {
    struct cycle c = rig->cycle[d][i];
    for (int k = 0; k < LEGS; k++) {
        double wave_pa = 2e4 * sin(7.0 * c.test_time_s + k);
        c.in.p2_pa[k] += wave_pa, c.in.p1_pa[k] += wave_pa * rig->areas.a2_m2[k] / rig->areas.a1_m2[k];
        c.out.valve[k] = c.ref[k] = (double)NAN;
    }
    return c;
}

static const int as_stated[LEGS] = {0, 1, 2, 3, 4, 5};

/* Checks the rig's six tests, with lengths and pressures in these orders. */
static int check_places(const struct params *params, const int lengths[LEGS], const int forces[LEGS], bool reference, bool axes,
                        struct error *error) {
    struct recording r;
    recording_init(&r, params);
    for (int d = 0; d < DOFS; d++)
        for (int i = 0; i < rig->samples; i++) {
            struct cycle c = sample(d, i);
            const struct hal_sample in = c.in;
            double motion[3][DOFS];
            rig_motion(rig, d, c.test_time_s, motion);
            put(in.length_m, lengths, c.in.length_m);
            put(in.p1_pa, forces, c.in.p1_pa);
            put(in.p2_pa, forces, c.in.p2_pa);
            for (int k = 0; k < DOFS && reference; k++) c.ref[k] = motion[0][k];
            if (!axes) c.dof = DOF_NONE;
            assert_int_equal(recording_add(&r, &c, error), 0);
        }
    *error = (struct error){0};
    int status = admit_rig(&r, false, error);
    recording_free(&r);
    return status;
}

/* Checks the tests with the legs of `target` in the order `number`. */
static int check(const struct params *params, int number, enum target target, bool reference, bool axes, struct error *error) {
    int place[LEGS];
    order_of(number, place);
    return check_places(params, target == OF_FORCES ? as_stated : place, target == OF_LENGTHS ? as_stated : place, reference, axes, error);
}

static void expect_name(const struct error *error, int number, enum target target) {
    static const char *const what[TARGETS] = {"lengths: ", "pressures: ", "lengths and pressures, or the drawing: "};
    int place[LEGS];
    char name[64];
    order_of(number, place);
    for (int a = 0; a < LEGS && number < 16; a++)
        if (place[a] > a) {
            snprintf(name, sizeof name, "%slegs %d and %d exchanged", what[target], a + 1, place[a] + 1);
            if (!strstr(error->text, name)) fail_msg("\"%s\" does not say \"%s\"", error->text, name);
        }
    /* on a symmetric machine, lengths in one order look like forces in the inverse order, and one
     * order of both like another */
    bool named = strstr(error->text, what[target]) || (target != OF_BOTH && strstr(error->text, "pressures: "));
    if (!named) fail_msg("\"%s\" does not say \"%s\"", error->text, what[target]);
}

/* Tries one in four of every step-th order, in `make check` one in sixteen and in `make test-long`
 * all, because cutting any motion takes long. */
static void each_wrong_order_is_named(bool reference, bool axes, int step) {
    struct error error;
    step *= quick() ? 16 : more_cases() ? 1 : 4;
    if (check(&rig->params, 0, OF_BOTH, reference, axes, &error)) fail_msg("as stated: %s", error.text);
    for (enum target target = OF_LENGTHS; target < TARGETS; target++)
        for (int number = 1; number < ORDERS; number += step) {
            bool symmetric = target == OF_BOTH && symmetry(number);
            int status = check(&rig->params, number, target, reference, axes, &error);
            if (symmetric && !reference && status) fail_msg("order %d is a symmetry: %s", number, error.text);
            if (!symmetric || reference) assert_int_equal(status, STATUS_USAGE);
            if (symmetric && reference && !strstr(error.text, "the lengths follow the reference with leg 1 in place"))
                fail_msg("%s", error.text);
            if (!symmetric) expect_name(&error, number, target);
        }
}

static void each_wrong_order_is_named_with_a_reference(void **unused) {
    (void)unused;
    each_wrong_order_is_named(true, true, 1);
}

static void each_wrong_order_is_named_without_a_reference(void **unused) {
    (void)unused;
    each_wrong_order_is_named(false, true, 1);
}

static void each_wrong_order_is_named_in_any_motion_with_a_reference(void **unused) {
    (void)unused;
    each_wrong_order_is_named(true, false, 4);
}

static void each_wrong_order_is_named_in_any_motion_without_a_reference(void **unused) {
    (void)unused;
    slow_case();
    each_wrong_order_is_named(false, false, 4);
}

static void expect_refusal(const int lengths[LEGS], const int forces[LEGS], bool axes, const char *name) {
    struct error error;
    assert_int_equal(check_places(&rig->params, lengths, forces, false, axes, &error), STATUS_USAGE);
    if (!strstr(error.text, name)) fail_msg("\"%s\" does not say \"%s\"", error.text, name);
}

/* Orders that are two exchanges from the stated one, and lengths and pressures in two different
 * orders. The legs of a symmetric machine have several such names. */
static void rare_orders_are_named(void **unused) {
    (void)unused;
    slow_case();
    static const int pairs[LEGS] = {1, 0, 3, 2, 4, 5}, three[LEGS] = {2, 1, 4, 3, 0, 5}, near[LEGS] = {1, 2, 0, 3, 4, 5};
    static const int one_four[LEGS] = {3, 1, 2, 0, 4, 5}, one_two[LEGS] = {1, 0, 2, 3, 4, 5};
    for (int axes = quick(); axes < 2; axes++) {
        expect_refusal(pairs, as_stated, axes, "they would with lengths: legs 1 and 2 exchanged, legs 3 and 4 exchanged");
        expect_refusal(as_stated, pairs, axes, "they would with pressures: legs 1 and 2 exchanged, legs 3 and 4 exchanged");
        expect_refusal(three, as_stated, axes, "they would with lengths: legs 1 3 5 in places 3 5 1");
        expect_refusal(as_stated, three, axes, "they would with pressures: legs 1 3 5 in places 3 5 1");
        expect_refusal(near, near, axes,
                       "they would with lengths and pressures, or the drawing: legs 1 2 3 in places 2 3 1, or what a symm");
        expect_refusal(pairs, pairs, axes,
                       "they would with lengths and pressures, or the drawing: legs 1 and 2 exchanged, legs 3 and 4 exch");
        expect_refusal(three, three, axes, "they would with lengths and pressures, or the drawing: legs ");
        expect_refusal(one_four, one_two, axes, "lengths: legs 1 and 4 exchanged, and pressures: legs 1 and 2 exchanged");
    }
}

static void symmetries_are_listed(void **unused) {
    (void)unused;
    char text[LEG_ORDER_TEXT];
    leg_order_symmetries(&rig->params, text);
    assert_string_equal(text, "leg 1 in place 3, counted on; leg 1 in place 5, counted on; leg 1 in place 2, counted backwards; "
                              "leg 1 in place 4, counted backwards; leg 1 in place 6, counted backwards");
    /* With one joint moved aside, no other order gives the same machine. */
    struct params odd = rig->params;
    struct kinematics k;
    kinematics_place(&k, &odd);
    odd.geometry.lower.given = true;
    for (int i = 0; i < LEGS; i++)
        for (int x = 0; x < 2; x++) odd.geometry.lower.leg[i][x] = k.lower[i][x] + (i == 2 ? 0.01 : 0.0);
    leg_order_symmetries(&odd, text);
    assert_string_equal(text, "");
}

/* The lists of platform joints and of base joints must have the same order of legs. */
static void lists_that_do_not_belong_together_are_refused_by_name(void **unused) {
    (void)unused;
    slow_case();
    for (int number = 1; number < ORDERS; number++) {
        struct params wrong = rig->params;
        struct kinematics k;
        struct error error;
        int place[LEGS];
        order_of(number, place);
        kinematics_place(&k, &wrong);
        wrong.geometry.upper.given = true;
        for (int leg = 0; leg < LEGS; leg++)
            for (int x = 0; x < 2; x++) wrong.geometry.upper.leg[place[leg]][x] = k.upper[leg][x];
        assert_int_equal(check(&wrong, 0, OF_BOTH, true, true, &error), STATUS_USAGE);
        bool impossible = kinematics_init(&k, &wrong, &(struct error){0}) != 0;
        if (!impossible && !strstr(error.text, "the joints of the platform are listed otherwise than those of the base"))
            fail_msg("order %d: %s", number, error.text);
        if (impossible || (quick() && number % 8)) continue;
        assert_int_equal(check(&wrong, 0, OF_BOTH, false, false, &error), STATUS_USAGE);
        if (!strstr(error.text, "the joints of the platform are listed otherwise than those of the base"))
            fail_msg("any motion, order %d: %s", number, error.text);
    }
}

/* All orders are tried on six tests of 5 s at 500 Hz, in less than 0.2 s of processor time. */
static void it_is_cheap(void **unused) {
    (void)unused;
    struct recording r;
    struct residual_data data;
    struct leg_order order;
    struct error error;
    recording_init(&r, &rig->params);
    for (int d = 0; d < DOFS; d++)
        for (int i = 0; i < rig->samples; i++) {
            struct cycle c = sample(d, i);
            assert_int_equal(recording_add(&r, &c, &error), 0);
        }
    assert_int_equal(admit_rig(&r, false, &error), 0);
    assert_int_equal(residual_prepare(&data, &r, CYCLES_ALL, &error), 0);
    clock_t before = clock();
    assert_int_equal(leg_order_find(&data, &r, 0, &order, &error), 0);
    double seconds = (double)(clock() - before) / CLOCKS_PER_SEC;
    print_message("%.3f s, unexplained %.2g\n", seconds, order.stated);
    assert_below(seconds, 0.2);
    assert_false(order.refuted);
    residual_free(&data);
    recording_free(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_wrong_order_is_named_with_a_reference),
        cmocka_unit_test(each_wrong_order_is_named_without_a_reference),
        cmocka_unit_test(each_wrong_order_is_named_in_any_motion_with_a_reference),
        cmocka_unit_test(each_wrong_order_is_named_in_any_motion_without_a_reference),
        cmocka_unit_test(rare_orders_are_named),
        cmocka_unit_test(symmetries_are_listed),
        cmocka_unit_test(lists_that_do_not_belong_together_are_refused_by_name),
        cmocka_unit_test(it_is_cheap),
    };
    rig = rig_create(11, DURATION_S);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
