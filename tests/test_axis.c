/* One axis: the rig's CSV file is the only thing that the import and the gap workflow see of it. */
#include "admit_rig.h"
#include "axis_rig.h"

#include <stdlib.h>
#include <unistd.h>

#include "csv.h"
#include "gap.h"
#include "log.h"
#include "messages.h"
#include "numeric.h"
#include "statements.h"

static char directory[] = "/tmp/hexid_axis_XXXXXX";
static char csv_path[60], log_path[60];
static struct params params;

static int set_up(void **unused) {
    (void)unused;
    struct error error;
    if (!mkdtemp(directory)) return -1;
    snprintf(csv_path, sizeof csv_path, "%s/1.csv", directory);
    snprintf(log_path, sizeof log_path, "%s/1.lcm", directory);
    return config_load(&params, "config/axis.yaml", NULL, 0, &error);
}

static int tear_down(void **unused) {
    (void)unused;
    unlink(csv_path);
    unlink(log_path);
    return rmdir(directory);
}

static void load(struct recording *r) {
    struct csv_report report;
    struct error error;
    struct log_reader *log;
    struct log_event event;
    struct cycle cycle;
    char *base = config_text(&params);
    unlink(log_path); /* the import would keep an earlier log under another name, and rmdir() at the
                       * end would fail */
    if (csv_import(&(struct csv_source){.path = directory, .base = base}, log_path, &report, &error)) fail_msg("%s", error.text);
    free(base);
    recording_init(r, &params);
    assert_int_equal(log_open(&log, log_path, &error), 0);
    while (log_next(log, &event))
        if (!strcmp(event.channel, CHANNEL_STATE) && state_decode(event.data, event.size, &cycle)) recording_add(r, &cycle, &error);
    log_release(log);
}

static int try_to_solve(const struct rig *rig, uint64_t seed, struct gap_result *g, struct error *error) {
    struct recording r;
    struct gap_options options = {.replay = GAP_MOTION, .simulate = true, .threads = 2};
    run_rig(rig, seed, csv_path);
    params.loop.period_s = 1.0 / rig->rate_hz;
    params.axis.gravity_mps2 = rig->gravity_mps2;
    load(&r);
    int status = admit_rig(&r, true, error);
    if (!status) status = gap_solve(&params, &r, NULL, &options, g, NULL, error);
    recording_free(&r);
    return status;
}

static void solve(const struct rig *rig, uint64_t seed, struct gap_result *g) {
    struct error error;
    if (try_to_solve(rig, seed, g, &error)) fail_msg("%s", error.text);
}

/* Prints names, ambiguities and the gap on held-out cycles, one line per case. */
static void describe(const struct rig *rig, uint64_t seed, const struct gap_result *g) {
    printf("# %-8s %s, %4.0f Hz, %s, seed %d: %s", rig->electric ? "electric" : "cylinder", motion_names[rig->motion], rig->rate_hz,
           rig->hides ? rig->hides : "nothing", (int)seed, gap_verdict_names[g->verdict]);
    for (int i = 0; i < g->effects; i++) {
        printf(" %s z %.1f", effect_table[g->effect[i].effect]->name, g->effect[i].z);
        for (int key = 0; key < EFFECT_KEYS && effect_table[g->effect[i].effect]->keys[key].name; key++)
            printf(" %.4g+-%.2g", g->effect[i].values.value[key][0], g->effect[i].std[key][0]);
    }
    for (int i = 0; i < g->ambiguous; i++) printf(" | %s", effect_table[g->ambiguous_with[i]]->name);
    const struct gap_certainty *c = &g->certainty;
    printf("; probability %.3g", c->probability);
    for (int i = 0; i < c->others; i++) printf("%s%s", i ? " + " : ", else ", effect_table[c->other[i]]->name);
    if (c->probability < GAP_SURE) printf(" %.3g", c->other_probability);
    printf("%s; held out %.4f -> %.4f, noise %.4f; white %.2f -> %.2f; %.1f s\n", g->offset_rival ? " | constant force" : "",
           g->held_out_before.overall, g->held_out_after.overall, g->noise_floor.overall, g->white_before, g->white_after, g->seconds);
    fflush(stdout);
}

/* Returns the relative error of the values found against the rig's own. */
static double value_error(const struct rig *rig, const struct gap_effect *e) {
    double found = e->values.value[0][0], other = e->values.value[1][0];
    if (rig->coulomb_extend_n > 0.0) return fmax(fabs(found / rig->coulomb_extend_n - 1.0), fabs(other / rig->coulomb_retract_n - 1.0));
    if (rig->viscous_n_s_per_m > 0.0) return fabs((2000.0 + found) / (2000.0 + rig->viscous_n_s_per_m) - 1.0);
    if (rig->payload_kg > 0.0) return fabs((MASS_KG + found) / (MASS_KG + rig->payload_kg) - 1.0);
    if (rig->more_leakage > 0.0) return fabs(found / (1.0 + rig->more_leakage) - 1.0);
    if (rig->force_lag_s > 0.0) return fabs(found * 2.0 * PI * rig->force_lag_s - 1.0);
    if (rig->seal_n > 0.0) return fabs(0.5 * (found + other) / rig->seal_n - 1.0);
    double hidden = rig->overlap + rig->stribeck_n + rig->load_friction + rig->spring_n_per_m;
    return fabs(found / hidden - 1.0);
}

/* Values must agree within 10 % and the tolerance of the base. The height of the Stribeck peak may
 * be off by 30 %, because it shows only at low speed. */
