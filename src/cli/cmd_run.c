#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bus.h"
#include "cli.h"
#include "commands.h"
#include "config.h"
#include "confine.h"
#include "crash.h"
#include "doctor.h"
#include "interlock.h"
#include "kinematics.h"
#include "log.h"
#include "log_directory.h"
#include "loop_check.h"
#include "machine_lock.h"
#include "messages.h"
#include "monotonic.h"
#include "motion_check.h"
#include "outputs.h"
#include "poll_any.h"
#include "process.h"
#include "quality_plan.h"
#include "recorder.h"
#include "signals.h"
#include "survey_report.h"
#include "trajectory_file.h"
#include "units.h"

/* distance of the main thread's SCHED_FIFO priority below the loop's. The main thread passes stops
 * to the loop, so it has priority over everything but the loop and the threads of signals and field
 * bus */
enum { STOP_PATH_BELOW_LOOP = 2 };
static const double STD_PCT = 0.5; /* wanted standard deviation of a survey's proposals if --std is
                                    * not given, % */
static const double RECORDER_BEHIND_S = 2.0; /* the recorder counts as hanging if the cycles that
                                              * wait in the ring last this long; the rest of the
                                              * ring, at least 14 s, is for parking */

struct session {
    struct options options;
    struct params params;
    struct trajectory trajectory; /* trajectory of the tests; knot NULL: there is none */
    struct multisine multisine;   /* motion of a survey */
    struct params machine;        /* the back-end's configuration (options_machine()): that in FILE
                                   * for sim:FILE, otherwise equal to params */
    struct params asked;          /* configured parameters, before --survey changes the tests */
    struct survey_report *survey; /* the survey's results; NULL: this run is no survey */
    struct hal *hal;
    struct ring ring;
    struct loop loop;
    struct recorder recorder;
    struct progress progress;
    struct loop_check poles;      /* result of the check of the closed loop */
    struct gains_check gains;     /* margins of the configured gains */
    struct log_writer *log;
    struct log_keeper keeper;
    struct bus *bus;
    struct commands commands;
    char *config;
    struct output json;
    char log_path[PATH_MAX];       /* path of the log if --log is a directory */
    struct machine_lock lock; /* lock of the machine, held to the end of the process */
    struct signals signals;
    struct error behind; /* report that the recorder fell too far behind; status 0: it did not */
    bool stuck;
};

static void warn(const struct error *error) { cli_say(stderr, "hexid: warning: %s", error->text); }

/* Opens LCM. If that fails, as without a multicast route, the run continues with a warning, because
 * LCM serves only watching, and a stop or park, which can also come through the sockets. */
static int open_bus(struct session *s, struct error *error) {
    int status = s->params.lcm.url[0] ? bus_open(&s->bus, s->params.lcm.url, error) : STATUS_OK;
    if (status == STATUS_USAGE) return status;
    if (status) warn(error);
    return STATUS_OK;
}

/* Opens the sockets for commands and listens on LCM. A run in virtual time receives no commands,
 * because these come in wall-clock time. */
static int open_commands(struct session *s, struct error *error) {
    struct error doubt;
    if (s->options.fast) return STATUS_OK;
    int status = commands_open(&s->commands, &s->params, s->bus, &doubt, error);
    const char *name = s->commands.server.machine.name;
    if (status) return status;
    if (doubt.status) warn(&doubt);
    if (!s->params.machine.name[0] && *name && strcmp(name, MACHINE_NAME_DEFAULT) != 0)
        fprintf(stderr, "hexid: another hexid of this host is `" MACHINE_NAME_DEFAULT "`; this one is `%s`: hexid command --machine %s\n",
                name, name);
    return STATUS_OK;
}

/* Tells the operator why nothing moves yet. */
static void say_who_moves_it(const struct session *s) {
    if (s->params.motion.automatic || s->hal->ops->simulated) return;
    fprintf(stderr,
            "hexid: %s is a real machine: it waits for `hexid command engage` and `start`%s; --set motion.automatic=true runs the "
            "tests without being told\n",
            s->options.hal, s->params.lcm.commands ? "" : ", which need lcm.commands: true");
}

