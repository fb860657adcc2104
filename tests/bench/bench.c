/* Benchmarks for bench.sh, one per process:
 *
 *     bench                   lists the names
 *     bench NAME RUNS [SHARE] prints a line per run: time of one operation [ns], operations in a
 *                             run, share of time inside dWorldStep (0: none); SHARE: only every
 *                             SHARE-th of a plant's cycles (1)
 *     bench use COMMAND ...   runs a command and prints its wall time [s] and largest memory [kB];
 *                             exits with its status
 *
 * Only the functions measured_* are timed and counted by callgrind. Every run starts from the same
 * state and does the same work, so the instructions are exact and the spread of the times is the
 * machine's. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include <valgrind/callgrind.h>

#include "../random.h"
#include "config.h"
#include "ident.h"
#include "loop.h"
#include "params.h"
#include "plant.h"
#include "platform.h"
#include "units.h"

enum { CYCLES = 500, LEAD_MAX = 10000, POSES = 1000, TEST_CYCLES = 2500 };

/* A closed loop from neutral into the evaluated part of the first test, and the data that the
 * benchmarks derive from it. */
struct work {
    struct params params;
    struct cycle *cycle;   /* recorded cycles */
    int begin;             /* the cycle that starts the test, at rest at neutral */
    int first, end;        /* evaluated cycles to work on */
    struct kinematics kinematics;
    struct platform platform;
    struct ident ident;
    struct plant *plant;
    double pose[POSES][DOFS], length_m[POSES][LEGS];
    double sum;            /* sum of results, so that no work is optimised away */
};

struct benchmark {
    const char *name;
    int operations;
    int cycles;            /* number of cycles to record */
    void (*prepare)(struct work *w);
    void (*measured)(struct work *w);
    const char *settings[6];
};

static int64_t now_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * NS_PER_S + t.tv_nsec;
}

/* The linker redirects the engine's calls of dWorldStep here. Both times, of this call and of the
 * whole step, come from the same run, so that their ratio is exact. */
typedef struct dxWorld *dWorldID;
int __real_dWorldStep(dWorldID world, double dt_s);
int __wrap_dWorldStep(dWorldID world, double dt_s);
static int64_t world_step_ns;

int __wrap_dWorldStep(dWorldID world, double dt_s) {
    int64_t start_ns = now_ns();
    int result = __real_dWorldStep(world, dt_s);
    world_step_ns += now_ns() - start_ns;
    return result;
}

static void fail(const struct error *e) {
    fprintf(stderr, "bench: %s\n", e->text);
    exit(1);
}

static void configure(struct params *p, const char *const settings[]) {
    struct error error;
    int count = 0;
    while (settings[count]) count++;
    if (config_load(p, NULL, settings, count, &error)) fail(&error);
    p->motion.hold_s = 0.0;
    p->tests.settle_s = 0.3;
    p->tests.ramp_s = 0.2;
    p->tests.duration_s = 10.0;
}

static void restart_plant(struct work *w) {
    struct error error;
    if (w->plant) plant_destroy(w->plant);
    w->plant = plant_create(&w->params, 1, &error);
    if (!w->plant) fail(&error);
    plant_place(w->plant, (const double[DOFS]){0});
}

static void restart_platform(struct work *w) {
    struct error error;
    if (platform_init(&w->platform, &w->params, &error)) fail(&error);
}

static void step_plant(struct work *w, int i) {
    static const double centred[LEGS];
    plant_step(w->plant, w->cycle[i].out.enable ? w->cycle[i].out.valve : centred);
}

/* Runs the daemon's own loop on the simulation, so the recorded cycles contain everything that a
 * run needs up to its test. The commands for the benchmarks of all engines come from the
 * closed-form engine, which is ten times as fast. */
