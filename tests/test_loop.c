/* The loop: its timing, its ends and its duties towards the back-end. The test's own clock_gettime
 * and clock_nanosleep override the C library's, so the test sets how late CLOCK_MONOTONIC is and
 * how often its sleeps are interrupted. */
#include "support.h"

#include <errno.h>
#include <sched.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "kinematics.h"
#include "loop.h"
#include "units.h"

enum { PERIOD_NS = 2000000, RING = 1 << 14 };

/* ---- the clock ---- */

static int64_t monotonic_ns = 123456789;
static int64_t late_ns;      /* lateness of the next sleep's end */
static int interruptions;    /* interruptions of the next sleep */
static int64_t told_ns;      /* deadline of the last sleep */

int clock_gettime(clockid_t id, struct timespec *t) {
    (void)id;
    *t = (struct timespec){.tv_sec = monotonic_ns / NS_PER_S, .tv_nsec = monotonic_ns % NS_PER_S};
    return 0;
}

int clock_nanosleep(clockid_t id, int flags, const struct timespec *until, struct timespec *left) {
    int64_t until_ns = until->tv_sec * NS_PER_S + until->tv_nsec;
    (void)left;
    assert_int_equal(id, CLOCK_MONOTONIC);
    assert_int_equal(flags, TIMER_ABSTIME);
    assert_true(until->tv_nsec >= 0 && until->tv_nsec < NS_PER_S);
    told_ns = until_ns;
    if (interruptions > 0) {
        interruptions--;
        return EINTR;
    }
    if (until_ns + late_ns > monotonic_ns) monotonic_ns = until_ns + late_ns;
    late_ns = 0;
    sched_yield(); /* the loop may be waiting for another thread */
    return 0;
}

/* ---- the back-end ---- */

/* A back-end of six legs whose speed is the valve's command; it counts its calls. */
struct fake {
    struct hal hal;
    double length_m[LEGS], valve[LEGS];
    int64_t now_ns;          /* time of the last read */
    int reads, writes, safes;
    bool read_fails, write_fails;
    bool powered;            /* the last call was a command */
    bool opened;             /* a valve was opened without enable */
};

static int fake_read(struct hal *hal, int64_t now_ns, struct hal_sample *sample) {
    struct fake *f = (struct fake *)hal;
    f->reads++;
    f->now_ns = now_ns;
    if (f->read_fails) return -1;
    for (int i = 0; i < LEGS; i++) sample->length_m[i] = f->length_m[i] += 0.5 * 0.002 * f->valve[i];
    sample->time_ns = now_ns;
    sample->inputs = f->powered ? INPUTS_ALL : INPUTS_ALL & ~(uint32_t)INPUT_SUPPLY;
    return 0;
}

static int fake_write(struct hal *hal, const struct hal_command *command) {
    struct fake *f = (struct fake *)hal;
    f->writes++;
    f->powered = true;
    for (int i = 0; i < LEGS && !command->enable; i++) f->opened |= command->valve[i] != 0.0;
    if (f->write_fails) return -1;
    memcpy(f->valve, command->valve, sizeof f->valve);
    return 0;
}

static void fake_safe(struct hal *hal) {
    struct fake *f = (struct fake *)hal;
    f->safes++;
    f->powered = f->write_fails; /* if writes fail, the machine's supply stays on for a while */
    memset(f->valve, 0, sizeof f->valve);
}

static const struct hal_ops fake_ops = {.scheme = "fake", .simulated = true, .read = fake_read, .write = fake_write, .safe = fake_safe};

/* ---- the bench ---- */

struct bench {
    struct params params;
    struct ring records;
    struct fake fake;
    struct hal *hal; /* back-end of the loop: the fake one, or sim: */
    struct loop loop;
    struct cycle last;
};

/* Prepares a loop on the back-end of `url`, or on the fake one, with a parked platform, if it is
 * NULL. */
