/* The wire types: encoding and decoding is exact bit for bit, impossible cycles are refused, and no
 * type changes unnoticed. */
#include "support.h"

#include <stdlib.h>

#include "hexid_answer_t.h"
#include "hexid_command_t.h"
#include "hexid_event_t.h"
#include "hexid_gap_2_t.h"
#include "hexid_gap_t.h"
#include "hexid_identification_t.h"
#include "hexid_loop_stats_2_t.h"
#include "hexid_loop_stats_t.h"
#include "hexid_method_c_t.h"
#include "hexid_request_t.h"
#include "hexid_state_t.h"
#include "hexid_test_result_t.h"
#include "messages.h"
#include "supervisor.h"

enum { STATE_SIZE = 417 };

static uint64_t random_bits(uint64_t *state) {
    *state ^= *state << 13, *state ^= *state >> 7, *state ^= *state << 17;
    return *state;
}

/* Returns a number with any bit pattern: infinities, NaNs with payloads, subnormal numbers. */
static double random_double(uint64_t *state) {
    uint64_t bits = random_bits(state);
    double number;
    if (bits % 16 == 0) bits |= 0x7ff0000000000000;
    memcpy(&number, &bits, sizeof number);
    return number;
}

static void fill(double *numbers, int count, uint64_t *state) {
    for (int i = 0; i < count; i++) numbers[i] = random_double(state);
}

static void random_cycle(struct cycle *c, uint64_t *state) {
    memset(c, 0, sizeof *c);
    c->seq = random_bits(state) >> 1;
    c->in.time_ns = (int64_t)random_bits(state), c->in.age_ns = (int64_t)random_bits(state), c->in.device_seq = random_bits(state);
    c->in.flags = (uint32_t)random_bits(state), c->faults = (uint32_t)random_bits(state), c->first_fault = (uint32_t)random_bits(state);
    fill(c->in.length_m, LEGS, state), fill(c->in.p1_pa, LEGS, state), fill(c->in.p2_pa, LEGS, state);
    fill(c->out.valve, LEGS, state), fill(c->force_n, LEGS, state), fill(c->ref, DOFS, state), fill(c->pose, DOFS, state);
    c->out.enable = random_bits(state) % 2;
    c->state = (enum state)(random_bits(state) % STATES);
    c->test = (int)(random_bits(state) % 129) - 1;
    c->dof = (enum dof)((int)(random_bits(state) % 7) - 1);
    c->phase = (enum phase)(random_bits(state) % 5);
    c->test_time_s = random_double(state);
    c->wake_late_ns = (int64_t)random_bits(state), c->exec_ns = (int64_t)random_bits(state);
}

#define assert_same(a, b, member) assert_memory_equal(&(a)->member, &(b)->member, sizeof(a)->member)

static void assert_cycles_equal(const struct cycle *a, const struct cycle *b) {
    assert_same(a, b, seq), assert_same(a, b, in.time_ns), assert_same(a, b, in.age_ns), assert_same(a, b, in.device_seq);
    assert_same(a, b, in.flags), assert_same(a, b, in.length_m), assert_same(a, b, in.p1_pa), assert_same(a, b, in.p2_pa);
    assert_same(a, b, out.valve), assert_same(a, b, out.enable), assert_same(a, b, ref), assert_same(a, b, pose);
    assert_same(a, b, force_n), assert_same(a, b, state), assert_same(a, b, faults), assert_same(a, b, first_fault);
    assert_same(a, b, test), assert_same(a, b, dof), assert_same(a, b, phase), assert_same(a, b, test_time_s);
    assert_same(a, b, wake_late_ns), assert_same(a, b, exec_ns);
}

static void state_comes_back_bit_for_bit(void **unused) {
    (void)unused;
    uint64_t state = 1;
    for (int i = 0; i < 20000; i++) {
        struct cycle c, back;
        unsigned char buffer[STATE_MESSAGE_MAX];
        random_cycle(&c, &state);
        assert_int_equal(state_encode(&c, buffer), STATE_SIZE);
        assert_true(state_decode(buffer, STATE_SIZE, &back));
        assert_cycles_equal(&back, &c);
    }
}

