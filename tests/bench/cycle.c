/* Instructions of one cycle of the controller, by state and fault, for cycle.sh:
 *
 *     cycle FAULT...    a run on the virtual clock behind `fault:FAULT,...;sim:` (none: healthy)
 *
 * Under callgrind (--instr-atstart=no) each platform_step() is a separate part, named after its
 * final state and the latched faults: `STATE FAULTS`. The first cycles of a state are included.
 * Without callgrind the program prints the same names, a line per cycle. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <valgrind/callgrind.h>

#include "config.h"
#include "loop.h"
#include "params.h"
#include "platform.h"

enum { CYCLES = 4000, REQUEST_PARK = 3000 };

static void fail(const char *text) {
    fprintf(stderr, "cycle: %s\n", text);
    exit(1);
}

/* Shortens the run, so that every state comes within a few hundred cycles. */
static void configure(struct params *p) {
    struct error error;
    static const char *const settings[] = {"sim.engine=closed_form", "motion.park_z_m=0.35", "motion.rate_mps=0.55", "motion.engage_s=1.6",
                                           "motion.park_s=1.6",      "motion.hold_s=0.1",    "tests.settle_s=0.1",   "tests.ramp_s=0.1",
                                           "tests.duration_s=0.5",   "tests.ramp_out_s=0.1"};
    if (config_load(p, NULL, settings, sizeof settings / sizeof *settings, &error)) fail(error.text);
}

/* Runs one cycle of the loop; only platform_step() is counted. */
static bool step(struct platform *platform, struct hal *hal, int64_t now_ns, int i) {
    struct hal_sample sample = {0};
    struct cycle c;
    char name[80];
    if (hal->ops->read(hal, now_ns, &sample)) sample.flags |= SAMPLE_IO;
    struct request request = i == REQUEST_PARK ? (struct request){.id = 1, .command = COMMAND_PARK} : (struct request){0};
    CALLGRIND_ZERO_STATS;
    platform_step(platform, &sample, request, &c);
    snprintf(name, sizeof name, "%d %d", (int)c.state, c.faults != 0);
    CALLGRIND_DUMP_STATS_AT(name);
    puts(name);
    bool powered = supervisor_powers(c.state);
    if (!powered || hal->ops->write(hal, &c.out)) hal->ops->safe(hal);
    return platform->automatic || powered || i < REQUEST_PARK;
}

int main(int argc, char **argv) {
    static struct params params;
    static struct platform platform;
    struct hal *hal;
    struct error error;
    char url[400] = "sim:";
    if (argc > 1) snprintf(url, sizeof url, "fault:%s;sim:", argv[1]);
    configure(&params);
    if (hal_open(&hal, url, &params, 1, &error)) fail(error.text);
    if (platform_init(&platform, &params, &error)) fail(error.text);
    CALLGRIND_START_INSTRUMENTATION;
    int64_t period_ns = (int64_t)(params.loop.period_s * 1e9);
    for (int i = 0; i < CYCLES && step(&platform, hal, i * period_ns, i); i++) continue;
    hal->ops->close(hal);
    return 0;
}
