#include "live_state.h"

#include <math.h>
#include <string.h>

#include "ident.h"
#include "messages.h"
#include "nominal.h"
#include "params.h"
#include "printable.h"
#include "units.h"

enum { DIGITS = 6, REORDERED_MS = 100, REORDERED_CYCLES = 100, EVENT_TEXT = 600 };

/* least time between kept cycles, a little below 20 ms, so that at most about 50 cycles a second
 * are kept, whatever the rate of the messages */
static const uint64_t APART_NS = 19 * NS_PER_S / 1000;

const char *const live_place_names[LIVE_PLACES] = {
    [LIVE_FAULT] = "fault",
    [LIVE_LOOP_STATS] = "loop_stats",
    [LIVE_METHOD_C] = "method_c",
    [LIVE_IDENTIFICATION] = "identification",
    [LIVE_GAP] = "gap",
    "test_result",
    "test_result",
    "test_result",
    "test_result",
    "test_result",
    "test_result",
};

/* ---- the machine, as configured ---- */

static void numbers(struct json_text *j, const char *name, const double *value, int count) {
    json_text_name(j, name);
    json_text_rounded_array(j, value, count, DIGITS);
}

static void number(struct json_text *j, const char *name, double value) {
    json_text_name(j, name);
    json_text_rounded(j, value, DIGITS);
}

static void words(struct json_text *j, const char *name, const char *const *word, int count) {
    json_text_name(j, name);
    for (int i = 0; i < count; i++) {
        json_text_add(j, i ? "," : "[", 1);
        json_text_string(j, word[i]);
    }
    json_text_add(j, "]", 1);
}

static void machine_tests(struct json_text *j, const struct params *p) {
    const struct test_params *t = &p->tests;
    const char *name[DOFS] = {0};
    int count = tests_count(t);
    for (int i = 0; i < count; i++) name[i] = tests_name(t, tests_single(t) ? t->order[i] : DOF_NONE);
    words(j, "tests", name, count);
    /* The duration of a trajectory is not in the configuration, so test_s is then null. */
    bool timed = tests_single(t) || t->multisine;
    number(j, "settle_s", t->settle_s);
    number(j, "test_s", timed ? t->ramp_s + t->duration_s + t->ramp_out_s : (double)NAN);
}

static void machine_matrix(struct json_text *j, const struct live_state *s) {
    double mt[DOFS][DOFS];
    nominal_matrix(s->params, &s->kinematics, (const double[DOFS]){0}, mt);
    numbers(j, "nominal_mt_si", &mt[0][0], DOFS * DOFS);
    json_text_name(j, "entries");
    for (int i = 0; i < IDENT_ENTRIES; i++)
        json_text_say(j, "%s{\"name\":\"%s\",\"row\":%d,\"column\":%d,\"unit\":\"%s\"}", i ? "," : "[", ident_entries[i].name,
                      ident_entries[i].row, ident_entries[i].col, ident_entries[i].unit);
    json_text_add(j, "]", 1);
}

static void machine_platform(struct json_text *j, const struct live_state *s) {
    const struct kinematics *k = &s->kinematics;
    numbers(j, "upper_m", &k->upper[0][0], LEGS * 3);
    numbers(j, "lower_m", &k->lower[0][0], LEGS * 3);
    machine_tests(j, s->params);
    machine_matrix(j, s);
}

static void machine(struct live_state *s) {
    const struct params *p = s->params;
    const struct mechanism *mechanism = params_mechanism(p);
    struct json_text *j = &s->machine;
    json_text_say(j, "{\"mechanism\":\"%s\",\"legs\":%d", mechanism->name, mechanism->legs);
    json_text_name(j, "lcm_url");
    json_text_string(j, p->lcm.url);
    words(j, "states", state_names, STATES);
    words(j, "dofs", dof_names, DOFS);
    number(j, "force_limit_n", p->limits.force_n);
    number(j, "middle_m", mechanism->pose ? (double)NAN : p->axis.middle_m);
    number(j, "stroke_m", p->actuator.stroke_m[0]);
    if (mechanism->pose) machine_platform(j, s);
    json_text_add(j, "}", 1);
}

int live_state_init(struct live_state *s, const struct params *params, struct error *error) {
    *s = (struct live_state){.params = params};
    int status = params_mechanism(params)->pose ? kinematics_init(&s->kinematics, params, error) : STATUS_OK;
    if (status) return status;
    machine(s);
    return s->machine.failed ? error_set(error, STATUS_IO, "out of memory") : STATUS_OK;
}

void live_state_free(struct live_state *s) {
    json_text_free(&s->machine);
    for (int i = 0; i < LIVE_CYCLES; i++) json_text_free(&s->cycle[i]);
    for (int i = 0; i < LIVE_EVENTS; i++) json_text_free(&s->event[i]);
    for (int i = 0; i < LIVE_PLACES; i++) json_text_free(&s->place[i]);
}

/* ---- messages received ---- */

