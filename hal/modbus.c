/* modbus: one device with all six legs, over TCP or a serial line (modbus_map.h: the registers,
 * modbus_link.h: the line).
 *
 * The back-end's own thread communicates: one function-23 transaction a cycle, triggered by the
 * loop's write() or safe(). The loop never waits for this thread. Cycle k reads the values that
 * were latched in cycle k-1, by the transaction that put the command of cycle k-1 into force. The
 * device does not report when it latched them; over TCP the middle of the round trip is taken, on a
 * serial line the end of the request.
 *
 * SAFETY: only the newest command is ever sent. A command that has waited for the line longer than
 * limits.sensor_age_s, or is from before a reconnection, is dropped; if nothing is sent, the
 * device's own watchdog centres the valves. The thread reconnects by itself; the supervisor and the
 * operator decide whether the platform may move again.
 *
 * SAFETY: one master (modbus_server.h). A connection first claims the device, and is refused if
 * another master has it. The device counts writes by others; a change of that count, or a refusal
 * because of another master, sets SAMPLE_FOREIGN. */
#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>

#include "backends.h"
#include "confine.h"
#include "crash.h"
#include "latest.h"
#include "modbus_link.h"
#include "modbus_map.h"
#include "monotonic.h"
#include "params.h"
#include "thread.h"
#include "units.h"

enum {
    BACKOFF_FIRST_MS = 50,
    BACKOFF_LAST_MS = 1000,
    TWIN_ANSWERS = 2, /* number of unrequested answers during bring-up that proves a second
                       * device */
};

struct command_record {
    int64_t posted_ns;
    double valve[LEGS];
    unsigned changes;     /* number of changes of the supply output that the loop has requested so
                           * far */
    bool keeps_supply;    /* SAFETY: the supply output keeps its level, even if changes are
                           * pending */
};

struct latched {
    int64_t time_ns;      /* time of latching, CLOCK_MONOTONIC */
    struct modbus_reading reading;
};

struct modbus_hal {
    struct hal hal;
    struct hal_ops ops;      /* calls of hal_modbus; `reopens` depends on the address */
    const struct params *params;
    struct modbus_address_parts address;
    /* the group below is shared by the loop and the Modbus thread */
    struct latest newest_command, newest_sample;
    struct command_record record[LATEST_SLOTS];
    struct latched sample[LATEST_SLOTS];
    sem_t due;
    _Atomic bool stop, connected;
    _Atomic int trouble;       /* errno of the first failure, cleared after a second without
                                * failures; 0: none */
    _Atomic unsigned foreign;  /* number of signs of another master (meet_foreign()) */
    _Atomic unsigned twins;    /* number of transactions with an unrequested answer */
    _Atomic int loop_priority; /* the loop's SCHED_FIFO priority; 0: the loop has another policy */
    /* the group below belongs to the Modbus thread */
    pthread_t thread;
    struct modbus_link *link;
    uint32_t token;
    uint16_t number, foreign_writes; /* number of the last sent command; last value of
                                      * MODBUS_FOREIGN */
    unsigned unasked;                /* last value of modbus_link_unasked() */
    bool begun;                      /* the loop has posted its first command */
    bool put_out;                    /* last sent level of the supply output */
    unsigned changes_seen;           /* `changes` of the last sent command */
    double latch_after_s; /* time from the start of sending a request until its values are latched;
                           * below 0: the middle of the round trip is taken */
    int64_t good_ns;      /* time from which on a second without failures has passed */
    /* the group below belongs to the loop's thread */
    struct latched newest;
    uint64_t device_seq;
    unsigned foreign_seen, twins_seen, changes;
    bool supply;          /* last commanded level of the supply output */
};

static const struct command_record centred = {.keeps_supply = true};

/* Returns the age beyond which a reading, or a command that waits to be sent, is useless. */
static double timeout_s(const struct params *p) { return p->limits.sensor_age_s; }

/* Returns the time-out of an answer. On a serial line an answer takes less than one period, and a
 * lost frame is not repeated. So after two periods an answer is lost, and waiting longer would only
 * delay the next command. */