/* The generated decoder is used, because two fields swapped by both own functions would not
 * show. */
static void every_field_of_a_state_is_what_its_name_says(void **unused) {
    (void)unused;
    uint64_t state = 2;
    struct cycle c;
    hexid_state_t m;
    unsigned char buffer[STATE_MESSAGE_MAX];
    random_cycle(&c, &state);
    c.out.enable = true;
    assert_int_equal(hexid_state_t_decode(buffer, 0, state_encode(&c, buffer), &m), STATE_SIZE);
    assert_true((uint64_t)m.seq == c.seq && m.time_ns == c.in.time_ns);
    assert_true(m.age_ns == c.in.age_ns && (uint64_t)m.device_seq == c.in.device_seq);
    assert_memory_equal(&m.test_time_s, &c.test_time_s, sizeof m.test_time_s);
    assert_true((uint32_t)m.sample_flags == c.in.flags && (uint32_t)m.faults == c.faults && (uint32_t)m.first_fault == c.first_fault);
    assert_true(m.wake_late_ns == c.wake_late_ns && m.exec_ns == c.exec_ns);
    assert_true(m.state == (int)c.state && m.test == c.test && m.dof == (int)c.dof && m.phase == (int)c.phase && m.enable == 1);
    assert_memory_equal(m.length_m, c.in.length_m, sizeof m.length_m);
    assert_memory_equal(m.p1_pa, c.in.p1_pa, sizeof m.p1_pa);
    assert_memory_equal(m.p2_pa, c.in.p2_pa, sizeof m.p2_pa);
    assert_memory_equal(m.force_n, c.force_n, sizeof m.force_n);
    assert_memory_equal(m.valve, c.out.valve, sizeof m.valve);
    assert_memory_equal(m.ref_m, &c.ref[DOF_X], sizeof m.ref_m);
    assert_memory_equal(m.ref_rad, &c.ref[DOF_PHI], sizeof m.ref_rad);
    assert_memory_equal(m.pose_m, &c.pose[DOF_X], sizeof m.pose_m);
    assert_memory_equal(m.pose_rad, &c.pose[DOF_PHI], sizeof m.pose_rad);
}

static void a_state_of_the_wrong_size_or_type_is_refused(void **unused) {
    (void)unused;
    uint64_t state = 3;
    struct cycle c, back, before;
    unsigned char buffer[STATE_MESSAGE_MAX] = {0};
    random_cycle(&c, &state);
    random_cycle(&before, &state);
    back = before;
    state_encode(&c, buffer);
    for (int size = 0; size <= STATE_MESSAGE_MAX; size++)
        if (size != STATE_SIZE) assert_false(state_decode(buffer, size, &back));
    for (int bit = 0; bit < 64; bit++) {
        buffer[bit / 8] ^= (unsigned char)(1 << bit % 8);
        assert_false(state_decode(buffer, STATE_SIZE, &back));
        buffer[bit / 8] ^= (unsigned char)(1 << bit % 8);
    }
    assert_cycles_equal(&back, &before); /* unchanged */
    assert_true(state_decode(buffer, STATE_SIZE, &back));
}

static bool decodes(const hexid_state_t *m) {
    unsigned char buffer[STATE_MESSAGE_MAX];
    struct cycle c;
    return state_decode(buffer, hexid_state_t_encode(buffer, 0, sizeof buffer, m), &c);
}