static void bench_init(struct bench *b, const struct params *params, const char *url, uint64_t seed, enum clock_kind clock,
                       uint64_t capacity) {
    struct error error = {0};
    memset(b, 0, sizeof *b);
    b->params = *params;
    b->fake.hal.ops = &fake_ops;
    b->hal = &b->fake.hal;
    if (url) assert_int_equal(hal_open(&b->hal, url, &b->params, seed, &error), STATUS_OK);
    assert_int_equal(ring_init(&b->records, sizeof(struct cycle), capacity), 0);
    assert_int_equal(loop_init(&b->loop, &b->params, b->hal, &b->records, clock, &error), STATUS_OK);
    ik_lengths(&b->loop.platform.kinematics, (double[DOFS]){[DOF_Z] = params->motion.park_z_m}, b->fake.length_m);
}

static void bench_end(struct bench *b) {
    if (b->hal != &b->fake.hal) b->hal->ops->close(b->hal);
    ring_free(&b->records);
}

/* Runs one cycle and pops its record. */
static bool bench_cycle(struct bench *b) {
    bool more = loop_cycle(&b->loop);
    assert_true(ring_pop(&b->records, &b->last));
    return more;
}

static void bench_until(struct bench *b, enum state state) {
    for (int n = 0; n == 0 || b->last.state != state; n++) {
        assert_true(n < 5000);
        assert_true(bench_cycle(b));
        enum command next = b->last.state == STATE_SETTLED ? COMMAND_ENGAGE : b->last.state == STATE_READY ? COMMAND_START : COMMAND_NONE;
        if (next && b->last.state != state && n % 10 == 0) mailbox_post(&b->loop.requests, next);
    }
}

/* ---- time ---- */

static void cycles_stand_on_the_grid_of_the_period(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct bench b;
    bench_init(&b, &params, NULL, 1, CLOCK_REAL, 16);
    int64_t zero_ns = monotonic_ns;
    for (int n = 0; n < 1000; n++) {
        late_ns = n % 7 * 100000; /* late, but never by a whole period */
        interruptions = n % 3;
        int64_t wanted_late_ns = late_ns;
        assert_true(bench_cycle(&b));
        assert_int_equal(told_ns, zero_ns + (int64_t)n * PERIOD_NS);
        assert_int_equal(b.last.wake_late_ns, wanted_late_ns);
        assert_int_equal(b.fake.now_ns, (int64_t)n * PERIOD_NS + wanted_late_ns);
        assert_int_equal(b.last.in.flags, 0);
        assert_int_equal(b.last.seq, n);
    }
    assert_int_equal(b.loop.overruns, 0);
    bench_end(&b);
}

static void missed_deadlines_are_skipped_and_flagged_not_caught_up(void **unused) {
    (void)unused;
    static const int64_t late[] = {PERIOD_NS - 1, PERIOD_NS, PERIOD_NS + 1, 3 * PERIOD_NS - 1, 3 * PERIOD_NS, 20 * PERIOD_NS + 777};
    struct params params = by_hand();
    params.loop.overrun_limit = 100; /* high, because otherwise the larger delays would be a
                                      * fault */
    for (unsigned k = 0; k < sizeof late / sizeof *late; k++) {
        struct bench b;
        int64_t missed = late[k] / PERIOD_NS;
        bench_init(&b, &params, NULL, 1, CLOCK_REAL, 16);
        int64_t zero_ns = monotonic_ns;
        for (int n = 0; n < 5; n++) bench_cycle(&b);
        late_ns = late[k];
        bench_cycle(&b);
        assert_int_equal(b.last.wake_late_ns, late[k]);
        assert_int_equal(b.last.in.flags, missed ? SAMPLE_OVERRUN : 0);
        assert_int_equal(b.loop.overruns, missed);
        for (int n = 1; n < 5; n++) {
            int64_t before_ns = monotonic_ns;
            bench_cycle(&b);
            assert_int_equal(told_ns, zero_ns + (5 + missed + n) * PERIOD_NS); /* deadlines stay on
                                                                                * the old grid */
            /* the deadline is in the future, so cycles do not follow in a burst */
            assert_true(told_ns > before_ns);
            assert_int_equal(b.last.in.flags, 0);
            assert_int_equal(b.last.seq, 5 + n); /* the reference counts cycles */
        }
        assert_int_equal(b.loop.overruns, missed);
        bench_end(&b);
    }
}

