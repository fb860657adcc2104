#include "can_master.h"

#include <linux/can/error.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "channel.h"
#include "units.h"

enum { REPLY_MS = 50, START_MS = 200, ASK_MS = 500, TRIES = 3, MISSED_HEARTBEATS = 3, NS_PER_MS = 1000000 };
#define PDO_OFF 0x80000000u

static uint32_t ms(double seconds) { return (uint32_t)lround(seconds * 1000.0); }

/* Step of the set-up of node 1..6; false past the last. An upload's value is what must come back: a node whose TPDO is mapped otherwise
 * would be misread without a word. */
static bool setup_step(const struct params *p, int node, int step, struct can_sdo *sdo) {
    unsigned rpdo = can_rpdo_cob(can_group(node)), tpdo = COB_TPDO + (unsigned)node;
    uint32_t heartbeat = ms(p->can.heartbeat_s), place = (uint32_t)can_place(node);
    const struct can_sdo steps[] = {
        {SDO_UPLOAD, 0x1a00, 1, 4, MAP_POSITION},
        {SDO_UPLOAD, 0x1a00, 2, 4, MAP_P1},
        {SDO_UPLOAD, 0x1a00, 3, 4, MAP_P2},
        {SDO_DOWNLOAD, 0x1400, 1, 4, PDO_OFF | rpdo},
        {SDO_DOWNLOAD, 0x1600, 0, 1, 0},
        {SDO_DOWNLOAD, 0x1600, 1, 4, place == 0 ? MAP_VALVE : MAP_DUMMY},
        {SDO_DOWNLOAD, 0x1600, 2, 4, place == 1 ? MAP_VALVE : MAP_DUMMY},
        {SDO_DOWNLOAD, 0x1600, 3, 4, place == 2 ? MAP_VALVE : MAP_DUMMY},
        {SDO_DOWNLOAD, 0x1600, 0, 1, CAN_GROUP_NODES},
        {SDO_DOWNLOAD, 0x1400, 2, 1, 1}, /* in force with the next SYNC */
        {SDO_DOWNLOAD, 0x1400, 5, 2, ms(p->device.watchdog_s)},
        {SDO_DOWNLOAD, 0x1400, 1, 4, rpdo},
        {SDO_DOWNLOAD, 0x1800, 1, 4, PDO_OFF | tpdo},
        {SDO_DOWNLOAD, 0x1800, 2, 1, 1}, /* with every SYNC */
        {SDO_DOWNLOAD, 0x1800, 1, 4, tpdo},
        {SDO_DOWNLOAD, 0x1016, 1, 4, (uint32_t)CAN_MASTER << 16 | MISSED_HEARTBEATS * heartbeat},
        {SDO_DOWNLOAD, 0x1017, 0, 2, heartbeat},
    };
    if (step >= (int)(sizeof steps / sizeof *steps)) return false;
    *sdo = steps[step];
    return true;
}

void can_master_init(struct can_master *m, const struct params *params) {
    memset(m, 0, sizeof *m);
    m->params = params;
}

static void set_up(struct can_peer *p) {
    p->phase = CAN_SETUP;
    p->step = p->tries = 0;
    p->deadline_ns = 0;
    p->emcy = EMCY_NONE;
}

static void heartbeat(struct can_master *m, struct can_peer *p, enum can_state state) {
    if (state == CAN_BOOTUP) {
        m->boots++;
        set_up(p);
    } else if (p->phase == CAN_LOST || (p->phase == CAN_RUNNING && state != CAN_OPERATIONAL)) {
        set_up(p);
    } else if (p->phase == CAN_STARTING && state == CAN_OPERATIONAL) {
        p->phase = CAN_RUNNING;
    }
}

/* A node that lost the daemon has left operational: set up at once, not with its next heartbeat. */
static void emergency(struct can_peer *p, const struct can_frame *f) {
    uint16_t code;
    uint8_t error_register;
    if (!can_parse_emcy(f, &code, &error_register)) return;
    if (code == EMCY_HEARTBEAT || code == EMCY_RPDO_TIMEOUT) set_up(p);
    p->emcy = code;
}

