/* Results on the wire: every field has the value that its name states, and values that were not
 * evaluated are NaN. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "hexid_identification_t.h"
#include "hexid_method_c_t.h"
#include "hexid_loop_stats_2_t.h"
#include "hexid_test_result_t.h"
#include "ident_messages.h"

enum { CAPACITY = 16384 }; /* the recorder's */

static unsigned char buffer[CAPACITY];
static double counter;

/* Gives each number of a test a value of its own. */
static void fill(double *numbers, int count) {
    for (int i = 0; i < count; i++) numbers[i] = counter += 1.0;
}

static void a_test_result_keeps_every_number(void **unused) {
    (void)unused;
    struct test_result t = {.test = 3, .dof = DOF_PHI, .samples = 2500, .excluded = 7};
    hexid_test_result_t m;
    fill(&t.frequency_hz, 1), fill(&t.amplitude, 1), fill(&t.achieved_amplitude, 1), fill(&t.phase_deg, 1);
    fill(t.unwanted_pct, DOFS), fill(&t.pose[0][0], 2 * DOFS), fill(&t.wrench[0][0], 2 * DOFS);
    fill(t.pose_rms, DOFS), fill(t.wrench_rms, DOFS), fill(t.pose_std, DOFS), fill(t.wrench_std, DOFS);
    int size = test_result_encode(&t, 99, buffer, CAPACITY);
    assert_int_equal(hexid_test_result_t_decode(buffer, 0, size, &m), size);
    assert_true(m.time_ns == 99 && m.test == 3 && m.dof == DOF_PHI && m.samples == 2500 && m.excluded == 7 && m.complete == 1);
    assert_string_equal(m.dof_name, "phi");
    assert_true(m.frequency_hz == t.frequency_hz && m.amplitude_m_or_rad == t.amplitude);
    assert_true(m.achieved_m_or_rad == t.achieved_amplitude && m.phase_deg == t.phase_deg);
    for (int i = 0; i < DOFS; i++) {
        assert_true(m.unwanted_pct[i] == t.unwanted_pct[i]);
        assert_true(m.pose_sin_m_rad[i] == t.pose[i][0] && m.pose_cos_m_rad[i] == t.pose[i][1]);
        assert_true(m.pose_rms_m_rad[i] == t.pose_rms[i] && m.pose_std_m_rad[i] == t.pose_std[i]);
        assert_true(m.wrench_sin_n_nm[i] == t.wrench[i][0] && m.wrench_cos_n_nm[i] == t.wrench[i][1]);
        assert_true(m.wrench_rms_n_nm[i] == t.wrench_rms[i] && m.wrench_std_n_nm[i] == t.wrench_std[i]);
    }
    hexid_test_result_t_decode_cleanup(&m);
    for (int capacity = 0; capacity < size; capacity++) assert_int_equal(test_result_encode(&t, 99, buffer, capacity), -1);
}

static void loop_statistics_keep_every_number(void **unused) {
    (void)unused;
    struct loop_statistics s = {.cycles = 5000, .overruns = 3, .lost = 2, .timed = true, .stalls = 14};
    hexid_loop_stats_2_t m;
    fill(&s.period_s, 1), fill(s.wake_us, 4), fill(s.exec_us, 4), fill(&s.pace, 1), fill(&s.longest_stall_s, 1);
    int size = loop_stats_encode(&s, 99, buffer, CAPACITY);
    assert_int_equal(hexid_loop_stats_2_t_decode(buffer, 0, size, &m), size);
    assert_true(m.time_ns == 99 && m.cycles == 5000 && m.overruns == 3 && m.lost_records == 2 && m.period_s == s.period_s && m.timed == 1);
    assert_true(m.wake_p50_us == s.wake_us[0] && m.wake_p99_us == s.wake_us[1]);
    assert_true(m.wake_p999_us == s.wake_us[2] && m.wake_max_us == s.wake_us[3]);
    assert_true(m.exec_p50_us == s.exec_us[0] && m.exec_p99_us == s.exec_us[1]);
    assert_true(m.exec_p999_us == s.exec_us[2] && m.exec_max_us == s.exec_us[3]);
    assert_true(m.pace_ratio == s.pace && m.stalls == 14 && m.longest_stall_s == s.longest_stall_s);
    s.timed = false; /* a virtual clock stands still within a cycle, so its zeros measure nothing */
    hexid_loop_stats_2_t_decode(buffer, 0, loop_stats_encode(&s, 99, buffer, CAPACITY), &m);
    assert_true(m.timed == 0 && isnan(m.wake_p50_us) && isnan(m.wake_max_us) && isnan(m.exec_p50_us) && isnan(m.exec_max_us) &&
                isnan(m.pace_ratio));
}

#define assert_matrix(got, expected) assert_memory_equal(got, expected, sizeof(double[DOFS][DOFS]))

static void fill_method(struct method_result *m) {
    m->evaluated = true;
    fill(&m->mt[0][0], 36), fill(&m->bt[0][0], 36), fill(&m->mt_std[0][0], 36), fill(&m->bt_std[0][0], 36), fill(&m->condition_number, 1);
}

