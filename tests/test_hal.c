/* The table of back-ends, the simulated one and the fault injector: each fault has exactly the
 * effect of its name, only in its time window and only on its leg; and the loop's reaction. */
#include "support.h"

#include "hal.h"
#include "loop.h"
#include "units.h"

enum { PERIOD_NS = 2000000 };

/* ---- the table ---- */

static void every_back_end_is_complete_and_found_by_its_url(void **unused) {
    (void)unused;
    char url[64];
    for (int i = 0; hal_table[i]; i++) {
        const struct hal_ops *ops = hal_table[i];
        assert_true(ops->scheme && ops->usage && ops->open && ops->read && ops->write && ops->safe && ops->close);
        snprintf(url, sizeof url, "%s:", ops->scheme);
        assert_ptr_equal(hal_find(url), ops);
        /* the help begins with the URL */
        assert_int_equal(strncmp(ops->usage, url, strlen(url)), 0);
    }
}

static void refused(const char *url, enum status status, const char *part) {
    struct params params = by_hand();
    struct hal *hal = NULL;
    struct error error = {0};
    int result = hal_open(&hal, url, &params, 1, &error);
    if (result != status) fail_msg("%s: status %d, not %d", url, result, status);
    assert_null(hal);
    if (!strstr(error.text, part)) fail_msg("%s: no `%s` in: %s", url, part, error.text);
}

static void urls_that_name_nothing_are_refused(void **unused) {
    (void)unused;
    static const char *const urls[] = {"", "sim", "simulation:", ":", "SIM:", "nosuch:x", "si:", "fault"};
    for (unsigned i = 0; i < sizeof urls / sizeof *urls; i++) {
        assert_null(hal_find(urls[i]));
        refused(urls[i], STATUS_USAGE, urls[i]);
    }
}

static void malformed_faults_are_refused_with_the_form_to_write(void **unused) {
    (void)unused;
    /* clang-format off */
    static const char *const faults[] = {
        "", ";sim:", "drop;sim:", "drop@;sim:", "drop@1;sim:", "drop@1+;sim:", "drop@+1;sim:", "drop@1+0;sim:", "drop@1+-1;sim:",
        "drop@-1+1;sim:", "drop@nan+1;sim:", "drop@1+nan;sim:", "drop@1+inf;sim:", "drop@1e7+1;sim:", "drop@1+1", "drop@1+1,;sim:",
        "drop@1+1 ;sim:", "drop@1+1x;sim:", "drop@1+1;;sim:x", "none@1+1;sim:", "dropp@1+1;sim:", "dro@1+1;sim:", "@1+1;sim:",
        "nan@1+1/;sim:", "nan@1+1/0;sim:", "nan@1+1/7;sim:", "nan@1+1/-1;sim:", "nan@1+1/1.5;sim:", "nan@1+1/4294967297;sim:",
        "nan@1+1/x;sim:", "nan@1+1/nan;sim:", "nan@1+1/1/2;sim:", "nan@1+1=3;sim:", "nan@1+1=nan;sim:", "length@1+1;sim:",
        "length@1+1=;sim:", "length@1+1=nan;sim:", "length@1+1=inf;sim:", "length@1+1=1e300;sim:", "length@1+1=1=2;sim:",
        "length@1+1=1/1;sim:", "late@1+1;sim:", "late@1+1/3=1;sim:", "drop@1+1/3;sim:", "stale@1+1/3;sim:", "deaf@1+1=1;sim:",
    };
    /* clang-format on */
    for (unsigned i = 0; i < sizeof faults / sizeof *faults; i++) {
        char url[80];
        snprintf(url, sizeof url, "fault:%s", faults[i]);
        if (strcmp(faults[i], "drop@1+1;;sim:x")) refused(url, STATUS_USAGE, "KIND@FROM+LENGTH");
        else refused(url, STATUS_USAGE, "no such back-end");
    }
    char many[400] = "fault:drop@1+1";
    for (int n = 0; n < 16; n++) strcat(many, ",drop@1+1");
    strcat(many, ";sim:");
    refused(many, STATUS_USAGE, "at most 16");
}