/* The answer to the request of this step: on to the next. Any other answer is left to the time-out. */
static void sdo_reply(struct can_master *m, struct can_peer *p, int node, const struct can_sdo *reply) {
    struct can_sdo asked;
    if (p->phase == CAN_LOST) set_up(p);
    if (p->phase != CAN_SETUP || !setup_step(m->params, node, p->step, &asked)) return;
    if (reply->kind != asked.kind || reply->index != asked.index || reply->sub != asked.sub) return;
    if (asked.kind == SDO_UPLOAD && (reply->size != asked.size || reply->value != asked.value)) return;
    p->step++;
    p->tries = 0;
    p->deadline_ns = 0;
}

static void error_frame(struct can_master *m, const struct can_frame *f) {
    m->errors++;
    if (f->can_id & CAN_ERR_BUSOFF) m->bus = CAN_BUS_OFF;
    else if (f->can_id & CAN_ERR_RESTARTED) m->bus = CAN_BUS_GOOD;
    else if (f->can_id & CAN_ERR_CRTL && m->bus != CAN_BUS_OFF && f->data[1])
        m->bus = f->data[1] & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE) ? CAN_BUS_PASSIVE : CAN_BUS_GOOD;
}

static bool whole(const struct can_master *m) {
    for (int i = 0; i < CAN_NODES; i++)
        if (!m->peer[i].fresh) return false;
    return true;
}

/* A TPDO of this window is missing: lost, or late. */
static void miss(struct can_master *m) {
    if (m->pause != CAN_NO_PAUSE) return;
    m->lost += can_master_ready(m);
    m->pause = CAN_PAUSE_DUE;
}

static void echo(struct can_master *m, int64_t time_ns) {
    if (m->syncs && !whole(m)) {
        miss(m);
        m->doubt = true;
    } else if (m->pause == CAN_PAUSED) {
        m->doubt &= !m->punctual;
    }
    m->pause = m->doubt ? CAN_PAUSE_DUE : CAN_NO_PAUSE;
    m->unechoed = 0;
    m->syncs++;
    m->gap_ns = time_ns - m->sync_ns;
    m->sync_ns = time_ns;
    if (m->bus == CAN_BUS_OFF) m->bus = CAN_BUS_GOOD;
    for (int i = 0; i < CAN_NODES; i++) m->peer[i].fresh = false;
}

static void tpdo(struct can_master *m, struct can_peer *p, const struct can_frame *f) {
    struct can_tpdo value;
    if (!m->syncs || !can_parse_tpdo(f, &value)) {
        m->stray++;
        return;
    }
    m->twice += p->fresh;
    p->fresh = true;
    p->tpdo = value;
}

void can_master_receive(struct can_master *m, const struct can_frame *f, int64_t time_ns) {
    static const unsigned functions[] = {COB_TPDO, COB_HEARTBEAT, COB_EMCY, COB_SDO_REPLY};
    if (f->can_id & CAN_ERR_FLAG) {
        error_frame(m, f);
        return;
    }
    if (f->can_id == COB_SYNC) {
        echo(m, time_ns);
        return;
    }
    for (unsigned i = 0; i < sizeof functions / sizeof *functions; i++) {
        int node = can_frame_node(f, functions[i]);
        if (node < 1 || node > CAN_NODES) continue;
        struct can_peer *p = &m->peer[node - 1];
        enum can_state state;
        struct can_sdo reply;
        p->heard_ns = time_ns;
        if (functions[i] == COB_TPDO) tpdo(m, p, f);
        else if (functions[i] == COB_HEARTBEAT && can_parse_heartbeat(f, &state)) heartbeat(m, p, state);
        else if (functions[i] == COB_EMCY) emergency(p, f);
        else if (functions[i] == COB_SDO_REPLY && can_parse_sdo_reply(f, &reply)) sdo_reply(m, p, node, &reply);
    }
}

