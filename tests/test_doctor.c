/* doctor's findings on computers that are not available: /proc and /sys are files in a
 * directory, and measurements are given. Each WARN and FAIL of each check occurs once and states
 * its remedy. */
#include "support.h"

#include <arpa/inet.h>
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bus.h"
#include "can_controller.h"
#include "doctor.h"
#include "machine_lock.h"
#include "kinematics.h"
#include "units.h"
#include "wakeup.h"

#define CPU "/sys/devices/system/cpu"

static char root[] = "/tmp/doctor.XXXXXX";
static struct params params;
static struct doctor simulated, machine; /* the same computer; only the back-ends differ */
static bool deaf;                        /* nothing is received */

int __real_bus_receive(struct bus *bus, struct bus_message *message);
int __wrap_bus_receive(struct bus *bus, struct bus_message *message);
int __wrap_bus_receive(struct bus *bus, struct bus_message *message) {
    int got = __real_bus_receive(bus, message);
    return deaf && got == 1 ? BUS_DROPPED : got;
}

static int begin(void **unused) {
    (void)unused;
    char command[200];
    snprintf(command, sizeof command, "rm -rf %s && mkdir -p %s%s", root, root, CPU);
    config_default(&params);
    simulated = (struct doctor){.params = &params, .url = "sim:", .log = root, .root = root};
    machine = simulated;
    machine.machine = true;
    deaf = false;
    return system(command);
}

static void put(const char *path, const char *text) {
    char whole[300], command[400];
    snprintf(whole, sizeof whole, "%s%s", root, path);
    snprintf(command, sizeof command, "mkdir -p $(dirname %s)", whole);
    assert_int_equal(system(command), 0);
    FILE *file = fopen(whole, "w");
    assert_non_null(file);
    assert_true(fprintf(file, "%s\n", text) > 0);
    assert_int_equal(fclose(file), 0);
}

static void is(struct finding f, enum level level, const char *word) {
    json_decref(f.data);
    if (f.level != level || !strstr(f.found, word)) fail_msg("level %d, not %d with \"%s\": %s", (int)f.level, (int)level, word, f.found);
    if (level > LEVEL_OK && !*f.remedy) fail_msg("no remedy: %s", f.found);
    if (level <= LEVEL_OK && *f.remedy) fail_msg("a remedy for what is well: %s", f.found);
}

/* ---- this computer ---- */

static void a_kernel_without_preempt_rt_is_warned_of(void **unused) {
    (void)unused;
    is(check_kernel(&machine), LEVEL_UNKNOWN, "/proc/version");
    put("/proc/version", "Linux version 6.1.0-13-rt-amd64 (gcc) #1 SMP PREEMPT_RT Debian");
    is(check_kernel(&machine), LEVEL_OK, "6.1.0-13-rt-amd64 with");
    put("/proc/version", "Linux version 6.1.0-13-amd64 (gcc) #1 SMP PREEMPT_DYNAMIC Debian");
    is(check_kernel(&machine), LEVEL_WARN, "without PREEMPT_RT");
}

static void a_virtual_machine_is_warned_of_with_what_its_host_took(void **unused) {
    (void)unused;
    is(check_hypervisor(&machine), LEVEL_UNKNOWN, "/proc/cpuinfo");
    put("/proc/cpuinfo", "processor\t: 0\nflags\t\t: fpu tsc\nbugs\t\t: spectre_v1");
    is(check_hypervisor(&machine), LEVEL_OK, "none");
    put("/proc/cpuinfo", "processor\t: 0\nflags\t\t: fpu hypervisor tsc\n");
    is(check_hypervisor(&machine), LEVEL_WARN, "when it likes");
    put("/proc/stat", "cpu  100 0 100 700 0 0 0 100 0 0\ncpu0 1 1 1 1 1 1 1 1 1 1");
    is(check_hypervisor(&machine), LEVEL_WARN, "10 % of the time");
}

static void too_little_locked_memory_is_refused_behind_hardware(void **unused) {
    (void)unused;
    static const char header[] = "Limit                     Soft Limit           Hard Limit           Units\n";
    char limits[300];
    is(check_locked_memory(&machine), LEVEL_UNKNOWN, "/proc/self");
    put("/proc/self/status", "Name:\thexid\nCapEff:\t0000000000000000\nCapBnd:\t000001ffffffffff");
    snprintf(limits, sizeof limits, "%sMax locked memory         8388608              8388608              bytes", header);
    put("/proc/self/limits", limits);
    is(check_locked_memory(&machine), LEVEL_FAIL, "8 MB allowed");
    is(check_locked_memory(&simulated), LEVEL_WARN, "8 MB allowed");
    snprintf(limits, sizeof limits, "%sMax locked memory         200000000            200000000            bytes", header);
    put("/proc/self/limits", limits);
    is(check_locked_memory(&machine), LEVEL_OK, "200 MB allowed");
    struct params fast = *machine.params;
    struct doctor of_fast = machine;
    fast.loop.period_s = 1e-4, of_fast.params = &fast; /* the ring holds 262144 cycles */
    is(check_locked_memory(&of_fast), LEVEL_FAIL, "200 MB allowed");
    snprintf(limits, sizeof limits, "%sMax locked memory         unlimited            unlimited            bytes", header);
    put("/proc/self/limits", limits);
    is(check_locked_memory(&machine), LEVEL_OK, "without a limit");
    put("/proc/self/limits", "Max locked memory         8388608              8388608              bytes");
    put("/proc/self/status", "Name:\thexid\nCapEff:\t0000000000004000"); /* CAP_IPC_LOCK alone */
    is(check_locked_memory(&machine), LEVEL_OK, "CAP_IPC_LOCK");
}

