/* The loop, fuzzed against an independent model of what must never happen (supervisor_model.h).
 * `make soak` runs a hundred times as long. */
#include "supervisor_fuzz.h"

/* Every possible change of state; a fuzzer that misses one proves nothing about it. */
static const struct {
    enum state from, to;
} changes[] = {
    {STATE_INIT, STATE_SETTLED},
    {STATE_INIT, STATE_FAULT},
    {STATE_SETTLED, STATE_PRESSURISING},
    {STATE_SETTLED, STATE_FAULT},
    {STATE_PRESSURISING, STATE_SETTLED},
    {STATE_PRESSURISING, STATE_FAULT},
    {STATE_PRESSURISING, STATE_ENGAGING},
    {STATE_ENGAGING, STATE_READY},
    {STATE_ENGAGING, STATE_PARKING},
    {STATE_ENGAGING, STATE_FAULT},
    {STATE_READY, STATE_TESTING},
    {STATE_READY, STATE_PARKING},
    {STATE_READY, STATE_FAULT},
    {STATE_TESTING, STATE_READY},
    {STATE_TESTING, STATE_PARKING},
    {STATE_TESTING, STATE_FAULT},
    {STATE_PARKING, STATE_SETTLED},
    {STATE_PARKING, STATE_FAULT},
    {STATE_FAULT, STATE_INIT},
};

static void a_million_random_cycles_break_no_rule_of_the_model_and_see_every_change_of_state(void **state) {
    (void)state;
    slow_case();
    static struct run run;
    if (!fuzz(1, 1000000, false, &run, NULL)) fail_msg("see above");
    for (unsigned i = 0; i < sizeof changes / sizeof *changes; i++) {
        long seen = run.model.edges[changes[i].from][changes[i].to];
        print_message("# %s -> %s: %ld\n", state_names[changes[i].from], state_names[changes[i].to], seen);
        assert_true(seen > 0);
    }
}

static void neither_do_they_on_the_simulated_platform(void **state) {
    (void)state;
    slow_case();
    static struct run run;
    if (!fuzz(1000001, random_cases(100000), true, &run, NULL)) fail_msg("see above");
}

static void no_memory_grows(void **state) {
    (void)state;
    slow_case();
    static struct run run;
    if (!fuzz(2000001, 20 * EPISODE, false, &run, NULL)) fail_msg("see above");
    size_t before = mallinfo2().uordblks;
    if (!fuzz(2000001, 60 * EPISODE, false, &run, NULL)) fail_msg("see above");
    assert_int_equal(mallinfo2().uordblks, before);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_million_random_cycles_break_no_rule_of_the_model_and_see_every_change_of_state),
        cmocka_unit_test(neither_do_they_on_the_simulated_platform),
        cmocka_unit_test(no_memory_grows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