static void record(struct work *w, int cycles) {
    static struct loop loop;
    struct hal *hal;
    struct ring records;
    struct error error;
    struct params params = w->params;
    params.sim.engine = ENGINE_CLOSED_FORM;
    w->cycle = calloc((size_t)(LEAD_MAX + cycles), sizeof *w->cycle);
    if (!w->cycle) fail(&(struct error){.text = "out of memory"});
    if (hal_open(&hal, "sim:", &params, 1, &error)) fail(&error);
    if (ring_init(&records, sizeof *w->cycle, 4)) fail(&(struct error){.text = "out of memory"});
    if (loop_init(&loop, &params, hal, &records, CLOCK_VIRTUAL, &error)) fail(&error);
    w->first = w->end = LEAD_MAX;
    bool more = true;
    for (int i = 0; i < w->end && more; i++) {
        more = loop_cycle(&loop) && ring_pop(&records, &w->cycle[i]);
        if (!w->begin && w->cycle[i].state == STATE_TESTING) w->begin = i;
        if (w->first == LEAD_MAX && w->cycle[i].phase == PHASE_EVALUATE) {
            w->first = i;
            w->end = i + cycles;
        }
    }
    if (w->first == LEAD_MAX) fail(&(struct error){.text = "the recorded loop never came to its test"});
    if (!more || w->cycle[w->end - 1].phase != PHASE_EVALUATE) fail(&(struct error){.text = "the recorded test is too short"});
    ring_free(&records);
    hal->ops->close(hal);
}

static void prepare_tracking(struct work *w) { memcpy(w->pose[0], w->cycle[w->first].pose, sizeof w->pose[0]); }

static void measured_tracking(struct work *w) {
    for (int i = w->first; i < w->end; i++) w->sum += fk_solve(&w->kinematics, w->cycle[i].in.length_m, w->pose[0]).residual_m;
}

/* Poses within +-0.1 m and +-0.1 rad of neutral, where the search starts. */
static void prepare_from_neutral(struct work *w) {
    uint64_t state = 1;
    for (int i = 0; i < POSES; i++) {
        for (int d = 0; d < DOFS; d++) w->pose[i][d] = 0.1 * random_unit(&state);
        ik_lengths(&w->kinematics, w->pose[i], w->length_m[i]);
    }
    memset(w->pose, 0, sizeof w->pose);
}

static void measured_from_neutral(struct work *w) {
    for (int i = 0; i < POSES; i++) w->sum += fk_solve(&w->kinematics, w->length_m[i], w->pose[i]).residual_m;
}

static void prepare_control(struct work *w) {
    struct cycle out;
    restart_platform(w);
    for (int i = 0; i < w->first; i++) platform_step(&w->platform, &w->cycle[i].in, (struct request){0}, &out);
}

static void measured_control(struct work *w) {
    struct cycle out;
    for (int i = w->first; i < w->end; i++) {
        platform_step(&w->platform, &w->cycle[i].in, (struct request){0}, &out);
        w->sum += out.out.valve[0];
    }
}

static void prepare_plant(struct work *w) {
    restart_plant(w);
    for (int i = w->begin; i < w->first; i++) step_plant(w, i);
    world_step_ns = 0;
}

static void measured_plant(struct work *w) {
    for (int i = w->first; i < w->end; i++) step_plant(w, i);
}

static void prepare_ident(struct work *w) {
    struct error error;
    if (ident_init(&w->ident, &w->params, &error)) fail(&error);
}

static void measured_ident(struct work *w) {
    for (int i = w->first; i < w->end; i++) ident_feed(&w->ident, &w->cycle[i]);
    ident_end(&w->ident);
}

/* Makes six results of a machine with the nominal matrix and no friction. */
static void prepare_solve(struct work *w) {
    prepare_ident(w);
    struct identification *r = &w->ident.result;
    double omega = 2.0 * PI * w->params.tests.hz[DOF_X];
    nominal_matrix(&w->params, &w->kinematics, (const double[DOFS]){0}, r->nominal_mt);
    r->tests = DOFS;
    for (int d = 0; d < DOFS; d++) {
        double a = w->params.tests.amplitude[d];
        r->test[d] = (struct test_result){.test = d,
                                          .dof = (enum dof)d,
                                          .frequency_hz = w->params.tests.hz[d],
                                          .amplitude = a,
                                          .achieved_amplitude = a,
                                          .samples = TEST_CYCLES};
        r->test[d].pose[d][0] = a;
        for (int k = 0; k < DOFS; k++) r->test[d].wrench[k][0] = -omega * omega * a * r->nominal_mt[k][d];
    }
}

static void measured_solve(struct work *w) { w->sum += ident_solve(&w->ident); }