/* The check runs in a process of its own without privileges. */
static void without_its_rights_real_time_is_refused_behind_hardware(void **unused) {
    (void)unused;
    const struct rlimit none = {0};
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) {
        bool dropped = !setrlimit(RLIMIT_RTPRIO, &none) && (geteuid() != 0 || (!setgid(65534) && !setuid(65534)));
        struct finding hard = check_realtime(&machine), soft = check_realtime(&simulated);
        _exit(!dropped ? 2
              : hard.level == LEVEL_FAIL && soft.level == LEVEL_WARN && strstr(hard.found, "SCHED_FIFO") && strstr(hard.remedy, "rtprio")
                  ? 0
                  : 1);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 2) skip_because("this user cannot give its rights up");
    assert_int_equal(status, 0);
}

static void a_governor_that_saves_power_is_warned_of(void **unused) {
    (void)unused;
    put(CPU "/online", "0-1");
    is(check_governor(&machine), LEVEL_UNKNOWN, "cpufreq");
    put(CPU "/cpu0/cpufreq/scaling_governor", "performance");
    put(CPU "/cpu1/cpufreq/scaling_governor", "performance");
    is(check_governor(&machine), LEVEL_OK, "performance on 2");
    put(CPU "/cpu1/cpufreq/scaling_governor", "powersave");
    is(check_governor(&machine), LEVEL_WARN, "powersave on 1 of 2");
    params.loop.cpu = 0; /* only the governor of the loop's processor matters */
    is(check_governor(&machine), LEVEL_OK, "performance on 1 processor");
}

static void deep_sleep_is_warned_of_unless_it_is_off(void **unused) {
    (void)unused;
    put(CPU "/online", "0");
    is(check_idle_states(&machine), LEVEL_UNKNOWN, "cpuidle");
    put(CPU "/cpu0/cpuidle/state0/latency", "0"), put(CPU "/cpu0/cpuidle/state0/name", "POLL");
    put(CPU "/cpu0/cpuidle/state1/latency", "33"), put(CPU "/cpu0/cpuidle/state1/name", "C1E");
    is(check_idle_states(&machine), LEVEL_OK, "C1E, is left in 33 us");
    put(CPU "/cpu0/cpuidle/state2/latency", "133"), put(CPU "/cpu0/cpuidle/state2/name", "C6"),
        put(CPU "/cpu0/cpuidle/state2/disable", "0");
    is(check_idle_states(&machine), LEVEL_WARN, "C6, is left in 133 us");
    put(CPU "/cpu0/cpuidle/state2/disable", "1");
    is(check_idle_states(&machine), LEVEL_OK, "C1E");
}

static void a_loop_without_a_processor_of_its_own_is_warned_of(void **unused) {
    (void)unused;
    is(check_isolation(&machine), LEVEL_UNKNOWN, "online");
    put(CPU "/online", "0-3");
    is(check_isolation(&machine), LEVEL_WARN, "loop.cpu -1");
    const char *online[] = {"0-3", "0-1", "0"},
               *remedy[] = {"isolcpus=3", "isolcpus=1 nohz_full=1 rcu_nocbs=1 irqaffinity=0 ", "this has one"};
    for (int i = 0; i < 3; i++) {
        put(CPU "/online", online[i]);
        struct finding f = check_isolation(&machine);
        assert_non_null(strstr(f.remedy, remedy[i]));
        json_decref(f.data);
    }
    put(CPU "/online", "0-3");
    put(CPU "/isolated", "2-3");
    is(check_isolation(&machine), LEVEL_WARN, "isolated are 2-3");
    params.loop.cpu = 3;
    is(check_isolation(&machine), LEVEL_OK, "3 is isolated");
    params.loop.cpu = 1;
    is(check_isolation(&machine), LEVEL_WARN, "1 is not isolated");
    params.loop.cpu = 4;
    is(check_isolation(&machine), LEVEL_FAIL, "4 is not there");
    is(check_isolation(&simulated), LEVEL_WARN, "4 is not there");
}

static void a_core_that_is_shared_is_warned_of(void **unused) {
    (void)unused;
    is(check_siblings(&machine), LEVEL_NONE, "");
    params.loop.cpu = 3;
    is(check_siblings(&machine), LEVEL_UNKNOWN, "topology");
    put(CPU "/cpu3/topology/thread_siblings_list", "1,3");
    put(CPU "/isolated", "3");
    is(check_siblings(&machine), LEVEL_WARN, "3 shares its core with 1");
    put(CPU "/isolated", "1,3");
    is(check_siblings(&machine), LEVEL_OK, "nobody else");
}

