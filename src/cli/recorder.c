#include "recorder.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "config.h"
#include "crash.h"
#include "failure.h"
#include "gains.h"
#include "interlock.h"
#include "ident_messages.h"
#include "messages.h"
#include "model_law.h"
#include "monotonic.h"
#include "number_text.h"
#include "params.h"
#include "supervisor.h"
#include "thread.h"
#include "units.h"

enum { MESSAGE_MAX = 16384, CONFIG_MAX = 1 << 18, POLL_NS = 2000000, PART_PATIENCE_MS = 10000, CHECK_NS = 300000000 };

/* SAFETY: parks the platform after a failure of the log. A run that cannot be recorded is neither
 * aborted nor continued unrecorded. */
static void log_failed(struct recorder *r, const struct error *error) {
    if (r->error.status) return;
    r->error = *error;
    loop_quit(r->loop);
    if (r->analysis.cycles) progress_say(r->progress, "hexid: %s: parking\n", r->error.text);
}

static void keep(struct recorder *r, const char *channel, const void *data, int size) {
    const struct clock *clock = &r->loop->clock;
    /* a paced clock falls behind when the loop is late; its delay is added, because the log's time
     * is that of the wall clock */
    int64_t stretched_ns = clock->kind == CLOCK_PACED ? r->analysis.behind_ns : 0;
    int64_t utime_us = clock->system_us + (r->analysis.last.in.time_ns + stretched_ns) / NS_PER_US;
    struct error error;
    if (r->log && size >= 0 && log_write(r->log, utime_us, channel, data, size, &error)) log_failed(r, &error);
}

/* Checks that the log's file is intact and that nobody else writes it. */
static void look_after_log(struct recorder *r) {
    struct error error;
    int64_t now_ns = monotonic_ns();
    if (!r->log || r->error.status || now_ns - r->checked_ns < CHECK_NS) return;
    r->checked_ns = now_ns;
    if (log_check(r->log, &error)) log_failed(r, &error);
}

static void keep_and_send(struct recorder *r, const char *channel, const void *data, int size) {
    keep(r, channel, data, size);
    if (r->bus && size >= 0) bus_publish(r->bus, channel, data, size);
}

static void event(struct recorder *r, const char *kind, const char *text) {
    unsigned char buffer[MESSAGE_MAX];
    const struct cycle *c = &r->analysis.last;
    keep_and_send(r, CHANNEL_EVENT, buffer, event_encode(c->in.time_ns, c->seq, kind, text, buffer, sizeof buffer));
}

static void statistics(struct recorder *r) {
    unsigned char buffer[MESSAGE_MAX];
    if (r->log) r->analysis.unlogged = log_lost(r->log);
    struct loop_statistics s = analysis_statistics(&r->analysis);
    keep_and_send(r, CHANNEL_LOOP_STATS, buffer, loop_stats_encode(&s, r->analysis.last.in.time_ns, buffer, sizeof buffer));
}

/* Reports the state of the back-end's connection to the machine whenever it changes during a
 * fault. */
static void device(struct recorder *r) {
    const struct hal *hal = r->loop->hal;
    char text[sizeof r->device] = "";
    if (!hal->ops->describe || !r->analysis.last.first_fault) return;
    hal->ops->describe(hal, text, sizeof text);
    if (!strcmp(text, r->device)) return;
    memcpy(r->device, text, sizeof text);
    event(r, "device", *text ? text : "nothing is wrong on the way to the machine");
    progress_say(r->progress, "hexid: device: %s\n", *text ? text : "nothing is wrong on the way to the machine");
}

/* Adds the gains to the likely causes of a fault that unsuitable gains can trigger, if they were
 * changed or gains_check() proposes better ones. The other causes stay first, because gains_check()
 * does not know whether there is an obstacle. */
static void blame_gains(const struct recorder *r, char cause[FAILURE_TEXT_SIZE], char remedy[FAILURE_TEXT_SIZE]) {
    static const uint32_t of_loop = FAULT_FORCE | FAULT_OSCILLATION | FAULT_LEG_RATE | FAULT_FOLLOWING;
    bool changed = *r->gains_say;
    if ((!changed && !*r->loop_says) || !(r->analysis.last.first_fault & of_loop)) return;
    size_t used = strlen(cause);
    snprintf(cause + used, FAILURE_TEXT_SIZE - used, "; or the gains, %s", changed ? "which were changed" : "whose margins are missed");
    used = strlen(remedy);
    if (changed) snprintf(remedy + used, FAILURE_TEXT_SIZE - used, "; the gains: changed to %s: set them back", r->gains_say);
    else snprintf(remedy + used, FAILURE_TEXT_SIZE - used, "; the gains: %s", r->loop_says);
}

