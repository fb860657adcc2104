/* The surroundings of the fuzzed loop: a cheap plant behind its own back-end, and the events that
 * affect plant, samples, bus, clock and operator. A world is a pure function of its seed and
 * events, so a history can be replayed with some events omitted. The test's own clock_gettime and
 * clock_nanosleep override the C library's, so the world sets the time. */
#ifndef HEXID_TESTS_SUPERVISOR_WORLD_H
#define HEXID_TESTS_SUPERVISOR_WORLD_H

#include <errno.h>
#include <time.h>

#include "support.h"

#include "force.h"
#include "loop.h"
#include "plant.h"
#include "power_unit.h"

/* ---- events ---- */

enum kind {
    /* from the operator */
    EVENT_UPWARDS,     /* the next command towards operation from the present state */
    EVENT_COMMAND,     /* value: enum command, possibly an invalid one */
    EVENT_CLIENT_HANGS, /* leg: which client */
    EVENT_CLIENT_GONE,  /* leg: which client */
    EVENT_MAIN_STALLS,
    EVENT_QUIT,        /* the daemon is told to quit */
    EVENT_RESTART,     /* the daemon restarts on the plant as it is then */
    /* disturbances of the readings for `cycles`; some disturb only leg `leg` */
    EVENT_LENGTH_NAN,
    EVENT_LENGTH_LOW,
    EVENT_LENGTH_HIGH,
    EVENT_LENGTH_JUMP,
    EVENT_LENGTH_FROZEN,
    EVENT_PRESSURE_NAN,
    EVENT_PRESSURE_LOW,
    EVENT_PRESSURE_HIGH,
    EVENT_LATE,
    EVENT_STALE,
    EVENT_HANG,
    EVENT_FUTURE,
    EVENT_INVALID,
    EVENT_FOREIGN,
    EVENT_TWIN,
    EVENT_DEVICE_RESTART,
    EVENT_GAP,
    /* disturbances of the back-end and of time */
    EVENT_READ_FAILS,
    EVENT_WRITE_FAILS,
    EVENT_STALL,
    EVENT_RECORDER_STALLS,
    /* in the machine */
    EVENT_INPUT_OPENS, /* leg: which input */
    EVENT_CONTRADICTION, /* leg: which input */
    EVENT_VALVE_STICKS,
    EVENT_SUPPLY_LOST,
    EVENT_PUSHED,
    EVENTS
};
static const char *const event_names[EVENTS] = {
    "upwards",       "command",        "client_hangs", "client_gone", "main_stalls",   "quit",         "restart",
    "length_nan",    "length_low",     "length_high",  "length_jump", "length_frozen", "pressure_nan", "pressure_low",
    "pressure_high", "late",           "stale",        "hang",        "future",        "invalid",      "foreign",
    "twin",          "device_restart", "gap",          "read_fails",  "write_fails",   "stall",        "recorder_stalls",
    "input_opens",   "contradiction",  "valve_sticks", "supply_lost", "pushed",
};

struct event {
    int cycle, cycles; /* start and duration */
    enum kind kind;
    int leg;
    double value;      /* a number from 0 to 1, or enum command */
};

/* ---- random numbers ---- */

static inline uint64_t mix(uint64_t z) {
    z += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}
static inline double uniform(uint64_t *state) { return (double)(mix((*state)++) >> 11) * 0x1p-53; }
static inline int below(uint64_t *state, int count) { return (int)(uniform(state) * count); }
static inline double between(uint64_t *state, double low, double high) { return low + (high - low) * uniform(state); }

/* ---- the clock ---- */

static int64_t world_ns = 123456789, world_late_ns;

int clock_gettime(clockid_t id, struct timespec *t) {
    (void)id;
    *t = (struct timespec){.tv_sec = world_ns / NS_PER_S, .tv_nsec = world_ns % NS_PER_S};
    return 0;
}

int clock_nanosleep(clockid_t id, int flags, const struct timespec *until, struct timespec *left) {
    (void)id, (void)flags, (void)left;
    int64_t until_ns = until->tv_sec * NS_PER_S + until->tv_nsec + world_late_ns;
    if (until_ns > world_ns) world_ns = until_ns;
    return 0;
}

/* ---- the plant ---- */

/* The world of the loop. Its plant has six legs whose speed follows the spool, which follows the
 * command, under a light load: stable with hexid's default gains. They sink without supply. */