static void heat_and_a_small_share_for_real_time_threads_are_warned_of(void **unused) {
    (void)unused;
    put(CPU "/online", "0-1");
    is(check_throttling(&machine), LEVEL_UNKNOWN, "thermal_throttle");
    put(CPU "/cpu0/thermal_throttle/core_throttle_count", "0");
    put(CPU "/cpu1/thermal_throttle/core_throttle_count", "0");
    put("/proc/sys/kernel/sched_rt_runtime_us", "950000"), put("/proc/sys/kernel/sched_rt_period_us", "1000000");
    is(check_throttling(&machine), LEVEL_OK, "no processor");
    put(CPU "/cpu1/thermal_throttle/core_throttle_count", "17");
    is(check_throttling(&machine), LEVEL_WARN, "17 times");
    put("/proc/sys/kernel/sched_rt_runtime_us", "500000");
    is(check_throttling(&machine), LEVEL_WARN, "500000 of 1000000");
    put("/proc/sys/kernel/sched_rt_runtime_us", "-1"); /* unlimited */
    put(CPU "/cpu1/thermal_throttle/core_throttle_count", "0");
    is(check_throttling(&machine), LEVEL_OK, "no processor");
}

static void a_slow_clock_is_warned_of(void **unused) {
    (void)unused;
    static const char path[] = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
    is(check_clock_source(&machine), LEVEL_UNKNOWN, path);
    put(path, "tsc");
    is(check_clock_source(&machine), LEVEL_OK, "tsc");
    put(path, "hpet");
    is(check_clock_source(&machine), LEVEL_WARN, "hpet");
}

/* ---- wake-ups ---- */

static struct wakeups wakeups(int count, int late_count, int64_t late_ns) {
    struct wakeups w = {0};
    for (int i = 0; i < count; i++) wakeups_add(&w, i < late_count ? late_ns : 30 * NS_PER_US, 2000 * NS_PER_US);
    return w;
}

static void wake_ups_are_judged_by_the_deadline_of_the_loop(void **unused) {
    (void)unused;
    /* 50 of 5000 wake-ups are late by a microsecond less than half a period */
    struct wakeups good = wakeups(5000, 50, 999 * NS_PER_US);
    is(judge_wakeups(&machine, &good), LEVEL_OK, "p50 3");
    assert_int_equal(good.half, 0);
    /* 51 late ones are more than checks.excluded_pct, 1 % */
    struct wakeups late = wakeups(5000, 51, 1000 * NS_PER_US);
    is(judge_wakeups(&machine, &late), LEVEL_WARN, "half a period late");
    struct wakeups missed = wakeups(5000, 1, 2500 * NS_PER_US);
    missed.missed = missed.missed_in_row = 1;
    is(judge_wakeups(&machine, &missed), LEVEL_WARN, "1 deadline missed");
    missed.missed = missed.missed_in_row = params.loop.overrun_limit;
    is(judge_wakeups(&machine, &missed), LEVEL_FAIL, "the fault `overrun`");
    is(judge_wakeups(&simulated, &missed), LEVEL_WARN, "time stretches");
}

static void the_histogram_counts_every_wake_up_once(void **unused) {
    (void)unused;
    struct wakeups w;
    struct error error;
    assert_int_equal(wakeups_measure(&params.loop, 0.2, &w, &error), STATUS_OK);
    int64_t sum = 0, deadlines = 99; /* deadlines at 2, 4, ..., 198 ms */
    for (int i = 0; i <= WAKEUP_EDGES; i++) sum += w.count[i];
    assert_int_equal(sum, w.late.count);
    /* every deadline is met or missed, however slow this host is */
    assert_true(sum <= deadlines && sum + w.missed >= deadlines);
    assert_true(w.missed_in_row <= w.missed && (w.missed == 0) == (w.missed_in_row == 0));
    simulated.latency_s = 0.001;
    is(check_wakeups(&simulated), LEVEL_UNKNOWN, "not one wake-up");
    simulated.latency_s = 0.0;
    is(check_wakeups(&simulated), LEVEL_NONE, "");
}

static void an_edge_belongs_to_the_bin_above_it(void **unused) {
    (void)unused;
    struct wakeups w = {0};
    wakeups_add(&w, 0, NS_PER_S);
    wakeups_add(&w, 1000, NS_PER_S);
    wakeups_add(&w, 1999, NS_PER_S);
    wakeups_add(&w, 2000, NS_PER_S);
    wakeups_add(&w, 100 * 1000 * 1000, NS_PER_S);
    assert_int_equal(w.count[0], 1);
    assert_int_equal(w.count[1], 2);
    assert_int_equal(w.count[2], 1);
    assert_int_equal(w.count[WAKEUP_EDGES], 1);
}

/* ---- LCM ---- */

static bool own_network(void) { return !unshare(CLONE_NEWNET) || !unshare(CLONE_NEWUSER | CLONE_NEWNET); }