static enum realtime_mode realtime_of(const struct session *s) {
    if (s->options.fast) return REALTIME_OFF;
    if (s->options.rt_given) return s->options.rt;
    return s->hal->ops->simulated ? REALTIME_TRY : REALTIME_REQUIRE;
}

/* SAFETY: chooses the clock. Hardware gets the real clock, because a machine does not wait for a
 * late loop; a simulation gets it with --rt require. */
static enum clock_kind clock_of(const struct session *s) {
    if (s->options.fast) return CLOCK_VIRTUAL;
    return s->hal->ops->simulated && realtime_of(s) != REALTIME_REQUIRE ? CLOCK_PACED : CLOCK_REAL;
}

/* Returns the machine's own URL, without the prefixes of simulated faults. */
static const char *machine_url(const struct session *s) {
    const char *last = strrchr(s->options.hal, ';');
    return last ? last + 1 : s->options.hal;
}

/* Returns true if the machine is on a field bus, where commands act one cycle later. */
static bool on_bus(const struct session *s) {
    const struct hal_ops *ops = hal_find(machine_url(s));
    return ops && !ops->simulated;
}

static const struct trajectory *driven(const struct session *s) { return s->trajectory.knot ? &s->trajectory : NULL; }

/* Makes s->trajectory the motion of the run; messages name `option`. The loop, the log and its
 * readers treat this motion as a trajectory that has no file. */
static int own_motion(struct session *s, const char *option, const char *name, int repeat, struct error *error) {
    struct test_params *t = &s->params.tests;
    struct error beyond;
    t->multisine = false;
    t->repeat = repeat;
    t->duration_s = trajectory_s(&s->trajectory);
    snprintf(t->trajectory, sizeof t->trajectory, "%s", name);
    if (!motion_check(&s->params, &s->trajectory, &beyond)) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "%s: %.320s (a lower limits.leg_rate_mps makes it smaller)", option, beyond.text);
}

static int check_survey(struct session *s, struct error *error) {
    s->asked = s->params;
    s->survey = calloc(1, sizeof *s->survey);
    if (!s->survey) return error_set(error, STATUS_IO, "out of memory");
    int status = multisine_init(&s->multisine, &s->params, error);
    if (!status) status = multisine_trajectory(&s->multisine, &s->trajectory, error);
    return status ? status : own_motion(s, "--survey", "survey", MULTISINE_PASSES, error);
}

static int check_qualify(struct session *s, struct error *error) {
    struct test_params *t = &s->params.tests;
    struct quality_plan plan;
    int status = quality_plan(&plan, &s->params, on_bus(s), error);
    if (!status) status = quality_trajectory(&plan, &s->trajectory, error);
    if (status) return status;
    t->ramp_out_s = fmax(t->ramp_out_s, plan.ramp_out_s);
    return own_motion(s, "--qualify", QUALITY_MOTION, 1, error);
}

/* SAFETY: checks the run's motion, and whether the machine may be driven at all, before anything is
 * opened. The duration of a trajectory becomes tests.duration_s. */
static int check_motion(struct session *s, struct error *error) {
    const char *own = s->options.qualify ? "--qualify" : s->options.survey ? "--survey" : NULL;
    if (!own) return motion_check_tests(&s->params, &s->trajectory, error);
    if (s->params.tests.trajectory[0])
        return error_set(error, STATUS_USAGE, "%s: tests.trajectory is set; it has a motion of its own", own);
    int status = config_check_motion(&s->params, error);
    if (status) return status;
    return s->options.qualify ? check_qualify(s, error) : check_survey(s, error);
}

/* Opens the log. Old logs that cannot be deleted cause a warning only. */
static int open_log(struct session *s, struct error *error) {
    struct options *o = &s->options;
    char aside[PATH_MAX];
    struct stat log;
    bool directory = o->log && !stat(o->log, &log) && S_ISDIR(log.st_mode);
    if ((o->log_quota_bytes > 0.0 || o->log_part_bytes > 0.0) && !directory)
        return error_set(error, STATUS_USAGE, "%s",
                         o->log_part_bytes > 0.0 ? "--log-part: it needs --log DIR, a directory that is there"
                                                 : "--log-quota: it needs --log DIR, a directory that is there");
    if (!o->log) return STATUS_OK;
    if (o->log_quota_bytes > 0.0 && log_directory_prune(o->log, (int64_t)o->log_quota_bytes, NULL, error)) warn(error);
    if (directory) {
        int status = log_directory_create(o->log, o->log_part_bytes > 0.0, s->log_path, sizeof s->log_path, error);
        if (!status && o->log_part_bytes > 0.0) status = log_keeper_start(&s->keeper, s->log_path, (int64_t)o->log_quota_bytes, error);
        if (status) return status;
        o->log = s->log_path;
    }
    int file = output_log(o->log, aside, error);
    if (file < 0) return file;
    if (*aside) cli_say(stderr, "hexid: %s: the log that was there is now %s", o->log, aside);
    return log_on_file(&s->log, file, o->log, error);
}

