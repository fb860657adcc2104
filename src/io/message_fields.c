#include "message_fields.h"

#include <stddef.h>
#include <string.h>

#include "hexid_event_t.h"
#include "hexid_gap_2_t.h"
#include "hexid_gap_t.h"
#include "hexid_identification_t.h"
#include "hexid_loop_stats_2_t.h"
#include "hexid_loop_stats_t.h"
#include "hexid_method_c_t.h"
#include "hexid_test_result_t.h"
#include "messages.h"
#include "types.h"
#include "wire.h"

#define INT64(name) {name, FIELD_INTEGER, 8, 1}
#define INT32(name) {name, FIELD_INTEGER, 4, 1}
#define INT8(name) {name, FIELD_INTEGER, 1, 1}
#define BOOLEAN(name) {name, FIELD_BOOLEAN, 1, 1}
#define REAL(name) {name, FIELD_REAL, 8, 1}
#define REALS(name, count) {name, FIELD_REAL, 8, count}
#define TEXT(name) {name, FIELD_TEXT, 0, 1}
#define TEXTS(name) {name, FIELD_TEXT, 0, FIELD_COUNTED}
#define COUNT(name) {name, FIELD_COUNT, 4, 1}
#define MATRIX(name) REALS(name, DOFS * DOFS)
#define LOOP_STATS                                                                                                                   \
    INT64("time_ns"), INT64("cycles"), INT64("overruns"), INT64("lost_records"), REAL("period_s"), BOOLEAN("timed"),                  \
    REAL("wake_p50_us"), REAL("wake_p99_us"), REAL("wake_p999_us"), REAL("wake_max_us"),                                              \
    REAL("exec_p50_us"), REAL("exec_p99_us"), REAL("exec_p999_us"), REAL("exec_max_us")
#define CHANNELS(before)                                                                                                             \
    REAL(before "_length_m"), REAL(before "_force_n"), REAL(before "_p1_pa"), REAL(before "_p2_pa"), REAL(before "_valve")

/* clang-format off */
#define GAP                                                                                                                          \
    INT64("time_ns"), TEXT("verdict"), TEXT("reason"), TEXT("next_experiment"), COUNT("effect_count"), TEXTS("effects"),             \
    REALS("share_explained", FIELD_COUNTED), REALS("z", FIELD_COUNTED), COUNT("parameter_count"), TEXTS("parameters"),               \
    {"parameter_legs", FIELD_INTEGER, 1, FIELD_COUNTED}, TEXTS("parameter_units"), REALS("values_si", FIELD_COUNTED),                \
    REALS("values_std_si", FIELD_COUNTED), COUNT("ambiguous_count"), TEXTS("ambiguous_with"), BOOLEAN("simulated"),                  \
    REAL("unexplained_fraction"), REAL("before_ratio"), REAL("after_ratio"), REAL("noise_floor_ratio"),                              \
    REAL("held_out_before_ratio"), REAL("held_out_after_ratio"), CHANNELS("held_out_before"), CHANNELS("held_out_after"),            \
    CHANNELS("noise_floor")