static void values_that_no_cycle_can_have_are_refused(void **unused) {
    (void)unused;
    hexid_state_t m = {.dof = -1, .test = -1};
    assert_true(decodes(&m));
    for (int i = -128; i < 128; i++) {
        m.state = (int8_t)i, assert_int_equal(decodes(&m), i >= 0 && i < STATES), m.state = 0;
        m.test = (int8_t)i, assert_int_equal(decodes(&m), i >= -1), m.test = -1;
        m.dof = (int8_t)i, assert_int_equal(decodes(&m), i >= -1 && i < DOFS), m.dof = -1;
        m.phase = (int8_t)i, assert_int_equal(decodes(&m), i >= 0 && i <= PHASE_RAMP_OUT), m.phase = 0;
        m.enable = (int8_t)i, assert_int_equal(decodes(&m), i == 0 || i == 1), m.enable = 0;
    }
    m.seq = -1, assert_false(decodes(&m));
}

#if SANITIZED
static void a_state_takes_no_heap(void **unused) { /* sanitizers have an allocator of their own */
    (void)unused;
    skip_because(OWN_ALLOCATOR);
}
#else
static volatile int allocations; /* volatile, because the compiler would assume that malloc()
                                  * changes nothing else */
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *malloc(size_t size) { return allocations++, __libc_malloc(size); }
void *calloc(size_t count, size_t size) { return allocations++, __libc_calloc(count, size); }

static void a_state_takes_no_heap(void **unused) {
    (void)unused;
    unsigned char buffer[STATE_MESSAGE_MAX];
    struct cycle c = {.dof = DOF_NONE, .test = -1};
    int before = allocations;
    void *volatile block = malloc(1); /* volatile, or the compiler omits the pair */
    free(block);
    assert_int_equal(allocations, before + 1); /* the counter does count */
    assert_true(state_decode(buffer, state_encode(&c, buffer), &c));
    assert_int_equal(allocations, before + 1);
}
#endif

static void an_event_comes_back_or_does_not_fit(void **unused) {
    (void)unused;
    static unsigned char buffer[70000];
    static char text[65000];
    struct event e;
    memset(text, 'x', sizeof text - 1);
    int size = event_encode(-5, 7, "note", text, buffer, sizeof buffer);
    assert_true(event_decode(buffer, size, &e));
    assert_true(e.time_ns == -5 && e.seq == 7);
    assert_string_equal(e.kind, "note");
    assert_string_equal(e.text, text);
    assert_int_equal(event_encode(-5, 7, "note", text, buffer, size), size);
    assert_int_equal(event_encode(-5, 7, "note", text, buffer, size - 1), -1);
    size = event_encode(0, 0, "", "", buffer, sizeof buffer);
    assert_true(event_decode(buffer, size, &e));
    assert_true(e.kind[0] == '\0' && e.text[0] == '\0');
}

static void a_configuration_is_found_in_its_event_only(void **unused) {
    (void)unused;
    unsigned char buffer[200];
    const char *text;
    size_t length;
    int size = event_encode(0, 0, "config", "a: 1\n", buffer, sizeof buffer);
    assert_true(event_decode_config(buffer, size, &text, &length));
    assert_int_equal(length, 5);
    assert_memory_equal(text, "a: 1\n", 6);
    assert_false(event_decode_config(buffer, size - 1, &text, &length));
    size = event_encode(0, 0, "configuration", "a: 1\n", buffer, sizeof buffer);
    assert_false(event_decode_config(buffer, size, &text, &length));
}

/* Copies into a block of exactly the message's size, so that a sanitizer sees every overrun. */
static bool event_good(const unsigned char *message, int size) {
    unsigned char *exact = malloc((size_t)size + 1);
    struct event e;
    memcpy(exact, message, (size_t)size);
    exact = realloc(exact, size ? (size_t)size : 1);
    bool good = event_decode(exact, size, &e);
    free(exact);
    return good;
}