static void a_fault_needs_a_back_end_behind_it_and_says_what_that_says(void **unused) {
    (void)unused;
    refused("fault:drop@1+1;", STATUS_USAGE, "no such back-end");
    refused("fault:drop@1+1;nosuch:", STATUS_USAGE, "nosuch:");
    refused("fault:drop@1+1;fault:drop@1;sim:", STATUS_USAGE, "KIND@FROM+LENGTH");
    struct params params = by_hand();
    all_legs(params.actuator.stroke_m, 3.6); /* the plant refuses because no pose is so low */
    struct hal *hal = NULL;
    struct error error = {0};
    assert_true(hal_open(&hal, "fault:drop@1+1;sim:", &params, 1, &error) < 0);
    assert_true(error.text[0]);
}

/* ---- the injector against the back-end behind it ---- */

struct pair {
    struct params params;
    struct hal *plain, *broken;
    int writes;
    struct hal_sample healthy, got, before; /* readings of this cycle, without and with the fault;
                                             * healthy readings of the cycle before */
    int status;
    int64_t now_ns;
};

static void pair_open(struct pair *p, const char *faults) {
    char url[160];
    struct error error;
    memset(p, 0, sizeof *p);
    p->params = by_hand();
    snprintf(url, sizeof url, "fault:%s;sim:", faults);
    assert_int_equal(hal_open(&p->plain, "sim:", &p->params, 5, &error), STATUS_OK);
    assert_int_equal(hal_open(&p->broken, url, &p->params, 5, &error), STATUS_OK);
    assert_int_equal(p->broken->ops->simulated, p->plain->ops->simulated);
}

static void pair_close(struct pair *p) {
    p->plain->ops->close(p->plain);
    p->broken->ops->close(p->broken);
}

/* Reads both back-ends. Both then get the same command, which lifts the platform unevenly. */
static void pair_read(struct pair *p, int cycle) {
    p->now_ns = (int64_t)cycle * PERIOD_NS;
    p->before = p->healthy;
    p->healthy = p->got = (struct hal_sample){0};
    assert_int_equal(p->plain->ops->read(p->plain, p->now_ns, &p->healthy), 0);
    p->status = p->broken->ops->read(p->broken, p->now_ns, &p->got);
}

static int pair_write(struct pair *p) {
    const struct hal_command command = {.enable = true, .valve = {0.20, 0.22, 0.24, 0.26, 0.24, 0.22}, .supply = p->writes++ % 2};
    p->plain->ops->write(p->plain, &command);
    return p->broken->ops->write(p->broken, &command);
}

static void assert_same_sample(const struct hal_sample *a, const struct hal_sample *b) {
    assert_int_equal(a->time_ns, b->time_ns);
    assert_int_equal(a->age_ns, b->age_ns);
    assert_int_equal(a->device_seq, b->device_seq);
    assert_int_equal(a->flags, b->flags);
    assert_memory_equal(a->length_m, b->length_m, sizeof a->length_m);
    assert_memory_equal(a->p1_pa, b->p1_pa, sizeof a->p1_pa);
    assert_memory_equal(a->p2_pa, b->p2_pa, sizeof a->p2_pa);
}

/* Makes of a healthy sample what the fault is expected to; `before` is the last healthy one before
 * the window. */
typedef void expectation(struct hal_sample *healthy, const struct hal_sample *before, int64_t now_ns);

