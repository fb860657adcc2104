#include "loop_margin.h"

#include <math.h>
#include <string.h>

#include "lin.h"
#include "params/control.h"
#include "units.h"

static const double ROUNDING = 1e-9; /* relative allowance for rounding of a gain's square */

static const double SAME_RADPS = 1e-4; /* relative; frequencies nearer to each other count as one */

static double decibel(double ratio) { return 20.0 * log10(ratio); }

/* Gain of the controller's position path at a frequency, as sampled: command per metre of error
 * (pid.h). */
static double complex position_gain(const struct control_params *g, double radps, double dt_s) {
    double derive = dt_s / (g->tf + dt_s);
    double complex back = cexp(CMPLX(0.0, -radps * dt_s)), change = 1.0 - back; /* change over one
                                                                                 * cycle */
    return g->kp + g->ki * dt_s / change + g->kd * derive / dt_s * change / (1.0 - (1.0 - derive) * back);
}

/* Gain of the pressure path: command per newton of force. */
static double complex pressure_gain(const struct control_params *g, double radps, double dt_s) {
    double low_pass = dt_s / (g->tp + dt_s);
    double complex back = cexp(CMPLX(0.0, -radps * dt_s));
    return g->kpf * (1.0 - low_pass) * (1.0 - back) / (1.0 - (1.0 - low_pass) * back);
}

/* The point of the plant's frequency response nearest to this frequency. */
static const struct loop_answer *nearest(const struct loop_plant *p, double radps) {
    const struct loop_answer *found = p->answer;
    for (int i = 1; i < LOOP_ANSWERS; i++)
        if (fabs(p->answer[i].radps - radps) < fabs(found->radps - radps)) found = &p->answer[i];
    return found;
}

double complex loop_follow(const struct loop_plant *p, const struct control_params *g, double radps, double dt_s) {
    const struct loop_answer *a = nearest(p, radps);
    double complex position = p->gain * position_gain(g, a->radps, dt_s);
    double complex force = (1.0 - p->feedback_cut) * pressure_gain(g, a->radps, dt_s);
    double complex ahead = g->kff * (1.0 - cexp(CMPLX(0.0, -a->radps * dt_s))) / dt_s;
    return (position + ahead) * a->length_m / (1.0 + position * a->length_m + force * a->force_n);
}

/* The loop's gain at two neighbouring frequencies. */
struct stretch {
    double radps[2];
    double complex gain[2];
};

static double squared(double complex gain) { return creal(gain) * creal(gain) + cimag(gain) * cimag(gain); }

static double between(double a, double b, double share) { return a + share * (b - a); }

/* Updates the gain margins where the loop's gain crosses the negative real axis between two
 * frequencies, if it does. */
static void take_gain(struct loop_margin *m, const struct stretch *s) {
    double from = cimag(s->gain[0]), to = cimag(s->gain[1]);
    if (from == to || (from > 0.0) == (to > 0.0)) return;
    double share = from / (from - to), real = between(creal(s->gain[0]), creal(s->gain[1]), share);
    if (real > -1.0 && real < 0.0 && decibel(-1.0 / real) < m->gain_db)
        m->gain_db = decibel(-1.0 / real), m->gain_hz = between(s->radps[0], s->radps[1], share) / (2.0 * PI);
    if (real <= -1.0) m->drop_db = fmin(m->drop_db, decibel(-real));
}

/* Updates the phase and delay margins where the magnitude of the gain passes 1, if it does. */
static void take_phase(struct loop_margin *m, const struct stretch *s) {
    /* Usually both magnitudes are on one side of 1. The squares show this in a tenth of the time
     * that logarithms take. */
    double one = squared(s->gain[0]), other = squared(s->gain[1]);
    if (fmin(one, other) > 1.0 + ROUNDING || fmax(one, other) < 1.0 - ROUNDING) return;

    double from = log(cabs(s->gain[0])), to = log(cabs(s->gain[1]));
    if (from == to || (from > 0.0) == (to > 0.0)) return;
    double share = from / (from - to), radps = between(s->radps[0], s->radps[1], share);
    /* lead: phase of the gain above -180 degrees */
    double turn = carg(s->gain[1] / s->gain[0]) * share, lead = carg(-s->gain[0]) + turn;
    double until = lead - 2.0 * PI * floor(lead / (2.0 * PI)), least = fmin(until, 2.0 * PI - until);
    if (deg_from_rad(least) < m->phase_deg) m->phase_deg = deg_from_rad(least), m->phase_hz = radps / (2.0 * PI);
    if (until / radps < m->delay_s) m->delay_s = until / radps, m->delay_hz = radps / (2.0 * PI);
}

static void take_stretch(struct loop_margin *m, const struct stretch *s) {
    take_gain(m, s);
    take_phase(m, s);
}

struct loop_margin loop_margin(const struct loop_plant *p, const struct control_params *control, double dt_s) {
    struct loop_margin m = {.gain_db = HUGE_VAL, .drop_db = HUGE_VAL, .phase_deg = HUGE_VAL, .delay_s = HUGE_VAL};
    struct stretch s = {{0}, {0}};
    double before = 0.0;
    for (int i = 0; i < LOOP_ANSWERS; i++) {
        const struct loop_answer *a = &p->answer[i];
        double complex position = p->gain * position_gain(control, a->radps, dt_s) * a->length_m;
        double complex force = (1.0 - p->feedback_cut) * pressure_gain(control, a->radps, dt_s) * a->force_n;
        double alone = cabs(position / (1.0 + force));
        s.radps[1] = a->radps, s.gain[1] = position + force;
        if (i > 0) {
            take_stretch(&m, &s);
            if (before >= 1.0 && alone < 1.0) m.bandwidth_hz = a->radps / (2.0 * PI);
        }
        s.radps[0] = s.radps[1], s.gain[0] = s.gain[1], before = alone;
    }
    return m;
}

