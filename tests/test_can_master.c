/* Codec, scaling, and the seven nodes with their master on a bus in memory: every claim about
 * failures without a socket or a clock. */
#include "support.h"

#include <linux/can/error.h>
#include <stdio.h>
#include <stdlib.h>

#include "can_master.h"
#include "channel.h"
#include "units.h"

enum { TOKEN = 0x600dcafe, CYCLES_TO_RUN = 200, LATE_NODE = 2, LATE_MAX = 8 };

/* The test's manipulation of frames on the bus. */
struct wire {
    int lose_tpdo_of;     /* node, 0 none */
    int late_by;          /* cycles of delay of LATE_NODE's TPDOs */
    bool lose_rpdo, lose_outputs, lose_heartbeat, lose_echo;
    int dead_node;        /* neither receives nor sends */
    int twin_of;          /* a second device with this number repeats the node's frames, 0: none */
    struct can_tpdo twin_adds; /* offsets of its readings (inputs: replaced) */
    int twin_percent;     /* percentage of frames that it repeats */
    bool twin_is_short;   /* its frames are a byte shorter */
    int lying_node;       /* answers wrongly for that object, 0: none */
    struct can_sdo lie;
};

struct late {
    struct can_frame frame;
    int64_t due_ns;
};

struct world {
    struct params params;
    struct can_master master;
    struct can_node node[CAN_NODES];
    struct wire wire;
    struct can_tpdo reading[CAN_NODES]; /* present readings of the sensors */
    struct late late[LATE_MAX];         /* delayed frames */
    int late_count;                     /* number of them */
    bool supply;                        /* level of the life sign for the supply */
    bool hangs;                         /* the life sign no longer toggles */
    int to_node_7;                      /* frames sent to node 7 */
    uint64_t seed;                      /* seed for the twin's omissions */
    int64_t now_ns;
};

/* Delays a TPDO by so many cycles; it arrives after that cycle's SYNC if there is one. */
static bool put_off(struct world *w, const struct can_frame *f) {
    struct late *l = &w->late[w->late_count];
    if (can_frame_node(f, COB_TPDO) != LATE_NODE || (w->wire.late_by == 0 && w->late_count == 0)) return false;
    assert_true(w->late_count < LATE_MAX);
    *l = (struct late){.frame = *f, .due_ns = w->now_ns + w->wire.late_by * ns_from_seconds(w->params.loop.period_s)};
    /* frames keep their order */
    if (w->late_count && l->due_ns < l[-1].due_ns) l->due_ns = l[-1].due_ns;
    w->late_count++;
    return true;
}

static void hand_in(struct world *w) {
    int kept = 0;
    for (int i = 0; i < w->late_count; i++) {
        if (w->late[i].due_ns <= w->now_ns) can_master_receive(&w->master, &w->late[i].frame, false, w->now_ns);
        else w->late[kept++] = w->late[i];
    }
    w->late_count = kept;
}

static void lie(const struct world *w, struct can_frame *f) {
    struct can_sdo reply;
    const struct can_sdo *l = &w->wire.lie;
    if (!w->wire.lying_node || can_frame_node(f, COB_SDO_REPLY) != w->wire.lying_node || !can_parse_sdo_reply(f, &reply)) return;
    if (reply.index == l->index && reply.sub == l->sub && (reply.kind == l->kind || l->kind == SDO_ABORT))
        *f = can_frame_sdo_reply(w->wire.lying_node, l);
}

/* The twin device answers as well. */
static void answer_again(struct world *w, const struct can_frame *f) {
    struct can_frame g = *f;
    struct can_tpdo t;
    const struct can_tpdo *more = &w->wire.twin_adds;
    if ((int)random_below(&w->seed, 100) >= w->wire.twin_percent) return;
    if (can_frame_node(f, COB_TPDO)) {
        can_parse_tpdo(f, &t);
        t.position += more->position;
        if (more->inputs) t.inputs = more->inputs;
        g = can_frame_tpdo(w->wire.twin_of, &t);
        g.len = (uint8_t)(g.len - w->wire.twin_is_short);
    }
    can_master_receive(&w->master, &g, false, w->now_ns);
}

static void to_master(struct world *w, struct can_queue *q) {
    for (int i = 0; i < q->count; i++) {
        struct can_frame *f = &q->frame[i];
        lie(w, f);
        int tpdo = can_frame_node(f, COB_TPDO);
        if (w->wire.dead_node && (f->can_id & COB_NODE) == (unsigned)w->wire.dead_node) continue;
        if (tpdo && tpdo == w->wire.lose_tpdo_of) continue;
        if (put_off(w, f)) continue;
        can_master_receive(&w->master, f, false, w->now_ns);
        if (w->wire.twin_of && (f->can_id & COB_NODE) == (unsigned)w->wire.twin_of) answer_again(w, f);
    }
    q->count = 0;
}

static void to_nodes(struct world *w, struct can_queue *q) {
    struct can_queue replies = {0};
    for (int k = 0; k < q->count; k++) {
        const struct can_frame *f = &q->frame[k];
        bool outputs = f->can_id == COB_RPDO + CAN_IO;
        w->to_node_7 += outputs || can_frame_node(f, COB_SDO) == CAN_IO;
        if (w->wire.lose_rpdo && (f->can_id & COB_FUNCTION) == COB_RPDO) continue;
        if (w->wire.lose_outputs && outputs) continue;
        if (w->wire.lose_heartbeat && can_frame_node(f, COB_HEARTBEAT)) continue;
        bool sync = f->can_id == COB_SYNC;
        if (sync && w->wire.lose_echo) continue;
        can_master_receive(&w->master, f, true, w->now_ns);
        for (int i = 0; i < CAN_NODES; i++) {
            if (w->wire.dead_node == i + 1) continue;
            if (sync) can_node_sync(&w->node[i], f, &w->reading[i], &replies);
            else can_node_receive(&w->node[i], f, w->now_ns, &replies);
        }
        to_master(w, &replies);
    }
    q->count = 0;
}

static struct hal_command commands(struct world *w, const double valve[LEGS]) {
    struct hal_command c = {.enable = true, .supply = w->supply ^= !w->hangs};
    memcpy(c.valve, valve, sizeof c.valve);
    return c;
}

/* One cycle of the loop: sample, then command. */
static struct hal_sample cycle(struct world *w, const double valve[LEGS]) {
    struct can_queue q = {0};
    struct hal_sample s;
    w->now_ns += ns_from_seconds(w->params.loop.period_s);
    for (int i = 0; i < CAN_NODES; i++)
        if (w->wire.dead_node != i + 1) can_node_tick(&w->node[i], w->now_ns, &q);
    to_master(w, &q);
    can_master_poll(&w->master, w->now_ns, true, &q);
    to_nodes(w, &q);
    can_master_sample(&w->master, &s);
    s.age_ns = w->now_ns - s.time_ns;
    /* as the back-end flags it */
    if (2 * s.age_ns > 3 * ns_from_seconds(w->params.loop.period_s)) s.flags |= SAMPLE_LATE;
    struct hal_command command = commands(w, valve);
    can_master_command(&w->master, &command, &q);
    to_nodes(w, &q);
    hand_in(w);
    return s;
}

static const double centre[LEGS] = {0}, some[LEGS] = {0.1, -0.2, 0.3, -0.4, 0.5, -1.0};

static struct hal_sample cycles(struct world *w, int count, const double valve[LEGS]) {
    struct hal_sample s = {0};
    for (int i = 0; i < count; i++) s = cycle(w, valve);
    return s;
}

static void power_on_with(struct world *w, const struct params *params) {
    struct can_queue q = {0};
    memset(w, 0, sizeof *w);
    w->params = *params;
    can_master_init(&w->master, &w->params, TOKEN);
    w->now_ns = NS_PER_S;
    for (int i = 0; i < CAN_NODES; i++) {
        w->reading[i] = (struct can_tpdo){
            .position = 1831000 + i, .p1 = (int16_t)(5000 + i), .p2 = (int16_t)(4000 - i), .inputs = INPUTS_ALL};
        can_node_init(&w->node[i], i + 1, w->now_ns, &q);
    }
    to_master(w, &q);
}