static void a_damaged_event_is_refused(void **unused) {
    (void)unused;
    enum { KIND_LENGTH = 24 };
    unsigned char buffer[100] = {0}, bad[100];
    int size = event_encode(1, 2, "state", "ready", buffer, sizeof buffer);
    assert_true(event_good(buffer, size));
    for (int cut = 0; cut < size; cut++) assert_false(event_good(buffer, cut));
    assert_false(event_good(buffer, size + 1));
    static const int32_t lengths[] = {0, -1, 5, 7, 1000, INT32_MAX, INT32_MIN};
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) { /* 6 is right */
        memcpy(bad, buffer, sizeof bad);
        for (int byte = 0; byte < 4; byte++) bad[KIND_LENGTH + byte] = (unsigned char)((uint32_t)lengths[i] >> (24 - 8 * byte));
        assert_false(event_good(bad, size));
    }
    memcpy(bad, buffer, sizeof bad);
    bad[KIND_LENGTH + 4] = '\0'; /* within the text */
    assert_false(event_good(bad, size));
    memcpy(bad, buffer, sizeof bad);
    bad[size - 1] = '!'; /* no closing zero */
    assert_false(event_good(bad, size));
}

static void stop_and_park_come_back_and_nothing_else_is_a_command(void **unused) {
    (void)unused;
    static const char *const words[] = {"", "none", "engage", "start", "reset", "renew", "Stop", "stop ", "stopp", "sto", "park\n"};
    unsigned char buffer[COMMAND_MESSAGE_MAX + 1] = {0};
    enum command c = COMMAND_NONE;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        hexid_command_t old = {.command = (char *)(uintptr_t)words[i]};
        hexid_request_t past = {.id = 1, .command = (char *)(uintptr_t)words[i]};
        assert_false(command_decode(buffer, hexid_command_t_encode(buffer, 0, sizeof buffer, &old), &c));
        assert_false(command_decode(buffer, hexid_request_t_encode(buffer, 0, sizeof buffer, &past), &c));
    }
    hexid_request_t past = {.id = 1, .command = (char *)(uintptr_t)"park"};
    assert_false(command_decode(buffer, hexid_request_t_encode(buffer, 0, sizeof buffer, &past), &c));
    assert_int_equal(c, COMMAND_NONE);
    for (int i = COMMAND_STOP; i <= COMMAND_PARK; i++)
        assert_true(command_decode(buffer, command_encode((enum command)i, 3, buffer), &c) && c == (enum command)i);
    int size = command_encode(COMMAND_STOP, 3, buffer);
    for (int cut = 0; cut < size; cut++) assert_false(command_decode(buffer, cut, &c));
    assert_false(command_decode(buffer, size + 1, &c));
    for (int i = 16; i < 20; i++) { /* these bytes are the word's length, which becomes negative or
                                     * huge */
        buffer[i] ^= 0x80;
        assert_false(command_decode(buffer, size, &c));
        buffer[i] ^= 0x80;
    }
    buffer[0] ^= 1;
    assert_false(command_decode(buffer, size, &c));
}

/* Decodes a copy in a block of exactly the message's size. */
static bool test_result_good(const unsigned char *message, int size, struct test_summary *r) {
    unsigned char *exact = malloc(size ? (size_t)size : 1);
    memcpy(exact, message, (size_t)size);
    bool good = test_result_decode(exact, size, r);
    free(exact);
    return good;
}

static bool gap_good(const unsigned char *message, int size, struct gap_summary *r) {
    unsigned char *exact = malloc(size ? (size_t)size : 1);
    memcpy(exact, message, (size_t)size);
    bool good = gap_decode(exact, size, r);
    free(exact);
    return good;
}

static int test_result_message(unsigned char *buffer, int capacity) {
    hexid_test_result_t m = {.time_ns = 1,
                             .test = 2,
                             .dof = 3,
                             .dof_name = (char *)(uintptr_t)"theta",
                             .complete = 1,
                             .frequency_hz = 4,
                             .amplitude_m_or_rad = 0.006,
                             .achieved_m_or_rad = 0.0058,
                             .phase_deg = -0.5,
                             .samples = 2500,
                             .excluded = 7};
    return hexid_test_result_t_encode(buffer, 0, capacity, &m);
}