static void lcm_is_followed_step_by_step(void **unused) {
    (void)unused;
    slow_case();
    if (!own_network()) skip_because("this system allows no network namespace");
    snprintf(params.lcm.url, sizeof params.lcm.url, "udpm://239.255.76.67:7667?ttl=0");
    is(check_lcm_socket(&machine), LEVEL_FAIL, "no route for multicast");
    is(check_lcm_route(&machine), LEVEL_NONE, "");
    is(check_lcm_datagram(&machine), LEVEL_NONE, "");
    assert_int_equal(system("ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo"), 0);
    is(check_lcm_socket(&machine), LEVEL_OK, "sends and listens");
    is(check_lcm_route(&machine), LEVEL_OK, "by lo, ttl 0");
    is(check_lcm_datagram(&machine), LEVEL_OK, "received");
    deaf = true;
    is(check_lcm_datagram(&machine), LEVEL_FAIL, "did not come back");
    snprintf(params.lcm.url, sizeof params.lcm.url, "udpm://239.255.76.67:7667?ttl=1");
    is(check_lcm_route(&machine), LEVEL_WARN, "does not leave this host");
    params.lcm.url[0] = '\0';
    is(check_lcm_socket(&machine), LEVEL_OK, "none");
    is(check_lcm_route(&machine), LEVEL_NONE, "");
    is(check_lcm_datagram(&machine), LEVEL_NONE, "");
    is(check_lcm_buffers(&machine), LEVEL_NONE, "");
    snprintf(params.lcm.url, sizeof params.lcm.url, "udpm://239.255.76.67:7667?ttl=0");
    bool other = !system("{ ip link add d0 type dummy || ip tuntap add d0 mode tap; } 2>/dev/null && ip link set d0 up && "
                         "ip addr add 192.0.2.1/24 dev d0");
    if (!other) skip_because("this kernel has no second interface to route to");
    /* a route by lo hides the messages of a network's other hosts */
    struct finding f = check_lcm_route(&machine);
    assert_int_equal(f.level, LEVEL_WARN);
    assert_string_equal(f.remedy, "sudo ip route replace 224.0.0.0/4 dev d0");
    json_decref(f.data);
    assert_int_equal(system("ip route del 224.0.0.0/4 dev lo"), 0);
    f = check_lcm_socket(&machine); /* where there is a network, the route by lo is not
                                     * recommended */
    assert_int_equal(f.level, LEVEL_FAIL);
    assert_null(strstr(f.remedy, "dev lo"));
    assert_int_equal(system("ip route add 224.0.0.0/4 dev d0"), 0);
    is(check_lcm_route(&machine), LEVEL_OK, "commands do not need it");
    snprintf(params.lcm.url, sizeof params.lcm.url, "udpm://239.255.76.67:7667?ttl=1");
    is(check_lcm_route(&machine), LEVEL_OK, "reaches other hosts");
}

static void small_receive_buffers_are_warned_of(void **unused) {
    (void)unused;
    is(check_lcm_buffers(&machine), LEVEL_UNKNOWN, "rmem_max");
    put("/proc/sys/net/core/rmem_max", "212992");
    is(check_lcm_buffers(&machine), LEVEL_WARN, "212992 bytes");
    put("/proc/sys/net/core/rmem_max", "2097152");
    is(check_lcm_buffers(&machine), LEVEL_OK, "2097152 bytes");
}

/* ---- CAN ---- */

static void a_bus_that_is_too_full_fails_where_it_is_driven(void **unused) {
    (void)unused;
    is(check_can_load(&machine), LEVEL_OK, "62.3 %");
    params.loop.period_s = 0.001;
    is(check_can_load(&machine), LEVEL_WARN, "at most 80 %");
    machine.url = "can:can0";
    is(check_can_load(&machine), LEVEL_FAIL, "at most 80 %");
}

static void a_can_interface_must_be_there_with_the_bit_rate_of_the_nodes(void **unused) {
    (void)unused;
    struct can_controller c = {.kind = "vcan"};
    is(check_can_interface(&machine), LEVEL_NONE, "");
    machine.url = "can:none9";
    is(check_can_interface(&machine), LEVEL_FAIL, "no such interface");
    is(check_can_errors(&machine), LEVEL_NONE, "");
    machine.url = "can:lo";
    is(check_can_interface(&machine), LEVEL_FAIL, "not a CAN interface");
    is(judge_can_interface(&machine, "vcan0", &c), LEVEL_OK, "vcan has no controller");
    c = (struct can_controller){.kind = "can", .known = true};
    is(judge_can_interface(&machine, "can0", &c), LEVEL_UNKNOWN, "does not tell");
    c.bitrate_bps = 1000000, c.sample_point = 0.75;
    is(judge_can_interface(&machine, "can0", &c), LEVEL_OK, "1000000 bit/s, sample point 75.0 %");
    c.bitrate_bps = 500000;
    is(judge_can_interface(&machine, "can0", &c), LEVEL_FAIL, "500000 bit/s, can.bitrate_bps is 1000000");
}

