/* can: CANopen nodes, six axes and an I/O module, on SocketCAN (can_frames.h: the frames,
 * can_master.h: nodes and samples, can_socket.h: the socket).
 *
 * Cycle k reads the values that the nodes latched at the SYNC of cycle k-1, and ends by sending the
 * RPDOs of its command, then SYNC k. SYNC k puts the command into force and latches the next
 * sample, so a command acts exactly one cycle after the sample from which it was computed. The
 * sample's time is the moment at which the bus carried its SYNC. After a missing TPDO a cycle may
 * send nothing (can_master.h).
 *
 * SAFETY: frames in the kernel's transmit queue cannot be recalled. So while three SYNCs have not
 * come back from the bus, nothing more is sent, and write() fails; only once every 0.1 s one
 * cycle's frames are sent as a trial (jam_s). If the bus carries the queued frames later, the nodes
 * ignore them: their watchdogs have centred the valves, and in pre-operational they take no
 * commands.
 *
 * When an interface disappears because its adapter was unplugged, its socket is useless. A thread
 * of the back-end checks the interface four times a second and opens a socket on the new interface
 * of the same name; the loop, which never waits, then uses that socket. Nodes and platform are then
 * in the same state as after any other loss of the bus.
 *
 * SAFETY: one master. Bring-up listens before it sends anything. If it hears a frame that only a
 * master sends, it ends, and does not disturb the running master. Later such a frame is a fault at
 * once, unless it is the echo of an own frame (can_master.h). */
#include <errno.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/random.h>
#include <time.h>
#include <unistd.h>

#include "backends.h"
#include "can_master.h"
#include "can_socket.h"
#include "crash.h"
#include "monotonic.h"
#include "params.h"
#include "poll_any.h"
#include "thread.h"
#include "units.h"

enum { BRING_UP_MS = 3000, LISTEN_MAX_MS = 500, DRAIN_MAX = 4 /* counted in batches of frames */, UNECHOED_MAX = 3 };
_Static_assert((int)CAN_QUEUE <= (int)CAN_BATCH, "a queue is sent at once");
#define JAMMED (1ull << 63)
static const double jam_s = 0.1; /* time after the last sent SYNC when its frames count as lost (for
                                  * instance by an interface reset), and one cycle's frames are sent
                                  * as a trial */

struct can {
    struct hal hal;
    struct can_socket socket;
    struct can_master master;
    int64_t sent_ns; /* time of the last SYNC, CLOCK_MONOTONIC */
    bool jammed;
    _Atomic uint64_t trouble, refusal; /* state and refusal (struct can_condition) of the first
                                        * problem, counted anew after each second without a problem;
                                        * written by the loop, read by any thread */
    int64_t good_ns;          /* time at which the last problem was seen */
    /* descriptors passed between the loop and the watch thread. fresh: a new socket; spent: a
     * replaced socket that must be closed; -1: there is none */
    _Atomic int fresh, spent;
    _Atomic int link;         /* enum can_link, as the watch thread saw it last */
    sem_t look;
    /* the group below belongs to the watch thread */
    pthread_t watch;
    _Atomic bool stop;
    char interface[CAN_INTERFACE_SIZE];
    int index;                /* the kernel's index of the newest socket's interface */
};

/* Frames that the socket accepts. The entry of COB_EMCY also accepts SYNC, whose node is 0. */
static const struct can_accept accepted[] = {{COB_NMT, CAN_SFF_MASK},      {COB_EMCY, COB_FUNCTION}, {COB_TPDO, COB_FUNCTION},
                                             {COB_RPDO, COB_FUNCTION},     {COB_SDO, COB_FUNCTION},  {COB_SDO_REPLY, COB_FUNCTION},
                                             {COB_HEARTBEAT, COB_FUNCTION}};

static int open_socket(struct can_socket *s, const char *interface, struct error *error) {
    return can_socket_open(s, interface, accepted, sizeof accepted / sizeof *accepted, true, true, error);
}

/* Sends all frames, or fails at the first that the kernel refuses. */
static int flush(struct can *c, struct can_queue *q) { return can_socket_send(&c->socket, q->frame, q->count) == q->count ? 0 : -1; }

/* Handles the received frames, at most DRAIN_MAX batches, so that a busy bus cannot delay the loop.
 * Returns -1 if the interface is down or gone. The kernel stamps frames on CLOCK_REALTIME, which
 * may jump; the stamps are converted to CLOCK_MONOTONIC, and a stamp in the future counts as
 * now. */