static void power_on(struct world *w) {
    struct params params;
    config_default(&params);
    power_on_with(w, &params);
}

static void bring_up(struct world *w) {
    power_on(w);
    cycles(w, CYCLES_TO_RUN, centre);
    assert_true(can_master_ready(&w->master));
}

static void tpdo_comes_back_as_it_was(void **state) {
    uint64_t seed = 1;
    (void)state;
    for (int i = 0; i < 1000; i++) {
        struct can_tpdo in = {.position = (int32_t)(random_unit(&seed) * 2147483647.0),
                              .p1 = (int16_t)(random_unit(&seed) * 32767.0),
                              .p2 = (int16_t)(random_unit(&seed) * 32767.0),
                              .inputs = (uint8_t)random_below(&seed, 256)},
                        out;
        struct can_frame f = can_frame_tpdo(1 + i % CAN_NODES, &in);
        assert_int_equal(can_frame_node(&f, COB_TPDO), 1 + i % CAN_NODES);
        assert_true(can_parse_tpdo(&f, &out));
        if (1 + i % CAN_NODES == CAN_IO) {
            assert_int_equal(f.len, 1);
            assert_int_equal(in.inputs, out.inputs);
            continue;
        }
        assert_int_equal(in.position, out.position);
        assert_int_equal(in.p1, out.p1);
        assert_int_equal(in.p2, out.p2);
    }
}

/* Frames of CiA 301, 7.2.4.3.3 and 7.2.4.3.6. */
static void sdo_frames_are_the_standards(void **state) {
    static const uint8_t write_1017[8] = {0x2b, 0x17, 0x10, 0x00, 0xe8, 0x03, 0, 0}, read_1000[8] = {0x40, 0x00, 0x10, 0x00},
                         written[8] = {0x60, 0x17, 0x10, 0x00}, is_198[8] = {0x43, 0x00, 0x10, 0x00, 0x98, 0x01},
                         aborted[8] = {0x80, 0x17, 0x10, 0x00, 0x02, 0x00, 0x01, 0x06};
    const struct can_sdo download = {SDO_DOWNLOAD, 0x1017, 0, 2, 1000}, upload = {SDO_UPLOAD, 0x1000, 0, 4, 0x198},
                         abort = {SDO_ABORT, 0x1017, 0, 0, SDO_READ_ONLY};
    (void)state;
    assert_memory_equal(can_frame_sdo(1, &download).data, write_1017, 8);
    assert_memory_equal(can_frame_sdo(1, &upload).data, read_1000, 8);
    assert_memory_equal(can_frame_sdo_reply(1, &download).data, written, 8);
    assert_memory_equal(can_frame_sdo_reply(1, &upload).data, is_198, 8);
    assert_memory_equal(can_frame_sdo_reply(1, &abort).data, aborted, 8);
}

static void no_frame_upsets_nodes_or_master(void **state) {
    struct world w;
    uint64_t seed = 7;
    (void)state;
    bring_up(&w);
    for (int i = 0; i < 200000; i++) {
        struct can_frame f = {.can_id = (canid_t)random_below(&seed, 0x800), .len = (uint8_t)random_below(&seed, 9)};
        struct can_queue q = {0};
        struct hal_sample s;
        if (random_below(&seed, 50) == 0) f.can_id |= CAN_ERR_FLAG;
        for (int k = 0; k < 8; k++) f.data[k] = (uint8_t)random_below(&seed, 256);
        can_master_receive(&w.master, &f, random_below(&seed, 2), w.now_ns);
        can_node_receive(&w.node[i % CAN_NODES], &f, w.now_ns, &q);
        can_node_tick(&w.node[i % CAN_NODES], w.now_ns, &q);
        can_master_sample(&w.master, &s);
        w.now_ns += 10 * NS_PER_US;
    }
}

static int stuffed_bits(const uint8_t *bit, int count) {
    int stuffed = 0, run = 0, last = -1;
    for (int i = 0; i < count; i++) {
        run = bit[i] == last ? run + 1 : 1;
        last = bit[i];
        if (run == 5) stuffed++, last = !last, run = 1;
    }
    return stuffed;
}

/* The worst case is 11111 0000 1111 ...: each stuff bit is the first of the next five. */
static void frame_bits_are_the_worst_that_stuffing_can_do(void **state) {
    (void)state;
    for (int n = 0; n <= 8; n++) {
        uint8_t bit[34 + 64];
        int count = 34 + 8 * n;
        for (int i = 0; i < count; i++) bit[i] = i < 5 || (i - 5) / 4 % 2;
        /* 13 bits: delimiters, acknowledge, end of frame, interframe space */
        assert_int_equal(can_frame_bits(n), count + stuffed_bits(bit, count) + 13);
    }
}

static struct params not_wired(void) {
    struct params p;
    config_default(&p);
    p.interlocks = (struct interlock_params){0};
    return p;
}

static void bus_load_at_a_megabit_and_two_milliseconds_is_sixty_three_percent_or_less(void **state) {
    struct params p = not_wired();
    (void)state;
    assert_int_equal(can_load(&p).cycle_bits, can_frame_bits(0) + 6 * can_frame_bits(8) + 2 * can_frame_bits(6));
    config_default(&p);
    struct can_load l = can_load(&p);
    assert_int_equal(l.cycle_bits, can_frame_bits(0) + 6 * can_frame_bits(8) + 2 * can_frame_bits(6) + 2 * can_frame_bits(1));
    assert_true(l.share > 0.6 && l.share < 0.63 && l.share < l.limit);
    p.can.bitrate_bps = 500e3;
    assert_true(can_load(&p).share > can_load(&p).limit);
}

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

static void all_nodes_are_set_up_and_started(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    for (int i = 0; i < CAN_NODES; i++) {
        assert_int_equal(w.node[i].state, CAN_OPERATIONAL);
        assert_int_equal(w.node[i].value[can_object_find(w.node[i].dictionary, 0x1400, 1)], can_rpdo_cob(can_group(i + 1)));
        assert_int_equal(w.node[i].value[can_object_find(w.node[i].dictionary, 0x1400, 5)], 20);
    }
}

static void every_command_reaches_its_own_leg_with_the_sync(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    cycle(&w, some);
    /* within half a step */
    for (int i = 0; i < LEGS; i++) assert_close(can_node_output(&w.node[i]) / 32767.0, some[i], 0.5 / 32767);
    struct can_frame rpdo = can_frame_rpdo(0, (int16_t[]){1, 2, 3});
    struct can_queue q = {0};
    can_node_receive(&w.node[0], &rpdo, w.now_ns, &q);
    /* takes effect only at the next SYNC */
    assert_close(can_node_output(&w.node[0]) / 32767.0, some[0], 0.5 / 32767);
}

static void the_sample_is_what_was_latched_at_the_sync_before(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    cycle(&w, centre);
    int64_t sync_ns = w.now_ns;
    w.reading[3].position = 1900000; /* changes after the SYNC */
    struct hal_sample s = cycle(&w, centre);
    assert_int_equal(s.flags, 0);
    assert_int_equal(s.time_ns, sync_ns);
    for (int i = 0; i < LEGS; i++) {
        assert_close(s.length_m[i], 1.831 + 1e-6 * i, 1e-12); /* rounding */
        assert_close(s.p1_pa[i], 5e6 + 1e3 * i, 1e-6);
        assert_close(s.p2_pa[i], 4e6 - 1e3 * i, 1e-6);
    }
    s = cycle(&w, centre);
    assert_close(s.length_m[3], 1.9, 1e-12);
}

static void a_lost_tpdo_makes_the_sample_stale_and_the_next_one_says_so(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    struct hal_sample before = cycle(&w, centre);
    w.wire.lose_tpdo_of = 4;
    cycle(&w, centre);
    w.wire.lose_tpdo_of = 0;
    w.reading[0].position += 100;
    for (int i = 0; i < 3; i++) { /* each of the next two SYNCs waits for a cycle */
        struct hal_sample s = cycle(&w, centre);
        assert_int_equal(s.flags, SAMPLE_STALE | SAMPLE_LATE);
        assert_int_equal(s.device_seq, before.device_seq + 1);
    }
    assert_int_equal(cycle(&w, centre).flags, SAMPLE_DROPPED | SAMPLE_LATE);
    assert_int_equal(cycle(&w, centre).flags, SAMPLE_LATE);
    assert_int_equal(cycle(&w, centre).flags, 0);
    assert_int_equal(w.master.lost, 1);
}