/* Fields that both types of a result have. */
#define GAP_FIELDS(words, numbers, legs)                                                                                         \
    .verdict = (char *)(uintptr_t)"ambiguous", .reason = (char *)(uintptr_t)"because", .next_experiment = (words)[1],            \
    .effect_count = 2, .effects = (words), .share_explained = (numbers), .z = (numbers), .parameter_count = 3,                   \
    .parameters = (words), .parameter_legs = (legs), .parameter_units = (words), .values_si = (numbers),                         \
    .values_std_si = (numbers), .ambiguous_count = 1, .ambiguous_with = (words), .simulated = 1, .noise_floor_ratio = 0.1,       \
    .held_out_before_ratio = 0.5, .held_out_after_ratio = 0.2

/* earlier: encode it in the type of versions before statements. */
static int gap_message(bool earlier, unsigned char *buffer, int capacity) {
    char *words[] = {(char *)(uintptr_t)"one", (char *)(uintptr_t)"", (char *)(uintptr_t)"three"};
    double numbers[] = {1, 2, 3};
    int8_t legs[] = {0, 1, 2};
    hexid_gap_t first = {GAP_FIELDS(words, numbers, legs)};
    hexid_gap_2_t m = {GAP_FIELDS(words, numbers, legs), .statement_count = 2,       .statements = words, .statement_levels = words,
                       .statement_probability = numbers, .statement_share = numbers, .family = words[0],  .certainty = 0.97};
    return earlier ? hexid_gap_t_encode(buffer, 0, capacity, &first) : hexid_gap_2_t_encode(buffer, 0, capacity, &m);
}

static void results_are_read_as_the_generated_code_writes_them(void **unused) {
    (void)unused;
    unsigned char buffer[1000];
    struct test_summary t;
    struct gap_summary g;
    assert_true(test_result_decode(buffer, test_result_message(buffer, sizeof buffer), &t));
    assert_string_equal(t.dof_name, "theta");
    assert_true(t.amplitude_m_or_rad == 0.006 && t.achieved_m_or_rad == 0.0058 && t.phase_deg == -0.5);
    assert_true(t.samples == 2500 && t.excluded == 7);
    for (int earlier = 0; earlier < 2; earlier++) {
        g = (struct gap_summary){0};
        assert_true(gap_decode(buffer, gap_message(earlier, buffer, sizeof buffer), &g));
        assert_string_equal(g.verdict, "ambiguous");
        assert_string_equal(g.reason, "because");
        assert_true(g.noise_floor_ratio == 0.1 && g.held_out_before_ratio == 0.5 && g.held_out_after_ratio == 0.2);
    }
}

/* The overwritten words include every length and count. */
static void a_damaged_result_is_refused(void **unused) {
    (void)unused;
    static const int32_t lengths[] = {-1, -2, 0, 1000, 0x10000000, INT32_MAX, INT32_MIN};
    unsigned char test[1000] = {0}, gap[1000] = {0}, bad[1000];
    struct test_summary t;
    struct gap_summary g;
    int test_size = test_result_message(test, sizeof test), gap_size = gap_message(false, gap, sizeof gap), refused = 0;
    for (int cut = 0; cut < test_size; cut++) assert_false(test_result_good(test, cut, &t));
    for (int cut = 0; cut < gap_size; cut++) assert_false(gap_good(gap, cut, &g));
    assert_false(test_result_good(test, test_size + 1, &t) || gap_good(gap, gap_size + 1, &g));
    for (int at = 0; at + 4 <= gap_size; at++)
        for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++)
            for (int which = 0; which < 2; which++) {
                int size = which ? gap_size : test_size;
                if (at + 4 > size) continue;
                memcpy(bad, which ? gap : test, sizeof bad);
                for (int byte = 0; byte < 4; byte++) bad[at + byte] = (unsigned char)((uint32_t)lengths[i] >> (24 - 8 * byte));
                refused += which ? !gap_good(bad, size, &g) : !test_result_good(bad, size, &t);
            }
    assert_true(refused > 13 * 7); /* at least all 7 values in the 13 lengths and counts */
}

