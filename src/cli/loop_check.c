#include "loop_check.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kinematics.h"
#include "number_text.h"
#include "params.h"
#include "units.h"

/* Damping ratios that a proposed gain must reach, at neutral and in all other poses. They are tried
 * in this order; the first are those of the shipped machines. */
static const struct wanted {
    double neutral, away;
} wanted[] = {{0.1, 0.03}, {0.07, 0.03}, {0.03, -1.0}}; /* -1: the other poses are not judged */
enum { WANTED = sizeof wanted / sizeof *wanted };
static const double TRIED = 0.8;           /* share of the path from neutral to the nearest end of a
                                            * stroke at which poses are checked */
static const double SEARCH = 10.0;         /* m or rad; limit of the search for a pose at a stroke's
                                            * end, longer than any stroke */
enum { WAY = 8, PLACES = 1 + WAY + 2 * DOFS, HALVINGS = 30, STEPS_PER_DECADE = 20, DECADES = 4 };

/* Models of the loop in all poses where the machine may be held: at neutral, on the way down to
 * parking, and at the ends of the strokes. */
struct places {
    int count;
    int way;             /* number of places at the beginning that are neutral or on the way down */
    struct loop_place place[PLACES];
};

/* True if every leg is within TRIED of the path from neutral to either end of its stroke. */
static bool within(const struct kinematics *k, const struct params *p, const double pose[DOFS]) {
    double length_m[LEGS];
    ik_lengths(k, pose, length_m);
    for (int i = 0; i < LEGS; i++) {
        struct stroke s = kinematics_stroke(k, &p->actuator, i);
        double neutral = k->neutral_length_m[i], way = length_m[i] - neutral;
        if (!(way <= TRIED * (s.most_m - neutral) && way >= TRIED * (s.least_m - neutral))) return false;
    }
    return true;
}

static double farthest(const struct kinematics *k, const struct params *p, int dof, double sense) {
    double low = 0.0, high = SEARCH;
    for (int i = 0; i < HALVINGS; i++) {
        double middle = 0.5 * (low + high), pose[DOFS] = {0};
        pose[dof] = sense * middle;
        if (within(k, p, pose)) low = middle;
        else high = middle;
    }
    return sense * low;
}

static void add(struct places *all, const struct params *p, int dof, double value, double delay_s) {
    double pose[DOFS] = {0};
    pose[dof] = value;
    if (loop_place_find(&all->place[all->count], p, pose, delay_s)) all->count++;
}

/* Finds the poses to be checked. Returns false if the supply cannot hold the platform up at
 * neutral. */
static bool find_places(struct places *all, const struct params *p, bool bus) {
    struct kinematics k;
    double delay_s = bus ? p->loop.period_s : 0.0;
    all->count = 0;
    kinematics_place(&k, p);
    add(all, p, DOF_Z, 0.0, delay_s);
    if (!all->count) return false;
    for (int i = 1; i <= WAY; i++) add(all, p, DOF_Z, p->motion.park_z_m * i / WAY, delay_s);
    all->way = all->count;
    for (int dof = 0; dof < DOFS; dof++)
        for (int sense = -1; sense <= 1; sense += 2) add(all, p, dof, farthest(&k, p, dof, sense), delay_s);
    return true;
}

static bool loop_grows(const struct loop_worst *w) { return !w->known || !(w->pole.decay_per_s > 0.0); }

static double damping_of(const struct loop_worst *w) { return w->known ? loop_pole_damping(&w->pole) : -1.0; }

/* Returns the least damping in all poses except neutral. */
static struct loop_worst worst_away(const struct places *all, const struct params *p, const double **pose) {
    struct loop_worst worst = {0};
    for (int i = 1; i < all->count; i++) {
        struct loop_worst here = loop_place_worst(&all->place[i], p);
        if (i > 1 && damping_of(&here) >= damping_of(&worst)) continue;
        worst = here;
        if (pose) *pose = all->place[i].pose;
    }
    return worst;
}

/* Rounds to two digits, as a person would set it. */
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

/* Returns the largest shaking by noise at neutral and on the way there, where the oil may be
 * stiffer and the loop less damped than at neutral. Unstable poses are left out. */
static double worst_noise_mps2(const struct places *all, const struct params *p) {
    double worst_mps2 = 0.0;
    for (int i = 0; i < all->way; i++) {
        struct loop_worst here = loop_place_worst(&all->place[i], p);
        if (!loop_grows(&here)) worst_mps2 = fmax(worst_mps2, loop_place_noise_mps2(&all->place[i], p));
    }
    return worst_mps2;
}

