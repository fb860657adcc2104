#include "loop_tune.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kinematics.h"
#include "loop_found.h"
#include "modal.h"
#include "params.h"
#include "units.h"

/* Dampings of the slowest mode that are required one after the other, until one is reached. */
static const double dampings[] = {TUNE_DAMPING, 0.2, 0.15, 0.1, 0.05, 0.0};
enum { DAMPINGS = sizeof dampings / sizeof *dampings };

/* kpf is tried from a 30th to ten times the value of kpf_of(), then in finer steps about the best
 * one. For each kpf, kp is found by bisection between its bound and a KP_RANGE-th of it. */
enum { STEPS_PER_DECADE = 6, STEPS_BELOW = 9, STEPS_ABOVE = 6, FINE = 4, HALVINGS = 9 };
static const double KP_RANGE = 500.0;
static const double NOISE_SHARE = 0.4;     /* share of the accepted shaking that the gains may
                                            * cause. It is less than 1, because the shaking is
                                            * computed for errors that are white and independent,
                                            * and the steps of six legs that move alike are
                                            * neither */
static const double MODE_DAMPING = 0.06, MODE_SHARE = 0.9; /* least damping of each mode at neutral;
                                                            * a mode that has less without a
                                                            * controller must keep the share
                                                            * MODE_SHARE of its own damping */
static const double PASS_PERIODS = 3.0;    /* time constant tp of the high-pass, as a multiple of 1
                                            * / w, w the frequency of the slowest mode, where the
                                            * high-pass then adds less than 19 degrees of lead */
static const double KFF_LEAST = 0.75, KFF_MOST = 1.3, KFF_STEP = 0.01; /* range of kff, as a
                                                                        * multiple of the value that
                                                                        * follows from the valve's
                                                                        * speed */
static const double FASTER = 4.0, STIFFER = 2.0; /* factors by which a part of the machine is
                                                  * improved, to see whether it limits the loop */
static const double WORTH = 1.1;           /* a part is named if it gives a tenth more damping */

/* The machine in all poses, and a controller that is tried. */
struct field {
    struct params params;              /* machine as it was found, and the controller */
    const struct params *configured;   /* machine from which the controller computes its modal
                                        * weights (modal.h) */
    struct loop_places places;
    struct loop_plant plant[LOOP_PLACES][DOFS];
    struct loop_plant moving[DOFS];    /* modes at neutral, with the valves opening as far as in the
                                        * tests */
    double own_damping[DOFS];          /* dampings of the modes at neutral without a controller */
    bool surveyed;                     /* the legs are as a survey found them */
    struct loop_found found;
    int failed;                        /* index, DOFS * place + mode, of the mode that last missed
                                        * its margins */
};

/* Upper bound of a leg's speed in the tests, m/s; 0 for a trajectory, whose speeds are not known
 * here. */
static double tests_mps(const struct params *p) {
    const struct test_params *t = &p->tests;
    struct kinematics k;
    double most_mps = 0.0, sum_mps = 0.0;
    kinematics_place(&k, p);
    for (int i = 0; i < t->count && !t->trajectory[0]; i++) {
        enum dof axis = t->order[i];
        double mps = 2.0 * PI * t->hz[axis] * t->amplitude[axis] * (axis < DOF_PHI ? 1.0 : k.arm_m);
        sum_mps += mps, most_mps = fmax(most_mps, mps);
    }
    return t->multisine ? sum_mps : most_mps;
}

double loop_fastest_mps(const struct params *p) {
    double asked_mps = 2.0 * p->motion.park_z_m / fmin(p->motion.engage_s, p->motion.park_s);
    return fmax(fmin(asked_mps, p->motion.rate_mps), tests_mps(p));
}

void loop_pose_text(const double pose[DOFS], char text[LOOP_POSE_SIZE]) {
    snprintf(text, LOOP_POSE_SIZE, "neutral");
    for (int i = 0; i < DOFS; i++)
        if (pose[i] != 0.0) snprintf(text, LOOP_POSE_SIZE, "%s %.3g %s", dof_names[i], pose[i], i < DOF_PHI ? "m" : "rad");
}