/* The lists are empty, so no data after the count contradict it. */
static void a_negative_count_and_no_boolean_are_refused(void **unused) {
    (void)unused;
    char *empty = (char *)(uintptr_t)"";
    double numbers[] = {0.0}; /* liblcm copies none of these numbers, but accepts no NULL */
    int8_t legs[] = {0};
    hexid_gap_t m = {.verdict = empty,
                     .reason = empty,
                     .next_experiment = empty,
                     .share_explained = numbers,
                     .z = numbers,
                     .parameter_legs = legs,
                     .values_si = numbers,
                     .values_std_si = numbers};
    unsigned char buffer[1000];
    struct gap_summary g;
    enum { COUNTS = 3, FIRST = 8 + 8 + 3 * 5 }; /* the counts follow type, time and three strings */
    int size = hexid_gap_t_encode(buffer, 0, sizeof buffer, &m);
    assert_true(gap_good(buffer, size, &g));
    for (int i = 0; i < COUNTS; i++) {
        unsigned char *count = buffer + FIRST + 4 * i;
        memset(count, 0xff, 4);
        assert_false(gap_good(buffer, size, &g));
        memset(count, 0, 4);
    }
    assert_true(gap_good(buffer, size, &g));
    buffer[FIRST + 4 * COUNTS] = 2; /* the value is neither true nor false */
    assert_false(gap_good(buffer, size, &g));
}

/* A changed type makes old logs unreadable: add a type instead of editing one. */
static void types_are_frozen(void **unused) {
    (void)unused;
    assert_int_equal(__hexid_state_t_get_hash(), 0x82de43c6682a2716);
    assert_int_equal(__hexid_loop_stats_t_get_hash(), 0xd95968ea35d03d3e);
    assert_int_equal(__hexid_test_result_t_get_hash(), 0x6630e6d5a271452d);
    assert_int_equal(__hexid_identification_t_get_hash(), 0x131c302b7899dd02);
    assert_int_equal(__hexid_event_t_get_hash(), 0xc675cdb82b97a028);
    assert_int_equal(__hexid_gap_t_get_hash(), 0x48254367c49769b7);
    assert_int_equal(__hexid_gap_2_t_get_hash(), 0xc0a63e16aef09b7e);
    assert_int_equal(__hexid_command_t_get_hash(), 0xbb4b50819e0d4308);
    assert_int_equal(__hexid_loop_stats_2_t_get_hash(), 0xfff8ccbf9bf6b948);
    assert_int_equal(__hexid_request_t_get_hash(), 0x4fd2e7e204d3f86a);
    assert_int_equal(__hexid_method_c_t_get_hash(), 0xa790a5427ca19015);
    assert_int_equal(__hexid_answer_t_get_hash(), 0x330d2c348ce6684a);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(state_comes_back_bit_for_bit),
        cmocka_unit_test(every_field_of_a_state_is_what_its_name_says),
        cmocka_unit_test(a_state_of_the_wrong_size_or_type_is_refused),
        cmocka_unit_test(values_that_no_cycle_can_have_are_refused),
        cmocka_unit_test(a_state_takes_no_heap),
        cmocka_unit_test(an_event_comes_back_or_does_not_fit),
        cmocka_unit_test(a_configuration_is_found_in_its_event_only),
        cmocka_unit_test(a_damaged_event_is_refused),
        cmocka_unit_test(stop_and_park_come_back_and_nothing_else_is_a_command),
        cmocka_unit_test(results_are_read_as_the_generated_code_writes_them),
        cmocka_unit_test(a_damaged_result_is_refused),
        cmocka_unit_test(a_negative_count_and_no_boolean_are_refused),
        cmocka_unit_test(types_are_frozen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