static void overrun_limit_late_cycles_in_a_row_are_a_fault(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct bench b;
    bench_init(&b, &params, NULL, 1, CLOCK_REAL, 16);
    bench_until(&b, STATE_READY);
    for (int n = 1; n < params.loop.overrun_limit; n++) late_ns = PERIOD_NS, bench_cycle(&b);
    assert_int_equal(b.last.state, STATE_READY);
    late_ns = PERIOD_NS;
    bench_cycle(&b);
    assert_int_equal(b.last.first_fault, FAULT_OVERRUN);
    assert_memory_equal(b.fake.valve, (double[LEGS]){0}, sizeof b.fake.valve);
    bench_end(&b);
}

/* Five cycles miss ten deadlines. Two reads are closer together than their deadlines if the first
 * read was later in its own period. */
static void deadlines_are_counted_on_the_grid_not_between_reads(void **unused) {
    (void)unused;
    static const int64_t late[] = {3 * PERIOD_NS - 1, 2 * PERIOD_NS, 3 * PERIOD_NS - 1, 2 * PERIOD_NS, 3 * PERIOD_NS - 1};
    struct params params = by_hand();
    struct bench b;
    assert_int_equal(params.loop.overrun_limit, 10);
    bench_init(&b, &params, NULL, 1, CLOCK_REAL, 16);
    bench_until(&b, STATE_READY);
    for (int n = 0; n < 5; n++) {
        assert_int_equal(b.last.faults, 0);
        late_ns = late[n];
        bench_cycle(&b);
    }
    assert_int_equal(b.last.first_fault, FAULT_OVERRUN);
    bench_end(&b);
}

/* After a second's absence the first cycle is a fault, even if it has nothing to read or the
 * previous command could not be written; a failed read alone is no missed deadline. */
static void a_loop_that_was_away_is_a_fault_whatever_its_first_cycle_reads(void **unused) {
    (void)unused;
    struct params params = by_hand();
    for (int how = 0; how < 3; how++) {
        struct bench b;
        bench_init(&b, &params, NULL, 1, CLOCK_REAL, 16);
        bench_until(&b, STATE_READY);
        if (how == 1) b.fake.write_fails = true, bench_cycle(&b);
        b.fake.read_fails = how == 0;
        if (how < 2) late_ns = NS_PER_S;
        bench_cycle(&b);
        if (how < 2) {
            assert_int_equal(b.last.first_fault, FAULT_OVERRUN);
            assert_memory_equal(b.fake.valve, (double[LEGS]){0}, sizeof b.fake.valve);
        } else {
            b.fake.read_fails = true, bench_cycle(&b);
            assert_int_equal(b.last.in.time_ns, b.fake.now_ns);
            b.fake.read_fails = false, late_ns = PERIOD_NS, bench_cycle(&b);
            assert_int_equal(b.last.state, STATE_READY);
        }
        bench_end(&b);
    }
}

/* Runs cycles until the platform is parked, and returns how many the loop took to begin with it; -1
 * if it does not park within `cycles`. round, work: cycles from one call of loop_attend() to the
 * next, and those of them in which its thread works; 0, 0: it is never heard of again. */
static int parks_after(struct bench *b, int cycles, int round, int work) {
    loop_attend(&b->loop, false);
    for (int i = 0; i < cycles; i++) {
        if (round && i % round == 0) loop_attend(&b->loop, work > 0);
        if (round && i % round == work && work) loop_attend(&b->loop, false);
        assert_true(bench_cycle(b));
        if (b->last.state == STATE_PARKING) return i + 1;
        assert_int_equal(b->last.state, STATE_READY);
    }
    return -1;
}

/* A thread that comes round in time, also one that works all the time in short rounds, is no reason
 * to park; one that hangs, or is held up again and again, is. Virtual time is not watched. */