static double answer_timeout_s(const struct modbus_hal *m) {
    return m->address.serial ? fmin(timeout_s(m->params), 2.0 * m->params->loop.period_s) : timeout_s(m->params);
}

static void failed(struct modbus_hal *m, int reason) {
    int none = 0;
    atomic_compare_exchange_strong(&m->trouble, &none, reason);
    m->good_ns = monotonic_ns() + NS_PER_S;
}

/* Reports another master to the loop. reason: EBUSY, or the errno of the exception. */
static void meet_foreign(struct modbus_hal *m, int reason) {
    atomic_fetch_add(&m->foreign, 1);
    failed(m, reason);
}

/* SAFETY: reports a second device to the loop, because answers of two devices cannot be told
 * apart. */
static void meet_twin(struct modbus_hal *m) {
    unsigned unasked = modbus_link_unasked(m->link);
    if (unasked == m->unasked) return;
    m->unasked = unasked;
    atomic_fetch_add(&m->twins, 1);
    failed(m, ENOTUNIQ);
}

/* Returns the command to send, with its level of the supply output. If the loop has changed the
 * output twice since the last transaction, that counts as one change, not as none, so that the life
 * sign goes on. */
static struct hal_command due_output(struct modbus_hal *m, const struct command_record *c) {
    struct hal_command command = {.supply = m->put_out};
    memcpy(command.valve, c->valve, sizeof command.valve);
    if (!c->keeps_supply) command.supply ^= c->changes != m->changes_seen;
    m->changes_seen = c->changes;
    m->put_out = command.supply;
    return command;
}

/* SAFETY: the answer begins with the number of the command in force. A wrong number means that this
 * is a late answer to another request, or that the device has not taken the command; the readings
 * would then be older than they seem. Another master is reported to the loop at once. */
static int exchange(struct modbus_hal *m, const struct command_record *record, struct latched *l) {
    const struct hal_command command = due_output(m, record);
    uint16_t written[MODBUS_WRITTEN], read[MODBUS_READ];
    modbus_put_command(m->params, m->token, ++m->number, &command, written);
    if (modbus_link_exchange(m->link, MODBUS_WRITE_FROM, MODBUS_WRITTEN, written, MODBUS_READ_FROM, MODBUS_READ, read)) {
        int reason = errno;
        meet_twin(m);
        if (modbus_link_busy(reason)) meet_foreign(m, reason);
        errno = reason;
        return -1;
    }
    meet_twin(m);
    int64_t begun_ns = modbus_link_begun_ns(m->link), ended_ns = monotonic_ns();
    l->time_ns = m->latch_after_s < 0.0 ? begun_ns + (ended_ns - begun_ns) / 2 : begun_ns + ns_from_seconds(m->latch_after_s);
    if (l->time_ns > ended_ns) l->time_ns = ended_ns;
    modbus_get_reading(m->params, read, &l->reading);
    if (l->reading.foreign != m->foreign_writes) meet_foreign(m, EBUSY);
    m->foreign_writes = l->reading.foreign;
    if (l->reading.number == m->number) return 0;
    modbus_link_not_answered(m->link);
    errno = EBADMSG;
    return -1;
}

/* Refuses a machine that another master owns. SAFETY: that master is neither disturbed nor asked to
 * release the machine. */
static int refuse_owned(struct modbus_hal *m, struct error *error) {
    uint16_t owner[2] = {0};
    char who[24] = "";
    meet_foreign(m, EBUSY);
    if (!modbus_link_read(m->link, MODBUS_OWNER, 2, owner) && (owner[0] || owner[1]))
        snprintf(who, sizeof who, ", %d.%d.%d.%d,", owner[0] >> 8, owner[0] & 255, owner[1] >> 8, owner[1] & 255);
    return error_set(error, STATUS_UNSAFE,
                     "modbus:%s: another master%s commands this machine: end it first; the machine is free when it "
                     "has been silent for the device's watchdog",
                     m->address.name, who);
}

