/* The whole controller, platform_step(), on the simulated machine. Whatever happens, in every cycle of every test here: valves are centred
 * unless the state holds the platform, commands are finite and within +-1, and the reference neither jumps nor outruns the limits. */
#include "support.h"

#include "plant.h"
#include "platform.h"
#include "units.h"

enum { PERIOD_NS = 2000000 };

struct rig {
    struct params params;
    struct plant *plant;
    struct platform platform;
    struct cycle now, before;
    int64_t cycles;
    uint32_t id;                    /* of the last request */
    int cut_leg;                    /* its valve's cable is cut, -1: none */
    double largest_valve_step;      /* driven cycles, engage included */
    double leg_ref_before[LEGS];
};

typedef void spoiler(struct hal_sample *sample, int cycle);

/* Short tests and moves; nothing else differs from the default. */
static struct params brisk(void) {
    struct params params;
    config_default(&params);
    params.sim.engine = ENGINE_CLOSED_FORM;
    params.tests.settle_s = 0.1, params.tests.ramp_s = 0.25, params.tests.duration_s = 0.5, params.tests.ramp_out_s = 0.2;
    params.motion.engage_s = params.motion.park_s = 2.0;
    params.motion.hold_s = 0.1;
    return params;
}

static void rig_init(struct rig *rig, const struct params *params) {
    struct error error;
    memset(rig, 0, sizeof *rig);
    rig->params = *params;
    rig->cut_leg = -1;
    rig->plant = plant_create(&rig->params, 1, &error);
    assert_non_null(rig->plant);
    assert_int_equal(platform_init(&rig->platform, &rig->params, &error), STATUS_OK);
}

static struct params by_hand(void) {
    struct params params = brisk();
    params.motion.automatic = false;
    return params;
}

static void check_always(struct rig *rig) {
    const struct cycle *c = &rig->now;
    bool drives = supervisor_drives(c->state), drove = rig->cycles > 0 && supervisor_drives(rig->before.state);
    assert_int_equal(c->out.enable, drives);
    assert_true(drives == (c->out.enable && !c->faults));
    assert_int_equal(c->state == STATE_FAULT, c->faults != 0);
    assert_int_equal(c->seq, rig->cycles);
    for (int i = 0; i < LEGS; i++) {
        double step = c->out.valve[i] - rig->before.out.valve[i];
        if (!drives) assert_true(c->out.valve[i] == 0.0);
        assert_true(c->out.valve[i] >= -1.0 && c->out.valve[i] <= 1.0);
        assert_true(isfinite(c->pose[i]) && isfinite(c->ref[i]) && isfinite(c->force_n[i]));
        if (drives) rig->largest_valve_step = fmax(rig->largest_valve_step, fabs(step));
        /* No leg is told to outrun its own limit; where driving starts, it starts where the leg is. */
        double from = drove ? rig->leg_ref_before[i] : rig->platform.length_m[i];
        if (drives) assert_below(fabs(rig->platform.leg_ref_m[i] - from), rig->params.limits.leg_rate_mps * rig->params.loop.period_s);
        rig->leg_ref_before[i] = rig->platform.leg_ref_m[i];
    }
}

static void rig_request(struct rig *rig, struct request request, spoiler *spoil, int cycle) {
    static const double centred[LEGS] = {0};
    struct hal_sample sample = {.time_ns = rig->cycles * PERIOD_NS, .device_seq = (uint64_t)rig->cycles + 1};
    double valve[LEGS];
    plant_measure(rig->plant, &sample);
    if (spoil) spoil(&sample, cycle);
    rig->before = rig->now;
    platform_step(&rig->platform, &sample, request, &rig->now);
    check_always(rig);
    memcpy(valve, rig->now.out.enable ? rig->now.out.valve : centred, sizeof valve);
    if (rig->cut_leg >= 0) valve[rig->cut_leg] = 0.0;
    plant_step(rig->plant, valve);
    rig->cycles++;
}

/* One cycle; a command other than none is a new request. */
static void rig_cycle(struct rig *rig, enum command command) {
    if (command != COMMAND_NONE) rig->id++;
    rig_request(rig, (struct request){.id = rig->id, .command = command}, NULL, 0);
}

static void rig_run(struct rig *rig, int cycles) {
    for (int n = 0; n < cycles; n++) rig_cycle(rig, COMMAND_NONE);
}

static void rig_until(struct rig *rig, enum state state) {
    for (int n = 0; rig->now.state != state; n++) {
        rig_cycle(rig, COMMAND_NONE);
        if (n == 5000)
            fail_msg("10 s later still %s (%s), not %s", state_names[rig->now.state], fault_name(rig->now.first_fault), state_names[state]);
    }
}