static void an_identification_keeps_every_number_and_reason(void **unused) {
    (void)unused;
    static struct identification id;
    struct verdict v = {.status = VERDICT_PASS, .scope = "what it is about"};
    hexid_identification_t m;
    fill(&id.nominal_mt[0][0], 36);
    fill_method(&id.method_a), fill_method(&id.modified_a), fill_method(&id.method_b);
    for (int i = 0; i < VERDICT_REASONS; i++) verdict_add(&v, VERDICT_FAIL, "reason %d, as long as one can be: %0*d", i, VERDICT_TEXT, 7);
    int size = identification_encode(&id, &v, 99, buffer, CAPACITY);
    assert_int_equal(hexid_identification_t_decode(buffer, 0, size, &m), size);
    assert_int_equal(m.time_ns, 99);
    assert_matrix(m.nominal_mt_si, id.nominal_mt);
    assert_matrix(m.method_a_mt_si, id.method_a.mt), assert_matrix(m.method_a_mt_std_si, id.method_a.mt_std);
    assert_matrix(m.method_a_bt_si, id.method_a.bt), assert_matrix(m.method_a_bt_std_si, id.method_a.bt_std);
    assert_matrix(m.modified_a_mt_si, id.modified_a.mt), assert_matrix(m.modified_a_mt_std_si, id.modified_a.mt_std);
    assert_matrix(m.method_b_mt_si, id.method_b.mt), assert_matrix(m.method_b_mt_std_si, id.method_b.mt_std);
    assert_true(m.method_a_condition == id.method_a.condition_number && m.method_b_condition == id.method_b.condition_number);
    assert_string_equal(m.verdict, "fail");
    assert_string_equal(m.scope, v.scope);
    assert_int_equal(m.reason_count, VERDICT_REASONS);
    for (int i = 0; i < VERDICT_REASONS; i++) assert_string_equal(m.reasons[i], v.reason[i]);
    hexid_identification_t_decode_cleanup(&m);
    assert_int_equal(identification_encode(&id, &v, 99, buffer, size - 1), -1);
}

static void what_was_not_evaluated_is_nan(void **unused) {
    (void)unused;
    static struct identification id;
    struct verdict v = {.status = VERDICT_NOT_EVALUATED, .scope = "what it is about"};
    hexid_identification_t m;
    int size = identification_encode(&id, &v, 0, buffer, CAPACITY);
    assert_int_equal(hexid_identification_t_decode(buffer, 0, size, &m), size);
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < DOFS; j++) {
            assert_true(isnan(m.method_a_mt_si[i][j]) && isnan(m.method_a_mt_std_si[i][j]));
            assert_true(isnan(m.method_a_bt_si[i][j]) && isnan(m.method_a_bt_std_si[i][j]));
            assert_true(isnan(m.modified_a_mt_si[i][j]) && isnan(m.modified_a_mt_std_si[i][j]));
            assert_true(isnan(m.method_b_mt_si[i][j]) && isnan(m.method_b_mt_std_si[i][j]));
        }
    assert_true(isnan(m.method_a_condition) && isnan(m.method_b_condition));
    assert_string_equal(m.verdict, "not_evaluated");
    assert_int_equal(m.reason_count, 0);
    hexid_identification_t_decode_cleanup(&m);
}

static void method_c_keeps_every_number(void **unused) {
    (void)unused;
    static struct method_c c;
    hexid_method_c_t m;
    fill(&c.matrix.mt[0][0], 36), fill(&c.matrix.mt_std[0][0], 36), fill(c.viscous, LEGS), fill(c.viscous_std, LEGS);
    fill(&c.dry[0][0], 2 * LEGS), fill(&c.dry_std[0][0], 2 * LEGS), fill(&c.matrix.condition_number, 1), fill(&c.scatter, 1);
    c.matrix.mt[1][2] = c.matrix.mt[2][1] = NAN;
    int size = method_c_encode(&c, 4, 99, buffer, CAPACITY);
    assert_int_equal(hexid_method_c_t_decode(buffer, 0, size, &m), size);
    assert_true(m.time_ns == 99 && m.tests == 4 && m.determined == 20);
    assert_matrix(m.mt_si, c.matrix.mt), assert_matrix(m.mt_std_si, c.matrix.mt_std);
    assert_true(m.condition == c.matrix.condition_number && m.scatter == c.scatter);
    for (int k = 0; k < LEGS; k++) {
        assert_true(m.viscous_n_s_per_m[k] == c.viscous[k] && m.viscous_std_n_s_per_m[k] == c.viscous_std[k]);
        assert_true(m.dry_extend_n[k] == c.dry[k][0] && m.dry_retract_n[k] == c.dry[k][1]);
        assert_true(m.dry_extend_std_n[k] == c.dry_std[k][0] && m.dry_retract_std_n[k] == c.dry_std[k][1]);
    }
    assert_int_equal(method_c_encode(&c, 4, 99, buffer, size - 1), -1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_test_result_keeps_every_number),  cmocka_unit_test(method_c_keeps_every_number),
        cmocka_unit_test(loop_statistics_keep_every_number), cmocka_unit_test(an_identification_keeps_every_number_and_reason),
        cmocka_unit_test(what_was_not_evaluated_is_nan),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
