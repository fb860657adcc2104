/* The whole back-end and the whole device, each on a socket pair instead of a CAN socket. The test
 * controls the bus between them: it stalls, goes bus-off, or fills the transmit queue. vcan offers
 * none of these, and sanitizers do not start where vcan exists. */
#include "support.h"

#include <linux/can/error.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "backends.h"
#include "can_frames.h"
#include "can_socket.h"
#include "device.h"
#include "monotonic.h"
#include "units.h"

int __wrap_can_socket_open(struct can_socket *s, const char *interface, const struct can_accept *accept, int count, bool own, bool errors,
                           struct error *error);

static bool marking; /* the sockets claim to mark echoes of own frames, so that every unmarked frame
                      * counts as another's */

/* Linked in place of can_socket_open (Makefile): the interface's name is a socket's number. */
int __wrap_can_socket_open(struct can_socket *s, const char *interface, const struct can_accept *accept, int count, bool own, bool errors,
                           struct error *error) {
    (void)accept, (void)count, (void)own, (void)errors, (void)error;
    *s = (struct can_socket){.fd = dup(atoi(interface)), .confirms = marking};
    return s->fd >= 0 ? STATUS_OK : STATUS_IO;
}

int64_t __real_can_realtime_ns(void);
int64_t __wrap_can_realtime_ns(void);

static _Atomic int64_t set_back_ns; /* the clock was set back by this since the kernel stamped the
                                     * frames */

/* Linked in place of can_realtime_ns; the kernel's stamps stay as they are. */
int64_t __wrap_can_realtime_ns(void) { return __real_can_realtime_ns() - set_back_ns; }

enum { THEIRS, OURS };

struct world {
    struct params params;
    struct hal *hal;
    struct device *device;
    int daemon[2], plant[2];
    pthread_t bus_thread, device_thread;
    pthread_mutex_t bus; /* locked by the test to stall the bus */
    bool still;          /* the bus is stalled */
    sem_t answered;      /* posted when all TPDOs since the last SYNC have come */
    int64_t written_ns;
    bool supply;         /* level of the life sign for the supply */
    int stalls;          /* number of stalls of the host, after which no answer came in time or the
                          * nodes' watchdogs fired */
    _Atomic bool bus_stop, device_stop;
};

static bool take(int fd, struct can_frame *f) { return recv(fd, f, sizeof *f, MSG_DONTWAIT) == (ssize_t)sizeof *f; }
static void give(int fd, const struct can_frame *f) { assert_int_equal(send(fd, f, sizeof *f, 0), sizeof *f); }

/* Carries frames to the plant, SYNC first echoed to its sender as a controller does, and all the
 * plant's frames to the daemon. */
static void carry(struct world *w, int *answers) {
    struct can_frame f;
    while (take(w->daemon[OURS], &f)) {
        if (f.can_id == COB_SYNC) *answers = 0, give(w->daemon[OURS], &f);
        give(w->plant[OURS], &f);
    }
    while (take(w->plant[OURS], &f)) {
        int node = can_frame_node(&f, COB_TPDO);
        give(w->daemon[OURS], &f);
        if (node && ++*answers == CAN_NODES) sem_post(&w->answered);
    }
}

static void *bus_run(void *argument) {
    struct world *w = argument;
    int answers = 0;
    while (!atomic_load(&w->bus_stop)) {
        struct pollfd p[] = {{.fd = w->daemon[OURS], .events = POLLIN}, {.fd = w->plant[OURS], .events = POLLIN}};
        poll(p, 2, 1);
        pthread_mutex_lock(&w->bus);
        carry(w, &answers);
        pthread_mutex_unlock(&w->bus);
    }
    return NULL;
}

static void *device_run(void *argument) {
    struct world *w = argument;
    char name[12];
    struct error error;
    snprintf(name, sizeof name, "%d", w->plant[THEIRS]);
    device_can.serve(name, &w->params, w->device, &w->device_stop, &error);
    return NULL;
}

static void halt_bus(struct world *w) {
    pthread_mutex_lock(&w->bus);
    w->still = true;
}

static void release_bus(struct world *w) {
    if (w->still) pthread_mutex_unlock(&w->bus);
    w->still = false;
}

/* No claim here depends on durations: a busy machine under a sanitizer is slow. Watchdogs are
 * therefore long, and a cycle starts anew if the host stalls for longer than they allow. */