/* From wherever it is, so many cycles into this state. */
static void rig_bring(struct rig *rig, enum state state, int cycles) {
    static const enum command next[STATES] = {
        [STATE_SETTLED] = COMMAND_ENGAGE, [STATE_READY] = COMMAND_START, [STATE_FAULT] = COMMAND_RESET};
    for (int n = 0; rig->now.state != state; n++) {
        enum command command = next[rig->now.state];
        if (rig->now.state == STATE_READY && state == STATE_PARKING) command = COMMAND_PARK;
        rig_cycle(rig, command);
        assert_true(n < 5000);
    }
    rig_run(rig, cycles);
    assert_int_equal(rig->now.state, state);
}

static const enum state held[] = {STATE_ENGAGING, STATE_READY, STATE_TESTING, STATE_PARKING};
enum { HELD = 4 };

/* ---- the run ---- */

static void automatic_run_tests_every_axis_and_ends_put_down(void **unused) {
    (void)unused;
    static const enum state story[] = {STATE_INIT,    STATE_SETTLED, STATE_ENGAGING, STATE_READY,
                                       STATE_TESTING, STATE_READY,   STATE_PARKING,  STATE_SETTLED};
    struct params params = brisk();
    struct rig rig;
    int chapter = 0, evaluated[DOFS] = {0};
    rig_init(&rig, &params);
    for (int n = 0; n < 20000 && (n == 0 || rig.platform.automatic); n++) {
        rig_cycle(&rig, COMMAND_NONE);
        const struct cycle *c = &rig.now;
        if (c->state != story[chapter]) assert_int_equal(c->state, story[++chapter]);
        if (c->phase == PHASE_EVALUATE) {
            assert_int_equal(c->dof, params.tests.order[c->test]);
            evaluated[c->test]++;
            assert_below(distance(c->pose, c->ref, DOFS), 1e-3); /* a lag of 10 degrees at 4 Hz is 0.7 mm of 4 */
        }
        assert_int_equal(c->test >= 0, c->phase != PHASE_NONE);
    }
    assert_int_equal(chapter, 7);
    for (int i = 0; i < DOFS; i++) assert_int_equal(evaluated[i], 250);
    struct plant_truth truth;
    plant_get_truth(rig.plant, &truth);
    assert_close(truth.pose[DOF_Z], params.motion.park_z_m, 2e-3);
    print_message("# largest valve step of a run: %.3f\n", rig.largest_valve_step);
    assert_below(rig.largest_valve_step, 0.2);
    rig_run(&rig, 500); /* and stays */
    assert_int_equal(rig.now.state, STATE_SETTLED);
    plant_destroy(rig.plant);
}

static void nothing_moves_without_engage(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    static const enum command others[] = {COMMAND_START, COMMAND_STOP, COMMAND_PARK, COMMAND_RESET, COMMAND_NONE};
    rig_init(&rig, &params);
    for (int n = 0; n < 500; n++) rig_cycle(&rig, others[n % 5]);
    assert_int_equal(rig.now.state, STATE_SETTLED);
    plant_destroy(rig.plant);
}

/* ---- limits ---- */

static void leg_too_short(struct hal_sample *s, int cycle) { (void)cycle, s->length_m[1] = 1.42; }
static void leg_too_long(struct hal_sample *s, int cycle) { (void)cycle, s->length_m[5] = 2.25; }
static void leg_too_fast(struct hal_sample *s, int cycle) { s->length_m[2] += (s->length_m[2] > 1.8 ? -2e-3 : 2e-3) * (cycle + 1); }
static void force_too_large(struct hal_sample *s, int cycle) { (void)cycle, s->p1_pa[3] = 6e6, s->p2_pa[3] = 0.0; }
static void pressure_too_high(struct hal_sample *s, int cycle) { (void)cycle, s->p1_pa[0] = 16.6e6, s->p2_pa[0] = 16.6e6; }
static void pressure_too_low(struct hal_sample *s, int cycle) { (void)cycle, s->p2_pa[4] = -2.1e5; }
static void length_not_a_number(struct hal_sample *s, int cycle) { (void)cycle, s->length_m[0] = (double)NAN; }
static void length_infinite(struct hal_sample *s, int cycle) { (void)cycle, s->length_m[5] = (double)INFINITY; }
static void pressure_not_a_number(struct hal_sample *s, int cycle) { (void)cycle, s->p2_pa[5] = (double)NAN; }
static void flagged_invalid(struct hal_sample *s, int cycle) { (void)cycle, s->flags |= SAMPLE_INVALID; }
static void flagged_io(struct hal_sample *s, int cycle) { (void)cycle, *s = (struct hal_sample){.flags = SAMPLE_IO}; }
static void too_old(struct hal_sample *s, int cycle) { (void)cycle, s->age_ns = 10000001; }
static void from_the_future(struct hal_sample *s, int cycle) { (void)cycle, s->age_ns = -1; }
static void all_not_a_number(struct hal_sample *s, int cycle) {
    (void)cycle;
    for (int i = 0; i < LEGS; i++) s->length_m[i] = s->p1_pa[i] = s->p2_pa[i] = (double)NAN;
}