/* SAFETY: the watchdog is read back, because this master relies on it to stop the machine. */
static int claim(struct modbus_hal *m, struct error *error) {
    uint16_t claimed[MODBUS_CLAIMED], own_ms = 0, set_ms = 0, watchdog_ms = (uint16_t)lround(m->params->device.watchdog_s * 1e3);
    modbus_put_claim(watchdog_ms, m->token, claimed);
    if (modbus_link_write(m->link, MODBUS_WATCHDOG_MS, MODBUS_CLAIMED, claimed)) {
        int reason = errno;
        if (modbus_link_busy(reason)) return refuse_owned(m, error);
        if (modbus_link_value(reason) && !modbus_link_read(m->link, MODBUS_WATCHDOG_MAX_MS, 1, &own_ms))
            return error_set(error, STATUS_UNSAFE, "modbus:%s: device.watchdog_s %g is not taken: this device takes %d to %d ms",
                             m->address.name, m->params->device.watchdog_s, MODBUS_WATCHDOG_MIN_MS, own_ms);
        return error_set(error, STATUS_IO, "modbus:%s: the machine cannot be claimed: %s", m->address.name, modbus_link_reason(reason));
    }
    if (modbus_link_read(m->link, MODBUS_WATCHDOG_MS, 1, &set_ms))
        return error_set(error, STATUS_IO, "modbus:%s: the watchdog cannot be read back: %s", m->address.name, modbus_link_reason(errno));
    if (set_ms != watchdog_ms)
        return error_set(error, STATUS_UNSAFE,
                         "modbus:%s: the watchdog was set to %d ms and is %d ms: a device that does not keep it must "
                         "not be run",
                         m->address.name, watchdog_ms, set_ms);
    return STATUS_OK;
}

/* Checks the device's identity and version, then claims the machine. */
static int greet(struct modbus_hal *m, struct error *error) {
    uint16_t who[2];
    int status = modbus_link_greet(m->link, m->address.name, who, error);
    if (status) return status;
    if (who[0] != MODBUS_IS_HEXID || who[1] != MODBUS_MAP_VERSION)
        return error_set(error, STATUS_IO,
                         "modbus:%s: registers 0 and 1 hold 0x%04x and %u, not 0x%04x and %d: another device, or "
                         "another map (`hexid doctor --modbus-map`)",
                         m->address.name, who[0], who[1], MODBUS_IS_HEXID, MODBUS_MAP_VERSION);
    if (modbus_link_read(m->link, MODBUS_FOREIGN, 1, &m->foreign_writes))
        return error_set(error, STATUS_IO, "modbus:%s: register %d: %s", m->address.name, MODBUS_FOREIGN, modbus_link_reason(errno));
    return claim(m, error);
}

static int connect_link(struct modbus_hal *m, struct error *error) {
    /* longer than answer_timeout_s(), because nothing moves yet, and a device with many clients may
     * be slow */
    static const double greet_timeout_s = 1.0;
    int status = modbus_link_open(&m->link, &m->address, m->params->modbus.unit, greet_timeout_s, error);
    if (status) return status;
    status = greet(m, error);
    m->unasked = modbus_link_unasked(m->link);
    if (!status && m->unasked >= TWIN_ANSWERS)
        status = error_set(error, STATUS_UNSAFE, "modbus:%s: two devices answer as unit %d: give each a number of its own", m->address.name,
                           m->params->modbus.unit);
    if (!status) status = modbus_link_keep_silence(m->link, &m->address, m->params->loop.period_s, error);
    modbus_link_set_timeout(m->link, answer_timeout_s(m));
    if (!status) return STATUS_OK;
    modbus_link_close(m->link);
    m->link = NULL;
    return status;
}

/* SAFETY: returns the newest command; NULL if there is no new command, or if it has waited too
 * long. */
static const struct command_record *due_command(struct modbus_hal *m) {
    if (!latest_take(&m->newest_command)) return NULL;
    const struct command_record *c = &m->record[m->newest_command.front];
    return monotonic_ns() - c->posted_ns <= ns_from_seconds(timeout_s(m->params)) ? c : NULL;
}

/* SAFETY: returns the command to send; NULL: nothing must be sent. Until the loop posts its first
 * command, valves are centred by a command that keeps the claim, so that no other master takes the
 * machine. Afterwards only the loop's commands are sent, so that the device's watchdog detects a
 * loop that hangs. */
