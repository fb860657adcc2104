#include "command_set.h"

#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "config.h"
#include "gains.h"
#include "loop_check.h"
#include "loop_places.h"
#include "params.h"
#include "process.h"

/* Waits for the daemon's answer. unsent: result of sending the request. Returns 0, or -3 without an
 * answer. */
static int wait_for_answer(struct command_client *c, int unsent, struct error *error) {
    enum command_news news = unsent ? NEWS_LOST : command_client_wait(c, ANSWER_MS, NULL);
    if (news == NEWS_ANSWER) return STATUS_OK;
    int status = report_silent(c, news, false, " Whether the gains were changed is not known: ask `hexid command set`.", error);
    return status ? status : error_set(error, STATUS_IO, "command set: the daemon has ended");
}

static int refused(const struct command_client *c) {
    cli_say(stderr, "hexid: set refused, state %s: %s", state_names[c->answer.state], c->answer.text);
    return STATUS_UNSAFE;
}

/* Asks the daemon for its gains, and puts them into params. *bus: gets true if the machine is on a
 * field bus. */
static int ask_gains(struct command_client *c, struct params *params, bool *bus, struct error *error) {
    char text[COMMAND_TEXT_SIZE], *rest;
    const char *setting[LOOP_GAINS];
    int count = 0, status = wait_for_answer(c, command_client_send(c, COMMAND_SET, false), error);
    if (status) return status;
    if (c->answer.outcome != OUTCOME_DONE) return refused(c);
    memcpy(text, c->answer.text, sizeof text);
    const char *place = strtok_r(text, " ", &rest);
    *bus = place && !strcmp(place, "bus");
    while (count < LOOP_GAINS && (setting[count] = strtok_r(NULL, " ", &rest))) count++;
    if (count < LOOP_GAINS) return error_set(error, STATUS_IO, "command set: %.100s did not say its gains", c->machine.name);
    return config_override(params, "the daemon's gains", setting, count, error);
}

/* Returns true if the setting is "control.kp=..." or that of another gain. */
static bool is_gain(const char *setting) {
    for (int i = 0; i < LOOP_GAINS; i++)
        if (!strncmp(setting, gain_keys[i], strlen(gain_keys[i])) && setting[strlen(gain_keys[i])] == '=') return true;
    return false;
}

/* Returns true if kff is too large for the valves, or the following error that an unsuitable kff
 * causes in the fastest motion is above LOOP_FOLLOWING_SHARE of limits.following_m. */
static bool runs_off(const struct loop_check *loop, const struct params *p) {
    return p->control.kff > LOOP_FEED_FORWARD_MOST * loop->kff_suits ||
           loop_check_off_m(loop, p) > LOOP_FOLLOWING_SHARE * p->limits.following_m;
}

/* Returns why gains with the check result `c` are refused: the loop cannot be computed, runs_off()
 * is true, or the loop is unstable in some pose or turns the sensors' noise into motion. Returns
 * NULL if the gains are accepted. A weakly damped loop is accepted, and on a field bus, whose
 * sensors are not known, also a noisy loop; `text` then describes the weakness. */
static const char *why_refused(const struct loop_check *c, const struct params *p, bool bus, char text[LOOP_TEXT_SIZE]) {
    char remedy[LOOP_TEXT_SIZE];
    if (c->state == LOOP_UNKNOWN) return "the loop cannot be computed";
    if (runs_off(c, p)) {
        snprintf(text, LOOP_TEXT_SIZE, "a leg would be up to %.2g mm off in motion, limits.following_m is %g mm, and kff %.3g suits",
                 loop_check_off_m(c, p) * 1e3, p->limits.following_m * 1e3, c->kff_suits);
        return text;
    }
    bool bearable = c->state == LOOP_WEAK || (c->state == LOOP_NOISY && bus);
    if (bearable && c->away_grows) return "the loop would be unstable in another pose";
    loop_check_describe(c, text, remedy);
    return c->state == LOOP_DAMPED || bearable ? NULL : text;
}

/* Returns true if the gains of `then` (check result `next`) are no worse than those of `p` (check
 * result `now`) in anything for which gains are refused. NaN counts as worse. Noise is not compared
 * if the present loop is unstable, because its noise has no finite value. */
static bool is_no_worse(const struct loop_check *next, const struct params *then, const struct loop_check *now, const struct params *p) {
    return loop_pole_damping(&next->neutral.pole) >= loop_pole_damping(&now->neutral.pole) &&
           loop_pole_damping(&next->away.pole) >= loop_pole_damping(&now->away.pole) &&
           (loop_grows(&now->neutral) || now->away_grows || next->noise_mps2 <= now->noise_mps2) &&
           loop_check_off_m(next, then) <= loop_check_off_m(now, p);
}

/* SAFETY: refuses gains for the reasons of why_refused(). If the present gains would be refused,
 * too, new gains that are no worse only cause a warning, because one change of a gain may be too
 * small to correct the loop. */
static int check_loop_of(const struct params *now, const struct params *next, bool bus, const char *setting) {
    struct loop_check after = loop_check(next, bus);
    char text[LOOP_TEXT_SIZE] = "", unsaid[LOOP_TEXT_SIZE];
    const char *why = why_refused(&after, next, bus, text);
    if (!why && after.state == LOOP_DAMPED) return STATUS_OK;
    if (why) {
        struct loop_check before = loop_check(now, bus);
        if (!why_refused(&before, now, bus, unsaid) || !is_no_worse(&after, next, &before, now)) {
            cli_say(stderr, "hexid: set refused: with %s %s", setting, why);
            return STATUS_UNSAFE;
        }
    }
    cli_say(stderr, "hexid: warning: with %s: %s", setting, why ? why : text);
    return STATUS_OK;
}

static int change(struct command_client *c, const struct params *now, struct params *next, const char *setting, bool bus,
                  struct error *error) {
    struct gain_change gains = {.digest = config_digest(now), .from = gains_of(&now->control)};
    *next = *now;
    int status = config_override(next, "the daemon's gains", &setting, 1, error);
    if (!status) status = check_loop_of(now, next, bus, setting);
    if (status) return status;
    gains.to = gains_of(&next->control);
    status = wait_for_answer(c, command_client_send_gains(c, &gains), error);
    if (status) return status;
    if (c->answer.outcome != OUTCOME_DONE) return refused(c);
    cli_say(stdout, "hexid: set done, now %s: %s", state_names[c->answer.state],
            strchr(c->answer.text, ' ') ? strchr(c->answer.text, ' ') + 1 : "");
    return STATUS_OK;
}

/* The check of the loop needs more stack than a stop does. So the process's limits are checked
 * here, because main() does not check them for `hexid command`. */
int command_set(struct command_client *c, const struct params *params, const char *setting, struct error *error) {
    int status = process_limits(error);
    if (status) return status;
    struct params *now = malloc(2 * sizeof *now);
    bool bus;
    if (!now) return error_set(error, STATUS_IO, "command set: out of memory");
    *now = *params;
    status = ask_gains(c, now, &bus, error);
    if (!status && !setting) cli_say(stdout, "hexid: set done, now %s: %s", state_names[c->answer.state], strchr(c->answer.text, ' ') + 1);
    else if (!status) status = change(c, now, now + 1, setting, bus, error);
    free(now);
    return status;
}

int command_set_check(const char *setting, struct error *error) {
    if (!setting || is_gain(setting)) return STATUS_OK;
    return error_set(error, STATUS_USAGE,
                     "command set %.100s: not KEY=VALUE with KEY one of control.kp, ki, kd, kff, kpf; other keys are set in the "
                     "configuration, for the next start",
                     setting);
}