static const struct {
    const char *what;
    spoiler *spoil;
    uint32_t headline;
} bad[] = {
    {"leg too short", leg_too_short, FAULT_STROKE},
    {"leg too long", leg_too_long, FAULT_STROKE},
    {"leg too fast", leg_too_fast, FAULT_LEG_RATE},
    {"force too large", force_too_large, FAULT_FORCE},
    {"pressure too high", pressure_too_high, FAULT_SENSOR_INVALID},
    {"pressure too low", pressure_too_low, FAULT_SENSOR_INVALID},
    {"length not a number", length_not_a_number, FAULT_SENSOR_INVALID},
    {"length infinite", length_infinite, FAULT_SENSOR_INVALID},
    {"pressure not a number", pressure_not_a_number, FAULT_SENSOR_INVALID},
    {"flagged invalid", flagged_invalid, FAULT_SENSOR_INVALID},
    {"not read", flagged_io, FAULT_IO},
    {"too old", too_old, FAULT_SENSOR_AGE},
    {"from the future", from_the_future, FAULT_SENSOR_AGE},
    {"nothing a number", all_not_a_number, FAULT_SENSOR_INVALID},
};
enum { BAD = sizeof bad / sizeof *bad };

static void spoil_cycles(struct rig *rig, spoiler *spoil, int cycles) {
    for (int n = 0; n < cycles; n++) rig_request(rig, (struct request){.id = rig->id}, spoil, n);
}

/* Whatever is asked for and however good the samples, a fault holds still until the reset; and then it waits to be engaged. */
static void assert_stays_still_until_reset(struct rig *rig) {
    static const enum command tempting[] = {COMMAND_ENGAGE, COMMAND_START, COMMAND_STOP, COMMAND_PARK, COMMAND_NONE};
    uint32_t faults = rig->now.faults, headline = rig->now.first_fault;
    for (int n = 0; n < 100; n++) {
        rig_cycle(rig, tempting[n % 5]);
        assert_int_equal(rig->now.state, STATE_FAULT);
        assert_int_equal(rig->now.faults, faults);
        assert_int_equal(rig->now.first_fault, headline);
    }
    rig_cycle(rig, COMMAND_RESET);
    assert_int_equal(rig->now.state, STATE_INIT);
    rig_run(rig, 100);
    assert_int_equal(rig->now.state, STATE_SETTLED);
}

static void each_limit_trips_in_bad_cycles_and_holds_until_reset(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    for (int b = 0; b < BAD; b++)
        for (int h = 0; h < HELD; h++) {
            rig_bring(&rig, held[h], 40);
            spoil_cycles(&rig, bad[b].spoil, params.limits.bad_cycles - 1);
            if (rig.now.state != held[h])
                fail_msg("%s in %s: tripped early (%s)", bad[b].what, state_names[held[h]], fault_name(rig.now.first_fault));
            rig_request(&rig, (struct request){.id = rig.id}, bad[b].spoil, params.limits.bad_cycles - 1);
            if (rig.now.state != STATE_FAULT) fail_msg("%s in %s: not tripped", bad[b].what, state_names[held[h]]);
            if (rig.now.first_fault != bad[b].headline)
                fail_msg("%s: headline %s, not %s", bad[b].what, fault_name(rig.now.first_fault), fault_name(bad[b].headline));
            assert_stays_still_until_reset(&rig);
        }
    rig_bring(&rig, STATE_READY, 0); /* none the worse for it */
    plant_destroy(rig.plant);
}

static void fewer_bad_samples_are_ridden_out_with_the_command_held(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    for (int b = 0; b < BAD; b++)
        for (int h = 0; h < HELD; h++) {
            rig_bring(&rig, held[h], 40);
            for (int length = 1; length < params.limits.bad_cycles; length++) {
                struct hal_command kept = rig.now.out;
                for (int n = 0; n < length; n++) {
                    rig_request(&rig, (struct request){.id = rig.id}, bad[b].spoil, n);
                    assert_memory_equal(kept.valve, rig.now.out.valve, sizeof kept.valve);
                    assert_true(rig.now.out.enable);
                    assert_true(rig.now.in.flags & (SAMPLE_INVALID | SAMPLE_IO)); /* the identifier leaves it out */
                }
                rig_run(&rig, 10);
                assert_int_equal(rig.now.in.flags, 0);
                assert_int_equal(rig.now.state, held[h]);
            }
            rig_run(&rig, 10);
        }
    print_message("# largest valve step with samples missing: %.3f\n", rig.largest_valve_step);
    assert_below(rig.largest_valve_step, 0.2);
    plant_destroy(rig.plant);
}

