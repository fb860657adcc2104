#include "can_master.h"

#include <linux/can/error.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "channel.h"
#include "interlock.h"
#include "params.h"
#include "units.h"

enum { REPLY_MS = 50, START_MS = 200, ASK_MS = 500, TRIES = 3, MISSED_HEARTBEATS = 3 };
/* REQUESTS: most set-up frames in a cycle. With a heartbeat, three RPDOs and SYNC they are ten
 * frames, the default length of a CAN interface's transmit queue. */
enum { REQUESTS = 5 };
/* Leaky buckets that reveal a second device with a node's number. TWICE counts windows: a window
 * with a repeated TPDO adds two, a window without one subtracts one. A bus that repeats every
 * fourth frame does not fill this bucket; a second device fills it in 50 windows. ODD counts excess
 * frames: a heartbeat adds 0.75, any other frame that a single device would not send adds 1, and
 * one is drained in each heartbeat period, so that the heartbeats of one device never fill it. */
enum { TWICE_STEP = 2, TWICE_MAX = 100, ODD_MAX = 6 };
static const double odd_heartbeat = 0.75, odd_frame = 1.0;
#define PDO_OFF 0x80000000u

static uint32_t ms(double seconds) { return (uint32_t)lround(seconds * 1000.0); }

enum { AXIS = 1, IO = 2, EVERY = AXIS | IO };

/* One request of the set-up. If an upload returns another value than `value`, the node is another
 * device, has another mapping, or has not stored what was written; it is then not driven. */
struct step {
    unsigned of;
    enum can_sdo_kind kind;
    uint16_t index;
    uint8_t sub;
    int size;
    uint32_t value;
    bool any; /* an upload may return any value */
};

double can_identity(const struct params *params, int node, uint16_t index, uint8_t sub, const char **key) {
    const struct can_params *c = &params->can;
    const struct {
        uint16_t index;
        uint8_t sub;
        const char *key[2];
        double value[2];
    } objects[] = {
        {0x1000, 0, {"device_type", "io_device_type"}, {c->device_type, c->io_device_type}},
        {0x1018, 1, {"vendor_id", "io_vendor_id"}, {c->vendor_id, c->io_vendor_id}},
        {0x1018, 2, {"product_code", "io_product_code"}, {c->product_code, c->io_product_code}},
    };
    int kind = node == CAN_IO;
    *key = NULL;
    for (unsigned i = 0; i < sizeof objects / sizeof *objects; i++) {
        if (objects[i].index != index || objects[i].sub != sub) continue;
        *key = objects[i].key[kind];
        return objects[i].value[kind];
    }
    return -1.0;
}

static struct step identity(const struct can_master *m, int node, uint16_t index, uint8_t sub) {
    const char *key;
    double configured = can_identity(m->params, node, index, sub, &key);
    bool any = configured < 0;
    return (struct step){EVERY, SDO_UPLOAD, index, sub, 4, any ? 0 : (uint32_t)llround(configured), any};
}

static uint32_t map_entry(int node, int place) { return can_place(node) == place ? MAP_VALVE : MAP_DUMMY; }

