#include "loop.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#include "confine.h"
#include "crash.h"
#include "gains.h"
#include "params.h"
#include "thread.h"
#include "units.h"

enum { TRIES = 1000 };

/* Returns true if the loop must end: at once after `abort`; otherwise when the supply is off, and
 * the loop was told to end or an automatic run is over. */
static bool finished(const struct loop *l) {
    if (atomic_load_explicit(&l->abort, memory_order_relaxed)) return true;
    bool over = l->params->motion.automatic && !l->platform.automatic;
    return (over || atomic_load_explicit(&l->quit, memory_order_relaxed)) && !supervisor_powers(l->platform.supervisor.state);
}

/* Handles missed deadlines. Returns the number of cycles that the machine was without a new
 * command; 0 on a paced clock, because time is stretched instead. */
static int64_t overrun(struct loop *l, int64_t late_ns) {
    int64_t period_ns = ns_from_seconds(l->params->loop.period_s), missed = late_ns / period_ns;
    if (l->clock.kind == CLOCK_PACED) {
        clock_stretch(&l->clock, missed * period_ns);
        return 0;
    }
    l->deadline_ns += missed * period_ns;
    l->overruns += missed;
    return missed;
}

/* SAFETY: once told to end, the loop ignores other requests and parks the platform; likewise while
 * the thread that takes stops is held up. */
static struct request asked(const struct loop *l) {
    struct request request = mailbox_read(&l->requests);
    /* gains that change at this moment belong to a later request, so this request gets NaN, which
     * is refused */
    if (request.command == COMMAND_SET && !gains_box_get(&l->gains, &request.gains)) request.gains = (struct gains){.value = {(double)NAN}};
    bool parks = atomic_load_explicit(&l->quit, memory_order_acquire) || atomic_load_explicit(&l->unattended, memory_order_relaxed);
    if (parks) request.command = COMMAND_PARK;
    return request;
}

void loop_quit(struct loop *l) {
    atomic_store_explicit(&l->quit, true, memory_order_release);
    mailbox_post(&l->requests, COMMAND_PARK);
}

void loop_attend(struct loop *l, bool works) {
    uint64_t next = (atomic_load_explicit(&l->attended, memory_order_relaxed) | 1) + 1;
    atomic_store_explicit(&l->attended, next | works, memory_order_relaxed);
}

/* SAFETY: parks if the thread that takes stops is held up, at a stretch or again and again. This
 * counts cycles, not time, because a host that stands still holds up both threads; that shows as an
 * overrun. */
static void watch_attendance(struct loop *l) {
    uint64_t attended = atomic_load_explicit(&l->attended, memory_order_relaxed);
    double period_s = l->params->loop.period_s;
    if (!attended || l->clock.kind == CLOCK_VIRTUAL) return;
    l->silent_cycles = attended == l->attended_before ? l->silent_cycles + 1 : 0;
    l->attended_before = attended;
    bool works = attended & 1, held_up = (double)l->silent_cycles * period_s >= (works ? LOOP_WORK_S : LOOP_ROUND_S);
    bool full = (double)l->held_up_cycles * period_s >= LOOP_ATTENDED_S;
    if (held_up && !full) l->held_up_cycles++;
    if (held_up && full && !atomic_exchange_explicit(&l->unattended, true, memory_order_relaxed)) mailbox_post(&l->requests, COMMAND_PARK);
    if (!held_up && !works) l->held_up_cycles = l->held_up_cycles > LOOP_RECOVERY ? l->held_up_cycles - LOOP_RECOVERY : 0;
    if (!l->held_up_cycles) atomic_store_explicit(&l->unattended, false, memory_order_relaxed);
}

static void hand_over(struct loop *l, const struct cycle *c) {
    while (!ring_push(l->records, c)) {
        if (l->clock.kind == CLOCK_REAL || atomic_load_explicit(&l->abort, memory_order_relaxed)) {
            atomic_fetch_add_explicit(&l->lost, 1, memory_order_relaxed);
            return;
        }
        clock_yield();
    }
}

uint64_t loop_acted_word(const struct loop_acted *a) {
    return (uint64_t)a->request_id << 32 | (uint64_t)a->wrong << 16 | (uint64_t)ffs((int)a->first_fault) << 10 | (uint64_t)a->state << 2 |
           (uint64_t)a->stopped << 1 | a->taken;
}

static void tell_gains(struct loop *l) {
    struct gains gains = gains_of(&l->platform.control), told;
    if (!gains_box_get(&l->present, &told) || !gains_equal(&gains, &told)) gains_box_put(&l->present, &gains);
}

