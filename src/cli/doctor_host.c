#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "doctor.h"
#include "params.h"
#include "recorder.h"
#include "wakeup.h"

#define CPU "/sys/devices/system/cpu"

static const double DAEMON_LOCKED_BYTES = 65e6; /* memory that the daemon locks in a run of six
                                                 * tests, without the ring between loop and recorder
                                                 * (docs/real-time.md) */
enum { CAP_IPC_LOCK_BIT = 14 };                  /* CAP_IPC_LOCK of linux/capability.h */

struct finding check_kernel(const struct doctor *d) {
    char version[400];
    if (!doctor_read(d, version, sizeof version, "/proc/version")) return finding_unseen("/proc/version", "the kernel");
    bool preempt = strstr(version, "PREEMPT_RT") || strstr(version, "PREEMPT RT");
    version[strcspn(version, "(")] = '\0';
    return finding(preempt ? LEVEL_OK : LEVEL_WARN,
                   "install a kernel with PREEMPT_RT (Debian: linux-image-rt-amd64) before a machine is driven", "%s%s", version,
                   preempt ? "with PREEMPT_RT" : "without PREEMPT_RT: other work of the kernel can hold the loop up for milliseconds");
}

/* Computes the share of stolen time since this computer was started, in which it was ready to run
 * but its host ran others: number 8 of the first line of /proc/stat. */
static bool stolen_share(const struct doctor *d, double *share) {
    char text[4096];
    double ticks[8], all = 0.0;
    if (!doctor_read(d, text, sizeof text, "/proc/stat") || strncmp(text, "cpu ", 4)) return false;
    char *at = text + 4, *end;
    for (int i = 0; i < 8; i++, at = end) {
        ticks[i] = strtod(at, &end);
        if (end == at) return false;
        all += ticks[i];
    }
    *share = all > 0.0 ? ticks[7] / all : 0.0;
    return true;
}

struct finding check_hypervisor(const struct doctor *d) {
    char info[8192];
    double share = 0.0;
    if (!doctor_read(d, info, sizeof info, "/proc/cpuinfo")) return finding_unseen("/proc/cpuinfo", "the processor");
    const char *flags = strstr(info, "\nflags");
    if (!flags) return finding_unseen("`flags` of /proc/cpuinfo", "whether this is a virtual machine");
    char line[4096];
    snprintf(line, sizeof line, "%.*s ", (int)strcspn(flags + 1, "\n"), flags + 1);
    if (!strstr(line, " hypervisor ")) return finding(LEVEL_OK, "", "none: this computer has its processors to itself");
    bool known = stolen_share(d, &share);
    struct finding f = finding(LEVEL_WARN, "drive a machine from a computer of its own; the simulation's time stretches instead",
                               "a virtual machine: its host stops it when it likes");
    if (!known) return f;
    size_t used = strlen(f.found);
    snprintf(f.found + used, sizeof f.found - used, ", %.2g %% of the time since it was started", 100.0 * share);
    f.data = json_pack("{sf}", "stolen_pct", 100.0 * share);
    return f;
}

struct finding check_realtime(const struct doctor *d) {
    static const char remedy[] =
        "run as root, or give this user `rtprio` and `memlock unlimited` in /etc/security/limits.conf (docs/real-time.md)";
    struct wakeups w;
    struct error error;
    if (wakeups_measure(&d->params->loop, 0.0, &w, &error)) return finding(LEVEL_FAIL, "free this computer", "%s", error.text);
    if (w.realtime) return finding(level_of_machine(d), remedy, "%s", w.realtime_error.text);
    return finding(LEVEL_OK, "", "SCHED_FIFO %d, memory locked%s", d->params->loop.priority, d->params->loop.cpu >= 0 ? ", pinned" : "");
}

/* Compares the limit of locked memory with what the daemon locks. A trial would not suffice,
 * because `hexid doctor` itself locks less. */