/* Returns step `number` of a node's set-up in *step; false if there are no more steps. */
static bool setup_step(const struct can_master *m, int node, int number, struct step *step) {
    const struct params *p = m->params;
    unsigned rpdo = can_rpdo_cob(can_group(node)), tpdo = COB_TPDO + (unsigned)node;
    uint32_t beat_ms = ms(p->can.heartbeat_s), watchdog_ms = ms(p->device.watchdog_s);
    uint32_t consumer = (uint32_t)CAN_MASTER << 16 | MISSED_HEARTBEATS * beat_ms;
    const struct step steps[] = {
        identity(m, node, 0x1000, 0),
        identity(m, node, 0x1018, 1),
        identity(m, node, 0x1018, 2),
        {EVERY, SDO_DOWNLOAD, 0x2000, 1, 4, m->token, false},
        {EVERY, SDO_DOWNLOAD, 0x1016, 1, 4, consumer, false},
        {EVERY, SDO_DOWNLOAD, 0x1017, 0, 2, beat_ms, false},
        {EVERY, SDO_DOWNLOAD, 0x1005, 0, 4, COB_SYNC, false},
        {EVERY, SDO_DOWNLOAD, 0x1400, 1, 4, PDO_OFF | rpdo, false},
        {AXIS, SDO_DOWNLOAD, 0x1600, 0, 1, 0, false},
        {AXIS, SDO_DOWNLOAD, 0x1600, 1, 4, map_entry(node, 0), false},
        {AXIS, SDO_DOWNLOAD, 0x1600, 2, 4, map_entry(node, 1), false},
        {AXIS, SDO_DOWNLOAD, 0x1600, 3, 4, map_entry(node, 2), false},
        {AXIS, SDO_DOWNLOAD, 0x1600, 0, 1, CAN_GROUP_NODES, false},
        {EVERY, SDO_DOWNLOAD, 0x1400, 2, 1, 1, false}, /* commands come into force with the next
                                                        * SYNC */
        {EVERY, SDO_DOWNLOAD, 0x1400, 5, 2, watchdog_ms, false},
        {EVERY, SDO_DOWNLOAD, 0x1400, 1, 4, rpdo, false},
        {EVERY, SDO_DOWNLOAD, 0x1800, 1, 4, PDO_OFF | tpdo, false},
        {EVERY, SDO_DOWNLOAD, 0x1800, 2, 1, 1, false}, /* TPDOs are sent with every SYNC */
        {EVERY, SDO_DOWNLOAD, 0x1800, 1, 4, tpdo, false},
        /* SAFETY: written watchdogs are read back, because a node may not have stored them. */
        {EVERY, SDO_UPLOAD, 0x1016, 1, 4, consumer, false},
        {EVERY, SDO_UPLOAD, 0x1017, 0, 2, beat_ms, false},
        {EVERY, SDO_UPLOAD, 0x1029, 1, 1, 0, false}, /* the node goes to pre-operational on a
                                                      * communication error */
        {EVERY, SDO_UPLOAD, 0x1005, 0, 4, COB_SYNC, false},
        {EVERY, SDO_UPLOAD, 0x1400, 1, 4, rpdo, false},
        {EVERY, SDO_UPLOAD, 0x1400, 2, 1, 1, false},
        {EVERY, SDO_UPLOAD, 0x1400, 5, 2, watchdog_ms, false},
        {AXIS, SDO_UPLOAD, 0x1600, 0, 1, CAN_GROUP_NODES, false},
        {AXIS, SDO_UPLOAD, 0x1600, 1, 4, map_entry(node, 0), false},
        {AXIS, SDO_UPLOAD, 0x1600, 2, 4, map_entry(node, 1), false},
        {AXIS, SDO_UPLOAD, 0x1600, 3, 4, map_entry(node, 2), false},
        {EVERY, SDO_UPLOAD, 0x1800, 1, 4, tpdo, false},
        {EVERY, SDO_UPLOAD, 0x1800, 2, 1, 1, false},
        {AXIS, SDO_UPLOAD, 0x1a00, 0, 1, 3, false},
        {AXIS, SDO_UPLOAD, 0x1a00, 1, 4, MAP_POSITION, false},
        {AXIS, SDO_UPLOAD, 0x1a00, 2, 4, MAP_P1, false},
        {AXIS, SDO_UPLOAD, 0x1a00, 3, 4, MAP_P2, false},
        {IO, SDO_UPLOAD, 0x1600, 0, 1, 1, false},
        {IO, SDO_UPLOAD, 0x1600, 1, 4, MAP_OUTPUTS, false},
        {IO, SDO_UPLOAD, 0x1a00, 0, 1, 1, false},
        {IO, SDO_UPLOAD, 0x1a00, 1, 4, MAP_INPUTS, false},
        /* SAFETY: on a communication error the outputs go to 0. */
        {IO, SDO_UPLOAD, 0x6206, 1, 1, 0xff, false},
        {IO, SDO_UPLOAD, 0x6207, 1, 1, 0, false},
        {EVERY, SDO_DOWNLOAD, 0x2000, 1, 4, m->token, false}, /* the claim again; it fails if the
                                                               * node has another owner by now */
    };
    unsigned kind = node == CAN_IO ? IO : AXIS;
    for (unsigned i = 0; i < sizeof steps / sizeof *steps; i++) {
        if (!(steps[i].of & kind) || number-- > 0) continue;
        *step = steps[i];
        return true;
    }
    return false;
}