static void a_loop_whose_stops_nobody_takes_parks(void **unused) {
    (void)unused;
    struct params params = by_hand();
    static const struct {
        int kind, round, work, least, most;
    } cases[] = {
        {CLOCK_REAL, 10, 0, -1, -1},      {CLOCK_PACED, 40, 0, -1, -1},    {CLOCK_REAL, 10, 5, -1, -1},
        {CLOCK_PACED, 3, 2, -1, -1},      {CLOCK_REAL, 0, 0, 550, 552},    {CLOCK_PACED, 0, 0, 550, 552},
        {CLOCK_REAL, 500, 450, 740, 775}, {CLOCK_PACED, 30, 29, 730, 770}, {CLOCK_VIRTUAL, 0, 0, -1, -1},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct bench b;
        bench_init(&b, &params, NULL, 1, (enum clock_kind)cases[k].kind, 16);
        bench_until(&b, STATE_READY); /* nobody attends yet, and nothing is watched */
        int after = parks_after(&b, 3000, cases[k].round, cases[k].work);
        if (after < cases[k].least || after > cases[k].most) fail_msg("case %d: parks after %d cycles", (int)k, after);
        bench_end(&b);
    }
}

/* The loop takes no command while stops cannot be taken, and takes commands again afterwards. */
static void a_loop_that_is_attended_again_takes_commands_again(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct bench b;
    bench_init(&b, &params, NULL, 1, CLOCK_REAL, 16);
    bench_until(&b, STATE_READY);
    assert_true(parks_after(&b, 1000, 0, 0) > 0);
    for (int n = 0; b.last.state != STATE_SETTLED; n++) {
        assert_true(n < 5000);
        assert_true(bench_cycle(&b)); /* the run goes on */
    }
    mailbox_post(&b.loop.requests, COMMAND_ENGAGE);
    for (int n = 0; n < 100; n++) assert_true(bench_cycle(&b) && b.last.state == STATE_SETTLED);
    for (int n = 0; n < 200; n++) loop_attend(&b.loop, false), assert_true(bench_cycle(&b) && b.last.state == STATE_SETTLED);
    assert_false(atomic_load(&b.loop.unattended));
    mailbox_post(&b.loop.requests, COMMAND_ENGAGE);
    for (int n = 0; b.last.state != STATE_READY; n++) {
        assert_true(n < 5000);
        loop_attend(&b.loop, false);
        assert_true(bench_cycle(&b));
    }
    assert_int_equal(b.last.first_fault, 0);
    bench_end(&b);
}

static void virtual_time_has_no_wall_clock_in_it(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct bench b;
    bench_init(&b, &params, NULL, 1, CLOCK_VIRTUAL, 16);
    int64_t before_ns = monotonic_ns;
    for (int n = 0; n < 1000; n++) {
        bench_cycle(&b);
        assert_int_equal(b.fake.now_ns, (int64_t)n * PERIOD_NS);
        assert_true(b.last.wake_late_ns == 0 && b.last.exec_ns == 0);
    }
    assert_int_equal(monotonic_ns, before_ns);
    bench_end(&b);
}

/* Compares bit for bit, except padding and the host's clock. */
#define SAME(member) (memcmp(&a->member, &b->member, sizeof a->member) == 0)
static bool same_record(const struct cycle *a, const struct cycle *b) {
    return SAME(seq) && SAME(in.time_ns) && SAME(in.age_ns) && SAME(in.device_seq) && SAME(in.flags) && SAME(in.length_m) &&
           SAME(in.p1_pa) && SAME(in.p2_pa) && SAME(out.valve) && SAME(out.enable) && SAME(ref) && SAME(pose) && SAME(force_n) &&
           SAME(state) && SAME(faults) && SAME(first_fault) && SAME(test) && SAME(dof) && SAME(phase) && SAME(test_time_s);
}

static void paced_time_is_virtual_time_whatever_the_host_does(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct bench virtual_time, paced;
    int stalls = 0;
    params.motion.automatic = true;
    params.sim.engine = ENGINE_CLOSED_FORM;
    bench_init(&virtual_time, &params, "sim:", 42, CLOCK_VIRTUAL, 4);
    bench_init(&paced, &params, "sim:", 42, CLOCK_PACED, 4);
    for (int n = 0; n < 4000; n++) {
        bench_cycle(&virtual_time);
        late_ns = n % 37 ? n % 5 * 300000 : n % 11 * PERIOD_NS + 1234;
        int64_t host_late_ns = late_ns;
        bench_cycle(&paced);
        assert_true(same_record(&virtual_time.last, &paced.last));
        assert_true(paced.last.wake_late_ns >= host_late_ns);
        stalls += paced.last.wake_late_ns >= PERIOD_NS;
    }
    assert_true(stalls > 50);
    assert_int_equal(paced.last.faults, 0);
    assert_int_equal(paced.loop.overruns, 0);
    bench_end(&virtual_time), bench_end(&paced);
}