static double with_digits(double x, int digits) {
    char text[32];
    snprintf(text, sizeof text, "%.*e", digits - 1, x);
    return strtod(text, NULL);
}

/* Finds the modal weights (modal.h) of this controller, from the configured machine as the
 * controller itself does. */
static int weights(const struct field *f, const struct control_params *g, struct modal *modal, struct error *error) {
    struct params p = *f->configured;
    struct kinematics k;
    p.control = *g;
    kinematics_place(&k, &p);
    return modal_init(modal, &p, &k, error);
}

static struct loop_mode_input shape_of(const struct field *f, int place, int mode) {
    return loop_place_mode(&f->places.place[place], mode);
}

/* Sets the controller that is tried next. Returns false, and keeps the present controller, if the
 * modal weights of the new one cannot be computed. */
static bool take(struct field *f, const struct control_params *g) {
    struct modal modal;
    bool same = g->modal == f->params.control.modal;
    if (!same && weights(f, g, &modal, &(struct error){0})) return false;
    f->params.control = *g;
    if (same) return true;
    for (int i = 0; i < f->places.count; i++) {
        loop_place_weigh(&f->places.place[i], &modal);
        for (int mode = 0; mode < DOFS; mode++) f->plant[i][mode].gain = f->places.place[i].mix[mode][mode];
    }
    for (int mode = 0; mode < DOFS; mode++) f->moving[mode].gain = f->plant[0][mode].gain;
    return true;
}

/* Changes one part of the machine to see whether it limits the loop. */
static void improve(struct field *f, enum loop_part part) {
    for (int i = 0; i < f->places.count; i++)
        for (int k = 0; k < LEGS; k++) {
            struct loop_leg *leg = &f->places.place[i].leg[k];
            if (part == LOOP_PART_VALVE) leg->spool_radps *= FASTER;
            if (part == LOOP_PART_CYCLE) leg->command_delay_s /= FASTER, leg->length_delay_s /= FASTER;
            for (int c = 0; c < 2 && part == LOOP_PART_OIL; c++) {
                struct oil_chamber *o = &leg->chamber[c];
                o->push *= STIFFER, o->open *= STIFFER, o->sag *= STIFFER, o->other *= STIFFER;
            }
        }
    if (part == LOOP_PART_CYCLE) f->params.loop.period_s /= FASTER;
}

/* Mean speeds of a leg at full opening, at neutral. */
static void speeds(const struct field *f, double *out_mps, double *in_mps) {
    const struct loop_place *neutral = &f->places.place[0];
    *out_mps = *in_mps = 0.0;
    for (int i = 0; i < LEGS; i++) *out_mps += neutral->out_mps[i] / LEGS, *in_mps += neutral->in_mps[i] / LEGS;
}

static double kff_of_valve(const struct field *f) {
    double out_mps, in_mps;
    speeds(f, &out_mps, &in_mps);
    return with_digits(2.0 / (out_mps + in_mps), 3);
}

static bool find_moving(struct field *f, const struct params *params, const struct modal *modal, bool bus) {
    static const double neutral[DOFS] = {0};
    struct loop_place moving;
    double swing = fmin(kff_of_valve(f) * tests_mps(params), 1.0);
    if (!loop_place_find_moving(&moving, params, neutral, loop_delay_s(params, bus), swing)) return false;
    if (f->surveyed && !loop_found_correct(&f->found, &moving, params, modal)) return false;
    for (int mode = 0; mode < DOFS; mode++) {
        const struct loop_mode_input shape = loop_place_mode(&moving, mode);
        loop_plant_find(moving.leg, &shape, params, &f->moving[mode]);
    }
    return true;
}

/* Least damped pair of poles of a mode. A mode without a pair does not oscillate, and counts as
 * critically damped. */
static struct loop_pole least_damped(const struct field *f, int place, int mode, bool *pair) {
    struct loop_pole pole[LOOP_POLES], least = {.decay_per_s = 1.0};
    const struct loop_mode_input shape = shape_of(f, place, mode);
    int count = loop_poles_all(f->places.place[place].leg, &shape, &f->params, pole);
    *pair = false;
    for (int i = 0; i < count; i++)
        if (pole[i].radps > 0.0 && loop_pole_damping(&pole[i]) < loop_pole_damping(&least)) least = pole[i], *pair = true;
    return least;
}