static void can_errors_are_warned_of_and_a_controller_off_the_bus_fails(void **unused) {
    (void)unused;
    const struct can_controller good = {.kind = "can", .known = true, .counts = true};
    struct can_controller c = good;
    is(judge_can_errors("can0", &good, &c), LEVEL_OK, "error-active, TEC 0, REC 0");
    c.arbitration_lost = 9; /* normal when two nodes start sending at the same time */
    is(judge_can_errors("can0", &good, &c), LEVEL_OK, "arbitration lost 9 times");
    c = good, c.tx_errors = 8;
    is(judge_can_errors("can0", &good, &c), LEVEL_WARN, "TEC 8, REC 0");
    c = good, c.rx_errors = 1;
    is(judge_can_errors("can0", &good, &c), LEVEL_WARN, "TEC 0, REC 1");
    c = good, c.state = CAN_STATE_ERROR_WARNING;
    is(judge_can_errors("can0", &good, &c), LEVEL_WARN, "error-warning");
    c.state = CAN_STATE_ERROR_PASSIVE;
    is(judge_can_errors("can0", &good, &c), LEVEL_WARN, "error-passive");
    c = good, c.bus_offs = 1;
    is(judge_can_errors("can0", &good, &c), LEVEL_WARN, "1 bus-off");
    is(judge_can_errors("can0", &c, &c), LEVEL_OK,
       "0 errors within a second; since it was made 0 bus errors, 0 times error-warning, 0 "
       "error-passive, 1 bus-off"); /* long ago */
    c = good, c.state = CAN_STATE_BUS_OFF;
    is(judge_can_errors("can0", &good, &c), LEVEL_FAIL, "bus-off");
    c.state = CAN_STATE_STOPPED;
    is(judge_can_errors("can0", &good, &c), LEVEL_FAIL, "stopped");
    c = (struct can_controller){.kind = "vcan"};
    is(judge_can_errors("vcan0", &c, &c), LEVEL_NONE, "");
}

struct message {
    _Alignas(struct nlmsghdr) unsigned char bytes[1024];
    size_t size;
};

static size_t attribute(struct message *m, unsigned short type, const void *value, size_t size) {
    struct rtattr a = {.rta_len = (unsigned short)(sizeof a + size), .rta_type = type};
    size_t at = m->size;
    memcpy(m->bytes + at, &a, sizeof a);
    if (size) memcpy(m->bytes + at + sizeof a, value, size);
    m->size += RTA_ALIGN(a.rta_len);
    return at;
}

static void end_nested(struct message *m, size_t at) {
    unsigned short length = (unsigned short)(m->size - at);
    memcpy(m->bytes + at, &length, sizeof length);
}

/* Makes a message as the kernel does: nested attributes, and the statistics next to them. */
static struct message of_controller(const char *kind) {
    struct message m = {.size = NLMSG_SPACE(sizeof(struct ifinfomsg))};
    const struct can_bittiming timing = {.bitrate = 1000000, .sample_point = 750};
    const struct can_berr_counter counter = {.txerr = 136, .rxerr = 3};
    const struct can_device_stats statistics = {
        .bus_error = 1, .error_warning = 2, .error_passive = 3, .bus_off = 4, .arbitration_lost = 5, .restarts = 6};
    const struct rtnl_link_stats64 link = {.rx_dropped = 7, .tx_dropped = 8};
    const uint32_t state = CAN_STATE_ERROR_PASSIVE;
    attribute(&m, IFLA_IFNAME, "can0", 5);
    attribute(&m, IFLA_STATS64, &link, sizeof link);
    size_t info = attribute(&m, IFLA_LINKINFO, NULL, 0);
    attribute(&m, IFLA_INFO_KIND, kind, strlen(kind) + 1);
    attribute(&m, IFLA_INFO_XSTATS, &statistics, sizeof statistics);
    size_t data = attribute(&m, IFLA_INFO_DATA | NLA_F_NESTED, NULL, 0);
    attribute(&m, IFLA_CAN_BITTIMING, &timing, sizeof timing);
    attribute(&m, IFLA_CAN_STATE, &state, sizeof state);
    attribute(&m, IFLA_CAN_BERR_COUNTER, &counter, sizeof counter);
    end_nested(&m, data);
    end_nested(&m, info);
    struct nlmsghdr header = {.nlmsg_len = (uint32_t)m.size, .nlmsg_type = RTM_NEWLINK};
    memcpy(m.bytes, &header, sizeof header);
    return m;
}

static void the_kernels_answer_is_read_member_by_member(void **unused) {
    (void)unused;
    struct message m = of_controller("can");
    struct can_controller c;
    assert_true(can_controller_parse(m.bytes, m.size, &c));
    assert_true(c.known && c.counts && !strcmp(c.kind, "can") && c.state == CAN_STATE_ERROR_PASSIVE);
    assert_true(c.bitrate_bps == 1000000 && c.tx_errors == 136 && c.rx_errors == 3);
    assert_close(c.sample_point, 0.75, 1e-12);
    assert_true(c.bus_errors == 1 && c.warnings == 2 && c.passives == 3 && c.bus_offs == 4 && c.arbitration_lost == 5 && c.restarts == 6);
    assert_true(c.rx_dropped == 7 && c.tx_dropped == 8);
    m = of_controller("vxcan"); /* these attributes of a vxcan have another meaning */
    assert_true(can_controller_parse(m.bytes, m.size, &c));
    assert_true(!c.known && !c.bitrate_bps && !strcmp(c.kind, "vxcan"));
}