static const struct command_record *command_to_send(struct modbus_hal *m) {
    const struct command_record *command = due_command(m);
    m->begun |= command != NULL;
    return m->begun ? command : &centred;
}

static void talk(struct modbus_hal *m, int *silent) {
    const struct command_record *command = command_to_send(m);
    if (!command) return;
    if (!exchange(m, command, &m->sample[m->newest_sample.back])) {
        latest_publish(&m->newest_sample);
        *silent = 0;
        if (monotonic_ns() > m->good_ns) atomic_store(&m->trouble, 0);
        return;
    }
    int reason = errno;
    failed(m, reason);
    /* SAFETY: if another master has taken the machine, nothing is written until this master has
     * claimed it again. Half a second without answers counts as a lost connection. */
    bool lost = modbus_link_gone(reason) || modbus_link_busy(reason) || ++*silent * answer_timeout_s(m) > 0.5;
    if (!lost) return;
    atomic_store_explicit(&m->connected, false, memory_order_release);
    modbus_link_close(m->link);
    m->link = NULL;
    *silent = 0;
}

static void wait_for_command(struct modbus_hal *m, int64_t at_most_ms) {
    int64_t until_ns = monotonic_ns() + at_most_ms * 1000 * NS_PER_US;
    struct timespec t = {.tv_sec = until_ns / NS_PER_S, .tv_nsec = until_ns % NS_PER_S};
    while (sem_clockwait(&m->due, CLOCK_MONOTONIC, &t) && errno == EINTR) continue;
}

/* Gives the thread SCHED_FIFO just below the loop's priority, if the loop has SCHED_FIFO. If the
 * kernel refuses, delays show in the readings' age. */
static void follow_loop(const struct modbus_hal *m, int *followed) {
    int loop = atomic_load_explicit(&m->loop_priority, memory_order_relaxed);
    if (loop == *followed) return;
    struct sched_param priority = {.sched_priority = loop > 1 ? loop - 1 : 1};
    pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority);
    *followed = loop;
    /* drops the capability that was needed to change the priority */
    if (m->params->security.confine) confine_thread();
}

static void *modbus_thread(void *argument) {
    struct modbus_hal *m = argument;
    struct error error;
    crash_stack();
    int64_t backoff_ms = BACKOFF_FIRST_MS, again_ns = 0;
    int silent = 0, followed = 0;
    int64_t kept_ms = llround(m->params->device.watchdog_s * 1e3 / 4);

    while (!atomic_load_explicit(&m->stop, memory_order_acquire)) {
        wait_for_command(m, m->begun || kept_ms > 100 ? 100 : kept_ms);
        follow_loop(m, &followed);
        if (m->link) {
            talk(m, &silent);
            if (!m->link) again_ns = monotonic_ns() + backoff_ms * 1000 * NS_PER_US;
            continue;
        }

        if (monotonic_ns() < again_ns) continue;
        if (connect_link(m, &error)) {
            backoff_ms = backoff_ms * 2 < BACKOFF_LAST_MS ? backoff_ms * 2 : BACKOFF_LAST_MS;
            again_ns = monotonic_ns() + backoff_ms * 1000 * NS_PER_US;
            continue;
        }

        backoff_ms = BACKOFF_FIRST_MS;
        /* SAFETY: drops the waiting command. A command from before the loss is outdated. Since
         * then, while `connected` was not set, the loop has posted only commands that centre the
         * valves, and it posts them again in every cycle. */
        latest_take(&m->newest_command);
        atomic_store_explicit(&m->connected, true, memory_order_release);
    }
    return NULL;
}

/* SAFETY: the Modbus thread blocks all signals, so that a signal that ends the run reaches the
 * thread that parks the platform first. */
static int start_thread(struct modbus_hal *m, struct error *error) {
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    int status = thread_start(&m->thread, "modbus", THREAD_STACK_REALTIME, modbus_thread, m, error);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return status;
}

/* Refuses a serial line that is too slow for the loop's period, and values of limits.sensor_age_s
 * and device.watchdog_s that do not suit Modbus. */