static double noise_most_mps2(const struct params *p) { return LOOP_NOISE_MOST * p->limits.oscillation_mps2; }

static bool suits(const struct places *all, const struct params *p, const struct wanted *w, double *damping) {
    struct loop_worst neutral = loop_place_worst(&all->place[0], p);
    *damping = damping_of(&neutral);
    if (!(*damping >= w->neutral)) return false;
    if (worst_noise_mps2(all, p) > noise_most_mps2(p)) return false;
    struct loop_worst away = worst_away(all, p, NULL);
    return all->count == 1 || damping_of(&away) >= w->away;
}

/* Finds the smallest suitable change of one gain. Returns its size in logarithmic steps;
 * increases count double, so a gain is raised only if lowering would need a much larger change.
 * 0: none. */
static int find_change(const struct places *all, const struct params *p, int gain, const struct wanted *w, double *value, double *damping) {
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

static void find_remedy(const struct places *all, const struct params *p, struct loop_check *c) {
    struct control_params now = p->control;
    for (int w = 0; w < WANTED && !c->key; w++) {
        int nearest = 0;
        for (int i = 0; i < GAINS; i++) {
            double value, damping;
            int steps = find_change(all, p, i, &wanted[w], &value, &damping);
            if (!steps || (nearest && steps >= nearest)) continue;
            nearest = steps;
            c->key = gain_names[i], c->now = *gain_of(&now, i), c->suits = value, c->damping = damping;
        }
    }
}

/* Finds kff for the valves' speeds. It uses the mean of both directions, because a leg moves out as
 * far as in. */
static void find_feed_forward(const struct loop_place *neutral, struct loop_check *c) {
    for (int i = 0; i < LEGS; i++) c->out_mps += neutral->out_mps[i] / LEGS, c->in_mps += neutral->in_mps[i] / LEGS;
    c->kff_suits = 2.0 / (c->out_mps + c->in_mps);
}

struct loop_check loop_check(const struct params *params, bool bus) {
    struct loop_check c = {.state = LOOP_UNKNOWN};
    struct places all;
    const double *pose = NULL;
    if (!find_places(&all, params, bus)) return c;
    find_feed_forward(&all.place[0], &c);
    c.neutral = loop_place_worst(&all.place[0], params);
    c.away = worst_away(&all, params, &pose);
    if (pose) memcpy(c.away_pose, pose, sizeof c.away_pose);
    double damping = damping_of(&c.neutral);
    bool away = pose && loop_grows(&c.away);
    c.noise_most_mps2 = noise_most_mps2(params);
    if (!loop_grows(&c.neutral)) c.noise_mps2 = worst_noise_mps2(&all, params);
    c.state = loop_grows(&c.neutral)             ? LOOP_UNSTABLE
              : c.noise_mps2 > c.noise_most_mps2 ? LOOP_NOISY
              : damping < LOOP_DAMPING_LEAST     ? LOOP_WEAK
              : away                             ? LOOP_UNSTABLE_AWAY
                                                 : LOOP_DAMPED;
    if (c.state != LOOP_DAMPED) find_remedy(&all, params, &c);
    return c;
}

/* Describes a mode: "z at 12.3 Hz, damping -0.02". A growing real pole has no frequency. */
static int describe_mode(const struct loop_worst *w, char *text, size_t size) {
    if (!w->known) return snprintf(text, size, "its numbers are beyond computing");
    if (w->pole.radps > 0.0)
        return snprintf(text, size, "%s at %.3g Hz, damping %.2g", dof_names[w->dof], loop_pole_hz(&w->pole), loop_pole_damping(&w->pole));
    return snprintf(text, size, "%s %s %.2g times in a second", dof_names[w->dof],
                    w->pole.decay_per_s < 0.0 ? "runs away, growing" : "settles", exp(fabs(w->pole.decay_per_s)));
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
                 "no single gain puts it right: compare payload, actuator and hydraulics with the machine, "
                 "then lower control.kp, ki, kd and kpf");
}

bool loop_check_refuses(const struct loop_check *c, bool bus) { return c->state == LOOP_UNSTABLE || (c->state == LOOP_NOISY && !bus); }

int loop_check_run(const struct loop_check *c, bool bus, struct error *error) {
    char found[LOOP_TEXT_SIZE], remedy[LOOP_TEXT_SIZE];
    if (!loop_check_refuses(c, bus)) return STATUS_OK;
    loop_check_describe(c, found, remedy);
    return error_set(error, STATUS_USAGE, "not run: %s; %s", found, remedy);
}