/* Sends the request of a set-up step. Answers to earlier tries may come late, so up to TRIES
 * answers may still be expected. */
static void request(struct can_peer *p, const struct step *s, int node, struct can_queue *out) {
    can_queue_push(out, can_frame_sdo(node, &(struct can_sdo){s->kind, s->index, s->sub, s->size, s->value}));
    if (p->asked < TRIES) p->asked++;
}

void can_master_init(struct can_master *m, const struct params *params, uint32_t token) {
    memset(m, 0, sizeof *m);
    m->params = params;
    m->nodes = can_nodes(params);
    m->token = token;
    m->closed = INPUTS_ALL;
}

static int64_t beats_ns(const struct can_master *m, double beats) { return ns_from_seconds(beats * m->params->can.heartbeat_s); }

/* Adds a heartbeat, or another frame that a single device would not send, to the node's leaky
 * bucket of excess frames. beats: amount added, in heartbeat periods. */
static void odd(const struct can_master *m, struct can_peer *p, double beats, int64_t time_ns) {
    int64_t most_ns = time_ns + beats_ns(m, 2 * ODD_MAX);
    if (p->odd_ns < time_ns) p->odd_ns = time_ns;
    p->odd_ns += beats_ns(m, beats);
    if (p->odd_ns > most_ns) p->odd_ns = most_ns;
}

static bool is_twin(const struct can_master *m, const struct can_peer *p) {
    return p->twice >= TWICE_MAX || p->odd_ns - m->now_ns > beats_ns(m, ODD_MAX);
}

int can_master_twin(const struct can_master *m) {
    for (int i = 0; i < m->nodes; i++)
        if (is_twin(m, &m->peer[i])) return i + 1;
    return 0;
}

static void set_up(struct can_peer *p) {
    p->phase = CAN_SETUP;
    p->step = p->tries = 0;
    p->deadline_ns = 0;
    p->emcy = EMCY_NONE;
    p->halted = p->claimed = false;
    p->refusal = (struct can_refusal){0};
}

/* SAFETY: invalidates the node's readings, because they are older than its loss, refusal or
 * boot-up. */
static void forget(struct can_peer *p) { p->fresh = p->known = false; }

static void lose(struct can_peer *p) {
    p->phase = CAN_LOST;
    forget(p);
}

static void heartbeat(struct can_master *m, struct can_peer *p, enum can_state state, int64_t time_ns) {
    /* before its set-up a node may have any heartbeat rate, so its heartbeats are not counted */
    if (p->phase >= CAN_STARTING) odd(m, p, odd_heartbeat, time_ns);
    if (state == CAN_BOOTUP) {
        m->boots++;
        forget(p);
        set_up(p);
    } else if (p->phase == CAN_LOST || (p->phase == CAN_RUNNING && state != CAN_OPERATIONAL)) {
        set_up(p);
    } else if (p->phase == CAN_STARTING && state == CAN_OPERATIONAL) {
        p->phase = CAN_RUNNING;
    }
}

/* Handles an EMCY; returns false if the frame is malformed. A node that reports the loss of the
 * daemon has left operational, so it is set up now, not only after its next heartbeat. */