static int open_all(struct session *s, struct error *error) {
    int status = machine_lock(&s->lock, s->options.hal, error);
    if (status) return status;
    if (s->lock.doubt.status) warn(&s->lock.doubt);
    status = options_machine(s->options.hal, &s->params, &s->machine, error);
    if (!status) status = hal_open(&s->hal, s->options.hal, &s->machine, s->options.seed, error);
    if (status) return status;
    options_automatic(&s->options, s->hal->ops->simulated, &s->params);
    say_who_moves_it(s);
    if (s->options.fast && !s->hal->ops->simulated)
        return error_set(error, STATUS_USAGE, "--fast: %s is not simulated; a real machine has real time", s->options.hal);
    if ((status = open_log(s, error))) return status;
    if (ring_init(&s->ring, sizeof(struct cycle), recorder_ring_cycles(&s->params))) return error_set(error, STATUS_IO, "out of memory");
    s->config = config_text(&s->params);
    if (!s->config) return error_set(error, STATUS_IO, "out of memory");
    if ((status = open_bus(s, error))) return status;
    if ((status = open_commands(s, error))) return status;
    status = loop_init(&s->loop, &s->params, s->hal, &s->ring, clock_of(s), error);
    s->loop.platform.trajectory = driven(s);
    return status;
}

/* Prints a message for the operator. Any thread may call it. */
static void say(void *context, const char *text) {
    struct session *s = context;
    progress_say(&s->progress, "hexid: %s\n", text);
}

/* SAFETY: parks the platform if the recorder hangs, before records are lost. It hangs if the log
 * stalls without an error (a sleeping reader of a pipe, a hanging disk) or the host is busy. */
static void watch_recorder(struct session *s) {
    double behind_s = (double)ring_count(&s->ring) * s->params.loop.period_s;
    if (s->options.fast || s->behind.status || behind_s < RECORDER_BEHIND_S) return;
    loop_quit(&s->loop);
    if (s->options.log)
        error_set(&s->behind, STATUS_IO, "%.300s took no more for %g s: look at its disk, its reader and the load of this host",
                  s->options.log, RECORDER_BEHIND_S);
    else error_set(&s->behind, STATUS_IO, "the recorder was not given the processor for %g s: free this host", RECORDER_BEHIND_S);
    progress_say(&s->progress, "hexid: %s: parking\n", s->behind.text);
}

/* SAFETY: handles commands until the loop ends. Nothing between a command and the loop's mailbox
 * can block, and another thread handles signals. */
static void wait_for_end(struct session *s) {
    struct pollfd p[COMMANDS_POLLS];
    commands_begin(&s->commands, &s->params, &s->loop, say, s);
    while (!atomic_load_explicit(&s->loop.ended, memory_order_acquire)) {
        commands_polls(&s->commands, p);
        loop_attend(&s->loop, false);
        poll_any(p, COMMANDS_POLLS, s->options.fast ? 2 : commands_patience_ms(&s->commands), NULL);
        loop_attend(&s->loop, true);
        commands_serve(&s->commands, p, monotonic_ns());
        watch_recorder(s);
        machine_lock_answer(&s->lock);
    }
    commands_end(&s->commands);
}

static int write_result(struct session *s, const struct verdicts *verdicts, struct error *error) {
    char *json = analysis_json(&s->recorder.analysis, verdicts);
    return output_made(&s->json, s->survey ? survey_report_json(s->survey, json) : json, error);
}

static void survey_step(void *context, const char *what, double share) {
    struct session *s = context;
    progress_compute(&s->progress, what, share);
}

