/* Protective limits: on every shipped machine each one trips at values that the machine can reach
 * or its sensors can report; a limit that nothing can reach is reported before a run with a value
 * that protects. */
#include "platform_rig.h"

#include <stdio.h>

#include "doctor.h"

static const char *const machines[] = {"config/tian2015.yaml", "config/desktop.yaml", "config/simulator.yaml"};
enum { MACHINES = 3 };

static struct params load(const char *path, const char *const settings[], int count) {
    struct params p;
    struct error error;
    if (config_load(&p, path, settings, count, &error)) fail_msg("%s", error.text);
    return p;
}

/* ---- each limit on each machine ---- */

static const struct rig *rig_now;

/* Makes a reading of leg 2 just beyond a limit that the machine can reach: a leg against an end
 * stop, a chamber at supply pressure beside an empty one, a transducer that jumps. */
static void beyond_longest(struct hal_sample *s, int n) { (void)n, s->length_m[1] = rig_now->params.limits.length_max_m[1] + 1e-5; }
static void beyond_shortest(struct hal_sample *s, int n) { (void)n, s->length_m[1] = rig_now->params.limits.length_min_m[1] - 1e-5; }
static void at_supply(struct hal_sample *s, int n) { (void)n, s->p1_pa[1] = rig_now->params.hydraulics.supply_pa, s->p2_pa[1] = 0.0; }
static void above_range(struct hal_sample *s, int n) {
    (void)n;
    /* both chambers in balance, so that no force is too large */
    double ratio = rig_now->platform.areas.a1_m2[1] / rig_now->platform.areas.a2_m2[1];
    s->p2_pa[1] = rig_now->params.limits.pressure_max_pa * 1.01, s->p1_pa[1] = s->p2_pa[1] / ratio;
}
static void below_range(struct hal_sample *s, int n) { (void)n, s->p2_pa[1] = rig_now->params.limits.pressure_min_pa - 1e4; }
static void jumping(struct hal_sample *s, int n) {
    double step_m = 1.1 * rig_now->params.limits.leg_rate_mps * rig_now->params.loop.period_s;
    (void)n;
    s->length_m[1] = rig_now->platform.length_m[1] + step_m * (double)(rig_now->platform.seq - rig_now->platform.good_seq);
}
static void old(struct hal_sample *s, int n) { (void)n, s->age_ns = ns_from_seconds(rig_now->params.limits.sensor_age_s) + 1; }

static void each_limit_trips_on_every_shipped_machine(void **unused) {
    (void)unused;
    static const struct {
        spoiler *spoil;
        uint32_t fault;
        const char *key;
    } cases[] = {
        {beyond_longest, FAULT_STROKE, "limits.length_max_m"},
        {beyond_shortest, FAULT_STROKE, "limits.length_min_m"},
        {at_supply, FAULT_FORCE, "limits.force_n"},
        {above_range, FAULT_PRESSURE_SENSOR, "limits.pressure_max_pa"},
        {below_range, FAULT_PRESSURE_SENSOR, "limits.pressure_min_pa"},
        {jumping, FAULT_LEG_RATE, "limits.leg_rate_mps"},
        {old, FAULT_SENSOR_AGE, "limits.sensor_age_s"},
    };
    static const char *const settings[] = {"motion.automatic=false", "sim.engine=closed_form", "motion.engage_s=5", "motion.park_s=5"};
    for (int m = 0; m < MACHINES; m++) {
        struct params params = load(machines[m], settings, 4);
        struct rig rig;
        rig_now = &rig;
        rig_init(&rig, &params);
        rig_bring(&rig, STATE_READY, 100);
        const struct rig ready = rig;
        for (unsigned c = 0; c < sizeof cases / sizeof *cases; c++) {
            char line[FAULT_LINE_SIZE];
            rig = ready; /* restores the controller; the samples are from a machine that stands
                          * still */
            for (int n = 0; n < params.limits.bad_cycles + 5 && !rig.now.faults; n++) {
                struct hal_sample s = ready.now.in;
                s.time_ns += (n + 1) * PERIOD_NS, s.device_seq += (uint64_t)n + 1;
                cases[c].spoil(&s, n);
                rig_given(&rig, &s);
            }
            fault_line(rig.now.first_fault, rig.now.faults, &rig.now.measure, line);
            if (!(rig.now.faults & cases[c].fault) || !strstr(line, cases[c].key))
                fail_msg("%s: %s does not trip: %s", machines[m], cases[c].key, line);
        }
        plant_destroy(rig.plant);
    }
}

/* The faults of one leg are a valve cable that is cut during a motion, and a transducer that
 * freezes. */
