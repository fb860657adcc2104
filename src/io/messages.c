#include "messages.h"

#include <math.h>
#include <string.h>

#include "hexid_command_t.h"
#include "hexid_event_t.h"
#include "hexid_gap_2_t.h"
#include "hexid_gap_t.h"
#include "hexid_state_t.h"
#include "hexid_test_result_t.h"
#include "wire.h"

int state_encode(const struct cycle *c, unsigned char buffer[STATE_MESSAGE_MAX]) {
    hexid_state_t m = {
        .seq = (int64_t)c->seq,
        .time_ns = c->in.time_ns,
        .age_ns = c->in.age_ns,
        .device_seq = (int64_t)c->in.device_seq,
        .test_time_s = c->test_time_s,
        .sample_flags = (int32_t)c->in.flags,
        .faults = (int32_t)c->faults,
        .first_fault = (int32_t)c->first_fault,
        .wake_late_ns = c->wake_late_ns,
        .exec_ns = c->exec_ns,
        .state = (int8_t)c->state,
        .test = (int8_t)c->test,
        .dof = (int8_t)c->dof,
        .phase = (int8_t)c->phase,
        .enable = c->out.enable,
    };
    memcpy(m.length_m, c->in.length_m, sizeof m.length_m);
    memcpy(m.p1_pa, c->in.p1_pa, sizeof m.p1_pa);
    memcpy(m.p2_pa, c->in.p2_pa, sizeof m.p2_pa);
    memcpy(m.force_n, c->force_n, sizeof m.force_n);
    memcpy(m.valve, c->out.valve, sizeof m.valve);
    memcpy(m.ref_m, c->ref, sizeof m.ref_m);
    memcpy(m.ref_rad, c->ref + DOF_PHI, sizeof m.ref_rad);
    memcpy(m.pose_m, c->pose, sizeof m.pose_m);
    memcpy(m.pose_rad, c->pose + DOF_PHI, sizeof m.pose_rad);
    return hexid_state_t_encode(buffer, 0, STATE_MESSAGE_MAX, &m);
}

static bool possible(const hexid_state_t *m) {
    return m->seq >= 0 && m->state >= 0 && m->state < STATES && m->test >= -1 && m->dof >= DOF_NONE && m->dof < DOFS &&
           m->phase >= PHASE_NONE && m->phase <= PHASE_RAMP_OUT && (m->enable == 0 || m->enable == 1);
}

/* Decodes a state without heap: liblcm's decoder needs none, because all arrays of a state have
 * fixed sizes. */
bool state_decode(const void *data, int size, struct cycle *cycle) {
    hexid_state_t m;
    if (hexid_state_t_decode(data, 0, size, &m) != size || !possible(&m)) return false;
    struct cycle *c = cycle;
    *c = (struct cycle){
        .seq = (uint64_t)m.seq,
        .in = {.time_ns = m.time_ns, .age_ns = m.age_ns, .device_seq = (uint64_t)m.device_seq, .flags = (uint32_t)m.sample_flags},
        .out.enable = m.enable,
        .state = (enum state)m.state,
        .faults = (uint32_t)m.faults,
        .first_fault = (uint32_t)m.first_fault,
        .measure = {.leg = -1, .value = (double)NAN, .limit = (double)NAN},
        .test = m.test,
        .dof = (enum dof)m.dof,
        .phase = (enum phase)m.phase,
        .test_time_s = m.test_time_s,
        .wake_late_ns = m.wake_late_ns,
        .exec_ns = m.exec_ns,
    };
    memcpy(c->in.length_m, m.length_m, sizeof m.length_m);
    memcpy(c->in.p1_pa, m.p1_pa, sizeof m.p1_pa);
    memcpy(c->in.p2_pa, m.p2_pa, sizeof m.p2_pa);
    memcpy(c->force_n, m.force_n, sizeof m.force_n);
    memcpy(c->out.valve, m.valve, sizeof m.valve);
    memcpy(c->ref, m.ref_m, sizeof m.ref_m);
    memcpy(c->ref + DOF_PHI, m.ref_rad, sizeof m.ref_rad);
    memcpy(c->pose, m.pose_m, sizeof m.pose_m);
    memcpy(c->pose + DOF_PHI, m.pose_rad, sizeof m.pose_rad);
    return true;
}

int event_encode(int64_t time_ns, uint64_t seq, const char *kind, const char *text, unsigned char *buffer, int capacity) {
    hexid_event_t m = {.time_ns = time_ns, .seq = (int64_t)seq, .kind = lcm_text(kind), .text = lcm_text(text)};
    if (hexid_event_t_encoded_size(&m) > capacity) return -1;
    return hexid_event_t_encode(buffer, 0, capacity, &m);
}