/* All legs move by the same amount every cycle, so a difference beyond the legs' own offsets
 * reveals readings of different cycles. Returns true if all are of one cycle. */
static bool of_one_instant(struct world *w, const double valve[LEGS], struct hal_sample *s) {
    for (int k = 0; k < CAN_NODES; k++) w->reading[k].position += 1000;
    *s = cycle(w, valve);
    for (int k = 0; k < LEGS; k++)        /* tolerance for rounding; a cycle is 1e-3 */
        if (!(fabs(s->length_m[k] - s->length_m[0] - 1e-6 * k) < 1e-9)) return false;
    return true;
}

static void a_tpdo_a_cycle_late_is_of_its_own_sync_or_left_out_whatever_is_commanded(void **state) {
    struct world w;
    struct hal_sample s;
    uint64_t seed = 11;
    (void)state;
    bring_up(&w);
    for (int i = 0; i < 20000; i++) {
        /* first always late, then occasionally */
        w.wire.late_by = i / 100 % 2 ? 1 : (int)random_below(&seed, 2);
        w.wire.lose_tpdo_of = random_below(&seed, 50) ? 0 : 1 + (int)random_below(&seed, CAN_NODES);
        bool one = of_one_instant(&w, random_below(&seed, 3) ? some : centre, &s);
        assert_true(one || s.flags & (SAMPLE_STALE | SAMPLE_LATE));
    }
}

static void a_leg_that_becomes_late_for_good_is_never_taken_for_punctual(void **state) {
    (void)state;
    for (int i = 0; i < LATE_MAX * LATE_MAX; i++) {
        struct world w;
        struct hal_sample s;
        int first = i / LATE_MAX, then = i % LATE_MAX;
        if (then == 0) continue;
        bring_up(&w);
        cycles(&w, 2, some);
        w.wire.late_by = first;
        cycle(&w, some);
        w.wire.late_by = then;
        cycle(&w, some);
        for (int k = 0; k < 1000; k++)
            if (!of_one_instant(&w, some, &s)) assert_true(s.flags & (SAMPLE_STALE | SAMPLE_LATE));
        w.wire.late_by = 0;
        cycles(&w, 2 * LATE_MAX, some);
        assert_true(of_one_instant(&w, some, &s));
        assert_int_equal(s.flags, 0);
    }
}

/* The waiting time owed from the cycle before is postponed for a centring command. */
static void the_command_that_centres_waits_for_no_tpdo(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    cycle(&w, some);
    w.wire.lose_tpdo_of = 4;
    cycle(&w, some);
    assert_true(can_node_output(&w.node[5]) < -32000);
    cycle(&w, centre);
    for (int i = 0; i < LEGS; i++) assert_int_equal(can_node_output(&w.node[i]), 0);
}

static void without_commands_a_node_centres_its_valve_and_takes_no_late_one(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    cycle(&w, some);
    w.wire.lose_rpdo = true;
    cycles(&w, 9, some);
    assert_true(can_node_output(&w.node[5]) < -32000); /* 18 ms are ridden out */
    cycles(&w, 2, some);
    for (int i = 0; i < CAN_NODES; i++) {
        assert_int_equal(can_node_output(&w.node[i]), 0);
        assert_int_equal(w.node[i].state, CAN_PREOPERATIONAL);
        assert_int_equal(w.node[i].errors, 1u << CAN_ERROR_RPDO_TIMEOUT);
    }
    struct can_frame late = can_frame_rpdo(0, (int16_t[]){20000, 20000, 20000});
    struct can_queue q = {0};
    can_node_receive(&w.node[0], &late, w.now_ns, &q);
    can_node_sync(&w.node[0], &(struct can_frame){.can_id = COB_SYNC}, &w.reading[0], &q);
    assert_int_equal(can_node_output(&w.node[0]), 0);
    assert_false(can_master_ready(&w.master));
}

static void a_silent_bus_is_set_up_again_when_it_speaks(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    w.wire.lose_rpdo = true;
    cycles(&w, 15, some);
    assert_false(can_master_ready(&w.master));
    w.wire.lose_rpdo = false;
    struct hal_sample s = cycles(&w, CYCLES_TO_RUN, centre);
    assert_true(can_master_ready(&w.master));
    assert_int_equal(s.flags, 0);
}

static void without_the_daemons_heartbeat_the_valves_are_centred(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    w.wire.lose_heartbeat = true;
    int left = 0;
    for (; left < 200 && can_node_output(&w.node[0]) != 0; left++) cycle(&w, some);
    cycle(&w, some);
    left = 0;
    while (left < 200 && w.node[0].state == CAN_OPERATIONAL) cycle(&w, some), left++;
    assert_true(left < 80); /* 150 ms and one cycle */
    assert_int_equal(can_node_output(&w.node[0]), 0);
}

static void a_lost_node_invalidates_samples_and_commands(void **state) {
    struct world w;
    struct hal_sample s;
    (void)state;
    bring_up(&w);
    w.wire.dead_node = 3;
    s = cycles(&w, 2, centre);
    assert_true(s.flags & SAMPLE_STALE);
    s = cycles(&w, 80, centre);
    assert_true(s.flags & SAMPLE_INVALID);
    assert_false(can_master_ready(&w.master));
    char text[200];
    can_condition_describe(can_master_condition(&w.master), &w.params, text, sizeof text);
    assert_non_null(strstr(text, "node 3 lost"));
}

static void a_node_that_was_reset_is_set_up_again_and_meanwhile_nothing_is_valid(void **state) {
    struct world w;
    struct can_queue q = {0};
    (void)state;
    bring_up(&w);
    cycle(&w, some);
    can_node_init(&w.node[4], 5, w.now_ns, &q);
    to_master(&w, &q);
    assert_false(can_master_ready(&w.master));
    assert_true(cycle(&w, centre).flags & SAMPLE_INVALID);
    struct hal_sample s = cycles(&w, CYCLES_TO_RUN, centre);
    assert_true(can_master_ready(&w.master));
    assert_int_equal(s.flags, 0);
    assert_int_equal(w.master.boots, CAN_NODES + 1);
}

/* The node boots unheard and then stays silent, because its heartbeat is off until set-up. */
static void a_lost_node_that_keeps_silent_is_asked_and_set_up_again(void **state) {
    struct world w;
    struct can_queue unheard = {0};
    (void)state;
    bring_up(&w);
    w.wire.dead_node = 3;
    can_node_init(&w.node[2], 3, w.now_ns, &unheard);
    cycles(&w, 500, centre);
    assert_int_equal(w.master.peer[2].phase, CAN_LOST);
    w.wire.dead_node = 0;
    struct hal_sample s = cycles(&w, 500, centre); /* asks twice a second */
    assert_true(can_master_ready(&w.master));
    assert_int_equal(s.flags, 0);
}

/* The platform handles a missing pressure; the node's EMCY 0x5000 adds nothing. */
static void a_pressure_that_is_missing_is_no_number_and_the_sample_is_good_for_the_rest(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    struct can_tpdo good = w.reading[1];
    w.reading[1].p1 = INT16_MIN; /* the sensor's wire is broken */
    for (int i = 0; i < 5; i++) {
        cycle(&w, centre);
        struct hal_sample s = cycle(&w, centre);
        assert_int_equal(w.master.peer[1].emcy, EMCY_SENSOR);
        assert_int_equal(s.flags, 0);
        assert_true(isnan(s.p1_pa[1]) && isfinite(s.p2_pa[1]) && isfinite(s.length_m[1]) && isfinite(s.p1_pa[0]));
    }
    w.reading[1] = good;
    w.reading[2].position = INT32_MIN;
    cycle(&w, centre);
    assert_true(isnan(cycle(&w, centre).length_m[2]));
}

