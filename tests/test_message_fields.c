/* Reads messages field by field, of the types that no run's log contains; tests/scenarios/export.sh
 * reads the types of a log. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "hexid_gap_t.h"
#include "hexid_loop_stats_t.h"
#include "hexid_method_c_t.h"
#include "message_fields.h"
#include "messages.h"

enum { CAPACITY = 16384 };
static unsigned char buffer[CAPACITY];

static int field_of(const struct message *m, const char *name) {
    for (int f = 0; m->type->field[f].name; f++)
        if (!strcmp(m->type->field[f].name, name)) return f;
    fail_msg("no field %s", name);
    return -1;
}

static int encode_gap(void) {
    char *effects[] = {"lag", "leak"}, *parameters[] = {"a", "bb", "ccc"}, *units[] = {"s", "", "m^3/(s Pa)"}, *with[] = {"x"};
    double share[] = {0.25, (double)NAN}, z[] = {4.0, 5.0}, values[] = {1.0, 2.0, 3.0}, std[] = {0.1, 0.2, 0.3};
    int8_t legs[] = {0, 6, -1};
    hexid_gap_t m = {.time_ns = -7,
                     .verdict = "effect_named",
                     .reason = "",
                     .next_experiment = "z",
                     .effect_count = 2,
                     .effects = effects,
                     .share_explained = share,
                     .z = z,
                     .parameter_count = 3,
                     .parameters = parameters,
                     .parameter_legs = legs,
                     .parameter_units = units,
                     .values_si = values,
                     .values_std_si = std,
                     .ambiguous_count = 1,
                     .ambiguous_with = with,
                     .simulated = 1,
                     .unexplained_fraction = 0.5,
                     .held_out_before_length_m = 11.0,
                     .noise_floor_valve = 12.0};
    return hexid_gap_t_encode(buffer, 0, CAPACITY, &m);
}

static void a_gap_is_read_field_by_field(void **unused) {
    (void)unused;
    struct message m;
    assert_true(message_read(CHANNEL_GAP, buffer, encode_gap(), &m));
    assert_int_equal(message_integer(&m, field_of(&m, "time_ns"), 0), -7);
    assert_string_equal(message_text(&m, field_of(&m, "effects"), 1), "leak");
    assert_string_equal(message_text(&m, field_of(&m, "parameters"), 2), "ccc");
    assert_string_equal(message_text(&m, field_of(&m, "parameter_units"), 1), "");
    assert_string_equal(message_text(&m, field_of(&m, "ambiguous_with"), 0), "x");
    assert_int_equal(message_integer(&m, field_of(&m, "parameter_legs"), 1), 6);
    assert_int_equal(message_integer(&m, field_of(&m, "parameter_legs"), 2), -1);
    assert_true(isnan(message_real(&m, field_of(&m, "share_explained"), 1)) && message_real(&m, field_of(&m, "z"), 1) == 5.0);
    assert_int_equal(m.value[field_of(&m, "values_std_si")].count, 3);
    assert_true(message_real(&m, field_of(&m, "values_std_si"), 2) == 0.3 &&
                message_real(&m, field_of(&m, "unexplained_fraction"), 0) == 0.5);
    assert_int_equal(message_integer(&m, field_of(&m, "simulated"), 0), 1);
    assert_true(message_real(&m, field_of(&m, "held_out_before_length_m"), 0) == 11.0);
    assert_true(message_real(&m, field_of(&m, "noise_floor_valve"), 0) == 12.0);
}

static void integers_of_every_size_keep_their_sign(void **unused) {
    (void)unused;
    struct message m;
    hexid_method_c_t c = {.time_ns = INT64_MIN, .tests = -1, .determined = -3};
    assert_true(message_read(CHANNEL_METHOD_C, buffer, hexid_method_c_t_encode(buffer, 0, CAPACITY, &c), &m));
    assert_true(message_integer(&m, field_of(&m, "time_ns"), 0) == INT64_MIN);
    assert_true(message_integer(&m, field_of(&m, "tests"), 0) == -1);
    assert_true(message_integer(&m, field_of(&m, "determined"), 0) == -3);
}

static void statistics_of_older_logs_are_read(void **unused) {
    (void)unused;
    struct message m;
    hexid_loop_stats_t old = {.cycles = 5000, .timed = 1, .exec_max_us = 31.0};
    int size = hexid_loop_stats_t_encode(buffer, 0, CAPACITY, &old);
    assert_true(message_read(CHANNEL_LOOP_STATS, buffer, size, &m));
    assert_string_equal(m.type->name, "loop_stats_1");
    assert_int_equal(message_integer(&m, field_of(&m, "cycles"), 0), 5000);
    assert_true(message_real(&m, field_of(&m, "exec_max_us"), 0) == 31.0);
}

static void a_message_cut_anywhere_or_too_long_is_none(void **unused) {
    (void)unused;
    struct message m = {0};
    int size = encode_gap();
    for (int cut = 0; cut < size; cut++) {
        /* a block of the exact size, so that a sanitizer detects an overrun */
        unsigned char *exact = malloc((size_t)cut + 1);
        memcpy(exact, buffer, (size_t)cut);
        assert_false(message_read(CHANNEL_GAP, exact, cut, &m));
        free(exact);
    }
    assert_false(message_read(CHANNEL_GAP, buffer, size + 1, &m));
    assert_false(message_read(CHANNEL_EVENT, buffer, size, &m));
    assert_null(m.type);
}

/* The n-th text is reached by skipping those before it, so reading an unlimited number would take
 * quadratic time. */
static void counts_have_a_bound(void **unused) {
    (void)unused;
    enum { MANY = ELEMENTS_MAX + 1 };
    static char *texts[MANY];
    static double numbers[MANY];
    static int8_t legs[1]; /* no parameter has one, but memcpy accepts no null pointer */
    static unsigned char large[CAPACITY + 64 * MANY];
    struct message m;
    for (int i = 0; i < MANY; i++) texts[i] = "";
    hexid_gap_t gap = {.verdict = "",
                       .reason = "",
                       .next_experiment = "",
                       .effects = texts,
                       .share_explained = numbers,
                       .z = numbers,
                       .parameter_legs = legs};
    gap.effect_count = ELEMENTS_MAX;
    assert_true(message_read(CHANNEL_GAP, large, hexid_gap_t_encode(large, 0, sizeof large, &gap), &m));
    gap.effect_count = MANY;
    assert_false(message_read(CHANNEL_GAP, large, hexid_gap_t_encode(large, 0, sizeof large, &gap), &m));
}

static void only_channels_of_the_table_are_known(void **unused) {
    (void)unused;
    assert_true(message_known(CHANNEL_EVENT) && message_known(CHANNEL_IDENTIFICATION) && message_known(CHANNEL_TEST_RESULT));
    assert_false(message_known(CHANNEL_STATE) || message_known(CHANNEL_COMMAND) || message_known("SOMEBODY_ELSE"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_gap_is_read_field_by_field),
        cmocka_unit_test(integers_of_every_size_keep_their_sign),
        cmocka_unit_test(statistics_of_older_logs_are_read),
        cmocka_unit_test(a_message_cut_anywhere_or_too_long_is_none),
        cmocka_unit_test(counts_have_a_bound),
        cmocka_unit_test(only_channels_of_the_table_are_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