static void paced_time_follows_the_hosts_and_stretches_by_the_periods_that_a_stall_took(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct bench b;
    bench_init(&b, &params, NULL, 1, CLOCK_PACED, 16);
    int64_t grid_ns = monotonic_ns;
    for (int n = 0; n < 1000; n++, grid_ns += PERIOD_NS) {
        int64_t late = n % 10 == 7 ? n * 12345 : n % 7 * 100000;
        late_ns = late;
        int64_t before_ns = monotonic_ns;
        bench_cycle(&b);
        assert_int_equal(told_ns, grid_ns);
        assert_true(n == 0 || told_ns > before_ns); /* never a burst */
        assert_int_equal(b.last.wake_late_ns, late);
        grid_ns += late / PERIOD_NS * PERIOD_NS;
        assert_int_equal(b.fake.now_ns, (int64_t)n * PERIOD_NS);
        assert_int_equal(clock_now(&b.loop.clock), (int64_t)n * PERIOD_NS);
        assert_int_equal(b.last.in.flags, 0);
    }
    bench_end(&b);
}

/* ---- records ---- */

static void a_full_ring_costs_a_record_and_not_the_deadline(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct bench b;
    struct cycle c;
    bench_init(&b, &params, NULL, 1, CLOCK_REAL, 4);
    for (int n = 0; n < 10; n++) loop_cycle(&b.loop);
    assert_int_equal(atomic_load(&b.loop.lost), 6);
    assert_int_equal(b.fake.reads, 10);
    for (uint64_t n = 0; n < 4; n++) assert_true(ring_pop(&b.records, &c) && c.seq == n);
    bench_cycle(&b);
    assert_int_equal(b.last.seq, 10); /* the lost records leave a gap in seq */
    bench_end(&b);
}

static void the_loop_waits_for_room(enum clock_kind clock) {
    struct params params = by_hand();
    struct bench b;
    struct error error;
    uint64_t expected = 0;
    struct cycle c;
    bench_init(&b, &params, NULL, 1, clock, 4);
    assert_int_equal(loop_start(&b.loop, REALTIME_OFF, &error), STATUS_OK);
    while (expected < 500) { /* fills the ring of four a hundred times */
        if (!ring_pop(&b.records, &c)) {
            sched_yield();
            continue;
        }
        assert_int_equal(c.seq, expected++);
    }
    loop_quit(&b.loop);
    while (!atomic_load(&b.loop.ended) || ring_count(&b.records)) {
        if (ring_pop(&b.records, &c)) assert_int_equal(c.seq, expected++);
        else sched_yield();
    }
    loop_join(&b.loop);
    assert_int_equal(b.fake.reads, expected);
    assert_int_equal(atomic_load(&b.loop.lost), 0);
    bench_end(&b);
}

static void on_virtual_and_paced_time_the_loop_waits_for_room(void **unused) {
    (void)unused;
    the_loop_waits_for_room(CLOCK_VIRTUAL);
    the_loop_waits_for_room(CLOCK_PACED);
}

static void an_abort_does_not_wait_for_a_reader_that_is_gone(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct bench b;
    struct error error;
    bench_init(&b, &params, NULL, 1, CLOCK_VIRTUAL, 4);
    assert_int_equal(loop_start(&b.loop, REALTIME_OFF, &error), STATUS_OK);
    while (ring_count(&b.records) < 4) sched_yield();
    atomic_store(&b.loop.abort, true);
    loop_join(&b.loop); /* the loop would wait for ever if it waited for the recorder */
    assert_true(atomic_load(&b.loop.ended));
    bench_end(&b);
}