static int start(void **state) {
    struct world *w = calloc(1, sizeof *w);
    struct error error;
    char name[12];
    assert_non_null(w);
    *state = w;
    config_default(&w->params);
    w->params.sensors.enabled = false;
    w->params.sim.engine = ENGINE_CLOSED_FORM;
    w->params.device.watchdog_s = 1.0; /* maximum that a node accepts */
    w->params.can.heartbeat_s = 5.0;
    assert_int_equal(socketpair(AF_UNIX, SOCK_SEQPACKET, 0, w->daemon), 0);
    assert_int_equal(socketpair(AF_UNIX, SOCK_SEQPACKET, 0, w->plant), 0);
    pthread_mutex_init(&w->bus, NULL);
    sem_init(&w->answered, 0, 0);
    w->device = device_create(&w->params, 1, &error);
    assert_non_null(w->device);
    assert_int_equal(pthread_create(&w->bus_thread, NULL, bus_run, w), 0);
    assert_int_equal(pthread_create(&w->device_thread, NULL, device_run, w), 0);
    snprintf(name, sizeof name, "%d", w->daemon[THEIRS]);
    int status = STATUS_IO;
    for (int tries = 0; status && tries < 5; tries++) status = hal_can.open(&w->hal, name, &w->params, 1, &error);
    if (status) print_error("%s\n", error.text);
    return status;
}

/* Starts for a slow case, which a quick run skips: cmocka cannot skip in a setup. */
static int start_slow(void **state) { return quick() ? 0 : start(state); }

static int end(void **state) {
    struct world *w = *state;
    struct can_frame f;
    if (!w) return 0;
    release_bus(w);
    if (w->hal) hal_can.close(w->hal);
    atomic_store(&w->bus_stop, true);
    /* the bus thread may be blocked, because the daemon no longer reads */
    while (pthread_tryjoin_np(w->bus_thread, NULL)) take(w->daemon[THEIRS], &f);
    atomic_store(&w->device_stop, true);
    pthread_join(w->device_thread, NULL);
    device_destroy(w->device);
    for (int i = 0; i < 2; i++) close(w->daemon[i]), close(w->plant[i]);
    pthread_mutex_destroy(&w->bus);
    sem_destroy(&w->answered);
    free(w);
    return 0;
}

static struct hal_sample read_now(struct world *w, int status) {
    struct hal_sample s;
    assert_int_equal(hal_can.read(w->hal, monotonic_ns(), &s), status);
    return s;
}

static int write_all(struct world *w, double valve) {
    struct hal_command command = {.enable = true, .supply = w->supply = !w->supply};
    for (int i = 0; i < LEGS; i++) command.valve[i] = valve;
    return hal_can.write(w->hal, &command);
}

/* Waits for the nodes' TPDOs. Returns false if they do not come, because a cycle that pauses for a
 * late TPDO sends no SYNC. */
static bool answered(struct world *w) {
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += NS_PER_S / 2; /* shorter than the nodes' watchdog */
    if (until.tv_nsec >= NS_PER_S) until.tv_sec++, until.tv_nsec -= NS_PER_S;
    return sem_clockwait(&w->answered, CLOCK_MONOTONIC, &until) == 0;
}

static const char *trouble(struct world *w, char text[200]) {
    hal_can.describe(w->hal, text, 200);
    return text;
}

static int frames_in_queue(struct world *w, struct can_frame *frames, int size) {
    int count = 0;
    while (count < size && take(w->daemon[OURS], &frames[count])) count++;
    return count;
}

static void wait_for_period(struct world *w) {
    while (monotonic_ns() - w->written_ns < ns_from_seconds(w->params.loop.period_s)) sched_yield();
    w->written_ns = monotonic_ns();
}

/* Runs one cycle, and returns -1 if its command was not written. It takes at least a period,
 * because the device takes a SYNC that comes too soon for a repetition. On return the next cycle's
 * readings have arrived. */
static int try_cycle(struct world *w, double valve, struct hal_sample *s) {
    wait_for_period(w);
    *s = read_now(w, 0);
    while (!sem_trywait(&w->answered)) continue; /* late answers */
    if (write_all(w, valve)) return -1;
    w->stalls += !answered(w);
    return 0;
}

/* Commands the centre in every cycle until a command is written and all nodes have answered. */
static void centre(struct world *w) {
    for (bool taken = false; !taken;) {
        wait_for_period(w);
        read_now(w, 0);
        taken = !write_all(w, 0.0);
        if (!taken) hal_can.safe(w->hal);
    }
    while (answered(w)) continue;
}