static void find_own_dampings(struct field *f) {
    const struct control_params control = f->params.control;
    struct control_params *g = &f->params.control;
    bool pair;
    g->kp = g->ki = g->kd = g->kpf = 0.0;
    for (int mode = 0; mode < DOFS; mode++) {
        struct loop_pole pole = least_damped(f, 0, mode, &pair);
        f->own_damping[mode] = loop_pole_damping(&pole);
    }
    f->params.control = control;
}

/* Corrects all places by the results of a survey. */
static bool take_survey(struct field *f, const struct modal *modal, const struct loop_survey *survey) {
    f->surveyed = survey != NULL;
    if (survey) f->found = loop_found(&f->places.place[0], &f->params, survey);
    for (int i = 0; i < f->places.count && survey; i++)
        if (!loop_found_correct(&f->found, &f->places.place[i], &f->params, modal)) return false;
    return true;
}

/* Fills a field; f->configured must be set before. params: the machine that a survey found, or the
 * configured one. survey: that survey, or NULL. part: part of the machine to be improved. Returns
 * false if the supply cannot hold the platform, or the modes of a place cannot be computed. */
static bool field_init(struct field *f, const struct params *params, bool bus, enum loop_part part, const struct loop_survey *survey) {
    struct modal modal;
    f->params = *params;
    f->failed = 0;
    if (weights(f, &params->control, &modal, &(struct error){0})) return false;
    if (!loop_places_find(&f->places, params, bus) || !take_survey(f, &modal, survey)) return false;
    improve(f, part);
    for (int i = 0; i < f->places.count; i++)
        for (int mode = 0; mode < DOFS; mode++) {
            const struct loop_mode_input shape = shape_of(f, i, mode);
            loop_plant_find(f->places.place[i].leg, &shape, &f->params, &f->plant[i][mode]);
        }
    find_own_dampings(f);
    return find_moving(f, params, &modal, bus);
}

/* ---- performance of a controller ---- */

/* Largest error, at the fastest motion, of the opening that kff gives. A leg at speed v needs an
 * opening of v / (its speed at full opening in this direction), and kff gives kff v. The position
 * error times kp must give the difference. */
static double missing_opening(const struct field *f, double kff) {
    double out_mps, in_mps;
    speeds(f, &out_mps, &in_mps);
    return fmax(fabs(1.0 / out_mps - kff), fabs(1.0 / in_mps - kff)) * loop_fastest_mps(&f->params);
}

static double following_m(const struct field *f, const struct control_params *g) {
    return g->kp > 0.0 ? missing_opening(f, g->kff) / g->kp : HUGE_VAL;
}

/* Largest error of a mode's amplitude, relative to its reference, at the frequency of its axis's
 * test, at neutral. */
static struct loop_least amplitude_off(const struct field *f, const struct control_params *g) {
    const struct loop_place *p = &f->places.place[0];
    struct loop_least most = {0};
    for (int mode = 0; mode < DOFS; mode++) {
        double hz = f->params.tests.hz[p->dof[mode]];
        double off = cabs(loop_follow(&f->moving[mode], g, 2.0 * PI * hz, f->params.loop.period_s)) - 1.0;
        if (fabs(off) > fabs(most.value)) most = (struct loop_least){.value = off, .hz = hz, .dof = p->dof[mode]};
    }
    return most;
}

static double slowest_damping(const struct field *f, int place) {
    bool pair;
    struct loop_pole pole = least_damped(f, place, 0, &pair);
    return loop_pole_damping(&pole);
}

/* Finds the margins in a place. Returns false if modes that are stable alone are unstable when the
 * modal weights couple them. */
static bool find_margins(const struct field *f, int place, struct loop_margin margin[DOFS]) {
    return loop_margins(f->plant[place], f->places.place[place].mix, &f->params.control, f->params.loop.period_s, margin) <= 0;
}