static bool emergency(struct can_peer *p, const struct can_frame *f) {
    uint16_t code;
    uint8_t error_register;
    if (!can_parse_emcy(f, &code, &error_register)) return false;
    if (code == EMCY_HEARTBEAT || code == EMCY_RPDO_TIMEOUT) set_up(p);
    /* SAFETY: an EMCY for a missing reading must not hide another active error */
    if (code == EMCY_SENSOR && p->emcy) return true;
    /* code 0 with a non-zero error register means that another error is still active, so its code
     * stays */
    if (code || !error_register) p->emcy = code;
    return true;
}

static void refuse(struct can_peer *p, enum can_refusal_kind kind, const struct can_sdo *reply, int64_t time_ns) {
    p->phase = CAN_REFUSED;
    forget(p);
    p->refusal = (struct can_refusal){kind, reply->index, reply->sub, reply->value};
    p->deadline_ns = time_ns + ASK_MS * NS_PER_MS;
}

static bool as_it_must_be(const struct step *asked, const struct can_sdo *reply) {
    return asked->any || ((reply->size == asked->size || reply->size == 0) && reply->value == asked->value);
}

/* Handles an SDO reply. A reply without a request counts as an excess frame. Any reply of a lost
 * node starts its set-up. During set-up the expected reply leads to the next step, an abort or an
 * unexpected value to a refusal; a reply for another object is ignored. */
static void sdo_reply(struct can_master *m, struct can_peer *p, int node, const struct can_sdo *reply, int64_t time_ns) {
    struct step asked;
    if (p->asked) p->asked--;
    else odd(m, p, odd_frame, time_ns);
    if (p->phase == CAN_LOST) set_up(p);
    if (p->phase != CAN_SETUP || p->tries == 0 || !setup_step(m, node, p->step, &asked)) return;
    if (reply->index != asked.index || reply->sub != asked.sub) return;
    bool claim = asked.index == 0x2000, ownerless = claim && reply->kind == SDO_ABORT && reply->value == SDO_NO_OBJECT;
    if (reply->kind == SDO_ABORT && !ownerless) {
        refuse(p, CAN_ABORTED, reply, time_ns);
        return;
    }
    if (reply->kind != asked.kind && !ownerless) return;
    if (asked.kind == SDO_UPLOAD && !as_it_must_be(&asked, reply)) {
        refuse(p, CAN_OTHERWISE, reply, time_ns);
        return;
    }
    p->claimed |= claim;
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
    for (int i = 0; i < m->nodes; i++)
        if (!m->peer[i].fresh) return false;
    return true;
}

static void miss(struct can_master *m) {
    if (m->pause != CAN_NO_PAUSE) return;
    m->lost += can_master_ready(m);
    m->pause = CAN_PAUSE_DUE;
}

static void close_window(struct can_peer *p) {
    p->twice += p->again ? TWICE_STEP : -(p->twice > 0);
    if (p->twice > TWICE_MAX) p->twice = TWICE_MAX;
    p->fresh = p->again = false;
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
    for (int i = 0; i < m->nodes; i++) close_window(&m->peer[i]);
}

static bool same(const struct can_tpdo *a, const struct can_tpdo *b) {
    return a->position == b->position && a->p1 == b->p1 && a->p2 == b->p2 && a->inputs == b->inputs;
}

/* SAFETY: handles a TPDO; returns false if its length is wrong. A TPDO of a wrong length, or one
 * that differs from an earlier TPDO of this window, comes from a second device or belongs to
 * another cycle. */
static bool tpdo(struct can_master *m, struct can_peer *p, const struct can_frame *f) {
    struct can_tpdo value;
    bool known = can_parse_tpdo(f, &value);
    if (!m->syncs || !known) {
        m->stray++;
        p->contradicts |= m->syncs != 0;
        return known;
    }
    m->twice += p->fresh;
    p->again |= p->fresh;
    p->contradicts |= p->fresh && !same(&value, &p->tpdo);
    p->fresh = true;
    p->tpdo = value;
    if (p == &m->peer[CAN_IO - 1]) m->closed &= interlock_read(&m->params->interlocks, value.inputs).closed;
    return true;
}

