/* The control laws on the rig by other means (tests/rig/), beside hexid's own plant with the same
 * base: the sines, friction and figures of `make bench-control`. The law `model` is driven with the
 * configured numbers, with those of `hexid identify --model` from six sines and a survey under the
 * PID, and with the true ones. Prints tables for docs/validation.md: a base as configured, then
 * bases drawn within model.tolerance, each leg's for itself; median and worst. */
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis.h"
#include "failure.h"
#include "loop_survey.h"
#include "machine_found.h"
#include "method_c.h"
#include "multisine.h"
#include "params.h"
#include "plant.h"
#include "trajectory_file.h"
#include "version.h"

#include "../../rig/bridge.h"
#include "../control_table.h"

/* Longest step of the rig, s. Half of it changes figures by their last digit. */
static const double STEP_S = 1e-3;
enum { SEEDS_MOST = 64, NOISE_SEED = 1 };

enum plant_kind { BY_OTHER_MEANS, OWN, PLANTS };
static const char *const plant_names[PLANTS] = {"the rig by other means", "hexid's own plant"};

enum driver { BY_PID, BY_CONFIGURED, BY_FOUND, BY_TRUTH, DRIVERS };
static const char *const driver_names[DRIVERS] = {"PID as shipped", "model, as configured", "model, as `identify --model` wrote it",
                                                  "model, the truth"};

/* What the command line chooses. */
struct choice {
    double hz, dry_n;  /* 0, and below 0: all of the table */
    int seeds;         /* number of bases drawn within the tolerance */
    int drivers;       /* number of rows */
    const char *only;  /* as in bridge_setup */
    bool drives[PLANTS];
};

/* Results of all drivers on one base. A run that ended in a fault has no numbers. */
struct column {
    struct table_cell cell[DRIVERS][RATES];
    uint32_t fault[DRIVERS][RATES];
    int doubts[DRIVERS][RATES]; /* cycles in which the law handed over to the PID */
};

static void measure_rig(void *state, struct hal_sample *sample) { bridge_measure(state, sample->length_m, sample->p1_pa, sample->p2_pa); }
static void pose_of_rig(void *state, double pose[DOFS]) { bridge_pose(state, pose); }
static void step_rig(void *state, const double valve[LEGS]) { bridge_step(state, valve); }

static struct bridge *make_bridge(const struct bridge_setup *setup, struct bridge_base *base) {
    struct bridge *bridge = bridge_create(setup, base);
    if (!bridge) fail("no rig");
    return bridge;
}

/* A machine at rest. truth: the parameters of its base. */
static void make_machine(struct control_machine *m, enum plant_kind kind, const struct bridge_setup *setup, const struct params *truth) {
    struct bridge_base base;
    if (kind == OWN) control_make_plant(m, truth, NOISE_SEED);
    else
        *m = (struct control_machine){make_bridge(setup, &base), &truth->payload, truth->loop.period_s, measure_rig, pose_of_rig, step_rig};
}

static void release(struct control_machine *m, enum plant_kind kind) {
    if (kind == OWN) plant_destroy(m->state);
    else bridge_destroy(m->state);
}

/* Gives the configuration the rig's base. */
static void take_base(struct params *p, const struct bridge_base *b) {
    struct payload_params *load = &p->payload;
    struct actuator_params *a = &p->actuator;
    struct hydraulics_params *h = &p->hydraulics;
    struct effect_values *null_bias = &p->effects[effect_find("valve_null_bias")];
    double *const of_payload[] = {&load->mass_kg,          &load->inertia_xx_kg_m2, &load->inertia_yy_kg_m2, &load->inertia_zz_kg_m2,
                                  &load->inertia_xy_kg_m2, &load->inertia_xz_kg_m2, &load->inertia_yz_kg_m2};
    for (size_t i = 0; i < sizeof of_payload / sizeof *of_payload; i++) *of_payload[i] *= b->payload;
    for (int leg = 0; leg < LEGS; leg++) {
        double dead_m3 = h->dead_volume_m3[leg];
        a->upper_mass_kg[leg] *= b->upper, a->upper_inertia_kg_m2[leg] *= b->upper;
        a->lower_mass_kg[leg] *= b->lower, a->lower_inertia_kg_m2[leg] *= b->lower;
        h->viscous_n_s_per_m[leg] *= b->viscous[leg], h->bulk_modulus_pa[leg] *= b->bulk[leg];
        h->leakage_m3_per_s_pa[leg] *= b->leakage[leg], h->valve_flow_m3_per_s[leg] *= b->gain[leg];
        h->dead_volume_m3[leg] = dead_m3 * b->dead1[leg], h->dead_volume_difference_m3[leg] = dead_m3 * (b->dead2[leg] - b->dead1[leg]);
        null_bias->on = null_bias->on || b->null_bias[leg] != 0.0;
        null_bias->value[0][leg] = b->null_bias[leg];
    }
}

