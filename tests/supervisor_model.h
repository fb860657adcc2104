/* The supervisor's contract (docs/safety.md, supervisor.h, platform.h, loop.h) as a table of what
 * must never happen, judged only by the loop's inputs and outputs. It is written from the documents
 * and shares no code with src/core but the inverse kinematics. Where the documents leave room (a
 * length near its limit), the controller may doubt the sample but need not. */
#ifndef HEXID_TESTS_SUPERVISOR_MODEL_H
#define HEXID_TESTS_SUPERVISOR_MODEL_H

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "support.h"

#include "kinematics.h"

/* One cycle as seen from outside. */
struct seen {
    struct hal_sample in;        /* the sample as delivered */
    bool read_failed, unwritten; /* the read failed; the previous command was not written */
    bool spoilt;                 /* a length differs from the plant's */
    bool disturbed;              /* samples or machine were disturbed in the last 0.6 s, so an
                                  * oscillation is allowed */
    bool write_failed;
    int64_t late_ns;             /* delay of the wake-up after the deadline */
    bool real;                   /* deadlines count because the clock is real */
    enum command command;        /* new request, COMMAND_NONE: none */
    int writes, safes;           /* calls of the back-end in this cycle */
    struct hal_command written;  /* last command that the back-end was given */
    struct cycle out;            /* the loop's own record of the cycle */
    bool lost;                   /* the cycle's record was lost, so test and phase are unknown */
};

struct model {
    const struct params *params;
    struct kinematics kinematics;
    struct cycle before;         /* record of the previous cycle */
    int64_t cycles;              /* cycles since the loop began */
    /* about samples */
    int64_t anew;                /* last cycle whose sample the device's counter marked as new */
    uint64_t device_seq;
    bool repeated;               /* the device's counter did not rise */
    int64_t missed;              /* deadlines missed in a row */
    int64_t time_ns;             /* time of the previous readings */
    double length_m[LEGS];       /* previous readings */
    bool good_before;            /* nothing was doubtful about the previous readings */
    double good_m[LEGS];         /* last readings without a doubt */
    int64_t good_cycle;          /* cycle of those readings, -1: none yet */
    int64_t unsure_until;        /* up to this cycle a length that jumped may have been believed, so
                                  * that its jump back is allowed too */
    double leg_ref_m[LEGS];      /* reference of the last cycle */
    double low_m[LEGS], high_m[LEGS]; /* range of the reference since the leg's reading last
                                       * changed */
    int sure_stop, sure_park, maybe_bad; /* bounds of the leaky buckets' levels */
    int good_run;                /* consecutive cycles without a certain doubt */
    uint32_t inputs;
    int contradicted[INPUTS];    /* consecutive cycles */
    /* about requests */
    bool automatic;
    int64_t in_state, stopped_for, down_for; /* cycles in this state; since a stop in testing, and
                                              * since a park, -1: none */
    bool retracted;              /* `stop` came after the last start: no test may continue by
                                  * itself */
    /* rate of the reference, from its last two cycles while the platform is driven without
     * interruption */
    double ref_rate[DOFS];
    bool ref_known, rate_known;
    bool reset;                  /* a fault was reset in this cycle */
    long edges[STATES][STATES];  /* count of each change of state */
    int rule;                    /* line in this file of the broken rule */
    char text[240];              /* the broken rule in words */
};

enum { GOOD_RUN = 50, INIT_BAD = 1000, INIT_LONGEST = 2000, UNSURE = 50 };

static const uint32_t MODEL_PARKS = FAULT_PRESSURE_SENSOR;
static const uint32_t MODEL_AT_ONCE = FAULT_MASTER | FAULT_EMERGENCY_STOP | FAULT_ENABLE | FAULT_DOOR | FAULT_ANTIVALENCE;

static inline void model_init(struct model *m, const struct params *params) {
    long edges[STATES][STATES];
    memcpy(edges, m->edges, sizeof edges);
    *m = (struct model){.params = params, .automatic = params->motion.automatic, .good_cycle = -1, .stopped_for = -1, .down_for = -1};
    memcpy(m->edges, edges, sizeof edges);
    kinematics_place(&m->kinematics, params);
}