static void fault(struct recorder *r) {
    const struct analysis *a = &r->analysis;
    char line[FAULT_LINE_SIZE], cause[FAILURE_TEXT_SIZE], remedy[FAILURE_TEXT_SIZE];
    fault_line(a->last.first_fault, a->last.faults, &a->last.measure, line);
    failure_explain(a->last.first_fault, a->missed, seconds_from_ns(a->longest_ns), r->params->motion.automatic, cause, remedy);
    blame_gains(r, cause, remedy);
    event(r, "fault", line);
    event(r, "cause", cause);
    event(r, "remedy", remedy);
    progress_fault(r->progress, &a->last, cause, remedy);
    device(r);
}

/* Reports why `engage` would be refused, whenever that changes; a sample without known inputs
 * changes nothing. Remaining pressure counts only after a second, because it may take that long to
 * disappear after the supply is switched off. */
static void interlocks(struct recorder *r, const struct cycle *c) {
    r->settled_cycles = c->state == STATE_SETTLED ? r->settled_cycles + 1 : 0;
    if (!r->settled_cycles || c->in.flags & (SAMPLE_IO | SAMPLE_INVALID)) return;
    uint32_t wrong = interlock_wrong(&r->params->interlocks, false, c->in.inputs);
    if (r->settled_cycles < r->statistics_cycles) wrong &= ~(uint32_t)INPUT_LINGERS;
    if (wrong == r->interlocks_wrong) return;
    r->interlocks_wrong = wrong;
    event(r, "interlock", wrong ? interlock_why(wrong) : "all closed");
    if (wrong) progress_interlock(r->progress, interlock_why(wrong));
}

/* Reports that the PID drives in place of the configured law, and why, and later that this has
 * ended. */
static void law(struct recorder *r, const struct cycle *c, const struct cycle *before) {
    char text[160] = "the law model drives again";
    if (!c->law_doubts == !before->law_doubts || !supervisor_drives(c->state)) return;
    if (c->law_doubts) snprintf(text, sizeof text, "pid drives in place of the law model: %s", model_law_doubt(c->law_doubts));
    event(r, "control", text);
    progress_say(r->progress, "hexid: %s\n", text);
}

/* Reports that the loop parks because the thread that takes stops is held up, which that thread
 * cannot report itself. If the platform was up, the run ends with this error. */
static void unattended(struct recorder *r, const struct cycle *c, const struct cycle *before) {
    struct error why;
    bool up = supervisor_powers(before->state);
    if (!c->unattended || before->unattended) return;
    error_set(&why, STATUS_IO,
              "at %.1f s stops could not be taken for %g s, at a stretch or in pieces, because the thread that takes them was held up: see "
              "who uses this host, and what starves it",
              seconds_from_ns(c->in.time_ns), LOOP_ATTENDED_S);
    event(r, "unattended", why.text);
    progress_say(r->progress, "hexid: %s%s\n", why.text, up ? ": parking" : "");
    if (up && !r->unattended.status) r->unattended = why;
}

/* Reports the first wrong input that has ended an automatic run. */
static void opened(struct recorder *r, const struct cycle *c, const struct cycle *before) {
    char text[240];
    if (!c->opened || before->opened) return;
    snprintf(text, sizeof text, "the automatic run is over: %s", interlock_why(c->opened));
    event(r, "interlock", text);
    progress_say(r->progress, "hexid: %s\n", text);
}

/* Reports, as events and to the terminal, what has changed since the last cycle. */
static void changes(struct recorder *r, const struct cycle *before, int64_t lost) {
    const struct cycle *c = &r->analysis.last;
    char text[160];
    if (r->analysis.lost > lost) {
        snprintf(text, sizeof text, "%lld records lost: the recorder was too slow", (long long)(r->analysis.lost - lost));
        event(r, "lost", text);
    }
    if (c->request_id != before->request_id) event(r, "command", command_names[c->request]);
    if (before->test >= 0 && before->dof == DOF_NONE && c->test < 0) progress_motion(r->progress, &r->analysis.motion);
    if (r->analysis.cycles == 1 || c->state != before->state) {
        event(r, "state", state_names[c->state]);
        progress_state(r->progress, c);
    }
    opened(r, c, before);
    interlocks(r, c);
    law(r, c, before);
    unattended(r, c, before);
    if (c->first_fault && c->first_fault != before->first_fault) fault(r);
    if (c->test >= 0 && (c->test != before->test || before->phase == PHASE_NONE)) {
        snprintf(text, sizeof text, "%d %s", c->test + 1, tests_name(&r->params->tests, c->dof));
        event(r, "test", text);
    }
}