static bool suffices(const struct loop_margin *m, double delay_s) {
    return fmin(m->gain_db, m->drop_db) >= TUNE_GAIN_DB && m->phase_deg >= TUNE_PHASE_DEG && m->delay_s >= delay_s;
}

/* True if this mode has the required margins; if the controller has modal weights, which couple the
 * modes, true if all modes in this place have these margins. */
static bool keeps_margin(const struct field *f, int place, int mode, double delay_s) {
    struct loop_margin m[DOFS];
    if (f->params.control.modal == 0.0) {
        *m = loop_margin(&f->plant[place][mode], &f->params.control, f->params.loop.period_s);
        return suffices(m, delay_s);
    }
    bool all = find_margins(f, place, m);
    for (int i = 0; i < DOFS; i++) all = all && suffices(&m[i], delay_s);
    return all;
}

/* True if all modes in all places have the required margins, and at least this delay margin. The
 * mode that failed last is checked first, because most gains fail in the same mode. */
static bool keeps_margins(struct field *f, double delay_s) {
    int each = f->params.control.modal == 0.0 ? 1 : DOFS, modes = DOFS * f->places.count, first = f->failed / each * each;
    for (int i = 0; i < modes; i += each) {
        int at = (first + i) % modes;
        if (keeps_margin(f, at / DOFS, at % DOFS, delay_s)) continue;
        f->failed = at;
        return false;
    }
    return true;
}

static double least_delay_s(const struct field *f) {
    struct loop_margin m[DOFS];
    double least_s = HUGE_VAL;
    for (int i = 0; i < f->places.count; i++) {
        find_margins(f, i, m);
        for (int mode = 0; mode < DOFS; mode++) least_s = fmin(least_s, m[mode].delay_s);
    }
    return least_s;
}

static bool is_stable(const struct field *f, int place) {
    struct loop_worst worst = loop_place_worst(&f->places.place[place], &f->params);
    return worst.known && worst.pole.decay_per_s > 0.0;
}

/* True if each mode at neutral has as much damping as it needs. */
static bool keeps_dampings(const struct field *f) {
    bool pair;
    for (int mode = 0; mode < DOFS; mode++) {
        struct loop_pole pole = least_damped(f, 0, mode, &pair);
        if (!(loop_pole_damping(&pole) >= fmin(MODE_DAMPING, MODE_SHARE * f->own_damping[mode]))) return false;
    }
    return true;
}

/* Requirements on gains, in addition to the margins, the dampings of keeps_dampings() and the
 * noise. */
struct required {
    double damping, delay_s;           /* least damping of the slowest mode; least delay margin */
};

/* True if the gains meet all requirements but the margins. */
static bool holds_but_margins(struct field *f, const struct required *r) {
    if (!keeps_dampings(f)) return false;
    for (int i = 0; i < f->places.way; i++)
        if (!(slowest_damping(f, i) >= r->damping)) return false;
    for (int i = 0; i < f->places.count; i++)
        if (!is_stable(f, i)) return false;
    return loop_places_noise_mps2(&f->places, &f->params) <= NOISE_SHARE * loop_noise_most_mps2(&f->params);
}

/* True if the gains meet all requirements. Margins are the fastest check without modal weights, and
 * the slowest with them; the fastest check comes first. */
static bool holds(struct field *f, const struct control_params *g, const struct required *r) {
    if (!take(f, g)) return false;
    if (g->modal == 0.0) return keeps_margins(f, r->delay_s) && holds_but_margins(f, r);
    return holds_but_margins(f, r) && keeps_margins(f, r->delay_s);
}

/* ---- the search ---- */

/* Returns gains with this kp and kpf. The bandwidth is kp / kff, as long as the oil's modes are
 * faster. */
static struct control_params gains_of(const struct field *f, double kff, double tp, double kpf, double kp) {
    struct control_params g = f->params.control;
    g.kff = kff, g.tp = tp, g.kd = g.modal = 0.0;
    g.kpf = with_digits(kpf, 2), g.kp = with_digits(kp, 2);
    g.ki = with_digits(TUNE_INTEGRAL * g.kp * g.kp / kff, 2);
    return g;
}

