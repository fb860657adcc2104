#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

#include "bus.h"
#include "cli.h"
#include "config.h"
#include "log.h"
#include "messages.h"
#include "recorder.h"
#include "units.h"

enum { RING_CAPACITY = 8192 }; /* cycles: 16 s at 2 ms, against a stalled disk */

struct session {
    struct options options;
    struct params params;
    struct hal *hal;
    struct ring ring;
    struct loop loop;
    struct recorder recorder;
    struct progress progress;
    struct log_writer *log;
    struct bus *bus;
    char *config;
    int signals; /* received */
};

static void warn(const struct error *error) { fprintf(stderr, "hexid: warning: %s\n", error->text); }

/* LCM is how others watch; without it the run goes on, and says so. */
static void open_bus(struct session *s) {
    struct error error;
    if (s->params.lcm.url[0] && bus_open(&s->bus, s->params.lcm.url, &error)) warn(&error);
}

/* What an operator would wonder about: nothing moves, and why. */
static void say_who_moves_it(const struct session *s) {
    if (s->params.motion.automatic || s->hal->ops->simulated) return;
    fprintf(stderr, "hexid: %s is a real machine: it waits for `hexid command engage` and `start`%s; --set motion.automatic=true runs the "
            "tests without being told\n", s->options.hal, s->params.lcm.commands ? "" : ", which need lcm.commands: true");
}

static enum realtime_mode realtime_of(const struct session *s) {
    if (s->options.fast) return REALTIME_OFF;
    if (s->options.rt_given) return s->options.rt;
    return s->hal->ops->simulated ? REALTIME_TRY : REALTIME_REQUIRE;
}

/* SAFETY: behind hardware time is real: a deadline missed is missed by the machine, too. */
static enum clock_kind clock_of(const struct session *s) {
    if (s->options.fast) return CLOCK_VIRTUAL;
    return s->hal->ops->simulated && realtime_of(s) != REALTIME_REQUIRE ? CLOCK_PACED : CLOCK_REAL;
}

static int open_all(struct session *s, struct error *error) {
    int status = hal_open(&s->hal, s->options.hal, &s->params, s->options.seed, error);
    if (status) return status;
    options_automatic(&s->options, s->hal->ops->simulated, &s->params);
    say_who_moves_it(s);
    if (s->options.fast && !s->hal->ops->simulated)
        return error_set(error, STATUS_USAGE, "--fast: %s is not simulated; a real machine has real time", s->options.hal);
    if ((status = cli_check_writable(s->options.json, error))) return status;
    if (s->options.log && (status = log_create(&s->log, s->options.log, error))) return status;
    if (ring_init(&s->ring, sizeof(struct cycle), RING_CAPACITY)) return error_set(error, STATUS_IO, "out of memory");
    s->config = config_text(&s->params);
    if (!s->config) return error_set(error, STATUS_IO, "out of memory");
    open_bus(s);
    return loop_init(&s->loop, &s->params, s->hal, &s->ring, clock_of(s), error);
}

static void close_all(struct session *s) {
    struct error ignored;
    if (s->bus) bus_close(s->bus);
    if (s->log) log_close(s->log, &ignored);
    ring_free(&s->ring);
    if (s->hal) s->hal->ops->close(s->hal);
    free(s->config);
}

/* SAFETY: a terminal or a pipe that goes away must not end the process that holds the platform up. */
static void block_signals(sigset_t *set) {
    signal(SIGPIPE, SIG_IGN);
    sigemptyset(set);
    sigaddset(set, SIGINT);
    sigaddset(set, SIGTERM);
    sigaddset(set, SIGHUP);
    pthread_sigmask(SIG_BLOCK, set, NULL);
}

/* SAFETY: the first signal puts the platform down and ends the run; the second centres the valves at once. */
static void signalled(struct session *s) {
    if (s->signals++) {
        progress_say(&s->progress, "hexid: interrupted again: valves centred\n");
        atomic_store(&s->loop.abort, true);
        return;
    }
    progress_say(&s->progress, "hexid: interrupted: parking (once more to centre the valves at once)\n");
    mailbox_post(&s->loop.requests, COMMAND_PARK);
    atomic_store(&s->loop.quit, true);
}

