/* Fuzzes the loop against the model. An episode is a configuration and a list of events, both drawn
 * from a seed. An episode that breaks the model is shortened by omitting events as long as the same
 * rule is broken, and then printed. */
#ifndef HEXID_TESTS_SUPERVISOR_FUZZ_H
#define HEXID_TESTS_SUPERVISOR_FUZZ_H

#include <malloc.h>

#include "params.h"
#include "supervisor_clients.h"
#include "supervisor_world.h"

enum {
    EPISODE = 4000,
    EVENTS_MAX = 400,
    RECORDS = 16,
    CALM = 300 /* number of cycles for which effects of a disturbance are allowed for */
};

struct episode {
    uint64_t seed;
    struct params params;
    enum clock_kind clock;
    bool operated;               /* commands come from clients under leases; otherwise straight into
                                  * the mailbox */
    struct event events[EVENTS_MAX];
    int count, cycles;
    bool simulated;              /* runs on the simulated platform, which takes five times as
                                  * long */
};

/* ---- drawing an episode ---- */

static inline void draw_motion(struct params *p, uint64_t *seed) {
    p->motion.automatic = below(seed, 3) == 0;
    p->motion.park_z_m = between(seed, 0.1, 0.4);
    p->motion.engage_s = between(seed, 1.3, 2.0), p->motion.park_s = between(seed, 1.3, 2.0);
    p->motion.hold_s = between(seed, 0.0, 0.3);
    p->tests.settle_s = between(seed, 0.0, 0.1), p->tests.ramp_s = between(seed, 0.2, 0.4);
    p->tests.duration_s = between(seed, 0.1, 0.5), p->tests.ramp_out_s = between(seed, 0.2, 0.4);
    p->tests.count = 1 + below(seed, DOFS);
    p->tests.multisine = below(seed, 4) == 0;
    for (int i = 0; i < DOFS; i++) p->tests.hz[i] = between(seed, 1.0, 4.0), p->tests.amplitude[i] = between(seed, 0.0005, 0.002);
}

static inline void draw_limits(struct params *p, uint64_t *seed) {
    struct interlock_params *i = &p->interlocks;
    p->limits.bad_cycles = 1 + below(seed, 10);
    p->limits.sensor_age_s = between(seed, 0.004, 0.02);
    p->loop.overrun_limit = 1 + below(seed, 15);
    i->emergency_stop = below(seed, 4), i->enable = below(seed, 4), i->door = below(seed, 4);
    i->pressure = below(seed, 3), i->supply = below(seed, 3);
    i->discrepancy_s = between(seed, 0.0, 0.1);
    i->pressure_s = between(seed, 0.05, 0.6);
}

/* Draws the kind of an event. Common operator actions are frequent; faults are rare enough for the
 * platform to move. Some kinds come together more often than by chance. */
static inline enum kind draw_kind(uint64_t *seed, int trouble, enum kind before) {
    static const enum kind together[EVENTS] = {
        [EVENT_STALL] = EVENT_READ_FAILS,         [EVENT_WRITE_FAILS] = EVENT_INPUT_OPENS, [EVENT_PRESSURE_NAN] = EVENT_LENGTH_NAN,
        [EVENT_CLIENT_HANGS] = EVENT_MAIN_STALLS, [EVENT_CLIENT_GONE] = EVENT_COMMAND,     [EVENT_INPUT_OPENS] = EVENT_COMMAND,
    };
    if (together[before] && below(seed, 3) == 0) return together[before];
    if (below(seed, 100) >= trouble) return below(seed, 25) ? EVENT_UPWARDS : EVENT_COMMAND;
    return (enum kind)(EVENT_CLIENT_HANGS + below(seed, EVENTS - EVENT_CLIENT_HANGS));
}

static inline int draw_length(uint64_t *seed, const struct params *p) {
    switch (below(seed, 4)) {
    case 0: return 1;
    case 1: return 1 + below(seed, p->limits.bad_cycles + 2);
    case 2: return p->limits.bad_cycles + below(seed, 20);
    default: return 1 + below(seed, 300);
    }
}