static void a_leg_that_does_not_follow_trips(void **unused) {
    (void)unused;
    struct params params = by_hand();
    params.limits.standstill_m = 1.0; /* or this would speak first */
    for (int leg = 0; leg < LEGS; leg++) {
        struct rig rig;
        int beyond = 0;
        rig_init(&rig, &params);
        rig_bring(&rig, STATE_ENGAGING, 100);
        rig.cut_leg = leg;
        while (rig.now.state == STATE_ENGAGING) {
            double ref = rig.platform.leg_ref_m[leg]; /* that the next sample is judged by */
            rig_cycle(&rig, COMMAND_NONE);
            if (fabs(ref - rig.now.in.length_m[leg]) > params.limits.following_m) beyond++;
        }
        assert_int_equal(rig.now.first_fault, FAULT_FOLLOWING);
        assert_int_equal(beyond, params.limits.bad_cycles);
        plant_destroy(rig.plant);
    }
}

/* A transducer dies while the platform moves. Without this its leg would follow a reference that it can never reach, to the end stop. */
static void a_length_that_stands_still_trips_before_its_leg_has_gone_far(void **unused) {
    (void)unused;
    struct params params = by_hand();
    static const enum state moving[] = {STATE_ENGAGING, STATE_TESTING, STATE_PARKING};
    params.tests.order[0] = DOF_Z; /* moves all legs by 3.6 mm */
    for (int m = 0; m < 3; m++)
        for (int leg = 0; leg < LEGS; leg++) {
            struct rig rig;
            double astray = 0.0;
            rig_init(&rig, &params);
            rig_bring(&rig, moving[m], 250);
            double frozen = rig.now.in.length_m[leg];
            while (rig.now.state == moving[m]) {
                struct hal_sample sample = {.time_ns = rig.cycles * PERIOD_NS};
                struct plant_truth truth;
                plant_measure(rig.plant, &sample);
                plant_get_truth(rig.plant, &truth);
                sample.length_m[leg] = frozen;
                astray = fmax(astray, fabs(truth.length_m[leg] - rig.platform.leg_ref_m[leg]));
                platform_step(&rig.platform, &sample, (struct request){.id = rig.id}, &rig.now);
                plant_step(rig.plant, rig.now.out.valve);
                rig.cycles++;
            }
            assert_int_equal(rig.now.first_fault, FAULT_STANDSTILL);
            assert_true(rig.platform.still_high_m[leg] - rig.platform.still_low_m[leg] > params.limits.standstill_m);
            double held_s = params.limits.bad_cycles * params.loop.period_s;
            assert_below(astray, 2 * params.limits.standstill_m + 0.4 * held_s); /* valves stay open at 0.4 m/s */
            plant_destroy(rig.plant);
        }
}

/* However the swing lies about the place where the reading stopped: its range counts. psi moves all legs by 2.5 mm from end to end. */
static void a_length_that_stands_still_in_a_test_trips_within_a_period(void **unused) {
    (void)unused;
    struct params params = by_hand();
    int ramped = (int)((params.tests.settle_s + params.tests.ramp_s) / params.loop.period_s);
    int period = (int)(1.0 / params.tests.frequency_hz / params.loop.period_s);
    params.tests.order[0] = DOF_PSI;
    for (int leg = 0; leg < LEGS; leg++)
        for (int at = 0; at < period; at += period / 5) {
            struct rig rig;
            rig_init(&rig, &params);
            rig_bring(&rig, STATE_TESTING, ramped + at);
            double frozen = rig.now.in.length_m[leg];
            int cycles = 0;
            for (; rig.now.state == STATE_TESTING; cycles++) {
                struct hal_sample sample = {.time_ns = rig.cycles++ * PERIOD_NS};
                plant_measure(rig.plant, &sample);
                sample.length_m[leg] = frozen;
                platform_step(&rig.platform, &sample, (struct request){.id = rig.id}, &rig.now);
                plant_step(rig.plant, rig.now.out.valve);
            }
            assert_int_equal(rig.now.first_fault, FAULT_STANDSTILL);
            assert_in_range(cycles, 1, period + params.limits.bad_cycles);
            plant_destroy(rig.plant);
        }
}

static void a_leg_with_much_dry_friction_does_not_stand_still_for_long_enough_to_trip(void **unused) {
    (void)unused;
    struct params params = brisk();
    struct rig rig;
    int effect = effect_find("cylinder_coulomb_friction");
    assert_true(effect >= 0);
    params.effects[effect].on = true;
    for (int k = 0; k < EFFECT_KEYS && effect_table[effect]->keys[k].name; k++)
        for (int i = 0; i < LEGS; i++) params.effects[effect].value[k][i] = 400.0; /* twice the paper's */
    rig_init(&rig, &params);
    for (int n = 0; n < 20000 && (n == 0 || rig.platform.automatic); n++) rig_cycle(&rig, COMMAND_NONE);
    assert_int_equal(rig.now.state, STATE_SETTLED);
    assert_int_equal(rig.now.first_fault, 0);
    plant_destroy(rig.plant);
}