static void an_emergency_invalidates_the_sample_until_it_is_over(void **state) {
    static const uint16_t codes[] = {EMCY_SENSOR, EMCY_RPDO_SHORT, EMCY_RPDO_LONG, EMCY_SYNC_LENGTH, 0xff00};
    (void)state;
    for (int node = 1; node <= CAN_NODES; node++)
        for (unsigned i = 0; i < sizeof codes / sizeof *codes; i++) {
            struct world w;
            const struct can_frame stands = can_frame_emcy(node, codes[i], 0x81), over = can_frame_emcy(node, EMCY_NONE, 0);
            bring_up(&w);
            can_master_receive(&w.master, &stands, false, w.now_ns);
            assert_true(cycle(&w, centre).flags & SAMPLE_INVALID);
            assert_true(cycle(&w, centre).flags & SAMPLE_INVALID);
            can_master_receive(&w.master, &over, false, w.now_ns);
            assert_int_equal(cycle(&w, centre).flags, 0);
        }
}

static void a_missing_reading_hides_no_other_error_of_its_node(void **state) {
    (void)state;
    for (int first = 0; first < 2; first++) {
        struct world w;
        const struct can_frame other = can_frame_emcy(2, EMCY_RPDO_SHORT, 0x91);
        bring_up(&w);
        if (first) can_master_receive(&w.master, &other, false, w.now_ns);
        w.reading[1].p1 = INT16_MIN;
        cycle(&w, centre);
        cycle(&w, centre);
        if (!first) can_master_receive(&w.master, &other, false, w.now_ns);
        assert_true(cycle(&w, centre).flags & SAMPLE_INVALID);
    }
}

static void one_error_that_is_over_is_not_all_of_them(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    const struct can_frame both[] = {can_frame_emcy(2, EMCY_SENSOR, 0x81), can_frame_emcy(2, EMCY_RPDO_SHORT, 0x91),
                                     can_frame_emcy(2, EMCY_NONE, 0x81)};
    for (int i = 0; i < 3; i++) {
        can_master_receive(&w.master, &both[i], false, w.now_ns);
        assert_true(cycle(&w, centre).flags & SAMPLE_INVALID);
    }
    const struct can_frame over = can_frame_emcy(2, EMCY_NONE, 0);
    can_master_receive(&w.master, &over, false, w.now_ns);
    assert_int_equal(cycle(&w, centre).flags, 0);
}

static void bus_off_lets_no_command_through_until_the_bus_is_restarted(void **state) {
    struct world w;
    struct can_frame off = {.can_id = CAN_ERR_FLAG | CAN_ERR_BUSOFF, .len = 8};
    struct can_frame restarted = {.can_id = CAN_ERR_FLAG | CAN_ERR_RESTARTED, .len = 8};
    struct hal_sample s;
    (void)state;
    bring_up(&w);
    can_master_receive(&w.master, &off, false, w.now_ns);
    assert_false(can_master_ready(&w.master));
    can_master_sample(&w.master, &s);
    assert_true(s.flags & SAMPLE_INVALID);
    can_master_receive(&w.master, &restarted, false, w.now_ns);
    assert_true(can_master_ready(&w.master));
}

static void error_passive_is_told_but_moves_on(void **state) {
    struct world w;
    struct can_frame passive = {.can_id = CAN_ERR_FLAG | CAN_ERR_CRTL, .len = 8, .data = {0, CAN_ERR_CRTL_TX_PASSIVE}};
    char text[200];
    (void)state;
    bring_up(&w);
    can_master_receive(&w.master, &passive, false, w.now_ns);
    assert_true(can_master_ready(&w.master));
    can_condition_describe(can_master_condition(&w.master), &w.params, text, sizeof text);
    assert_non_null(strstr(text, "error-passive"));
}

static void a_sync_that_the_bus_does_not_carry_yields_no_new_sample(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    w.wire.lose_echo = true;
    cycle(&w, centre);
    struct hal_sample s = cycle(&w, centre);
    assert_int_equal(w.master.unechoed, 2);
    assert_true(s.flags & SAMPLE_STALE);
}

static void a_node_with_another_mapping_is_not_started(void **state) {
    struct world w;
    (void)state;
    power_on(&w);
    w.node[2].value[can_object_find(w.node[2].dictionary, 0x1a00, 2)] = MAP_P2;
    cycles(&w, CYCLES_TO_RUN, centre);
    assert_false(can_master_ready(&w.master));
    assert_int_not_equal(w.node[2].state, CAN_OPERATIONAL);
}

static const char *condition(const struct world *w, char text[200]) {
    can_condition_describe(can_master_condition(&w->master), &w->params, text, 200);
    return text;
}

/* Covers every object that the set-up reads, found by its requests. */
static void a_node_that_answers_otherwise_is_not_started_whatever_it_is(void **state) {
    static const uint32_t asked[] = {0x100000, 0x101801, 0x101802, 0x101601, 0x101700, 0x102901, 0x100500, 0x140001, 0x140002, 0x140005,
                                     0x160000, 0x160001, 0x160002, 0x160003, 0x180001, 0x180002, 0x1a0000, 0x1a0001, 0x1a0002, 0x1a0003};
    (void)state;
    for (unsigned i = 0; i < sizeof asked / sizeof *asked; i++) {
        struct world w;
        char text[200], object[32];
        uint16_t index = (uint16_t)(asked[i] >> 8);
        uint8_t sub = (uint8_t)asked[i];
        power_on(&w);
        w.wire.lying_node = 4;
        w.wire.lie = (struct can_sdo){SDO_UPLOAD, index, sub, can_axis.object[can_object_find(&can_axis, index, sub)].size, 77};
        cycles(&w, CYCLES_TO_RUN, centre);
        assert_false(can_master_ready(&w.master));
        assert_int_equal(w.node[3].state, CAN_PREOPERATIONAL);
        assert_int_equal(w.node[4].state, CAN_OPERATIONAL);
        assert_true(can_master_misfit(&w.master));
        snprintf(object, sizeof object, "0x%04x:%u", index, sub);
        if (!strstr(condition(&w, text), "node 4") || !strstr(text, object) || !strstr(text, "0x4d")) fail_msg("%s: %s", object, text);
        w.wire.lying_node = 0; /* the node was replaced */
        cycles(&w, 2 * CYCLES_TO_RUN, centre);
        assert_true(can_master_ready(&w.master));
    }
}

static void a_node_of_another_vendor_runs_when_it_is_configured(void **state) {
    static const uint32_t objects[] = {0x100000, 0x101801, 0x101802};
    (void)state;
    for (int k = 0; k < 3; k++)
        for (int any = 0; any < 2; any++) {
            struct world w;
            power_on(&w);
            double *keys[] = {&w.params.can.device_type, &w.params.can.vendor_id, &w.params.can.product_code};
            *keys[k] = any ? -1.0 : 4294967295.0;
            w.wire.lying_node = 1;
            w.wire.lie = (struct can_sdo){SDO_UPLOAD, (uint16_t)(objects[k] >> 8), (uint8_t)objects[k], any ? 4 : 0, 0xffffffff};
            int place = can_object_find(&can_axis, w.wire.lie.index, w.wire.lie.sub);
            for (int i = 1; i < LEGS; i++) w.node[i].value[place] = 0xffffffff;
            cycles(&w, CYCLES_TO_RUN, centre);
            assert_true(can_master_ready(&w.master));
        }
}

static void inputs_are_what_was_latched_at_the_sync_before(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    w.params.interlocks.antivalent = false;
    for (unsigned inputs = 0; inputs <= 0xff; inputs++) {
        w.reading[CAN_IO - 1].inputs = (uint8_t)inputs;
        cycle(&w, centre);
        w.reading[CAN_IO - 1].inputs = (uint8_t)~inputs; /* change after the SYNC */
        struct hal_sample s = cycle(&w, centre);
        assert_int_equal(s.flags, 0);
        assert_int_equal(s.inputs, inputs & INPUTS_ALL);
        assert_int_equal(s.contradicted, 0);
    }
}

