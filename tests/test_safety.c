/* The promises of docs/safety.md's table that no other test covers: what stops, who may move the
 * machine, what a fault reports, and what follows it. */
#include "platform_rig.h"

#include "blind_time.h"
#include "cli.h"
#include "reference.h"
#include "witness.h"

static void not_a_number(struct hal_sample *s, int leg) { s->length_m[leg] = (double)NAN; }
static void too_long(struct hal_sample *s, int leg) { s->length_m[leg] = 3.0; }
static void jumped(struct hal_sample *s, int leg) { s->length_m[leg] += 0.012; }
static void pressed(struct hal_sample *s, int leg) { s->p1_pa[leg] += 8e6; }
static void burst(struct hal_sample *s, int leg) { s->p2_pa[leg] = 20e6; }

/* ---- stop ---- */

/* After a stop in any state, also a repeated one, nothing accelerates or starts by itself, and the
 * platform comes to rest. */
static void a_stop_in_any_state_leads_to_rest(void **unused) {
    (void)unused;
    slow_case();
    static const enum state states[] = {STATE_INIT,    STATE_SETTLED, STATE_ENGAGING, STATE_READY,
                                        STATE_TESTING, STATE_PARKING, STATE_FAULT,    STATE_PRESSURISING};
    for (int k = 0; k < STATES * 3; k++) {
        enum state state = states[k % STATES], rest;
        struct rig rig;
        double last[DOFS];
        int still = 0;
        struct params params = k >= STATES && state != STATE_PARKING && state != STATE_FAULT ? brisk() : by_hand();
        rig_init(&rig, &params);
        if (state == STATE_FAULT) {
            rig_bring(&rig, STATE_READY, 0);
            for (int n = 0; n < 5; n++) rig_spoilt(&rig, not_a_number, 2);
            rig_until(&rig, STATE_FAULT);
        } else rig_bring(&rig, state, 0);
        for (int n = 0; n < 40 * (k / STATES) && rig.now.state == state; n++) rig_cycle(&rig, COMMAND_NONE);
        rig_cycle(&rig, COMMAND_STOP);
        for (int n = 0; n < 4000; n++) {
            memcpy(last, rig.now.ref, sizeof last);
            rig_cycle(&rig, n % 100 == 50 ? COMMAND_STOP : COMMAND_NONE);
            assert_true(rig.now.state != STATE_ENGAGING);
            /* limit: the ramp-out takes no longer */
            if (rig.now.state == STATE_TESTING) assert_true(n < (int)(0.5 * 500));
            still = rig.now.out.enable && distance(last, rig.now.ref, DOFS) > 0.0 ? 0 : still + 1;
        }
        rest = rig.now.state;
        assert_true(still > 1000);
        assert_true(rest == STATE_SETTLED || rest == STATE_READY || rest == STATE_FAULT);
        if (rest == STATE_READY) assert_true(state == STATE_READY || state == STATE_TESTING);
        plant_destroy(rig.plant);
    }
}

/* ---- who may move it ---- */

static void a_real_machine_moves_by_itself_only_when_the_command_line_says_so(void **unused) {
    (void)unused;
    struct options said = {.settings = {"sim.substeps=8", "motion.automatic=true"}, .setting_count = 2}, silent = {.setting_count = 0};
    struct params params;
    for (int simulated = 0; simulated < 2; simulated++) {
        config_default(&params);
        assert_true(params.motion.automatic);
        options_automatic(&silent, simulated, &params);
        assert_int_equal(params.motion.automatic, simulated);
        config_default(&params);
        options_automatic(&said, simulated, &params);
        assert_true(params.motion.automatic);
    }
}

static void nothing_is_run_without_ramps(void **unused) {
    (void)unused;
    static const struct {
        double ramp_s, ramp_out_s;
        bool good;
    } cases[] = {{0.05, 0.05, true}, {0.049, 0.5, false}, {1.0, 0.0, false}, {(double)NAN, 0.5, false}};
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct params params;
        struct error error;
        config_default(&params);
        params.tests.ramp_s = cases[i].ramp_s, params.tests.ramp_out_s = cases[i].ramp_out_s;
        assert_int_equal(config_check_motion(&params, &error), cases[i].good ? STATUS_OK : STATUS_USAGE);
    }
}

