/* The device side of CAN, for `hexid plant`: seven CANopen nodes (can_node.h) on one socket, with
 * the simulated machine behind them. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "backends.h"
#include "can_node.h"
#include "can_socket.h"
#include "channel.h"
#include "device.h"
#include "interlock.h"
#include "monotonic.h"
#include "params.h"
#include "poll_any.h"
#include "units.h"

struct can_device {
    const struct params *params;
    struct device *device;
    struct can_socket socket;
    struct can_node node[CAN_NODES];
    struct can_queue out;
    int64_t came_ns; /* arrival time of the last frame */
    int64_t look_ns; /* time of the next check of the interface */
    enum can_link link;
};

/* Accepts all 11-bit data frames, because a master may give SYNC and RPDOs any identifier. */
static const struct can_accept everything[] = {{0, 0}};
enum { LOOK_NS = NS_PER_S / 4 };

static int open_socket(struct can_device *d, const char *interface, struct error *error) {
    return can_socket_open(&d->socket, interface, everything, sizeof everything / sizeof *everything, false, false, error);
}

/* Opens a new socket when an interface that was removed is back. The nodes keep their state; their
 * watchdogs have centred the valves in the meantime. */
static void look_after_interface(struct can_device *d, const char *interface, int64_t now_ns) {
    char text[160];
    if (now_ns < d->look_ns || !d->socket.index) return;
    d->look_ns = now_ns + LOOK_NS;
    enum can_link before = d->link;
    d->link = can_socket_link(interface, d->socket.index);
    if (d->link == CAN_LINK_GONE) {
        struct can_device again = {0};
        if (!open_socket(&again, interface, &(struct error){0})) {
            can_socket_close(&d->socket);
            d->socket = again.socket;
            d->link = CAN_LINK_UP;
            before = CAN_LINK_GONE;
        }
    }
    can_link_describe(d->link, interface, text, sizeof text);
    if (d->link != before) printf("plant: can:%s: %s\n", interface, *text ? text : "ready again");
    fflush(stdout);
}

/* Sends the queued frames. A frame that the kernel's transmit queue cannot take is dropped, as in
 * the controller of a real node, because late frames are useless. */
static void flush(struct can_device *d) {
    for (int i = 0; i < d->out.count; i++) i += can_socket_send(&d->socket, d->out.frame + i, d->out.count - i);
    d->out.count = 0;
}

static struct can_tpdo reading(const struct params *p, const struct hal_sample *s, int node) {
    int leg = node - 1;
    if (node == CAN_IO) return (struct can_tpdo){.inputs = (uint8_t)interlock_bits(&p->interlocks, s->inputs)};
    return (struct can_tpdo){.position = channel_raw(&p->length_channel, leg, s->length_m[leg], INT32_MAX),
                             .p1 = (int16_t)channel_raw(&p->p1_channel, leg, s->p1_pa[leg], INT16_MAX),
                             .p2 = (int16_t)channel_raw(&p->p2_channel, leg, s->p2_pa[leg], INT16_MAX)};
}

static void valves(const struct can_device *d, double valve[LEGS]) {
    for (int i = 0; i < LEGS; i++) {
        double command = channel_si(&d->params->valve_channel, i, can_node_output(&d->node[i]));
        valve[i] = command >= -1.0 && command <= 1.0 ? command : 0.0; /* an implausible command
                                                                       * (NAN) centres the valve */
    }
}

/* Handles SYNC: sends the readings at now_ns, then simulates the next period with the commands that
 * the SYNC puts into force. */
static void synchronise(struct can_device *d, const struct can_frame *sync, int64_t now_ns) {
    struct hal_sample latched = {0};
    struct hal_command command = {.enable = true};
    device_latch(d->device, now_ns, &latched);
    for (int i = 0; i < CAN_NODES; i++) {
        struct can_tpdo t = reading(d->params, &latched, i + 1);
        if (can_node_synced_by(&d->node[i], sync)) can_node_sync(&d->node[i], sync, &t, &d->out);
    }
    flush(d);
    valves(d, command.valve);
    /* SAFETY: can_node_output() is 0, which switches the supply off, unless a command for the
     * supply is in force and a heartbeat is watched and comes */
    command.supply = can_node_output(&d->node[CAN_IO - 1]) & OUTPUT_SUPPLY;
    device_live(d->device, &command, now_ns);
}

static bool synced_by(const struct can_device *d, const struct can_frame *f) {
    for (int i = 0; i < CAN_NODES; i++)
        if (can_node_synced_by(&d->node[i], f)) return true;
    return false;
}

static void take(struct can_device *d, const struct can_frame *f, int64_t came_ns) {
    if (synced_by(d, f)) synchronise(d, f, came_ns);
    for (int i = 0; i < CAN_NODES; i++)
        if (!can_node_synced_by(&d->node[i], f)) can_node_receive(&d->node[i], f, came_ns, &d->out);
    flush(d);
}

static void receive(struct can_device *d) {
    struct can_arrival come[CAN_BATCH];
    for (int got = CAN_BATCH; got == CAN_BATCH;) {
        got = can_socket_receive(&d->socket, come);
        int64_t now_ns = monotonic_ns(), realtime_ns = can_realtime_ns();
        for (int i = 0; i < got; i++) {
            d->came_ns = can_came_ns(now_ns, realtime_ns - come[i].realtime_ns, d->came_ns);
            take(d, &come[i].frame, d->came_ns);
        }
    }
}

/* Advances nodes and machine to now_ns. All frames that came before now_ns must have been
 * handled. */
static void tick(struct can_device *d, int64_t now_ns) {
    double valve[LEGS];
    for (int i = 0; i < CAN_NODES; i++) can_node_tick(&d->node[i], now_ns, &d->out);
    flush(d);
    valves(d, valve);
    /* SAFETY: a valve whose node has a time-out is centred now, not only at the next SYNC */
    device_valves(d->device, valve);
    device_tick(d->device, now_ns);
}

static int can_serve(const char *interface, const struct params *params, struct device *device, const _Atomic bool *stop,
                     struct error *error) {
    struct can_device d = {.params = params, .device = device};
    int status = open_socket(&d, interface, error);
    if (status) return status;
    for (int i = 0; i < CAN_NODES; i++) can_node_init(&d.node[i], i + 1, monotonic_ns(), &d.out);
    flush(&d);
    printf("plant: ready on can:%s\n", interface);
    fflush(stdout);
    while (!atomic_load_explicit(stop, memory_order_relaxed)) {
        struct pollfd p = {.fd = d.socket.fd, .events = POLLIN};
        if (poll_any(&p, 1, 1, NULL) < 0 && errno != EINTR) {
            status = error_set(error, STATUS_IO, "plant: can:%s: %s", interface, strerror(errno));
            break;
        }
        int64_t now_ns = monotonic_ns();
        receive(&d);
        tick(&d, now_ns);
        look_after_interface(&d, interface, now_ns);
    }
    can_socket_close(&d.socket);
    return status;
}

const struct device_bus device_can = {
    .scheme = "can",
    .usage = "can:IF                     six CANopen axis nodes and an I/O module on SocketCAN interface IF",
    .serve = can_serve,
};