static void one_seed_gives_the_same_records_bit_for_bit(void **unused) {
    (void)unused;
    slow_case();
    static const enum engine_kind engines[] = {ENGINE_CLOSED_FORM, ENGINE_ODE};
    static const int cycles[] = {4000, 500};
    for (int e = 0; e < 2; e++) {
        struct params params = by_hand();
        struct bench one, same, other;
        bool differs = false;
        params.motion.automatic = true;
        params.sim.engine = engines[e];
        bench_init(&one, &params, "sim:", 42, CLOCK_VIRTUAL, 4);
        bench_init(&same, &params, "sim:", 42, CLOCK_VIRTUAL, 4);
        bench_init(&other, &params, "sim:", 43, CLOCK_VIRTUAL, 4);
        for (int n = 0; n < cycles[e]; n++) {
            bench_cycle(&one), bench_cycle(&same), bench_cycle(&other);
            assert_true(same_record(&one.last, &same.last));
            differs = differs || !same_record(&one.last, &other.last);
        }
        assert_true(differs);
        bench_end(&one), bench_end(&same), bench_end(&other);
    }
}

/* ---- ends ---- */

static void an_automatic_run_ends_by_itself_put_down(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct bench b;
    struct error error;
    int tested = 0;
    params.motion.automatic = true;
    bench_init(&b, &params, "sim:", 1, CLOCK_VIRTUAL, RING);
    assert_int_equal(loop_start(&b.loop, REALTIME_OFF, &error), STATUS_OK);
    loop_join(&b.loop);
    assert_true(ring_count(&b.records) < RING);
    while (ring_pop(&b.records, &b.last)) tested += b.last.phase == PHASE_EVALUATE;
    assert_int_equal(tested, 6 * 250);
    assert_int_equal(b.last.state, STATE_SETTLED);
    assert_int_equal(b.last.faults, 0);
    bench_end(&b);
}

static void a_record_says_which_request_was_taken_last(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct bench b;
    bench_init(&b, &params, NULL, 1, CLOCK_REAL, 16);
    bench_until(&b, STATE_SETTLED);
    uint32_t before = b.last.request_id, id = mailbox_post(&b.loop.requests, COMMAND_ENGAGE);
    assert_int_not_equal(id, before);
    bench_cycle(&b);
    assert_int_equal(b.last.request_id, id);
    assert_int_equal(b.last.request, COMMAND_ENGAGE);
    bench_cycle(&b);
    assert_int_equal(b.last.request_id, id);
    loop_quit(&b.loop);
    bench_cycle(&b);
    assert_int_equal(b.last.request_id, id + 1);
    assert_int_equal(b.last.request, COMMAND_PARK);
    bench_end(&b);
}

static void quit_puts_the_platform_down_first_whatever_else_is_asked(void **unused) {
    (void)unused;
    static const enum state from[] = {STATE_ENGAGING, STATE_READY, STATE_TESTING, STATE_PARKING};
    struct params params = by_hand();
    for (int k = 0; k < 4; k++) {
        struct bench b;
        bench_init(&b, &params, NULL, 1, CLOCK_VIRTUAL, 4);
        if (from[k] == STATE_PARKING) {
            bench_until(&b, STATE_READY);
            mailbox_post(&b.loop.requests, COMMAND_PARK);
        } else bench_until(&b, from[k]);
        for (int n = 0; n < 20; n++) bench_cycle(&b);
        assert_int_equal(b.last.state, from[k]);
        loop_quit(&b.loop);
        for (int n = 0;; n++) {
            bool more = bench_cycle(&b);
            assert_true(b.last.state == STATE_PARKING || b.last.state == STATE_SETTLED);
            assert_int_equal(more, b.last.state == STATE_PARKING);
            if (!more) break;
            mailbox_post(&b.loop.requests, n % 2 ? COMMAND_ENGAGE : COMMAND_START);
            assert_true(n < 3000);
        }
        /* tolerance: wide, because valves act as legs and the integral is at work */
        assert_close(b.last.pose[DOF_Z], params.motion.park_z_m, 1e-2);
        bench_end(&b);
    }
}