struct world {
    struct hal hal;
    const struct params *params;
    struct cylinder_areas areas;
    uint64_t seed;
    int cycle;
    const struct event *events;
    int count;
    int until[EVENTS][LEGS];     /* the leg's event lasts until this cycle */
    int disturbed_until;
    double value[EVENTS][LEGS];
    double length_m[LEGS], rate_mps[LEGS], spool[LEGS], load_n[LEGS];
    struct plant *plant;         /* the simulated platform, used in place of the cheap plant; NULL:
                                  * the cheap plant */
    double valve[LEGS];          /* spool positions */
    bool level;
    struct power_unit unit;
    struct hal_command command;  /* command that is in force in the device */
    struct hal_sample last;      /* last delivered sample */
    uint64_t device_seq;
    bool counts;                 /* the device numbers its samples */
    int64_t now_ns;              /* time of the last read */
    bool read_failed;
    int writes, safes;
    struct hal_command written;
};

static inline bool under_way(const struct world *w, enum kind kind, int leg) { return w->cycle < w->until[kind][leg]; }

static inline double noise(const struct world *w, int what) {
    return (double)(int64_t)mix(w->seed ^ (uint64_t)w->cycle << 8 ^ (uint64_t)what) * 0x1p-63;
}

/* Moves the simulated platform by a cycle. */
static inline void plant_move(struct world *w) {
    for (int i = 0; i < LEGS; i++)
        if (!under_way(w, EVENT_VALVE_STICKS, i)) w->valve[i] = w->command.enable ? w->command.valve[i] : 0.0;
    if (!under_way(w, EVENT_SUPPLY_LOST, 0)) w->level = w->command.supply;
    plant_life_sign(w->plant, w->level);
    plant_step(w->plant, w->valve);
}

/* Moves the plant by a cycle. A command remains in force until the next one; a device's watchdog
 * for missing commands is tested elsewhere (hal/). */
static inline void world_move(struct world *w) {
    if (w->plant) {
        plant_move(w);
        return;
    }
    double t = w->params->loop.period_s;
    bool level = under_way(w, EVENT_SUPPLY_LOST, 0) ? w->unit.level : w->command.supply;
    power_unit_step(&w->unit, level, t);
    bool powered = w->unit.share > 0.5 || !w->params->interlocks.supply;
    for (int i = 0; i < LEGS; i++) {
        double wanted = w->command.enable ? w->command.valve[i] : 0.0, before = w->rate_mps[i];
        if (!under_way(w, EVENT_VALVE_STICKS, i)) w->spool[i] += 0.6 * (wanted - w->spool[i]);
        double rate = powered ? 0.5 * w->spool[i] : -0.02;
        if (under_way(w, EVENT_PUSHED, i)) rate += 0.4 * (w->value[EVENT_PUSHED][i] - 0.5);
        w->length_m[i] += t * rate;
        if (w->length_m[i] < 1.431) w->length_m[i] = 1.431, rate = 0.0;
        if (w->length_m[i] > 2.231) w->length_m[i] = 2.231, rate = 0.0;
        w->rate_mps[i] = rate;
        w->load_n[i] += 0.3 * (350.0 + 10.0 * i + 30.0 * (rate - before) / t - w->load_n[i]);
    }
}

static inline void world_measure(const struct world *w, struct hal_sample *s) {
    for (int i = 0; i < LEGS && !w->plant; i++) {
        s->length_m[i] = w->length_m[i] + 1e-6 * noise(w, i);
        s->p2_pa[i] = 2e6 + 1e4 * noise(w, LEGS + i);
        s->p1_pa[i] = (w->load_n[i] + w->areas.a2_m2[i] * s->p2_pa[i]) / w->areas.a1_m2[i] + 1e3 * noise(w, 2 * LEGS + i);
    }
    s->inputs = w->unit.pressure ? INPUTS_ALL : INPUTS_ALL & ~(uint32_t)INPUT_SUPPLY;
    if (w->plant) plant_measure(w->plant, s);
    for (int i = 0; i < INPUTS; i++)
        if (under_way(w, EVENT_INPUT_OPENS, i) || under_way(w, EVENT_CONTRADICTION, i)) s->inputs &= ~(1u << i);
    for (int i = 0; i < INPUTS; i++)
        if (under_way(w, EVENT_CONTRADICTION, i)) s->contradicted |= 1u << i;
}

static inline void spoil_leg(struct world *w, struct hal_sample *s, int i) {
    const struct limit_params *l = &w->params->limits;
    if (under_way(w, EVENT_LENGTH_FROZEN, i)) s->length_m[i] = w->last.length_m[i];
    if (under_way(w, EVENT_LENGTH_JUMP, i)) s->length_m[i] += 0.05 * (w->value[EVENT_LENGTH_JUMP][i] - 0.5);
    if (under_way(w, EVENT_LENGTH_LOW, i)) s->length_m[i] = l->length_min_m[i] - w->value[EVENT_LENGTH_LOW][i];
    if (under_way(w, EVENT_LENGTH_HIGH, i)) s->length_m[i] = l->length_max_m[i] + w->value[EVENT_LENGTH_HIGH][i];
    if (under_way(w, EVENT_LENGTH_NAN, i)) s->length_m[i] = w->value[EVENT_LENGTH_NAN][i] < 0.5 ? (double)NAN : (double)INFINITY;
    if (under_way(w, EVENT_PRESSURE_HIGH, i)) s->p1_pa[i] = 2e7 * w->value[EVENT_PRESSURE_HIGH][i];
    if (under_way(w, EVENT_PRESSURE_LOW, i)) s->p2_pa[i] = l->pressure_min_pa * (0.5 + w->value[EVENT_PRESSURE_LOW][i]);
    if (under_way(w, EVENT_PRESSURE_NAN, i)) s->p1_pa[i] = (double)NAN;
}