static void assert_full_value(const struct rig *rig, const struct gap_effect *e) {
    double found = e->values.value[0][0], other = e->values.value[1][0];
    if (rig->coulomb_extend_n > 0.0) {
        /* a difference between the two directions is a constant force, which a force sensor
         * measures to only 0.5 % of its force: allow two of the stated deviations */
        assert_close((found + other) / (rig->coulomb_extend_n + rig->coulomb_retract_n), 1.0, 0.1);
        assert_close(found, rig->coulomb_extend_n, fmax(0.1 * rig->coulomb_extend_n, 2.0 * e->std[0][0]));
    } else {
        assert_below(value_error(rig, e), rig->stribeck_n > 0.0 ? 0.3 : 0.1);
        if (rig->seal_n > 0.0) assert_close(e->values.value[2][0], rig->seal_m, fmax(0.1 * rig->seal_m, 3.0 * e->std[2][0]));
    }
}

/* True if the effect cannot be told apart from the rig's. On a cylinder at one load, Coulomb
 * friction can be load-dependent friction. A mass on a level axis can be an error of scale of the
 * position or force sensor, and at one frequency a spring of negative stiffness. At one speed all
 * friction laws agree, and with two pressures also an error of scale of the pressure sensors. */
static bool alike(const struct rig *rig, const char *name) {
    double friction = rig->coulomb_extend_n + rig->viscous_n_s_per_m + rig->stribeck_n + rig->load_friction + rig->seal_n;
    bool scale = !strcmp(name, "pressure_sensor_scale") || !strcmp(name, "load_dependent_friction");
    if (rig->motion == TRIANGLE && friction > 0.0 && (!strncmp(name, "cylinder_", 9) || (scale && !rig->electric))) return true;
    if (rig->coulomb_extend_n > 0.0) return !strcmp(name, "load_dependent_friction");
    if (rig->payload_kg > 0.0 && rig->motion == SINE && !strcmp(name, "external_stiffness")) return true;
    return rig->payload_kg > 0.0 && (!strcmp(name, "position_sensor_scale") || !strcmp(name, "force_sensor_scale"));
}

static bool in_set(const struct gap_result *g, const char *name) {
    bool in = false;
    for (int i = 0; i < g->ambiguous; i++) in = in || !strcmp(effect_table[g->ambiguous_with[i]]->name, name);
    return in;
}

/* A known fault (docs/validation.md): beside another leakage at a single frequency, a lag of the
 * pressure sensors of some 0.2 ms may be named, which is not there. */
static bool lag_beside_leakage(const struct rig *rig, const struct gap_result *g) {
    return rig->motion == SINE && !strcmp(rig->hides, "internal_leakage") && g->effects == 2 &&
           !strcmp(effect_table[g->effect[1].effect]->name, "pressure_sensor_lag");
}

/* Asserts that the hidden effect is named, alone or in a set of effects that cannot be told
 * apart. */
static void assert_named(const struct rig *rig, const struct gap_result *g) {
    if (rig->motion == SINE) assert_true(g->one_hz > 0.0);
    if (rig->motion == CHIRP || rig->motion == MULTISINE) assert_true(g->one_hz == 0.0);
    if (!rig->hides) {
        assert_int_equal(g->verdict, GAP_NO_GAP);
        assert_int_equal(g->effects, 0);
        assert_true(g->certainty.probability >= GAP_SURE);
        return;
    }
    if (lag_beside_leakage(rig, g)) {
        assert_string_equal(effect_table[g->effect[0].effect]->name, rig->hides);
        assert_true(g->verdict == GAP_EFFECT_NAMED || g->verdict == GAP_PARTLY_NAMED);
        return;
    }
    assert_int_equal(g->effects, 1);
    const char *first = effect_table[g->effect[0].effect]->name;
    bool rival = strcmp(first, rig->hides) && alike(rig, first) && in_set(g, rig->hides);
    if (!rival) assert_string_equal(first, rig->hides);
    assert_true(g->verdict == GAP_EFFECT_NAMED || (g->verdict == GAP_AMBIGUOUS && g->ambiguous));
    assert_true(g->verdict == GAP_AMBIGUOUS || g->certainty.probability >= 0.95);
    for (int i = 0; i < g->ambiguous; i++) {
        const char *name = effect_table[g->ambiguous_with[i]]->name;
        assert_true(alike(rig, name) || !strcmp(name, rig->hides));
    }
    /* the rig sticks where the law slides, so the residual may be larger than the noise */
    double law = rig->motion == SINE ? 0.0 : 0.1 * g->held_out_before.overall;
    assert_below(g->held_out_after.overall, fmax(1.2 * g->noise_floor.overall, law));
    /* a triangle has one speed in either direction, and the residual beyond its frequencies does
     * not count */
    if (rig->motion == TRIANGLE && rig->coulomb_extend_n > 0.0) assert_below(g->held_out_after.overall, 0.02);
    if (!rival) assert_full_value(rig, &g->effect[0]);
}

enum { NOTHING, FRICTION, VISCOUS, STRIBECK, MASS, SEAL, LEAKS, DEAD_BAND, LOAD, ONE_WAY, SPRING, RIGS };
enum {
    MECHANICAL = LEAKS
}; /* the rigs before this one, and ONE_WAY and SPRING, need no
                              * pressures */