struct finding check_locked_memory(const struct doctor *d) {
    char status[8192], limits[4096];
    if (!doctor_read(d, status, sizeof status, "/proc/self/status") || !doctor_read(d, limits, sizeof limits, "/proc/self/limits"))
        return finding_unseen("/proc/self", "the rights of this user");
    const char *effective = strstr(status, "CapEff:"), *limit = strstr(limits, "Max locked memory");
    if (effective && strtoull(effective + 7, NULL, 16) >> CAP_IPC_LOCK_BIT & 1)
        return finding(LEVEL_OK, "", "without a limit (CAP_IPC_LOCK)");
    if (!limit) return finding_unseen("a line of /proc/self/limits", "the limit of locked memory");
    limit += strcspn(limit, "0123456789u\n");
    if (*limit == 'u') return finding(LEVEL_OK, "", "without a limit");
    double bytes = strtod(limit, NULL);
    double needed = DAEMON_LOCKED_BYTES + (double)(recorder_ring_cycles(d->params) * sizeof(struct cycle));
    bool enough = bytes >= needed;
    struct finding f = finding(enough ? LEVEL_OK : level_of_machine(d),
                               "`memlock unlimited` for this user in /etc/security/limits.conf, or LimitMEMLOCK= "
                               "of its service",
                               "%.0f MB allowed; the daemon locks %.0f MB", bytes / 1e6, needed / 1e6);
    f.data = json_pack("{sf sf}", "allowed_bytes", bytes, "needed_bytes", needed);
    return f;
}

struct finding check_governor(const struct doctor *d) {
    int cpu[PROCESSORS_MAX], count = doctor_processors(d, cpu), seen = 0, others = 0;
    char governor[40], other[40] = "";
    for (int i = 0; i < count; i++) {
        if (!doctor_read(d, governor, sizeof governor, CPU "/cpu%d/cpufreq/scaling_governor", cpu[i])) continue;
        seen++;
        if (!strcmp(governor, "performance")) continue;
        if (!others++) strcpy(other, governor);
    }
    if (!seen) return finding_unseen(CPU "/cpu*/cpufreq", "no frequency of a processor is set from here");
    if (!others) return finding(LEVEL_OK, "", "performance on %d processor%s", seen, seen == 1 ? "" : "s");
    return finding(LEVEL_WARN, "echo performance | sudo tee " CPU "/cpu*/cpufreq/scaling_governor",
                   "%s on %d of %d processors: they slow down between two cycles and wake the loop late", other, others, seen);
}

/* Checks the processors' idle states: an idle state whose exit takes more than a twentieth of the
 * period delays the loop visibly. */
struct finding check_idle_states(const struct doctor *d) {
    int cpu[PROCESSORS_MAX], count = doctor_processors(d, cpu), seen = 0;
    double limit_us = d->params->loop.period_s * 1e6 / 20.0;
    int64_t worst_us = 0, us, disabled;
    char name[40], worst[40] = "none";
    for (int i = 0; i < count; i++)
        for (int state = 0; doctor_number(d, &us, CPU "/cpu%d/cpuidle/state%d/latency", cpu[i], state); state++) {
            seen++;
            if (doctor_number(d, &disabled, CPU "/cpu%d/cpuidle/state%d/disable", cpu[i], state) && disabled) continue;
            if (us <= worst_us || !doctor_read(d, name, sizeof name, CPU "/cpu%d/cpuidle/state%d/name", cpu[i], state)) continue;
            worst_us = us;
            strcpy(worst, name);
        }
    if (!seen) return finding_unseen(CPU "/cpu*/cpuidle/state0", "how deep the processors sleep");
    struct finding f = finding((double)worst_us > limit_us ? LEVEL_WARN : LEVEL_OK,
                               "sudo cpupower idle-set -D 20 (from linux-cpupower), or processor.max_cstate=1 on the kernel's command line",
                               "the deepest, %s, is left in %" PRId64 " us; %.0f us, a twentieth of the cycle, do no harm", worst, worst_us,
                               limit_us);
    f.data = json_pack("{sI sf}", "latency_us", (json_int_t)worst_us, "limit_us", limit_us);
    return f;
}

/* Writes the remedy: reserve a processor for the loop, loop.cpu or else the last one; on a computer
 * with a single processor, use a computer with two. */
static void isolation_remedy(const char *online, int cpu, char *text, size_t size) {
    int last = -1, other = -1;
    for (int i = 0; i < PROCESSORS_MAX; i++)
        if (doctor_listed(online, i)) last = i;
    int loop = cpu >= 0 ? cpu : last;
    for (int i = 0; i < PROCESSORS_MAX && other < 0; i++)
        if (i != loop && doctor_listed(online, i)) other = i;
    if (other < 0) snprintf(text, size, "a computer with a second processor: this has one, which the loop cannot have to itself");
    else
        snprintf(text, size, "isolcpus=%d nohz_full=%d rcu_nocbs=%d irqaffinity=%d on the kernel's command line, and loop.cpu: %d", loop,
                 loop, loop, other, loop);
}