/* The paper's machine rests at leg lengths of 1.4310 m. */
static void nothing_is_run_whose_rest_is_a_fault(void **unused) {
    (void)unused;
    static const struct {
        const char *setting, *said;
    } cases[] = {
        {"limits.length_min_m=1.43", NULL},
        {"limits.length_min_m=1.432", "leg 1 is 1.431 m"},
        {"limits.length_min_m=[1.4,1.4,1.4,1.432,1.4,1.4]", "leg 4"},
        {"actuator.mid_stroke_m=-0.01", "leg 1 is 1.421 m"},
        {"geometry.height_m=-1.64", "the platform hangs"},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct params params;
        struct error error = {0};
        if (config_load(&params, NULL, &cases[i].setting, 1, &error)) fail_msg("%s", error.text);
        assert_int_equal(config_check_motion(&params, &error), cases[i].said ? STATUS_USAGE : STATUS_OK);
        if (cases[i].said && !strstr(error.text, cases[i].said)) fail_msg("%s: %s", cases[i].setting, error.text);
    }
}

/* Covers both sides of 0.1 s, for each key alone and for a slow loop. The message names the keys to
 * change, and the time. */
static void nothing_is_run_that_could_move_blindly_for_long(void **unused) {
    (void)unused;
    static const char slow[] = "loop.period_s=0.01", steps[] = "sim.substeps=40";
    static const struct {
        const char *settings[7], *said[3]; /* NULL: accepted */
    } cases[] = {
        {{"limits.sensor_age_s=0.044"}, {NULL}},
        {{"limits.sensor_age_s=0.045"}, {"0.102 s", "limits.sensor_age_s", "limits.bad_cycles"}},
        {{"limits.sensor_age_s=1"}, {"2.01 s", "limits.sensor_age_s", "limits.blind_time_s 0.1"}},
        {{"limits.bad_cycles=37"}, {NULL}},
        {{"limits.bad_cycles=38"}, {"0.101 s", "limits.bad_cycles", "loop.period_s"}},
        {{"loop.overrun_limit=44"}, {NULL}},
        {{"loop.overrun_limit=45"}, {"0.102 s", "loop.overrun_limit", "loop.period_s"}},
        {{"loop.overrun_limit=100000"}, {"200 s", "loop.overrun_limit", "limits.blind_time_s"}},
        {{"device.watchdog_s=0.085"}, {NULL}},
        {{"device.watchdog_s=0.086"}, {"0.101 s", "device.watchdog_s", "limits.bad_cycles"}},
        {{"device.watchdog_s=10"}, {"10 s", "device.watchdog_s", "limits.blind_time_s"}},
        {{"device.watchdog_s=0.068", "limits.sensor_age_s=0.03", "limits.bad_cycles=1"}, {NULL}},
        {{"device.watchdog_s=0.07", "limits.sensor_age_s=0.03", "limits.bad_cycles=1"}, {"0.101 s", "killed", "device.watchdog_s + 1 ms)"}},
        {{"device.watchdog_s=9.9", "limits.blind_time_s=10"}, {NULL}},
        {{"device.watchdog_s=9.99", "limits.blind_time_s=10"}, {"10 s", "device.watchdog_s", "limits.blind_time_s 10"}},
        {{"limits.blind_time_s=0.03"}, {"0.035 s", "device.watchdog_s", "limits.blind_time_s 0.03"}},
        {{slow, steps}, {"0.12 s", "loop.overrun_limit", "loop.period_s"}},
        {{slow, steps, "limits.sensor_age_s=0.03", "limits.bad_cycles=2", "loop.overrun_limit=5", "device.watchdog_s=0.05"}, {NULL}},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct params params;
        struct error error = {0};
        int count = 0;
        while (count < 7 && cases[i].settings[count]) count++;
        if (config_load(&params, NULL, cases[i].settings, count, &error)) fail_msg("%s", error.text);
        int status = config_check_motion(&params, &error);
        if (status != (cases[i].said[0] ? STATUS_USAGE : STATUS_OK)) fail_msg("case %u: %d %s", i, status, error.text);
        for (int k = 0; k < 3 && cases[i].said[k]; k++)
            if (!strstr(error.text, cases[i].said[k])) fail_msg("case %u: no %s: %s", i, cases[i].said[k], error.text);
    }
}