#define RIG .rate_hz = 1000.0, .stribeck_mps = 0.06
static const struct rig rigs[RIGS] = {
    [NOTHING] = {RIG},
    [FRICTION] = {RIG, .hides = "cylinder_coulomb_friction", .coulomb_extend_n = 80.0, .coulomb_retract_n = 80.0},
    [VISCOUS] = {RIG, .hides = "cylinder_viscous_friction", .viscous_n_s_per_m = 600.0},
    [STRIBECK] = {RIG, .hides = "cylinder_stribeck_friction", .stribeck_n = 300.0},
    [MASS] = {RIG, .hides = "payload_mass", .payload_kg = 25.0},
    [SEAL] = {RIG, .hides = "cylinder_dahl_friction", .seal_n = 80.0, .seal_m = 5e-4},
    [LEAKS] = {RIG, .hides = "internal_leakage", .more_leakage = 2.0},
    [DEAD_BAND] = {RIG, .hides = "valve_dead_band", .overlap = 0.02},
    [LOAD] = {RIG, .hides = "load_dependent_friction", .load_friction = 0.01},
    [ONE_WAY] = {RIG, .hides = "cylinder_coulomb_friction", .coulomb_extend_n = 120.0, .coulomb_retract_n = 40.0},
    [SPRING] = {RIG, .hides = "external_stiffness", .spring_n_per_m = 6e3},
};

/* Returns rig i with a cylinder, or with an electric drive at one of several rates, level or
 * upright. */
static struct rig variant(int i, bool electric, int seed) {
    static const double rates_hz[] = {1000.0, 200.0, 5000.0};
    struct rig one = rigs[i];
    one.electric = electric;
    if (electric) one.rate_hz = rates_hz[(i + seed) % 3], one.gravity_mps2 = seed % 2 ? 0.0 : 9.80665;
    /* Stribeck friction makes the rod stick too briefly for 200 Hz. */
    if (electric && one.stribeck_n > 0.0) one.rate_hz = seed % 2 ? 1000.0 : 5000.0, one.stribeck_n = 150.0;
    return one;
}

static double base_of(const struct gap_result *g, const char *name) {
    for (int i = 0; i < g->base_values; i++)
        if (!strcmp(g->base[i].name, name)) return g->base[i].value;
    return NAN;
}

/* Asserts that parameters of oil, valve and supply are known for a cylinder only, because a force
 * alone has no information about them. */
static void assert_base(const struct rig *rig, const struct gap_result *g) {
    static const char *const oil[] = {"hydraulics.bulk_modulus_pa", "hydraulics.leakage_m3_per_s_pa", "hydraulics.valve_flow_m3_per_s",
                                      "hydraulics.supply_pa",       "hydraulics.valve_damping",       "hydraulics.dead_volume_m3"};
    for (size_t i = 0; i < sizeof oil / sizeof *oil && rig->electric; i++) assert_true(isnan(base_of(g, oil[i])));
    assert_true(rig->electric || isfinite(base_of(g, oil[0])));
}

static void try_all(int count, bool electric, int seeds) {
    static struct gap_result g;
    for (int i = 0; i < count; i++)
        for (int seed = 1; seed <= seeds; seed++) {
            struct rig one = variant(i, electric, seed);
            solve(&one, (uint64_t)seed, &g);
            describe(&one, (uint64_t)seed, &g);
            assert_named(&one, &g);
            assert_base(&one, &g);
        }
}

static void what_a_cylinder_hides_is_named_and_nothing_else(void **unused) {
    (void)unused;
    slow_sweep();
    if (SANITIZED) skip_because(MINUTES_UNDER_SANITIZERS);
    try_all(DEAD_BAND + 1, false, more_cases() ? 2 : 1);
}

static void what_an_electric_axis_hides_is_named_by_its_force_alone(void **unused) {
    (void)unused;
    slow_sweep();
    try_all(MECHANICAL, true, more_cases() ? 3 : 1);
}

static void try_in(enum motion motion, int i, bool electric, int seed) {
    static struct gap_result g;
    struct rig one = variant(i, electric, seed);
    one.motion = motion;
    solve(&one, (uint64_t)seed, &g);
    describe(&one, (uint64_t)seed, &g);
    assert_named(&one, &g);
}

/* Covers motions at several rates: a sixth of the cases here, all in `make test-long`. Seals in
 * steps are left out, because near a step the fitted series rings at 5 kHz by more than the noise,
 * and the computed deflection of the seals with it. */
static void what_is_hidden_is_named_in_any_motion(void **unused) {
    (void)unused;
    slow_sweep();
    bool all = more_cases();
    for (int motion = TRIANGLE; motion < MOTIONS; motion++)
        for (int i = 0; i < (SANITIZED ? 2 : MECHANICAL); i++)
            if ((all || (motion + i) % 6 == 1) && !(motion == STEPS && i == SEAL)) try_in((enum motion)motion, i, true, motion);
}

/* Cases with two pressures take ten times as long. The corners of a triangle are sharper than the
 * rows resolve and could be taken for other effects. A mass hardly shows in slow motions; a dead
 * band in point-to-point motion comes with a zero error of the pressure sensors. */
static void what_a_cylinder_hides_is_named_in_any_motion(void **unused) {
    (void)unused;
    long_case();
    static const int shows[] = {NOTHING, FRICTION, VISCOUS, LEAKS, LOAD, SPRING};
    if (SANITIZED) skip_because(MINUTES_UNDER_SANITIZERS);
    try_in(TRIANGLE, DEAD_BAND, false, 11);
    try_in(TRIANGLE, NOTHING, false, 11);
    try_in(MULTISINE, DEAD_BAND, false, 1);
    for (int motion = TRIANGLE; motion < MOTIONS; motion++)
        for (size_t i = 0; i < sizeof shows / sizeof *shows; i++) try_in((enum motion)motion, shows[i], false, motion);
}

