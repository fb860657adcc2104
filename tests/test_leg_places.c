/* Orders of legs have the names by which an engineer finds the exchanged plugs. */
#include "support.h"

#include "leg_places.h"

static void expect(const int place[LEGS], const char *name) {
    struct leg_places order;
    char is[LEG_PLACES_NAME];
    memcpy(order.place, place, sizeof order.place);
    leg_places_name(&order, is);
    assert_string_equal(is, name);
}

static void every_order_has_its_name(void **unused) {
    (void)unused;
    expect((const int[]){0, 1, 2, 3, 4, 5}, "as stated");
    expect((const int[]){0, 4, 2, 3, 1, 5}, "legs 2 and 5 exchanged");
    expect((const int[]){2, 3, 4, 5, 0, 1}, "leg 1 in place 3, counted on");
    expect((const int[]){1, 0, 5, 4, 3, 2}, "leg 1 in place 2, counted backwards");
    expect((const int[]){1, 0, 3, 2, 4, 5}, "legs 1 and 2 exchanged, legs 3 and 4 exchanged");
    expect((const int[]){1, 0, 3, 2, 5, 4}, "legs 1 and 2 exchanged, legs 3 and 4 exchanged, legs 5 and 6 exchanged");
    expect((const int[]){2, 1, 4, 3, 0, 5}, "legs 1 3 5 in places 3 5 1");
    expect((const int[]){1, 2, 3, 5, 0, 4}, "legs 1 2 3 4 6 5 in places 2 3 4 6 5 1");
    expect((const int[]){1, 2, 0, 4, 5, 3}, "legs 1 2 3 in places 2 3 1, legs 4 5 6 in places 5 6 4");
}

static void common_orders_are_permutations_and_differ(void **unused) {
    (void)unused;
    struct leg_places list[LEG_PLACES_COMMON];
    leg_places_common(list);
    for (int i = 0; i < LEG_PLACES_COMMON; i++) {
        unsigned seen = 0;
        for (int k = 0; k < LEGS; k++) seen |= 1u << list[i].place[k];
        assert_int_equal(seen, (1u << LEGS) - 1);
        assert_int_equal(leg_places_stated(&list[i]), i == 0);
        for (int j = 0; j < i; j++) assert_memory_not_equal(&list[i], &list[j], sizeof list[i]);
    }
}

static void an_order_is_as_many_exchanges_away_as_it_takes(void **unused) {
    (void)unused;
    struct leg_places order, list[LEG_PLACES_COMMON];
    leg_places_common(list);
    for (int i = 0; i < LEG_PLACES_COMMON; i++)
        if (i >= 1 && i <= 15) assert_int_equal(leg_places_exchanges(&list[i]), 1);
    order = list[0];
    for (int k = 0; k < LEGS; k++) {
        assert_int_equal(leg_places_exchanges(&order), k);
        if (k < LEGS - 1) order = leg_places_exchanged(&order, k, k + 1);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_order_has_its_name),
        cmocka_unit_test(common_orders_are_permutations_and_differ),
        cmocka_unit_test(an_order_is_as_many_exchanges_away_as_it_takes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