static void expect_stale(struct hal_sample *s, const struct hal_sample *before, int64_t now_ns) {
    *s = *before;
    s->age_ns = now_ns - before->time_ns;
    s->flags = SAMPLE_STALE;
}
static void expect_late(struct hal_sample *s, const struct hal_sample *before, int64_t now_ns) {
    (void)before;
    s->time_ns = now_ns - 3000000;
    s->age_ns = 3000000;
    s->flags = SAMPLE_LATE;
}
static void expect_freeze(struct hal_sample *s, const struct hal_sample *before, int64_t now_ns) {
    (void)now_ns, s->length_m[2] = before->length_m[2];
}
static void expect_freeze_all(struct hal_sample *s, const struct hal_sample *before, int64_t now_ns) {
    (void)now_ns, memcpy(s->length_m, before->length_m, sizeof s->length_m);
}
static void expect_nan(struct hal_sample *s, const struct hal_sample *before, int64_t now_ns) {
    (void)before, (void)now_ns, s->length_m[5] = s->p1_pa[5] = s->p2_pa[5] = (double)NAN;
}
static void expect_length(struct hal_sample *s, const struct hal_sample *before, int64_t now_ns) {
    (void)before, (void)now_ns, s->length_m[0] += 0.01;
}
static void expect_pressure(struct hal_sample *s, const struct hal_sample *before, int64_t now_ns) {
    (void)before, (void)now_ns, s->p1_pa[3] += -5e5;
}
static void expect_swap(struct hal_sample *s, const struct hal_sample *before, int64_t now_ns) {
    (void)now_ns;
    double sixth = s->length_m[5];
    (void)before, s->length_m[5] = s->length_m[0], s->length_m[0] = sixth;
}
static void expect_swap_first(struct hal_sample *s, const struct hal_sample *before, int64_t now_ns) {
    (void)now_ns;
    double first = s->length_m[0];
    (void)before, s->length_m[0] = s->length_m[1], s->length_m[1] = first;
}

static void expect_hang(struct hal_sample *s, const struct hal_sample *before, int64_t now_ns) {
    *s = *before;
    s->time_ns = now_ns;
}
static void expect_drift(struct hal_sample *s, const struct hal_sample *before, int64_t now_ns) {
    (void)before, s->length_m[4] += 0.01 * seconds_from_ns(now_ns - ns_from_seconds(0.2));
}
static void expect_pressure_drift(struct hal_sample *s, const struct hal_sample *before, int64_t now_ns) {
    (void)before, s->p1_pa[1] += -1e5 * seconds_from_ns(now_ns - ns_from_seconds(0.2));
}
static void expect_pressure_freeze(struct hal_sample *s, const struct hal_sample *before, int64_t now_ns) {
    (void)now_ns, s->p1_pa[2] = before->p1_pa[2], s->p2_pa[2] = before->p2_pa[2];
}
static void expect_pressure_swap(struct hal_sample *s, const struct hal_sample *before, int64_t now_ns) {
    (void)before, (void)now_ns;
    double keep = s->p1_pa[2];
    s->p1_pa[2] = s->p2_pa[2], s->p2_pa[2] = keep;
}
static void expect_mix(struct hal_sample *s, const struct hal_sample *before, int64_t now_ns) {
    (void)before, (void)now_ns;
    double p1 = s->p1_pa[5], p2 = s->p2_pa[5];
    s->p1_pa[5] = s->p1_pa[0], s->p2_pa[5] = s->p2_pa[0];
    s->p1_pa[0] = p1, s->p2_pa[0] = p2;
}