static inline void episode_draw(struct episode *e, uint64_t seed) {
    static const enum command commands[] = {COMMAND_STOP,  COMMAND_STOP, COMMAND_PARK, COMMAND_ENGAGE,          COMMAND_START,
                                            COMMAND_RESET, COMMAND_NONE, COMMANDS,     (enum command)UINT32_MAX};
    uint64_t state = mix(seed) << 20;
    *e = (struct episode){.seed = seed, .cycles = EPISODE};
    e->params = brisk();
    e->params.control.law = seed % 2 ? CONTROL_MODEL : CONTROL_PID;
    draw_motion(&e->params, &state);
    draw_limits(&e->params, &state);
    e->clock = below(&state, 6) ? CLOCK_REAL : CLOCK_PACED;
    e->operated = !e->params.motion.automatic && below(&state, 2);
    e->params.lcm.commands = true, e->params.lcm.lease_s = between(&state, 0.05, 1.0);
    static const int troubles[] = {0, 1, 2, 4, 10, 40};
    int trouble = troubles[below(&state, 6)], often = 10 + below(&state, 80);
    /* the first event is near the cycle from which the sensors are trusted */
    int cycle = 40 + below(&state, 20);
    for (; e->count < EVENTS_MAX; e->count++) {
        struct event *v = &e->events[e->count];
        enum kind before = e->count ? v[-1].kind : EVENT_UPWARDS;
        /* events often coincide */
        if (e->count) cycle += below(&state, 4) ? 1 + below(&state, 2 * often) : below(&state, 3);
        if (cycle >= EPISODE) break;
        *v = (struct event){.cycle = cycle,
                            .kind = draw_kind(&state, trouble, before),
                            .cycles = draw_length(&state, &e->params),
                            .leg = below(&state, LEGS)};
        v->value = uniform(&state);
        if (v->kind == EVENT_COMMAND) v->value = commands[below(&state, (int)(sizeof commands / sizeof *commands))];
    }
}

/* ---- running an episode ---- */

struct run {
    const struct episode *episode;
    struct world world;
    struct loop loop;
    struct ring records;
    struct model model;
    int64_t popped, next_seq, gaps;     /* counters of the present loop's records */
    struct clients clients;
    uint32_t last_id;
    FILE *told;                         /* file to which the last cycles are printed, NULL: none */
};

static inline void loop_begin(struct run *r) {
    struct error error;
    while (ring_count(&r->records)) ring_pop(&r->records, &(struct cycle){0});
    assert_int_equal(loop_init(&r->loop, &r->episode->params, &r->world.hal, &r->records, r->episode->clock, &error), STATUS_OK);
    model_init(&r->model, &r->episode->params);
    r->popped = r->next_seq = r->gaps = 0, r->last_id = 0;
    clients_begin(&r->clients, &r->episode->params, &r->loop);
}

static inline enum command upwards(enum state state) {
    static const enum command next[STATES] = {
        [STATE_SETTLED] = COMMAND_ENGAGE, [STATE_READY] = COMMAND_START, [STATE_FAULT] = COMMAND_RESET};
    return next[state];
}

static inline void ask(struct run *r, const struct event *v, enum command command) {
    if (command == COMMAND_NONE) return;
    if (!r->episode->operated) mailbox_post(&r->loop.requests, command);
    else clients_ask(&r->clients, v->leg, command, v->cycles % 8 != 0);
}

/* Starts the events of this cycle. */
static inline void befall(struct run *r, int *next) {
    struct world *w = &r->world;
    for (; *next < w->count && w->events[*next].cycle <= w->cycle; ++*next) {
        const struct event *v = &w->events[*next];
        bool input = v->kind == EVENT_INPUT_OPENS || v->kind == EVENT_CONTRADICTION;
        int leg = input ? v->leg % INPUTS : v->leg;
        bool each = v->kind >= EVENT_LENGTH_NAN && v->kind <= EVENT_PRESSURE_HIGH;
        if (!each && !input && v->kind != EVENT_VALVE_STICKS && v->kind != EVENT_PUSHED) leg = 0;
        w->until[v->kind][leg] = w->cycle + v->cycles, w->value[v->kind][leg] = v->value;
        bool disturbs = v->kind >= EVENT_LENGTH_NAN && w->cycle + v->cycles + CALM > w->disturbed_until;
        if (disturbs) w->disturbed_until = w->cycle + v->cycles + CALM;
        if (v->kind == EVENT_UPWARDS) ask(r, v, upwards(r->loop.platform.supervisor.state));
        if (v->kind == EVENT_COMMAND) ask(r, v, (enum command)v->value);
        if (v->kind == EVENT_CLIENT_HANGS) r->clients.client[v->leg].hangs_until = w->cycle + 10 * v->cycles;
        if (v->kind == EVENT_CLIENT_GONE) clients_gone(&r->clients, v->leg);
        if (v->kind == EVENT_QUIT) loop_quit(&r->loop);
        if (v->kind == EVENT_RESTART) loop_begin(r);
    }
    if (under_way(w, EVENT_DEVICE_RESTART, 0)) w->until[EVENT_DEVICE_RESTART][0] = w->cycle + 1;
}

static inline bool spoilt(const struct world *w) {
    for (int k = EVENT_LENGTH_NAN; k <= EVENT_LENGTH_FROZEN; k++)
        for (int i = 0; i < LEGS; i++)
            if (under_way(w, (enum kind)k, i)) return true;
    return under_way(w, EVENT_STALE, 0) || under_way(w, EVENT_HANG, 0);
}