/* A lag no longer than an amplifier's belongs to the base; a longer one is an effect with a cut-off
 * frequency. */
static void a_lagging_force_sensor_is_named_where_it_lags_by_much(void **unused) {
    (void)unused;
    slow_sweep();
    static const enum motion motions[] = {TRIANGLE, CHIRP, STEPS, MULTISINE, RESTS};
    size_t step = SANITIZED ? 5 : more_cases() ? 1 : 3;
    static struct gap_result g;
    for (size_t i = 0; i < sizeof motions / sizeof *motions; i += step) {
        struct rig rig = {RIG, .electric = true, .motion = motions[i], .force_lag_s = 8e-4};
        solve(&rig, i + 1, &g);
        describe(&rig, i + 1, &g);
        assert_named(&rig, &g);
        rig.hides = "force_sensor_lag", rig.force_lag_s = 6e-3;
        solve(&rig, i + 1, &g);
        describe(&rig, i + 1, &g);
        assert_named(&rig, &g);
        assert_below(value_error(&rig, &g.effect[0]), 0.05);
    }
}

/* A force sensor that reads too much and a position sensor that reads too little look the same
 * unless a weight is known, so both are named. */
static void a_force_sensor_that_says_too_much_is_in_the_set_that_is_named(void **unused) {
    (void)unused;
    slow_sweep();
    static struct gap_result g;
    int scale = effect_find("force_sensor_scale");
    for (uint64_t seed = 1; seed <= (more_cases() ? 3 : 1); seed++) {
        struct rig rig = {RIG, .electric = true, .motion = MULTISINE, .hides = "force_sensor_scale", .force_more = 0.06};
        solve(&rig, seed, &g);
        describe(&rig, seed, &g);
        bool in_set = g.effects == 1 && g.effect[0].effect == scale;
        for (int i = 0; i < g.ambiguous; i++) in_set = in_set || g.ambiguous_with[i] == scale;
        assert_true(in_set && g.verdict == GAP_AMBIGUOUS);
        /* tolerance: the base determines the mass, and so the scale, to 1 % */
        if (g.effect[0].effect == scale) assert_close(g.effect[0].values.value[0][0], 1.06, 0.02);
    }
}

/* A radius taken for a diameter, or newtons for pounds, is one factor on all forces, friction and
 * inertia alike. */
static void a_force_in_another_unit_is_named_as_its_factor(void **unused) {
    (void)unused;
    slow_case();
    static const double factor[] = {2.0, 4.448};
    static struct gap_result g;
    int scale = effect_find("force_sensor_scale");
    for (int i = 0; i < 2; i++) {
        struct rig rig = {RIG, .electric = true, .hides = "force_sensor_scale", .force_more = factor[i] - 1.0};
        solve(&rig, 1, &g);
        describe(&rig, 1, &g);
        assert_true(g.effects >= 1 && g.effect[0].effect == scale);
        /* tolerance: the prior of a sensor's scale (0.09) pulls the value towards 1: 4.448 is found
         * as 4.24, and as 4.44 with a prior of 1.5 */
        assert_close(g.effect[0].values.value[0][0] / factor[i], 1.0, 0.06);
    }
}

/* Friction of seals varies along the stroke, which no law describes. If it varies by a fifth, dry
 * friction is still named; by three fifths, it is named together with a remainder. */
static void friction_that_differs_along_the_stroke_is_friction(void **unused) {
    (void)unused;
    slow_sweep();
    if (SANITIZED) skip_because(MINUTES_UNDER_SANITIZERS);
    static const enum motion motions[] = {SINE, TRIANGLE, CHIRP, POINT_TO_POINT, MULTISINE, RESTS};
    static struct gap_result g;
    struct rig rig = rigs[FRICTION];
    rig.electric = true, rig.coulomb_extend_n = rig.coulomb_retract_n = 300.0;
    for (size_t i = 0; i < (more_cases() ? sizeof motions / sizeof *motions : 1); i++) {
        rig.motion = motions[i], rig.along_stroke = 0.2;
        solve(&rig, 11, &g);
        describe(&rig, 11, &g);
        assert_int_equal(g.effects, 1);
        assert_string_equal(effect_table[g.effect[0].effect]->name, rig.hides);
        assert_full_value(&rig, &g.effect[0]);
    }
    rig.motion = TRIANGLE, rig.along_stroke = 0.6;
    solve(&rig, 11, &g);
    describe(&rig, 11, &g);
    assert_int_equal(g.verdict, GAP_PARTLY_NAMED);
    assert_int_equal(g.effects, 1);
    assert_string_equal(effect_table[g.effect[0].effect]->name, rig.hides);
    assert_close(g.effect[0].values.value[0][0], 300.0, 2.0 * g.effect[0].std[0][0]);
    assert_below(g.effect[0].std[0][0], 100.0);
    assert_true(g.certainty.probability >= 0.95 && g.statements > 0);
}