static void each_fault_does_what_it_says_in_its_window_and_to_its_leg_only(void **unused) {
    (void)unused;
    static const struct {
        const char *fault;
        expectation *expect;
    } cases[] = {
        {"stale@0.2+0.1", expect_stale},
        {"late@0.2+0.1=0.003", expect_late},
        {"freeze@0.2+0.1/3", expect_freeze},
        {"freeze@0.2+0.1", expect_freeze_all},
        {"nan@0.2+0.1/6", expect_nan},
        {"length@0.2+0.1/1=0.01", expect_length},
        {"pressure@0.2+0.1/4=-5e5", expect_pressure},
        {"swap@0.2+0.1/6", expect_swap},
        {"swap@0.2+0.1", expect_swap_first},
        {"hang@0.2+0.1", expect_hang},
        {"drift@0.2+0.1/5=0.01", expect_drift},
        {"pressure_drift@0.2+0.1/2=-1e5", expect_pressure_drift},
        {"pressure_freeze@0.2+0.1/3", expect_pressure_freeze},
        {"pressure_swap@0.2+0.1/3", expect_pressure_swap},
        {"mix@0.2+0.1/6", expect_mix},
    };
    for (unsigned k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct pair p;
        struct hal_sample before = {0};
        int spoiled = 0;
        pair_open(&p, cases[k].fault);
        for (int n = 0; n < 200; n++) {
            pair_read(&p, n);
            struct hal_sample expected = p.healthy;
            if (n == 100) before = p.before;
            if (n >= 100 && n < 150) cases[k].expect(&expected, &before, p.now_ns);
            assert_same_sample(&p.got, &expected);
            spoiled += memcmp(&p.got, &p.healthy, sizeof p.got) != 0;
            assert_int_equal(p.status, 0);
            assert_int_equal(pair_write(&p), 0);
        }
        /* the lengths move, but exchanged ones may happen to be equal */
        assert_true(spoiled >= 40 && spoiled <= 50);
        pair_close(&p);
    }
}

static void a_dropped_read_fails_and_a_deaf_device_takes_no_command_but_safe(void **unused) {
    (void)unused;
    struct pair p;
    pair_open(&p, "drop@0.2+0.1,deaf@0.4+0.1");
    for (int n = 0; n < 300; n++) {
        pair_read(&p, n);
        /* from cycle 200 on, the machine with the fault has moved by an older command */
        if (n <= 200) assert_same_sample(&p.got, &p.healthy);
        assert_int_equal(p.status, n >= 100 && n < 150 ? -1 : 0);
        assert_int_equal(pair_write(&p), n >= 200 && n < 250 ? -1 : 0);
    }
    pair_close(&p);

    pair_open(&p, "deaf@0.1+100");
    for (int n = 0; n < 300; n++) {
        pair_read(&p, n);
        if (n < 150) pair_write(&p);
        if (n == 100) p.plain->ops->safe(p.plain), p.broken->ops->safe(p.broken);
        /* safe() must reach the valves whatever else fails */
        if (n > 50 && n < 150) p.plain->ops->safe(p.plain), p.broken->ops->safe(p.broken);
    }
    assert_same_sample(&p.got, &p.healthy);
    pair_close(&p);
}

static void a_twin_is_flagged_with_its_leg_and_changes_no_reading(void **unused) {
    (void)unused;
    static const char *const fault[] = {"twin@0.2+0.1", "twin@0.2+0.1/3"};
    for (int k = 0; k < 2; k++) {
        struct pair p;
        pair_open(&p, fault[k]);
        for (int n = 0; n < 200; n++) {
            bool active = n >= 100 && n < 150;
            pair_read(&p, n);
            assert_int_equal(p.got.flags, p.healthy.flags | (active ? SAMPLE_TWIN : 0));
            assert_int_equal(p.got.twins, active && k ? 1u << 2 : 0);
            assert_memory_equal(p.got.length_m, p.healthy.length_m, sizeof p.got.length_m);
            pair_write(&p);
        }
        pair_close(&p);
    }
}