/* Sends the step's request, or again after the time-out; past the last step the node is started. */
static void drive_setup(struct can_master *m, struct can_peer *p, int node, int64_t now_ns, struct can_queue *out) {
    struct can_sdo request;
    if (now_ns < p->deadline_ns) return;
    if (p->tries++ >= TRIES) {
        p->phase = CAN_LOST;
        return;
    }
    if (setup_step(m->params, node, p->step, &request)) {
        can_queue_push(out, can_frame_sdo(node, &request));
        p->deadline_ns = now_ns + (int64_t)REPLY_MS * NS_PER_MS;
        return;
    }
    can_queue_push(out, can_frame_nmt(NMT_START, node));
    p->phase = CAN_STARTING;
    p->deadline_ns = now_ns + (int64_t)START_MS * NS_PER_MS;
}

/* A node that has booted unheard says nothing by itself: its heartbeat is off until it is set up. Whatever it answers will do. */
static void ask(struct can_master *m, struct can_peer *p, int node, int64_t now_ns, struct can_queue *out) {
    struct can_sdo request;
    if (now_ns < p->deadline_ns || !setup_step(m->params, node, 0, &request)) return;
    can_queue_push(out, can_frame_sdo(node, &request));
    p->deadline_ns = now_ns + (int64_t)ASK_MS * NS_PER_MS;
}

static void supervise(struct can_master *m, struct can_peer *p, int node, int64_t now_ns, struct can_queue *out) {
    int64_t silence_ns = MISSED_HEARTBEATS * ns_from_seconds(m->params->can.heartbeat_s);
    if (p->phase == CAN_LOST) ask(m, p, node, now_ns, out);
    else if (p->phase == CAN_SETUP) drive_setup(m, p, node, now_ns, out);
    else if (p->phase == CAN_STARTING && now_ns >= p->deadline_ns) set_up(p);
    else if (p->phase == CAN_RUNNING && now_ns - p->heard_ns > silence_ns) p->phase = CAN_LOST;
}

void can_master_poll(struct can_master *m, int64_t now_ns, bool alive, struct can_queue *out) {
    for (int i = 0; i < CAN_NODES; i++) supervise(m, &m->peer[i], i + 1, now_ns, out);
    if (!alive || now_ns < m->heartbeat_due_ns) return;
    can_queue_push(out, can_frame_heartbeat(CAN_MASTER, CAN_OPERATIONAL));
    m->heartbeat_due_ns = now_ns + ns_from_seconds(m->params->can.heartbeat_s);
}

bool can_master_ready(const struct can_master *m) {
    for (int i = 0; i < CAN_NODES; i++)
        if (m->peer[i].phase != CAN_RUNNING) return false;
    return m->bus != CAN_BUS_OFF;
}

void can_master_command(struct can_master *m, const double valve[LEGS], struct can_queue *out) {
    int16_t raw[CAN_NODES];
    bool centre = true;
    for (int i = 0; i < LEGS; i++) centre &= valve[i] == 0.0;
    /* SAFETY: the command that centres the valves waits for nothing; then the pause is due in the cycle after it. */
    if (m->pause == CAN_PAUSE_DUE && !(centre && !m->centred)) {
        m->pause = CAN_PAUSED;
        m->punctual = whole(m);
        return;
    }
    m->centred = centre;
    for (int i = 0; i < LEGS; i++) raw[i] = (int16_t)channel_raw(&m->params->valve_channel, i, valve[i], INT16_MAX);
    for (int group = 0; group < CAN_GROUPS; group++) can_queue_push(out, can_frame_rpdo(group, raw + CAN_GROUP_NODES * group));
    can_queue_push(out, can_frame_sync()); /* last: it puts the two into force */
    m->unechoed++;
}

/* Takes the window's sample over when it is whole. */
static void latch(struct can_master *m) {
    if (m->syncs == m->latched_sync) return;
    if (!whole(m)) miss(m);
    if (!whole(m) || m->pause == CAN_PAUSE_DUE) return;
    for (int i = 0; i < CAN_NODES; i++) m->latched[i] = m->peer[i].tpdo;
    m->latched_sync = m->syncs;
    m->latched_ns = m->sync_ns;
    m->latched_gap_ns = m->gap_ns;
    m->delivered = false;
}