int command_encode(enum command command, int64_t time_ns, unsigned char buffer[COMMAND_MESSAGE_MAX]) {
    hexid_command_t m = {.time_ns = time_ns, .command = lcm_text(command_names[command])};
    return hexid_command_t_encode(buffer, 0, COMMAND_MESSAGE_MAX, &m);
}

static void skip_strings(struct wire *w, int count) {
    for (int i = 0; w->good && i < count; i++) wire_string(w);
}

static void skip_doubles(struct wire *w, int count) {
    for (int i = 0; w->good && i < count; i++) wire_take(w, sizeof(double));
}

bool event_decode(const void *data, int size, struct event *event) {
    struct wire w = wire_open(data, size, __hexid_event_t_get_hash());
    struct event e = {.time_ns = wire_int(&w, 8), .seq = (uint64_t)wire_int(&w, 8)};
    e.kind = wire_string(&w);
    e.text = wire_string(&w);
    if (w.good && w.left == 0) *event = e;
    return w.good && w.left == 0;
}

bool event_decode_config(const void *data, int size, const char **text, size_t *length) {
    struct event event;
    if (!event_decode(data, size, &event) || strcmp(event.kind, "config") != 0) return false;
    *text = event.text;
    *length = strlen(event.text);
    return true;
}

bool command_decode(const void *data, int size, enum command *command) {
    struct wire w = wire_open(data, size, __hexid_command_t_get_hash());
    wire_int(&w, 8); /* time */
    const char *word = wire_string(&w);
    for (int i = COMMAND_STOP; w.good && !w.left && i <= COMMAND_PARK; i++)
        if (!strcmp(word, command_names[i])) return *command = (enum command)i, true;
    return false;
}

bool test_result_decode(const void *data, int size, struct test_summary *summary) {
    struct wire w = wire_open(data, size, __hexid_test_result_t_get_hash());
    struct test_summary r = {0};
    wire_take(&w, 8 + 1 + 1); /* time, test, dof */
    r.dof_name = wire_string(&w);
    wire_boolean(&w); /* complete */
    wire_double(&w);  /* frequency */
    r.amplitude_m_or_rad = wire_double(&w);
    r.achieved_m_or_rad = wire_double(&w);
    r.phase_deg = wire_double(&w);
    skip_doubles(&w, DOFS); /* unwanted */
    r.samples = wire_int(&w, 8);
    r.excluded = wire_int(&w, 8);
    skip_doubles(&w, 8 * DOFS); /* pose and wrench: sine, cosine, standard deviation, rms */
    if (w.good && w.left == 0) *summary = r;
    return w.good && w.left == 0;
}

static void skip_effects(struct wire *w) {
    int count = wire_count(w);
    skip_strings(w, count);
    skip_doubles(w, 2 * count); /* share explained, z */
}

static void skip_parameters(struct wire *w) {
    int count = wire_count(w);
    skip_strings(w, count);
    wire_take(w, count); /* legs */
    skip_strings(w, count); /* units */
    skip_doubles(w, 2 * count); /* values, their standard deviations */
}

static void skip_statements(struct wire *w) {
    int count = wire_count(w);
    skip_strings(w, count);
    skip_strings(w, count); /* levels */
    skip_doubles(w, 2 * count); /* probabilities, shares */
    wire_string(w); /* family */
    skip_doubles(w, 1); /* certainty */
}

/* Reads a result of the present type, hexid_gap_2_t, or of that of earlier versions,
 * hexid_gap_t. */
bool gap_decode(const void *data, int size, struct gap_summary *summary) {
    enum { CHANNELS = 5 };
    struct wire w = wire_open(data, size, __hexid_gap_2_t_get_hash());
    bool statements = w.good;
    if (!statements) w = wire_open(data, size, __hexid_gap_t_get_hash());
    struct gap_summary r = {0};
    wire_take(&w, 8); /* time */
    r.verdict = wire_string(&w);
    r.reason = wire_string(&w);
    wire_string(&w); /* next experiment */
    skip_effects(&w);
    skip_parameters(&w);
    skip_strings(&w, wire_count(&w)); /* ambiguous with */
    wire_boolean(&w); /* simulated */
    skip_doubles(&w, 3); /* unexplained, before, after */
    r.noise_floor_ratio = wire_double(&w);
    r.held_out_before_ratio = wire_double(&w);
    r.held_out_after_ratio = wire_double(&w);
    skip_doubles(&w, 3 * CHANNELS);
    if (statements) skip_statements(&w);
    if (w.good && w.left == 0) *summary = r;
    return w.good && w.left == 0;
}