/* Each cycle delivers either a healthy sample of some cycles ago or one spoilt at random. */
static void faults_of_order_and_chance_keep_their_promise(void **unused) {
    (void)unused;
    slow_case();
    static const struct {
        const char *fault;
        int back[4]; /* delay in cycles, by cycle % 4 */
    } cases[] = {{"delay@0.2+0.1=0.006", {3, 3, 3, 3}},
                 {"lag@0.2+0.1=0.004", {2, 2, 2, 2}},
                 {"repeat@0.2+0.1", {1, 0, 1, 0}},
                 {"reorder@0.2+0.1", {2, 0, 2, 0}}};
    for (unsigned k = 0; k < sizeof cases / sizeof *cases; k++) {
        static struct hal_sample past[200];
        struct pair p;
        pair_open(&p, cases[k].fault);
        for (int n = 0; n < 200; n++) {
            pair_read(&p, n);
            past[n] = p.healthy;
            const struct hal_sample *expected = &past[n >= 100 && n < 150 ? n - cases[k].back[n % 4] : n];
            assert_memory_equal(p.got.length_m, expected->length_m, sizeof p.got.length_m);
            assert_memory_equal(p.got.p2_pa, expected->p2_pa, sizeof p.got.p2_pa);
            pair_write(&p);
        }
        pair_close(&p);
    }
    static const char *const random[] = {"loss@0.2+100=20", "flip@0.2+100/2=20", "noise@0.2+100/2=0.001"};
    static const double share[] = {0.2, 0.2, 1.0};
    for (int k = 0; k < 3; k++) {
        struct pair p;
        int spoilt = 0;
        pair_open(&p, random[k]);
        for (int n = 0; n < 2100; n++) {
            pair_read(&p, n);
            bool same = !memcmp(p.got.length_m, p.healthy.length_m, sizeof p.got.length_m) && !(p.got.flags & SAMPLE_STALE);
            if (n < 100) assert_true(same);
            spoilt += !same;
            assert_true(p.got.length_m[0] == p.healthy.length_m[0] || p.got.flags & SAMPLE_STALE);
            if (k == 2) assert_below(fabs(p.got.length_m[1] - p.healthy.length_m[1]), 0.001000001);
        }
        assert_close(spoilt / 2000.0, share[k], 0.05); /* tolerance: five standard deviations of
                                                        * 2000 draws */
        pair_close(&p);
    }
}

/* The reference is a plant that is driven by the commands of the faulty valve. */
static void a_valve_at_fault_does_what_it_likes_also_when_centred(void **unused) {
    (void)unused;
    for (int k = 0; k < 2; k++) {
        struct pair p;
        pair_open(&p, k ? "valve@0.2+0.2/3=-0.4" : "stuck@0.2+0.2/3");
        for (int n = 0; n < 300; n++) {
            struct hal_command told = {.enable = true, .valve = {0.2, 0.2, n < 100 ? 0.2 : 0.1, 0.2, 0.2, 0.2}}, done = told;
            bool centred = n >= 150 && n < 200;
            pair_read(&p, n);
            assert_same_sample(&p.got, &p.healthy);
            if (centred) memset(done.valve, 0, sizeof done.valve);
            if (n >= 100 && n < 200) done.valve[2] = k ? -0.4 : 0.2;
            p.plain->ops->write(p.plain, &done);
            if (centred) p.broken->ops->safe(p.broken);
            else assert_int_equal(p.broken->ops->write(p.broken, &told), 0);
        }
        pair_close(&p);
    }
}

static void faults_add_up_and_each_remembers_its_own_beginning(void **unused) {
    (void)unused;
    struct pair p;
    double first = 0.0, second = 0.0;
    pair_open(&p, "freeze@0.2+0.2/1,freeze@0.3+0.2/2,length@0.35+0.01/1=0.001");
    for (int n = 0; n < 300; n++) {
        pair_read(&p, n);
        if (n == 100) first = p.before.length_m[0];
        if (n == 150)
            second = p.before.length_m[1]; /* the second fault begins while the first leg
                                                      * is already frozen */
        double expected[LEGS];
        memcpy(expected, p.healthy.length_m, sizeof expected);
        if (n >= 100 && n < 200) expected[0] = first;
        if (n >= 175 && n < 180) expected[0] += 0.001;
        if (n >= 150 && n < 250) expected[1] = second;
        assert_memory_equal(p.got.length_m, expected, sizeof expected);
        pair_write(&p);
    }
    assert_true(first != second);
    pair_close(&p);
}

/* ---- what the loop makes of them ---- */

struct outcome {
    uint32_t fault;
    int cycles;              /* number of cycles from the start of the window to the fault, both
                              * included */
    double largest_valve_step;
};