/* On one axis, friction in one direction and a constant force look the same. */
static void friction_in_one_direction_and_a_constant_force_are_not_told_apart(void **unused) {
    (void)unused;
    slow_case();
    static struct gap_result g;
    struct rig rig = {RIG, .electric = true, .coulomb_extend_n = 120.0, .coulomb_retract_n = 40.0};
    solve(&rig, 1, &g);
    describe(&rig, 1, &g);
    assert_int_equal(g.verdict, GAP_AMBIGUOUS);
    assert_true(g.offset_rival);
    assert_string_equal(effect_table[g.effect[0].effect]->name, "cylinder_coulomb_friction");
    assert_close(g.effect[0].values.value[0][0] / 120.0, 1.0, 0.1);
    assert_close(g.effect[0].values.value[1][0] / 40.0, 1.0, 0.1);
    /* this case, the alternative, yields nearly the same data */
    rig.coulomb_extend_n = rig.coulomb_retract_n = 80.0, rig.offset_n = -40.0;
    solve(&rig, 1, &g);
    describe(&rig, 1, &g);
    assert_true(g.verdict == GAP_AMBIGUOUS && g.offset_rival);
    /* this force is too large for friction in one direction; it may be the weight of an axis that
     * is not level */
    rig.offset_n = -300.0;
    solve(&rig, 1, &g);
    describe(&rig, 1, &g);
    assert_int_equal(g.verdict, GAP_EFFECT_NAMED);
    assert_string_equal(effect_table[g.effect[0].effect]->name, "cylinder_coulomb_friction");
    for (int way = 0; way < 2; way++) assert_close(g.effect[0].values.value[way][0] / 80.0, 1.0, 0.1);
    assert_close(base_of(&g, "axis.force_offset_n"), -300.0, 10.0);
    assert_non_null(strstr(g.reason, " N too low throughout: zeros of the force or pressure sensors, or another weight than "));
    rig.offset_n = -40.0;
    /* a constant force alone is a zero error of the sensor, and no finding */
    rig.coulomb_extend_n = rig.coulomb_retract_n = 0.0;
    solve(&rig, 1, &g);
    describe(&rig, 1, &g);
    assert_int_equal(g.verdict, GAP_NO_GAP);
    assert_close(base_of(&g, "axis.force_offset_n"), -40.0, 4.0);
    assert_non_null(strstr(g.reason, " N too low throughout"));
}

static const struct gap_effect *found(const struct gap_result *g, const char *name) {
    for (int i = 0; i < g->effects; i++)
        if (!strcmp(effect_table[g->effect[i].effect]->name, name)) return &g->effect[i];
    return NULL;
}

/* A load that falls as the rod extends is a spring of negative stiffness, such as a crane's boom or
 * an inverted pendulum, and no mass. */
static void a_spring_of_either_sign_is_found_beside_friction(void **unused) {
    (void)unused;
    long_case();
    if (SANITIZED) skip_because(MINUTES_UNDER_SANITIZERS);
    static struct gap_result g;
    static const double springs_n_per_m[] = {-8e3, 8e3};
    for (size_t i = 0; i < 2; i++) {
        struct rig rig = {RIG, .electric = true, .motion = CHIRP, .coulomb_extend_n = 150.0, .coulomb_retract_n = 150.0};
        rig.spring_n_per_m = springs_n_per_m[i];
        solve(&rig, 21, &g);
        describe(&rig, 21, &g);
        const struct gap_effect *spring = found(&g, "external_stiffness"), *friction = found(&g, "cylinder_coulomb_friction");
        assert_true(spring && friction && g.effects == 2);
        assert_close(spring->values.value[0][0] / springs_n_per_m[i], 1.0, 0.1);
        assert_close(friction->values.value[0][0] / 150.0, 1.0, 0.1);
    }
}

/* An arm's weight bends over the position, as no spring's force does. */
static void a_weight_on_a_lever_is_found_beside_friction(void **unused) {
    (void)unused;
    slow_case();
    static struct gap_result g;
    struct rig rig = {RIG, .electric = true, .motion = POINT_TO_POINT, .coulomb_extend_n = 150.0, .coulomb_retract_n = 150.0};
    rig.lever_n = 400.0, rig.lever_m = 0.08, rig.lever_rad = 0.6;
    solve(&rig, 22, &g);
    describe(&rig, 22, &g);
    const struct gap_effect *load = found(&g, "lever_load"), *friction = found(&g, "cylinder_coulomb_friction");
    assert_true(load && friction && g.effects == 2);
    double slope = rig.lever_n * cos(rig.lever_rad) / rig.lever_m, bend = -rig.lever_n * sin(rig.lever_rad) / square(rig.lever_m);
    assert_close(load->values.value[0][0] / slope, 1.0, 0.05);
    assert_close(load->values.value[1][0] / bend, 1.0, 0.1);
    assert_close(load->values.value[2][0] * square(rig.lever_m), 1.0, 0.2);
    assert_close(friction->values.value[0][0] / 150.0, 1.0, 0.1);
}

typedef void change(struct recording_sample *s);

/* A robot's joint turned to and fro: its inertia is less than half of what is stated, its friction
 * differs a little along the way and its gear has teeth, so that a remainder is left. */
static void write_joint(uint64_t seed) {
    FILE *f = fopen(csv_path, "w");
    assert_non_null(f);
    fprintf(f, "# mechanism: axis\n# dof: none\nt_s,position_m,force_n\n");
    for (int i = 0; i < 5500; i++) {
        double t = 0.01 * i, w = 2.0 * PI * 0.1, x = 1.55 * sin(w * t), v = 1.55 * w * cos(w * t), wave = 2.0 * PI * x;
        double dry = 1.34 * (1.0 + 0.03 * sin(wave / 1.7 + 1.0)), viscous = 2.2 * (1.0 + 0.03 * sin(wave / 0.9));
        double force = -0.4 * w * w * x + dry * tanh(v / 5e-3) + viscous * v + 0.3 * sin(14.0 * wave) + 0.1 * gauss(&seed);
        fprintf(f, "%.3f,%.6f,%.5f\n", t, x + 1e-5 * gauss(&seed), force);
    }
    fclose(f);
}

