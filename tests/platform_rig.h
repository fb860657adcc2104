/* The whole controller, platform_step(), on the simulated machine. The rig checks in every cycle of
 * every test that valves are centred unless the state holds the platform, that commands are finite
 * and within +-1, and that the reference neither jumps nor exceeds its limits. */
#ifndef HEXID_TESTS_PLATFORM_RIG_H
#define HEXID_TESTS_PLATFORM_RIG_H

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
    uint32_t id;                    /* number of the last request */
    double stuck_valve;             /* all spools stick at this position whatever the command; 0:
                                     * none sticks */
    int cut_leg;                    /* leg whose valve cable is cut, -1: none */
    double largest_valve_step;      /* largest change of a command while driven, engage included */
    double leg_ref_before[LEGS];
};

typedef void spoiler(struct hal_sample *sample, int which); /* `which` is a cycle or a leg, as the
                                                             * test defines it */

static inline void rig_init(struct rig *rig, const struct params *params) {
    struct error error;
    memset(rig, 0, sizeof *rig);
    rig->params = *params;
    rig->cut_leg = -1;
    rig->plant = plant_create(&rig->params, 1, &error);
    assert_non_null(rig->plant);
    plant_add_power_unit(rig->plant, params->device.watchdog_s);
    assert_int_equal(platform_init(&rig->platform, &rig->params, &error), STATUS_OK);
}

static inline void check_always(struct rig *rig) {
    const struct cycle *c = &rig->now;
    bool drives = supervisor_drives(c->state), drove = rig->cycles > 0 && supervisor_drives(rig->before.state);
    assert_int_equal(c->out.enable, drives);
    /* A fault may be latched only in FAULT, or while parking if control still works with it. */
    if (c->faults && c->state != STATE_FAULT)
        assert_true(c->state == STATE_PARKING && failure_of(c->first_fault)->reaction == REACTION_PARK);
    if (c->state == STATE_FAULT) assert_true(c->faults);
    assert_int_equal(c->out.supply != rig->before.out.supply, supervisor_powers(c->state));
    assert_int_equal(c->seq, rig->cycles);
    for (int i = 0; i < LEGS; i++) {
        double step = c->out.valve[i] - rig->before.out.valve[i];
        if (!drives) assert_true(c->out.valve[i] == 0.0);
        assert_true(c->out.valve[i] >= -1.0 && c->out.valve[i] <= 1.0);
        assert_true(isfinite(c->pose[i]) && isfinite(c->ref[i]) && isfinite(c->force_n[i]));
        if (drives) rig->largest_valve_step = fmax(rig->largest_valve_step, fabs(step));
        /* No leg's reference exceeds that leg's speed limit; at the start of driving it equals the
         * leg's length. */
        double from = drove ? rig->leg_ref_before[i] : rig->platform.length_m[i];
        if (drives) assert_below(fabs(rig->platform.leg_ref_m[i] - from), rig->params.limits.leg_rate_mps * rig->params.loop.period_s);
        rig->leg_ref_before[i] = rig->platform.leg_ref_m[i];
    }
}

/* Runs one cycle with this sample and request. */
static inline void rig_step(struct rig *rig, const struct hal_sample *sample, struct request request) {
    static const double centred[LEGS] = {0};
    double valve[LEGS];
    rig->before = rig->now;
    platform_step(&rig->platform, sample, request, &rig->now);
    check_always(rig);
    memcpy(valve, rig->now.out.enable ? rig->now.out.valve : centred, sizeof valve);
    if (rig->cut_leg >= 0) valve[rig->cut_leg] = 0.0;
    for (int i = 0; i < LEGS && rig->stuck_valve != 0.0; i++) valve[i] = rig->stuck_valve;
    plant_life_sign(rig->plant, rig->now.out.supply);
    plant_step(rig->plant, valve);
    rig->cycles++;
}

static inline void rig_request(struct rig *rig, struct request request, spoiler *spoil, int which) {
    struct hal_sample sample = {.time_ns = rig->cycles * PERIOD_NS, .device_seq = (uint64_t)rig->cycles + 1};
    plant_measure(rig->plant, &sample);
    if (spoil) spoil(&sample, which);
    rig_step(rig, &sample, request);
}

static inline void rig_spoilt(struct rig *rig, spoiler *spoil, int which) {
    rig_request(rig, (struct request){.id = rig->id}, spoil, which);
}

/* Runs one cycle on the test's own sample, without a request. */
static inline void rig_given(struct rig *rig, const struct hal_sample *sample) { rig_step(rig, sample, (struct request){.id = rig->id}); }

/* Runs one cycle; any command except COMMAND_NONE is a new request. */
static inline void rig_cycle(struct rig *rig, enum command command) {
    if (command != COMMAND_NONE) rig->id++;
    rig_request(rig, (struct request){.id = rig->id, .command = command}, NULL, 0);
}

