#include <string.h>
#include <sys/utsname.h>
#include <time.h>

#include "blind_time.h"
#include "bus.h"
#include "can_frames.h"
#include "cli.h"
#include "config.h"
#include "failure.h"
#include "interlock.h"
#include "kinematics.h"
#include "modbus_map.h"
#include "workspace.h"

static bool say(bool good, const char *what, const char *detail) {
    printf("  %-5s %-14s %s\n", good ? "ok" : "FAIL", what, detail);
    return good;
}

static bool check_realtime(const struct params *params) {
    struct error error = {.text = "SCHED_FIFO, memory locked"};
    return say(!realtime_enter(&params->loop, REALTIME_REQUIRE, &error), "real time", error.text);
}

static bool check_kernel(void) {
    struct utsname name;
    char detail[sizeof name.version + 80];
    uname(&name);
    bool preempt = strstr(name.version, "PREEMPT_RT") != NULL;
    snprintf(detail, sizeof detail, "%s %s", name.version, preempt ? "" : "(no PREEMPT_RT: fit for `sim:`, not for a machine)");
    say(true, "kernel", detail);
    return true;
}

static bool check_bus(const struct params *params) {
    struct error error = {.text = "reachable"};
    struct bus *bus;
    if (!params->lcm.url[0]) return say(true, "LCM", "none configured");
    bool good = !bus_open(&bus, params->lcm.url, &error);
    if (good) bus_close(bus);
    return say(good, "LCM", error.text);
}

/* A singular pose within the strokes is no mistake: most such machines have some, far from where they are driven. */
static bool check_workspace(const struct params *params, const struct kinematics *k) {
    char detail[300];
    struct workspace w = workspace_find(k, params);
    bool all = w.reached == w.corners;
    const double *p = all ? w.worst_pose : w.nearest_pose;
    size_t used = (size_t)snprintf(detail, sizeof detail, "condition %.3g at neutral, at worst %.3g; ", w.neutral_condition, w.worst_condition);
    if (all) used += (size_t)snprintf(detail + used, sizeof detail - used, "no singular pose within the strokes; worst");
    else used += (size_t)snprintf(detail + used, sizeof detail - used, "%d of %d corners of the strokes lie beyond a singular pose, the nearest "
                                  "after %.0f %% of the way,", w.corners - w.reached, w.corners, 100.0 * w.nearest);
    snprintf(detail + used, sizeof detail - used, " at %.3f %.3f %.3f m %.3f %.3f %.3f rad", p[0], p[1], p[2], p[3], p[4], p[5]);
    return say(true, "workspace", detail);
}

static bool check_kinematics(const struct params *params) {
    struct error error;
    struct kinematics k;
    bool good = !kinematics_init(&k, params, &error);
    size_t used = 0;
    for (int i = 0; i < LEGS && good; i++)
        used += (size_t)snprintf(error.text + used, sizeof error.text - used, "%s%.4f", i ? " " : "neutral lengths ", k.neutral_length_m[i]);
    if (good) snprintf(error.text + used, sizeof error.text - used, " m");
    return say(good, "kinematics", error.text) && check_workspace(params, &k);
}

static bool check_blind_time(const struct params *params) {
    char detail[200];
    struct blind_time blind = blind_time(params);
    snprintf(detail, sizeof detail, "%.3f s of %g, with %s: %s", blind.s, params->limits.blind_time_s, blind.when, blind.sum);
    return say(blind.allowed, "blind time", detail);
}

static bool check_interlocks(const struct params *params) {
    char detail[200];
    interlock_describe(&params->interlocks, detail, sizeof detail);
    return say(true, "interlocks", detail);
}

static bool check_can(const struct params *params) {
    char detail[120];
    struct can_load l = can_load(params);
    snprintf(detail, sizeof detail, "%.1f %% of the cycle: %d bits a cycle, %.1f of heartbeats; at most %.0f %%", 100 * l.share,
             l.cycle_bits, l.heartbeat_bits, 100 * l.limit);
    return say(l.share <= l.limit, "CAN load", detail);
}

/* The baud rate of a serial line is the address's, not the configuration's: said for the usual ones. */
static bool check_modbus(const struct params *params) {
    char detail[120];
    struct modbus_load slow = modbus_load(115200.0), fast = modbus_load(1e6);
    snprintf(detail, sizeof detail, "function 23: %d + %d bytes, on a serial line %.1f ms at 115200 baud, %.1f ms at 1 Mbaud; "
             "the cycle has %.1f ms", slow.request_bytes, slow.response_bytes, slow.cycle_s * 1e3, fast.cycle_s * 1e3,
             0.9 * params->loop.period_s * 1e3);
    return say(true, "Modbus", detail);
}

int cmd_doctor(int argc, char **argv) {
    char installed[PATH_MAX];
    struct options o;
    struct params params;
    struct error error;
    if (options_parse(&o, argc, argv, "cSmxk", 0, &error) || options_params(&o, &params, &error)) return cli_fail(&error);
    if (o.failures) {
        failure_print(stdout);
        return EXIT_PASSED;
    }
    if (o.keys) {
        config_print_keys(stdout);
        return EXIT_PASSED;
    }
    if (o.modbus_map) {
        modbus_map_print(stdout);
        return EXIT_PASSED;
    }
    const char *found = o.config ? o.config : options_default_config(installed);
    bool good = say(true, "configuration", found ? found : "built in");
    good &= check_kinematics(&params);
    good &= check_kernel();
    good &= check_bus(&params);
    good &= check_blind_time(&params);
    good &= check_interlocks(&params);
    good &= check_can(&params);
    good &= check_modbus(&params);
    good &= check_realtime(&params);
    return good ? EXIT_PASSED : EXIT_CHECK_FAILED;
}