static void refuse(struct session *s, enum command command) {
    unsigned char buffer[256];
    char text[160];
    snprintf(text, sizeof text, "%s refused: set lcm.commands to true to accept commands that move", command_names[command]);
    int size = event_encode(clock_now(&s->loop.clock), 0, "command", text, buffer, sizeof buffer);
    bus_publish(s->bus, CHANNEL_EVENT, buffer, size);
    progress_say(&s->progress, "hexid: command %s\n", text);
}

/* SAFETY: whoever reaches the bus may put the platform down; only the configuration lets it be moved from there. */
static void command_received(void *context, enum command command) {
    struct session *s = context;
    bool stops = command == COMMAND_STOP || command == COMMAND_PARK;
    if (stops || s->params.lcm.commands) mailbox_post(&s->loop.requests, command); /* the recorder answers */
    else refuse(s, command);
}

static void wait_for_end(struct session *s, const sigset_t *signals) {
    const struct timespec pause = {.tv_nsec = s->options.fast ? 2000000 : 20000000};
    bool listens = s->bus && !s->options.fast && !bus_subscribe_commands(s->bus, command_received, s);
    while (!atomic_load_explicit(&s->loop.ended, memory_order_acquire)) {
        if (sigtimedwait(signals, NULL, &pause) > 0) signalled(s);
        if (listens) bus_handle(s->bus, 0);
    }
}

static int report(struct session *s, struct error *error) {
    struct analysis *a = &s->recorder.analysis;
    struct verdict verdict = analysis_verdict(a);
    progress_end(&s->progress);
    if (s->signals) verdict_add(&verdict, VERDICT_NOT_EVALUATED, "interrupted");
    analysis_print(a, &verdict, s->progress.out);
    char trouble[200] = "";
    if (s->hal->ops->describe) s->hal->ops->describe(s->hal, trouble, sizeof trouble);
    if (*trouble) fprintf(s->progress.out, "device    %s: %s\n", s->options.hal, trouble);
    fprintf(s->progress.out, "log       %s\n", s->options.log ? s->options.log : "none kept (--log FILE keeps one)");
    int status = analysis_write_json(a, &verdict, s->options.json, error);
    return status ? status : verdict.status == VERDICT_PASS ? EXIT_PASSED : EXIT_CHECK_FAILED;
}

static int run(struct session *s, struct error *error) {
    sigset_t signals;
    block_signals(&signals);
    progress_init(&s->progress, &s->params, s->options.json && !strcmp(s->options.json, "-") ? stderr : stdout, s->options.fast);
    s->recorder = (struct recorder){.params = &s->params, .loop = &s->loop, .records = &s->ring, .log = s->log, .bus = s->bus,
                                    .progress = &s->progress, .virtual_time = s->options.fast};
    int status = recorder_start(&s->recorder, s->config, error);
    if (status) return status;
    status = loop_start(&s->loop, realtime_of(s), error);
    if (status) {
        recorder_join(&s->recorder);
        return status;
    }
    if (s->loop.realtime) warn(&s->loop.realtime_error);
    wait_for_end(s, &signals);
    loop_join(&s->loop);
    recorder_join(&s->recorder);
    struct error closing = {0};
    if (s->log && log_close(s->log, &closing) && !s->recorder.error.status) s->recorder.error = closing;
    s->log = NULL;
    int reported = report(s, error);
    if (s->recorder.error.status) {
        *error = s->recorder.error;
        return error->status;
    }
    return reported;
}

int cmd_run(int argc, char **argv) {
    struct session *s = calloc(1, sizeof *s);
    struct error error = {0};
    if (!s) return -STATUS_IO;
    int status = options_parse(&s->options, argc, argv, "cHfrsljStp", 0, &error);
    if (!status) status = options_params(&s->options, &s->params, &error);
    if (!status && !s->options.print_config) status = config_check_motion(&s->params, &error);
    if (!status && s->options.print_config) {
        char *text = config_text(&s->params);
        status = text ? cli_write_text("-", text, &error) : error_set(&error, STATUS_IO, "out of memory");
        free(text);
    } else if (!status) {
        status = open_all(s, &error);
        if (!status) status = run(s, &error);
    }
    close_all(s);
    free(s);
    return status < 0 ? cli_fail(&error) : status;
}