static inline void rig_run(struct rig *rig, int cycles) {
    for (int n = 0; n < cycles; n++) rig_cycle(rig, COMMAND_NONE);
}

static inline void rig_until(struct rig *rig, enum state state) {
    for (int n = 0; rig->now.state != state; n++) {
        rig_cycle(rig, COMMAND_NONE);
        if (n == 5000)
            fail_msg("10 s later still %s (%s), not %s", state_names[rig->now.state], fault_name(rig->now.first_fault), state_names[state]);
    }
}

/* Brings the platform from its present state into `state`, and runs `cycles` more cycles there. */
static inline void rig_bring(struct rig *rig, enum state state, int cycles) {
    static const enum command next[STATES] = {
        [STATE_SETTLED] = COMMAND_ENGAGE, [STATE_READY] = COMMAND_START, [STATE_FAULT] = COMMAND_RESET};
    for (int n = 0; rig->now.state != state; n++) {
        enum command command = next[rig->now.state];
        if (rig->platform.automatic) command = COMMAND_NONE;
        if (rig->now.state == STATE_READY && state == STATE_PARKING) command = COMMAND_PARK;
        rig_cycle(rig, command);
        assert_true(n < 5000);
    }
    rig_run(rig, cycles);
    assert_int_equal(rig->now.state, state);
}

static const enum state held[] = {STATE_ENGAGING, STATE_READY, STATE_TESTING, STATE_PARKING};
enum { HELD = 4 };

static inline void leg_too_short(struct hal_sample *s, int cycle) { (void)cycle, s->length_m[1] = 1.42; }
static inline void leg_too_long(struct hal_sample *s, int cycle) { (void)cycle, s->length_m[5] = 2.25; }
static inline void leg_too_fast(struct hal_sample *s, int cycle) { s->length_m[2] += (s->length_m[2] > 1.8 ? -2e-3 : 2e-3) * (cycle + 1); }
static inline void force_too_large(struct hal_sample *s, int cycle) { (void)cycle, s->p1_pa[3] = 6e6, s->p2_pa[3] = 0.0; }
static inline void pressure_too_high(struct hal_sample *s, int cycle) { (void)cycle, s->p1_pa[0] = 16.6e6, s->p2_pa[0] = 16.6e6; }
static inline void pressure_too_low(struct hal_sample *s, int cycle) { (void)cycle, s->p2_pa[4] = -2.1e5; }
static inline void length_not_a_number(struct hal_sample *s, int cycle) { (void)cycle, s->length_m[0] = (double)NAN; }
static inline void length_infinite(struct hal_sample *s, int cycle) { (void)cycle, s->length_m[5] = (double)INFINITY; }
static inline void pressure_not_a_number(struct hal_sample *s, int cycle) { (void)cycle, s->p2_pa[5] = (double)NAN; }
static inline void flagged_invalid(struct hal_sample *s, int cycle) { (void)cycle, s->flags |= SAMPLE_INVALID; }
static inline void flagged_io(struct hal_sample *s, int cycle) { (void)cycle, *s = (struct hal_sample){.flags = SAMPLE_IO}; }
static inline void too_old(struct hal_sample *s, int cycle) { (void)cycle, s->age_ns = 10000001; }
static inline void from_the_future(struct hal_sample *s, int cycle) { (void)cycle, s->age_ns = -1; }
static inline void all_not_a_number(struct hal_sample *s, int cycle) {
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
    {"pressure too high", pressure_too_high, FAULT_FORCE},
    {"pressure too low", pressure_too_low, FAULT_PRESSURE_SENSOR},
    {"length not a number", length_not_a_number, FAULT_SENSOR_INVALID},
    {"length infinite", length_infinite, FAULT_SENSOR_INVALID},
    {"pressure not a number", pressure_not_a_number, FAULT_PRESSURE_SENSOR},
    {"flagged invalid", flagged_invalid, FAULT_SENSOR_INVALID},
    {"not read", flagged_io, FAULT_IO},
    {"too old", too_old, FAULT_SENSOR_AGE},
    {"from the future", from_the_future, FAULT_SENSOR_AGE},
    {"nothing a number", all_not_a_number, FAULT_SENSOR_INVALID},
};
enum { BAD = sizeof bad / sizeof *bad };

static inline void spoil_cycles(struct rig *rig, spoiler *spoil, int cycles) {
    for (int n = 0; n < cycles; n++) rig_request(rig, (struct request){.id = rig->id}, spoil, n);
}

static inline bool parks(uint32_t fault) { return failure_of(fault)->reaction == REACTION_PARK; }

/* Keeps the latched fault present until the platform stands, at once or after parking. */
static inline void rig_trip(struct rig *rig, spoiler *spoil) {
    if (parks(rig->now.first_fault)) assert_int_equal(rig->now.state, STATE_PARKING);
    for (int n = 0; rig->now.state == STATE_PARKING && n < 5000; n++) rig_spoilt(rig, spoil, n);
    assert_int_equal(rig->now.state, STATE_FAULT);
}

#endif