/* Handles a frame of this node. Returns false if it is malformed. */
static bool take(struct can_master *m, int node, unsigned function, const struct can_frame *f, int64_t time_ns) {
    struct can_peer *p = &m->peer[node - 1];
    enum can_state state;
    struct can_sdo reply;
    switch (function) {
    case COB_TPDO: return tpdo(m, p, f);
    case COB_EMCY: return emergency(p, f);
    case COB_HEARTBEAT:
        if (!can_parse_heartbeat(f, &state)) return false;
        heartbeat(m, p, state, time_ns);
        return true;
    default:
        if (!can_parse_sdo_reply(f, &reply)) return false;
        sdo_reply(m, p, node, &reply, time_ns);
        return true;
    }
}

void can_master_receive(struct can_master *m, const struct can_frame *f, bool own, int64_t time_ns) {
    static const unsigned functions[] = {COB_TPDO, COB_HEARTBEAT, COB_EMCY, COB_SDO_REPLY};
    if (f->can_id & CAN_ERR_FLAG) {
        error_frame(m, f);
        return;
    }
    if (can_frame_of_master(f)) {
        /* SAFETY: a frame that is not our own means that another master commands this machine */
        if (!own && !m->foreign) m->foreign = f->can_id | FOREIGN_HEARD;
        if (own && f->can_id == COB_SYNC) echo(m, time_ns);
        return;
    }
    for (unsigned i = 0; i < sizeof functions / sizeof *functions; i++) {
        int node = can_frame_node(f, functions[i]);
        if (node < 1 || node > m->nodes) continue;
        if (take(m, node, functions[i], f, time_ns)) m->peer[node - 1].heard_ns = time_ns;
        else odd(m, &m->peer[node - 1], odd_frame, time_ns);
    }
}

/* Sends the request of the current set-up step, or repeats it after the time-out. After the last
 * step, starts the node. SAFETY: before the first step the node is sent to pre-operational, where
 * its valve is centred. */
static void drive_setup(struct can_master *m, struct can_peer *p, int node, int64_t now_ns, struct can_queue *out) {
    struct step step;
    if (now_ns < p->deadline_ns || out->count >= REQUESTS) return;
    if (!p->halted) {
        can_queue_push(out, can_frame_nmt(NMT_PREOPERATIONAL, node));
        p->halted = true;
        return; /* each node gets at most one frame per cycle */
    }
    if (p->tries++ >= TRIES) {
        lose(p);
        return;
    }
    if (setup_step(m, node, p->step, &step)) {
        request(p, &step, node, out);
        p->deadline_ns = now_ns + REPLY_MS * NS_PER_MS;
        return;
    }
    can_queue_push(out, can_frame_nmt(NMT_START, node));
    p->phase = CAN_STARTING;
    p->deadline_ns = now_ns + START_MS * NS_PER_MS;
}

/* Sends a lost node a request, because any reply shows that the node is there. A node whose boot-up
 * was missed is silent otherwise: its heartbeat is off until its set-up. */
static void ask(struct can_master *m, struct can_peer *p, int node, int64_t now_ns, struct can_queue *out) {
    struct step step;
    if (now_ns < p->deadline_ns || out->count >= REQUESTS || !setup_step(m, node, 0, &step)) return;
    request(p, &step, node, out);
    p->deadline_ns = now_ns + ASK_MS * NS_PER_MS;
}

static void supervise(struct can_master *m, struct can_peer *p, int node, int64_t now_ns, struct can_queue *out) {
    int64_t silence_ns = MISSED_HEARTBEATS * ns_from_seconds(m->params->can.heartbeat_s);
    if (p->phase == CAN_REFUSED && now_ns >= p->deadline_ns) set_up(p);
    if (p->phase == CAN_LOST) ask(m, p, node, now_ns, out);
    else if (p->phase == CAN_SETUP) drive_setup(m, p, node, now_ns, out);
    else if (p->phase == CAN_STARTING && now_ns >= p->deadline_ns) set_up(p);
    else if (p->phase == CAN_RUNNING && now_ns - p->heard_ns > silence_ns) lose(p);
}