static inline bool model_drives(enum state s) {
    return s == STATE_ENGAGING || s == STATE_READY || s == STATE_TESTING || s == STATE_PARKING;
}
static inline bool model_powers(enum state s) { return model_drives(s) || s == STATE_PRESSURISING; }

__attribute__((format(printf, 2, 3))) static inline bool broken(struct model *m, const char *format, ...) {
    va_list list;
    va_start(list, format);
    vsnprintf(m->text, sizeof m->text, format, list);
    va_end(list);
    return false;
}

#define never(condition, ...)                                  \
    do {                                                       \
        if (condition) return m->rule = __LINE__, broken(m, __VA_ARGS__); \
    } while (0)

/* ---- doubts about a sample ---- */

struct doubt {
    uint32_t sure, maybe; /* FAULT_... that the controller must and may detect; `maybe` includes
                           * `sure` */
};

static inline void must(struct doubt *d, uint32_t fault, bool when) {
    if (when) d->sure |= fault, d->maybe |= fault;
}
static inline void may(struct doubt *d, uint32_t fault, bool when) {
    if (when) d->maybe |= fault;
}
static inline bool out_of(double x, double low, double high) { return !(x >= low && x <= high); }

static inline uint32_t model_wired(const struct interlock_params *p) {
    return (p->emergency_stop ? INPUT_EMERGENCY_STOP : 0u) | (p->enable ? INPUT_ENABLE : 0u) | (p->door ? INPUT_DOOR : 0u);
}

static inline void doubt_inputs(const struct model *m, const struct seen *s, struct doubt *d) {
    uint32_t open = model_wired(&m->params->interlocks) & ~m->inputs;
    bool old = s->read_failed, ends = s->command == COMMAND_STOP || s->command == COMMAND_PARK;
    if (!model_powers(m->before.state)) return;
    must(d, FAULT_EMERGENCY_STOP, open & INPUT_EMERGENCY_STOP && !old);
    must(d, FAULT_ENABLE, open & INPUT_ENABLE && !old);
    must(d, FAULT_DOOR, open & INPUT_DOOR && !old);
    bool pressure = !m->params->interlocks.pressure || m->inputs & INPUT_SUPPLY;
    double waited_s = (double)(m->in_state + 1) * m->params->loop.period_s - m->params->interlocks.pressure_s;
    must(d, FAULT_SUPPLY, !pressure && ((model_drives(m->before.state) && !old) || (!ends && waited_s > 1.5 * m->params->loop.period_s)));
    may(d, FAULT_SUPPLY, !pressure && waited_s > -1.5 * m->params->loop.period_s);
}

/* Doubts an input whose two contacts contradict each other for longer than allowed. */
static inline void doubt_contacts(struct model *m, const struct seen *s, struct doubt *d) {
    const struct interlock_params *p = &m->params->interlocks;
    uint32_t wired = model_wired(p) | (p->pressure ? INPUT_SUPPLY : 0u);
    for (int i = 0; i < INPUTS; i++) {
        bool says = wired & s->in.contradicted & 1u << i;
        if (!s->read_failed) m->contradicted[i] = says ? m->contradicted[i] + 1 : 0;
        double for_s = m->contradicted[i] * m->params->loop.period_s;
        must(d, FAULT_ANTIVALENCE, for_s > p->discrepancy_s + 1e-9);
        may(d, FAULT_ANTIVALENCE, m->contradicted[i] && for_s > p->discrepancy_s - 1e-9);
    }
}

