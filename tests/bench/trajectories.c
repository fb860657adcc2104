/* The control laws side by side on trajectories, files as `hexid run --trajectory` takes them, on
 * the simulated machine (ODE, with its sensors), without and with 100 N of dry friction in each
 * cylinder. Prints the tables of docs/validation.md; a cell compares the true pose with the
 * reference:
 *
 *     largest / rms distance of the origin, mm / largest / rms error of the angles, mrad
 *
 *     trajectories [-s] FILE...       -s: without dry friction only */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "failure.h"
#include "loop_tune.h"
#include "motion_check.h"
#include "params.h"
#include "trajectory_file.h"
#include "version.h"

#include "../control_rig.h"
#include "drivers.h"

static const double DRY_N[] = {0.0, 100.0};
enum { FRICTIONS = 2 };
/* A stop in the middle of the circle brings the platform back from 0.68 m; with less time
 * motion_check() refuses the trajectory. */
static const double RAMP_OUT_S = 4.0;

enum driver { BY_PID, BY_TUNED, BY_WRONG, BY_FOUND, BY_TRUTH, DRIVERS };
static const char *const driver_names[DRIVERS] = {"PID as shipped", "PID as tune sets it", "model, payload 30 % too light",
                                                  "model, as identify --model wrote it", "model, the truth"};

static void tune(struct params *p) {
    struct loop_tune t;
    struct error error;
    if (loop_tune(p, false, false, &t, &error)) fail(error.text);
    p->control = t.gains;
}

static void make_driver(struct params *p, enum driver driver, const struct params *machine, const struct found *found) {
    if (driver == BY_FOUND) *p = found->written.params;
    else if (driver == BY_WRONG) make_wrong(p, machine);
    else *p = *machine;
    if (driver == BY_TUNED) tune(p);
    p->control.law = driver <= BY_TUNED ? CONTROL_PID : CONTROL_MODEL;
}

/* Loads the trajectory of a file and checks it against the machine's limits, as `hexid run` does
 * before anything moves. */
static void load(struct params *p, const char *file, struct trajectory *t) {
    struct error error;
    *t = (struct trajectory){0};
    snprintf(p->tests.trajectory, sizeof p->tests.trajectory, "%s", file);
    p->tests.ramp_out_s = RAMP_OUT_S;
    if (motion_check_tests(p, t, &error)) fail(error.text);
}

static void print_errors(const struct control_figures *f) {
    printf(" %.3f / %.3f /", 1e3 * f->peak_position_m, 1e3 * f->rms_position_m);
    printf(" %.3f / %.3f", 1e3 * f->peak_angle_rad, 1e3 * f->rms_angle_rad);
    if (f->doubt_cycles) printf(" (PID in %.1f %% of the cycles)", 100.0 * f->doubt_cycles / f->driven_cycles);
    printf(" |");
}

/* Prints how far the platform was off. Returns the largest valve command. */
static double cell(const struct params *machine, const struct params *controller, const char *file) {
    struct params m = *machine, c = *controller;
    struct trajectory t;
    struct control_figures f;
    load(&c, file, &t);
    m.tests = c.tests;
    control_drive(&m, &c, &t, 1, &f);
    trajectory_free(&t);
    if (f.faulted) printf(" %s |", fault_name(f.fault));
    else print_errors(&f);
    fflush(stdout);
    return f.peak_command;
}

static const char *name_of(const char *file) {
    const char *slash = strrchr(file, '/');
    return slash ? slash + 1 : file;
}

/* Prints what the trajectories ask of the machine, beside the largest commands that drove them. */
static void print_demands(const struct params *machine, int files, char *const file[], const double command[]) {
    struct kinematics k;
    kinematics_place(&k, machine);
    puts("\n| trajectory | s | legs, m | fastest leg, m/s | largest valve command |\n| --- | --- | --- | --- | --- |");
    for (int n = 0; n < files; n++) {
        struct params p = *machine;
        struct trajectory t;
        load(&p, file[n], &t);
        double dt_s = p.loop.period_s, least_m = HUGE_VAL, most_m = 0.0, most_mps = 0.0, before_m[LEGS], now_m[LEGS], pose[DOFS];
        for (int64_t i = 0; (double)i * dt_s <= trajectory_s(&t); i++, memcpy(before_m, now_m, sizeof now_m)) {
            trajectory_at(&t, (double)i * dt_s, pose);
            ik_lengths(&k, pose, now_m);
            for (int leg = 0; leg < LEGS; leg++) {
                least_m = fmin(least_m, now_m[leg]), most_m = fmax(most_m, now_m[leg]);
                if (i > 0) most_mps = fmax(most_mps, fabs(now_m[leg] - before_m[leg]) / dt_s);
            }
        }
        printf("| %s | %g | %.3f to %.3f | %.3f | %.2f |\n", name_of(file[n]), trajectory_s(&t), least_m, most_m, most_mps, command[n]);
        trajectory_free(&t);
    }
}

static void compare(double dry_n, int files, char *const file[], double command[]) {
    static struct params machine, wrong, controller;
    static struct found found;
    configure(&machine, dry_n);
    make_wrong(&wrong, &machine);
    identify(&machine, &wrong, &found);
    printf("\n| %g N of dry friction |", dry_n);
    for (int n = 0; n < files; n++) printf(" %s |", name_of(file[n]));
    printf("\n| --- |");
    for (int n = 0; n < files; n++) printf(" --- |");
    for (int driver = 0; driver < DRIVERS; driver++) {
        make_driver(&controller, (enum driver)driver, &machine, &found);
        printf("\n| %s |", driver_names[driver]);
        for (int n = 0; n < files; n++) command[n] = fmax(command[n], cell(&machine, &controller, file[n]));
    }
    puts("");
    recording_free(&found.recording);
}

int main(int argc, char **argv) {
    bool brief = argc > 1 && !strcmp(argv[1], "-s");
    int files = argc - 1 - brief;
    char **file = argv + 1 + brief;
    if (files < 1) fail("usage: trajectories [-s] FILE...");
    double *command = calloc((size_t)files, sizeof *command);
    struct params machine;
    if (!command) fail("out of memory");
    printf("hexid %s\n", version);
    for (int friction = 0; friction < (brief ? 1 : FRICTIONS); friction++) compare(DRY_N[friction], files, file, command);
    configure(&machine, 0.0);
    print_demands(&machine, files, file, command);
    free(command);
    return 0;
}