static int report_survey(struct session *s, struct verdict *verdict, struct error *error) {
    const struct analysis *a = &s->recorder.analysis;
    struct error none = {0};
    int status = survey_report_make(s->survey, &s->multisine, &a->recording, &a->ident.result.method_c, &s->asked,
                                    s->options.std_pct > 0.0 ? s->options.std_pct : STD_PCT,
                                    &(struct survey_watch){.step = survey_step, .context = s}, &none);
    progress_end(&s->progress);
    if (status) verdict_add(verdict, VERDICT_NOT_EVALUATED, "%.110s", none.text);
    else if (!s->survey->survey.determined) verdict_add(verdict, VERDICT_NOT_EVALUATED, "survey: no eigenfrequency is determined");
    if (status) free(s->survey), s->survey = NULL;
    if (status == STATUS_IO) *error = none;
    return status == STATUS_IO ? status : STATUS_OK;
}

/* Returns true if SIGTERM was the regular end of this run. A run without motion.automatic never
 * ends by itself; a service manager ends it with SIGTERM, which is regular if the platform is
 * parked without a fault. */
static bool ended_by_order(const struct session *s) {
    const struct cycle *last = &s->recorder.analysis.last;
    return atomic_load(&s->signals.first) == SIGTERM && !s->params.motion.automatic && last->state == STATE_SETTLED && !last->first_fault;
}

/* Tells the user which option or command prints the whole result. */
static void say_whole(const struct session *s) {
    if (s->options.verbose) return;
    if (!s->options.log) cli_say(s->progress.out, "whole     --verbose prints it; with a log, hexid identify does");
    else if (s->recorder.part > 1) cli_say(s->progress.out, "whole     --verbose prints it; of each part, hexid identify does");
    else cli_say(s->progress.out, "whole     hexid %s %s", s->options.qualify ? "qualify" : "identify", s->options.log);
}

static int report(struct session *s, struct error *error) {
    struct analysis *a = &s->recorder.analysis;
    analysis_identify(a);
    struct verdicts verdicts = analysis_verdicts(a);
    progress_end(&s->progress);
    if (atomic_load(&s->signals.first)) verdict_add(&verdicts.run, VERDICT_NOT_EVALUATED, "interrupted");
    int status = s->survey ? report_survey(s, &verdicts.run, error) : STATUS_OK;
    if (status) return status;
    if (s->survey) survey_report_print(s->survey, s->progress.out);
    analysis_print(a, &verdicts, !s->options.verbose, s->progress.out);
    char trouble[200] = "";
    if (s->hal->ops->describe) s->hal->ops->describe(s->hal, trouble, sizeof trouble);
    if (*trouble) cli_say(s->progress.out, "device    %s: %s", s->options.hal, trouble);
    const char *log = s->options.log ? s->options.log : "none kept (--log FILE keeps one)";
    if (s->recorder.part > 1) cli_say(s->progress.out, "log       %s to %s, %d parts", log, s->recorder.part_path, s->recorder.part);
    else cli_say(s->progress.out, "log       %s", log);
    say_whole(s);
    outlet_flush(&s->progress.steps);
    status = write_result(s, &verdicts, error);
    return status ? status : verdicts.run.status == VERDICT_PASS || ended_by_order(s) ? EXIT_PASSED : EXIT_CHECK_FAILED;
}

/* Waits for the recorder, closes the log and reports the result. If the recorder hangs, its thread
 * keeps running, and the run ends with an error and without a result. */
static int finish(struct session *s, struct error *error) {
    struct error closing = {0};
    s->stuck = !recorder_join(&s->recorder);
    if (s->stuck)
        return error_set(error, STATUS_IO, "%s: takes no more: %llu records of the end are not in it",
                         s->options.log ? s->options.log : "the recorder", (unsigned long long)ring_count(&s->ring));
    if (s->log && log_check(s->log, &closing) && !s->recorder.error.status) s->recorder.error = closing;
    if (s->log) s->recorder.analysis.unlogged = log_lost(s->log);
    if (s->log && log_close(s->log, &closing) && !s->recorder.error.status) s->recorder.error = closing;
    s->log = NULL;
    /* nothing is driven any more and the log is closed, so from here on signals may end the
     * process */
    signals_release(&s->signals);
    int reported = report(s, error), refused = atomic_load(&s->signals.refused);
    struct error deaf = {0};
    if (refused) error_set(&deaf, STATUS_IO, "signals cannot be taken: %s", strerror(refused));
    const struct error *ends[] = {&s->recorder.error, &s->recorder.keeper_error, &s->behind, &s->recorder.unattended, &deaf};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
        if (!ends[i]->status) continue;
        *error = *ends[i];
        return error->status;
    }
    return reported;
}

