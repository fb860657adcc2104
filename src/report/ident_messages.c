#include "ident_messages.h"

#include <math.h>

#include "hexid_identification_t.h"
#include "hexid_loop_stats_2_t.h"
#include "hexid_method_c_t.h"
#include "hexid_test_result_t.h"
#include "messages.h"

int test_result_encode(const struct test_result *t, int64_t time_ns, unsigned char *buffer, int capacity) {
    hexid_test_result_t m = {
        .time_ns = time_ns,
        .test = (int8_t)t->test,
        .dof = (int8_t)t->dof,
        .dof_name = lcm_text(dof_names[t->dof]),
        .complete = !t->refused,
        .frequency_hz = t->frequency_hz,
        .amplitude_m_or_rad = t->amplitude,
        .achieved_m_or_rad = t->achieved_amplitude,
        .phase_deg = t->phase_deg,
        .samples = t->samples,
        .excluded = t->excluded,
    };
    for (int i = 0; i < DOFS; i++) {
        m.unwanted_pct[i] = t->unwanted_pct[i];
        m.pose_sin_m_rad[i] = t->pose[i][0], m.pose_cos_m_rad[i] = t->pose[i][1];
        m.pose_std_m_rad[i] = t->pose_std[i], m.pose_rms_m_rad[i] = t->pose_rms[i];
        m.wrench_sin_n_nm[i] = t->wrench[i][0], m.wrench_cos_n_nm[i] = t->wrench[i][1];
        m.wrench_std_n_nm[i] = t->wrench_std[i], m.wrench_rms_n_nm[i] = t->wrench_rms[i];
    }
    return hexid_test_result_t_encode(buffer, 0, capacity, &m);
}

static void matrix(double to[DOFS][DOFS], const double from[DOFS][DOFS], bool evaluated) {
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < DOFS; j++) to[i][j] = evaluated ? from[i][j] : (double)NAN;
}

int identification_encode(const struct identification *id, const struct verdict *verdict, int64_t time_ns, unsigned char *buffer,
                          int capacity) {
    const struct method_result *a = &id->method_a, *modified = &id->modified_a, *b = &id->method_b;
    char *reasons[VERDICT_REASONS];
    hexid_identification_t m = {
        .time_ns = time_ns,
        .method_a_condition = a->evaluated ? a->condition_number : (double)NAN,
        .method_b_condition = b->evaluated ? b->condition_number : (double)NAN,
        .verdict = lcm_text(verdict_names[verdict->status]),
        .scope = lcm_text(verdict->scope),
        .reason_count = verdict->reasons,
        .reasons = reasons,
    };
    for (int i = 0; i < verdict->reasons; i++) reasons[i] = lcm_text(verdict->reason[i]);
    matrix(m.nominal_mt_si, id->nominal_mt, true);
    matrix(m.method_a_mt_si, a->mt, a->evaluated);
    matrix(m.method_a_mt_std_si, a->mt_std, a->evaluated);
    matrix(m.method_a_bt_si, a->bt, a->evaluated);
    matrix(m.method_a_bt_std_si, a->bt_std, a->evaluated);
    matrix(m.modified_a_mt_si, modified->mt, modified->evaluated);
    matrix(m.modified_a_mt_std_si, modified->mt_std, modified->evaluated);
    matrix(m.method_b_mt_si, b->mt, b->evaluated);
    matrix(m.method_b_mt_std_si, b->mt_std, b->evaluated);
    return hexid_identification_t_encode(buffer, 0, capacity, &m);
}

int method_c_encode(const struct method_c *c, int tests, int64_t time_ns, unsigned char *buffer, int capacity) {
    hexid_method_c_t m = {.time_ns = time_ns, .tests = (int8_t)tests, .condition = c->matrix.condition_number, .scatter = c->scatter};
    double std;
    for (int i = 0; i < MATRIX_ENTRIES; i++) m.determined += !isnan(method_c_value(c, i, &std));
    matrix(m.mt_si, c->matrix.mt, true);
    matrix(m.mt_std_si, c->matrix.mt_std, true);
    for (int k = 0; k < LEGS; k++) {
        m.viscous_n_s_per_m[k] = c->viscous[k], m.viscous_std_n_s_per_m[k] = c->viscous_std[k];
        m.dry_extend_n[k] = c->dry[k][0], m.dry_extend_std_n[k] = c->dry_std[k][0];
        m.dry_retract_n[k] = c->dry[k][1], m.dry_retract_std_n[k] = c->dry_std[k][1];
    }
    return hexid_method_c_t_encode(buffer, 0, capacity, &m);
}

int loop_stats_encode(const struct loop_statistics *s, int64_t time_ns, unsigned char *buffer, int capacity) {
    double wake_us[4], exec_us[4];
    for (int i = 0; i < 4; i++) {
        wake_us[i] = s->timed ? s->wake_us[i] : (double)NAN;
        exec_us[i] = s->timed ? s->exec_us[i] : (double)NAN;
    }
    hexid_loop_stats_2_t m = {
        .time_ns = time_ns,
        .cycles = s->cycles,
        .overruns = s->overruns,
        .lost_records = s->lost,
        .period_s = s->period_s,
        .timed = s->timed,
        .wake_p50_us = wake_us[0],
        .wake_p99_us = wake_us[1],
        .wake_p999_us = wake_us[2],
        .wake_max_us = wake_us[3],
        .exec_p50_us = exec_us[0],
        .exec_p99_us = exec_us[1],
        .exec_p999_us = exec_us[2],
        .exec_max_us = exec_us[3],
        .pace_ratio = s->timed ? s->pace : (double)NAN,
        .stalls = s->stalls,
        .longest_stall_s = s->timed ? s->longest_stall_s : (double)NAN,
    };
    return hexid_loop_stats_2_t_encode(buffer, 0, capacity, &m);
}