/* Finds the largest kp with which the gains meet the requirements, for this kpf. Returns kp = 0 if
 * the least kp that is tried does not meet them, or if least_kp, the best kp so far, does not. */
static struct control_params best_of_kpf(struct field *f, double kff, double tp, double kpf, double damping, double least_kp) {
    const struct required required = {.damping = damping};
    double most = TUNE_BANDWIDTH * kff * f->plant[0][0].oil_radps, low = most / KP_RANGE, high = most;
    struct control_params least = gains_of(f, kff, tp, kpf, least_kp), found = gains_of(f, kff, tp, kpf, low);
    if (least_kp > low && !holds(f, &least, &required)) return (struct control_params){0};
    if (!holds(f, &found, &required)) return (struct control_params){0};
    struct control_params bound = gains_of(f, kff, tp, kpf, most);
    if (holds(f, &bound, &required)) return bound;
    for (int i = 0; i < HALVINGS; i++) {
        double middle = sqrt(low * high);
        struct control_params g = gains_of(f, kff, tp, kpf, middle);
        if (holds(f, &g, &required)) low = middle, found = g;
        else high = middle;
    }
    return found;
}

static void take_better(struct control_params *best, struct control_params g) {
    if (g.kp > best->kp) *best = g;
}

/* kpf that adds this damping to the slowest mode, if the valve has no lag: 2 d kff / (w m). */
static double kpf_of(const struct field *f, double kff, double damping) {
    return 2.0 * damping * kff / (f->plant[0][0].oil_radps * f->places.place[0].mass_kg[0]);
}

static struct control_params search(struct field *f, double kff, double tp, double damping) {
    struct control_params best = {0};
    double scale = kpf_of(f, kff, TUNE_DAMPING);
    for (int i = -STEPS_BELOW; i <= STEPS_ABOVE; i++)
        take_better(&best, best_of_kpf(f, kff, tp, scale * pow(10.0, (double)i / STEPS_PER_DECADE), damping, best.kp));
    double about = best.kpf;
    for (int i = 1 - FINE; i < FINE && about > 0.0; i++)
        take_better(&best, best_of_kpf(f, kff, tp, about * pow(10.0, (double)i / (FINE * STEPS_PER_DECADE)), damping, best.kp));
    return best;
}

/* Finds the kff with which the amplitudes of all tests are nearest to their references. Leakage
 * takes a share of a slow flow, so the kff that follows from the speed at full opening is too
 * small. */
static void match_amplitudes(const struct field *f, struct control_params *g) {
    struct control_params tried = *g;
    double least = HUGE_VAL, valve = g->kff;
    for (double share = KFF_LEAST; share <= KFF_MOST; share += KFF_STEP) {
        tried.kff = with_digits(share * valve, 3);
        double off = fabs(amplitude_off(f, &tried).value);
        if (off < least) least = off, *g = tried;
    }
}

/* Finds gains for the largest damping that any gains reach, with kp large enough for the legs to
 * follow; if no kp is, returns the gains with the largest kp. wanted: set to this damping. A slow
 * machine needs a longer tp: the high-pass must pass the slowest mode's force. */
static struct control_params find(struct field *f, const struct control_params *now, double kff, double *wanted) {
    double slow_s = with_digits(PASS_PERIODS / f->plant[0][0].oil_radps, 2);
    double kp_least = missing_opening(f, kff) / (TUNE_FOLLOWING * f->params.limits.following_m);
    struct control_params weak = {0};
    *wanted = 0.0;
    for (int i = 0; i < DAMPINGS; i++) {
        struct control_params g = search(f, kff, now->tp, dampings[i]);
        if (g.kp < kp_least && slow_s > now->tp) take_better(&g, search(f, kff, slow_s, dampings[i]));
        if (g.kp > weak.kp) weak = g, *wanted = dampings[i];
        if (g.kp >= kp_least && g.kp > 0.0) return g;
    }
    return weak;
}