/* Runs the loop with these faults: engaged at 0.1 s, at neutral from 2.1 s, testing z from 2.5
 * s. */
static struct outcome run_with(const char *faults, double begin_s) {
    struct params params = by_hand();
    struct outcome outcome = {0};
    struct hal *hal;
    struct ring records;
    static struct loop loop;
    struct error error;
    struct cycle c;
    char url[160];
    double last[LEGS] = {0};
    params.tests.order[0] = DOF_Z;
    params.tests.settle_s = 0.2, params.tests.ramp_s = 0.25;
    snprintf(url, sizeof url, "fault:%s;sim:", faults);
    assert_int_equal(hal_open(&hal, url, &params, 7, &error), STATUS_OK);
    assert_int_equal(ring_init(&records, sizeof c, 4), 0);
    assert_int_equal(loop_init(&loop, &params, hal, &records, CLOCK_VIRTUAL, &error), STATUS_OK);
    for (int n = 0; n < 2000; n++) {
        if (n == 50) mailbox_post(&loop.requests, COMMAND_ENGAGE);
        if (n == 1250) mailbox_post(&loop.requests, COMMAND_START);
        assert_true(loop_cycle(&loop));
        assert_true(ring_pop(&records, &c));
        for (int i = 0; i < LEGS; i++) {
            outcome.largest_valve_step = fmax(outcome.largest_valve_step, c.out.enable ? fabs(c.out.valve[i] - last[i]) : 0.0);
            last[i] = c.out.valve[i];
            if (c.state == STATE_FAULT) assert_true(!c.out.enable && c.out.valve[i] == 0.0);
        }
        if (!c.faults) continue;
        if (outcome.fault) continue;
        assert_int_equal(c.state, failures_with(REACTION_PARK, c.first_fault) ? STATE_PARKING : STATE_FAULT);
        outcome.fault = c.first_fault;
        outcome.cycles = n + 1 - (int)lround(begin_s * 500);
    }
    if (!outcome.fault) assert_int_equal(c.state, STATE_TESTING);
    ring_free(&records);
    hal->ops->close(hal);
    return outcome;
}

static void the_loop_detects_or_rides_out_every_fault(void **unused) {
    (void)unused;
    slow_case();
    enum {
        BAD = 5,
        AGE = 5
    }; /* values of limits.bad_cycles, and of limits.sensor_age_s in
                                * cycles */
    static const struct {
        const char *fault; /* %g: start time */
        uint32_t expected;
        int within;
    } cases[] = {
        {"stale@%g+1", FAULT_SENSOR_AGE, AGE + BAD},
        {"stale@%g+0.008", 0, 0},
        {"late@%g+1=0.011", FAULT_SENSOR_AGE, BAD},
        {"late@%g+0.5=0.009", 0, 0},
        {"late@%g+1=-0.001", FAULT_SENSOR_AGE, BAD},
        {"drop@%g+1", FAULT_IO, BAD},
        {"drop@%g+0.008", 0, 0},
        {"deaf@%g+1", FAULT_IO, 1 + BAD}, /* a failed write is known a cycle later */
        {"deaf@%g+0.002", 0, 0},
        {"nan@%g+1/3", FAULT_SENSOR_INVALID, BAD},
        {"nan@%g+1", FAULT_SENSOR_INVALID, BAD},
        {"nan@%g+0.008/3", 0, 0},
        {"length@%g+1/2=0.01", FAULT_LEG_RATE, BAD},
        {"length@%g+1/2=-0.01", FAULT_LEG_RATE, BAD},
        {"length@%g+1/2=0.1", FAULT_LEG_RATE, BAD},
        {"length@%g+1/5=1", FAULT_STROKE, BAD},
        {"length@%g+0.008/2=0.1", 0, 0},
        {"pressure@%g+1/1=8e6", FAULT_FORCE, BAD},
        {"pressure@%g+1/1=20e6", FAULT_FORCE, BAD},
        {"pressure_nan@%g+1/4", FAULT_PRESSURE_SENSOR, BAD},
        {"pressure_nan@%g+0.008", 0, 0},
        {"emergency_stop@%g+1", FAULT_EMERGENCY_STOP, 1},
        {"enable@%g+0.002", FAULT_ENABLE, 1},
        {"door@%g+0.002", FAULT_DOOR, 1},
        {"inputs_off@%g+1=1", FAULT_EMERGENCY_STOP, 1},
        {"inputs_on@%g+1=16", FAULT_EMERGENCY_STOP, 1},
        {"inputs_off@%g+1=255", FAULT_EMERGENCY_STOP, 1},
        {"inputs_on@%g+1=15", 0, 0}, /* these bits mean that all inputs are closed */
        {"supply@%g+1", FAULT_SUPPLY, 40}, /* limit: the delays of relay and accumulator, and
                                            * bad_cycles */
        {"pressure@%g+0.008/6=8e6", 0, 0},
    };
    static const double begins[] = {1.2, 2.3, 3.3}; /* engaging, ready, testing */
    for (unsigned k = 0; k < sizeof cases / sizeof *cases; k++)
        for (int b = 0; b < 3; b++) {
            char faults[80];
            snprintf(faults, sizeof faults, cases[k].fault, begins[b]);
            struct outcome o = run_with(faults, begins[b]);
            if (o.fault != cases[k].expected) fail_msg("%s: %s, not %s", faults, fault_name(o.fault), fault_name(cases[k].expected));
            if (o.cycles > cases[k].within) fail_msg("%s: %d cycles, not %d", faults, o.cycles, cases[k].within);
            assert_below(o.largest_valve_step, 0.5);
        }
}