/* Reports a completed test, and after the last test the identification. */
static void result(struct recorder *r) {
    unsigned char buffer[MESSAGE_MAX];
    int64_t time_ns = r->analysis.last.in.time_ns;
    const struct identification *id = &r->analysis.ident.result;
    const struct test_result *t = &id->test[id->tests - 1];
    keep_and_send(r, CHANNEL_TEST_RESULT, buffer, test_result_encode(t, time_ns, buffer, sizeof buffer));
    progress_result(r->progress, t);
    if (t->test != r->params->tests.count - 1) return;
    struct verdict verdict = analysis_verdicts(&r->analysis).run;
    if (id->method_a.evaluated)
        keep_and_send(r, CHANNEL_IDENTIFICATION, buffer, identification_encode(id, &verdict, time_ns, buffer, sizeof buffer));
}

/* Publishes method C's result for the tests so far, if they determine one. */
static void publish_estimate(struct recorder *r, bool wait) {
    struct {
        struct equations rest, sum;
        struct estimate estimate;
        struct method_c result;
        struct error error;
    } *w;
    unsigned char buffer[MESSAGE_MAX];
    if (!wait && !estimator_ready(&r->estimator)) return;
    if (!(w = malloc(sizeof *w))) return;
    parts_take(&r->analysis.parts, wait);
    if (estimator_take(&r->estimator, wait, &w->rest, &w->error)) {
        parts_sum(&r->analysis.parts, r->params, &w->sum, NULL, &(struct error){0});
        if (!w->error.status) equations_add(&w->sum, &w->rest);
        if (!method_c_solve(&w->sum, r->params, &w->estimate, &w->result, &w->error))
            keep_and_send(r, CHANNEL_METHOD_C, buffer,
                          method_c_encode(&w->result, r->estimate_tests, r->estimate_ns, buffer, sizeof buffer));
        r->estimate_tests = 0;
    }
    free(w);
}

/* Starts method C after each test while recording continues. If several tests end before it is
 * finished, it starts again only once. wait: this call waits for the result, which in virtual time
 * makes repeated runs give the same log. */
static void estimate(struct recorder *r, bool wait) {
    struct recording copy;
    struct error none;
    if (r->estimate_tests) publish_estimate(r, wait);
    if (!r->estimate_due || r->estimate_tests) return;
    r->estimate_due = false;
    r->estimate_ns = r->analysis.last.in.time_ns;
    if (analysis_copy(&r->analysis, &copy, &none) || !copy.tests) {
        recording_free(&copy);
        return;
    }
    r->estimate_tests = copy.tests;
    estimator_give(&r->estimator, &copy);
    if (wait) publish_estimate(r, true);
}

static void tell_manager(struct recorder *r, const struct cycle *before) {
    const struct cycle *c = &r->analysis.last;
    struct notify *n = &r->notify;
    char line[64];
    notify_alive(n);
    if (!n->ready && c->state == STATE_SETTLED) {
        n->ready = true;
        notify_send(n, "READY=1");
    }
    if (!n->stopping && atomic_load_explicit(&r->loop->quit, memory_order_relaxed)) {
        n->stopping = true;
        notify_send(n, "STOPPING=1");
    }
    if (c->state == before->state && r->analysis.cycles > 1) return;
    snprintf(line, sizeof line, "STATUS=%s", state_names[c->state]);
    notify_send(n, line);
}

/* Writes the effective configuration into the log, as the first event of each file and after a
 * change of the gains, so that a log is self-contained. If that is impossible, the log has
 * failed. */
static void keep_configuration(struct recorder *r) {
    if (!r->log) return;
    struct error error;
    unsigned char *buffer = malloc(CONFIG_MAX);
    int size = buffer ? event_encode(0, 0, "config", r->config, buffer, CONFIG_MAX) : -1;
    if (size >= 0) keep(r, CHANNEL_EVENT, buffer, size);
    else {
        error_set(&error, STATUS_IO,
                  buffer ? "the log cannot keep the configuration: %zu bytes, at most %d with the event's head; shorten it"
                         : "out of memory: the log cannot keep the configuration, %zu of at most %d bytes",
                  strlen(r->config), CONFIG_MAX);
        log_failed(r, &error);
    }
    free(buffer);
}