static void a_leg_that_does_not_follow_or_move_trips_on_every_shipped_machine(void **unused) {
    (void)unused;
    static const char *const settings[] = {"motion.automatic=false", "sim.engine=closed_form", "motion.engage_s=5", "motion.park_s=5"};
    for (int m = 0; m < MACHINES; m++)
        for (int frozen = 0; frozen < 2; frozen++) {
            struct params params = load(machines[m], settings, 4);
            struct rig rig;
            /* otherwise these limits would trip first */
            params.limits.oscillation_mps2 = 1e3;
            if (!frozen) params.limits.standstill_m = 1.0;
            rig_init(&rig, &params);
            rig_bring(&rig, STATE_ENGAGING, 400);
            double still_m = rig.now.in.length_m[1];
            rig.cut_leg = frozen ? -1 : 1;
            for (int n = 0; n < 2500 && !rig.now.faults; n++) {
                struct hal_sample s = {.time_ns = rig.cycles * PERIOD_NS, .device_seq = (uint64_t)rig.cycles + 1};
                plant_measure(rig.plant, &s);
                if (frozen) s.length_m[1] = still_m;
                rig_given(&rig, &s);
            }
            assert_int_equal(rig.now.first_fault, frozen ? FAULT_STANDSTILL : FAULT_FOLLOWING);
            assert_int_equal(rig.now.measure.leg, 1);
            plant_destroy(rig.plant);
        }
}

/* ---- limits that protect nobody ---- */

/* Applies the "KEY to VALUE" of a remedy. */
static void follow(const char *remedy, struct params *p) {
    char key[60], value[30], setting[100];
    const char *one = setting;
    struct error error;
    if (sscanf(remedy, "set %59s to %29s", key, value) != 2) fail_msg("no value in: %s", remedy);
    for (char *end = value + strlen(value) - 1; *end == ';' || *end == ','; end--) *end = '\0';
    snprintf(setting, sizeof setting, "%s=%s", key, value);
    if (config_override(p, "test", &one, 1, &error)) fail_msg("%s: %s", remedy, error.text);
}

static void a_limit_that_protects_nobody_is_said_with_a_value_that_does(void **unused) {
    (void)unused;
    static const struct {
        const char *setting, *said;
    } cases[] = {
        {"limits.force_n=40000", "the supply pushes a leg with 3.12e+04 N"},
        {"limits.leg_rate_mps=1.5", "makes 0.668 m/s"},
        {"limits.following_m=0.2", "limits.following_m 0.2: with a stroke of 0.8 m"},
        {"limits.standstill_m=0.1", "limits.standstill_m 0.1"},
        {"limits.standstill_m=0.011", "is not below limits.following_m"},
        {"limits.standstill_m=0.0002", "sensors.position_resolution_m is 5e-05"},
        {"limits.following_m=0.0002", "limits.following_m 0.0002"},
        {"limits.pressure_max_pa=1e8", "supply and sensors end at"},
        {"limits.pressure_min_pa=-1e7", "only a sensor far below its range"},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct params p = load(NULL, &cases[i].setting, 1);
        const struct doctor d = {.params = &p};
        struct finding f = check_limits(&d);
        if (f.level != LEVEL_WARN || !strstr(f.found, cases[i].said)) fail_msg("%s: %s", cases[i].setting, f.found);
        for (int n = 0; n < 3 && f.level == LEVEL_WARN; n++) follow(f.remedy, &p), f = check_limits(&d);
        if (f.level != LEVEL_OK) fail_msg("%s: as proposed, and still: %s", cases[i].setting, f.found);
    }
}

static void patience_in_which_a_leg_goes_far_is_said(void **unused) {
    (void)unused;
    static const char *const patient[] = {"limits.sensor_age_s=0.2", "limits.blind_time_s=1"}, *const hasty[] = {"limits.bad_cycles=1"};
    struct params p = load(NULL, patient, 2);
    const struct doctor d = {.params = &p};
    struct finding f = check_limits(&d);
    assert_int_equal(f.level, LEVEL_WARN);
    assert_non_null(strstr(f.found, "a leg at full opening goes"));
    p = load(NULL, hasty, 1);
    f = check_limits(&d);
    assert_non_null(strstr(f.found, "one sample that is bad is a fault"));
}

/* The warning applies only if the readings come over a bus. */
static void a_channel_that_ends_below_the_supply_is_said(void **unused) {
    (void)unused;
    static const char *const low[] = {"p1_channel.high=8e6"};
    struct params p = load(NULL, low, 1);
    const struct doctor bus = {.params = &p, .machine = true}, simulated = {.params = &p};
    struct finding f = check_limits(&bus);
    assert_non_null(strstr(f.found, "p1_channel.high 8e+06"));
    assert_int_equal(check_limits(&simulated).level, LEVEL_OK);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_limit_trips_on_every_shipped_machine),
        cmocka_unit_test(a_leg_that_does_not_follow_or_move_trips_on_every_shipped_machine),
        cmocka_unit_test(a_limit_that_protects_nobody_is_said_with_a_value_that_does),
        cmocka_unit_test(patience_in_which_a_leg_goes_far_is_said),
        cmocka_unit_test(a_channel_that_ends_below_the_supply_is_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