static void a_time_that_is_no_number_is_not_allowed(void **unused) {
    (void)unused;
    struct params params = by_hand();
    double *const times[] = {&params.loop.period_s, &params.limits.sensor_age_s, &params.device.watchdog_s, &params.limits.blind_time_s};
    assert_true(blind_time(&params).allowed);
    for (int i = 0; i < 4; i++) {
        double usual = *times[i];
        *times[i] = (double)NAN;
        assert_false(blind_time(&params).allowed);
        *times[i] = usual;
    }
}

/* ---- faults ---- */

static void a_fault_names_its_leg(void **unused) {
    (void)unused;
    slow_case();
    static const struct {
        spoiler *spoil;
        uint32_t fault;
    } cases[] = {{not_a_number, FAULT_SENSOR_INVALID},
                 {too_long, FAULT_STROKE},
                 {jumped, FAULT_LEG_RATE},
                 {pressed, FAULT_FORCE},
                 {burst, FAULT_FORCE}};
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    for (int leg = 0; leg < LEGS; leg++)
        for (unsigned k = 0; k < sizeof cases / sizeof *cases; k++) {
            char text[FAULT_TEXT_SIZE], expected[FAULT_TEXT_SIZE];
            rig_bring(&rig, STATE_READY, 0);
            while (!rig.now.faults) rig_spoilt(&rig, cases[k].spoil, leg);
            assert_int_equal(rig.now.first_fault, cases[k].fault);
            assert_int_equal(rig.now.faults & FAULT_LEGS, fault_leg(leg));
            snprintf(expected, sizeof expected, "%s, leg %d", fault_name(cases[k].fault), leg + 1);
            fault_describe(rig.now.first_fault, rig.now.faults, text);
            assert_string_equal(text, expected);
        }
    plant_destroy(rig.plant);
}

static void the_longest_fault_fits_its_text(void **unused) {
    (void)unused;
    char text[FAULT_TEXT_SIZE];
    fault_describe(FAULT_FOLLOWING, UINT32_MAX, text);
    assert_string_equal(text, "following_error, legs 1 2 3 4 5 6");
    fault_describe(FAULT_IO, FAULT_IO, text);
    assert_string_equal(text, "io");
}

static void the_supply_is_gone(struct hal_sample *s, int cycle) { (void)cycle, s->inputs &= ~(uint32_t)INPUT_SUPPLY; }
static void cut_off(struct hal_sample *s, int cycle) { (void)cycle, *s = (struct hal_sample){.flags = SAMPLE_IO}; }
static void far_too_old(struct hal_sample *s, int cycle) { (void)cycle, s->age_ns = 31000000; }
static void in_vain(struct hal_sample *s, int leg) { s->p2_pa[leg] = -3e5; }
static void too_short(struct hal_sample *s, int leg) { s->length_m[leg] = 1.4; }

/* The value belongs to the first or the last bad cycle; limit and key follow it, in units for
 * people. */