/* Each length is one a leg can have; together they fit no pose. */
static void no_such_platform(struct hal_sample *s, int cycle) {
    (void)cycle;
    for (int i = 0; i < LEGS; i++) s->length_m[i] = i % 2 ? 2.2 : 1.45;
}

static void lengths_that_fit_no_pose_trip(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    params.limits.leg_rate_mps = params.limits.following_m = params.limits.standstill_m = 1e6; /* or these would speak first */
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_READY, 10);
    spoil_cycles(&rig, no_such_platform, params.limits.bad_cycles - 1);
    assert_int_equal(rig.now.state, STATE_READY);
    spoil_cycles(&rig, no_such_platform, 1);
    assert_int_equal(rig.now.first_fault, FAULT_KINEMATICS);
    assert_stays_still_until_reset(&rig);
    plant_destroy(rig.plant);
}

static void overran(struct hal_sample *s, int cycle) { (void)cycle, s->flags |= SAMPLE_OVERRUN; }

static void overrun_limit_in_a_row_trips_and_one_less_does_not(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_READY, 10);
    for (int n = 0; n < 10; n++) {
        spoil_cycles(&rig, overran, params.loop.overrun_limit - 1);
        rig_run(&rig, 1);
        assert_int_equal(rig.now.state, STATE_READY);
    }
    spoil_cycles(&rig, overran, params.loop.overrun_limit);
    assert_int_equal(rig.now.first_fault, FAULT_OVERRUN);
    assert_stays_still_until_reset(&rig);
    plant_destroy(rig.plant);
}

/* 50 ms without the loop, at the fastest the platform goes: the leg did not break its rate limit, the loop was away. */
static void a_missed_deadline_is_no_leg_rate_fault(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    params.loop.overrun_limit = 100, params.limits.following_m = 0.05; /* or these would speak first */
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_ENGAGING, 500); /* the middle of the move */
    for (int n = 0; n < 25; n++) plant_step(rig.plant, rig.now.out.valve);
    struct hal_sample sample = {.flags = SAMPLE_OVERRUN};
    plant_measure(rig.plant, &sample);
    double moved = fabs(sample.length_m[0] - rig.platform.length_m[0]);
    assert_true(moved > 2 * params.limits.leg_rate_mps * params.loop.period_s); /* it is a jump for one period */
    for (int n = 0; n < 20; n++) {
        sample.time_ns = (rig.cycles + 25) * PERIOD_NS;
        if (n > 0) sample.flags = 0, plant_measure(rig.plant, &sample);
        platform_step(&rig.platform, &sample, (struct request){.id = rig.id}, &rig.now);
        assert_int_equal(rig.now.state, STATE_ENGAGING);
        assert_false(rig.now.in.flags & SAMPLE_INVALID);
        plant_step(rig.plant, rig.now.out.valve);
        rig.cycles++;
    }
    plant_destroy(rig.plant);
}

static void late_but_young_enough_samples_are_used(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_READY, 10);
    for (int n = 0; n < 100; n++) {
        struct hal_sample sample = {.time_ns = rig.cycles * PERIOD_NS - 9000000, .age_ns = 9000000, .flags = SAMPLE_LATE};
        plant_measure(rig.plant, &sample);
        platform_step(&rig.platform, &sample, (struct request){.id = rig.id}, &rig.now);
        assert_int_equal(rig.now.state, STATE_READY);
        assert_int_equal(rig.now.in.flags, SAMPLE_LATE);
        plant_step(rig.plant, rig.now.out.valve);
        rig.cycles++;
    }
    plant_destroy(rig.plant);
}

static void a_stale_sample_trips_once_it_is_too_old(void **unused) {
    (void)unused;
    struct params params = by_hand();
    for (int h = 0; h < HELD; h++) {
        struct rig rig;
        int cycles = 0;
        rig_init(&rig, &params);
        rig_bring(&rig, held[h], 40);
        struct hal_sample last = rig.now.in;
        for (; rig.now.state == held[h]; cycles++) {
            last.age_ns += PERIOD_NS;
            last.flags = SAMPLE_STALE;
            platform_step(&rig.platform, &last, (struct request){.id = rig.id}, &rig.now);
            plant_step(rig.plant, rig.now.out.valve);
            rig.cycles++;
        }
        assert_int_equal(rig.now.first_fault, FAULT_SENSOR_AGE);
        /* ages 2, 4, ... 10 ms are young enough; the next bad_cycles are not */
        assert_int_equal(cycles, (int)(params.limits.sensor_age_s / params.loop.period_s + 0.5) + params.limits.bad_cycles);
        plant_destroy(rig.plant);
    }
}

