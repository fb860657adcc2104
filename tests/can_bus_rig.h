/* The seven nodes and their master on a bus in memory, so that failures can be tested without a
 * socket or a clock. */
#ifndef HEXID_TESTS_CAN_BUS_RIG_H
#define HEXID_TESTS_CAN_BUS_RIG_H

#include "support.h"

#include "can_master.h"
#include "can_node.h"
#include "config.h"
#include "units.h"

enum { TOKEN = 0x600dcafe, CYCLES_TO_RUN = 200, LATE_NODE = 2, LATE_MAX = 8 };

/* Disturbances of the bus that a test sets. */
struct wire {
    int lose_tpdo_of;     /* node, 0 none */
    int late_by;          /* cycles of delay of LATE_NODE's TPDOs */
    bool lose_rpdo, lose_outputs, lose_heartbeat, lose_echo;
    int dead_node;        /* number of a node that neither receives nor sends, 0: none */
    int twin_of;          /* number of a node that has a twin: a second device that repeats its
                           * frames; 0: none */
    struct can_tpdo twin_adds; /* offsets of the twin's readings (inputs: replaced) */
    int twin_percent;     /* percentage of frames that the twin repeats */
    bool twin_is_short;   /* the twin's frames are a byte shorter */
    int lying_node;       /* node that answers with `lie` when that object is asked for, 0: none */
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

/* Delays a TPDO of LATE_NODE by wire.late_by cycles; if the bus has a SYNC in the cycle of its
 * arrival, the TPDO arrives after it. */
static inline bool put_off(struct world *w, const struct can_frame *f) {
    struct late *l = &w->late[w->late_count];
    if (can_frame_node(f, COB_TPDO) != LATE_NODE || (w->wire.late_by == 0 && w->late_count == 0)) return false;
    assert_true(w->late_count < LATE_MAX);
    *l = (struct late){.frame = *f, .due_ns = w->now_ns + w->wire.late_by * ns_from_seconds(w->params.loop.period_s)};
    /* frames keep their order */
    if (w->late_count && l->due_ns < l[-1].due_ns) l->due_ns = l[-1].due_ns;
    w->late_count++;
    return true;
}

static inline void hand_in(struct world *w) {
    int kept = 0;
    for (int i = 0; i < w->late_count; i++) {
        if (w->late[i].due_ns <= w->now_ns) can_master_receive(&w->master, &w->late[i].frame, false, w->now_ns);
        else w->late[kept++] = w->late[i];
    }
    w->late_count = kept;
}

static inline void lie(const struct world *w, struct can_frame *f) {
    struct can_sdo reply;
    const struct can_sdo *l = &w->wire.lie;
    if (!w->wire.lying_node || can_frame_node(f, COB_SDO_REPLY) != w->wire.lying_node || !can_parse_sdo_reply(f, &reply)) return;
    if (reply.index == l->index && reply.sub == l->sub && (reply.kind == l->kind || l->kind == SDO_ABORT))
        *f = can_frame_sdo_reply(w->wire.lying_node, l);
}

/* Sends the twin's copy of a frame to the master. */
static inline void answer_again(struct world *w, const struct can_frame *f) {
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

static inline void to_master(struct world *w, struct can_queue *q) {
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

static inline void to_nodes(struct world *w, struct can_queue *q) {
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

static inline struct hal_command commands(struct world *w, const double valve[LEGS]) {
    struct hal_command c = {.enable = true, .supply = w->supply ^= !w->hangs};
    memcpy(c.valve, valve, sizeof c.valve);
    return c;
}

/* Runs one cycle of the loop: sample, then command. */
static inline struct hal_sample cycle(struct world *w, const double valve[LEGS]) {
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
    /* hal/can.c flags late samples in the same way */
    if (2 * s.age_ns > 3 * ns_from_seconds(w->params.loop.period_s)) s.flags |= SAMPLE_LATE;
    struct hal_command command = commands(w, valve);
    can_master_command(&w->master, &command, &q);
    to_nodes(w, &q);
    hand_in(w);
    return s;
}

static const double centre[LEGS] = {0}, some[LEGS] = {0.1, -0.2, 0.3, -0.4, 0.5, -1.0};

static inline struct hal_sample cycles(struct world *w, int count, const double valve[LEGS]) {
    struct hal_sample s = {0};
    for (int i = 0; i < count; i++) s = cycle(w, valve);
    return s;
}

static inline void power_on_with(struct world *w, const struct params *params) {
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

static inline void power_on(struct world *w) {
    struct params params;
    config_default(&params);
    power_on_with(w, &params);
}

static inline void bring_up(struct world *w) {
    power_on(w);
    cycles(w, CYCLES_TO_RUN, centre);
    assert_true(can_master_ready(&w->master));
}

static inline struct params not_wired(void) {
    struct params p;
    config_default(&p);
    p.interlocks = (struct interlock_params){0};
    return p;
}

static inline const char *condition(const struct world *w, char text[200]) {
    can_condition_describe(can_master_condition(&w->master), &w->params, text, 200);
    return text;
}

static inline bool supply(const struct world *w) { return can_node_output(&w->node[CAN_IO - 1]) & OUTPUT_SUPPLY; }

#endif