static void a_fault_says_value_limit_and_key(void **unused) {
    (void)unused;
    static const struct {
        spoiler *spoil;
        bool by_cycle;         /* the spoiler gets the cycle, otherwise leg 4 */
        const char *said[3];
    } cases[] = {
        {too_long, false, {"stroke, leg 4: 3000 mm, limit 2240 mm (limits.length_max_m)"}},
        {too_short, false, {"stroke, leg 4: 1400 mm, limit 1425 mm (limits.length_min_m)"}},
        {not_a_number, false, {"sensor_invalid, leg 4: not a number"}},
        {jumped, false, {"leg_rate, leg 4: ", " m/s, limit 0.6 m/s (limits.leg_rate_mps)"}},
        {pressed, false, {"force, leg 4: ", " kN, limit 15 kN (limits.force_n)"}},
        {burst, false, {"force, leg 4: -", " kN, limit -15 kN (limits.force_n)"}},
        {in_vain, false, {"pressure_sensor, leg 4: -0.3 MPa, limit -0.2 MPa (limits.pressure_min_pa)"}},
        {far_too_old, true, {"sensor_age: 31 ms, limit 10 ms (limits.sensor_age_s)"}},
        {cut_off, true, {"io"}},
        {the_supply_is_gone, true, {"supply"}},
    };
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    for (unsigned k = 0; k < sizeof cases / sizeof *cases; k++) {
        char line[FAULT_LINE_SIZE];
        rig_bring(&rig, STATE_READY, 0);
        for (int n = 0; !rig.now.faults; n++) rig_spoilt(&rig, cases[k].spoil, cases[k].by_cycle ? n : 3);
        fault_line(rig.now.first_fault, rig.now.faults, &rig.now.measure, line);
        for (int i = 0; i < 3 && cases[k].said[i]; i++)
            if (!strstr(line, cases[k].said[i])) fail_msg("%s is not in: %s", cases[k].said[i], line);
        if (!cases[k].said[1]) assert_string_equal(line, cases[k].said[0]);
        for (int n = 0; rig.now.state != STATE_FAULT && n < 5000; n++) rig_spoilt(&rig, cases[k].spoil, cases[k].by_cycle ? n : 3);
    }
    plant_destroy(rig.plant);
}

/* The machine itself causes these faults: a valve's cable is cut, or a transducer is frozen. */
static void a_leg_that_does_not_follow_says_how_far_it_is_off(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    char line[FAULT_LINE_SIZE];
    double off_mm = 0.0;
    params.limits.standstill_m = 1.0; /* otherwise this limit would trip first */
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_ENGAGING, 100);
    rig.cut_leg = 2;
    while (!rig.now.faults) {
        double ref = rig.platform.leg_ref_m[2];
        rig_cycle(&rig, COMMAND_NONE);
        off_mm = fabs(ref - rig.now.in.length_m[2]) * 1e3;
    }
    fault_line(rig.now.first_fault, rig.now.faults, &rig.now.measure, line);
    assert_int_equal(rig.now.measure.leg, 2);
    assert_close(rig.now.measure.value * 1e3, off_mm, 1e-9);
    assert_non_null(strstr(line, "following_error, leg 3: 1"));
    assert_non_null(strstr(line, " mm, limit 10 mm (limits.following_m)"));
    plant_destroy(rig.plant);
}

static void an_unstable_loop_is_among_the_causes_of_what_it_trips(void **unused) {
    (void)unused;
    static const uint32_t trips[] = {FAULT_FORCE, FAULT_FOLLOWING, FAULT_LEG_RATE};
    for (unsigned i = 0; i < 3; i++) {
        assert_non_null(strstr(failure_of(trips[i])->cause, "a loop that is unstable"));
        assert_non_null(strstr(failure_of(trips[i])->remedy, "hexid doctor"));
    }
}

/* The same sample comes again and again with fresh time stamps; only the device's own counter
 * reveals it. */
static void a_device_that_hangs_behind_fresh_time_stamps_is_found_out(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_READY, 0);
    struct hal_sample hung = rig.now.in;
    int cycles = 0;
    for (; !rig.now.faults; cycles++) {
        hung.time_ns += PERIOD_NS;
        rig_given(&rig, &hung);
        assert_true(rig.now.in.flags & SAMPLE_STALE);
    }
    assert_int_equal(rig.now.first_fault, FAULT_SENSOR_AGE);
    assert_int_equal(cycles, 10); /* limit: 10 ms and bad_cycles */
    plant_destroy(rig.plant);
}

static void a_device_without_a_count_is_believed_by_its_clock(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_READY, 0);
    struct hal_sample sample = rig.now.in;
    sample.device_seq = 0;
    for (int n = 0; n < 50; n++) {
        sample.time_ns += PERIOD_NS;
        rig_given(&rig, &sample);
        assert_int_equal(rig.now.in.flags, 0);
        assert_int_equal(rig.now.faults, 0);
    }
    plant_destroy(rig.plant);
}