static void a_damaged_answer_is_read_no_further_than_it_goes(void **unused) {
    (void)unused;
    const struct message whole = of_controller("can");
    struct can_controller c;
    for (size_t size = 0; size < whole.size; size++) {
        unsigned char *part = malloc(size ? size : 1); /* a buffer of the exact size, in which a
                                                        * sanitizer detects an overrun */
        memcpy(part, whole.bytes, size);
        assert_false(can_controller_parse(part, size, &c)); /* truncated */
        free(part);
    }
    uint64_t seed = 1;
    for (int i = 0; i < 20000; i++) {
        struct message m = whole;
        for (int n = random_below(&seed, 4); n >= 0; n--)
            m.bytes[sizeof(struct nlmsghdr) + (size_t)random_below(&seed, (int)(m.size - sizeof(struct nlmsghdr)))] = (unsigned char)
                random_below(&seed, 256);
        can_controller_parse(m.bytes, m.size, &c);
        assert_true(memchr(c.kind, '\0', sizeof c.kind) != NULL);
    }
}

/* ---- Modbus ---- */

static void a_serial_line_must_be_fast_enough(void **unused) {
    (void)unused;
    is(check_modbus_line(&machine), LEVEL_OK, "8.9 ms at 115200 baud");
    machine.url = "modbus:rtu:/dev/ttyS0?baud=115200";
    is(check_modbus_line(&machine), LEVEL_FAIL, "on this line 8.9 ms");
    machine.url = "modbus:rtu:/dev/ttyS0?baud=4000000";
    is(check_modbus_line(&machine), LEVEL_OK, "on this line 0.3 ms");
    machine.url = "modbus:somewhere";
    is(check_modbus_line(&machine), LEVEL_FAIL, "modbus:tcp://HOST:PORT");
    is(check_modbus(&machine), LEVEL_NONE, "");
}

static void round_trips_are_judged_by_cycle_and_time_out(void **unused) {
    (void)unused;
    struct round_trips r = {.median_s = 0.3e-3, .max_s = 1e-3};
    is(judge_round_trips(&machine, &r), LEVEL_OK, "0.30 ms, at most 1.00 (50 of 50");
    r.owned = true;
    is(judge_round_trips(&machine, &r), LEVEL_WARN, "another master");
    r.owned = false, r.lost = 1;
    is(judge_round_trips(&machine, &r), LEVEL_WARN, "answers are lost");
    r.lost = ROUND_TRIPS / 2 + 1;
    is(judge_round_trips(&machine, &r), LEVEL_FAIL, "too old");
    r.lost = 0, r.median_s = 0.95 * params.loop.period_s;
    is(judge_round_trips(&machine, &r), LEVEL_WARN, "too slow for every cycle");
    r.median_s = 1.1 * params.limits.sensor_age_s;
    is(judge_round_trips(&machine, &r), LEVEL_FAIL, "too old");
}

/* The port is taken, but nobody listens on it. */
static void a_device_that_does_not_answer_fails_and_one_that_is_driven_is_not_asked(void **unused) {
    (void)unused;
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t length = sizeof address;
    char url[64];
    struct error error;
    int s = socket(AF_INET, SOCK_STREAM, 0);
    assert_int_equal(bind(s, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(getsockname(s, (struct sockaddr *)&address, &length), 0);
    snprintf(url, sizeof url, "modbus:tcp://127.0.0.1:%d", ntohs(address.sin_port));
    machine.url = url;
    is(check_modbus(&machine), LEVEL_FAIL, "127.0.0.1");
    struct machine_lock lock; /* stands for the lock of a running hexid */
    assert_int_equal(machine_lock(&lock, url, &error), STATUS_OK);
    is(check_modbus(&machine), LEVEL_UNKNOWN, "not asked: ");
    machine_unlock(&lock);
    close(s);
}

/* ---- disk ---- */

static void a_log_needs_room_for_its_run(void **unused) {
    (void)unused;
    double rate = log_bytes_per_s(&params);
    /* docs/service.md has 457 bytes per cycle, which includes other events */
    assert_close(rate * params.loop.period_s, 450.0, 50.0);
    struct disk k = {.directory = "/logs", .room_bytes = rate * 3601.0};
    is(judge_log_room(&machine, &k), LEVEL_OK, "1 hours");
    k.room_bytes = rate * 3540.0;
    is(judge_log_room(&machine, &k), LEVEL_WARN, "full after 59 minutes");
    k.room_bytes = rate * 20.0;
    is(judge_log_room(&machine, &k), LEVEL_FAIL, "the log of the configured tests");
    is(check_log_room(&machine), LEVEL_OK, root);
    machine.log = "/nowhere/a.lcm";
    is(check_log_room(&machine), LEVEL_FAIL, "/nowhere");
    is(check_log_speed(&machine), LEVEL_NONE, "");
}

static void a_slow_disk_is_warned_of_and_one_that_hangs_fails(void **unused) {
    (void)unused;
    double rate = log_bytes_per_s(&params);
    struct disk k = {.speed_bytes_per_s = 100e6, .longest_s = 0.1};
    is(judge_log_speed(&machine, &k), LEVEL_OK, "100 MB/s");
    k.longest_s = 0.6;
    is(judge_log_speed(&machine, &k), LEVEL_WARN, "longest write 600 ms");
    k.longest_s = 2.1;
    is(judge_log_speed(&machine, &k), LEVEL_FAIL, "hangs");
    k.longest_s = 0.1, k.speed_bytes_per_s = 9.0 * rate;
    is(judge_log_speed(&machine, &k), LEVEL_WARN, "slow");
    k.speed_bytes_per_s = 0.9 * rate;
    is(judge_log_speed(&machine, &k), LEVEL_FAIL, "too slow");
}

static void a_disk_that_takes_nothing_fails(void **unused) {
    (void)unused;
    struct rlimit before;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &(struct rlimit){4096, before.rlim_max}), 0);
    struct finding f = check_log_speed(&machine);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    is(f, LEVEL_FAIL, "cannot be written");
}