/* SAFETY: reports inputs that are not wired, because somebody must decide to run without them. */
static void warn_of_missing_inputs(struct session *s) {
    char wiring[200];
    if (!interlock_describe(&s->params.interlocks, wiring, sizeof wiring)) progress_say(&s->progress, "hexid: interlocks: %s\n", wiring);
}

/* SAFETY: warns of weaknesses with the texts of `hexid doctor`. Before the machine is opened it
 * warns only of singular poses, in which the legs do not hold the platform, because check_poles()
 * may refuse the loop on account of them. The other warnings follow once the machine is open. */
static void warn_of_machine(const struct session *s, bool opened) {
    static const struct {
        const char *name;
        doctor_check *ask;
        bool opened;
    } checks[] = {{"workspace", check_workspace, false},      {"loop", check_loop, true},     {"gains", check_gains, true},
                  {"feed-forward", check_feed_forward, true}, {"limits", check_limits, true}, {"moves", check_moves, true}};
    const struct doctor d = {.params = &s->params, .machine = on_bus(s), .loop = &s->poles, .gains = &s->gains};
    for (size_t i = 0; i < sizeof checks / sizeof *checks; i++) {
        if (checks[i].opened != opened) continue;
        struct finding f = checks[i].ask(&d);
        if (f.level == LEVEL_WARN) fprintf(stderr, "hexid: warning: %s: %s: %s\n", checks[i].name, f.found, f.remedy);
        json_decref(f.data);
    }
}

/* SAFETY: refuses an unstable loop, which endangers people on the platform, and on a simulated
 * machine also a loop that turns sensor noise into motion; no key overrides this check. Without
 * valid kinematics there is no loop to check, and check_motion() reports the reason. */
static int check_poles(struct session *s, struct error *error) {
    struct kinematics k;
    struct error unheard;
    if (params_mechanism(&s->params)->refuses.run || kinematics_init(&k, &s->params, &unheard)) return STATUS_OK;
    warn_of_machine(s, false);
    s->poles = loop_check(&s->params, on_bus(s));
    s->gains = gains_check(&s->params, on_bus(s));
    int status = loop_check_run(&s->poles, on_bus(s), error);
    size_t used = status ? strlen(error->text) : 0;
    if (status && *s->gains.remedy)
        snprintf(error->text + used, sizeof error->text - used, "; or, as `hexid tune` gives for this machine: %s", s->gains.remedy);
    return status;
}

/* Warns if two axes of a multisine have the same frequency, because the responses to these axes
 * then cannot be told apart. */
static void warn_of_axes_alike(const struct test_params *t) {
    for (int i = 0; i < t->count && t->multisine; i++)
        for (int j = 0; j < i; j++) {
            if (t->hz[t->order[i]] != t->hz[t->order[j]]) continue;
            fprintf(stderr,
                    "hexid: warning: tests.multisine: %s and %s both move at %g Hz, so that nothing tells them apart: give each axis a "
                    "frequency of its own, as in tests.frequency_hz=2.1,2.7,3.3,3.9,4.5,5.1\n",
                    dof_names[t->order[j]], dof_names[t->order[i]], t->hz[t->order[i]]);
            return;
        }
}

/* SAFETY: confines the daemon. If confinement fails, the platform is parked and the run ends,
 * because nobody allowed it to run unconfined. */
static int confine_all(struct session *s, struct error *error) {
    const struct confinement all = {.result = &s->json, .reopens = s->hal->ops->reopens};
    int status = s->params.security.confine ? confine(&all, error) : STATUS_OK;
    if (!s->params.security.confine)
        progress_say(&s->progress, "hexid: warning: security.confine is off: the daemon keeps all its rights\n");
    if (status) loop_quit(&s->loop);
    return status;
}