/* Finds the largest control.modal, which gives the faster modes more kp and ki, that meets the
 * requirements. A loop that is faster in all modes tolerates less delay, and most of what the model
 * of a machine lacks acts as delay. So the gains keep the share TUNE_MODAL_DELAY of the delay
 * margin. */
static void raise_modal(struct field *f, struct control_params *g, double damping) {
    struct control_params tried = *g;
    if (!(g->kp > 0.0)) return;
    take(f, g);
    const struct required required = {.damping = damping, .delay_s = TUNE_MODAL_DELAY * least_delay_s(f)};
    for (int tenths = 10; tenths > 0; tenths--) {
        tried.modal = tenths / 10.0;
        if (!holds(f, &tried, &required)) continue;
        *g = tried;
        return;
    }
    take(f, g);
}

/* ---- performance of the gains ---- */

static void take_least(struct loop_least *to, double value, double hz, const struct loop_place *place, int mode) {
    if (!(value < to->value)) return;
    *to = (struct loop_least){.value = value, .hz = hz, .dof = place->dof[mode]};
    memcpy(to->pose, place->pose, sizeof to->pose);
}

static void stand_in(struct field *f, int place, struct loop_standing *s) {
    const struct loop_place *p = &f->places.place[place];
    struct loop_margin margin[DOFS];
    s->stable &= find_margins(f, place, margin) && is_stable(f, place);
    for (int mode = 0; mode < DOFS; mode++) {
        const struct loop_margin m = margin[mode];
        struct loop_mode_standing *of = &s->mode[mode];
        double gain_db = fmin(m.gain_db, m.drop_db), hz = m.gain_db <= m.drop_db ? m.gain_hz : 0.0;
        take_least(&of->gain_db, gain_db, hz, p, mode), take_least(&s->gain_db, gain_db, hz, p, mode);
        take_least(&of->phase_deg, m.phase_deg, m.phase_hz, p, mode), take_least(&s->phase_deg, m.phase_deg, m.phase_hz, p, mode);
        take_least(&s->delay_s, m.delay_s, m.delay_hz, p, mode);
        if (place == 0) of->bandwidth_hz = m.bandwidth_hz;
    }
    if (place < f->places.way) take_least(&s->damping, slowest_damping(f, place), f->plant[place][0].oil_radps / (2.0 * PI), p, 0);
}

static void stand_neutral(struct field *f, const struct control_params *g, struct loop_standing *s) {
    bool pair;
    take(f, g);
    for (int mode = 0; mode < DOFS; mode++) {
        struct loop_mode_standing *of = &s->mode[mode];
        of->dof = f->places.place[0].dof[mode], of->oil_hz = f->plant[0][mode].oil_radps / (2.0 * PI);
        of->oil_damping = f->own_damping[mode];
        struct loop_pole pole = least_damped(f, 0, mode, &pair);
        of->hz = pair ? loop_pole_hz(&pole) : (double)NAN, of->damping = loop_pole_damping(&pole);
    }
}

static struct loop_standing stand(struct field *f, const struct control_params *g) {
    const struct loop_least none = {.value = HUGE_VAL};
    struct loop_standing s = {.stable = true, .gain_db = none, .phase_deg = none, .delay_s = none, .damping = none};
    for (int mode = 0; mode < DOFS; mode++) s.mode[mode].gain_db = s.mode[mode].phase_deg = none;
    take(f, g);
    for (int i = 0; i < f->places.count; i++) stand_in(f, i, &s);
    s.noise_mps2 = loop_places_noise_mps2(&f->places, &f->params), s.noise_most_mps2 = loop_noise_most_mps2(&f->params);
    s.following_m = following_m(f, g), s.amplitude = amplitude_off(f, g);
    stand_neutral(f, g, &s);
    return s;
}

/* ---- all of it ---- */

static void solve(struct field *f, const struct params *params, struct loop_tune *t) {
    speeds(f, &t->out_mps, &t->in_mps);
    t->gains = find(f, &params->control, kff_of_valve(f), &t->damping_wanted);
    raise_modal(f, &t->gains, t->damping_wanted);
    match_amplitudes(f, &t->gains);
    t->reached = t->gains.kp > 0.0 && t->damping_wanted >= TUNE_DAMPING &&
                 following_m(f, &t->gains) <= TUNE_FOLLOWING * params->limits.following_m;
}

