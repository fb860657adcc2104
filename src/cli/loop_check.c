#include "loop_check.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kinematics.h"
#include "loop_places.h"
#include "loop_tune.h"
#include "modal.h"
#include "number_text.h"
#include "params.h"
#include "units.h"

/* Damping ratios that the loop must reach with a proposed gain, at neutral and in all other poses.
 * If no gain reaches the first pair, the next is tried. The shipped machines reach the first
 * pair. */
static const struct wanted {
    double neutral, away;
} wanted[] = {{0.1, 0.03}, {0.07, 0.03}, {0.03, -1.0}}; /* -1: the other poses are not judged */
enum { WANTED = sizeof wanted / sizeof *wanted };
enum { STEPS_PER_DECADE = 20, DECADES = 4 };

static double damping_of(const struct loop_worst *w) { return w->known ? loop_pole_damping(&w->pole) : -1.0; }

/* Returns the least damped pole in all poses except neutral. pose: gets the pose of that pole, or
 * stays if neutral is the only pose; NULL: it is not needed. */
static struct loop_worst worst_away(const struct loop_places *all, const struct params *p, const double **pose) {
    struct loop_worst worst = {0};
    for (int i = 1; i < all->count; i++) {
        struct loop_worst here = loop_place_worst(&all->place[i], p);
        if (i > 1 && damping_of(&here) >= damping_of(&worst)) continue;
        worst = here;
        if (pose) *pose = all->place[i].pose;
    }
    return worst;
}

/* Rounds a gain to two significant digits, as a person would set it. */
static double rounded(double x) {
    char text[16];
    snprintf(text, sizeof text, "%.1e", x);
    return strtod(text, NULL);
}

static const char *const gain_names[] = {"control.kp", "control.kpf", "control.kd", "control.ki"};
enum { GAINS = sizeof gain_names / sizeof *gain_names };

static double *gain_of(struct control_params *g, int i) {
    double *const gains[GAINS] = {&g->kp, &g->kpf, &g->kd, &g->ki};
    return gains[i];
}

static bool suits(const struct loop_places *all, const struct params *p, const struct wanted *w, double *damping) {
    struct loop_worst neutral = loop_place_worst(&all->place[0], p);
    *damping = damping_of(&neutral);
    if (!(*damping >= w->neutral)) return false;
    if (loop_places_noise_mps2(all, p) > loop_noise_most_mps2(p)) return false;
    struct loop_worst away = worst_away(all, p, NULL);
    return all->count == 1 || damping_of(&away) >= w->away;
}

/* Finds the smallest change of one gain with which suits() is true. Returns its size in logarithmic
 * steps, or 0 if there is none. An increase counts double, so that a gain is raised only if
 * lowering it would take more than twice as many steps. */
static int find_change(const struct loop_places *all, const struct params *p, int gain, const struct wanted *w, double *value,
                       double *damping) {
    struct params tried = *p;
    double now = *gain_of(&tried.control, gain);
    for (int step = 1; now > 0.0 && step <= DECADES * STEPS_PER_DECADE; step++)
        for (int raise = 0; raise <= (step % 2 == 0); raise++) {
            double steps = raise ? 0.5 * step : -step;
            *value = rounded(now * pow(10.0, steps / STEPS_PER_DECADE));
            *gain_of(&tried.control, gain) = *value;
            if (suits(all, &tried, w, damping)) return step;
        }
    return 0;
}

/* Finds the largest exponent control.modal below the configured one with which suits() is true. A
 * smaller exponent lowers only the gains of the fast modes, so it is tried before kp, kpf, kd and
 * ki, which act on all modes. */
static bool lower_modal(const struct loop_places *all, const struct params *p, const struct wanted *w, struct loop_check *c) {
    struct loop_places lowered = *all;
    struct params tried = *p;
    struct kinematics k;
    struct modal modal;
    kinematics_place(&k, p);
    for (int tenths = (int)ceil(10.0 * p->control.modal) - 1; tenths >= 0; tenths--) {
        tried.control.modal = tenths / 10.0;
        if (modal_init(&modal, &tried, &k, &(struct error){0})) return false;
        for (int i = 0; i < all->count; i++) loop_place_weigh(&lowered.place[i], &modal);
        if (!suits(&lowered, &tried, w, &c->damping)) continue;
        c->key = "control.modal", c->now = p->control.modal, c->suits = tried.control.modal;
        return true;
    }
    return false;
}

static void find_remedy(const struct loop_places *all, const struct params *p, struct loop_check *c) {
    struct control_params now = p->control;
    for (int w = 0; w < WANTED && !c->key; w++) {
        int nearest = 0;
        if (lower_modal(all, p, &wanted[w], c)) return;
        for (int i = 0; i < GAINS; i++) {
            double value, damping;
            int steps = find_change(all, p, i, &wanted[w], &value, &damping);
            if (!steps || (nearest && steps >= nearest)) continue;
            nearest = steps;
            c->key = gain_names[i], c->now = *gain_of(&now, i), c->suits = value, c->damping = damping;
        }
    }
}

/* Finds the kff that matches the valves. It uses the mean speed of both directions, because a leg
 * extends as far as it retracts. */
static void find_feed_forward(const struct loop_place *neutral, struct loop_check *c) {
    for (int i = 0; i < LEGS; i++) c->out_mps += neutral->out_mps[i] / LEGS, c->in_mps += neutral->in_mps[i] / LEGS;
    c->kff_suits = 2.0 / (c->out_mps + c->in_mps);
}