static int run(struct session *s, struct error *error) {
    bool results_on_stdout = s->options.json && !strcmp(s->options.json, "-");
    signals_block(&s->signals);
    if (progress_open(&s->progress, &s->params, results_on_stdout ? STDERR_FILENO : STDOUT_FILENO, s->options.fast))
        return error_set(error, STATUS_IO, "no pipe to the terminal: %s", strerror(errno));
    int status = signals_start(&s->signals, &s->loop, realtime_of(s) != REALTIME_OFF, say, s, error);
    if (status) return status;
    crash_guard(s->hal, &s->loop.abort);
    s->recorder = (struct recorder){.params = &s->params,
                                    .loop = &s->loop,
                                    .records = &s->ring,
                                    .log = s->log,
                                    .bus = s->bus,
                                    .progress = &s->progress,
                                    .loop_says = s->gains.remedy};
    if (s->keeper.socket >= 0) s->recorder.keeper = &s->keeper, s->recorder.part_bytes = (int64_t)s->options.log_part_bytes;
    if (notify_open(&s->recorder.notify, error)) warn(error);
    warn_of_missing_inputs(s);
    status = recorder_start(&s->recorder, s->config, error);
    if (status) return status;
    loop_attend(&s->loop, false);
    status = loop_start(&s->loop, realtime_of(s), error);
    if (status) {
        s->stuck = !recorder_join(&s->recorder);
        return status;
    }
    if (s->loop.realtime) progress_say(&s->progress, "hexid: warning: %s\n", s->loop.realtime_error.text);
    if (realtime_of(s) != REALTIME_OFF) realtime_follow(&s->params.loop, STOP_PATH_BELOW_LOOP);
    struct error refused = {0};
    confine_all(s, &refused);
    wait_for_end(s);
    loop_join(&s->loop);
    realtime_leave();
    status = finish(s, error);
    if (refused.status) *error = refused;
    return refused.status ? (int)refused.status : status;
}

/* SAFETY: closes the back-end even if a thread hangs; in that case it then ends the process,
 * otherwise it frees everything and returns the exit status. */
static int close_all(struct session *s, int status, const struct error *error) {
    struct error ignored;
    signals_mute(&s->signals);
    bool quiet = !s->progress.out || progress_close(&s->progress);
    if (s->hal) s->hal->ops->close(s->hal);
    if (status < 0) status = cli_fail(error);
    /* a thread that hangs at a terminal or a disk still uses this memory, so it is not freed */
    if (!quiet || s->stuck) _exit(status);
    signals_release(&s->signals);
    notify_close(&s->recorder.notify);
    log_keeper_stop(&s->keeper);
    commands_end(&s->commands);
    if (s->bus) bus_close(s->bus);
    if (s->log) log_close(s->log, &ignored);
    analysis_free(&s->recorder.analysis);
    ring_free(&s->ring);
    trajectory_free(&s->trajectory);
    free(s->config);
    free(s->recorder.changed);
    free(s->survey);
    free(s);
    return status;
}

int cmd_run(int argc, char **argv) {
    realtime_heap();
    struct session *s = calloc(1, sizeof *s);
    struct error error = {0};
    if (!s) return -STATUS_IO;
    s->recorder.notify.socket = s->keeper.socket = -1; /* -1 marks the sockets as not open; 0 would
                                                        * be standard input */
    commands_init(&s->commands);
    int status = options_parse(&s->options, argc, argv, "cHfrslqgjStTnpVQdB", 0, &error);
    if (!status) status = options_params(&s->options, &s->params, &error);
    if (!status && !s->options.print_config) status = outputs_open(&s->options, &s->params, OUTPUTS_LOG, &s->json, NULL, &error);
    if (!status && !s->options.print_config) status = check_poles(s, &error);
    if (!status && !s->options.print_config) status = check_motion(s, &error);
    if (!status && s->options.print_config) {
        char *text = config_text(&s->params);
        status = output_text("-", text, &error);
        free(text);
    } else if (!status) {
        warn_of_axes_alike(&s->params.tests);
        status = open_all(s, &error);
        if (!status) warn_of_machine(s, true);
        if (!status) status = run(s, &error);
    }
    return close_all(s, status, &error);
}