void can_master_poll(struct can_master *m, int64_t now_ns, bool alive, struct can_queue *out) {
    m->now_ns = now_ns;
    for (int i = 0; i < m->nodes; i++) supervise(m, &m->peer[i], i + 1, now_ns, out);
    if (!alive || now_ns < m->heartbeat_due_ns) return;
    can_queue_push(out, can_frame_heartbeat(CAN_MASTER, CAN_OPERATIONAL));
    m->heartbeat_due_ns = now_ns + ns_from_seconds(m->params->can.heartbeat_s);
}

bool can_master_ready(const struct can_master *m) {
    for (int i = 0; i < m->nodes; i++)
        if (m->peer[i].phase != CAN_RUNNING) return false;
    return m->bus != CAN_BUS_OFF;
}

void can_master_new_bus(struct can_master *m) {
    m->unechoed = 0;
    m->bus = CAN_BUS_GOOD;
}

bool can_master_claimed(const struct can_master *m) {
    for (int i = 0; i < m->nodes; i++)
        if (!m->peer[i].claimed) return false;
    return true;
}

bool can_master_misfit(const struct can_master *m) {
    for (int i = 0; i < m->nodes; i++)
        if (m->peer[i].phase == CAN_REFUSED && !can_refused_by_owner(&m->peer[i].refusal)) return true;
    return false;
}

void can_master_leave(const struct can_master *m, struct can_queue *out) {
    can_queue_push(out, can_frame_nmt(NMT_PREOPERATIONAL, 0));
    for (int i = 0; i < m->nodes; i++)
        if (m->peer[i].claimed) can_queue_push(out, can_frame_sdo(i + 1, &(struct can_sdo){SDO_DOWNLOAD, 0x2000, 2, 4, m->token}));
}

static const double centre[LEGS] = {0};

static void give(struct can_master *m, const double valve[LEGS], struct can_queue *out) {
    int16_t raw[LEGS];
    bool centres = true;
    for (int i = 0; i < LEGS; i++) centres &= valve[i] == 0.0;
    /* SAFETY: the first command that centres the valves is never delayed; a pause that is still due
     * follows in the next cycle. */
    if (m->pause == CAN_PAUSE_DUE && !(centres && !m->centred)) {
        m->pause = CAN_PAUSED;
        m->punctual = whole(m);
        return;
    }
    m->centred = centres;
    m->level ^= m->due;
    m->due = false;
    for (int i = 0; i < LEGS; i++) raw[i] = (int16_t)channel_raw(&m->params->valve_channel, i, valve[i], INT16_MAX);
    for (int group = 0; group < CAN_GROUPS; group++) can_queue_push(out, can_frame_rpdo(group, raw + CAN_GROUP_NODES * group));
    if (m->nodes >= CAN_IO) can_queue_push(out, can_frame_outputs(m->level ? OUTPUT_SUPPLY : 0));
    can_queue_push(out, can_frame_sync()); /* SYNC comes last, because it puts the commands into
                                            * force */
    m->unechoed++;
}

void can_master_command(struct can_master *m, const struct hal_command *command, struct can_queue *out) {
    m->due |= command->supply != m->given;
    m->given = command->supply;
    give(m, command->enable ? command->valve : centre, out);
}

/* SAFETY: pending changes of the supply output are dropped, and the output keeps its level. Its
 * changes are the life sign; without them the machine switches the supply off. */
void can_master_safe(struct can_master *m, struct can_queue *out) {
    m->due = false;
    give(m, centre, out);
}

/* Takes over the window's sample if the sample is complete and no pause (a cycle without SYNC) is
 * due. */