/* Empties a place for new contents. */
static struct json_text *renew(struct live_state *s, int place) {
    s->version[place]++;
    json_text_restart(&s->place[place]);
    return &s->place[place];
}

static void write_fault(struct live_state *s) {
    const struct live_fault *f = &s->fault;
    struct json_text *j = renew(s, LIVE_FAULT);
    const char *const text[][2] = {{"name", f->name}, {"measured", f->measured}, {"cause", f->cause}, {"remedy", f->remedy}};
    if (!f->there) return;
    json_text_say(j, "{\"legs\":%u", (unsigned)f->legs);
    for (size_t i = 0; i < sizeof text / sizeof *text; i++) {
        json_text_name(j, text[i][0]);
        json_text_string(j, text[i][1]);
    }
    json_text_add(j, "}", 1);
}

/* Takes the fault from a cycle. A fault is known from two sources: its events, which carry the
 * run's own text, and the state of each cycle while the fault is latched. Either may be missing,
 * because a message was lost, the viewer joined late, or the run ended with the fault before it
 * sent a cycle that has it. */
static void fault_of_cycle(struct live_state *s, const struct cycle *c) {
    struct live_fault *f = &s->fault;
    const struct failure *row = failure_of(c->first_fault);
    uint32_t legs = (c->faults & FAULT_LEGS) >> FAULT_LEG_SHIFT;
    if (row ? f->there && f->legs == legs : !f->there || c->seq <= f->seq) return;
    if (row && !f->there) {
        *f->measured = '\0'; /* cycles do not carry the measured value */
        snprintf(f->cause, sizeof f->cause, "%s; most likely %s", row->what, row->cause);
        snprintf(f->remedy, sizeof f->remedy, "%s; then `hexid command reset`, `engage`, or start the run again", row->remedy);
    }
    if (row) fault_describe(c->first_fault, c->faults, f->name);
    f->there = row != NULL;
    f->legs = legs;
    f->seq = c->seq;
    write_fault(s);
}

/* Returns the legs named in "standstill, legs 2 3: 2.1 mm", the format of fault_line(); one bit
 * each. */
static uint32_t legs_of(const char *name) {
    uint32_t legs = 0;
    const char *list = strstr(name, ", leg");
    for (; list && *list && *list != ':'; list++)
        if (*list >= '1' && *list < '1' + LEGS) legs |= 1u << (*list - '1');
    return legs;
}

static void fault_of_event(struct live_state *s, const struct event *e) {
    struct live_fault *f = &s->fault;
    char text[FAILURE_TEXT_SIZE];
    text_printable(e->text, text, sizeof text);
    if (!strcmp(e->kind, "fault")) {
        if (!f->there) *f = (struct live_fault){.there = true};
        f->seq = e->seq;
        f->legs = legs_of(text);
        size_t name = strcspn(text, ":"), rest = name + strspn(text + name, ": ");
        snprintf(f->name, sizeof f->name, "%.*s", (int)name, text);
        snprintf(f->measured, sizeof f->measured, "%.*s", (int)sizeof f->measured - 1, text + rest);
    } else if (f->there && !strcmp(e->kind, "cause")) memcpy(f->cause, text, sizeof text);
    else if (f->there && !strcmp(e->kind, "remedy")) memcpy(f->remedy, text, sizeof text);
    else return;
    write_fault(s);
}

static void keep_cycle(struct live_state *s, const struct cycle *c) {
    struct json_text *j = &s->cycle[++s->cycles % LIVE_CYCLES];
    const struct mechanism *mechanism = params_mechanism(s->params);
    int legs = mechanism->legs;
    s->kept_ns = c->in.time_ns;
    json_text_restart(j);
    json_text_say(j, "{\"seq\":%llu,\"state\":%d,\"test\":%d,\"dof\":%d,\"phase\":%d,\"flags\":%u", (unsigned long long)c->seq,
                  (int)c->state, c->test, (int)c->dof, (int)c->phase, (unsigned)c->in.flags);
    json_text_name(j, "time_s");
    json_text_rounded(j, seconds_from_ns(c->in.time_ns), 12);
    number(j, "test_time_s", c->test_time_s);
    numbers(j, "ref_m_rad", c->ref, mechanism->axes);
    numbers(j, "pose_m_rad", mechanism->pose ? c->pose : c->in.length_m, mechanism->axes);
    numbers(j, "length_m", c->in.length_m, legs);
    numbers(j, "p1_pa", c->in.p1_pa, legs);
    numbers(j, "p2_pa", c->in.p2_pa, legs);
    numbers(j, "force_n", c->force_n, legs);
    numbers(j, "valve", c->out.valve, legs);
    json_text_add(j, "}", 1);
}

/* Begins a new run: resets its counters and empties all places except LIVE_GAP, which belongs to no
 * run. Cycles and events of the previous run stay. */
static void begin_run(struct live_state *s) {
    s->run++;
    s->messages = s->lost = s->step = 0;
    s->fault.there = false;
    for (int i = 0; i < LIVE_PLACES; i++)
        if (i != LIVE_GAP && s->place[i].size) renew(s, i);
}