static void an_input_is_closed_where_both_of_its_contacts_say_so_and_told_where_they_contradict(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    for (unsigned bits = 0; bits <= 0xff; bits++) {
        w.reading[CAN_IO - 1].inputs = (uint8_t)bits;
        struct hal_sample s = cycles(&w, 2, centre);
        assert_int_equal(s.flags, 0);
        for (int i = 0; i < INPUTS; i++) {
            bool plain = bits >> i & 1, inverse = bits >> (i + 4) & 1;
            assert_int_equal(s.inputs >> i & 1, plain && !inverse);
            assert_int_equal(s.contradicted >> i & 1, plain == inverse);
        }
    }
}

/* A leg's TPDO is lost in the cycle in which the door opens or its contacts contradict. */
static void what_opens_or_contradicts_does_not_wait_for_the_sample_to_be_whole(void **state) {
    (void)state;
    for (int inverse = 0; inverse < 2; inverse++) {
        struct world w;
        bring_up(&w);
        assert_int_equal(cycle(&w, centre).inputs, INPUTS_ALL);
        w.wire.lose_tpdo_of = 4;
        w.reading[CAN_IO - 1].inputs = (uint8_t)((INPUTS_ALL & ~INPUT_DOOR) | (inverse ? INPUT_DOOR << 4 : 0));
        cycle(&w, centre);
        struct hal_sample s = cycle(&w, centre);
        assert_true(s.flags & SAMPLE_STALE);
        assert_int_equal(s.inputs, INPUTS_ALL & ~INPUT_DOOR);
        assert_int_equal(s.contradicted, inverse ? 0 : INPUT_DOOR);
    }
}

static void what_contradicts_does_so_until_its_module_says_otherwise(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    w.reading[CAN_IO - 1].inputs = INPUTS_ALL & ~INPUT_DOOR;
    assert_int_equal(cycles(&w, 2, centre).contradicted, INPUT_DOOR);
    w.wire.lose_tpdo_of = CAN_IO;
    assert_int_equal(cycles(&w, 2, centre).contradicted, INPUT_DOOR);
}

/* ---- two devices with one number ---- */

static void twin(struct world *w, int node, int um, unsigned inputs) {
    bring_up(w);
    w->wire.twin_of = node, w->wire.twin_percent = 100;
    w->wire.twin_adds = (struct can_tpdo){.position = um, .inputs = (uint8_t)inputs};
}

static void two_answers_of_a_leg_in_one_cycle_are_no_length_and_name_it(void **state) {
    (void)state;
    for (int node = 1; node <= LEGS; node++) {
        struct world w;
        twin(&w, node, node == 1 ? 700 : 1, 0);
        cycle(&w, some);
        for (int i = 0; i < 100; i++) {
            struct hal_sample s = cycle(&w, some);
            assert_true(s.flags & SAMPLE_TWIN);
            assert_int_equal(s.twins, 1u << (node - 1));
        }
        w.wire.twin_of = 0; /* the report ends with the twin */
        assert_int_equal(cycles(&w, 300, some).flags, 0);
    }
}

/* The twin says "closed" before or after the node says "open". */
static void an_input_is_open_if_any_answer_says_so(void **state) {
    static const uint8_t open[] = {0xe1, 0xd2, 0xb4, 0x78};
    (void)state;
    for (int antivalent = 0; antivalent < 2; antivalent++)
        for (unsigned k = 0; k < 4; k++)
            for (int first = 0; first < 2; first++) {
                struct world w;
                const uint8_t closed = 0x0f, says = antivalent ? open[k] : open[k] & 0x0f;
                twin(&w, CAN_IO, 0, first ? says : closed);
                w.params.interlocks.antivalent = antivalent;
                w.reading[CAN_IO - 1].inputs = first ? closed : says;
                struct hal_sample s = cycles(&w, 2, some);
                assert_int_equal(s.inputs, says & 0x0f);
                assert_true(s.flags & SAMPLE_TWIN);
                assert_int_equal(s.twins, 0);
            }
}

/* The twin must be found before its readings differ: a pressed emergency stop must not be its first
 * sign. */
static void a_twin_that_says_the_same_is_found_within_a_tenth_of_a_second(void **state) {
    (void)state;
    for (int node = 1; node <= CAN_NODES; node++) {
        struct world w;
        char text[200];
        int cycle_count = 0;
        twin(&w, node, 0, 0);
        while (!(cycle(&w, some).flags & SAMPLE_TWIN)) cycle_count++;
        assert_in_range(cycle_count, 40, 52);
        condition(&w, text);
        char named[32];
        snprintf(named, sizeof named, "node %d answers twice", node);
        assert_non_null(strstr(text, named));
    }
}

static void a_bus_that_repeats_every_fifth_frame_is_no_twin(void **state) {
    struct world w;
    (void)state;
    twin(&w, 3, 0, 0);
    w.wire.twin_percent = 20;
    for (int i = 0; i < 50000; i++) assert_int_equal(cycle(&w, some).flags, 0);
    assert_true(w.master.twice > 9000);
}

static void one_frame_that_comes_twice_is_ridden_out(void **state) {
    struct world w;
    struct can_frame again;
    (void)state;
    bring_up(&w);
    for (int node = 1; node <= CAN_NODES; node++) {
        again = can_frame_tpdo(node, &w.reading[node - 1]);
        can_master_receive(&w.master, &again, false, w.now_ns);
        assert_int_equal(cycle(&w, some).flags, 0);
        again = can_frame_heartbeat(node, CAN_OPERATIONAL);
        can_master_receive(&w.master, &again, false, w.now_ns);
        assert_int_equal(cycle(&w, some).flags, 0);
    }
}

/* The twin hears no SYNC or its TPDO is off, so only its heartbeats show it. */
static void a_twins_heartbeats_are_too_many_and_a_nodes_own_are_not(void **state) {
    (void)state;
    for (int twins = 0; twins < 2; twins++) {
        struct world w;
        int beat = 0, flagged = 0;
        bring_up(&w);
        int cycles_a_beat = (int)lround(w.params.can.heartbeat_s / w.params.loop.period_s);
        for (int i = 0; i < 40 * cycles_a_beat; i++) {
            const struct can_frame f = can_frame_heartbeat(4, CAN_OPERATIONAL);
            if (twins && i % cycles_a_beat == 7) can_master_receive(&w.master, &f, false, w.now_ns), beat++;
            struct hal_sample s = cycle(&w, some);
            flagged += (s.flags & SAMPLE_TWIN) != 0;
            if (s.flags & SAMPLE_TWIN) assert_int_equal(s.twins, 1u << 3);
        }
        assert_int_equal(flagged > 0, twins);
    }
}

static void a_twin_that_answers_the_set_up_is_found_in_it(void **state) {
    struct world w;
    (void)state;
    power_on(&w);
    w.wire.twin_of = 5, w.wire.twin_percent = 100;
    for (int i = 0; i < CYCLES_TO_RUN && !can_master_twin(&w.master); i++) cycle(&w, centre);
    assert_int_equal(can_master_twin(&w.master), 5);
}

static void frames_of_another_length_are_no_sign_of_life_and_are_judged(void **state) {
    struct world w;
    (void)state;
    twin(&w, 2, 0, 0);
    w.wire.twin_is_short = true;
    cycle(&w, some);
    for (int i = 0; i < 20; i++) assert_int_equal(cycle(&w, some).twins, 1u << 1);
    bring_up(&w);
    w.wire.dead_node = 6; /* another device sends two-byte heartbeats in its place */
    const struct can_frame strange = {.can_id = COB_HEARTBEAT + 6, .len = 2, .data = {CAN_OPERATIONAL}};
    for (int i = 0; i < 400; i++) {
        if (i % 50 == 0) can_master_receive(&w.master, &strange, false, w.now_ns);
        cycle(&w, some);
    }
    assert_int_equal(w.master.peer[5].phase, CAN_LOST);
}