static void convert(const struct can_master *m, struct hal_sample *s) {
    const struct params *p = m->params;
    for (int i = 0; i < LEGS; i++) {
        const struct can_tpdo *t = &m->latched[i];
        s->length_m[i] = channel_si(&p->length_channel, i, channel_from_32(t->position));
        s->p1_pa[i] = channel_si(&p->p1_channel, i, channel_from_16(t->p1));
        s->p2_pa[i] = channel_si(&p->p2_channel, i, channel_from_16(t->p2));
        if (isnan(s->length_m[i]) || isnan(s->p1_pa[i]) || isnan(s->p2_pa[i])) s->flags |= SAMPLE_INVALID;
        if (m->peer[i].phase != CAN_RUNNING || m->peer[i].emcy) s->flags |= SAMPLE_INVALID;
    }
}

void can_master_sample(struct can_master *m, struct hal_sample *s) {
    uint64_t before = m->latched_sync;
    latch(m);
    *s = (struct hal_sample){.time_ns = m->latched_ns, .device_seq = m->latched_sync};
    if (m->delivered) s->flags |= SAMPLE_STALE;
    else if (before && m->latched_sync != before + 1) s->flags |= SAMPLE_DROPPED;
    /* SAFETY: half a period off the grid: a SYNC was lost or late, and the command before it was held too long or too short. */
    int64_t period_ns = ns_from_seconds(m->params->loop.period_s);
    if (2 * llabs(m->latched_gap_ns - period_ns) > period_ns) s->flags |= SAMPLE_LATE;
    if (!m->latched_sync || m->bus == CAN_BUS_OFF) s->flags |= SAMPLE_INVALID;
    convert(m, s);
    m->delivered = true;
}

enum { CONDITION_NODES = 2, CONDITION_NODE_BITS = 3, CONDITION_EMCY = CONDITION_NODES + CAN_NODES * CONDITION_NODE_BITS };

uint64_t can_master_condition(const struct can_master *m) {
    uint64_t word = (uint64_t)m->bus;
    for (int i = CAN_NODES - 1; i >= 0; i--) {
        const struct can_peer *p = &m->peer[i];
        word |= (uint64_t)(CAN_RUNNING - p->phase) << (CONDITION_NODES + i * CONDITION_NODE_BITS);
        if (!p->emcy) continue;
        word |= 4ull << (CONDITION_NODES + i * CONDITION_NODE_BITS);
        word = (word & ~(0xffffull << CONDITION_EMCY)) | (uint64_t)p->emcy << CONDITION_EMCY;
    }
    return word;
}

/* "node 3 lost, EMCY 0x8250" at text, after a comma; returns its length. */
static size_t describe_node(const char *who, unsigned node, unsigned code, char *text, size_t size) {
    static const char *const phases[] = {[CAN_LOST] = " lost", [CAN_SETUP] = " being set up", [CAN_STARTING] = " starting",
                                         [CAN_RUNNING] = ""};
    char emcy[20] = "";
    if (node & 4) snprintf(emcy, sizeof emcy, code ? " EMCY 0x%04x" : " EMCY", code);
    return (size_t)snprintf(text, size, ", %s%s%s", who, phases[CAN_RUNNING - (node & 3)], emcy);
}

void can_condition_describe(uint64_t word, char *text, size_t size) {
    static const char *const buses[] = {[CAN_BUS_GOOD] = "", [CAN_BUS_PASSIVE] = ", bus error-passive", [CAN_BUS_OFF] = ", bus-off"};
    const unsigned all = 0111111; /* the same in every node's bits */
    unsigned code = word >> CONDITION_EMCY & 0xffff, nodes = word >> CONDITION_NODES & 0777777;
    size_t used = (size_t)snprintf(text, size, "%s", buses[(word & 3) % 3]);
    if (nodes && nodes == (nodes & 7) * all) used += describe_node("all nodes", nodes & 7, code, text + used, size - used), nodes = 0;
    for (int i = 1; nodes && used < size; i++, nodes >>= CONDITION_NODE_BITS) {
        char who[20];
        snprintf(who, sizeof who, "node %d", i);
        if (nodes & 7) used += describe_node(who, nodes & 7, code, text + used, size - used);
        if (nodes & 4) code = 0; /* it is the first such node's */
    }
    if (used) memmove(text, text + 2, strlen(text + 2) + 1); /* the comma in front */
}