/* Runs one cycle on a working bus. If the host itself stalled until the nodes' watchdogs fired, the
 * nodes have rightly left operational and are started again first. */
static struct hal_sample cycle(struct world *w, double valve) {
    struct hal_sample s;
    char text[200];
    if (try_cycle(w, valve, &s)) {
        assert_non_null(strstr(trouble(w, text), "EMCY 0x8250")); /* RPDO timeout */
        w->stalls++;
        centre(w);
        assert_int_equal(try_cycle(w, valve, &s), 0);
    }
    assert_true(w->stalls < 10);
    return s;
}

/* Commands the centre until samples are fresh and valid again. */
static void recovers(struct world *w) {
    centre(w);
    for (int i = 0; cycle(w, 0.0).flags & (SAMPLE_INVALID | SAMPLE_STALE); i++) assert_true(i < 100);
}

/* Switches the supply on or off and waits until the pressure switch confirms it. */
static struct hal_sample pump(struct world *w, bool on) {
    struct hal_sample s;
    do {
        s = cycle(w, 0.0);
        w->supply ^= !on; /* write_all() toggles it */
    } while (!(s.inputs & INPUT_SUPPLY) == on);
    return s;
}

static void commands_through_the_whole_back_end_move_the_legs_behind_the_whole_device(void **state) {
    slow_case();
    struct world *w = *state;
    struct hal_sample before = pump(w, true), s = before;
    int stalls = w->stalls;
    for (int i = 0; i < 50;) {
        uint64_t seq = s.device_seq;
        bool stalled = w->stalls > stalls;
        stalls = w->stalls;
        s = cycle(w, 0.5);
        if (stalled || w->stalls > stalls) continue;
        i++;
        assert_int_equal(s.device_seq, seq + 1);
        assert_int_equal(s.flags & (SAMPLE_INVALID | SAMPLE_STALE | SAMPLE_DROPPED), 0);
    }
    for (int i = 0; i < LEGS; i++) assert_below(before.length_m[i] + 0.001, s.length_m[i]);
}

static void the_supply_is_there_while_its_output_changes_and_the_inputs_say_so(void **state) {
    slow_case();
    struct world *w = *state;
    assert_int_equal(cycle(w, 0.0).inputs, 0); /* nothing was latched before */
    assert_int_equal(cycle(w, 0.0).inputs, INPUTS_ALL & ~INPUT_SUPPLY);
    assert_int_equal(pump(w, true).inputs, INPUTS_ALL);
    assert_int_equal(pump(w, false).inputs, INPUTS_ALL & ~INPUT_SUPPLY);
    assert_int_equal(pump(w, true).inputs, INPUTS_ALL);
    struct hal_sample s;
    do { /* centres the valves as the loop does on a fault */
        s = read_now(w, 0);
        hal_can.safe(w->hal);
        answered(w);
    } while (s.inputs & INPUT_SUPPLY);
    assert_int_equal(s.inputs, INPUTS_ALL & ~INPUT_SUPPLY);
}

static void a_bus_that_stands_still_is_given_three_cycles_and_then_the_centre_only(void **state) {
    slow_case();
    struct world *w = *state;
    struct can_frame queued[64];
    char text[200];
    int written = 0, syncs = 0;
    for (int i = 0; i < 5; i++) cycle(w, 0.1);
    halt_bus(w);
    int64_t start_ns = monotonic_ns();
    for (read_now(w, 0); !write_all(w, 0.7); read_now(w, 0)) written++;
    /* one extra for each 0.1 s that this machine itself stalled */
    int excused = (int)((monotonic_ns() - start_ns) / ns_from_seconds(0.1));
    assert_in_range(written, 3, 3 + excused);
    assert_string_equal(trouble(w, text), "the bus does not carry what is sent");
    start_ns = monotonic_ns();
    while (monotonic_ns() - start_ns < ns_from_seconds(0.25)) { /* two more attempts */
        hal_can.safe(w->hal);
        read_now(w, 0);
    }
    int count = frames_in_queue(w, queued, 64);
    assert_true(count < 64);
    for (int i = 0; i < count; i++) {
        bool rpdo = (queued[i].can_id & COB_FUNCTION) == COB_RPDO && queued[i].can_id != COB_RPDO + CAN_IO;
        syncs += queued[i].can_id == COB_SYNC;
        for (int k = 0; rpdo && k < CAN_GROUP_NODES; k++) assert_true((can_get(queued[i].data + 2 * k, 2) == 0) == (syncs >= written));
    }
    assert_true(syncs > written);
    release_bus(w);
    recovers(w);
}