/* ---- six modes that the weights connect ---- */

/* A walk through the frequencies of all six plants in ascending order. */
struct walk {
    int next[DOFS];              /* first point of each plant's frequency response at or above
                                  * radps */
    double radps;
};

/* Moves on to the next frequency that differs from this one. Returns false if a plant has no
 * further one. */
static bool walk_on(struct walk *w, const struct loop_plant plant[DOFS]) {
    double next = HUGE_VAL;
    for (int mode = 0; mode < DOFS; mode++) {
        const struct loop_answer *a = plant[mode].answer;
        while (w->next[mode] < LOOP_ANSWERS && a[w->next[mode]].radps <= w->radps * (1.0 + SAME_RADPS)) w->next[mode]++;
        if (w->next[mode] == LOOP_ANSWERS) return false;
        next = fmin(next, a[w->next[mode]].radps);
    }
    w->radps = next;
    return true;
}

/* A plant's frequency response at the walk's frequency, interpolated between the plant's own
 * frequencies. */
static struct loop_answer answer_at(const struct loop_plant *p, const struct walk *w, int mode) {
    const struct loop_answer *to = &p->answer[w->next[mode]], *from = w->next[mode] ? to - 1 : to;
    double share = to == from ? 0.0 : (w->radps - from->radps) / (to->radps - from->radps);
    return (struct loop_answer){.radps = w->radps,
                                .length_m = from->length_m + share * (to->length_m - from->length_m),
                                .force_n = from->force_n + share * (to->force_n - from->force_n)};
}

/* The loop's gain from the commands of six modes back to them. */
static void connected_gain(const struct loop_plant plant[DOFS], const double mix[DOFS][DOFS], const struct walk *w,
                           const struct control_params *g, double dt_s, double complex gain[DOFS][DOFS]) {
    double complex position = position_gain(g, w->radps, dt_s), pressure = pressure_gain(g, w->radps, dt_s);
    for (int j = 0; j < DOFS; j++) {
        struct loop_answer a = answer_at(&plant[j], w, j);
        for (int i = 0; i < DOFS; i++) gain[i][j] = mix[i][j] * position * a.length_m;
        gain[j][j] += (1.0 - plant[j].feedback_cut) * pressure * a.force_n;
    }
}

/* Reorders the values: value[i] becomes the one nearest to known[i] among those that no earlier i
 * has taken. */
static void follow(const double complex known[DOFS], double complex value[DOFS]) {
    for (int i = 0; i < DOFS; i++) {
        int nearest = i;
        for (int j = i + 1; j < DOFS; j++)
            if (cabs(value[j] - known[i]) < cabs(value[nearest] - known[i])) nearest = j;
        double complex swapped = value[i];
        value[i] = value[nearest], value[nearest] = swapped;
    }
}

static bool connects(const double mix[DOFS][DOFS]) {
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < DOFS; j++)
            if (i != j && mix[i][j] != 0.0) return true;
    return false;
}

_Static_assert((int)DOFS <= (int)LIN_COMPLEX_MAX, "the modes' gains fit lin_complex_eigenvalues()");

int loop_margins(const struct loop_plant plant[DOFS], const double mix[DOFS][DOFS], const struct control_params *control, double dt_s,
                 struct loop_margin margin[DOFS]) {
    struct walk w = {{0}, 0.0};
    double complex gain[DOFS][DOFS], value[DOFS], before[DOFS];
    double complex alone[DOFS];
    double before_radps = 0.0, turn = 0.0;
    for (int mode = 0; mode < DOFS; mode++) margin[mode] = loop_margin(&plant[mode], control, dt_s);
    if (!connects(mix)) return 0;
    for (int mode = 0; mode < DOFS; mode++) {
        struct loop_margin *m = &margin[mode];
        m->gain_db = m->drop_db = m->phase_deg = m->delay_s = HUGE_VAL;
        w.radps = fmax(w.radps, plant[mode].answer[0].radps);
    }
    while (walk_on(&w, plant)) {
        connected_gain(plant, mix, &w, control, dt_s, gain);
        if (!(before_radps > 0.0))
            for (int mode = 0; mode < DOFS; mode++) before[mode] = alone[mode] = gain[mode][mode];
        if (lin_complex_eigenvalues(DOFS, (const double *)gain, (double *)value)) {
            for (int mode = 0; mode < DOFS; mode++) margin[mode].gain_db = margin[mode].phase_deg = margin[mode].delay_s = 0.0;
            return DOFS;
        }
        follow(before, value);
        for (int mode = 0; mode < DOFS && before_radps > 0.0; mode++) {
            take_stretch(&margin[mode], &(struct stretch){{before_radps, w.radps}, {before[mode], value[mode]}});
            turn += carg((1.0 + value[mode]) / (1.0 + before[mode])) - carg((1.0 + gain[mode][mode]) / (1.0 + alone[mode]));
        }
        for (int mode = 0; mode < DOFS; mode++) alone[mode] = gain[mode][mode];
        memcpy(before, value, sizeof before);
        before_radps = w.radps;
    }
    return (int)lround(-turn / PI);
}