static void without_node_7_nothing_is_closed_and_no_sample_is_whole(void **state) {
    struct world w;
    char text[200];
    (void)state;
    bring_up(&w);
    assert_int_equal(cycle(&w, centre).inputs, INPUTS_ALL);
    w.wire.lose_tpdo_of = CAN_IO;
    assert_true(cycles(&w, 2, centre).flags & SAMPLE_STALE);
    w.wire.lose_tpdo_of = 0;
    assert_int_equal(cycles(&w, 10, centre).flags, 0);
    w.wire.dead_node = CAN_IO;
    assert_true(cycles(&w, 2, centre).flags & SAMPLE_STALE);
    struct hal_sample s = cycles(&w, 80, centre);
    assert_true(s.flags & SAMPLE_INVALID);
    assert_int_equal(s.inputs, 0);
    assert_false(can_master_ready(&w.master));
    assert_string_equal(condition(&w, text), "node 7 lost");
    w.wire.dead_node = 0;
    s = cycles(&w, 500, centre); /* asks twice a second */
    assert_int_equal(s.flags, 0);
    assert_int_equal(s.inputs, INPUTS_ALL);
}

/* A rebooted module may have other inputs than before; a module that only lost the daemon has the
 * same ones. */
static void an_io_module_that_boots_closes_nothing_until_it_is_set_up(void **state) {
    for (int boots = 0; boots < 2; boots++) {
        struct world w;
        struct can_queue q = {0};
        (void)state;
        bring_up(&w);
        if (boots) can_node_init(&w.node[CAN_IO - 1], CAN_IO, w.now_ns, &q);
        to_master(&w, &q);
        w.wire.lose_outputs = !boots;
        while (w.master.peer[CAN_IO - 1].phase == CAN_RUNNING) cycle(&w, centre);
        w.wire.lose_outputs = false;
        struct hal_sample s = cycle(&w, centre);
        assert_true(s.flags & SAMPLE_INVALID);
        assert_int_equal(s.inputs, boots ? 0 : INPUTS_ALL);
        for (int i = 0; s.flags & (SAMPLE_INVALID | SAMPLE_STALE); i++) {
            assert_true(i < CYCLES_TO_RUN);
            assert_int_equal(s.inputs, boots ? 0 : INPUTS_ALL);
            s = cycle(&w, centre);
        }
        assert_int_equal(s.inputs, INPUTS_ALL);
    }
}

static bool supply(const struct world *w) { return can_node_output(&w->node[CAN_IO - 1]) & OUTPUT_SUPPLY; }

/* Counts the cycles in which the output changed. */
static int changes(struct world *w, int count) {
    int changed = 0;
    for (int i = 0; i < count; i++) {
        bool before = supply(w);
        cycle(w, some);
        changed += supply(w) != before;
    }
    return changed;
}

static void the_supply_output_changes_with_every_command_and_not_without(void **state) {
    struct world w;
    struct can_queue q = {0};
    (void)state;
    bring_up(&w);
    assert_int_equal(changes(&w, 100), 100);
    w.hangs = true;
    assert_int_equal(changes(&w, 100), 0);
    w.hangs = false;
    assert_int_equal(changes(&w, 10), 10);
    for (int i = 0; i < 20; i++) {
        bool before = supply(&w);
        w.now_ns += ns_from_seconds(w.params.loop.period_s);
        can_master_safe(&w.master, &q);
        to_nodes(&w, &q);
        assert_int_equal(supply(&w), before);
    }
    assert_int_equal(can_node_output(&w.node[5]), 0);
    assert_int_equal(changes(&w, 100), 100);
}

/* Every second cycle waits for the late leg; a level sent as commanded would look constant. */
static void the_supply_output_changes_where_every_second_cycle_waits(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    w.wire.late_by = 1;
    cycles(&w, 10, some);
    int changed = changes(&w, 100);
    assert_in_range(changed, 45, 55);
    for (int i = 0; i < 20; i++) assert_true(changes(&w, 4) >= 1);
    w.hangs = true;
    cycles(&w, 2, some);
    assert_int_equal(changes(&w, 100), 0);
}

static void a_change_that_waits_is_not_made_up_for_by_safe(void **state) {
    struct world w;
    struct can_queue q = {0};
    (void)state;
    bring_up(&w);
    w.wire.late_by = 1;
    for (int tries = 0; w.master.pause != CAN_PAUSED || !w.master.due; tries++) {
        assert_true(tries < 20);
        cycle(&w, some);
    }
    bool before = supply(&w);
    for (int i = 0; i < 10; i++) {
        can_master_safe(&w.master, &q);
        to_nodes(&w, &q);
        assert_int_equal(supply(&w), before);
    }
}

static void what_is_not_enabled_is_the_centre(void **state) {
    struct world w;
    struct can_queue q = {0};
    (void)state;
    bring_up(&w);
    cycle(&w, some);
    struct hal_command off = commands(&w, some);
    off.enable = false;
    can_master_command(&w.master, &off, &q);
    to_nodes(&w, &q);
    for (int i = 0; i < LEGS; i++) assert_int_equal(can_node_output(&w.node[i]), 0);
}

static void without_its_rpdo_or_the_heartbeat_the_supply_output_is_off(void **state) {
    (void)state;
    for (int lost = 0; lost < 2; lost++) {
        struct world w;
        bring_up(&w);
        while (!supply(&w)) cycle(&w, some);
        w.wire.lose_outputs = lost == 0;
        w.wire.lose_heartbeat = lost == 1;
        int left = 0;
        for (; w.node[CAN_IO - 1].state == CAN_OPERATIONAL; left++) cycle(&w, some);
        assert_in_range(left, lost ? 48 : 9, lost ? 80 : 12); /* 150 ms; 20 ms */
        assert_int_equal(can_node_output(&w.node[CAN_IO - 1]), 0);
        assert_int_equal(w.node[CAN_IO - 1].errors, 1u << (lost ? CAN_ERROR_HEARTBEAT : CAN_ERROR_RPDO_TIMEOUT));
        assert_true(cycle(&w, centre).flags & SAMPLE_INVALID);
        assert_int_equal(can_node_output(&w.node[0]), 0);
    }
}

static void an_io_module_that_answers_otherwise_is_not_started_whatever_it_is(void **state) {
    static const uint32_t asked[] = {0x100000, 0x101801, 0x101802, 0x101601, 0x101700, 0x102901, 0x100500, 0x140001, 0x140002,
                                     0x140005, 0x160000, 0x160001, 0x180001, 0x180002, 0x1a0000, 0x1a0001, 0x620601, 0x620701};
    (void)state;
    for (unsigned i = 0; i < sizeof asked / sizeof *asked; i++) {
        struct world w;
        char text[200], object[32];
        uint16_t index = (uint16_t)(asked[i] >> 8);
        uint8_t sub = (uint8_t)asked[i];
        power_on(&w);
        w.wire.lying_node = CAN_IO;
        w.wire.lie = (struct can_sdo){SDO_UPLOAD, index, sub, can_io.object[can_object_find(&can_io, index, sub)].size, 77};
        cycles(&w, CYCLES_TO_RUN, centre);
        assert_false(can_master_ready(&w.master));
        assert_int_equal(w.node[CAN_IO - 1].state, CAN_PREOPERATIONAL);
        assert_true(can_master_misfit(&w.master));
        snprintf(object, sizeof object, "0x%04x:%u", index, sub);
        if (!strstr(condition(&w, text), "node 7") || !strstr(text, object) || !strstr(text, "0x4d")) fail_msg("%s: %s", object, text);
        if (asked[i] == 0x101802)
            assert_string_equal(text, "node 7: another device, 0x1018:2 is 0x4d, not 0x4858494f (can.io_product_code)");
    }
}

static void an_io_module_of_another_vendor_runs_when_it_is_configured(void **state) {
    struct world w;
    struct params p;
    (void)state;
    config_default(&p);
    p.can.io_device_type = p.can.io_vendor_id = -1.0, p.can.io_product_code = 77.0;
    power_on_with(&w, &p);
    struct can_node *n = &w.node[CAN_IO - 1];
    for (int i = 0; i < n->dictionary->count; i++)
        if (n->dictionary->object[i].index == 0x1000 || n->dictionary->object[i].index == 0x1018) n->value[i] = 77;
    cycles(&w, CYCLES_TO_RUN, centre);
    assert_true(can_master_ready(&w.master));
}