/* Adds the hypothesis of an effect for all legs to a set, at its typical strength. */
static void add_effect(const struct diagnosis *d, const char *name, struct set *one) {
    static struct hypothesis list[HYPOTHESES_MAX];
    int n = hypotheses_list(d->given, &d->model, (const bool[EFFECTS_MAX]){0}, d->even.equations, list);
    for (int i = 0; i < n; i++) {
        if (list[i].effect != effect_find(name) || list[i].pattern != PATTERN_ALL) continue;
        one->hypothesis[one->effects++] = list[i];
        assert_true(hypothesis_at(&list[i], 1.0, &one->model));
    }
}

/* Begins the diagnosis of a recording of the rig. */
static void diagnose(const struct rig *rig, uint64_t seed, struct recording *r, struct diagnosis *d) {
    struct error error;
    params.loop.period_s = 1.0 / rig->rate_hz;
    run_rig(rig, seed, csv_path);
    load(r);
    assert_int_equal(admit_rig(r, false, &error), 0);
    assert_int_equal(diagnosis_init(d, &params, r, 2, &error), 0);
}

static double rms(const struct diagnosis *d, const double *white) { return sqrt(fit_square(d->fit.values, white) / d->fit.evaluated); }

/* Where the friction of a leg does not follow the balance of forces, its seals are still deflected
 * as the balance says: a piece of any motion begins with seals that are deflected already. */
static void seals_of_a_leg_that_may_be_held_are_deflected_as_before(void **unused) {
    (void)unused;
    numbers_case();
    struct rig rig = {RIG, .electric = true, .motion = CHIRP, .coulomb_extend_n = 5.0, .coulomb_retract_n = 5.0};
    rig.seal_n = 150.0, rig.seal_m = 4e-3;
    struct recording r;
    static struct diagnosis d;
    static struct set found;
    diagnose(&rig, 23, &r, &d);
    found = (struct set){.model = d.model};
    add_effect(&d, "cylinder_coulomb_friction", &found);
    add_effect(&d, "cylinder_dahl_friction", &found);
    assert_true(diagnosis_assume(&d, found.effects, found.hypothesis, &found.model));
    double *white = calloc((size_t)d.fit.values, sizeof *white),
           *column = calloc((size_t)d.fit.values * (size_t)d.variables, sizeof *column);
    assert_true(white && column && fit_residual(&d.fit, &d.model, white));
    double before = rms(&d, white);
    held_residuals(&d, white, column);
    assert_below(rms(&d, white), 1.5 * before);
    free(white);
    free(column);
    diagnosis_free(&d);
    recording_free(&r);
}

/* Friction that falls with the speed, and a load that bends, are in the result of a search, where
 * the machine has their limiting cases: dry friction and a spring. */
static void laws_give_way_to_their_limiting_cases(void **unused) {
    (void)unused;
    slow_case();
    struct rig rig = {RIG, .electric = true, .motion = CHIRP, .coulomb_extend_n = 150.0, .coulomb_retract_n = 150.0};
    rig.spring_n_per_m = -8e3;
    struct recording r;
    static struct diagnosis d;
    static struct gap_result g;
    static struct set found;
    struct gap_certainty certainty;
    diagnose(&rig, 21, &r, &d);
    g.base_model = d.model;
    found = (struct set){.model = d.model};
    add_effect(&d, "lever_load", &found);
    add_effect(&d, "cylinder_stribeck_friction", &found);
    assert_int_equal(found.effects, 2);
    g.effects = 1, g.effect[0] = (struct gap_effect){.effect = effect_find("clock_skew"), .z = 8.0};
    assert_true(statements_weigh(&d, &g, &found, 0, NULL, &certainty));
    assert_int_equal(g.effects, 3);
    assert_string_equal(effect_table[g.effect[0].effect]->name, "cylinder_coulomb_friction");
    assert_string_equal(effect_table[g.effect[1].effect]->name, "external_stiffness");
    assert_string_equal(effect_table[g.effect[2].effect]->name, "clock_skew");
    assert_true(g.effect[0].z > g.effect[1].z && g.effect[1].z > 8.0);
    assert_memory_equal(g.effect[0].evidence, "force: odd harmonics", 20);
    assert_close(g.effect[1].values.value[0][0] / -8e3, 1.0, 0.1);
    assert_true(certainty.probability >= GAP_SURE && d.found[effect_find("external_stiffness")] && !d.found[effect_find("lever_load")]);
    diagnosis_free(&d);
    recording_free(&r);
}

/* A friction that seals have besides is no simpler law than theirs, although it is a limiting case
 * of it. */