const struct message_type message_types[MESSAGE_TYPES] = {
    {"event", CHANNEL_EVENT, __hexid_event_t_get_hash, {INT64("time_ns"), INT64("seq"), TEXT("kind"), TEXT("text")}},
    {"loop_stats", CHANNEL_LOOP_STATS, __hexid_loop_stats_2_t_get_hash,
     {LOOP_STATS, REAL("pace_ratio"), INT64("stalls"), REAL("longest_stall_s")}},
    {"loop_stats_1", CHANNEL_LOOP_STATS, __hexid_loop_stats_t_get_hash, {LOOP_STATS}},
    {"test_result", CHANNEL_TEST_RESULT, __hexid_test_result_t_get_hash,
     {INT64("time_ns"), INT8("test"), INT8("dof"), TEXT("dof_name"), BOOLEAN("complete"), REAL("frequency_hz"), REAL("amplitude_m_or_rad"),
      REAL("achieved_m_or_rad"), REAL("phase_deg"), REALS("unwanted_pct", DOFS), INT64("samples"), INT64("excluded"),
      REALS("pose_sin_m_rad", DOFS), REALS("pose_cos_m_rad", DOFS), REALS("pose_std_m_rad", DOFS), REALS("pose_rms_m_rad", DOFS),
      REALS("wrench_sin_n_nm", DOFS), REALS("wrench_cos_n_nm", DOFS), REALS("wrench_std_n_nm", DOFS), REALS("wrench_rms_n_nm", DOFS)}},
    {"identification", CHANNEL_IDENTIFICATION, __hexid_identification_t_get_hash,
     {INT64("time_ns"), MATRIX("nominal_mt_si"), MATRIX("method_a_mt_si"), MATRIX("method_a_mt_std_si"), MATRIX("method_a_bt_si"),
      MATRIX("method_a_bt_std_si"), REAL("method_a_condition"), MATRIX("modified_a_mt_si"), MATRIX("modified_a_mt_std_si"),
      MATRIX("method_b_mt_si"), MATRIX("method_b_mt_std_si"), REAL("method_b_condition"), TEXT("verdict"), TEXT("scope"),
      COUNT("reason_count"), TEXTS("reasons")}},
    {"method_c", CHANNEL_METHOD_C, __hexid_method_c_t_get_hash,
     {INT64("time_ns"), INT8("tests"), INT32("determined"), MATRIX("mt_si"), MATRIX("mt_std_si"), REAL("condition"), REAL("scatter"),
      REALS("viscous_n_s_per_m", LEGS), REALS("viscous_std_n_s_per_m", LEGS), REALS("dry_extend_n", LEGS), REALS("dry_extend_std_n", LEGS),
      REALS("dry_retract_n", LEGS), REALS("dry_retract_std_n", LEGS)}},
    {"gap", CHANNEL_GAP, __hexid_gap_2_t_get_hash,
     {GAP, COUNT("statement_count"), TEXTS("statements"), TEXTS("statement_levels"), REALS("statement_probability", FIELD_COUNTED),
      REALS("statement_share", FIELD_COUNTED), TEXT("family"), REAL("certainty")}},
    {"gap_1", CHANNEL_GAP, __hexid_gap_t_get_hash, {GAP}},
};
/* clang-format on */

bool message_known(const char *channel) {
    for (int i = 0; i < MESSAGE_TYPES; i++)
        if (!strcmp(message_types[i].channel, channel)) return true;
    return false;
}

static void pass(struct wire *w, const struct field *f, int count) {
    for (int i = 0; w->good && i < count; i++) {
        if (f->kind == FIELD_TEXT) wire_string(w);
        else if (f->kind == FIELD_BOOLEAN) wire_boolean(w);
        else wire_take(w, f->bytes);
    }
}

static bool read_as(const struct message_type *type, const void *data, int size, struct message *m) {
    struct wire w = wire_open(data, size, type->fingerprint());
    struct message read = {.type = type, .data = data, .size = size};
    int counted = 0;
    for (int i = 0; w.good && type->field[i].name; i++) {
        const struct field *f = &type->field[i];
        if (f->kind == FIELD_COUNT) {
            counted = wire_count(&w);
            w.good = w.good && counted <= ELEMENTS_MAX;
            continue;
        }
        read.value[i] = (struct message_value){.count = f->count == FIELD_COUNTED ? counted : f->count, .bytes = w.next};
        pass(&w, f, read.value[i].count);
    }
    if (w.good && w.left == 0) *m = read;
    return w.good && w.left == 0;
}

bool message_read(const char *channel, const void *data, int size, struct message *m) {
    for (int i = 0; i < MESSAGE_TYPES; i++)
        if (!strcmp(message_types[i].channel, channel) && read_as(&message_types[i], data, size, m)) return true;
    return false;
}

/* Returns a reader at an element whose bounds message_read() has checked. */
static struct wire element(const struct message *m, int field, int i) {
    return (struct wire){.next = m->value[field].bytes + i * m->type->field[field].bytes, .left = INT32_MAX, .good = true};
}

double message_real(const struct message *m, int field, int i) {
    struct wire w = element(m, field, i);
    return wire_double(&w);
}

int64_t message_integer(const struct message *m, int field, int i) {
    struct wire w = element(m, field, i);
    int bytes = m->type->field[field].bytes;
    uint64_t sign = UINT64_C(1) << (8 * bytes - 1);
    return (int64_t)(((uint64_t)wire_int(&w, bytes) ^ sign) - sign);
}

const char *message_text(const struct message *m, int field, int i) {
    struct wire w = element(m, field, 0);
    while (i-- > 0) wire_string(&w);
    return wire_string(&w);
}