static void where_nothing_is_wired_there_are_six_nodes_and_no_frame_for_a_seventh(void **state) {
    for (int there = 0; there < 2; there++) {
        struct world w;
        struct params p = not_wired();
        char text[200];
        (void)state;
        power_on_with(&w, &p);
        w.wire.dead_node = there ? 0 : CAN_IO;
        struct hal_sample s = cycles(&w, CYCLES_TO_RUN, some);
        assert_true(can_master_ready(&w.master));
        assert_int_equal(s.flags, 0);
        assert_int_equal(s.inputs, 0);
        assert_int_equal(w.to_node_7, 0);
        assert_int_equal(w.node[CAN_IO - 1].state, CAN_PREOPERATIONAL);
        assert_string_equal(condition(&w, text), "");
        can_master_init(&w.master, &p, TOKEN);
        assert_string_equal(condition(&w, text), "all nodes lost");
    }
}

static void all_nodes_lost_are_told_as_all_and_one_as_one(void **state) {
    struct world w;
    char text[200];
    (void)state;
    bring_up(&w);
    for (int i = 0; i < CAN_NODES; i++) w.master.peer[i].phase = CAN_LOST;
    assert_string_equal(condition(&w, text), "all nodes lost");
    w.master.peer[CAN_IO - 1].phase = CAN_RUNNING;
    assert_string_equal(condition(&w, text), "node 1 lost, node 2 lost, node 3 lost, node 4 lost, node 5 lost, node 6 lost");
    bring_up(&w);
    w.master.peer[CAN_IO - 1].emcy = 0xff00;
    w.master.foreign = 0x7ff | FOREIGN_HEARD;
    assert_string_equal(condition(&w, text), "another master: frame (0x7ff), node 7 EMCY 0xff00");
}

static void an_abort_is_told_as_what_it_is(void **state) {
    struct world w;
    char text[200];
    (void)state;
    power_on(&w);
    w.wire.lying_node = 3;
    w.wire.lie = (struct can_sdo){SDO_ABORT, 0x1400, 5, 0, SDO_VALUE};
    cycles(&w, CYCLES_TO_RUN, centre);
    assert_string_equal(condition(&w, text), "node 3 refused 0x1400:5: abort 0x06090030, value out of range");
    w.wire.lie = (struct can_sdo){SDO_ABORT, 0x1017, 0, 0, 0x08000000};
    cycles(&w, 2 * CYCLES_TO_RUN, centre);
    assert_string_equal(condition(&w, text), "node 3 refused 0x1017:0: abort 0x08000000");
    assert_int_equal(w.node[2].state, CAN_PREOPERATIONAL);
}

static void a_node_without_ownership_is_driven_all_the_same(void **state) {
    struct world w;
    (void)state;
    power_on(&w);
    w.wire.lying_node = 2;
    w.wire.lie = (struct can_sdo){SDO_ABORT, 0x2000, 1, 0, SDO_NO_OBJECT};
    cycles(&w, CYCLES_TO_RUN, centre);
    assert_true(can_master_ready(&w.master));
}

/* The node still believes that it runs, and a running node refuses to have its watchdogs set. */
static void a_lost_node_that_is_still_operational_is_halted_and_set_up(void **state) {
    struct world w;
    (void)state;
    for (int stopped = 0; stopped < 2; stopped++) {
        bring_up(&w);
        w.master.peer[2].phase = CAN_LOST;
        if (stopped) w.node[2].state = CAN_STOPPED;
        cycles(&w, 2 * CYCLES_TO_RUN, centre);
        assert_true(can_master_ready(&w.master));
        assert_int_equal(w.node[2].state, CAN_OPERATIONAL);
    }
}

static void another_masters_first_frame_flags_the_next_sample(void **state) {
    const struct can_sdo read = {SDO_UPLOAD, 0x1000, 0, 0, 0};
    const struct can_frame theirs[] = {can_frame_sync(),
                                       can_frame_nmt(NMT_RESET_NODE, 3),
                                       can_frame_nmt(NMT_START, 0),
                                       can_frame_rpdo(0, (int16_t[]){0, 0, 0}),
                                       can_frame_rpdo(1, (int16_t[]){0, 0, 0}),
                                       can_frame_sdo(6, &read),
                                       can_frame_sdo(7, &read),
                                       can_frame_outputs(0),
                                       can_frame_heartbeat(CAN_MASTER, CAN_OPERATIONAL),
                                       {.can_id = 0x202},
                                       {.can_id = COB_SYNC, .len = 1}};
    const struct can_frame harmless[] = {can_frame_sdo(8, &read),     can_frame_heartbeat(9, CAN_OPERATIONAL),
                                         {.can_id = 0x100, .len = 6}, {.can_id = 0x208, .len = 6},
                                         {.can_id = 0x7ff},           {.can_id = COB_SYNC | CAN_EFF_FLAG}};
    struct world w;
    char text[200];
    (void)state;
    bring_up(&w);
    for (unsigned i = 0; i < sizeof theirs / sizeof *theirs; i++) {
        assert_int_equal(cycle(&w, centre).flags, 0);
        uint64_t syncs = w.master.syncs;
        can_master_receive(&w.master, &theirs[i], false, w.now_ns);
        assert_int_equal(w.master.syncs, syncs); /* opens no window for inputs */
        assert_non_null(strstr(condition(&w, text), "another master: "));
        assert_true(cycle(&w, centre).flags & SAMPLE_FOREIGN);
        /* flagged once; the fault stays latched */
        assert_false(cycle(&w, centre).flags & SAMPLE_FOREIGN);
        can_master_receive(&w.master, &theirs[i], true, w.now_ns); /* our own frame, echoed */
        assert_false(cycle(&w, centre).flags & SAMPLE_FOREIGN);
        cycles(&w, 5, centre); /* one surplus SYNC has passed */
    }
    for (unsigned i = 0; i < sizeof harmless / sizeof *harmless; i++) {
        can_master_receive(&w.master, &harmless[i], false, w.now_ns);
        assert_int_equal(cycle(&w, centre).flags, 0);
    }
}

static void a_node_of_another_master_is_left_alone_until_that_one_is_gone(void **state) {
    struct world w;
    char text[200];
    struct can_queue q = {0};
    const struct can_sdo theirs = {SDO_DOWNLOAD, 0x2000, 1, 4, TOKEN + 1};
    const struct can_frame claim = can_frame_sdo(5, &theirs), beat = can_frame_heartbeat(CAN_MASTER, CAN_OPERATIONAL);
    (void)state;
    power_on(&w);
    can_node_receive(&w.node[4], &claim, w.now_ns, &q);
    w.wire.lose_heartbeat = true; /* our heartbeat, which would keep the other master's claim
                                   * alive */
    for (int i = 0; i < 2 * CYCLES_TO_RUN; i++) {
        can_node_receive(&w.node[4], &beat, w.now_ns, &q);
        cycle(&w, centre);
        q.count = 0;
        assert_false(can_master_claimed(&w.master));
        assert_false(can_master_misfit(&w.master));
        assert_int_equal(w.node[4].state, CAN_PREOPERATIONAL);
    }
    assert_non_null(strstr(condition(&w, text), "node 5 owned by another master"));
    /* nothing was written to the node */
    assert_int_equal(w.node[4].value[can_object_find(w.node[4].dictionary, 0x1017, 0)], 0);
    cycles(&w, CYCLES_TO_RUN, centre);
    w.wire.lose_heartbeat = false;
    cycles(&w, 2 * CYCLES_TO_RUN, centre);
    assert_true(can_master_ready(&w.master));
    assert_true(can_master_claimed(&w.master));
    assert_int_equal(w.node[4].owner.token, TOKEN);
}

static void a_master_that_leaves_centres_the_valves_and_gives_the_nodes_free(void **state) {
    struct world w;
    struct can_queue q = {0};
    (void)state;
    bring_up(&w);
    cycle(&w, some);
    can_master_leave(&w.master, &q);
    assert_int_equal(q.count, 1 + CAN_NODES);
    to_nodes(&w, &q);
    for (int i = 0; i < CAN_NODES; i++) {
        assert_int_equal(w.node[i].state, CAN_PREOPERATIONAL);
        assert_int_equal(can_node_output(&w.node[i]), 0);
        assert_int_equal(w.node[i].owner.token, 0);
    }
    can_master_init(&w.master, &w.params, TOKEN + 1);
    cycles(&w, CYCLES_TO_RUN, centre);
    assert_true(can_master_ready(&w.master));
}