static void count(struct live_state *s, const struct cycle *c) {
    int64_t passed = (int64_t)(c->seq - s->newest.seq);
    s->messages++;
    if (s->messages == 1 || passed <= 0) return;
    if (!s->step || passed < s->step) s->step = passed;
    s->lost += passed / s->step - 1;
}

static void take_cycle(struct live_state *s, const struct cycle *c, int64_t now_ms) {
    bool back = s->heard && c->seq < s->newest.seq;
    /* An older number that arrives soon after the newest cycle is a reordered datagram, not a new
     * run. */
    if (back && s->newest.seq - c->seq < REORDERED_CYCLES && now_ms - s->heard_ms < REORDERED_MS) return;
    if (back || !s->heard) begin_run(s);
    fault_of_cycle(s, c);
    count(s, c);
    s->heard = true;
    s->heard_ms = now_ms;
    s->newest = *c;
    /* Times come from the network and may have any value, so the difference is unsigned, which
     * cannot overflow. */
    uint64_t apart_ns = (uint64_t)c->in.time_ns - (uint64_t)s->kept_ns;
    if (s->messages == 1 || c->in.time_ns < s->kept_ns || apart_ns >= APART_NS) keep_cycle(s, c);
}

/* Takes an event, except the configuration in a replayed log, which the page does not use. */
static void take_event(struct live_state *s, const struct event *e) {
    struct json_text *j = &s->event[(s->events + 1) % LIVE_EVENTS];
    char kind[40], text[EVENT_TEXT];
    if (!strcmp(e->kind, "config")) return;
    fault_of_event(s, e);
    text_printable(e->kind, kind, sizeof kind);
    text_printable(e->text, text, sizeof text);
    s->events++;
    json_text_restart(j);
    json_text_say(j, "{\"number\":%llu,\"run\":%lld,\"seq\":%lld", (unsigned long long)s->events, (long long)s->run, (long long)e->seq);
    json_text_name(j, "time_s");
    json_text_rounded(j, seconds_from_ns(e->time_ns), 12);
    json_text_name(j, "kind");
    json_text_string(j, kind);
    json_text_name(j, "text");
    json_text_string(j, text);
    json_text_add(j, "}", 1);
}

/* Returns the place that shows a message, or -1 if no place does. A message of an older type of its
 * channel goes to the place of the newer type. */
static int place_of(const struct message *m) {
    for (int i = LIVE_LOOP_STATS; i < LIVE_TEST; i++)
        if (!strncmp(m->type->name, live_place_names[i], strlen(live_place_names[i]))) return i;
    for (int f = 0; m->type->field[f].name; f++) {
        if (strcmp(m->type->field[f].name, "test")) continue;
        int64_t test = message_integer(m, f, 0);
        return test >= 0 && test < DOFS ? LIVE_TEST + (int)test : -1;
    }
    return -1;
}

void live_state_take(struct live_state *s, const struct bus_message *b, int64_t now_ms) {
    struct cycle c;
    struct event e;
    struct message m;
    if (!strcmp(b->channel, CHANNEL_STATE)) {
        if (state_decode(b->data, b->size, &c)) take_cycle(s, &c, now_ms);
        else s->dropped++;
    } else if (!strcmp(b->channel, CHANNEL_EVENT)) {
        if (event_decode(b->data, b->size, &e)) take_event(s, &e);
        else s->dropped++;
    } else if (message_known(b->channel)) {
        bool fits = b->size <= LIVE_MESSAGE_MAX && message_read(b->channel, b->data, b->size, &m);
        int place = fits ? place_of(&m) : -1;
        if (place >= 0) json_text_message(renew(s, place), &m);
        else s->dropped++;
    }
}

/* Returns the largest difference between the lengths implied by the pose and the measured ones, m.
 * Returns 0 for a single axis, before the first cycle, and for a cycle with flags or faults, whose
 * pose may not match its lengths. */
static double misfit(const struct live_state *s) {
    double length_m[LEGS], most = 0.0;
    if (!s->heard || !params_mechanism(s->params)->pose || s->newest.in.flags || s->newest.faults) return 0.0;
    ik_lengths(&s->kinematics, s->newest.pose, length_m);
    for (int i = 0; i < LEGS; i++) most = fmax(most, fabs(length_m[i] - s->newest.in.length_m[i]));
    return most;
}

void live_state_health(const struct live_state *s, int64_t now_ms, struct json_text *j) {
    json_text_say(j, "{\"run\":%lld,\"messages\":%lld,\"lost\":%lld,\"dropped\":%lld,\"silence_s\":", (long long)s->run,
                  (long long)s->messages, (long long)s->lost, (long long)s->dropped);
    json_text_rounded(j, s->heard ? (double)(now_ms - s->heard_ms) * 1e-3 : (double)NAN, DIGITS);
    number(j, "misfit_m", misfit(s));
    json_text_add(j, "}", 1);
}