/* Records a machine's run under the PID and identifies it. trajectory: NULL or the tests'
 * motion. */
static void identify(const struct control_machine *m, const struct params *controller, const struct trajectory *trajectory,
                     struct analysis *a) {
    struct error error;
    struct platform *platform = calloc(1, sizeof *platform);
    struct cycle c = {0};
    double pose[DOFS];
    if (!platform || platform_init(platform, controller, &error) || analysis_init(a, controller, &error)) fail(error.text);
    platform->trajectory = trajectory;
    for (int64_t i = 0; c.state != STATE_PARKING && c.state != STATE_FAULT; i++) {
        control_cycle(m, platform, i, pose, &c);
        analysis_take(a, &c);
        control_act(m, &c);
    }
    if (c.state == STATE_FAULT) fail(fault_name(c.first_fault));
    analysis_end(a);
    analysis_identify(a);
    if (!a->ident.result.method_c.matrix.evaluated) fail(a->ident.result.no_method_c.text);
    free(platform);
}

/* Drives the survey's motion, and finds oil, valves and delay. */
static void survey(const struct control_machine *m, const struct params *configured, struct analysis *a, struct loop_survey *s) {
    static struct params params;
    struct multisine motion;
    struct trajectory trajectory;
    struct error error;
    params = *configured;
    if (multisine_init(&motion, &params, &error) || multisine_trajectory(&motion, &trajectory, &error)) fail(error.text);
    params.tests.repeat = MULTISINE_PASSES, params.tests.duration_s = trajectory_s(&trajectory);
    snprintf(params.tests.trajectory, sizeof params.tests.trajectory, "survey");
    identify(m, &params, &trajectory, a);
    if (loop_survey(s, &motion, &a->recording, &a->ident.result.method_c, &error)) fail(error.text);
    trajectory_free(&trajectory);
}

/* Makes the configuration of `hexid identify SINES SURVEY --model`. */
static void find(enum plant_kind kind, const struct bridge_setup *setup, const struct params *truth, const struct params *configured,
                 struct machine_found *found) {
    static struct analysis sines, surveyed;
    static struct loop_survey s;
    struct control_machine m;
    struct error error;
    struct equations *sum = calloc(1, sizeof *sum);
    struct estimate *estimate = calloc(1, sizeof *estimate);
    struct method_c *both = calloc(1, sizeof *both);
    if (!sum || !estimate || !both) fail("out of memory");
    memset(&sines, 0, sizeof sines), memset(&surveyed, 0, sizeof surveyed);
    make_machine(&m, kind, setup, truth);
    identify(&m, configured, NULL, &sines);
    release(&m, kind);
    make_machine(&m, kind, setup, truth);
    survey(&m, configured, &surveyed, &s);
    release(&m, kind);
    equations_add(sum, &sines.equations), equations_add(sum, &surveyed.equations);
    if (method_c_solve(sum, &sines.calibrated, estimate, both, &error)) fail(error.text);
    machine_found(&sines.calibrated, both, estimate, found);
    machine_found_survey(&s, found);
    analysis_free(&sines), analysis_free(&surveyed);
    free(sum), free(estimate), free(both);
}