/* A controller's transmit queue holds ten frames by default. */
static void no_cycle_sends_more_than_ten_frames(void **state) {
    struct world w;
    (void)state;
    power_on(&w);
    for (int i = 0; i < 2 * CYCLES_TO_RUN; i++) {
        struct can_queue q = {0};
        if (i == CYCLES_TO_RUN)
            for (int k = 0; k < CAN_NODES; k++) can_node_init(&w.node[k], k + 1, w.now_ns, &q);
        to_master(&w, &q);
        w.now_ns += ns_from_seconds(w.params.loop.period_s);
        can_master_poll(&w.master, w.now_ns, true, &q);
        struct hal_command command = commands(&w, some);
        can_master_command(&w.master, &command, &q);
        assert_true(q.count <= 10);
        to_nodes(&w, &q);
    }
}

static uint32_t write_object(struct can_node *n, uint16_t index, uint8_t sub, int size, uint32_t value) {
    const struct can_sdo request = {SDO_DOWNLOAD, index, sub, size, value};
    struct can_frame f = can_frame_sdo(n->id, &request);
    struct can_queue q = {0};
    struct can_sdo reply = {0};
    can_node_receive(n, &f, 1, &q);
    assert_int_equal(q.count, 1);
    assert_true(can_parse_sdo_reply(&q.frame[0], &reply));
    return reply.kind == SDO_ABORT ? reply.value : 0;
}

static void sdo_cannot_move_a_valve_nor_break_the_mapping(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    assert_int_equal(write_object(&w.node[0], 0x6300, 1, 2, 20000), SDO_DENIED);
    /* refused because the PDO is valid */
    assert_int_equal(write_object(&w.node[0], 0x1600, 1, 4, MAP_DUMMY), SDO_DENIED);
    assert_int_equal(write_object(&w.node[0], 0x1400, 5, 4, 20), SDO_SIZE);
    assert_int_equal(write_object(&w.node[0], 0x1000, 0, 4, 1), SDO_READ_ONLY);
    assert_int_equal(write_object(&w.node[0], 0x2f00, 0, 4, 1), SDO_NO_OBJECT);
    assert_int_equal(write_object(&w.node[0], 0x1018, 9, 4, 1), SDO_NO_SUB);
    assert_int_equal(can_node_output(&w.node[0]), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tpdo_comes_back_as_it_was),
        cmocka_unit_test(sdo_frames_are_the_standards),
        cmocka_unit_test(no_frame_upsets_nodes_or_master),
        cmocka_unit_test(frame_bits_are_the_worst_that_stuffing_can_do),
        cmocka_unit_test(bus_load_at_a_megabit_and_two_milliseconds_is_sixty_three_percent_or_less),
        cmocka_unit_test(channel_turns_milliamperes_into_metres_and_refuses_a_broken_wire),
        cmocka_unit_test(all_nodes_are_set_up_and_started),
        cmocka_unit_test(every_command_reaches_its_own_leg_with_the_sync),
        cmocka_unit_test(the_sample_is_what_was_latched_at_the_sync_before),
        cmocka_unit_test(a_lost_tpdo_makes_the_sample_stale_and_the_next_one_says_so),
        cmocka_unit_test(a_tpdo_a_cycle_late_is_of_its_own_sync_or_left_out_whatever_is_commanded),
        cmocka_unit_test(a_leg_that_becomes_late_for_good_is_never_taken_for_punctual),
        cmocka_unit_test(the_command_that_centres_waits_for_no_tpdo),
        cmocka_unit_test(without_commands_a_node_centres_its_valve_and_takes_no_late_one),
        cmocka_unit_test(a_silent_bus_is_set_up_again_when_it_speaks),
        cmocka_unit_test(without_the_daemons_heartbeat_the_valves_are_centred),
        cmocka_unit_test(a_lost_node_invalidates_samples_and_commands),
        cmocka_unit_test(a_node_that_was_reset_is_set_up_again_and_meanwhile_nothing_is_valid),
        cmocka_unit_test(a_lost_node_that_keeps_silent_is_asked_and_set_up_again),
        cmocka_unit_test(a_pressure_that_is_missing_is_no_number_and_the_sample_is_good_for_the_rest),
        cmocka_unit_test(an_emergency_invalidates_the_sample_until_it_is_over),
        cmocka_unit_test(a_missing_reading_hides_no_other_error_of_its_node),
        cmocka_unit_test(one_error_that_is_over_is_not_all_of_them),
        cmocka_unit_test(bus_off_lets_no_command_through_until_the_bus_is_restarted),
        cmocka_unit_test(error_passive_is_told_but_moves_on),
        cmocka_unit_test(a_sync_that_the_bus_does_not_carry_yields_no_new_sample),
        cmocka_unit_test(a_node_with_another_mapping_is_not_started),
        cmocka_unit_test(a_node_that_answers_otherwise_is_not_started_whatever_it_is),
        cmocka_unit_test(a_node_of_another_vendor_runs_when_it_is_configured),
        cmocka_unit_test(inputs_are_what_was_latched_at_the_sync_before),
        cmocka_unit_test(an_input_is_closed_where_both_of_its_contacts_say_so_and_told_where_they_contradict),
        cmocka_unit_test(what_opens_or_contradicts_does_not_wait_for_the_sample_to_be_whole),
        cmocka_unit_test(what_contradicts_does_so_until_its_module_says_otherwise),
        cmocka_unit_test(two_answers_of_a_leg_in_one_cycle_are_no_length_and_name_it),
        cmocka_unit_test(an_input_is_open_if_any_answer_says_so),
        cmocka_unit_test(a_twin_that_says_the_same_is_found_within_a_tenth_of_a_second),
        cmocka_unit_test(a_bus_that_repeats_every_fifth_frame_is_no_twin),
        cmocka_unit_test(one_frame_that_comes_twice_is_ridden_out),
        cmocka_unit_test(a_twins_heartbeats_are_too_many_and_a_nodes_own_are_not),
        cmocka_unit_test(a_twin_that_answers_the_set_up_is_found_in_it),
        cmocka_unit_test(frames_of_another_length_are_no_sign_of_life_and_are_judged),
        cmocka_unit_test(without_node_7_nothing_is_closed_and_no_sample_is_whole),
        cmocka_unit_test(an_io_module_that_boots_closes_nothing_until_it_is_set_up),
        cmocka_unit_test(the_supply_output_changes_with_every_command_and_not_without),
        cmocka_unit_test(the_supply_output_changes_where_every_second_cycle_waits),
        cmocka_unit_test(a_change_that_waits_is_not_made_up_for_by_safe),
        cmocka_unit_test(what_is_not_enabled_is_the_centre),
        cmocka_unit_test(without_its_rpdo_or_the_heartbeat_the_supply_output_is_off),
        cmocka_unit_test(an_io_module_that_answers_otherwise_is_not_started_whatever_it_is),
        cmocka_unit_test(an_io_module_of_another_vendor_runs_when_it_is_configured),
        cmocka_unit_test(where_nothing_is_wired_there_are_six_nodes_and_no_frame_for_a_seventh),
        cmocka_unit_test(all_nodes_lost_are_told_as_all_and_one_as_one),
        cmocka_unit_test(an_abort_is_told_as_what_it_is),
        cmocka_unit_test(a_node_without_ownership_is_driven_all_the_same),
        cmocka_unit_test(a_lost_node_that_is_still_operational_is_halted_and_set_up),
        cmocka_unit_test(another_masters_first_frame_flags_the_next_sample),
        cmocka_unit_test(a_node_of_another_master_is_left_alone_until_that_one_is_gone),
        cmocka_unit_test(a_master_that_leaves_centres_the_valves_and_gives_the_nodes_free),
        cmocka_unit_test(no_cycle_sends_more_than_ten_frames),
        cmocka_unit_test(sdo_cannot_move_a_valve_nor_break_the_mapping),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
