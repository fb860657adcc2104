/* Reasons for which samples and tests are excluded: each has a text, and a sample gets the right
 * one. */
#include "support.h"

#include "recording.h"
#include "refusal.h"

static struct params params;

/* Returns a cycle of the evaluated part in which every value is a number. */
static struct cycle whole(void) {
    struct cycle c = {.test_time_s = 1.0, .phase = PHASE_EVALUATE};
    all_legs(c.in.length_m, 1.4), all_legs(c.in.p1_pa, 2e6), all_legs(c.in.p2_pa, 1e6);
    return c;
}

static void every_reason_has_a_word_of_its_own_a_sentence_and_a_remedy(void **unused) {
    (void)unused;
    for (int i = 1; i < REFUSALS; i++) {
        const struct refusal_row *r = &refusals[i];
        assert_true(*r->word && *r->what && *r->why && *r->remedy);
        assert_true(r->why[strlen(r->why) - 1] != '.' && !strchr(r->why, '|') && !strchr(r->remedy, '|'));
        for (int j = 1; j < i; j++) assert_true(strcmp(r->word, refusals[j].word) && strcmp(r->why, refusals[j].why));
    }
    assert_string_equal(refusals[REFUSED_NOT].why, "");
}

static void each_flag_is_a_reason_and_an_unknown_one_is_no_pardon(void **unused) {
    (void)unused;
    struct cycle c = whole();
    assert_int_equal(refusal_of(&c, LEGS), REFUSED_NOT);
    for (int i = 0; i < SAMPLE_FLAGS; i++) {
        c.in.flags = 1u << i;
        assert_int_equal(refusal_of(&c, LEGS), REFUSED_STALE + i);
    }
    c.in.flags = SAMPLE_LATE;
    assert_string_equal(refusals[refusal_of(&c, LEGS)].word, "late");
    c.in.flags = SAMPLE_TWIN;
    assert_string_equal(refusals[refusal_of(&c, LEGS)].word, "twin");
    for (int i = SAMPLE_FLAGS; i < 32; i++) {
        c.in.flags = 1u << i;
        assert_int_equal(refusal_of(&c, LEGS), REFUSED_INVALID);
    }
}

static void a_length_that_is_no_number_counts_where_there_is_a_leg(void **unused) {
    (void)unused;
    for (int leg = 0; leg < LEGS; leg++) {
        struct cycle c = whole();
        c.in.length_m[leg] = leg % 2 ? (double)NAN : (double)INFINITY;
        assert_int_equal(refusal_of(&c, LEGS), REFUSED_NO_NUMBER);
        assert_int_equal(refusal_of(&c, leg), REFUSED_NOT);
    }
}

static void a_recorded_sample_has_the_reason_of_its_cycle(void **unused) {
    (void)unused;
    struct cycle c = whole();
    assert_int_equal(recording_sample_of(&params, &c).refused, REFUSED_NOT);
    c.in.flags = SAMPLE_OVERRUN, c.in.length_m[1] = (double)NAN;
    assert_int_equal(recording_sample_of(&params, &c).refused, REFUSED_OVERRUN);
    c = whole(), c.test_time_s = (double)NAN;
    assert_int_equal(recording_sample_of(&params, &c).refused, REFUSED_NO_NUMBER);
    /* the leg has neither a pressure nor a measured force */
    c = whole(), c.in.p1_pa[3] = c.force_n[3] = (double)NAN;
    assert_int_equal(recording_sample_of(&params, &c).refused, REFUSED_NO_NUMBER);
}

/* A channel that the log has must be valid in every sample; one that the log never has need not. */
static void a_channel_that_the_log_lacks_excludes_nothing(void **unused) {
    (void)unused;
    for (int has = 0; has < 2; has++) {
        struct recording r;
        struct error error;
        recording_init(&r, &params);
        for (int i = 0; i < 3; i++) {
            struct cycle c = whole();
            c.test_time_s = i;
            all_legs(c.out.valve, has && i ? 0.1 : (double)NAN);
            if (i == 2) c.in.flags = SAMPLE_STALE;
            assert_int_equal(recording_add(&r, &c, &error), STATUS_OK);
        }
        recording_settle(&r);
        assert_int_equal(r.test[0].sample[0].refused, has ? REFUSED_NO_NUMBER : REFUSED_NOT);
        assert_int_equal(r.test[0].sample[1].refused, REFUSED_NOT);
        assert_int_equal(r.test[0].sample[2].refused, REFUSED_STALE);
        recording_free(&r);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_reason_has_a_word_of_its_own_a_sentence_and_a_remedy),
        cmocka_unit_test(each_flag_is_a_reason_and_an_unknown_one_is_no_pardon),
        cmocka_unit_test(a_length_that_is_no_number_counts_where_there_is_a_leg),
        cmocka_unit_test(a_recorded_sample_has_the_reason_of_its_cycle),
        cmocka_unit_test(a_channel_that_the_log_lacks_excludes_nothing),
    };
    config_default(&params);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