static int refuse_slow(const struct modbus_hal *m, struct error *error) {
    const struct params *p = m->params;
    double period_s = p->loop.period_s;
    struct modbus_load l = modbus_load(m->address.baud);
    if (m->address.serial && l.cycle_s > 0.9 * period_s)
        return error_set(error, STATUS_USAGE,
                         "modbus:rtu: function 23 takes %d + %d bytes of 10 bits, %.1f ms at %d baud with the silence "
                         "after each; 90 %% of loop.period_s are %.1f ms: raise the baud rate, or loop.period_s to %.3f or more "
                         "(with sim.substeps where simulated)",
                         l.request_bytes, l.response_bytes, l.cycle_s * 1e3, m->address.baud, 0.9 * period_s * 1e3,
                         ceil(l.cycle_s / 0.9 * 1e3) / 1e3);
    if (p->limits.sensor_age_s < 2.5 * period_s)
        return error_set(error, STATUS_USAGE,
                         "modbus: limits.sensor_age_s %g must be at least 2.5 x loop.period_s: a reading is up to two "
                         "cycles old when used",
                         p->limits.sensor_age_s);
    if (p->device.watchdog_s < 3.0 * period_s || p->device.watchdog_s > 65.0)
        return error_set(error, STATUS_USAGE, "modbus: device.watchdog_s %g must be at least 3 x loop.period_s, and at most 65 s",
                         p->device.watchdog_s);
    return STATUS_OK;
}

static void release(struct modbus_hal *m) {
    modbus_link_close(m->link);
    sem_destroy(&m->due);
    free(m);
}

/* Makes the first exchange, and repeats it for up to half a second if frames are lost or garbled.
 * Nothing moves yet, and a single lost frame must not keep the machine from starting. */
static int first_exchange(struct modbus_hal *m) {
    int64_t until_ns = monotonic_ns() + NS_PER_S / 2;
    while (exchange(m, &centred, &m->sample[m->newest_sample.back]))
        if (!modbus_link_lost(errno) || monotonic_ns() > until_ns) return -1;
    return 0;
}

static int bring_up(struct modbus_hal *m, const char *address, struct error *error) {
    int status = modbus_parse(address, &m->address, error);
    if (!status) status = refuse_slow(m, error);
    m->ops.reopens = m->address.serial ? HAL_REOPENS_SERIAL : HAL_REOPENS_SOCKETS;
    while (!m->token)
        if (getrandom(&m->token, sizeof m->token, 0) < 0)
            return error_set(error, STATUS_IO, "modbus: no random number: %s", strerror(errno));
    if (!status) status = connect_link(m, error);
    if (status) return status;
    m->latch_after_s = m->address.serial ? modbus_load(m->address.baud).request_s : -1.0;
    if (first_exchange(m))
        return error_set(error, STATUS_IO,
                         "modbus:%s: function 23 is not answered: %s; the device must serve the map of "
                         "`hexid doctor --modbus-map`",
                         m->address.name, modbus_link_reason(errno));
    latest_publish(&m->newest_sample);
    atomic_store(&m->connected, true);
    return start_thread(m, error);
}

static int modbus_open(struct hal **hal, const char *address, const struct params *params, uint64_t seed, struct error *error) {
    struct modbus_hal *m = calloc(1, sizeof *m);
    (void)seed;
    if (!m) return error_set(error, STATUS_IO, "modbus: out of memory");
    m->ops = hal_modbus;
    m->hal.ops = &m->ops;
    m->params = params;
    latest_init(&m->newest_command);
    latest_init(&m->newest_sample);
    sem_init(&m->due, 0, 0);
    int status = bring_up(m, address, error);
    if (status) release(m);
    else *hal = &m->hal;
    return status;
}

static void hand_out(const struct modbus_hal *m, struct hal_sample *s) {
    const struct modbus_reading *r = &m->newest.reading;
    for (int i = 0; i < LEGS; i++) {
        s->length_m[i] = r->length_m[i], s->p1_pa[i] = r->p1_pa[i], s->p2_pa[i] = r->p2_pa[i];
    }
    s->inputs = r->inputs;
    s->contradicted = r->contradicted;
}

