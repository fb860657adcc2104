/* The control laws side by side on the simulated machine (ODE, with its sensors): six sines at 2,
 * 4, 8 and 12 Hz, without and with 100 N of dry friction in each cylinder. They are driven by the
 * PID as shipped and with tuned gains, and by the law `model` with different knowledge of the
 * payload. Then two machines with tuned gains, without and with gains of the modes. Prints the
 * tables of docs/validation.md; a cell is the worst of six tests:
 *
 *     amplitude error, % / phase, deg / unwanted motion, % / rms distance of the true pose, mm */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "failure.h"
#include "loop_tune.h"
#include "params.h"
#include "payload.h"
#include "version.h"

#include "control_table.h"
#include "drivers.h"

/* Takes the payload from a matrix; all entries get the same relative standard deviation. */
static void take_matrix(struct params *p, const double mt[DOFS][DOFS]) {
    struct kinematics k;
    struct error error;
    double entry[MATRIX_ENTRIES], covariance[MATRIX_ENTRIES][MATRIX_ENTRIES] = {{0}};
    if (kinematics_init(&k, p, &error)) fail(error.text);
    for (int i = 0, n = 0; i < DOFS; i++)
        for (int j = i; j < DOFS; j++, n++) {
            entry[n] = 0.5 * (mt[i][j] + mt[j][i]);
            covariance[n][n] = 1e-4 * mt[i][i] * mt[j][j];
        }
    struct payload found = payload_find(p, &k, entry, covariance);
    if (!found.whole) fail("the matrix has no payload");
    const double *v = found.nearest, *inertia = &v[PAYLOAD_INERTIA];
    p->payload.mass_kg = v[PAYLOAD_MASS];
    /* The mass centre stays as configured: it is the origin of {M}, and with another origin the
     * sines would be about another point. */
    p->payload.inertia_xx_kg_m2 = inertia[0], p->payload.inertia_yy_kg_m2 = inertia[1], p->payload.inertia_zz_kg_m2 = inertia[2];
    p->payload.inertia_xy_kg_m2 = inertia[3], p->payload.inertia_xz_kg_m2 = inertia[4], p->payload.inertia_yz_kg_m2 = inertia[5];
}

enum driver { BY_PID, BY_TUNED, BY_WRONG, BY_METHOD_A, BY_FOUND, BY_TRUTH, DRIVERS };
static const char *const driver_names[DRIVERS] = {
    "PID as shipped",  "PID as tuned", "model, payload 30 % too light", "model, method A's matrix", "model, as identify --model wrote it",
    "model, the truth"};

static void tune(struct params *p) {
    struct loop_tune t;
    struct error error;
    if (loop_tune(p, false, false, &t, &error)) fail(error.text);
    p->control = t.gains;
}

static void make_driver(struct params *p, enum driver driver, const struct params *machine, const struct found *found) {
    if (driver == BY_FOUND) *p = found->written.params;
    else if (driver == BY_TRUTH || driver == BY_PID || driver == BY_TUNED) *p = *machine;
    else make_wrong(p, machine);
    if (driver == BY_TUNED) tune(p);
    p->control.law = driver == BY_PID || driver == BY_TUNED ? CONTROL_PID : CONTROL_MODEL;
    if (driver == BY_METHOD_A) take_matrix(p, found->ident.result.method_a.mt);
}

static void cell(const struct params *machine, const struct params *controller) {
    struct control_figures f;
    control_drive(machine, controller, NULL, 1, &f);
    if (f.faulted) printf(" %s |", fault_name(f.fault));
    else table_print(table_worst(&f));
    fflush(stdout);
}

static void rate_cell(const struct params *machine, const struct params *controller, int rate) {
    struct params m = *machine, c = *controller;
    table_tests(&m.tests, rate);
    c.tests = m.tests;
    cell(&m, &c);
}

/* The machines' own tests with tuned gains; the payload of the law is 30 % too light. */
static void tables_of_modes(void) {
    static const char *const files[] = {"config/desktop.yaml", "config/simulator.yaml"};
    static const char *const laws[] = {"PID", "model"};
    static struct params machine, wrong;
    printf("\n| gains of the modes | all as the slowest | as tuned |\n| --- | --- | --- |\n");
    for (int row = 0; row < 4; row++) {
        configure_file(&machine, files[row / 2], 0.0);
        make_wrong(&wrong, &machine);
        tune(&wrong);
        double tuned = wrong.control.modal;
        wrong.control.law = row % 2 ? CONTROL_MODEL : CONTROL_PID;
        printf("| %s, %s, control.modal %g |", files[row / 2], laws[row % 2], tuned);
        for (int with = 0; with < 2; with++) {
            wrong.control.modal = with ? tuned : 0.0;
            cell(&machine, &wrong);
        }
        puts("");
    }
}

/* An argument selects one frequency, without dry friction and without the tables of the modes. */
int main(int argc, char **argv) {
    static struct params machine, wrong, controller;
    static struct found found;
    double only_hz = argc > 1 ? atof(argv[1]) : 0.0;
    printf("hexid %s\n", version);
    for (int friction = 0; friction < (only_hz > 0.0 ? 1 : FRICTIONS); friction++) {
        configure(&machine, DRY_N[friction]);
        make_wrong(&wrong, &machine);
        identify(&machine, &wrong, &found);
        printf("\n| %g N of dry friction |", DRY_N[friction]);
        for (int rate = 0; rate < RATES; rate++)
            if (!(only_hz > 0.0) || HZ[rate] == only_hz) printf(" %g Hz |", HZ[rate]);
        printf("\n| --- | %s\n", only_hz > 0.0 ? "--- |" : "--- | --- | --- | --- |");
        for (int driver = 0; driver < DRIVERS; driver++) {
            make_driver(&controller, (enum driver)driver, &machine, &found);
            printf("| %s |", driver_names[driver]);
            for (int rate = 0; rate < RATES; rate++)
                if (!(only_hz > 0.0) || HZ[rate] == only_hz) rate_cell(&machine, &controller, rate);
            puts("");
        }
        recording_free(&found.recording);
    }
    if (!(only_hz > 0.0)) tables_of_modes();
    return 0;
}