static int drain(struct can *c) {
    int64_t to_monotonic_ns = monotonic_ns() - can_realtime_ns();
    struct can_arrival come[CAN_BATCH];
    for (int batch = 0, got = CAN_BATCH; batch < DRAIN_MAX && got == CAN_BATCH; batch++) {
        got = can_socket_receive(&c->socket, come);
        if (got < 0) return -1;
        int64_t now_ns = monotonic_ns();
        for (int i = 0; i < got; i++) {
            int64_t came_ns = come[i].realtime_ns + to_monotonic_ns;
            can_master_receive(&c->master, &come[i].frame, come[i].own, came_ns < now_ns ? came_ns : now_ns);
        }
    }
    return 0;
}

static int housekeep(struct can *c, bool alive) {
    struct can_queue q = {0};
    can_master_poll(&c->master, monotonic_ns(), alive, &q);
    return flush(c, &q);
}

static void wait_for_frames(const struct can *c) {
    struct pollfd p = {.fd = c->socket.fd, .events = POLLIN};
    poll_any(&p, 1, 5, NULL);
}

static void leave(struct can *c) {
    struct can_queue q = {0};
    can_master_leave(&c->master, &q);
    flush(c, &q);
}

static int refuse_second(const struct can_frame *heard, const char *interface, struct error *error) {
    return error_set(error, STATUS_UNSAFE,
                     "can:%s: another master is on %s: %s (0x%03x) heard; stop that one first, two cannot "
                     "command one machine",
                     interface, interface, can_frame_of_master(heard), (unsigned)heard->can_id);
}

/* SAFETY: listens for three heartbeat periods, at most 0.5 s, before anything is sent. A running
 * hexid would send SYNC in every cycle of that time. */
static int listen_first(struct can *c, const char *interface, struct error *error) {
    int64_t three_ns = 3 * ns_from_seconds(c->master.params->can.heartbeat_s), most_ns = LISTEN_MAX_MS * NS_PER_MS;
    int64_t end_ns = monotonic_ns() + (three_ns < most_ns ? three_ns : most_ns);
    do {
        struct can_arrival come[CAN_BATCH];
        wait_for_frames(c);
        for (int got = CAN_BATCH; got == CAN_BATCH;) {
            got = can_socket_receive(&c->socket, come);
            for (int i = 0; i < got; i++)
                if (!come[i].own && can_frame_of_master(&come[i].frame)) return refuse_second(&come[i].frame, interface, error);
        }
    } while (monotonic_ns() < end_ns);
    return STATUS_OK;
}

/* Returns the result of the bring-up: STATUS_OK if the nodes are ready, else an error with the
 * reason and the remedy. */
static int judge(const struct can *c, bool sent, const char *interface, struct error *error) {
    const struct can_master *m = &c->master;
    char text[200];
    if (m->foreign) return refuse_second(&(struct can_frame){.can_id = m->foreign & CAN_SFF_MASK}, interface, error);
    if (can_master_twin(m))
        return error_set(error, STATUS_UNSAFE,
                         "can:%s: node %d answers twice: two devices have its number, or it repeats itself; give each device a number "
                         "of its own",
                         interface, can_master_twin(m));
    if (can_master_ready(m)) return STATUS_OK;
    struct can_condition condition = can_master_condition(m);
    can_condition_describe(condition, m->params, text, sizeof text);
    if (condition.refusal && sent)
        return error_set(error, STATUS_UNSAFE,
                         "can:%s: %s; connect the nodes of hexid_node.eds and hexid_io.eds, give the keys of "
                         "others, or stop the other master",
                         interface, text);
    return error_set(error, STATUS_IO,
                     "can:%s: %s; check power, node ids 1 to %d, bit rate and termination "
                     "(`candump %s` shows what is there)",
                     interface, sent ? text : "nothing can be sent", m->nodes, interface);
}

static int bring_up(struct can *c, const char *interface, struct error *error) {
    struct can_frame reset = can_frame_nmt(NMT_RESET_COMMUNICATION, 0);
    const struct can_master *m = &c->master;
    int64_t deadline_ns = monotonic_ns() + BRING_UP_MS * NS_PER_MS;
    bool sent = can_socket_send(&c->socket, &reset, 1) == 1;
    while (sent && !can_master_ready(m) && !can_master_misfit(m) && !m->foreign && !can_master_twin(m) && monotonic_ns() < deadline_ns) {
        wait_for_frames(c);
        if (drain(c) || housekeep(c, can_master_claimed(m))) break;
    }
    int status = judge(c, sent, interface, error);
    if (status && sent) leave(c);
    return status;
}