static inline void spoil_sample(struct world *w, struct hal_sample *s) {
    struct hal_sample old = w->last;
    bool stale = under_way(w, EVENT_STALE, 0), hangs = under_way(w, EVENT_HANG, 0);
    if ((stale || hangs) && old.time_ns) {
        uint32_t inputs = s->inputs, contradicted = s->contradicted, flags = s->flags;
        int64_t now_ns = s->time_ns;
        *s = old;
        s->flags = flags | (stale ? SAMPLE_STALE : 0u), s->inputs = inputs, s->contradicted = contradicted;
        if (hangs) s->time_ns = now_ns, s->age_ns = 0;
        else s->age_ns = now_ns - s->time_ns;
    }
    if (under_way(w, EVENT_LATE, 0)) {
        int64_t by_ns = (int64_t)(w->value[EVENT_LATE][0] * 2.0 * w->params->limits.sensor_age_s * NS_PER_S);
        s->time_ns -= by_ns, s->age_ns += by_ns, s->flags |= SAMPLE_LATE;
    }
    if (under_way(w, EVENT_FUTURE, 0)) s->age_ns = -1;
    if (under_way(w, EVENT_INVALID, 0)) s->flags |= SAMPLE_INVALID;
    if (under_way(w, EVENT_GAP, 0)) s->flags |= SAMPLE_DROPPED;
}

/* Returns the flags that a back-end reports even if it cannot read. */
static inline uint32_t world_flags(const struct world *w) {
    return (under_way(w, EVENT_FOREIGN, 0) ? SAMPLE_FOREIGN : 0u) | (under_way(w, EVENT_TWIN, 0) ? SAMPLE_TWIN : 0u);
}

static inline int world_read(struct hal *hal, int64_t now_ns, struct hal_sample *s) {
    struct world *w = (struct world *)hal;
    w->now_ns = now_ns;
    s->flags |= world_flags(w);
    w->read_failed = under_way(w, EVENT_READ_FAILS, 0);
    if (w->read_failed) return -1;
    w->device_seq += under_way(w, EVENT_GAP, 0) ? 3 : 1;
    if (under_way(w, EVENT_DEVICE_RESTART, 0)) w->device_seq = 1;
    s->time_ns = now_ns;
    s->device_seq = w->counts ? w->device_seq : 0;
    world_measure(w, s);
    for (int i = 0; i < LEGS; i++) spoil_leg(w, s, i);
    spoil_sample(w, s);
    w->last = *s;
    return 0;
}

static inline int world_write(struct hal *hal, const struct hal_command *command) {
    struct world *w = (struct world *)hal;
    w->writes++;
    w->written = *command;
    if (under_way(w, EVENT_WRITE_FAILS, 0)) return -1;
    w->command = *command;
    return 0;
}

static inline void world_safe(struct hal *hal) {
    struct world *w = (struct world *)hal;
    w->safes++;
    memset(w->command.valve, 0, sizeof w->command.valve);
    w->command.enable = false;
}

static const struct hal_ops world_ops = {
    .scheme = "world", .simulated = true, .read = world_read, .write = world_write, .safe = world_safe};

/* plant: NULL, or the simulated platform at rest. */
static inline void world_init(struct world *w, struct plant *plant, const struct params *params, uint64_t seed, const struct event *events,
                              int count) {
    struct kinematics k;
    *w = (struct world){.hal = {&world_ops}, .params = params, .seed = seed, .events = events, .count = count, .plant = plant};
    w->areas = cylinder_areas(&params->actuator);
    w->counts = mix(seed) & 1;
    power_unit_init(&w->unit, params->device.watchdog_s);
    kinematics_place(&k, params);
    ik_lengths(&k, (double[DOFS]){[DOF_Z] = params->motion.park_z_m}, w->length_m);
    for (int i = 0; i < LEGS; i++) w->load_n[i] = 350.0 + 10.0 * i;
    if (plant && params->interlocks.supply) plant_add_power_unit(plant, params->device.watchdog_s);
}

#endif