static inline int64_t lateness(const struct world *w, const struct params *p) {
    if (!under_way(w, EVENT_STALL, 0)) return 0;
    double most = w->value[EVENT_STALL][0] < 0.5 ? 3.0 : 2.0 * p->loop.overrun_limit;
    return (int64_t)(p->loop.period_s * NS_PER_S * most * (0.5 + 0.5 * noise(w, 99)));
}

/* Copies this cycle's record to `c`: the newest in the ring or, if it was lost because the recorder
 * stalls and the ring is full, one made from the platform itself. */
static inline void take_record(struct run *r, uint64_t lost, int test, struct cycle *c) {
    const struct platform *p = &r->loop.platform;
    uint64_t head = atomic_load(&r->records.head);
    if (atomic_load(&r->loop.lost) == lost) {
        memcpy(c, r->records.slots + ((head - 1) & (r->records.capacity - 1)) * r->records.element_size, sizeof *c);
        return;
    }
    *c = (struct cycle){.seq = (uint64_t)p->seq - 1,
                        .out = p->command,
                        .state = p->supervisor.state,
                        .faults = p->supervisor.faults,
                        .first_fault = p->supervisor.first_fault,
                        .test = test,
                        .dof = DOF_NONE,
                        .phase = PHASE_RAMP_OUT};
    c->in.flags = SAMPLE_INVALID;
    memcpy(c->ref, p->ref, sizeof c->ref);
    memcpy(c->pose, p->pose, sizeof c->pose);
    memcpy(c->force_n, p->force_n, sizeof c->force_n);
}

/* Plays the recorder. Every lost sequence number must be counted. */
static inline bool drain(struct run *r) {
    struct model *m = &r->model;
    struct cycle c;
    if (under_way(&r->world, EVENT_RECORDER_STALLS, 0) && r->loop.clock.kind == CLOCK_REAL) return true;
    while (ring_pop(&r->records, &c)) {
        never((int64_t)c.seq < r->next_seq, "record %d came after %d", (int)c.seq, (int)r->next_seq - 1);
        r->gaps += (int64_t)c.seq - r->next_seq;
        r->next_seq = (int64_t)c.seq + 1;
        r->popped++;
    }
    int64_t lost = (int64_t)atomic_load(&r->loop.lost);
    never(r->popped + lost != m->cycles, "%d records and %d lost of %d cycles", (int)r->popped, (int)lost, (int)m->cycles);
    never(r->gaps > lost, "a gap of %d in the records, %d counted", (int)r->gaps, (int)lost);
    return true;
}

static inline void cycle_print(int cycle, const struct seen *s, FILE *out) {
    const struct cycle *c = &s->out;
    fprintf(out, "#   in cycle %d: %s, faults %x (headline %x), flags %x, z %.5f m, valve 1 %.4f\n", cycle, state_names[c->state],
            (unsigned)c->faults, (unsigned)c->first_fault, (unsigned)c->in.flags, c->ref[DOF_Z], c->out.valve[0]);
}

static inline bool run_cycle(struct run *r, int *next) {
    struct world *w = &r->world;
    struct seen s = {.real = r->loop.clock.kind == CLOCK_REAL};
    r->clients.now_ns = world_ns;
    befall(r, next);
    clients_turn(&r->clients, &r->episode->params, w->cycle, under_way(w, EVENT_MAIN_STALLS, 0));
    struct request request = mailbox_read(&r->loop.requests);
    s.command = request.id == r->last_id ? COMMAND_NONE : request.command;
    r->last_id = request.id;
    if (s.command != COMMAND_NONE && atomic_load(&r->loop.quit)) s.command = COMMAND_PARK;
    uint64_t lost = atomic_load(&r->loop.lost);
    int test = r->loop.platform.test;
    s.unwritten = r->loop.unwritten && r->model.cycles > 0;
    s.late_ns = world_late_ns = lateness(w, &r->episode->params);
    w->writes = w->safes = 0;
    bool goes_on = loop_cycle(&r->loop);
    if ((unsigned)s.command >= COMMANDS) s.command = COMMAND_NONE;
    take_record(r, lost, test, &s.out);
    s.lost = atomic_load(&r->loop.lost) != lost;
    s.read_failed = w->read_failed;
    if (!s.read_failed) s.in = w->last;
    s.in.flags |= world_flags(w);
    s.spoilt = spoilt(w);
    s.disturbed = w->cycle < w->disturbed_until;
    s.write_failed = w->writes && under_way(w, EVENT_WRITE_FAILS, 0);
    s.writes = w->writes, s.safes = w->safes, s.written = w->written;
    if (r->told && w->cycle + 5 >= r->episode->cycles) cycle_print(w->cycle, &s, r->told);
    if (!model_step(&r->model, &s) || !drain(r)) return false;
    struct model *m = &r->model;
    if (r->episode->operated && (!never_by_clients(&r->clients, m, s.command) || !never_unled(&r->clients, m))) return false;
    never(!goes_on && model_powers(s.out.state), "the loop ended in %s", state_names[s.out.state]);
    world_move(w);
    w->cycle++;
    if (!goes_on) loop_begin(r);
    return true;
}