/* Writes each gain that differs as "control.kp=45, was 40". */
static void list_gains(const struct gains *before, const struct gains *now, char *text, size_t size) {
    char was[NUMBER_SIZE], is[NUMBER_SIZE];
    *text = '\0';
    for (int i = 0; i < LOOP_GAINS; i++) {
        size_t used = strlen(text);
        if (before->value[i] == now->value[i]) continue;
        snprintf(text + used, size - used, "%s%s=%s, was %s", used ? "; " : "", gain_keys[i], number_shortest(now->value[i], is),
                 number_shortest(before->value[i], was));
    }
}

/* Reports which gains were changed, and writes the new configuration into the log. Readers of the
 * log then see two runs, each with its own gains. If memory runs out, the log would state wrong
 * gains from here on, so this counts as a failure of the log. */
static void gains_changed(struct recorder *r, const struct gains *before, const struct gains *now) {
    struct params *params = malloc(sizeof *params);
    struct error error;
    char text[sizeof r->gains_say];
    const struct gains configured = gains_of(&r->params->control);
    list_gains(before, now, text, sizeof text);
    list_gains(&configured, now, r->gains_say, sizeof r->gains_say);
    event(r, "gains", text);
    progress_say(r->progress, "hexid: gains: %s\n", text);
    if (params) *params = *r->params, gains_apply(now, &params->control);
    char *config = params ? config_text(params) : NULL;
    free(params);
    if (!config) {
        error_set(&error, STATUS_IO, "out of memory: the log cannot keep the new gains");
        log_failed(r, &error);
        return;
    }
    free(r->changed);
    r->config = r->changed = config;
    keep_configuration(r);
}

static void say_over_quota(struct recorder *r, bool over) {
    static const char text[] = "the logs of runs in progress alone take more than --log-quota: nothing of them is deleted; move parts away "
                               "that are done";
    if (over && !r->over_quota) {
        event(r, "log", text);
        progress_say(r->progress, "hexid: warning: %s\n", text);
    }
    r->over_quota = over;
}

/* Reports that the keeper makes no more parts and deletes no old logs. The log continues in the
 * current part, and the run ends with an error. */
static void keeper_failed(struct recorder *r, const char *why) {
    static const char format[] = "%.200s: the log goes on in %.300s, and nothing keeps --log-quota; look at that directory's disk";
    if (r->keeper_error.status) return;
    error_set(&r->keeper_error, STATUS_IO, format, why, *r->part_path ? r->part_path : "its first part");
    event(r, "log", r->keeper_error.text);
    progress_say(r->progress, "hexid: warning: %s\n", r->keeper_error.text);
}

static void ask_keeper(struct recorder *r) {
    if (!r->keeper->asked) r->asked_ns = monotonic_ns();
    log_keeper_ask(r->keeper);
}

/* Takes the keeper's next part with log_keeper_take(). A run in virtual time waits for the keeper,
 * so that repeated runs give the same log, unless the keeper has failed. */
static int take_part(struct recorder *r, struct log_part *next, struct error *error) {
    bool waits = r->loop->clock.kind == CLOCK_VIRTUAL && !r->keeper_error.status;
    int got = log_keeper_take(r->keeper, waits ? PART_PATIENCE_MS : 0, next, error);
    if (r->keeper->gone) keeper_failed(r, error->text);
    else if (!got && monotonic_ns() - r->asked_ns >= PART_PATIENCE_MS * NS_PER_S / 1000)
        keeper_failed(r, "the process that makes the parts of the log does not answer");
    return got;
}

/* Continues the log in a new part, beginning with this cycle, if the current part is large enough,
 * no test is split, and the new file is ready (a run in virtual time waits for it). A test that
 * goes on until the part has twice its size, such as a trajectory of hours, is split. If no new
 * part can be made, the log continues in the current part. */
static void rotate(struct recorder *r, const struct cycle *c) {
    struct error error;
    struct log_part next;
    const struct cycle *before = &r->analysis.last;
    bool cuts = c->test >= 0 && c->test == before->test && c->dof == before->dof;
    if (!r->keeper || r->error.status || log_bytes(r->log) < r->part_due_bytes) return;
    ask_keeper(r);
    if (cuts && log_bytes(r->log) < r->part_due_bytes + r->part_bytes) return;
    int got = take_part(r, &next, &error);
    if (!got || r->keeper->gone) return;
    if (got > 0 && !log_continue(r->log, next.file, next.path, &error)) {
        snprintf(r->part_path, sizeof r->part_path, "%s", next.path);
        r->part_due_bytes = r->part_bytes;
        keep_configuration(r);
        char text[32];
        snprintf(text, sizeof text, "%d", ++r->part);
        event(r, "part", text);
        say_over_quota(r, next.over);
    } else {
        r->part_due_bytes = log_bytes(r->log) + r->part_bytes;
        event(r, "log", error.text);
        progress_say(r->progress, "hexid: warning: no new part of the log: %s\n", error.text);
    }
}