static inline void doubt_leg(struct model *m, const struct seen *s, int i, struct doubt *d) {
    const struct limit_params *l = &m->params->limits;
    const struct actuator_params *a = &m->params->actuator;
    double length_m = s->in.length_m[i], p1 = s->in.p1_pa[i], p2 = s->in.p2_pa[i];
    double bore = a->piston_diameter_m[i], rod = a->rod_diameter_m[i];
    double force_n = 0.25 * PI * (bore * bore * p1 - (bore * bore - rod * rod) * p2);
    double step_m = fabs(length_m - m->length_m[i]), most_m = l->leg_rate_mps * m->params->loop.period_s;
    must(d, FAULT_SENSOR_INVALID, !isfinite(length_m));
    must(d, FAULT_PRESSURE_SENSOR,
         out_of(p1, l->pressure_min_pa, l->pressure_max_pa) || out_of(p2, l->pressure_min_pa, l->pressure_max_pa));
    must(d, FAULT_STROKE, out_of(length_m, l->length_min_m[i], l->length_max_m[i]));
    must(d, FAULT_FORCE, fabs(force_n) > l->force_n * (1 + 1e-9));
    may(d, FAULT_FORCE, fabs(force_n) > l->force_n * (1 - 1e-9));
    bool next = s->in.time_ns - m->time_ns <= ns_from_seconds(1.01 * m->params->loop.period_s);
    must(d, FAULT_LEG_RATE, m->good_before && next && !(step_m <= most_m * 1.001));
    if (m->cycles && !(step_m <= most_m * 0.999)) m->unsure_until = m->cycles + UNSURE;
    double since_m = fabs(length_m - m->good_m[i]), long_m = most_m * (double)(m->cycles - m->good_cycle);
    may(d, FAULT_LEG_RATE, m->good_cycle >= 0 && (!(since_m <= long_m * 0.999) || m->cycles < m->unsure_until));
    if (!model_powers(m->before.state)) return;
    double off_m = fabs(m->leg_ref_m[i] - length_m), range_m = m->high_m[i] - m->low_m[i];
    must(d, FAULT_FOLLOWING, !(off_m <= l->following_m + 1e-9));
    may(d, FAULT_FOLLOWING, !(off_m <= l->following_m - 1e-9));
    if (!model_drives(m->before.state)) return;
    must(d, FAULT_STANDSTILL, range_m > l->standstill_m + 1e-9);
    may(d, FAULT_STANDSTILL, range_m > l->standstill_m - 1e-9);
}

/* Tracks the range of the leg's reference while its reading stands still. */
static inline void follow_standstill(struct model *m, const struct seen *s) {
    for (int i = 0; i < LEGS && !s->read_failed && !s->unwritten; i++) {
        bool moved = s->in.length_m[i] != m->length_m[i];
        m->low_m[i] = moved ? m->leg_ref_m[i] : fmin(m->low_m[i], m->leg_ref_m[i]);
        m->high_m[i] = moved ? m->leg_ref_m[i] : fmax(m->high_m[i], m->leg_ref_m[i]);
    }
}

static inline struct doubt model_doubt(struct model *m, const struct seen *s) {
    struct doubt d = {0};
    int64_t period_ns = ns_from_seconds(m->params->loop.period_s), limit_ns = ns_from_seconds(m->params->limits.sensor_age_s);
    int64_t late = s->real ? s->late_ns / period_ns : 0;
    m->missed = late ? m->missed + late : 0;
    must(&d, FAULT_OVERRUN, m->missed >= m->params->loop.overrun_limit);
    must(&d, FAULT_MASTER, s->in.flags & SAMPLE_FOREIGN);
    if (!s->read_failed) m->inputs = s->in.inputs;
    doubt_inputs(m, s, &d);
    doubt_contacts(m, s, &d);
    must(&d, FAULT_TWIN, s->in.flags & SAMPLE_TWIN);
    must(&d, FAULT_IO, s->read_failed || s->unwritten);
    follow_standstill(m, s);
    m->repeated = false;
    if (s->read_failed || s->unwritten) return d;
    bool anew = s->in.device_seq == 0 || (int64_t)(s->in.device_seq - m->device_seq) > 0;
    if (anew) m->anew = m->cycles;
    m->repeated = !anew;
    m->device_seq = s->in.device_seq;
    must(&d, FAULT_SENSOR_AGE, s->in.age_ns < 0 || s->in.age_ns > limit_ns || (m->cycles - m->anew) * period_ns > limit_ns);
    must(&d, FAULT_SENSOR_INVALID, s->in.flags & SAMPLE_INVALID);
    for (int i = 0; i < LEGS; i++) doubt_leg(m, s, i, &d);
    may(&d, FAULT_KINEMATICS, s->spoilt);
    return d;
}

/* ---- allowed changes of state ---- */