/* After such an absence the device may have centred the valves, so the loop does not continue. */
static void a_loop_that_was_away_for_long_does_not_go_on(void **unused) {
    (void)unused;
    slow_case();
    struct params params = by_hand();
    for (int away = 1; away <= 500; away += away < 20 ? 1 : 60) {
        struct rig rig;
        rig_init(&rig, &params);
        rig_bring(&rig, STATE_READY, 0);
        struct hal_sample sample = rig.now.in;
        sample.flags = SAMPLE_OVERRUN, sample.missed = away, sample.device_seq += 1, sample.time_ns += (away + 1) * (int64_t)PERIOD_NS;
        rig_given(&rig, &sample);
        assert_int_equal(rig.now.first_fault, away >= rig.params.loop.overrun_limit ? FAULT_OVERRUN : 0);
        plant_destroy(rig.plant);
        /* the same absence, but with a sample latched earlier */
        rig_init(&rig, &params);
        rig_bring(&rig, STATE_READY, 0);
        sample = rig.now.in;
        sample.flags = SAMPLE_OVERRUN, sample.missed = away, sample.device_seq += 1, sample.age_ns = (away + 1) * (int64_t)PERIOD_NS;
        rig_given(&rig, &sample);
        assert_int_equal(rig.now.faults != 0 && !rig.now.out.enable, away >= rig.params.loop.overrun_limit);
        plant_destroy(rig.plant);
    }
}

/* The platform may be engaged from any state, after any time with the valves centred, at any height
 * to which it has sunk. */
static void engaging_again_after_a_fault_is_bumpless(void **unused) {
    (void)unused;
    slow_case();
    static spoiler *const spoilers[] = {not_a_number, jumped, pressed};
    uint64_t seed = 11;
    double valve_first = 0.0, valve_later = 0.0, reference = 0.0;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    for (int n = 0; n < 40; n++) {
        rig_bring(&rig, held[n % HELD], 0);
        for (int wait = random_below(&seed, 200); wait > 0 && supervisor_drives(rig.now.state); wait--) rig_cycle(&rig, COMMAND_NONE);
        if (!supervisor_drives(rig.now.state)) continue;
        while (!rig.now.faults) rig_spoilt(&rig, spoilers[n % 3], n % LEGS);
        rig_until(&rig, STATE_FAULT);
        for (int wait = random_below(&seed, 2000); wait > 0; wait--) rig_cycle(&rig, COMMAND_NONE);
        rig_cycle(&rig, COMMAND_RESET);
        while (rig.now.state != STATE_SETTLED) rig_cycle(&rig, COMMAND_NONE);
        double before[DOFS];
        memcpy(before, rig.now.pose, sizeof before);
        rig_cycle(&rig, COMMAND_ENGAGE);
        rig_until(&rig, STATE_ENGAGING);
        reference = fmax(reference, distance(rig.now.ref, rig.now.pose, DOFS));
        for (int i = 0; i < LEGS; i++) valve_first = fmax(valve_first, fabs(rig.now.out.valve[i]));
        for (int cycle = 0; cycle < 100; cycle++) {
            rig_cycle(&rig, COMMAND_NONE);
            valve_later = fmax(valve_later, distance(rig.now.out.valve, rig.before.out.valve, LEGS));
        }
    }
    print_message("# reference off by %.2g m or rad, valves step by %.4f, then by %.4f a cycle\n", reference, valve_first, valve_later);
    assert_below(reference, 5e-6);   /* limit: one cycle from the start of the move */
    assert_below(valve_first, 0.005);
    /* limit: mostly for the damping of the pressures; a step of the length, 50 um, moves a valve by
     * only 0.002 of its opening */
    assert_below(valve_later, 0.03);
    plant_destroy(rig.plant);
}

/* ---- witnesses of a test ---- */

enum { SAMPLES = 1000 };