/* ---- configuration ---- */

static void a_configuration_that_is_no_machine_fails(void **unused) {
    (void)unused;
    is(check_kinematics(&machine), LEVEL_OK, "neutral lengths 1.8310");
    is(check_workspace(&machine), LEVEL_OK, "condition 3.18");
    all_legs(params.actuator.mid_stroke_m, 5.0);
    is(check_kinematics(&machine), LEVEL_FAIL, "actuator.mid_stroke_m");
    is(check_workspace(&machine), LEVEL_NONE, "");
}

/* Two upper joints are exchanged; then all lower ones are shifted by one leg. */
static void joints_in_another_order_are_found(void **unused) {
    (void)unused;
    struct kinematics k;
    const double h = params.payload.center_height_m, height = h + params.geometry.height_m;
    kinematics_place(&k, &params);
    params.geometry.upper.given = params.geometry.lower.given = true;
    for (int further = 0; further < 3; further++) {
        for (int i = 0; i < LEGS; i++)
            for (int r = 0; r < 3; r++) {
                params.geometry.upper.leg[further == 1 ? i ^ 1 : i][r] = k.upper[i][r] - (r == 2 ? h : 0.0);
                params.geometry.lower.leg[further == 2 ? (i + 5) % LEGS : i][r] = k.lower[i][r] - (r == 2 ? height : 0.0);
            }
        is(check_kinematics(&machine), further == 1 ? LEVEL_FAIL : LEVEL_OK, further == 1 ? "legs 1 and 2 go through" : "neutral");
        is(check_workspace(&machine), further == 2 ? LEVEL_WARN : further ? LEVEL_NONE : LEVEL_OK, further == 1 ? "" : "singular pose");
    }
}

static void limits_that_nothing_reaches_are_warned_of(void **unused) {
    (void)unused;
    is(check_strokes(&machine), LEVEL_OK, "limits 1.425 to 2.24");
    params.limits.length_max_m[3] = 2.4;
    is(check_strokes(&machine), LEVEL_WARN, "leg 4");
}

static void a_payload_in_tonnes_is_warned_of(void **unused) {
    (void)unused;
    is(check_payload(&machine), LEVEL_OK, "178.6 kg");
    params.payload.mass_kg *= 1e-3;
    is(check_payload(&machine), LEVEL_WARN, "gyration 8.7");
    params.payload.mass_kg *= 1e6;
    is(check_payload(&machine), LEVEL_WARN, "gyration 0.0087");
}

static void tests_that_the_legs_cannot_make_fail(void **unused) {
    (void)unused;
    slow_case();
    is(check_tests(&machine), LEVEL_OK, "6, within the limits");
    double tank_pa = params.hydraulics.tank_pa;
    params.hydraulics.tank_pa = 1e6; /* such a tank pressure lifts the platform without any
                                      * command */
    is(check_tests(&machine), LEVEL_OK, "6, within the limits"); /* is not run */
    is(check_tests(&simulated), LEVEL_FAIL, "hydraulics.tank_pa");
    params.hydraulics.tank_pa = tank_pa;
    params.mechanism = MECHANISM_AXIS;
    is(check_machine(&machine), LEVEL_OK, "a single axis");
    is(check_cylinders(&machine), LEVEL_OK, "31.17 cm^2 on the rodless side, 15.27 cm^2 on the rod side");
    params.actuator.stated.rod = false;
    is(check_cylinders(&machine), LEVEL_WARN, "actuator.rod_diameter_m");
    params.actuator.stated.piston = false;
    is(check_cylinders(&machine), LEVEL_OK, "no diameters");
    params.actuator.stated.piston = params.actuator.stated.rod = true;
    is(check_cylinders(&machine), LEVEL_OK, "as in the default configuration: hydraulics.supply_pa 10e6");
    is(check_tests(&machine), LEVEL_NONE, "");
    is(check_can_load(&machine), LEVEL_NONE, "");
    params.mechanism = MECHANISM_STEWART;
    for (int i = 0; i < DOFS; i++) params.tests.amplitude[i] *= 20.0;
    is(check_tests(&machine), LEVEL_FAIL, "limit");
    snprintf(params.tests.trajectory, sizeof params.tests.trajectory, "%s/none.csv", root);
    is(check_tests(&machine), LEVEL_FAIL, "none.csv");
}