static void quit_ends_at_once_where_nothing_is_driven(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct bench b;
    bench_init(&b, &params, NULL, 1, CLOCK_VIRTUAL, 4);
    loop_quit(&b.loop);
    assert_false(bench_cycle(&b));
    bench_end(&b);
    bench_init(&b, &params, NULL, 1, CLOCK_VIRTUAL, 4);
    bench_until(&b, STATE_READY);
    b.fake.read_fails = true;
    while (b.last.state != STATE_FAULT) assert_true(bench_cycle(&b));
    loop_quit(&b.loop);
    assert_false(bench_cycle(&b));
    bench_end(&b);
}

static void abort_ends_at_once_with_the_valves_centred(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct bench b;
    struct error error;
    struct cycle c;
    bench_init(&b, &params, NULL, 1, CLOCK_VIRTUAL, RING);
    bench_until(&b, STATE_ENGAGING);
    for (int n = 0; n < 300; n++) bench_cycle(&b);
    assert_true(b.fake.valve[0] != 0.0);
    /* the thread continues from here */
    assert_int_equal(loop_start(&b.loop, REALTIME_OFF, &error), STATUS_OK);
    while (!ring_pop(&b.records, &c)) sched_yield();
    atomic_store(&b.loop.abort, true);
    loop_join(&b.loop);
    assert_memory_equal(b.fake.valve, (double[LEGS]){0}, sizeof b.fake.valve);
    assert_true(atomic_load(&b.loop.ended));
    bench_end(&b);
    bench_init(&b, &params, NULL, 1, CLOCK_VIRTUAL, 4);
    bench_until(&b, STATE_READY);
    atomic_store(&b.loop.abort, true);
    assert_false(bench_cycle(&b)); /* the loop does not run another cycle */
    bench_end(&b);
}

/* loop_start() must return if real time is refused. Every machine refuses a processor that does not
 * exist. */
static void real_time_that_is_refused_runs_nothing_when_required(void **unused) {
    (void)unused;
    pid_t child = fork(); /* in a child process, because locked memory stays with the process */
    if (child == 0) {
        static struct bench b;
        struct params params = by_hand();
        struct error error = {0};
        params.loop.cpu = CPU_SETSIZE - 1;
        bench_init(&b, &params, NULL, 1, CLOCK_VIRTUAL, 4);
        if (loop_start(&b.loop, REALTIME_REQUIRE, &error) != STATUS_UNSAFE || !error.text[0]) _exit(1);
        if (b.fake.reads || b.fake.writes || !b.fake.safes) _exit(2);
        bench_end(&b);
        bench_init(&b, &params, NULL, 1, CLOCK_VIRTUAL, 4);
        loop_quit(&b.loop);
        if (loop_start(&b.loop, REALTIME_TRY, &error)) _exit(3);
        loop_join(&b.loop);
        /* the loop ran and reports what was refused */
        if (!b.loop.realtime || !b.loop.realtime_error.text[0] || b.fake.reads != 1) _exit(4);
        _exit(0);
    }
    int status = -1;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
}

/* ---- duties ---- */

static void safe_is_called_in_every_cycle_without_supply_and_write_in_every_other(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct bench b;
    bench_init(&b, &params, NULL, 1, CLOCK_VIRTUAL, 4);
    for (int n = 0; n < 8000; n++) {
        int safes = b.fake.safes, writes = b.fake.writes;
        static const enum command round[] = {COMMAND_ENGAGE, COMMAND_START, COMMAND_PARK, COMMAND_RESET};
        if (n % 1500 == 100) mailbox_post(&b.loop.requests, round[n / 1500 % 4]);
        b.fake.read_fails = n > 6500 && n < 6600;
        bench_cycle(&b);
        bool powers = supervisor_powers(b.last.state);
        assert_int_equal(b.fake.safes - safes, !powers);
        assert_int_equal(b.fake.writes - writes, powers);
        if (powers) assert_memory_equal(b.fake.valve, b.last.out.valve, sizeof b.fake.valve);
    }
    assert_true(b.fake.safes > 100 && b.fake.writes > 1000);
    assert_false(b.fake.opened);
    bench_end(&b);
}

