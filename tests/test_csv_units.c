/* Units of columns become SI; factors and offsets are part of a unit. */
#include "support.h"

#include <math.h>

#include "csv_units.h"

static struct csv_unit unit;

static void units_are_their_definitions(void **unused) {
    (void)unused;
    static const struct {
        const char *text;
        enum csv_quantity quantity;
        double si; /* the unit's value in SI */
    } cases[] = {
        {"mm", CSV_PLACE, 1e-3},
        {"in", CSV_PLACE, 0.0254},
        {"ft", CSV_LENGTH, 0.3048},
        {"lbf", CSV_FORCE, 0.45359237 * 9.80665},
        {"kip", CSV_FORCE, 453.59237 * 9.80665},
        {"kgf", CSV_FORCE, 9.80665},
        {"psi", CSV_PRESSURE, 0.45359237 * 9.80665 / (0.0254 * 0.0254)},
        {"bar", CSV_PRESSURE, 1e5},
        {"deg", CSV_PLACE, 3.14159265358979 / 180.0},
        {"rev", CSV_PLACE, 6.28318530717959},
        {"rpm", CSV_PLACE, 6.28318530717959 / 60.0},
        {"lbf ft", CSV_FORCE, 1.3558179483314},
        {"N m", CSV_FORCE, 1.0},
        {"ns", CSV_TIME, 1e-9},
        {"%", CSV_SHARE, 0.01},
        {"0.1", CSV_SHARE, 0.1},
        {"85.2 N", CSV_FORCE, 85.2},
        {"85.2N", CSV_FORCE, 85.2},
        {"-1 kN", CSV_FORCE, -1e3},
        {"2.5e-3 mm", CSV_PLACE, 2.5e-6},
        {"MN", CSV_FORCE, 1e6},
        {"mN", CSV_FORCE, 1e-3},
        {"KN", CSV_FORCE, 1e3},
        {"BAR", CSV_PRESSURE, 1e5},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        if (!csv_unit_parse(cases[i].text, cases[i].quantity, &unit)) fail_msg("%s: no unit", cases[i].text);
        if (!(fabs(unit.factor / cases[i].si - 1.0) < 1e-12)) fail_msg("%s: %.15g", cases[i].text, unit.factor);
        assert_true(unit.offset == 0.0);
    }
}

static void an_offset_is_in_the_unit_before_it(void **unused) {
    (void)unused;
    assert_true(csv_unit_parse("bar-1.013", CSV_PRESSURE, &unit) && unit.factor == 1e5 && fabs(unit.offset + 1.013e5) < 1e-9);
    assert_true(csv_unit_parse("25 bar - 1.013", CSV_PRESSURE, &unit) && unit.factor == 25e5 && fabs(unit.offset + 1.013e5) < 1e-9);
    assert_true(csv_unit_parse("mm+1827", CSV_LENGTH, &unit) && fabs(unit.offset - 1.827) < 1e-15);
}

static void a_unit_says_what_the_column_is(void **unused) {
    (void)unused;
    assert_true(csv_unit_parse("mm/s", CSV_PLACE, &unit) && unit.speed && !unit.turns);
    assert_true(csv_unit_parse("deg", CSV_PLACE, &unit) && !unit.speed && unit.turns);
    assert_true(csv_unit_parse("rpm", CSV_PLACE, &unit) && unit.speed && unit.turns);
    assert_true(csv_unit_parse("Nm", CSV_FORCE, &unit) && unit.turns);
    assert_true(csv_unit_parse("deg", CSV_ANGLE, &unit) && !unit.turns); /* an angle is expected
                                                                          * here, so it does not
                                                                          * make the axis a turning
                                                                          * one */
}

static void what_is_no_unit_is_none(void **unused) {
    (void)unused;
    static const struct {
        const char *text;
        enum csv_quantity quantity;
    } cases[] = {
        {"", CSV_FORCE},        {"kg", CSV_FORCE},        {"A", CSV_FORCE},    {"mm", CSV_FORCE},      {"N", CSV_PLACE},
        {"m/s2", CSV_PLACE},    {"mm/s", CSV_LENGTH},     {"mn", CSV_FORCE},   {"0 N", CSV_FORCE},     {"nan N", CSV_FORCE},
        {"inf N", CSV_FORCE},   {"N+x", CSV_FORCE},       {"N+1x", CSV_FORCE}, {"85.2", CSV_FORCE},    {"?", CSV_PLACE},
        {"? N", CSV_FORCE},     {"s", CSV_NO_QUANTITY},   {"- N", CSV_FORCE},  {"1e999 N", CSV_FORCE}, {"N N", CSV_FORCE},
        {"furlong", CSV_PLACE}, {"bar--1", CSV_PRESSURE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        if (csv_unit_parse(cases[i].text, cases[i].quantity, &unit))
            fail_msg("\"%s\" is a unit: %g %g", cases[i].text, unit.factor, unit.offset);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(units_are_their_definitions),
        cmocka_unit_test(an_offset_is_in_the_unit_before_it),
        cmocka_unit_test(a_unit_says_what_the_column_is),
        cmocka_unit_test(what_is_no_unit_is_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