struct loop_check loop_check(const struct params *params, bool bus) {
    struct loop_check c = {.state = LOOP_UNKNOWN};
    struct loop_places all;
    const double *pose = NULL;
    if (!loop_places_find(&all, params, bus)) return c;
    find_feed_forward(&all.place[0], &c);
    c.neutral = loop_place_worst(&all.place[0], params);
    c.away = worst_away(&all, params, &pose);
    if (pose) memcpy(c.away_pose, pose, sizeof c.away_pose);
    double damping = damping_of(&c.neutral);
    c.away_grows = pose && loop_grows(&c.away);
    c.noise_most_mps2 = loop_noise_most_mps2(params);
    if (!loop_grows(&c.neutral)) c.noise_mps2 = loop_places_noise_mps2(&all, params);
    c.state = loop_grows(&c.neutral)             ? LOOP_UNSTABLE
              : c.noise_mps2 > c.noise_most_mps2 ? LOOP_NOISY
              : damping < LOOP_DAMPING_LEAST     ? LOOP_WEAK
              : c.away_grows                     ? LOOP_UNSTABLE_AWAY
                                                 : LOOP_DAMPED;
    if (c.state != LOOP_DAMPED) find_remedy(&all, params, &c);
    return c;
}

double loop_check_off_m(const struct loop_check *c, const struct params *p) {
    return p->control.kp > 0.0 ? fabs(c->kff_suits - p->control.kff) * loop_fastest_mps(p) / p->control.kp : 0.0;
}

/* Describes a mode: "z at 12.3 Hz, damping -0.02". A real pole has no frequency: "z settles,
 * shrinking by a factor of 3.1 each second". */
static int describe_mode(const struct loop_worst *w, char *text, size_t size) {
    if (!w->known) return snprintf(text, size, "its numbers are beyond computing");
    if (w->pole.radps > 0.0)
        return snprintf(text, size, "%s at %.3g Hz, damping %.2g", dof_names[w->dof], loop_pole_hz(&w->pole), loop_pole_damping(&w->pole));
    bool grows = w->pole.decay_per_s < 0.0;
    return snprintf(text, size, "%s %s by a factor of %.2g each second", dof_names[w->dof],
                    grows ? "runs away, growing" : "settles, shrinking", exp(fabs(w->pole.decay_per_s)));
}

static void describe_pose(const double pose[DOFS], char text[40]) {
    for (int i = 0; i < DOFS; i++)
        if (pose[i] != 0.0) snprintf(text, 40, "%s %.3g %s", dof_names[i], pose[i], i < DOF_PHI ? "m" : "rad");
}

static void describe_away(const struct loop_check *c, char *text, size_t size) {
    char pose[40] = "neutral", mode[80];
    describe_pose(c->away_pose, pose);
    describe_mode(&c->away, mode, sizeof mode);
    snprintf(text, size, "at %s%s: %s", pose, loop_grows(&c->away) ? " it is unstable and shakes" : "", mode);
}

void loop_check_describe(const struct loop_check *c, char found[LOOP_TEXT_SIZE], char remedy[LOOP_TEXT_SIZE]) {
    static const char *const states[] = {[LOOP_DAMPED] = "least damped",
                                         [LOOP_UNSTABLE_AWAY] = "least damped",
                                         [LOOP_WEAK] = "the closed loop is hardly damped",
                                         [LOOP_UNSTABLE] = "the closed loop is unstable"};
    char neutral[80], away[140], suits[NUMBER_SIZE], now[NUMBER_SIZE];
    *remedy = '\0';
    if (c->state == LOOP_UNKNOWN) {
        snprintf(found, LOOP_TEXT_SIZE, "not computed: the supply does not hold the platform up at neutral");
        return;
    }
    describe_mode(&c->neutral, neutral, sizeof neutral);
    describe_away(c, away, sizeof away);
    if (c->state == LOOP_NOISY)
        snprintf(found, LOOP_TEXT_SIZE,
                 "the gains make the sensors' noise shake the platform with %.2g m/s^2 rms on its way to neutral (%.2g are borne, %.2g of "
                 "limits.oscillation_mps2); least damped at neutral: %s",
                 c->noise_mps2, c->noise_most_mps2, LOOP_NOISE_MOST, neutral);
    else
        snprintf(found, LOOP_TEXT_SIZE, "%s at neutral: %s%s%s", states[c->state], neutral, c->state == LOOP_UNSTABLE ? "" : "; ",
                 c->state == LOOP_UNSTABLE ? "" : away);
    if (c->state == LOOP_DAMPED) return;
    if (c->key)
        snprintf(remedy, LOOP_TEXT_SIZE, "set %s to %s (now %s): the damping at neutral is then %.2g", c->key,
                 number_shortest(c->suits, suits), number_shortest(c->now, now), c->damping);
    else
        snprintf(remedy, LOOP_TEXT_SIZE,
                 "no single gain puts it right: `hexid tune` finds all of them; compare payload, actuator and hydraulics with the machine");
}

bool loop_check_refuses(const struct loop_check *c, bool bus) { return c->state == LOOP_UNSTABLE || (c->state == LOOP_NOISY && !bus); }

int loop_check_run(const struct loop_check *c, bool bus, struct error *error) {
    char found[LOOP_TEXT_SIZE], remedy[LOOP_TEXT_SIZE];
    if (!loop_check_refuses(c, bus)) return STATUS_OK;
    loop_check_describe(c, found, remedy);
    return error_set(error, STATUS_USAGE, "not run: %s; %s", found, remedy);
}