/* Processes one cycle. No new part of the log begins in a cycle that changes the gains, because it
 * would repeat the configuration that gains_changed() writes. */
static void take(struct recorder *r, const struct cycle *c) {
    unsigned char buffer[STATE_MESSAGE_MAX];
    struct cycle before = r->analysis.last;
    int64_t lost = r->analysis.lost;
    atomic_store_explicit(&r->computes, true, memory_order_relaxed);
    if (r->analysis.cycles && !gains_equal(&c->gains, &before.gains)) gains_changed(r, &before.gains, &c->gains);
    else rotate(r, c);
    bool completed = analysis_take(&r->analysis, c);
    atomic_store_explicit(&r->computes, false, memory_order_relaxed);
    int size = state_encode(c, buffer);
    keep(r, CHANNEL_STATE, buffer, size);
    if (r->bus && c->seq % (uint64_t)r->params->lcm.state_every == 0) bus_publish(r->bus, CHANNEL_STATE, buffer, size);
    changes(r, &before, lost);
    tell_manager(r, &before);
    if (completed) result(r);
    if (r->bus && (completed || (before.test >= 0 && before.dof == DOF_NONE && c->test < 0))) r->estimate_due = true;
    if (r->estimate_due || r->estimate_tests) {
        bool wait = r->loop->clock.kind == CLOCK_VIRTUAL;
        atomic_store_explicit(&r->computes, wait, memory_order_relaxed);
        estimate(r, wait);
        atomic_store_explicit(&r->computes, false, memory_order_relaxed);
    }
    if (r->analysis.cycles % r->statistics_cycles == 0) statistics(r), device(r);
    progress_tick(r->progress, c);
}

static void *recorder_thread(void *argument) {
    struct recorder *r = argument;
    struct cycle c;
    crash_stack();
    for (;;) {
        /* `ended` is read before the ring, so that no record remains in the ring at the end */
        bool ended = atomic_load_explicit(&r->loop->ended, memory_order_acquire);
        look_after_log(r);
        if (ring_pop(r->records, &c)) take(r, &c);
        else if (ended) break;
        else nanosleep(&(struct timespec){.tv_nsec = POLL_NS}, NULL);
    }
    if (analysis_end(&r->analysis)) result(r), r->estimate_due = r->bus != NULL;
    atomic_store_explicit(&r->computes, true, memory_order_relaxed);
    estimate(r, true); /* waits for the estimate in progress */
    estimate(r, true); /* makes the estimate that became due meanwhile */
    estimator_stop(&r->estimator);
    atomic_store_explicit(&r->computes, false, memory_order_relaxed);
    statistics(r);
    return NULL;
}

uint64_t recorder_ring_cycles(const struct params *p) {
    uint64_t cycles = 1;
    while ((double)cycles * p->loop.period_s < RECORDER_RING_S) cycles *= 2;
    return cycles;
}

int recorder_start(struct recorder *r, const char *config, struct error *error) {
    int status = analysis_init(&r->analysis, r->params, error);
    if (!status && r->bus) status = estimator_start(&r->estimator, error);
    if (status) return status;
    r->statistics_cycles = ns_from_seconds(1.0) / ns_from_seconds(r->params->loop.period_s);
    r->config = config;
    r->part = 1, r->part_due_bytes = r->part_bytes;
    if (r->log) log_count(r->log, CHANNEL_STATE);
    keep_configuration(r);
    if (r->error.status) {
        estimator_stop(&r->estimator);
        *error = r->error;
        return error->status;
    }
    status = thread_start(&r->thread, "recorder", THREAD_STACK_IDENTIFY, recorder_thread, r, error);
    if (status) estimator_stop(&r->estimator);
    return status;
}

bool recorder_join(struct recorder *r) {
    bool computed = false;
    for (uint64_t before = ring_count(r->records) + 1, now; (now = ring_count(r->records)) < before || computed; before = now) {
        computed = atomic_load_explicit(&r->computes, memory_order_relaxed);
        if (thread_join_within(r->thread, RECORDER_PATIENCE_S)) return true;
    }
    return false;
}