struct finding check_isolation(const struct doctor *d) {
    char online[256] = "", isolated[256] = "", remedy[256];
    int cpu = d->params->loop.cpu;
    if (!doctor_read(d, online, sizeof online, CPU "/online")) return finding_unseen(CPU "/online", "the processors");
    doctor_read(d, isolated, sizeof isolated, CPU "/isolated");
    isolation_remedy(online, cpu, remedy, sizeof remedy);
    if (cpu >= 0 && !doctor_listed(online, cpu))
        return finding(level_of_machine(d), "choose one of them as loop.cpu", "loop.cpu %d is not there: this computer has %s", cpu,
                       online);
    if (cpu >= 0 && doctor_listed(isolated, cpu)) return finding(LEVEL_OK, "", "loop.cpu %d is isolated", cpu);
    if (cpu >= 0) return finding(LEVEL_WARN, remedy, "loop.cpu %d is not isolated: other programs run there, too", cpu);
    return finding(LEVEL_WARN, remedy, "loop.cpu -1: the loop shares its processor with other programs%s%s",
                   *isolated ? "; isolated are " : "", isolated);
}

struct finding check_siblings(const struct doctor *d) {
    char siblings[256], isolated[256] = "";
    int cpu = d->params->loop.cpu;
    if (cpu < 0) return finding_none(); /* check_isolation() reports that no processor is chosen */
    if (!doctor_read(d, siblings, sizeof siblings, CPU "/cpu%d/topology/thread_siblings_list", cpu))
        return finding_unseen(CPU "/cpu*/topology", "which processors share a core");
    doctor_read(d, isolated, sizeof isolated, CPU "/isolated");
    for (int other = 0; other < PROCESSORS_MAX; other++)
        if (other != cpu && doctor_listed(siblings, other) && !doctor_listed(isolated, other))
            return finding(LEVEL_WARN, "`nosmt` on the kernel's command line, or the sibling in isolcpus, too",
                           "processor %d shares its core with %d, which other programs use: they take the loop's time", cpu, other);
    return finding(LEVEL_OK, "", "nobody else uses the core of processor %d", cpu);
}

/* Checks two kinds of throttling: of processors by heat, counted since they were switched on, and
 * of real-time threads, which the kernel limits to a share of the time. */
struct finding check_throttling(const struct doctor *d) {
    int cpu[PROCESSORS_MAX], count = doctor_processors(d, cpu), seen = 0;
    int64_t runtime_us, period_us, times, hot = 0;
    for (int i = 0; i < count; i++)
        if (doctor_number(d, &times, CPU "/cpu%d/thermal_throttle/core_throttle_count", cpu[i])) seen++, hot += times;
    if (doctor_number(d, &runtime_us, "/proc/sys/kernel/sched_rt_runtime_us") &&
        doctor_number(d, &period_us, "/proc/sys/kernel/sched_rt_period_us") && runtime_us >= 0 &&
        runtime_us < period_us * 9 / 10) /* the kernel's default lets real-time threads run for 95 %
                                          * of the time */
        return finding(LEVEL_WARN, "sudo sysctl -w kernel.sched_rt_runtime_us=950000",
                       "real-time threads get %" PRId64 " of %" PRId64 " us: the loop is stopped when they want more", runtime_us,
                       period_us);
    if (hot > 0) {
        struct finding f = finding(LEVEL_WARN,
                                   "cool the computer (fan, dust, ambient temperature); the count begins anew when it is switched on",
                                   "processors were slowed down by heat %" PRId64 " times", hot);
        f.data = json_pack("{sI}", "thermal_count", (json_int_t)hot);
        return f;
    }
    if (!seen) return finding_unseen(CPU "/cpu*/thermal_throttle", "whether heat slows the processors down");
    return finding(LEVEL_OK, "", "no processor was slowed down by heat since it was switched on");
}

/* Checks the clock source: reading a clock over a bus or by an interrupt takes microseconds, and
 * the loop reads the clock several times a cycle. */
struct finding check_clock_source(const struct doctor *d) {
    static const char path[] = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
    static const char *const slow[] = {"hpet", "acpi_pm", "pit", "jiffies", "refined-jiffies"};
    char name[64];
    if (!doctor_read(d, name, sizeof name, path)) return finding_unseen(path, "the clock");
    for (size_t i = 0; i < sizeof slow / sizeof *slow; i++)
        if (!strcmp(name, slow[i]))
            return finding(LEVEL_WARN,
                           "see in `dmesg | grep -i tsc` why the kernel gave the TSC up; a firmware update, or tsc=reliable where it is",
                           "%s: reading it takes microseconds", name);
    return finding(LEVEL_OK, "", "%s", name);
}