static void a_command_that_cannot_be_written_centres_the_valves_and_faults(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct bench b;
    bench_init(&b, &params, NULL, 1, CLOCK_VIRTUAL, 4);
    bench_until(&b, STATE_READY);
    b.fake.write_fails = true;
    for (int n = 0; n < params.limits.bad_cycles; n++) {
        int safes = b.fake.safes;
        bench_cycle(&b);
        assert_int_equal(b.last.state, STATE_READY);
        assert_int_equal(b.fake.safes, safes + 1);
        assert_memory_equal(b.fake.valve, (double[LEGS]){0}, sizeof b.fake.valve);
    }
    bench_cycle(&b); /* a failed write is known in the next cycle */
    assert_int_equal(b.last.first_fault, FAULT_IO);
    bench_end(&b);

    bench_init(&b, &params, NULL, 1, CLOCK_VIRTUAL, 4);
    bench_until(&b, STATE_READY);
    b.fake.write_fails = true;
    bench_cycle(&b);
    b.fake.write_fails = false;
    bench_cycle(&b);
    assert_true(b.last.in.flags & SAMPLE_IO); /* so that the identifier excludes the sample */
    bench_cycle(&b);
    assert_int_equal(b.last.in.flags, 0);
    assert_int_equal(b.last.state, STATE_READY); /* a single failed write changes no state */
    bench_end(&b);
}

static void a_device_that_cannot_be_read_faults_in_bad_cycles(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct bench b;
    bench_init(&b, &params, NULL, 1, CLOCK_VIRTUAL, 4);
    bench_until(&b, STATE_READY);
    b.fake.read_fails = true;
    for (int n = 1; n < params.limits.bad_cycles; n++) bench_cycle(&b);
    assert_int_equal(b.last.state, STATE_READY);
    bench_cycle(&b);
    assert_int_equal(b.last.first_fault, FAULT_IO);
    assert_memory_equal(b.fake.valve, (double[LEGS]){0}, sizeof b.fake.valve);
    bench_end(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cycles_stand_on_the_grid_of_the_period),
        cmocka_unit_test(missed_deadlines_are_skipped_and_flagged_not_caught_up),
        cmocka_unit_test(overrun_limit_late_cycles_in_a_row_are_a_fault),
        cmocka_unit_test(deadlines_are_counted_on_the_grid_not_between_reads),
        cmocka_unit_test(a_loop_that_was_away_is_a_fault_whatever_its_first_cycle_reads),
        cmocka_unit_test(a_loop_whose_stops_nobody_takes_parks),
        cmocka_unit_test(a_loop_that_is_attended_again_takes_commands_again),
        cmocka_unit_test(virtual_time_has_no_wall_clock_in_it),
        cmocka_unit_test(paced_time_is_virtual_time_whatever_the_host_does),
        cmocka_unit_test(paced_time_follows_the_hosts_and_stretches_by_the_periods_that_a_stall_took),
        cmocka_unit_test(a_full_ring_costs_a_record_and_not_the_deadline),
        cmocka_unit_test(on_virtual_and_paced_time_the_loop_waits_for_room),
        cmocka_unit_test(an_abort_does_not_wait_for_a_reader_that_is_gone),
        cmocka_unit_test(one_seed_gives_the_same_records_bit_for_bit),
        cmocka_unit_test(an_automatic_run_ends_by_itself_put_down),
        cmocka_unit_test(a_record_says_which_request_was_taken_last),
        cmocka_unit_test(quit_puts_the_platform_down_first_whatever_else_is_asked),
        cmocka_unit_test(quit_ends_at_once_where_nothing_is_driven),
        cmocka_unit_test(abort_ends_at_once_with_the_valves_centred),
        cmocka_unit_test(real_time_that_is_refused_runs_nothing_when_required),
        cmocka_unit_test(safe_is_called_in_every_cycle_without_supply_and_write_in_every_other),
        cmocka_unit_test(a_command_that_cannot_be_written_centres_the_valves_and_faults),
        cmocka_unit_test(a_device_that_cannot_be_read_faults_in_bad_cycles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