/* ---- before and after ---- */

static void init_waits_for_the_sensors_and_then_gives_up(void **unused) {
    (void)unused;
    struct params params = brisk();
    struct rig rig;
    rig_init(&rig, &params);
    spoil_cycles(&rig, flagged_io, 999);
    assert_int_equal(rig.now.state, STATE_INIT);
    rig_run(&rig, 49);
    assert_int_equal(rig.now.state, STATE_INIT);
    rig_run(&rig, 2);
    assert_int_equal(rig.now.state, STATE_ENGAGING);
    spoil_cycles(&rig, flagged_io, 1); /* patience in init does not shorten it now */
    assert_int_equal(rig.now.state, STATE_ENGAGING);
    plant_destroy(rig.plant);

    rig_init(&rig, &params);
    spoil_cycles(&rig, flagged_io, 1000);
    assert_int_equal(rig.now.first_fault, FAULT_IO);
    spoil_cycles(&rig, flagged_io, 3000);
    rig_cycle(&rig, COMMAND_RESET);
    rig_run(&rig, 200);
    assert_int_equal(rig.now.state, STATE_SETTLED); /* not engaging: a fault ends what was automatic */
    plant_destroy(rig.plant);
}

static void a_request_cannot_hide_a_fault_of_the_same_cycle(void **unused) {
    (void)unused;
    struct params params = by_hand();
    for (int command = COMMAND_NONE; command < COMMANDS; command++)
        for (int h = 0; h < HELD; h++) {
            struct rig rig;
            rig_init(&rig, &params);
            rig_bring(&rig, held[h], 10);
            spoil_cycles(&rig, flagged_io, params.limits.bad_cycles - 1);
            rig_request(&rig, (struct request){.id = ++rig.id, .command = (enum command)command}, flagged_io, 0);
            assert_int_equal(rig.now.state, STATE_FAULT);
            assert_int_equal(rig.now.faults, FAULT_IO);
            plant_destroy(rig.plant);
        }
}

static void engage_starts_where_the_platform_is(void **unused) {
    (void)unused;
    struct params params = by_hand();
    uint64_t seed = 5;
    struct rig rig;
    params.motion.engage_s = 4.0; /* from as far as 0.4 m above and tilted */
    for (int n = 0; n < 25; n++) {
        double pose[DOFS];
        struct plant_truth truth;
        rig_init(&rig, &params);
        for (int i = 0; i < DOFS; i++) pose[i] = random_unit(&seed) * (i < DOF_PHI ? 0.08 : 0.12);
        pose[DOF_Z] = n % 2 ? 0.3 * random_unit(&seed) : 0.05 * random_unit(&seed);
        plant_place(rig.plant, pose);
        rig_bring(&rig, STATE_ENGAGING, 0);
        plant_get_truth(rig.plant, &truth);
        assert_below(distance(rig.now.ref, truth.pose, DOFS), 1e-3); /* a sensor's resolution and a cycle of settling */
        rig_until(&rig, STATE_READY);
        assert_below(distance(rig.now.pose, (double[DOFS]){0}, DOFS), 2e-3);
        assert_below(rig.largest_valve_step, 0.2);
        plant_destroy(rig.plant);
    }
}

static void after_a_fault_at_any_instant_it_can_be_engaged_again_and_put_down(void **unused) {
    (void)unused;
    struct params params = by_hand();
    uint64_t seed = 6;
    struct rig rig;
    rig_init(&rig, &params);
    for (int n = 0; n < 20; n++) {
        rig_bring(&rig, held[n % HELD], random_below(&seed, n % HELD == 1 ? 100 : 900));
        spoil_cycles(&rig, bad[n % BAD].spoil, params.limits.bad_cycles);
        assert_int_equal(rig.now.state, STATE_FAULT);
        rig_run(&rig, random_below(&seed, 300)); /* it sinks or rises a little */
        rig_cycle(&rig, COMMAND_RESET);
        rig_until(&rig, STATE_SETTLED);
        rig_cycle(&rig, COMMAND_ENGAGE);
        rig_until(&rig, STATE_READY);
        rig_cycle(&rig, COMMAND_PARK);
        rig_until(&rig, STATE_SETTLED);
    }
    assert_below(rig.largest_valve_step, 0.2);
    plant_destroy(rig.plant);
}

/* ---- requests ---- */