struct cause {
    bool good, closed;                              /* the sample is good; the interlocks are
                                                     * closed, before engage */
    bool engage, start, stop, park, reset;          /* requested */
    bool automatic, parks, faults;                  /* starts unasked; has faults that park; has any
                                                     * fault */
    bool pressure, believed, neutral, parked;
    bool ended;                                     /* the last test, or a stopped one, has ended */
};

static inline bool at(const double ref[DOFS], double z_m, double tolerance) {
    for (int i = 0; i < DOFS; i++)
        if (!(fabs(ref[i] - (i == DOF_Z ? z_m : 0.0)) <= tolerance)) return false;
    return true;
}

static inline struct cause model_cause(const struct model *m, const struct seen *s, struct doubt d) {
    const struct interlock_params *p = &m->params->interlocks;
    double held_s = (double)(m->in_state + 1) * m->params->loop.period_s;
    bool lingers = p->pressure && p->supply && s->in.inputs & INPUT_SUPPLY && !model_powers(m->before.state);
    bool there = p->pressure ? s->in.inputs & INPUT_SUPPLY : !p->supply || held_s >= p->pressure_s;
    return (struct cause){
        .good = !d.sure,
        .closed = !(model_wired(p) & ~s->in.inputs) && !lingers,
        .engage = s->command == COMMAND_ENGAGE,
        .start = s->command == COMMAND_START,
        .stop = s->command == COMMAND_STOP,
        .park = s->command == COMMAND_PARK,
        .reset = s->command == COMMAND_RESET,
        .automatic = m->automatic && s->command != COMMAND_STOP && s->command != COMMAND_PARK,
        .parks = s->out.faults & MODEL_PARKS,
        .faults = s->out.faults != 0,
        .pressure = there && !d.sure,
        .believed = !d.sure && m->good_run + 1 >= GOOD_RUN,
        .ended = m->before.test == tests_count(&m->params->tests) - 1 || m->stopped_for >= 0 || s->command == COMMAND_STOP,
        .neutral = at(s->out.ref, 0.0, 1e-9),
        .parked = at(m->before.ref, m->params->motion.park_z_m, m->params->limits.leg_rate_mps * m->params->loop.period_s),
    };
}

static inline bool edge(enum state from, enum state to, const struct cause *c) {
    if (to == STATE_FAULT) return c->faults;
    switch (from) {
    case STATE_INIT: return to == STATE_SETTLED && c->believed;
    case STATE_SETTLED: return to == STATE_PRESSURISING && c->good && c->closed && (c->engage || c->automatic);
    case STATE_PRESSURISING: return (to == STATE_ENGAGING && c->pressure) || (to == STATE_SETTLED && (c->stop || c->park));
    case STATE_ENGAGING: return (to == STATE_READY && c->neutral) || (to == STATE_PARKING && (c->stop || c->park || c->parks));
    case STATE_READY:
        return (to == STATE_TESTING && c->good && (c->start || c->automatic)) ||
               (to == STATE_PARKING && (c->park || c->automatic || c->parks));
    case STATE_TESTING: return (to == STATE_READY && c->neutral && c->ended) || (to == STATE_PARKING && (c->park || c->parks));
    case STATE_PARKING: return to == STATE_SETTLED && c->parked && !c->faults;
    case STATE_FAULT: return to == STATE_INIT && c->reset;
    default: return false;
    }
}

/* True if the state can get from one to the other in a cycle, into which several changes may
 * fall. */
static inline bool model_reaches(enum state from, enum state to, const struct cause *c) {
    bool reached[STATES] = {false};
    reached[from] = true;
    for (int round = 0; round < STATES; round++)
        for (int a = 0; a < STATES; a++)
            for (int b = 0; reached[a] && b < STATES; b++) reached[b] = reached[b] || edge((enum state)a, (enum state)b, c);
    return reached[to];
}

/* ---- what must never happen ---- */

