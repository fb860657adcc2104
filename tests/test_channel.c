/* Scaling of an analogue channel. */
#include "support.h"

#include "channel.h"
#include "config.h"

static void channel_turns_milliamperes_into_metres_and_refuses_a_broken_wire(void **state) {
    struct params p;
    (void)state;
    config_default(&p);
    struct channel_params c = p.length_channel;
    for (int i = 0; i < LEGS; i++) {
        c.raw_min[i] = 4000, c.raw_max[i] = 20000;
        c.si_min[i] = 1.4, c.si_max[i] = 2.3, c.offset[i] = 0.01;
        c.low[i] = 1.38, c.high[i] = 2.35;
    }
    assert_close(channel_si(&c, 2, 4000), 1.41, 1e-12); /* rounding */
    assert_close(channel_si(&c, 2, 20000), 2.31, 1e-12);
    assert_true(isnan(channel_si(&c, 2, 0))); /* 0 mA */
    assert_true(isnan(channel_si(&c, 2, (double)NAN)));
    assert_int_equal(channel_raw(&c, 2, 1.86, INT16_MAX), 12000);
    assert_int_equal(channel_raw(&c, 2, (double)NAN, INT16_MAX), INT16_MIN);
    assert_int_equal(channel_raw(&c, 2, 1e9, INT16_MAX), INT16_MAX);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(channel_turns_milliamperes_into_metres_and_refuses_a_broken_wire),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