static void a_full_transmit_queue_fails_the_write_and_is_got_over(void **state) {
    slow_case();
    struct world *w = *state;
    int two = 3200; /* size of the send buffer, which the kernel doubles: room for two cycles'
                     * frames and one more */
    for (int i = 0; i < 5; i++) cycle(w, 0.0);
    assert_int_equal(setsockopt(w->daemon[THEIRS], SOL_SOCKET, SO_SNDBUF, &two, sizeof two), 0);
    halt_bus(w);
    int written = 0;
    for (; written < 3; written++) {
        read_now(w, 0);
        if (write_all(w, 0.0)) break;
    }
    assert_true(written < 3); /* the full queue fails the write before three SYNCs are unechoed */
    release_bus(w);
    recovers(w);
}

static void bus_off_invalidates_samples_and_refuses_commands_until_the_bus_carries_again(void **state) {
    slow_case();
    struct world *w = *state;
    const struct can_frame off = {.can_id = CAN_ERR_FLAG | CAN_ERR_BUSOFF, .len = 8};
    char text[200];
    for (int i = 0; i < 5; i++) cycle(w, 0.0);
    halt_bus(w);
    give(w->daemon[OURS], &off);
    assert_true(read_now(w, 0).flags & SAMPLE_INVALID);
    assert_int_equal(write_all(w, 0.5), -1);
    assert_string_equal(trouble(w, text), "bus-off");
    release_bus(w);
    recovers(w);
}

static void error_passive_is_told_and_commands_go_on(void **state) {
    struct world *w = *state;
    const struct can_frame passive = {.can_id = CAN_ERR_FLAG | CAN_ERR_CRTL, .len = 8, .data = {0, CAN_ERR_CRTL_TX_PASSIVE}};
    char text[200];
    for (int i = 0; i < 5; i++) cycle(w, 0.0);
    give(w->daemon[OURS], &passive);
    struct hal_sample s = cycle(w, 0.0);
    assert_int_equal(s.flags & (SAMPLE_INVALID | SAMPLE_STALE), 0);
    assert_string_equal(trouble(w, text), "bus error-passive");
}

static void a_clock_that_is_set_back_makes_no_twin(void **state) {
    struct world *w = *state;
    const struct can_frame beat = can_frame_heartbeat(4, CAN_OPERATIONAL);
    for (int i = 0; i < 5; i++) cycle(w, 0.0);
    give(w->daemon[OURS], &beat);
    set_back_ns = 1000 * NS_PER_S;
    assert_true(read_now(w, 0).time_ns <= monotonic_ns());
    set_back_ns = 0;
    for (int i = 0; i < 10; i++) assert_int_equal(cycle(w, 0.0).flags & SAMPLE_TWIN, 0);
}

static void a_frame_came_neither_in_the_future_nor_before_the_last_one(void **state) {
    (void)state;
    assert_int_equal(can_came_ns(1000, 10, 0), 990);
    assert_int_equal(can_came_ns(1000, -10, 0), 1000);
    assert_int_equal(can_came_ns(1000, 10, 995), 995);
}

/* Waits for a heartbeat with that state from the plant's node. When it comes, the node's tick has
 * ended. */
static void await_state(struct world *w, int node, enum can_state awaited) {
    const struct can_frame beat = can_frame_heartbeat(node, awaited);
    for (struct can_frame f = {0}; f.can_id != beat.can_id || f.data[0] != beat.data[0];)
        if (!take(w->plant[OURS], &f)) sched_yield();
}

static double length_m(struct world *w, int64_t now_ns) {
    struct hal_sample s = {0};
    device_latch(w->device, now_ns, &s);
    return s.length_m[0];
}

/* Nobody sends a SYNC any more; with the device's own watchdog alone the machine would move for a
 * second. */