/* Runs an episode. Returns the cycle that broke the model, -1 if none did. */
static inline int episode_run(const struct episode *e, struct run *r, FILE *told) {
    long edges[STATES][STATES];
    int next = 0, broke = -1;
    memcpy(edges, r->model.edges, sizeof edges);
    memset(r, 0, sizeof *r);
    memcpy(r->model.edges, edges, sizeof edges);
    r->episode = e;
    r->told = told;
    assert_int_equal(ring_init(&r->records, sizeof(struct cycle), RECORDS), 0);
    struct error error;
    struct plant *plant = e->simulated ? plant_create(&e->params, e->seed, &error) : NULL;
    world_init(&r->world, plant, &e->params, e->seed, e->events, e->count);
    loop_begin(r);
    for (int n = 0; n < e->cycles && broke < 0; n++)
        if (!run_cycle(r, &next)) broke = n;
    ring_free(&r->records);
    if (plant) plant_destroy(plant);
    return broke;
}

/* ---- the shortest history ---- */

/* Omits events while the same rule is broken: halves, quarters, ..., single ones. */
static inline void episode_shorten(struct episode *e, struct run *r) {
    char text[sizeof r->model.text];
    int rule = r->model.rule;
    memcpy(text, r->model.text, sizeof text);
    for (int size = e->count; size >= 1; size = size > 1 ? (size + 1) / 2 : 0)
        for (int at_event = 0; at_event < e->count;) {
            struct episode *shorter = malloc(sizeof *shorter);
            *shorter = *e;
            int left_out = at_event + size < e->count ? size : e->count - at_event;
            memmove(shorter->events + at_event, shorter->events + at_event + left_out,
                    (size_t)(e->count - at_event - left_out) * sizeof *e->events);
            shorter->count -= left_out;
            int broke = episode_run(shorter, r, NULL);
            if (broke >= 0 && r->model.rule == rule) {
                shorter->cycles = broke + 1;
                while (shorter->count && shorter->events[shorter->count - 1].cycle > broke) shorter->count--;
                *e = *shorter;
                memcpy(text, r->model.text, sizeof text);
            } else at_event += left_out;
            free(shorter);
        }
    memcpy(r->model.text, text, sizeof text);
}

static inline void episode_print(const struct episode *e, const char *text, FILE *out) {
    const struct params *p = &e->params;
    fprintf(out,
            "# seed %llu, cycle %d: %s\n"
            "# the shortest history of it: automatic %d, bad_cycles %d, overrun_limit %d, sensor_age_s %.4f, interlocks "
            "%d%d%d%d%d, pressure_s %.3f, %s clock\n",
            (unsigned long long)e->seed, e->cycles - 1, text, p->motion.automatic, p->limits.bad_cycles, p->loop.overrun_limit,
            p->limits.sensor_age_s, p->interlocks.emergency_stop, p->interlocks.enable, p->interlocks.door, p->interlocks.pressure,
            p->interlocks.supply, p->interlocks.pressure_s, e->clock == CLOCK_REAL ? "real" : "paced");
    for (int i = 0; i < e->count; i++) {
        const struct event *v = &e->events[i];
        fprintf(out, "#   cycle %4d: %s", v->cycle, event_names[v->kind]);
        if (v->kind == EVENT_COMMAND) fprintf(out, " %s\n", v->value < COMMANDS ? command_names[(int)v->value] : "unknown");
        else fprintf(out, ", leg %d, for %d cycles, %.4f\n", v->leg + 1, v->cycles, v->value);
    }
}

/* Runs episodes, the first with this seed, until `cycles` have been run. Returns false and prints
 * the episode if one broke the model. */
static inline bool fuzz(uint64_t seed, int64_t cycles, bool simulated, struct run *r, void (*progress)(uint64_t seed, int64_t cycles)) {
    struct episode *e = malloc(sizeof *e);
    bool good = true;
    for (int64_t done = 0; done < cycles && good; done += EPISODE, seed++) {
        episode_draw(e, seed);
        e->simulated = simulated;
        int broke = episode_run(e, r, NULL);
        if (progress) progress(seed, done);
        if (broke < 0) continue;
        good = false;
        e->cycles = broke + 1;
        episode_shorten(e, r);
        episode_print(e, r->model.text, stdout);
        episode_run(e, r, stdout);
    }
    free(e);
    return good;
}

#endif