static int refuse_load(const struct params *params, const char *interface, struct error *error) {
    struct can_load l = can_load(params);
    if (l.share <= l.limit) return STATUS_OK;
    return error_set(error, STATUS_USAGE,
                     "can:%s: %d bits a cycle and %.1f of heartbeats take %.0f %% of %g s at %g bit/s, "
                     "at most %.0f %% fit: raise can.bitrate_bps or loop.period_s",
                     interface, l.cycle_bits, l.heartbeat_bits, 100 * l.share, params->loop.period_s, params->can.bitrate_bps,
                     100 * l.limit);
}

static int refuse_watchdog(const struct params *params, const char *interface, struct error *error) {
    double watchdog_s = params->device.watchdog_s;
    if (watchdog_s * 1e3 <= CAN_WATCHDOG_MAX_MS) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "can:%s: device.watchdog_s %g is more than the nodes take, %g s", interface, watchdog_s,
                     CAN_WATCHDOG_MAX_MS / 1e3);
}

/* Returns a random token; never 0, which means no owner. */
static uint32_t session_token(void) {
    uint32_t token = 0;
    if (getrandom(&token, sizeof token, 0) != sizeof token) token = (uint32_t)monotonic_ns();
    return token ? token : 1;
}

/* Checks the interface once, and opens a new socket if the interface was replaced. Called by the
 * watch thread, which may wait. */
static void look(struct can *c) {
    struct can_socket again;
    int spent = atomic_exchange(&c->spent, -1);
    if (spent >= 0) close(spent);
    enum can_link link = can_socket_link(c->interface, c->index);
    atomic_store(&c->link, (int)link);
    if (link != CAN_LINK_GONE || open_socket(&again, c->interface, &(struct error){0})) return;
    c->index = again.index;
    int unused = atomic_exchange(&c->fresh, again.fd); /* an earlier new socket that the loop has
                                                        * not taken, perhaps because the loop has
                                                        * ended */
    if (unused >= 0) close(unused);
}

static void *watch(void *argument) {
    struct can *c = argument;
    crash_stack();
    while (!atomic_load(&c->stop)) {
        int64_t until_ns = monotonic_ns() + NS_PER_S / 4;
        struct timespec t = {.tv_sec = until_ns / NS_PER_S, .tv_nsec = until_ns % NS_PER_S};
        while (sem_clockwait(&c->look, CLOCK_MONOTONIC, &t) && errno == EINTR) continue;
        look(c);
    }
    return NULL;
}

/* SAFETY: the watch thread blocks all signals, so that a signal that ends the run reaches the
 * thread that parks the platform first. */
static int start_watch(struct can *c, const char *interface, struct error *error) {
    sigset_t all, before;
    if (!c->socket.index) return STATUS_OK;
    snprintf(c->interface, sizeof c->interface, "%s", interface);
    c->index = c->socket.index;
    sem_init(&c->look, 0, 0);
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    int status = thread_start(&c->watch, "can", THREAD_STACK_COPY, watch, c, error);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (status) leave(c);
    return status;
}

static void end_watch(struct can *c) {
    if (!c->socket.index) return;
    atomic_store(&c->stop, true);
    sem_post(&c->look);
    pthread_join(c->watch, NULL);
    int rest[] = {atomic_load(&c->fresh), atomic_load(&c->spent)};
    for (int i = 0; i < 2; i++)
        if (rest[i] >= 0) close(rest[i]);
    sem_destroy(&c->look);
}

/* Takes the socket that the watch thread has opened, and hands the old one back to that thread.
 * RT. */
static void take_fresh(struct can *c) {
    int fresh = atomic_exchange(&c->fresh, -1);
    if (fresh < 0) return;
    atomic_store(&c->spent, c->socket.fd);
    c->socket.fd = fresh;
    can_master_new_bus(&c->master);
}