static void park_at_any_instant_of_a_test_ramps_out_and_puts_down(void **unused) {
    (void)unused;
    struct params params = by_hand();
    uint64_t seed = 7;
    struct rig rig;
    params.tests.count = 1;
    rig_init(&rig, &params);
    for (int n = 0; n < 30; n++) {
        rig.params.tests.order[0] = (enum dof)(n % DOFS);
        rig_bring(&rig, STATE_TESTING, random_below(&seed, 500));
        if (n % 3 == 0) rig_cycle(&rig, COMMAND_STOP), rig_run(&rig, random_below(&seed, 80)); /* stopping already */
        rig_cycle(&rig, COMMAND_PARK);
        for (int m = 0; rig.now.state != STATE_SETTLED; m++) {
            assert_int_equal(rig.now.state, STATE_PARKING);
            assert_true(rig.now.phase == PHASE_RAMP_OUT || rig.now.phase == PHASE_NONE);
            assert_true(m < 101 + 1001);
            rig_cycle(&rig, m % 7 ? COMMAND_NONE : COMMAND_PARK); /* told again and again */
        }
        assert_close(rig.now.pose[DOF_Z], params.motion.park_z_m, 2e-3);
    }
    print_message("# largest valve step with parks during tests: %.3f\n", rig.largest_valve_step);
    assert_below(rig.largest_valve_step, 0.2);
    plant_destroy(rig.plant);
}

static void stop_ends_the_test_and_start_takes_it_up_again(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_TESTING, 1000); /* in the second of about 526 cycles each */
    assert_int_equal(rig.now.test, 1);
    rig_cycle(&rig, COMMAND_STOP);
    rig_run(&rig, 150);
    assert_int_equal(rig.now.state, STATE_READY);
    rig_run(&rig, 500);
    assert_int_equal(rig.now.state, STATE_READY); /* held until told otherwise */
    rig_cycle(&rig, COMMAND_START);
    assert_int_equal(rig.now.state, STATE_TESTING);
    assert_int_equal(rig.now.test, 1);
    rig_until(&rig, STATE_READY);
    rig_cycle(&rig, COMMAND_START); /* all done: from the first again */
    assert_int_equal(rig.now.test, 0);
    plant_destroy(rig.plant);
}

static void a_stop_ends_what_is_automatic(void **unused) {
    (void)unused;
    struct params params = brisk();
    struct rig rig;
    rig_init(&rig, &params);
    rig_until(&rig, STATE_TESTING);
    rig_run(&rig, 700);
    rig_cycle(&rig, COMMAND_STOP);
    rig_until(&rig, STATE_READY);
    rig_run(&rig, 1000);
    assert_int_equal(rig.now.state, STATE_READY);
    plant_destroy(rig.plant);
}

static void a_request_is_acted_upon_once(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    const struct request engage = {.id = 7, .command = COMMAND_ENGAGE}, park = {.id = 8, .command = COMMAND_PARK};
    for (int n = 0; n < 200; n++) rig_request(&rig, engage, NULL, 0); /* came while init: too early, and never later */
    assert_int_equal(rig.now.state, STATE_SETTLED);
    rig_request(&rig, park, NULL, 0);
    rig_request(&rig, engage, NULL, 0); /* its id is another one now */
    assert_int_equal(rig.now.state, STATE_ENGAGING);
    for (int n = 0; n < 500; n++) rig_request(&rig, engage, NULL, 0);
    for (int n = 0; n < 5; n++) rig_request(&rig, engage, flagged_io, 0);
    assert_int_equal(rig.now.state, STATE_FAULT);
    rig_request(&rig, (struct request){.id = UINT32_MAX, .command = COMMAND_RESET}, NULL, 0);
    for (int n = 0; n < 200; n++) rig_request(&rig, (struct request){.id = UINT32_MAX, .command = COMMAND_ENGAGE}, NULL, 0);
    assert_int_equal(rig.now.state, STATE_SETTLED);
    rig_request(&rig, (struct request){.id = 0, .command = COMMAND_ENGAGE}, NULL, 0); /* ids come round */
    assert_int_equal(rig.now.state, STATE_ENGAGING);
    plant_destroy(rig.plant);
}

static void hostile_commands_do_nothing(void **unused) {
    (void)unused;
    struct params params = by_hand();
    static const uint32_t values[] = {COMMANDS, COMMANDS + 1, 77, 0x7fffffff, 0x80000000, 0xffffffff};
    for (int h = 0; h < HELD; h++) {
        struct rig rig;
        rig_init(&rig, &params);
        rig_bring(&rig, held[h], 10);
        for (unsigned n = 0; n < sizeof values / sizeof *values; n++) {
            rig_request(&rig, (struct request){.id = ++rig.id, .command = (enum command)values[n]}, NULL, 0);
            assert_int_equal(rig.now.state, held[h]);
        }
        rig_cycle(&rig, COMMAND_PARK); /* and do not block the next one */
        assert_int_equal(rig.now.state, STATE_PARKING);
        plant_destroy(rig.plant);
    }
}