static void latch(struct can_master *m) {
    if (m->syncs == m->latched_sync) return;
    if (!whole(m)) miss(m);
    if (!whole(m) || m->pause == CAN_PAUSE_DUE) return;
    for (int i = 0; i < m->nodes; i++) m->latched[i] = m->peer[i].tpdo, m->peer[i].known = true;
    m->latched_sync = m->syncs;
    m->latched_ns = m->sync_ns;
    m->latched_gap_ns = m->gap_ns;
    m->delivered = false;
}

/* SAFETY: an unknown input counts as open; so does an input that any frame since the last sample
 * shows open, even in an incomplete window. */
static void convert_inputs(const struct can_master *m, struct hal_sample *s) {
    const struct can_peer *io = &m->peer[CAN_IO - 1];
    const struct interlock_params *interlocks = &m->params->interlocks;
    struct interlock_reading latched = interlock_read(interlocks, m->latched[CAN_IO - 1].inputs);
    if (!io->known) return;
    s->inputs = latched.closed & m->closed;
    s->contradicted = latched.contradicted;
    if (!io->fresh) return;
    struct interlock_reading newest = interlock_read(interlocks, io->tpdo.inputs);
    s->inputs &= newest.closed;
    s->contradicted |= newest.contradicted;
}

static void convert(const struct can_master *m, struct hal_sample *s) {
    const struct params *p = m->params;
    bool missing[CAN_NODES] = {false};
    for (int i = 0; i < LEGS; i++) {
        const struct can_tpdo *t = &m->latched[i];
        s->length_m[i] = channel_si(&p->length_channel, i, channel_from_32(t->position));
        s->p1_pa[i] = channel_si(&p->p1_channel, i, channel_from_16(t->p1));
        s->p2_pa[i] = channel_si(&p->p2_channel, i, channel_from_16(t->p2));
        missing[i] = isnan(s->length_m[i]) || isnan(s->p1_pa[i]) || isnan(s->p2_pa[i]);
    }
    for (int i = 0; i < m->nodes; i++) {
        uint16_t emcy = m->peer[i].emcy;
        bool told = emcy == EMCY_SENSOR && missing[i]; /* the missing reading itself shows this
                                                        * error */
        if (m->peer[i].phase != CAN_RUNNING || (emcy && !told)) s->flags |= SAMPLE_INVALID;
    }
    convert_inputs(m, s);
}

static void tell_twins(struct can_master *m, struct hal_sample *s) {
    for (int i = 0; i < m->nodes; i++) {
        struct can_peer *p = &m->peer[i];
        if (!p->contradicts && !is_twin(m, p)) continue;
        s->flags |= SAMPLE_TWIN;
        if (i < LEGS) s->twins |= 1u << i;
        p->contradicts = false;
    }
}

void can_master_sample(struct can_master *m, struct hal_sample *s) {
    uint64_t before = m->latched_sync;
    latch(m);
    *s = (struct hal_sample){.time_ns = m->latched_ns, .device_seq = m->latched_sync};
    if (m->delivered) s->flags |= SAMPLE_STALE;
    else if (before && m->latched_sync != before + 1) s->flags |= SAMPLE_DROPPED;
    /* SAFETY: if the time between two SYNCs differs from the period by more than half a period, a
     * SYNC was lost or late, and the previous command was held too long or too short. */
    int64_t period_ns = ns_from_seconds(m->params->loop.period_s);
    if (2 * llabs(m->latched_gap_ns - period_ns) > period_ns) s->flags |= SAMPLE_LATE;
    if (!m->latched_sync || m->bus == CAN_BUS_OFF) s->flags |= SAMPLE_INVALID;
    convert(m, s);
    if (m->foreign) s->flags |= SAMPLE_FOREIGN;
    tell_twins(m, s);
    m->foreign = 0;
    m->closed = INPUTS_ALL;
    m->delivered = true;
}