/* Evaluates a leg's sinusoid; from sample `from` on, `what` happens to leg 3. */
enum happening { NOTHING, FROZEN, JUMP, DRIFT, WEAKER, MISSING, LOST, JUMP_LOST, GAPS };
static struct testimony testify_of(const bool moves[LEGS], double frequency_hz, double period_s, enum happening what, int from) {
    static struct witness w;
    struct hal_sample s = {0};
    double force_n[LEGS], frozen_m = 0.0;
    witness_reset(&w, frequency_hz, period_s, moves);
    for (int n = 0; n < SAMPLES; n++) {
        double t = n * period_s, wave = sin(2 * PI * frequency_hz * t + 0.3);
        for (int i = 0; i < LEGS; i++) {
            s.length_m[i] = 1.8 + 1e-3 * wave, force_n[i] = 500 - 150 * wave;
            s.p1_pa[i] = 1e5 * wave, s.p2_pa[i] = -1e5 * wave;
        }
        bool now = n >= from;
        if (n == from) frozen_m = s.length_m[2];
        if (now && what == FROZEN) s.length_m[2] = frozen_m;
        if (now && what == JUMP) force_n[2] += 300;
        if (what == DRIFT) force_n[2] += 100 * t;
        if (now && what == WEAKER) force_n[2] = 500 - 50 * wave;
        if (now && what == JUMP_LOST) force_n[2] += 300;
        if ((what == LOST || what == JUMP_LOST) && n % 50 == 7) continue;
        if (what == GAPS && n % 100 < 20) continue;
        witness_add(&w, t, &s, force_n, !(what == MISSING && n % 7 == 3));
    }
    return witness_says(&w);
}

static struct testimony testify(double frequency_hz, double period_s, enum happening what, int from) {
    return testify_of((const bool[LEGS]){true, true, true, true, true, true}, frequency_hz, period_s, what, from);
}

static void a_leg_that_a_test_moves_less_than_its_sensor_sees_may_stand_still(void **unused) {
    (void)unused;
    struct testimony t = testify_of((const bool[LEGS]){true, true, false, true, true, true}, 4.0, 0.002, FROZEN, 0);
    assert_true(t.still_samples < 60);
    t = testify(4.0, 0.002, FROZEN, 0);
    assert_true(t.still_leg == 2 && t.still_samples == SAMPLES);
}

static void a_steady_motion_wanders_not_at_all_at_any_rate(void **unused) {
    (void)unused;
    static const double frequency_hz[] = {0.5, 1.0, 4.0, 5.7, 8.0, 20.0, 60.0}, period_s[] = {0.001, 0.002, 0.01};
    for (int f = 0; f < 7; f++)
        for (int p = 0; p < 3; p++) {
            if (frequency_hz[f] * period_s[p] > 0.2) continue;
            struct testimony t = testify(frequency_hz[f], period_s[p], NOTHING, 0);
            /* limit: a block is up to a sample longer or shorter, so 150 N 2 / 100 samples,
             * twice */
            assert_below(t.force_n, 6.0);
            assert_below(t.length_m, 4e-5);
            assert_true((double)t.still_samples * period_s[p] * frequency_hz[f] < 0.5);
            assert_close(t.mean_n[0], 500.0, 151.0 * 2);
        }
}

static void each_witness_sees_its_fault_and_names_its_leg(void **unused) {
    (void)unused;
    /* a whole period of the eight comes before and after the event */
    for (int from = 130; from < SAMPLES - 150; from += 60) {
        struct testimony t = testify(4.0, 0.002, FROZEN, from);
        assert_true(t.still_leg == 2 && t.still_samples == SAMPLES - from && t.length_leg == 2);
        t = testify(4.0, 0.002, JUMP, from);
        assert_true(t.force_leg == 2 && t.force_n > 100);
        t = testify(4.0, 0.002, WEAKER, from);
        assert_true(t.force_leg == 2 && t.force_n > 60);
    }
    struct testimony t = testify(4.0, 0.002, DRIFT, 0);
    assert_true(t.force_leg == 2);
    assert_close(t.force_n, 100 * 0.25 * 7, 15.0); /* the change from the first of eight periods to
                                                    * the last */
}

static void samples_left_out_do_not_blind_the_witnesses(void **unused) {
    (void)unused;
    struct testimony t = testify(4.0, 0.002, MISSING, 0);
    assert_below(t.force_n, 6.0);
    assert_below(t.length_m, 4e-5);
}