static int can_open(struct hal **hal, const char *interface, const struct params *params, uint64_t seed, struct error *error) {
    (void)seed;
    int status = refuse_load(params, interface, error);
    if (!status) status = refuse_watchdog(params, interface, error);
    if (status) return status;
    struct can *c = calloc(1, sizeof *c);
    if (!c) return error_set(error, STATUS_IO, "can: out of memory");
    c->hal.ops = &hal_can;
    atomic_init(&c->fresh, -1);
    atomic_init(&c->spent, -1);
    can_master_init(&c->master, params, session_token());
    status = open_socket(&c->socket, interface, error);
    if (!status) {
        status = listen_first(c, interface, error);
        if (!status) status = bring_up(c, interface, error);
        if (!status) status = start_watch(c, interface, error);
        if (status) can_socket_close(&c->socket);
    }
    if (status) free(c);
    else *hal = &c->hal;
    return status;
}

/* Keeps the first problem until a second has passed without a problem, because later problems are
 * its consequences. */
static void note_trouble(struct can *c, int64_t now_ns) {
    struct can_condition condition = can_master_condition(&c->master);
    uint64_t state = condition.state | (c->jammed ? JAMMED : 0);
    uint64_t noted = atomic_load_explicit(&c->trouble, memory_order_relaxed);
    if (state) c->good_ns = now_ns;
    if (!(state ? !noted : noted && now_ns - c->good_ns > NS_PER_S)) return;
    atomic_store_explicit(&c->refusal, condition.refusal, memory_order_relaxed);
    atomic_store_explicit(&c->trouble, state, memory_order_release);
}

static int can_read(struct hal *hal, int64_t now_ns, struct hal_sample *sample) {
    struct can *c = (struct can *)hal;
    int64_t to_loop_ns = now_ns - monotonic_ns();
    take_fresh(c);
    int dead = drain(c);
    if (dead && c->socket.index) sem_post(&c->look); /* wakes the watch thread */
    c->jammed = c->master.unechoed >= UNECHOED_MAX && monotonic_ns() - c->sent_ns < ns_from_seconds(jam_s);
    if (!c->jammed) dead |= housekeep(c, true);
    note_trouble(c, now_ns);
    can_master_sample(&c->master, sample);
    sample->time_ns += to_loop_ns;
    sample->age_ns = now_ns - sample->time_ns;
    /* The sample should be one period old, because it was latched at the SYNC of the previous
     * cycle. It is late if it is more than half a period older than that. */
    if (2 * sample->age_ns > 3 * ns_from_seconds(c->master.params->loop.period_s)) sample->flags |= SAMPLE_LATE;
    return dead ? -1 : 0;
}

/* Sends the command, or only centres the valves if `wanted` is NULL. */
static int command(struct can *c, const struct hal_command *wanted) {
    struct can_queue q = {0};
    if (c->jammed) return -1;
    if (wanted) can_master_command(&c->master, wanted, &q);
    else can_master_safe(&c->master, &q);
    if (q.count) c->sent_ns = monotonic_ns();
    return flush(c, &q);
}

static int can_write(struct hal *hal, const struct hal_command *wanted) {
    struct can *c = (struct can *)hal;
    return can_master_ready(&c->master) ? command(c, wanted) : -1;
}

static void can_safe(struct hal *hal) { command((struct can *)hal, NULL); }

static void can_describe(const struct hal *hal, char *text, size_t size) {
    const struct can *c = (const struct can *)hal;
    uint64_t trouble = atomic_load_explicit(&c->trouble, memory_order_acquire);
    struct can_condition condition = {trouble & ~JAMMED, atomic_load_explicit(&c->refusal, memory_order_relaxed)};
    can_link_describe((enum can_link)atomic_load(&c->link), c->interface, text, size);
    if (*text) return;
    can_condition_describe(condition, c->master.params, text, size);
    if (trouble & JAMMED && !*text) snprintf(text, size, "the bus does not carry what is sent");
}

/* SAFETY: nodes that leave operational centre their valves, even if command frames are still under
 * way. */
static void can_close(struct hal *hal) {
    struct can *c = (struct can *)hal;
    end_watch(c);
    leave(c);
    can_socket_close(&c->socket);
    free(c);
}

const struct hal_ops hal_can = {
    .scheme = "can",
    .usage = "can:IF                     six CANopen axis nodes and an I/O module on SocketCAN interface IF (can:can0)",
    .reopens = HAL_REOPENS_CAN,
    .open = can_open,
    .read = can_read,
    .write = can_write,
    .safe = can_safe,
    .close = can_close,
    .describe = can_describe,
};