static void nodes_out_of_operational_centre_their_valves_without_a_sync(void **state) {
    slow_case();
    struct world *w = *state;
    const struct can_frame out = can_frame_nmt(NMT_PREOPERATIONAL, 0);
    pump(w, true);
    for (int i = 0; i < 20; i++) cycle(w, 0.5);
    halt_bus(w);
    give(w->plant[OURS], &out);
    await_state(w, 1, CAN_PREOPERATIONAL);
    atomic_store(&w->device_stop, true);
    pthread_join(w->device_thread, NULL);
    int64_t now_ns = monotonic_ns();
    double closed_m = length_m(w, now_ns += NS_PER_S / 50); /* the valve closes */
    double moved_m = length_m(w, now_ns + NS_PER_S / 20) - closed_m;
    atomic_store(&w->device_stop, false);
    assert_int_equal(pthread_create(&w->device_thread, NULL, device_run, w), 0);
    assert_below(fabs(moved_m), 1e-3);
}

static void its_end_takes_the_nodes_out_of_operational(void **state) {
    enum { SIZE = 64 };
    struct world *w = *state;
    struct can_frame frames[SIZE], last = can_frame_nmt(NMT_PREOPERATIONAL, 0);
    bool told = false;
    cycle(w, 0.5);
    halt_bus(w);
    hal_can.close(w->hal);
    w->hal = NULL;
    int count = frames_in_queue(w, frames, SIZE);
    for (int i = 0; i < count; i++)
        told |= frames[i].can_id == last.can_id && frames[i].len == last.len && !memcmp(frames[i].data, last.data, last.len);
    assert_true(told);
}

/* hexid does not start, and sends nothing, if it receives any of another master's frames. */
static void another_master_on_the_bus_is_not_disturbed_by_a_start(void **state) {
    const struct can_frame theirs[] = {can_frame_sync(), can_frame_rpdo(1, (int16_t[]){0, 0, 0}), can_frame_nmt(NMT_START, 0),
                                       can_frame_heartbeat(CAN_MASTER, CAN_OPERATIONAL)};
    static const char *const words[] = {"SYNC (0x080)", "RPDO (0x204)", "NMT command (0x000)", "heartbeat of a master (0x77f)"};
    (void)state;
    marking = true;
    for (unsigned i = 0; i < sizeof theirs / sizeof *theirs; i++) {
        struct params params;
        struct error error = {0};
        struct hal *hal;
        struct can_frame sent;
        int bus[2];
        char name[12];
        config_default(&params);
        assert_int_equal(socketpair(AF_UNIX, SOCK_SEQPACKET, 0, bus), 0);
        snprintf(name, sizeof name, "%d", bus[THEIRS]);
        give(bus[OURS], &theirs[i]);
        assert_int_equal(hal_can.open(&hal, name, &params, 1, &error), STATUS_UNSAFE);
        assert_non_null(strstr(error.text, words[i]));
        assert_false(take(bus[OURS], &sent));
        close(bus[OURS]), close(bus[THEIRS]);
    }
    marking = false;
}

static void a_watchdog_longer_than_a_node_takes_is_refused(void **state) {
    struct params params;
    struct error error = {0};
    struct hal *hal;
    (void)state;
    config_default(&params);
    params.device.watchdog_s = 1.001;
    assert_int_equal(hal_can.open(&hal, "0", &params, 1, &error), STATUS_USAGE);
    assert_non_null(strstr(error.text, "device.watchdog_s 1.001"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(commands_through_the_whole_back_end_move_the_legs_behind_the_whole_device, start_slow, end),
        cmocka_unit_test_setup_teardown(the_supply_is_there_while_its_output_changes_and_the_inputs_say_so, start_slow, end),
        cmocka_unit_test_setup_teardown(a_bus_that_stands_still_is_given_three_cycles_and_then_the_centre_only, start_slow, end),
        cmocka_unit_test_setup_teardown(a_full_transmit_queue_fails_the_write_and_is_got_over, start_slow, end),
        cmocka_unit_test_setup_teardown(bus_off_invalidates_samples_and_refuses_commands_until_the_bus_carries_again, start_slow, end),
        cmocka_unit_test_setup_teardown(error_passive_is_told_and_commands_go_on, start, end),
        cmocka_unit_test_setup_teardown(a_clock_that_is_set_back_makes_no_twin, start, end),
        cmocka_unit_test(a_frame_came_neither_in_the_future_nor_before_the_last_one),
        cmocka_unit_test_setup_teardown(nodes_out_of_operational_centre_their_valves_without_a_sync, start_slow, end),
        cmocka_unit_test_setup_teardown(its_end_takes_the_nodes_out_of_operational, start, end),
        cmocka_unit_test(another_master_on_the_bus_is_not_disturbed_by_a_start),
        cmocka_unit_test(a_watchdog_longer_than_a_node_takes_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