static void drive(enum plant_kind kind, const struct bridge_setup *setup, const struct params *truth, const struct choice *choice,
                  struct column *column) {
    static struct params configured, controller;
    static struct machine_found found;
    configure(&configured, 0.0);
    find(kind, setup, truth, &configured, &found);
    for (int driver = 0; driver < choice->drivers; driver++) {
        controller = driver == BY_TRUTH ? *truth : driver == BY_FOUND ? found.params : configured;
        controller.control.law = driver == BY_PID ? CONTROL_PID : CONTROL_MODEL;
        for (int rate = 0; rate < RATES; rate++) {
            struct control_figures f;
            struct control_machine m;
            if (choice->hz > 0.0 && HZ[rate] != choice->hz) continue;
            table_tests(&controller.tests, rate);
            make_machine(&m, kind, setup, truth);
            control_run(&m, &controller, NULL, &f);
            release(&m, kind);
            column->fault[driver][rate] = f.fault, column->doubts[driver][rate] = f.doubt_cycles;
            column->cell[driver][rate] = table_worst(&f);
        }
    }
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Columns, and the share of them that are to be below what is printed: 0.5 the median, 1 the
 * worst. */
struct sample {
    const struct column *column;
    int columns;
    double share;
};

/* Returns this quantile of each figure, over the columns without a fault. */
static struct table_cell quantile(struct sample s, int driver, int rate) {
    struct table_cell c;
    for (int k = 0; k < FIGURES; k++) {
        double value[SEEDS_MOST];
        int n = 0;
        for (int i = 0; i < s.columns; i++)
            if (!s.column[i].fault[driver][rate]) value[n++] = s.column[i].cell[driver][rate].figure[k];
        qsort(value, (size_t)n, sizeof *value, ascending);
        double place = s.share * (n - 1), low = floor(place);
        int at = n ? (int)low : 0;
        c.figure[k] = n ? value[at] + (place - low) * (value[at + 1 < n ? at + 1 : at] - value[at]) : (double)NAN;
    }
    return c;
}

static struct table_cell ratio(struct table_cell a, struct table_cell b) {
    for (int k = 0; k < FIGURES; k++) a.figure[k] /= b.figure[k];
    return a;
}

static void print_head(const char *what, double dry_n, const struct choice *choice) {
    printf("\n| %s; %g N of dry friction |", what, dry_n);
    for (int rate = 0; rate < RATES; rate++)
        if (!(choice->hz > 0.0) || HZ[rate] == choice->hz) printf(" %g Hz |", HZ[rate]);
    printf("\n| --- |");
    for (int rate = 0; rate < RATES; rate++)
        if (!(choice->hz > 0.0) || HZ[rate] == choice->hz) printf(" --- |");
    puts("");
}

/* Prints the quantile of each cell; if `by` is not NULL, as a multiple of its quantile. */
static void print_table(const struct choice *choice, struct sample of, const struct sample *by) {
    for (int driver = 0; driver < choice->drivers; driver++) {
        printf("| %s |", driver_names[driver]);
        for (int rate = 0; rate < RATES; rate++) {
            if (choice->hz > 0.0 && HZ[rate] != choice->hz) continue;
            struct table_cell c = quantile(of, driver, rate);
            if (!by) table_print(c);
            else {
                c = ratio(c, quantile(*by, driver, rate));
                printf(" %.2g / %.2g / %.2g / %.2g |", c.figure[0], c.figure[1], c.figure[2], c.figure[3]);
            }
        }
        puts("");
    }
}

/* Names each run that a fault ended, or in which the law handed over to the PID. */
static void print_doubts(const char *plant, const struct column *column, int columns) {
    for (int i = 0; i < columns; i++)
        for (int driver = 0; driver < DRIVERS; driver++)
            for (int rate = 0; rate < RATES; rate++) {
                uint32_t fault = column[i].fault[driver][rate];
                int doubts = column[i].doubts[driver][rate];
                if (!fault && !doubts) continue;
                printf("%s, base %d, %s, %g Hz: fault %s, %d cycles by the PID\n", plant, i, driver_names[driver], HZ[rate],
                       fault_name(fault), doubts);
            }
}

/* Prints a table with its head. */
static void print_whole(const char *what, double dry_n, const struct choice *choice, struct sample of, const struct sample *by) {
    print_head(what, dry_n, choice);
    print_table(choice, of, by);
}

static void print_tables(const struct choice *choice, double dry_n, struct column column[PLANTS][SEEDS_MOST + 1]) {
    const struct sample rig = {column[BY_OTHER_MEANS], 1, 0.5}, own = {column[OWN], 1, 0.5};
    int seeds = choice->seeds;
    for (int plant = 0; plant < PLANTS; plant++) {
        if (!choice->drives[plant]) continue;
        print_whole(plant_names[plant], dry_n, choice, (struct sample){column[plant], 1, 0.5}, NULL);
        for (int worst = 0; worst < 2 && seeds; worst++) {
            char what[100];
            snprintf(what, sizeof what, "%s, %s of %d bases", plant_names[plant], worst ? "worst" : "median", seeds);
            print_whole(what, dry_n, choice, (struct sample){&column[plant][1], seeds, worst ? 1.0 : 0.5}, NULL);
        }
        print_doubts(plant_names[plant], column[plant], seeds + 1);
    }
    if (!choice->drives[BY_OTHER_MEANS] || !choice->drives[OWN]) return;
    print_whole("rig over own plant", dry_n, choice, rig, &own);
    for (int worst = 0; worst < 2 && seeds; worst++) {
        double share = worst ? 1.0 : 0.5;
        const struct sample drawn = {&column[BY_OTHER_MEANS][1], seeds, share}, same = {&column[OWN][1], seeds, share};
        print_whole(worst ? "rig over own plant, worst of the bases" : "rig over own plant, median of the bases", dry_n, choice, drawn,
                    &same);
        print_whole(worst ? "worst of the rig's bases over own plant as configured"
                          : "median of the rig's bases over own plant as configured",
                    dry_n, choice, drawn, &own);
    }
}

static struct choice choose(int argc, char **argv) {
    struct choice c = {.dry_n = -1.0, .seeds = 8, .drivers = DRIVERS, .drives = {true, true}};
    for (int o; (o = getopt(argc, argv, "f:n:s:d:o:p:")) != -1;) {
        if (o == 'f') c.hz = atof(optarg);
        else if (o == 'n') c.dry_n = atof(optarg);
        else if (o == 's') c.seeds = atoi(optarg);
        else if (o == 'd') c.drivers = atoi(optarg);
        else if (o == 'o') c.only = optarg;
        else if (o == 'p') c.drives[BY_OTHER_MEANS] = *optarg == 'r', c.drives[OWN] = *optarg == 'o';
        else
            fail("usage: control [-f HZ] [-n DRY_FRICTION_N] [-s SEEDS] [-d ROWS] [-o PARAMETER] [-p rig|own]; -o: only this one is drawn");
    }
    if (!(c.seeds >= 0 && c.seeds <= SEEDS_MOST)) fail("-s: 0 to 64");
    if (!(c.drivers >= 1 && c.drivers <= DRIVERS)) fail("-d: 1 to 4");
    return c;
}

int main(int argc, char **argv) {
    static struct column column[PLANTS][SEEDS_MOST + 1];
    static struct params truth;
    const struct choice choice = choose(argc, argv);
    printf("hexid %s\n", version);
    for (int friction = 0; friction < FRICTIONS; friction++) {
        double dry_n = DRY_N[friction];
        if (choice.dry_n >= 0.0 && choice.dry_n != dry_n) continue;
        for (int seed = 0; seed <= choice.seeds; seed++) {
            const struct bridge_setup setup = {
                .tolerance_seed = seed ? seed : -1, .only = choice.only, .dry_n = dry_n, .step_s = STEP_S, .noise_seed = NOISE_SEED};
            struct bridge_base base;
            bridge_destroy(make_bridge(&setup, &base));
            configure(&truth, dry_n);
            take_base(&truth, &base);
            truth.sim.engine = ENGINE_CLOSED_FORM;
            for (int plant = 0; plant < PLANTS; plant++)
                if (choice.drives[plant]) drive((enum plant_kind)plant, &setup, &truth, &choice, &column[plant][seed]);
            fprintf(stderr, "base %d of %d\n", seed, choice.seeds);
        }
        print_tables(&choice, dry_n, column);
        fflush(stdout);
    }
    return 0;
}