static inline bool never_in_outputs(struct model *m, const struct seen *s) {
    const struct cycle *c = &s->out;
    bool drives = model_drives(c->state), powers = model_powers(c->state);
    never((unsigned)c->state >= STATES, "state %d does not exist", (int)c->state);
    never(c->seq != (uint64_t)m->cycles, "sequence number %d in cycle %d", (int)c->seq, (int)m->cycles);
    never(c->out.enable != drives, "valves are %s in %s", c->out.enable ? "driven" : "not driven", state_names[c->state]);
    never((c->out.supply != m->before.out.supply) != powers, "the supply output %s in %s", powers ? "stands still" : "toggles",
          state_names[c->state]);
    for (int i = 0; i < LEGS; i++) {
        never(out_of(c->out.valve[i], -m->params->control.output_limit, m->params->control.output_limit), "leg %d: command %g", i + 1,
              c->out.valve[i]);
        never(!drives && c->out.valve[i] != 0.0, "leg %d: command %g in %s", i + 1, c->out.valve[i], state_names[c->state]);
        never(!isfinite(c->ref[i]) || !isfinite(c->pose[i]) || !isfinite(c->force_n[i]), "reference, pose or force of %d is no number",
              i + 1);
    }
    never(powers && s->writes != 1, "%d commands were written in %s", s->writes, state_names[c->state]);
    never(!powers && s->writes, "a command was written in %s", state_names[c->state]);
    never(!powers && !s->safes, "the valves were not centred by `safe` in %s", state_names[c->state]);
    never(s->write_failed && !s->safes, "a command could not be written, and the valves were not centred");
    never(powers && memcmp(s->written.valve, c->out.valve, sizeof c->out.valve), "another command was written than is recorded");
    never(powers && (s->written.enable != drives || s->written.supply != c->out.supply),
          "enable or supply is written that is not recorded");
    return true;
}

static inline bool one_bit(uint32_t bits) { return bits && !(bits & (bits - 1)); }

static inline bool never_in_faults(struct model *m, const struct seen *s, struct doubt d) {
    const struct cycle *c = &s->out;
    uint32_t before = m->reset ? 0 : m->before.faults, faults = c->faults & FAULT_ANY, fresh = faults & ~before;
    uint32_t headline = m->before.first_fault;
    never(before & ~c->faults, "a fault was unlatched without a reset: %x", (unsigned)(before & ~c->faults));
    never(faults && !one_bit(c->first_fault), "faults %x have the headline %x", (unsigned)faults, (unsigned)c->first_fault);
    never(c->first_fault & ~faults, "the headline %x is none of the faults", (unsigned)c->first_fault);
    never(c->faults && !faults, "legs %x without a fault", (unsigned)c->faults);
    never(before && headline != c->first_fault && !(headline & MODEL_PARKS), "the headline became another: %x, then %x", (unsigned)headline,
          (unsigned)c->first_fault);
    never(faults & ~MODEL_PARKS && c->first_fault & MODEL_PARKS, "what stopped the platform, %x, is not the headline", (unsigned)faults);
    bool slowly = model_drives(m->before.state) && m->before.state != STATE_PARKING;
    never(slowly && faults && !(faults & ~MODEL_PARKS) && c->state != STATE_PARKING, "faults %x stopped at once", (unsigned)faults);
    never(c->state == STATE_FAULT && !faults, "the state is fault without one");
    never(faults && c->state != STATE_FAULT && c->state != STATE_PARKING, "faults %x in %s", (unsigned)faults, state_names[c->state]);
    never(c->state == STATE_PARKING && faults & ~MODEL_PARKS, "faults %x while parking", (unsigned)faults);
    if (s->disturbed && model_drives(m->before.state)) d.maybe |= FAULT_OSCILLATION;
    never(!m->reset && fresh & ~d.maybe & ~(uint32_t)FAULT_LEGS, "faults %x without a cause (causes %x)", (unsigned)fresh,
          (unsigned)d.maybe);
    return true;
}

/* Fills a leaky bucket. A bucket that counts only certain doubts is the lower bound of the
 * controller's, one that counts possible doubts the upper bound. */
static inline void fill(int *bucket, bool bad) { *bucket = bad ? *bucket + 1 : *bucket > 0 ? *bucket - 1 : 0; }