static double least_slowest_damping(struct field *f, const struct control_params *g) {
    double least = HUGE_VAL;
    take(f, g);
    for (int i = 0; i < f->places.way; i++) least = fmin(least, slowest_damping(f, i));
    return least;
}

/* Finds the part whose improvement gives the slowest mode most damping. */
static void find_part(struct field *f, const struct params *params, bool bus, struct loop_tune *t) {
    double most = WORTH * t->after.damping.value;
    for (int part = LOOP_PART_NONE + 1; part < LOOP_PARTS; part++) {
        struct loop_tune other;
        if (!field_init(f, params, bus, (enum loop_part)part, NULL)) continue;
        solve(f, params, &other);
        double damping = other.gains.kp > 0.0 ? least_slowest_damping(f, &other.gains) : 0.0;
        t->part_damping[part] = damping;
        if (damping > most) t->limit = (enum loop_part)part, most = damping;
    }
}

/* True if no delay is longer than the LOOP_DELAY_MOST cycles that loop_poles.h can model. */
static bool delays_fit(const struct field *f) {
    double most_s = LOOP_DELAY_MOST * f->params.loop.period_s;
    for (int k = 0; k < LEGS; k++)
        if (f->places.place[0].leg[k].command_delay_s > most_s || f->places.place[0].leg[k].length_delay_s > most_s) return false;
    return true;
}

/* Makes the field of this machine, which the caller frees; configured must outlive it. On failure
 * returns NULL and sets status and error. */
static struct field *field_new(const struct params *configured, const struct params *params, bool bus, const struct loop_survey *survey,
                               int *status, struct error *error) {
    struct field *f = malloc(sizeof *f);
    struct modal modal;
    if (f) f->configured = configured;
    if (!f) *status = error_set(error, STATUS_IO, "out of memory");
    else if ((*status = weights(f, &configured->control, &modal, error))) {
        free(f);
        return NULL;
    } else if (!field_init(f, params, bus, LOOP_PART_NONE, survey))
        *status = error_set(error, STATUS_USAGE,
                            "no gains: the supply does not hold the platform up at neutral; compare payload, actuator and "
                            "hydraulics.supply_pa with the machine");
    else if (!delays_fit(f))
        *status = error_set(
            error, STATUS_USAGE,
            "no gains: a delay of commands or lengths is longer than %d cycles, %g s, with which the loop is computed; compare "
            "control.delay_s and the effects command_delay and position_sensor_delay with the machine",
            LOOP_DELAY_MOST, LOOP_DELAY_MOST * params->loop.period_s);
    else {
        *status = STATUS_OK;
        return f;
    }
    free(f);
    return NULL;
}

int loop_tune_stand(const struct params *params, bool bus, struct loop_standing *s, struct error *error) {
    int status;
    struct field *f = field_new(params, params, bus, NULL, &status, error);
    if (f) *s = stand(f, &params->control);
    free(f);
    return status;
}

static int tune(const struct params *configured, const struct params *params, const struct loop_survey *survey, bool bus, bool parts,
                struct loop_tune *t, struct error *error) {
    int status;
    *t = (struct loop_tune){.now = params->control};
    struct field *f = field_new(configured, params, bus, survey, &status, error);
    if (!f) return status;
    solve(f, params, t);
    t->before = stand(f, &t->now);
    t->after = stand(f, &t->gains);
    if (parts && !t->reached) find_part(f, params, bus, t);
    free(f);
    return STATUS_OK;
}

int loop_tune(const struct params *params, bool bus, bool parts, struct loop_tune *t, struct error *error) {
    return tune(params, params, NULL, bus, parts, t, error);
}

int loop_tune_surveyed(const struct params *params, const struct loop_survey *survey, struct loop_tune *t, struct error *error) {
    const struct params found = loop_found_params(params, survey);
    return tune(params, &found, survey, false, false, t, error);
}