/* Rows that a recorder loses, and a recorder slower than the controller, leave blocks whole. */
static void lost_rows_and_a_slow_recorder_do_not_blind_the_witnesses(void **unused) {
    (void)unused;
    struct testimony t = testify(4.0, 0.002, LOST, 0);
    assert_true(t.compared);
    assert_below(t.force_n, 6.0);
    assert_below(t.length_m, 4e-5);
    t = testify(4.0, 0.002, JUMP_LOST, 400);
    assert_true(t.force_leg == 2 && t.force_n > 100);
    static struct witness w;
    struct hal_sample s = {0};
    double force_n[LEGS] = {0};
    static const bool moves[LEGS] = {true, true, true, true, true, true};
    witness_reset(&w, 4.0, 0.002, moves);
    for (int n = 0; n < 500; n++) {
        for (int i = 0; i < LEGS; i++) s.length_m[i] = 1.8 + 1e-3 * sin(2 * PI * 4.0 * n * 0.004), force_n[i] = n < 250 ? 500 : 700;
        witness_add(&w, n * 0.004, &s, force_n, true);
    }
    t = witness_says(&w);
    assert_true(t.compared);
    assert_close(t.force_n, 200, 1.0);
    assert_below(t.length_m, 4e-5);
    /* ten samples a period, so that each step is longer than a sixteenth of it */
    witness_reset(&w, 4.0, 0.002, moves);
    for (int n = 0; n < 100; n++) {
        for (int i = 0; i < LEGS; i++) s.length_m[i] = 1.8 + 1e-3 * sin(2 * PI * 4.0 * n * 0.025), force_n[i] = n < 50 ? 500 : 700;
        witness_add(&w, n * 0.025, &s, force_n, true);
    }
    t = witness_says(&w);
    assert_true(t.compared);
    assert_close(t.force_n, 200, 10.0);
    assert_below(t.length_m, 4e-5);
}

/* Nothing that was compared is not the same as nothing that changed. */
static void a_witness_that_saw_no_two_whole_periods_says_so(void **unused) {
    (void)unused;
    assert_false(testify(4.0, 0.002, GAPS, 0).compared);
    assert_true(testify(4.0, 0.002, NOTHING, 0).compared);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_stop_in_any_state_leads_to_rest),
        cmocka_unit_test(a_real_machine_moves_by_itself_only_when_the_command_line_says_so),
        cmocka_unit_test(nothing_is_run_without_ramps),
        cmocka_unit_test(nothing_is_run_whose_rest_is_a_fault),
        cmocka_unit_test(nothing_is_run_that_could_move_blindly_for_long),
        cmocka_unit_test(a_time_that_is_no_number_is_not_allowed),
        cmocka_unit_test(a_fault_names_its_leg),
        cmocka_unit_test(a_fault_says_value_limit_and_key),
        cmocka_unit_test(a_leg_that_does_not_follow_says_how_far_it_is_off),
        cmocka_unit_test(an_unstable_loop_is_among_the_causes_of_what_it_trips),
        cmocka_unit_test(the_longest_fault_fits_its_text),
        cmocka_unit_test(a_device_that_hangs_behind_fresh_time_stamps_is_found_out),
        cmocka_unit_test(a_device_without_a_count_is_believed_by_its_clock),
        cmocka_unit_test(a_loop_that_was_away_for_long_does_not_go_on),
        cmocka_unit_test(engaging_again_after_a_fault_is_bumpless),
        cmocka_unit_test(a_leg_that_a_test_moves_less_than_its_sensor_sees_may_stand_still),
        cmocka_unit_test(a_steady_motion_wanders_not_at_all_at_any_rate),
        cmocka_unit_test(each_witness_sees_its_fault_and_names_its_leg),
        cmocka_unit_test(samples_left_out_do_not_blind_the_witnesses),
        cmocka_unit_test(lost_rows_and_a_slow_recorder_do_not_blind_the_witnesses),
        cmocka_unit_test(a_witness_that_saw_no_two_whole_periods_says_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
