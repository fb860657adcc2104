#include "loop_margin.h"

#include <math.h>

#include "params/control.h"
#include "units.h"

static const double ROUNDING = 1e-9; /* well above the rounding of a gain's square */

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

/* The plant's sampled frequency nearest to this one. */
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
    /* most neighbours are on one side, which the squares say in a tenth of the logarithms' time */
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
            take_gain(&m, &s);
            take_phase(&m, &s);
            if (before >= 1.0 && alone < 1.0) m.bandwidth_hz = a->radps / (2.0 * PI);
        }
        s.radps[0] = s.radps[1], s.gain[0] = s.gain[1], before = alone;
    }
    return m;
}