static void a_machine_that_would_be_blind_for_long_fails(void **unused) {
    (void)unused;
    is(check_blind_time(&machine), LEVEL_OK, "0.035 s of 0.1");
    params.device.watchdog_s = 0.5;
    is(check_blind_time(&machine), LEVEL_FAIL, "of 0.1");
}

static void an_input_that_is_not_wired_is_warned_of_behind_hardware(void **unused) {
    (void)unused;
    is(check_interlocks(&machine), LEVEL_OK, "door");
    params.interlocks.door = false;
    is(check_interlocks(&machine), LEVEL_WARN, "NOT WIRED");
    is(check_interlocks(&simulated), LEVEL_OK, "NOT WIRED");
}

static void inputs_with_one_contact_are_warned_of_behind_hardware(void **unused) {
    (void)unused;
    params.interlocks.antivalent = false;
    is(check_interlocks(&machine), LEVEL_WARN, "one contact each");
    is(check_interlocks(&machine), LEVEL_WARN, "door");
    is(check_interlocks(&simulated), LEVEL_OK, "one contact each");
    params.interlocks = (struct interlock_params){0};
    is(check_interlocks(&machine), LEVEL_WARN, "none; NOT WIRED");
}

int main(void) {
    if (!mkdtemp(root)) return 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_kernel_without_preempt_rt_is_warned_of, begin),
        cmocka_unit_test_setup(a_virtual_machine_is_warned_of_with_what_its_host_took, begin),
        cmocka_unit_test_setup(too_little_locked_memory_is_refused_behind_hardware, begin),
        cmocka_unit_test_setup(without_its_rights_real_time_is_refused_behind_hardware, begin),
        cmocka_unit_test_setup(a_governor_that_saves_power_is_warned_of, begin),
        cmocka_unit_test_setup(deep_sleep_is_warned_of_unless_it_is_off, begin),
        cmocka_unit_test_setup(a_loop_without_a_processor_of_its_own_is_warned_of, begin),
        cmocka_unit_test_setup(a_core_that_is_shared_is_warned_of, begin),
        cmocka_unit_test_setup(heat_and_a_small_share_for_real_time_threads_are_warned_of, begin),
        cmocka_unit_test_setup(a_slow_clock_is_warned_of, begin),
        cmocka_unit_test_setup(wake_ups_are_judged_by_the_deadline_of_the_loop, begin),
        cmocka_unit_test_setup(the_histogram_counts_every_wake_up_once, begin),
        cmocka_unit_test_setup(an_edge_belongs_to_the_bin_above_it, begin),
        cmocka_unit_test_setup(small_receive_buffers_are_warned_of, begin),
        cmocka_unit_test_setup(a_bus_that_is_too_full_fails_where_it_is_driven, begin),
        cmocka_unit_test_setup(a_can_interface_must_be_there_with_the_bit_rate_of_the_nodes, begin),
        cmocka_unit_test_setup(can_errors_are_warned_of_and_a_controller_off_the_bus_fails, begin),
        cmocka_unit_test_setup(the_kernels_answer_is_read_member_by_member, begin),
        cmocka_unit_test_setup(a_damaged_answer_is_read_no_further_than_it_goes, begin),
        cmocka_unit_test_setup(a_serial_line_must_be_fast_enough, begin),
        cmocka_unit_test_setup(round_trips_are_judged_by_cycle_and_time_out, begin),
        cmocka_unit_test_setup(a_device_that_does_not_answer_fails_and_one_that_is_driven_is_not_asked, begin),
        cmocka_unit_test_setup(a_log_needs_room_for_its_run, begin),
        cmocka_unit_test_setup(a_slow_disk_is_warned_of_and_one_that_hangs_fails, begin),
        cmocka_unit_test_setup(a_disk_that_takes_nothing_fails, begin),
        cmocka_unit_test_setup(a_configuration_that_is_no_machine_fails, begin),
        cmocka_unit_test_setup(joints_in_another_order_are_found, begin),
        cmocka_unit_test_setup(limits_that_nothing_reaches_are_warned_of, begin),
        cmocka_unit_test_setup(a_payload_in_tonnes_is_warned_of, begin),
        cmocka_unit_test_setup(tests_that_the_legs_cannot_make_fail, begin),
        cmocka_unit_test_setup(a_machine_that_would_be_blind_for_long_fails, begin),
        cmocka_unit_test_setup(an_input_that_is_not_wired_is_warned_of_behind_hardware, begin),
        cmocka_unit_test_setup(inputs_with_one_contact_are_warned_of_behind_hardware, begin),
        /* the last test, because it stays in its own network namespace */
        cmocka_unit_test_setup(lcm_is_followed_step_by_step, begin),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    char command[64];
    snprintf(command, sizeof command, "rm -rf %s", root);
    return system(command) || failed;
}