/* Three minutes of buttons pushed at random, with a bad sample now and then: check_always holds, and there is never a bump. */
static void random_requests_never_bump_the_platform(void **unused) {
    (void)unused;
    struct params params = by_hand();
    uint64_t seed = 8;
    struct rig rig;
    int visits[STATES] = {0};
    static const enum command buttons[] = {COMMAND_ENGAGE, COMMAND_ENGAGE, COMMAND_START, COMMAND_START,
                                           COMMAND_STOP,   COMMAND_PARK,   COMMAND_RESET, COMMAND_RESET};
    rig_init(&rig, &params);
    for (int n = 0; n < 90000; n++) {
        bool push = random_below(&seed, 200) == 0;
        if (push) rig_cycle(&rig, buttons[random_below(&seed, 8)]);
        else if (random_below(&seed, 2000) == 0) spoil_cycles(&rig, bad[random_below(&seed, BAD)].spoil, 1 + random_below(&seed, 6));
        else rig_cycle(&rig, COMMAND_NONE);
        if (rig.now.state != rig.before.state) visits[rig.now.state]++;
    }
    print_message("# visits:");
    for (int s = 0; s < STATES; s++) print_message(" %s %d", state_names[s], visits[s]);
    print_message("; largest valve step %.3f\n", rig.largest_valve_step);
    for (int s = 0; s < STATES; s++) assert_true(visits[s] > 0);
    assert_below(rig.largest_valve_step, 0.2);
    plant_destroy(rig.plant);
}

/* Any bits at all from the sensors, in any mixture with good ones: check_always holds. */
static void garbage_from_the_sensors_never_reaches_the_valves(void **unused) {
    (void)unused;
    struct params params = by_hand();
    uint64_t seed = 9;
    struct rig rig;
    rig_init(&rig, &params);
    for (int n = 0; n < 20000; n++) {
        struct hal_sample sample = {.time_ns = rig.cycles * PERIOD_NS};
        plant_measure(rig.plant, &sample);
        if (random_below(&seed, 20) == 0) {
            uint64_t word;
            size_t at = (size_t)random_below(&seed, (int)(sizeof sample / sizeof word)) * sizeof word;
            random_unit(&seed);
            word = random_below(&seed, 2) ? seed ^ seed << 31 : seed >> 1; /* also exponents that make sense */
            memcpy((char *)&sample + at, &word, sizeof word);
        }
        struct request request = {.id = (uint32_t)n, .command = (enum command)(n % 50 == 0 ? random_below(&seed, COMMANDS) : 0)};
        rig.before = rig.now;
        platform_step(&rig.platform, &sample, request, &rig.now);
        check_always(&rig);
        plant_step(rig.plant, rig.now.out.valve);
        rig.cycles++;
    }
    plant_destroy(rig.plant);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(automatic_run_tests_every_axis_and_ends_put_down),
        cmocka_unit_test(nothing_moves_without_engage),
        cmocka_unit_test(each_limit_trips_in_bad_cycles_and_holds_until_reset),
        cmocka_unit_test(fewer_bad_samples_are_ridden_out_with_the_command_held),
        cmocka_unit_test(a_leg_that_does_not_follow_trips),
        cmocka_unit_test(a_length_that_stands_still_trips_before_its_leg_has_gone_far),
        cmocka_unit_test(a_length_that_stands_still_in_a_test_trips_within_a_period),
        cmocka_unit_test(a_leg_with_much_dry_friction_does_not_stand_still_for_long_enough_to_trip),
        cmocka_unit_test(lengths_that_fit_no_pose_trip),
        cmocka_unit_test(overrun_limit_in_a_row_trips_and_one_less_does_not),
        cmocka_unit_test(a_missed_deadline_is_no_leg_rate_fault),
        cmocka_unit_test(late_but_young_enough_samples_are_used),
        cmocka_unit_test(a_stale_sample_trips_once_it_is_too_old),
        cmocka_unit_test(init_waits_for_the_sensors_and_then_gives_up),
        cmocka_unit_test(a_request_cannot_hide_a_fault_of_the_same_cycle),
        cmocka_unit_test(engage_starts_where_the_platform_is),
        cmocka_unit_test(after_a_fault_at_any_instant_it_can_be_engaged_again_and_put_down),
        cmocka_unit_test(park_at_any_instant_of_a_test_ramps_out_and_puts_down),
        cmocka_unit_test(stop_ends_the_test_and_start_takes_it_up_again),
        cmocka_unit_test(a_stop_ends_what_is_automatic),
        cmocka_unit_test(a_request_is_acted_upon_once),
        cmocka_unit_test(hostile_commands_do_nothing),
        cmocka_unit_test(random_requests_never_bump_the_platform),
        cmocka_unit_test(garbage_from_the_sensors_never_reaches_the_valves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