static inline bool never_blind(struct model *m, const struct seen *s, struct doubt d) {
    const struct cycle *c = &s->out;
    bool waits = c->state == STATE_INIT || m->before.state == STATE_INIT;
    /* the controller has emptied its buckets */
    bool anew = m->reset || (c->state == STATE_SETTLED && m->before.state != STATE_SETTLED);
    int limit = waits ? INIT_BAD : m->params->limits.bad_cycles, least = limit;
    /* the cycle of a reset may or may not count as a cycle in init */
    if (waits && m->in_state >= INIT_LONGEST) limit = 1;
    if (waits && m->in_state >= INIT_LONGEST - 1) least = 1;
    fill(&m->sure_stop, d.sure & ~MODEL_PARKS & ~(uint32_t)FAULT_OVERRUN);
    fill(&m->sure_park, d.sure & MODEL_PARKS);
    fill(&m->maybe_bad, d.maybe != 0);
    uint32_t now = d.sure & (MODEL_AT_ONCE | (waits ? 0u : (uint32_t)FAULT_OVERRUN));
    never(!m->reset && now && (c->state != STATE_FAULT || now & ~c->faults), "%x is no fault in its first cycle, in %s", (unsigned)now,
          state_names[c->state]);
    never(!anew && m->sure_stop >= limit && c->state != STATE_FAULT, "%d bad samples, the last with %x, in %s", m->sure_stop,
          (unsigned)d.sure, state_names[c->state]);
    never(!anew && m->sure_park >= limit && c->state != STATE_FAULT && c->state != STATE_PARKING, "%d samples without pressures, in %s",
          m->sure_park, state_names[c->state]);
    uint32_t patient = c->faults & ~m->before.faults & FAULT_ANY & ~(MODEL_AT_ONCE | (uint32_t)FAULT_OVERRUN);
    /* an oscillation becomes a fault after many cycles, and their samples need not be bad */
    if (c->faults & ~m->before.faults & FAULT_OSCILLATION) patient = 0;
    never(!anew && patient && !(d.maybe & (MODEL_AT_ONCE | FAULT_OVERRUN)) && m->maybe_bad < least, "fault %x after %d bad samples of %d",
          (unsigned)patient, m->maybe_bad, least);
    never(m->repeated && !c->in.flags, "a sample that the device's count calls old was not flagged");
    uint32_t stops = d.sure & ~MODEL_PARKS, latched = c->faults & ~m->before.faults & FAULT_ANY & ~MODEL_PARKS;
    never(!anew && latched && stops & ~c->faults, "%x was latched, %x beside it was not", (unsigned)latched,
          (unsigned)(stops & ~c->faults));
    never(d.sure && !c->in.flags, "a sample with %x was not flagged", (unsigned)d.sure);
    bool held = d.sure & ~MODEL_PARKS && model_drives(c->state) && model_drives(m->before.state);
    never(held && memcmp(c->out.valve, m->before.out.valve, sizeof c->out.valve), "a sample with %x moved the valves", (unsigned)d.sure);
    if (anew) m->sure_stop = m->sure_park = 0, m->maybe_bad = d.maybe != 0;
    return true;
}

/* Returns the longest time to park: from the fastest upward move to rest and back down. */
static inline double model_longest_move_s(const struct model *m) {
    const struct motion_params *p = &m->params->motion;
    double brake_s = 0.25 + 3.0 / sqrt(2.0) * p->rate_mps / p->accel_mps2, far_m = 0.5 + brake_s * p->rate_mps;
    return fmax(p->park_s, brake_s + fmax(15.0 / 8.0 * far_m / p->rate_mps, sqrt(6.0 * far_m / p->accel_mps2)));
}

