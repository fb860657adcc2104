/* Machines that differ from what the controller knows. Named cases first, then machines whose
 * parameters are all drawn at once, from one of two sets:
 *
 *     stated   each parameter within the tolerance that the configuration states or hexid gap takes
 *              (base.h), each leg for itself where it is each leg's, and the pressure sensors
 *     wide     payload +-30 %, its inertias +-20 % besides, oil +-30 %, valves +-10 % in common and
 *              +-3 % each, viscous friction and leakage +-50 %, supply +-5 %
 *
 * both with 0 to 100 N of dry friction and 0 to 2 ms of delay. Neither law knows any of it. The
 * margins are those of `hexid tune` and `hexid doctor` (loop_tune.h); the driven machine is the
 * closed form with its sensors. A machine is a function of its set and its number. */
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base.h"
#include "config.h"
#include "engine.h"
#include "failure.h"
#include "loop_tune.h"
#include "params.h"
#include "sort.h"
#include "version.h"

#include "../control_rig.h"
#include "../random.h"

enum { RATES = 2, MARGIN_DRAWS = 1000, DRIVE_DRAWS = 200, MARGINS = 3 };
static const double HZ[RATES] = {4.0, 8.0}, AMPLITUDE_M[RATES] = {4e-3, 1.5e-3}, AMPLITUDE_RAD[RATES] = {6e-3, 2e-3};
static const double DRY_MOST_N = 100.0, DELAY_MOST_S = 2e-3;

enum set { STATED, WIDE, SETS };
static const char *const set_names[SETS] = {"stated", "wide"};

/* Who drives: a law with gains. */
enum { DRIVERS = 4 };
static const struct driver {
    const char *name;
    enum control_law law;
    bool tuned;
} drivers[DRIVERS] = {{"PID, as shipped", CONTROL_PID, false},
                      {"PID, as tuned", CONTROL_PID, true},
                      {"model, gains as shipped", CONTROL_MODEL, false},
                      {"model, gains as tuned", CONTROL_MODEL, true}};

/* The configuration with its motion as shipped, and the gains that `hexid tune` finds for it.
 * `nominal` has the tests of the named cases. */
struct bench {
    struct params nominal;
    struct test_params short_tests; /* tests of the drawn machines */
    struct control_params tuned;
};

static void fail(const char *what) {
    fprintf(stderr, "robust: %s\n", what);
    exit(1);
}

static void bench_init(struct bench *b) {
    struct error error;
    struct loop_tune *tune = malloc(sizeof *tune);
    if (config_load(&b->nominal, NULL, NULL, 0, &error)) fail(error.text);
    if (!tune || loop_tune(&b->nominal, false, false, tune, &error)) fail("no gains");
    b->tuned = tune->gains;
    b->nominal.tests.settle_s = 0.5, b->nominal.tests.duration_s = 3.0;
    b->short_tests = b->nominal.tests;
    b->short_tests.settle_s = 0.2, b->short_tests.ramp_s = 0.5, b->short_tests.duration_s = 1.0;
    b->nominal.sim.engine = ENGINE_CLOSED_FORM;
    b->nominal.interlocks = (struct interlock_params){0};
    free(tune);
}

/* ---- machines ---- */

static double *effect_value(struct params *p, const char *name, int key) {
    struct effect_values *of = &p->effects[effect_find(name)];
    of->on = true;
    return of->value[key];
}

static void fill(double value[LEGS], double of_all) {
    for (int leg = 0; leg < LEGS; leg++) value[leg] = of_all;
}

static void scale(double value[LEGS], double by) {
    for (int leg = 0; leg < LEGS; leg++) value[leg] *= by;
}

static void scale_payload(struct params *p, double mass, double inertia) {
    struct payload_params *load = &p->payload;
    load->mass_kg *= mass;
    load->inertia_xx_kg_m2 *= inertia, load->inertia_yy_kg_m2 *= inertia, load->inertia_zz_kg_m2 *= inertia;
    load->inertia_xy_kg_m2 *= inertia, load->inertia_xz_kg_m2 *= inertia, load->inertia_yz_kg_m2 *= inertia;
}