static void a_limiting_case_beside_its_law_is_not_simpler(void **unused) {
    (void)unused;
    numbers_case();
    struct rig rig = {RIG, .electric = true, .motion = CHIRP, .coulomb_extend_n = 100.0, .coulomb_retract_n = 100.0};
    rig.seal_n = 150.0, rig.seal_m = 1e-3;
    struct recording r;
    static struct diagnosis d;
    static struct gap_result g;
    static struct set found, more;
    struct gap_certainty certainty;
    diagnose(&rig, 24, &r, &d);
    g.base_model = d.model;
    found = (struct set){.model = d.model};
    add_effect(&d, "cylinder_dahl_friction", &found);
    more = found;
    add_effect(&d, "cylinder_coulomb_friction", &more);
    g.effects = 1, g.effect[0].effect = effect_find("cylinder_dahl_friction");
    assert_false(statements_weigh(&d, &g, &found, 1, &more, &certainty));
    assert_int_equal(g.effects, 1);
    diagnosis_free(&d);
    recording_free(&r);
}

/* A sensor's error is as small on a small machine as on a large one, and a friction of 1 N is as
 * likely there as one of a kilonewton elsewhere. */
static void a_small_machine_lacks_a_mass_and_not_a_sensor(void **unused) {
    (void)unused;
    slow_sweep();
    if (SANITIZED) skip_because(MINUTES_UNDER_SANITIZERS);
    struct params given = params;
    params.axis.mass_kg = 1.0, params.loop.period_s = 0.01;
    for (int leg = 0; leg < LEGS; leg++) params.actuator.stroke_m[leg] = 3.8, params.hydraulics.viscous_n_s_per_m[leg] = 0.0;
    for (uint64_t seed = 1; seed <= (more_cases() ? 3 : 1); seed++) {
        struct recording r;
        struct gap_result g;
        struct gap_options options = {.replay = GAP_MOTION, .simulate = true, .threads = 2};
        struct error error;
        write_joint(seed);
        load(&r);
        int status = admit_rig(&r, false, &error);
        if (!status) status = gap_solve(&params, &r, NULL, &options, &g, NULL, &error);
        if (status) fail_msg("%s", error.text);
        recording_free(&r);
        print_message("# %s", gap_verdict_names[g.verdict]);
        for (int i = 0; i < g.effects; i++) print_message(" %s", effect_table[g.effect[i].effect]->name);
        print_message("\n");
        assert_non_null(found(&g, "cylinder_viscous_friction"));
        for (int i = 0; i < g.effects; i++) {
            enum effect_family family = effect_table[g.effect[i].effect]->family;
            assert_true(family != EFFECT_SENSORS && family != EFFECT_TIMING);
        }
    }
    params = given;
}

static void flip_force(struct recording_sample *s) { s->force_n[0] = -s->force_n[0]; }
static void flip_position(struct recording_sample *s) { s->length_m[0] = -s->length_m[0]; }
static void exchange_ports(struct recording_sample *s) {
    double p1_pa = s->p1_pa[0];
    s->p1_pa[0] = s->p2_pa[0], s->p2_pa[0] = p1_pa;
    s->force_n[0] = A1 * s->p1_pa[0] - A2 * s->p2_pa[0];
}
static void flip_valve(struct recording_sample *s) { s->valve[0] = -s->valve[0]; }
static void millimetres(struct recording_sample *s) { s->length_m[0] *= 1e3; }
static void kilonewtons(struct recording_sample *s) { s->force_n[0] *= 1e-3; }
static void hundredfold(struct recording_sample *s) { s->force_n[0] *= 1e2; }
static void zero_force(struct recording_sample *s) { s->force_n[0] = 0.0; }
static void clip_pressure(struct recording_sample *s) { s->p2_pa[0] = fmin(4.0 * s->p2_pa[0], 16e6); }
static void shake(struct recording_sample *s) {
    static uint64_t dice = 7;
    s->force_n[0] += 4e4 * random_unit(&dice);
}
static void pump_up(struct recording_sample *s) { s->p1_pa[0] += 5e6 * A2 / A1, s->p2_pa[0] += 5e6; }

static void recordings_that_lie_are_refused_for_what_they_are(void **unused) {
    (void)unused;
    slow_case();
    static const struct {
        change *change;
        bool electric;
        const char *says;
    } lies[] = {
        {flip_force, true, "sign of force or position"},
        {flip_position, true, "sign of force or position"},
        {exchange_ports, false, "p1 and p2 are exchanged"},
        {flip_position, false, "sign"},
        {flip_valve, false, "valve command"},
        {millimetres, true, "other units"},
        {kilonewtons, true, "other units"},
        {hundredfold, true, "other units"},
        {zero_force, true, "does not change"},
        {clip_pressure, false, "clipped"},
        {shake, true, "of what varies in the forces"},
        {pump_up, false, "another supply"},
    };
    struct rig rig = {RIG};
    for (size_t n = 0; n < sizeof lies / sizeof *lies; n++) {
        struct recording r;
        struct error error = {0};
        rig.electric = lies[n].electric;
        run_rig(&rig, 1, csv_path);
        load(&r);
        for (int i = 0; i < r.tests; i++)
            for (int j = 0; j < r.test[i].count; j++) lies[n].change(&r.test[i].sample[j]);
        int status = admit_rig(&r, true, &error);
        recording_free(&r);
        if (status != STATUS_USAGE || !strstr(error.text, lies[n].says))
            fail_msg("%d: \"%s\" does not say \"%s\"", (int)n, error.text, lies[n].says);
    }
}

/* The bursts fall anywhere: the fitted series bridges them, and segments that become too noisy (at
 * 100 Hz) are left out. */