struct gains loop_gains(const struct loop *l) {
    struct gains gains;
    /* SAFETY: the number of tries is limited, because the calling thread also takes stops; the loop
     * writes in a few instructions. If the result is a mixture of two writes all the same, a change
     * of gains based on it is refused. */
    for (int i = 0; i < TRIES && !gains_box_get(&l->present, &gains); i++) continue;
    return gains;
}

static void tell_acted(struct loop *l) {
    const struct platform *p = &l->platform;
    tell_gains(l); /* first, so that a thread that sees a request as processed in `acted` also sees
                    * its gains */
    struct loop_acted acted = {.request_id = p->supervisor.request_id,
                               .taken = p->request_taken,
                               .stopped = p->stopping,
                               .state = p->supervisor.state,
                               .wrong = platform_wrong(p),
                               .first_fault = p->supervisor.first_fault};
    atomic_store_explicit(&l->acted, loop_acted_word(&acted), memory_order_release);
}

struct loop_acted loop_acted(const struct loop *l) {
    uint64_t word = atomic_load_explicit(&l->acted, memory_order_acquire), fault = word >> 10 & 0x3f;
    return (struct loop_acted){.request_id = (uint32_t)(word >> 32),
                               .taken = word & 1,
                               .stopped = word >> 1 & 1,
                               .state = (enum state)(word >> 2 & 0xff),
                               .first_fault = fault ? 1u << (fault - 1) : 0,
                               .wrong = (uint32_t)(word >> 16) & (INPUTS_ALL | INPUT_LINGERS)};
}

bool loop_cycle(struct loop *l) {
    struct hal_sample sample = {0};
    struct cycle c;

    int64_t late_ns, now_ns = clock_wait(&l->clock, l->deadline_ns, &late_ns);
    int64_t missed = overrun(l, late_ns);
    if (l->hal->ops->read(l->hal, now_ns, &sample)) sample.flags |= SAMPLE_IO, sample.time_ns = now_ns, sample.age_ns = 0;
    else if (l->unwritten) sample.flags |= SAMPLE_IO | SAMPLE_UNWRITTEN;
    if (missed) sample.flags |= SAMPLE_OVERRUN;
    sample.missed = missed;

    watch_attendance(l);
    struct request request = asked(l);
    platform_step(&l->platform, &sample, request, &c);
    c.request_id = l->platform.supervisor.request_id;
    c.request = request.command;

    /* SAFETY: without the supply, or after a failed write, the valves are centred in every cycle
     * by the back-end's fastest way. */
    bool powered = supervisor_powers(c.state);
    l->unwritten = powered && l->hal->ops->write(l->hal, &c.out) != 0;
    if (!powered || l->unwritten) l->hal->ops->safe(l->hal);
    c.unattended = atomic_load_explicit(&l->unattended, memory_order_relaxed);
    c.wake_late_ns = late_ns;
    c.exec_ns = clock_since_wake(&l->clock);
    tell_acted(l);
    hand_over(l, &c);
    l->deadline_ns += ns_from_seconds(l->params->loop.period_s);
    return !finished(l);
}

static void *loop_thread(void *argument) {
    struct loop *l = argument;
    crash_stack();
    l->realtime = realtime_enter(&l->params->loop, l->mode, &l->realtime_error);
    bool refused = l->realtime && l->mode == REALTIME_REQUIRE;
    if (l->params->security.confine) confine_thread();
    clock_start(&l->clock, l->clock.kind);
    sem_post(&l->started);
    if (!refused)
        while (loop_cycle(l)) continue;
    l->hal->ops->safe(l->hal); /* SAFETY: however the loop ends, the valves are centred */
    atomic_store_explicit(&l->ended, true, memory_order_release);
    return NULL;
}

int loop_init(struct loop *l, const struct params *params, struct hal *hal, struct ring *records, enum clock_kind clock,
              struct error *error) {
    memset(l, 0, sizeof *l);
    l->params = params;
    l->hal = hal;
    l->records = records;
    clock_start(&l->clock, clock);
    sem_init(&l->started, 0, 0);
    int status = platform_init(&l->platform, params, error);
    tell_gains(l);
    return status;
}

int loop_start(struct loop *l, enum realtime_mode mode, struct error *error) {
    l->mode = mode;
    int status = thread_start(&l->thread, "loop", THREAD_STACK_REALTIME, loop_thread, l, error);
    if (status) atomic_store_explicit(&l->ended, true, memory_order_release);
    if (status) return status;
    while (sem_wait(&l->started)) continue;
    if (!l->realtime || mode != REALTIME_REQUIRE) return STATUS_OK;
    loop_join(l);
    *error = l->realtime_error;
    return error->status;
}

void loop_join(struct loop *l) { pthread_join(l->thread, NULL); }