/* A dead transducer is detected as soon as the reference moves. Two exchanged ones make the legs'
 * loops work against each other. */
static void the_loop_detects_dead_and_exchanged_transducers_when_it_moves(void **unused) {
    (void)unused;
    slow_case();
    for (int leg = 1; leg <= LEGS; leg++) {
        char faults[80];
        snprintf(faults, sizeof faults, "freeze@1.2+100/%d", leg);
        struct outcome o = run_with(faults, 1.2);
        assert_int_equal(o.fault, FAULT_STANDSTILL);
        assert_true(o.cycles < 15); /* limit: 2 mm at 0.3 m/s, and bad_cycles */
        snprintf(faults, sizeof faults, "freeze@3.3+100/%d", leg);
        o = run_with(faults, 3.3);
        assert_int_equal(o.fault, FAULT_STANDSTILL);
        assert_true(o.cycles < 125 + 5); /* limit: a period of the test, and bad_cycles */
        snprintf(faults, sizeof faults, "swap@0.2+100/%d", leg);
        o = run_with(faults, 0.2);
        assert_true(o.fault != 0);
        assert_true(o.cycles < 500);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_back_end_is_complete_and_found_by_its_url),
        cmocka_unit_test(urls_that_name_nothing_are_refused),
        cmocka_unit_test(malformed_faults_are_refused_with_the_form_to_write),
        cmocka_unit_test(a_fault_needs_a_back_end_behind_it_and_says_what_that_says),
        cmocka_unit_test(each_fault_does_what_it_says_in_its_window_and_to_its_leg_only),
        cmocka_unit_test(a_dropped_read_fails_and_a_deaf_device_takes_no_command_but_safe),
        cmocka_unit_test(a_twin_is_flagged_with_its_leg_and_changes_no_reading),
        cmocka_unit_test(faults_of_order_and_chance_keep_their_promise),
        cmocka_unit_test(a_valve_at_fault_does_what_it_likes_also_when_centred),
        cmocka_unit_test(faults_add_up_and_each_remembers_its_own_beginning),
        cmocka_unit_test(the_loop_detects_or_rides_out_every_fault),
        cmocka_unit_test(the_loop_detects_dead_and_exchanged_transducers_when_it_moves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