/* Checks that every state obeys a stop or a park, and comes to its end in time. */
static inline bool never_without_end(struct model *m, const struct seen *s) {
    const struct cycle *c = &s->out;
    bool stop = s->command == COMMAND_STOP, park = s->command == COMMAND_PARK, rests = !model_powers(c->state);
    int ramp = (int)(m->params->tests.ramp_out_s / m->params->loop.period_s + 0.5);
    int move = (int)(model_longest_move_s(m) / m->params->loop.period_s + 0.5);
    bool turns = rests || c->state == STATE_PARKING;
    never((stop || park) && m->before.state == STATE_PRESSURISING && !rests, "a stop was not taken while pressurising");
    never((stop || park) && m->before.state == STATE_ENGAGING && !turns, "a stop was not taken while engaging");
    never(park && model_drives(m->before.state) && !turns, "a park was not taken in %s", state_names[m->before.state]);
    bool ramps = turns || c->state == STATE_READY || c->phase == PHASE_RAMP_OUT;
    never(stop && m->before.state == STATE_TESTING && !ramps, "a stop was not taken in testing");
    bool down = m->before.state == STATE_TESTING && c->state == STATE_PARKING;
    never(down && c->phase != PHASE_RAMP_OUT && !at(c->ref, 0.0, 1e-9), "a park did not ramp out the test");
    if (stop && m->before.state == STATE_TESTING && m->stopped_for < 0) m->stopped_for = 0;
    if (model_drives(m->before.state) && c->state == STATE_PARKING && m->down_for < 0) m->down_for = 0;
    if (m->stopped_for >= 0 && c->state == STATE_TESTING)
        never(m->stopped_for++ > ramp + 1, "a test goes on %d cycles after a stop", ramp + 1);
    if (c->state != STATE_TESTING) m->stopped_for = -1;
    if (m->down_for >= 0) never(m->down_for++ > ramp + move + 3, "still parking %d cycles later", ramp + move + 3);
    if (c->state != STATE_PARKING) m->down_for = -1;
    return true;
}

/* Computes bounds of the reference's rate and acceleration. A test is an envelope e (two if it is
 * stopped while it ramps in) times a sinusoid, with |e'| <= 1.5 / ramp and |e''| <= 6 / ramp^2. A
 * move keeps its limits, or begins with the motion that the test had. */
static inline void model_motion_limits(const struct model *m, bool test, double rate[DOFS], double acceleration[DOFS]) {
    const struct test_params *t = &m->params->tests;
    const struct motion_params *p = &m->params->motion;
    double ramp = 1.0 / fmin(t->ramp_s, t->ramp_out_s), once = 1.5 * ramp, twice = 6.0 * ramp * ramp;
    if (m->stopped_for >= 0 || m->down_for >= 0) twice = 2.0 * twice + 2.0 * once * once, once *= 2.0;
    for (int i = 0; i < DOFS; i++) {
        double w = 2.0 * PI * t->hz[i], a = t->amplitude[i], arm = i < DOF_PHI ? 1.0 : m->kinematics.arm_m;
        rate[i] = a * (w + once);
        acceleration[i] = a * (w * w + 2.0 * w * once + twice);
        if (test) continue;
        rate[i] = fmax(rate[i] * 1.5, p->rate_mps / arm);
        acceleration[i] = fmax(acceleration[i], p->accel_mps2 / arm);
    }
}

static inline bool never_in_reference(struct model *m, const struct seen *s) {
    const struct cycle *c = &s->out;
    double t = m->params->loop.period_s, rate[DOFS], acceleration[DOFS], leg_m[LEGS];
    bool drives = model_drives(c->state), drove = model_drives(m->before.state);
    model_motion_limits(m, c->state == STATE_TESTING && m->before.state == STATE_TESTING, rate, acceleration);
    ik_lengths(&m->kinematics, c->ref, leg_m);
    for (int i = 0; i < LEGS && drives; i++) {
        double from_m = drove ? m->leg_ref_m[i] : m->length_m[i], step_m = fabs(leg_m[i] - from_m);
        never(m->good_before && !(step_m <= m->params->limits.leg_rate_mps * t), "reference of leg %d steps by %g m in %s", i + 1, step_m,
              state_names[c->state]);
    }
    for (int i = 0; i < LEGS && drives && !drove; i++)
        never(!(fabs(c->out.valve[i]) <= 0.02), "leg %d: a blow of %g where driving begins", i + 1, c->out.valve[i]);
    for (int i = 0; i < DOFS && drives; i++) {
        double now = drove ? (c->ref[i] - m->before.ref[i]) / t : (c->ref[i] - c->pose[i]) / t, before = drove ? m->ref_rate[i] : 0.0;
        never(!(fabs(now) <= rate[i] * 1.001), "%s: reference at %g /s, limit %g", dof_names[i], now, rate[i]);
        never(!(fabs(now - before) / t <= acceleration[i] * 1.01), "%s: reference at %g /s^2, limit %g", dof_names[i],
              fabs(now - before) / t, acceleration[i]);
        m->ref_rate[i] = now;
    }
    never(!drives && distance(c->ref, c->pose, DOFS) != 0.0, "the reference is not the pose in %s", state_names[c->state]);
    /* while the supply builds up, the references are the lengths with which that state began */
    if (c->state != STATE_PRESSURISING) memcpy(m->leg_ref_m, leg_m, sizeof leg_m);
    else if (m->before.state != STATE_PRESSURISING) memcpy(m->leg_ref_m, s->in.length_m, sizeof m->leg_ref_m);
    return true;
}