/* Passes the loop's priority to the Modbus thread; called once, in the loop's thread. */
static void tell_priority(struct modbus_hal *m) {
    struct sched_param p;
    if (sched_getscheduler(0) == SCHED_FIFO && !sched_getparam(0, &p))
        atomic_store_explicit(&m->loop_priority, p.sched_priority, memory_order_relaxed);
}

static int modbus_read(struct hal *hal, int64_t now_ns, struct hal_sample *s) {
    struct modbus_hal *m = (struct modbus_hal *)hal;
    int64_t period_ns = ns_from_seconds(m->params->loop.period_s);
    uint16_t before = m->newest.reading.sample;
    int64_t before_ns = m->newest.time_ns;
    bool first = before_ns == 0, any = latest_take(&m->newest_sample);
    if (first) tell_priority(m);
    if (any) m->newest = m->sample[m->newest_sample.front];
    uint16_t step = (uint16_t)(m->newest.reading.sample - before);
    if (first) m->device_seq = 1;
    else m->device_seq += step;
    *s = (struct hal_sample){.device_seq = m->device_seq, .time_ns = m->newest.time_ns + now_ns - monotonic_ns()};
    s->age_ns = now_ns - s->time_ns;
    if (!any || (!first && step == 0)) s->flags |= SAMPLE_STALE;
    if (!first && step > 1) s->flags |= SAMPLE_DROPPED;
    /* SAFETY: if the time between two latches differs from the period by more than half a period,
     * the previous command was held too long or too short. */
    if (any && !first && 2 * llabs(m->newest.time_ns - before_ns - period_ns) > period_ns) s->flags |= SAMPLE_LATE;
    if (2 * s->age_ns > 5 * period_ns) s->flags |= SAMPLE_LATE;
    unsigned foreign = atomic_load(&m->foreign);
    if (foreign != m->foreign_seen) s->flags |= SAMPLE_FOREIGN;
    m->foreign_seen = foreign;
    unsigned twins = atomic_load(&m->twins);
    if (twins != m->twins_seen) s->flags |= SAMPLE_TWIN;
    m->twins_seen = twins;
    hand_out(m, s);
    return atomic_load_explicit(&m->connected, memory_order_acquire) ? 0 : -1;
}

static void post(struct modbus_hal *m, const double valve[LEGS], bool keeps_supply) {
    struct command_record *c = &m->record[m->newest_command.back];
    c->posted_ns = monotonic_ns();
    memcpy(c->valve, valve, sizeof c->valve);
    c->changes = m->changes;
    c->keeps_supply = keeps_supply;
    latest_publish(&m->newest_command);
    sem_post(&m->due);
}

static int modbus_write(struct hal *hal, const struct hal_command *command) {
    struct modbus_hal *m = (struct modbus_hal *)hal;
    if (!atomic_load_explicit(&m->connected, memory_order_acquire)) return -1;
    m->changes += command->supply != m->supply;
    m->supply = command->supply;
    post(m, command->valve, false);
    return 0;
}

static void modbus_safe(struct hal *hal) { post((struct modbus_hal *)hal, centred.valve, true); }

static void modbus_describe(const struct hal *hal, char *text, size_t size) {
    int reason = atomic_load(&((const struct modbus_hal *)hal)->trouble);
    snprintf(text, size, "%s", reason ? modbus_link_reason(reason) : "");
}

static void modbus_close(struct hal *hal) {
    struct modbus_hal *m = (struct modbus_hal *)hal;
    struct latched ignored;
    atomic_store_explicit(&m->stop, true, memory_order_release);
    sem_post(&m->due);
    pthread_join(m->thread, NULL);
    /* SAFETY: the last command centres the valves, whatever the thread was doing */
    if (m->link) exchange(m, &centred, &ignored);
    release(m);
}

const struct hal_ops hal_modbus = {
    .scheme = "modbus",
    .usage = "modbus:tcp://HOST:PORT     one Modbus device with all legs; or modbus:rtu:DEVICE?baud=N",
    .open = modbus_open,
    .read = modbus_read,
    .write = modbus_write,
    .safe = modbus_safe,
    .close = modbus_close,
    .describe = modbus_describe,
};