static void delay(struct params *p, double delay_s) { fill(effect_value(p, "command_delay", 0), delay_s); }

static void rub(struct params *p, double dry_n) {
    fill(effect_value(p, "cylinder_coulomb_friction", 0), dry_n);
    fill(effect_value(p, "cylinder_coulomb_friction", 1), dry_n);
}

/* Gives each leg's pressures this lag. */
static void lag(struct params *p, int leg, double lag_s) {
    effect_value(p, "pressure_sensor_lag", 0)[leg] = lag_s > 0.0 ? 1.0 / (2.0 * PI * lag_s) : 1e5;
}

/* Makes the state of the random numbers of a machine; SplitMix64, so that neighbours have nothing
 * in common. */
static uint64_t seed_of(enum set set, int number) {
    uint64_t x = (uint64_t)number * SETS + (uint64_t)set + 1;
    x *= 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

static double uniform(uint64_t *r, double least, double most) { return least + 0.5 * (most - least) * (1.0 + random_unit(r)); }

/* Returns a number of standard deviation 1, never beyond 3: a sum of nine uniform ones. */
static double normal(uint64_t *r) {
    double sum = 0.0;
    for (int i = 0; i < 9; i++) sum += random_unit(r);
    return sum / sqrt(3.0);
}

static bool is_sensor_error(const struct variable *v) {
    size_t first = offsetof(struct params, errors);
    return v->offset >= first && v->offset < first + sizeof(struct sensor_errors);
}

/* Draws what the base of hexid gap lists: masses, oil, valves, friction, supply, valves' nulls and
 * the zeros of the pressures. Joints are left out: they only displace the true pose. The plant has
 * no member `errors`, so draw_pressures() sets the errors of sensors as effects. */
static void draw_base(struct params *p, const struct params *nominal, uint64_t *r) {
    static struct variable v[FIT_VARIABLES];
    int joints = effect_find("geometry_error"), count = base_variables(nominal, EQUATIONS_ALL & ~EQUATIONS_FORCE_SENSOR, v);
    for (int i = 0; i < count; i++) {
        double value = v[i].prior_inverse_std > 0.0 ? v[i].neutral + normal(r) / v[i].prior_inverse_std : uniform(r, v[i].min, v[i].max);
        if (!is_sensor_error(&v[i]) && v[i].effect != joints) variable_set(&v[i], p, value);
    }
}

static void draw_pressures(struct params *p, uint64_t *r) {
    const struct tolerance_params *t = &p->model.tolerance;
    double common_s = fabs(normal(r)) * t->pressure_lag_s;
    for (int leg = 0; leg < LEGS; leg++) {
        for (int key = 0; key < 2; key++) effect_value(p, "pressure_sensor_scale", key)[leg] = 1.0 + t->pressure_gain * normal(r);
        lag(p, leg, fmax(common_s + 0.5 * t->pressure_lag_s * normal(r), 0.0));
    }
}

static void draw_wide(struct params *p, uint64_t *r) {
    struct hydraulics_params *h = &p->hydraulics;
    double mass = uniform(r, 0.7, 1.3), valves = uniform(r, 0.9, 1.1);
    scale_payload(p, mass, mass * uniform(r, 0.8, 1.2));
    scale(h->bulk_modulus_pa, uniform(r, 0.7, 1.3));
    scale(h->viscous_n_s_per_m, uniform(r, 0.5, 1.5));
    scale(h->leakage_m3_per_s_pa, uniform(r, 0.5, 1.5));
    for (int leg = 0; leg < LEGS; leg++) h->valve_flow_m3_per_s[leg] *= valves * uniform(r, 0.97, 1.03);
    h->supply_pa *= uniform(r, 0.95, 1.05);
}

static void draw(struct params *p, const struct params *nominal, enum set set, int number) {
    uint64_t r = seed_of(set, number);
    *p = *nominal;
    if (set == STATED) draw_base(p, nominal, &r), draw_pressures(p, &r);
    else draw_wide(p, &r);
    rub(p, uniform(&r, 0.0, DRY_MOST_N));
    delay(p, uniform(&r, 0.0, DELAY_MOST_S));
}

/* ---- margins ---- */

struct margins {
    bool stable;
    double value[MARGINS]; /* gain margin, dB; phase margin, degrees; damping of the slowest mode */
};

/* An unstable loop has no margin: 0. */
static struct margins margins_of(const struct params *machine, const struct control_params *gains) {
    static struct params p;
    struct loop_standing s;
    struct error error;
    p = *machine;
    p.control = *gains;
    if (loop_tune_stand(&p, false, &s, &error)) fail(error.text);
    return (struct margins){s.stable, {s.stable ? s.gain_db.value : 0.0, s.stable ? s.phase_deg.value : 0.0, s.damping.value}};
}

/* Value below which this share of the ascending numbers lies. */
static double quantile(int count, const double *ascending, double share) { return ascending[(int)(share * (count - 1) + 0.5)]; }

static void margin_rows(const struct bench *b, enum set set, bool tuned, int draws) {
    static const char *const what[MARGINS] = {"gain margin, dB", "phase margin, degrees", "damping of the slowest mode"};
    static double value[MARGINS][MARGIN_DRAWS];
    static struct params machine;
    const struct control_params *gains = tuned ? &b->tuned : &b->nominal.control;
    struct margins nominal = margins_of(&b->nominal, gains);
    int unstable = 0, least_of[MARGINS] = {0};
    for (int n = 0; n < draws; n++) {
        draw(&machine, &b->nominal, set, n);
        struct margins m = margins_of(&machine, gains);
        unstable += !m.stable;
        for (int i = 0; i < MARGINS; i++) {
            value[i][n] = m.value[i];
            if (value[i][n] < value[i][least_of[i]]) least_of[i] = n;
        }
    }
    for (int i = 0; i < MARGINS; i++) {
        sort_ascending(draws, value[i]);
        printf("| %s, %s, %s | %.3g | %.3g | %.3g | %.3g | %.3g (%d) | %d |\n", set_names[set], tuned ? "tuned" : "shipped", what[i],
               nominal.value[i], quantile(draws, value[i], 0.95), quantile(draws, value[i], 0.5), quantile(draws, value[i], 0.05),
               value[i][0], least_of[i], unstable);
    }
    fflush(stdout);
}

static void margin_table(const struct bench *b, int draws) {
    printf("\n| %d machines | as configured | 95 %% | median | 5 %% | least (number) | unstable |\n"
           "| --- | --- | --- | --- | --- | --- | --- |\n",
           draws);
    for (int set = 0; set < SETS; set++)
        for (int tuned = 0; tuned < 2; tuned++) margin_rows(b, (enum set)set, tuned, draws);
}

/* ---- one parameter at a time ---- */

/* Sets one parameter to one end of the wide set: end 0 or 1. */
static void payload_end(struct params *p, int end) { scale_payload(p, end ? 1.3 : 0.7, end ? 1.3 : 0.7); }
static void oil_end(struct params *p, int end) { scale(p->hydraulics.bulk_modulus_pa, end ? 1.3 : 0.7); }
static void valves_end(struct params *p, int end) { scale(p->hydraulics.valve_flow_m3_per_s, end ? 1.13 : 0.87); }
static void viscous_end(struct params *p, int end) { scale(p->hydraulics.viscous_n_s_per_m, end ? 1.5 : 0.5); }
static void leakage_end(struct params *p, int end) { scale(p->hydraulics.leakage_m3_per_s_pa, end ? 1.5 : 0.5); }
static void supply_end(struct params *p, int end) { p->hydraulics.supply_pa *= end ? 1.05 : 0.95; }
static void delay_end(struct params *p, int end) { delay(p, end ? DELAY_MOST_S : 0.0); }

static const struct {
    const char *name;
    void (*set)(struct params *p, int end);
} ends[] = {{"payload -30, +30 %", payload_end}, {"oil -30, +30 %", oil_end},         {"valves -13, +13 %", valves_end},
            {"viscous -50, +50 %", viscous_end}, {"leakage -50, +50 %", leakage_end}, {"supply -5, +5 %", supply_end},
            {"delay 0, 2 ms", delay_end}};
enum { ENDS = sizeof ends / sizeof *ends };

static void print_margins(const struct params *machine, const struct control_params *gains) {
    struct margins m = margins_of(machine, gains);
    if (m.stable) printf(" %.1f / %.0f / %.2f |", m.value[0], m.value[1], m.value[2]);
    else printf(" unstable |");
}

/* Margins with one parameter at its ends, alone and beside a delay of 2 ms. */
static void end_table(const struct bench *b) {
    static struct params machine;
    printf("\n| parameter | shipped: low | high | low, and 2 ms | high, and 2 ms | tuned: low | high | low, and 2 ms | high, and 2 ms |\n"
           "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
    for (int i = 0; i < ENDS; i++) {
        printf("| %s |", ends[i].name);
        for (int n = 0; n < 8; n++) {
            machine = b->nominal;
            if (n & 2) delay(&machine, DELAY_MOST_S);
            ends[i].set(&machine, n & 1);
            print_margins(&machine, n & 4 ? &b->tuned : &b->nominal.control);
        }
        puts("");
    }
    fflush(stdout);
}

/* ---- driven ---- */

static double worst_amplitude(const struct control_figures *f) {
    double most = 0.0;
    for (int i = 0; i < DOFS; i++) most = fmax(most, fabs(f->amplitude_pct[i]));
    return most;
}

/* Drives the machine with the knowledge of `known`. */
static struct control_figures drive(const struct bench *b, const struct params *machine, const struct params *known, const struct driver *d,
                                    int rate) {
    static struct params m, c;
    struct control_figures f;
    m = *machine, c = *known;
    if (d->tuned) c.control = b->tuned;
    c.control.delay_s = known->control.delay_s, c.control.law = d->law;
    for (int i = 0; i < DOFS; i++) m.tests.hz[i] = HZ[rate], m.tests.amplitude[i] = i < 3 ? AMPLITUDE_M[rate] : AMPLITUDE_RAD[rate];
    c.tests = m.tests;
    control_drive(&m, &c, NULL, 1, &f);
    return f;
}

static void print_cell(const struct control_figures *f) {
    if (f->faulted) printf(" `%s` %s, %.2f, %.2f |", fault_name(f->fault), state_names[f->faulted_in], f->still_mps2, f->true_mps2);
    else printf(" %.3f, %.2f, %.2f |", 1e3 * f->rms_m, f->still_mps2, f->true_mps2);
    fflush(stdout);
}

/* ---- named cases ---- */

/* Changes the machine, and for some cases what the law knows. */
typedef void change(struct params *machine, struct params *known);

static void as_known(struct params *m, struct params *k) { (void)m, (void)k; }
static void thought_half(struct params *m, struct params *k) { (void)m, scale_payload(k, 0.5, 0.5); }
static void thought_twice(struct params *m, struct params *k) { (void)m, scale_payload(k, 2.0, 2.0); }
static void has_half(struct params *m, struct params *k) { (void)k, scale_payload(m, 0.5, 0.5); }
static void has_twice(struct params *m, struct params *k) { (void)k, scale_payload(m, 2.0, 2.0); }
static void soft_oil(struct params *m, struct params *k) { (void)k, scale(m->hydraulics.bulk_modulus_pa, 0.5); }
static void late(struct params *m, struct params *k) { (void)k, delay(m, 3e-3); }
static void soft_and_late(struct params *m, struct params *k) { soft_oil(m, k), late(m, k); }
static void light_soft_late(struct params *m, struct params *k) { has_half(m, k), soft_and_late(m, k); }
static void heavy_soft_late(struct params *m, struct params *k) { has_twice(m, k), soft_and_late(m, k); }
static void weak_valve(struct params *m, struct params *k) { (void)k, m->hydraulics.valve_flow_m3_per_s[0] *= 0.5; }
static void dead_band(struct params *m, struct params *k) { (void)k, fill(effect_value(m, "valve_dead_band", 0), 0.02); }
static void dead_band_thought(struct params *m, struct params *k) { dead_band(k, m); }
static void dead_band_known(struct params *m, struct params *k) { dead_band(m, k), dead_band(k, k); }
static void low_supply(struct params *m, struct params *k) { (void)k, m->hydraulics.supply_pa *= 0.7; }
static void rubs(struct params *m, struct params *k) { (void)k, rub(m, DRY_MOST_N); }
static void late_pressures(struct params *m, struct params *k) {
    (void)k;
    for (int leg = 0; leg < LEGS; leg++) lag(m, leg, 3e-3);
}
static void pipes(struct params *m, struct params *k) { (void)k, m->hydraulics.pipe_length_m = 1.0; }

static const struct {
    const char *name;
    change *make;
} cases[] = {
    {"what the law knows", as_known},
    {"the law takes half of the payload", thought_half},
    {"the law takes twice the payload", thought_twice},
    {"half the payload", has_half},
    {"twice the payload", has_twice},
    {"oil of half its stiffness", soft_oil},
    {"3 ms more delay", late},
    {"soft oil and 3 ms", soft_and_late},
    {"half the payload, soft oil, 3 ms", light_soft_late},
    {"twice the payload, soft oil, 3 ms", heavy_soft_late},
    {"one valve at half its gain", weak_valve},
    {"a dead band of 2 %", dead_band},
    {"the same, known", dead_band_known},
    {"none, but the law takes 2 %", dead_band_thought},
    {"30 % less supply pressure", low_supply},
    {"100 N of dry friction", rubs},
    {"pressures 3 ms late", late_pressures},
    {"pipes of 1 m", pipes},
};
enum { CASES = sizeof cases / sizeof *cases };

static void named_row(const struct bench *b, int n) {
    static struct params machine, known;
    machine = known = b->nominal;
    cases[n].make(&machine, &known);
    printf("| %s |", cases[n].name);
    print_margins(&machine, &b->nominal.control), print_margins(&machine, &b->tuned);
    for (int d = 0; d < DRIVERS; d++)
        for (int rate = 0; rate < RATES; rate++) {
            struct control_figures f = drive(b, &machine, &known, &drivers[d], rate);
            print_cell(&f);
        }
    puts("");
}

static void named_table(const struct bench *b) {
    printf("\n| the machine has | margins, shipped | margins, tuned |");
    for (int d = 0; d < DRIVERS; d++)
        for (int rate = 0; rate < RATES; rate++) printf(" %s, %g Hz |", drivers[d].name, HZ[rate]);
    printf("\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
    for (int n = 0; n < CASES; n++) named_row(b, n);
}

/* ---- drawn machines, driven ---- */

/* What one driver made of the drawn machines. */
struct outcome {
    double rms_mm[MARGIN_DRAWS]; /* by number; NaN: a fault */
    double amplitude_pct[MARGIN_DRAWS], still_mps2[MARGIN_DRAWS], true_mps2[MARGIN_DRAWS];
    int faults;
    char faulted[2000]; /* number, fault, state, predicted gain margin, true acceleration of each */
};

static void note_fault(const struct bench *b, const struct params *machine, const struct driver *d, int number,
                       const struct control_figures *f, struct outcome *o) {
    size_t used = strlen(o->faulted);
    struct margins m = margins_of(machine, d->tuned ? &b->tuned : &b->nominal.control);
    snprintf(o->faulted + used, sizeof o->faulted - used, "%s %d %s %s (%.1f dB, %.2f)", o->faults++ ? "," : "", number,
             fault_name(f->fault), state_names[f->faulted_in], m.value[0], f->true_mps2);
}

static void drive_drawn(const struct bench *b, enum set set, int rate, const struct driver *d, int draws, struct outcome *o) {
    static struct params machine, known;
    known = b->nominal, known.tests = b->short_tests;
    o->faults = 0, o->faulted[0] = '\0';
    for (int n = 0; n < draws; n++) {
        draw(&machine, &known, set, n);
        struct control_figures f = drive(b, &machine, &known, d, rate);
        o->rms_mm[n] = f.faulted ? (double)NAN : 1e3 * f.rms_m;
        o->amplitude_pct[n] = worst_amplitude(&f), o->still_mps2[n] = f.still_mps2, o->true_mps2[n] = f.true_mps2;
        if (f.faulted) note_fault(b, &machine, d, n, &f, o);
    }
}

/* Median, 95 % and most of the machines without a fault. */
static void print_spread(const struct outcome *o, const double *value, int draws, const char *format) {
    static double kept[MARGIN_DRAWS];
    int count = 0;
    for (int n = 0; n < draws; n++)
        if (!isnan(o->rms_mm[n])) kept[count++] = value[n];
    if (!count) fail("no machine was driven without a fault");
    sort_ascending(count, kept);
    for (int i = 0; i < 3; i++) {
        fputs(i ? ", " : " | ", stdout);
        printf(format, quantile(count, kept, i == 0 ? 0.5 : i == 1 ? 0.95 : 1.0));
    }
}

static int worse_than(const struct outcome *o, const struct outcome *pid, int draws) {
    int count = 0;
    for (int n = 0; n < draws; n++) count += o->rms_mm[n] > pid->rms_mm[n];
    return count;
}

/* The tuned gains are driven at the first frequency only: stability does not depend on it. */
static void drive_rows(const struct bench *b, enum set set, int rate, int draws) {
    static struct outcome outcome[DRIVERS];
    for (int d = 0; d < DRIVERS; d++) {
        if (drivers[d].tuned && rate > 0) continue;
        struct outcome *o = &outcome[d];
        drive_drawn(b, set, rate, &drivers[d], draws, o);
        printf("| %s, %g Hz: %s | %d", set_names[set], HZ[rate], drivers[d].name, o->faults);
        print_spread(o, o->rms_mm, draws, "%.3f"), print_spread(o, o->amplitude_pct, draws, "%.2g");
        print_spread(o, o->still_mps2, draws, "%.2f"), print_spread(o, o->true_mps2, draws, "%.2f");
        if (drivers[d].law == CONTROL_MODEL) printf(" | %d |", worse_than(o, &outcome[d - DRIVERS / 2], draws));
        else printf(" | |");
        printf(" %s |\n", o->faulted);
        fflush(stdout);
    }
}

/* only: name of a set, or NULL: both. */
static void drive_table(const struct bench *b, int draws, const char *only) {
    printf("\n| %d machines | faults | rms, mm | amplitude, %% | unexpected, m/s^2 | true | worse than PID | faults |\n"
           "| --- | --- | --- | --- | --- | --- | --- | --- |\n",
           draws);
    for (int set = 0; set < SETS; set++)
        for (int rate = 0; rate < RATES && (!only || !strcmp(only, set_names[set])); rate++) drive_rows(b, (enum set)set, rate, draws);
}

/* ---- one machine ---- */

/* Puts a group of parameters back to what the configuration says. */
enum group { PAYLOAD, OIL, VALVES, VISCOUS, LEAKAGE, SUPPLY, DRY, DELAY, GROUPS };
static const char *const group_names[GROUPS] = {"payload", "oil",    "valves",       "viscous friction",
                                                "leakage", "supply", "dry friction", "delay"};

static void put_back(struct params *p, const struct params *nominal, enum group group) {
    struct hydraulics_params *h = &p->hydraulics;
    const struct hydraulics_params *from = &nominal->hydraulics;
    if (group == PAYLOAD) p->payload = nominal->payload, p->actuator = nominal->actuator;
    if (group == OIL) memcpy(h->bulk_modulus_pa, from->bulk_modulus_pa, sizeof h->bulk_modulus_pa);
    if (group == VALVES) memcpy(h->valve_flow_m3_per_s, from->valve_flow_m3_per_s, sizeof h->valve_flow_m3_per_s);
    if (group == VISCOUS) memcpy(h->viscous_n_s_per_m, from->viscous_n_s_per_m, sizeof h->viscous_n_s_per_m);
    if (group == LEAKAGE) memcpy(h->leakage_m3_per_s_pa, from->leakage_m3_per_s_pa, sizeof h->leakage_m3_per_s_pa);
    if (group == SUPPLY) h->supply_pa = from->supply_pa;
    if (group == DRY) rub(p, 0.0);
    if (group == DELAY) delay(p, 0.0);
}

static void print_machine(const struct params *p, const struct params *nominal) {
    const struct hydraulics_params *h = &p->hydraulics, *from = &nominal->hydraulics;
    printf("payload %.3f, Ixx %.3f, oil %.3f, valve 1 %.3f, viscous %.3f, leakage %.3f, supply %.3f of the configured; ",
           p->payload.mass_kg / nominal->payload.mass_kg, p->payload.inertia_xx_kg_m2 / nominal->payload.inertia_xx_kg_m2,
           h->bulk_modulus_pa[0] / from->bulk_modulus_pa[0], h->valve_flow_m3_per_s[0] / from->valve_flow_m3_per_s[0],
           h->viscous_n_s_per_m[0] / from->viscous_n_s_per_m[0], h->leakage_m3_per_s_pa[0] / from->leakage_m3_per_s_pa[0],
           h->supply_pa / from->supply_pa);
    printf("dry %.1f N, delay %.2f ms\n", p->effects[effect_find("cylinder_coulomb_friction")].value[0][0],
           1e3 * p->effects[effect_find("command_delay")].value[0][0]);
}

static void print_driven(const struct bench *b, const char *name, const struct params *machine) {
    struct margins m = margins_of(machine, &b->nominal.control);
    printf("| %s | %s, %.1f / %.0f / %.3f |", name, m.stable ? "stable" : "unstable", m.value[0], m.value[1], m.value[2]);
    for (int d = 0; d < DRIVERS; d++) {
        struct control_figures f = drive(b, machine, &b->nominal, &drivers[d], 0);
        print_cell(&f);
    }
    puts("");
}

/* Prints the machine, and how it drives at 4 Hz with each group of parameters put back in turn. */
static void one_machine(const struct bench *b, enum set set, int number) {
    static struct params machine, other;
    draw(&machine, &b->nominal, set, number);
    machine.tests = b->short_tests;
    print_machine(&machine, &b->nominal);
    print_driven(b, "as drawn", &machine);
    for (int group = 0; group < GROUPS; group++) {
        other = machine;
        put_back(&other, &b->nominal, (enum group)group);
        print_driven(b, group_names[group], &other);
    }
}

static int count_of(const char *text, int most) {
    int count = text ? atoi(text) : most;
    if (count < 1 || count > MARGIN_DRAWS) fail("a number of machines, 1 to 1000");
    return count;
}

/* Usage: robust [named | ends | margins [COUNT] | drives [COUNT [SET]] | SET NUMBER]; SET is stated
 * or wide. */
int main(int argc, char **argv) {
    static struct bench b;
    const char *what = argc > 1 ? argv[1] : "", *number = argc > 2 ? argv[2] : NULL;
    printf("hexid %s\n", version);
    bench_init(&b);
    if (!*what || !strcmp(what, "named")) named_table(&b);
    if (!*what || !strcmp(what, "ends")) end_table(&b);
    if (!*what || !strcmp(what, "margins")) margin_table(&b, count_of(number, MARGIN_DRAWS));
    if (!*what || !strcmp(what, "drives")) drive_table(&b, count_of(number, DRIVE_DRAWS), argc > 3 ? argv[3] : NULL);
    for (int set = 0; set < SETS; set++)
        if (!strcmp(what, set_names[set]) && number) one_machine(&b, (enum set)set, atoi(number));
    return 0;
}