static inline bool never_out_of_turn(struct model *m, const struct seen *s, struct doubt d) {
    const struct cycle *c = &s->out;
    struct cause cause = model_cause(m, s, d);
    never(!model_reaches(m->before.state, c->state, &cause), "%s followed %s (command %s%s)", state_names[c->state],
          state_names[m->before.state], (unsigned)s->command < COMMANDS ? command_names[s->command] : "?",
          cause.automatic ? ", automatic" : "");
    bool asked = s->command == COMMAND_ENGAGE && !d.maybe && cause.closed && m->before.state == STATE_SETTLED;
    never(m->reset && c->state == STATE_FAULT && !d.maybe, "a reset was not taken");
    never(asked && !model_powers(c->state) && !c->faults, "an engage was not taken");
    never(!s->lost && c->test >= 0 && c->state != STATE_TESTING && c->state != STATE_PARKING && m->before.state != STATE_TESTING &&
              m->before.state != STATE_PARKING,
          "test %d in %s", c->test, state_names[c->state]);
    return true;
}

/* Keeps the values by which the next cycle is judged. */
static inline void model_keep(struct model *m, const struct seen *s, struct doubt d) {
    const struct cycle *c = &s->out;
    bool open = model_wired(&m->params->interlocks) & ~s->in.inputs || s->read_failed;
    bool down = c->state == STATE_SETTLED && m->before.state != STATE_SETTLED && m->before.state != STATE_INIT;
    if (s->command == COMMAND_STOP || s->command == COMMAND_PARK || c->state == STATE_FAULT || down) m->automatic = false;
    if (m->before.state == STATE_SETTLED && open && !s->read_failed) m->automatic = false;
    bool read = !s->read_failed && !s->unwritten;
    /* faults that do not make the lengths doubtful */
    uint32_t beside = MODEL_PARKS | FAULT_KINEMATICS | (m->before.state == STATE_PRESSURISING ? FAULT_SUPPLY : 0u);
    bool shakes = c->faults & ~m->before.faults & FAULT_OSCILLATION;
    m->good_before = read && !shakes && !(d.maybe & ~beside);
    if (m->good_before) memcpy(m->good_m, s->in.length_m, sizeof m->good_m), m->good_cycle = m->cycles;
    if (read) memcpy(m->length_m, s->in.length_m, sizeof m->length_m), m->time_ns = s->in.time_ns;
    if (!model_drives(m->before.state) && model_drives(c->state))
        for (int i = 0; i < LEGS; i++)
            m->low_m[i] = fmin(m->leg_ref_m[i], m->length_m[i]), m->high_m[i] = fmax(m->leg_ref_m[i], m->length_m[i]);
    m->good_run = d.sure ? 0 : m->reset ? 1 : m->good_run + 1;
    m->in_state = c->state == m->before.state ? m->in_state + 1 : 0;
    m->edges[m->before.state][c->state]++;
    m->before = *c;
    m->cycles++;
}

/* Returns false if a rule was broken; m->text names it. */
static inline bool model_step(struct model *m, const struct seen *s) {
    struct doubt d = model_doubt(m, s);
    m->reset = s->command == COMMAND_RESET && m->before.state == STATE_FAULT;
    if (!never_in_outputs(m, s) || !never_in_faults(m, s, d) || !never_blind(m, s, d) || !never_out_of_turn(m, s, d) ||
        !never_without_end(m, s) || !never_in_reference(m, s))
        return false;
    model_keep(m, s, d);
    return true;
}

#endif