#define ODE "sim.engine=ode"
#define CLOSED_FORM "sim.engine=closed_form"
#define LEG_STICK "effects.cylinder_coulomb_friction.force_extend_n=100", "effects.cylinder_coulomb_friction.force_retract_n=100"
#define JOINT_STICK "effects.passive_joint_friction.coulomb_nm=2"

static const struct benchmark benchmarks[] = {
    {"fk_tracking", CYCLES, CYCLES, prepare_tracking, measured_tracking, {CLOSED_FORM}},
    {"fk_from_neutral", POSES, CYCLES, prepare_from_neutral, measured_from_neutral, {CLOSED_FORM}},
    {"control_step", CYCLES, CYCLES, prepare_control, measured_control, {CLOSED_FORM}},
    {"sim_step_ode", CYCLES, CYCLES, prepare_plant, measured_plant, {ODE}},
    {"sim_step_ode_leg_stick", CYCLES, CYCLES, prepare_plant, measured_plant, {ODE, LEG_STICK}},
    {"sim_step_ode_leg_and_joint_stick", CYCLES, CYCLES, prepare_plant, measured_plant, {ODE, LEG_STICK, JOINT_STICK}},
    {"sim_step_closed_form", CYCLES, CYCLES, prepare_plant, measured_plant, {CLOSED_FORM}},
    {"sim_step_closed_form_leg_stick", CYCLES, CYCLES, prepare_plant, measured_plant, {CLOSED_FORM, LEG_STICK}},
    {"sim_step_closed_form_leg_and_joint_stick", CYCLES, CYCLES, prepare_plant, measured_plant, {CLOSED_FORM, LEG_STICK, JOINT_STICK}},
    {"identify_5_s", 1, TEST_CYCLES, prepare_ident, measured_ident, {CLOSED_FORM}},
    {"identify_solve", 1, CYCLES, prepare_solve, measured_solve, {CLOSED_FORM}},
};
enum { BENCHMARKS = sizeof benchmarks / sizeof benchmarks[0] };

static void run(const struct benchmark *b, struct work *w, int runs, int share) {
    struct error error;
    configure(&w->params, b->settings);
    if (kinematics_init(&w->kinematics, &w->params, &error)) fail(&error);
    record(w, b->cycles);
    int operations = b->operations;
    if (b->measured == measured_plant) {
        w->end = w->first + b->cycles / share;
        operations = b->cycles / share * w->params.sim.substeps;
    }
    for (int i = 0; i < runs; i++) {
        b->prepare(w);
        CALLGRIND_START_INSTRUMENTATION;
        int64_t start_ns = now_ns();
        b->measured(w);
        int64_t ns = now_ns() - start_ns;
        CALLGRIND_STOP_INSTRUMENTATION;
        printf("%.1f %d %.4f\n", (double)ns / operations, operations, world_step_ns ? (double)ns / (double)world_step_ns : 0.0);
    }
}

static int use(char **command) {
    int64_t start_ns = now_ns();
    pid_t child = fork();
    if (!child) {
        execvp(command[0], command);
        _exit(127);
    }
    int status;
    struct rusage usage;
    if (child < 0 || wait4(child, &status, 0, &usage) < 0) return 127;
    printf("%.3f %ld\n", seconds_from_ns(now_ns() - start_ns), usage.ru_maxrss);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 127;
}

int main(int argc, char **argv) {
    if (argc > 2 && !strcmp(argv[1], "use")) return use(argv + 2);
    for (int i = 0; i < BENCHMARKS; i++) {
        if (argc < 2) puts(benchmarks[i].name);
        else if (!strcmp(argv[1], benchmarks[i].name)) {
            struct work *w = calloc(1, sizeof *w);
            int runs = argc > 2 ? atoi(argv[2]) : 1, share = argc > 3 ? atoi(argv[3]) : 1;
            if (runs < 1 || share < 1 || share > CYCLES) fail(&(struct error){.text = "RUNS and SHARE are 1 or more"});
            run(&benchmarks[i], w, runs, share);
            if (!isfinite(w->sum)) fail(&(struct error){.text = "the results that were timed are no numbers"});
            return 0;
        }
    }
    return argc >= 2;
}