static void rows_lost_in_bursts_cost_nothing(void **unused) {
    (void)unused;
    slow_sweep();
    static const struct {
        enum motion motion;
        bool electric;
        double rate_hz, share;
        int seed;
    } cases[] = {{TRIANGLE, true, 1000.0, 0.01, 12},      {STEPS, true, 5000.0, 0.01, 12},  {RESTS, true, 200.0, 0.01, 12},
                 {POINT_TO_POINT, true, 100.0, 0.03, 14}, {CHIRP, false, 1000.0, 0.01, 12}, {MULTISINE, false, 1000.0, 0.01, 12}};
    static const size_t few = 4, all = sizeof cases / sizeof *cases;
    size_t step = more_cases() ? 1 : 3; /* here a triangle at 1 kHz and point to point at 100 Hz */
    static struct gap_result g;
    for (size_t i = 0; i < (SANITIZED ? 1 : more_cases() ? all : few); i += step) {
        struct rig one = variant(FRICTION, cases[i].electric, cases[i].seed);
        one.motion = cases[i].motion, one.rate_hz = cases[i].rate_hz, one.lost_share = cases[i].share;
        solve(&one, (uint64_t)cases[i].seed, &g);
        describe(&one, (uint64_t)cases[i].seed, &g);
        assert_named(&one, &g);
    }
}

/* Users leave the reversals out of a record, and then the motion there is unknown. */
static void a_record_without_its_reversals_is_refused(void **unused) {
    (void)unused;
    slow_case();
    static struct gap_result g;
    static const double lost_s[] = {0.01, 0.02, 0.045};
    for (int i = 0; i < 6; i++) {
        struct rig rig = {RIG, .motion = TRIANGLE, .electric = i % 2, .lost_s = lost_s[i / 2]};
        struct error error = {0};
        int status = try_to_solve(&rig, 11, &g, &error);
        if (status != STATUS_USAGE || !strstr(error.text, "missing where the motion turns sharply"))
            fail_msg("%g s: \"%s\"", lost_s[i / 2], error.text);
    }
}

/* Prints how many of `seeds` are right, alone and as the first of an ambiguous set, and each of
 * them. */
static void print_row(int i, bool electric, enum motion motion, int seeds) {
    static struct gap_result g;
    int alone = 0, first = 0;
    double noise = 0.0, value = 0.0;
    for (int seed = 11; seed < 11 + seeds; seed++) {
        struct rig one = variant(i, electric, seed);
        one.motion = motion;
        solve(&one, (uint64_t)seed, &g);
        bool right = one.hides ? g.effects == 1 && !strcmp(effect_table[g.effect[0].effect]->name, one.hides) : g.verdict == GAP_NO_GAP;
        alone += right && g.verdict != GAP_AMBIGUOUS, first += right && g.verdict == GAP_AMBIGUOUS;
        noise = fmax(noise, g.held_out_after.overall / g.noise_floor.overall);
        if (right && one.hides) value = fmax(value, value_error(&one, &g.effect[0]));
        describe(&one, (uint64_t)seed, &g);
    }
    printf("%-8s %-15s %-28s %2d + %2d of %d, values within %.1f %%, held out at most %.3f of the noise\n",
           electric ? "electric" : "cylinder", motion_names[motion], rigs[i].hides ? rigs[i].hides : "nothing", alone, first, seeds,
           100.0 * value, noise);
    fflush(stdout);
}

/* Prints the table for the sine or, with a second argument, for every other motion. Leakage, dead
 * band and load-dependent friction need pressures. */
static void print_table(int seeds, enum motion first, enum motion last) {
    for (int electric = 1; electric >= 0; electric--)
        for (int motion = (int)first; motion <= (int)last; motion++)
            for (int i = 0; i < RIGS; i++)
                if (!electric || i < MECHANICAL || i >= ONE_WAY) print_row(i, electric, (enum motion)motion, seeds);
}

int main(int argc, char **argv) {
    if (argc > 1) {
        int status = set_up(NULL);
        if (!status) print_table(atoi(argv[1]), argc > 2 ? TRIANGLE : SINE, argc > 2 ? RESTS : SINE);
        return status ? status : tear_down(NULL);
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_a_cylinder_hides_is_named_and_nothing_else),
        cmocka_unit_test(what_an_electric_axis_hides_is_named_by_its_force_alone),
        cmocka_unit_test(what_is_hidden_is_named_in_any_motion),
        cmocka_unit_test(what_a_cylinder_hides_is_named_in_any_motion),
        cmocka_unit_test(recordings_that_lie_are_refused_for_what_they_are),
        cmocka_unit_test(rows_lost_in_bursts_cost_nothing),
        cmocka_unit_test(a_record_without_its_reversals_is_refused),
        cmocka_unit_test(a_lagging_force_sensor_is_named_where_it_lags_by_much),
        cmocka_unit_test(a_force_sensor_that_says_too_much_is_in_the_set_that_is_named),
        cmocka_unit_test(a_force_in_another_unit_is_named_as_its_factor),
        cmocka_unit_test(friction_that_differs_along_the_stroke_is_friction),
        cmocka_unit_test(a_spring_of_either_sign_is_found_beside_friction),
        cmocka_unit_test(a_weight_on_a_lever_is_found_beside_friction),
        cmocka_unit_test(friction_in_one_direction_and_a_constant_force_are_not_told_apart),
        cmocka_unit_test(seals_of_a_leg_that_may_be_held_are_deflected_as_before),
        cmocka_unit_test(laws_give_way_to_their_limiting_cases),
        cmocka_unit_test(a_limiting_case_beside_its_law_is_not_simpler),
        cmocka_unit_test(a_small_machine_lacks_a_mass_and_not_a_sensor),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
