#include "quality_check.h"

#include <math.h>
#include <stddef.h>

#include "numeric.h"
#include "units.h"

/* Two tones are the same if their frequencies differ by at most this share; a tone lasts a whole
 * number of loop periods, so its frequency changes a little with loop.period_s. */
static const double SAME_FREQUENCY = 0.02;
/* Two tones are comparable if their amplitudes differ by at most this share, because the describing
 * function of a nonlinear machine depends on the amplitude. */
static const double SAME_AMPLITUDE = 0.02;

struct quality_change quality_change(const struct quality *now, const struct quality *before, int dof, int tone) {
    const struct quality_tone *a = &now->tone[dof][tone], *b = &before->tone[dof][tone];
    bool same = tone < before->plan.tones && fabs(b->hz - a->hz) <= SAME_FREQUENCY * a->hz &&
                fabs(b->amplitude - a->amplitude) <= SAME_AMPLITUDE * a->amplitude;
    if (!same) return (struct quality_change){(double)NAN, (double)NAN, (double)NAN, (double)NAN};
    double complex ratio = a->gain[dof] / b->gain[dof], off = a->gain[dof] - b->gain[dof];
    return (struct quality_change){.gain_pct = 100.0 * (cabs(ratio) - 1.0),
                                   .phase_deg = deg_from_rad(carg(ratio)),
                                   .mps2 = cabs(off) * a->amplitude * square(2.0 * PI * a->hz) * quality_metres(&now->plan, dof),
                                   .of_noise = cabs(off) / sqrt(2.0 * (a->std * a->std + b->std * b->std))};
}

double quality_change_of_noise(const struct quality *now, const struct quality *before) {
    double square = 0.0;
    int count = 0;
    for (int dof = 0; dof < DOFS; dof++)
        for (int i = 0; i < now->plan.tones; i++) {
            double off = quality_change(now, before, dof, i).of_noise;
            if (isfinite(off)) square += off * off, count++;
        }
    return count ? sqrt(square / count) : (double)NAN;
}

double quality_rest(const struct quality *q, int dof) {
    const double *band = q->axis[dof].rest;
    return sqrt(band[0] * band[0] + band[1] * band[1] + band[2] * band[2]);
}

/* Arguments of a check's function: measurement, axis and tone. */
struct subject {
    const struct quality *q, *before;
    int dof, tone;
};

static double metres(const struct subject *s, double value) { return value * quality_metres(&s->q->plan, s->dof); }
static const struct quality_axis *axis(const struct subject *s) { return &s->q->axis[s->dof]; }
static const struct quality_tone *tone(const struct subject *s) { return &s->q->tone[s->dof][s->tone]; }

static double of_amplitude(const struct subject *s) { return 100.0 * fabs(cabs(tone(s)->gain[s->dof]) - 1.0); }
static double of_phase(const struct subject *s) { return fabs(quality_phase_deg(s->q, s->dof, s->tone)); }
static double of_cross(const struct subject *s) { return 100.0 * quality_cross_most(s->q, s->dof, s->tone); }
static double of_harmonics(const struct subject *s) { return 100.0 * tone(s)->low; }
static double of_noise(const struct subject *s) { return 100.0 * tone(s)->noise; }
static double of_rest(const struct subject *s) { return metres(s, quality_rest(s->q, s->dof)); }
static double of_turn(const struct subject *s) { return metres(s, axis(s)->turn_around); }
static double of_threshold(const struct subject *s) { return metres(s, axis(s)->threshold); }
static double of_hysteresis(const struct subject *s) { return metres(s, axis(s)->hysteresis); }
static double of_dead(const struct subject *s) { return axis(s)->dead_s; }
static double of_excursion(const struct subject *s) { return metres(s, axis(s)->excursion); }
static double of_rate(const struct subject *s) { return metres(s, axis(s)->rate); }
static double of_accel(const struct subject *s) { return metres(s, axis(s)->accel); }
static double of_repeat(const struct subject *s) { return s->before ? quality_change(s->q, s->before, s->dof, s->tone).mps2 : (double)NAN; }
static double of_balance(const struct subject *s) {
    double complex mean = 0.0;
    double most = 0.0;
    for (int k = 0; k < LEGS; k++) mean += s->q->leg[k] / LEGS;
    for (int k = 0; k < LEGS; k++) most = quality_worse(most, 100.0 * cabs(s->q->leg[k] / mean - 1.0));
    return most;
}

/* Set of values whose worst one a check takes. OF_LOW_TONES: of tones up to qualify.up_to_hz;
 * OF_HARMONICS: of low tones whose second harmonic is in the measured band. */
enum reach { OF_MACHINE, OF_AXES, OF_TONES, OF_LOW_TONES, OF_HARMONICS };

static bool counts(enum reach reach, double hz, const struct qualify_params *limits) {
    if (reach == OF_HARMONICS && 2.0 * hz > QUALITY_BAND_HZ) return false;
    return reach < OF_LOW_TONES || hz <= limits->up_to_hz * (1.0 + SAME_FREQUENCY);
}

#define LIMIT(member) offsetof(struct qualify_params, member)
static const struct {
    const char *key, *unit, *what;
    enum reach reach;
    bool least;
    size_t limit;
    double (*value)(const struct subject *);
} rows[QUALITY_CHECKS] = {
    {"amplitude_pct", "%", "amplitude off 1", OF_LOW_TONES, false, LIMIT(amplitude_pct), of_amplitude},
    {"phase_deg", "deg", "phase", OF_LOW_TONES, false, LIMIT(phase_deg), of_phase},
    {"cross_talk_pct", "%", "cross-talk", OF_LOW_TONES, false, LIMIT(cross_talk_pct), of_cross},
    {"harmonics_pct", "%", "harmonics 2 and 3", OF_HARMONICS, false, LIMIT(harmonics_pct), of_harmonics},
    {"noise_pct", "%", "noise in motion", OF_LOW_TONES, false, LIMIT(noise_pct), of_noise},
    {"rest_mps2", "m/s²", "noise at rest", OF_AXES, false, LIMIT(rest_mps2), of_rest},
    {"turn_around_mps2", "m/s²", "turn-around bump", OF_AXES, false, LIMIT(turn_around_mps2), of_turn},
    {"threshold_m", "m", "threshold", OF_AXES, false, LIMIT(threshold_m), of_threshold},
    {"hysteresis_m", "m", "hysteresis", OF_AXES, false, LIMIT(hysteresis_m), of_hysteresis},
    {"dead_s", "s", "dead time", OF_AXES, false, LIMIT(dead_s), of_dead},
    {"balance_pct", "%", "leg balance", OF_MACHINE, false, LIMIT(balance_pct), of_balance},
    {"excursion_m", "m", "excursion reached", OF_AXES, true, LIMIT(excursion_m), of_excursion},
    {"rate_mps", "m/s", "rate reached", OF_AXES, true, LIMIT(rate_mps), of_rate},
    {"accel_mps2", "m/s²", "acceleration reached", OF_AXES, true, LIMIT(accel_mps2), of_accel},
    {"repeat_mps2", "m/s²", "change from the baseline", OF_TONES, false, LIMIT(repeat_mps2), of_repeat},
};

static void take(struct quality_check *c, const struct subject *s, double value, enum reach reach) {
    c->lacks |= isnan(value);
    if (isnan(value) || (!isnan(c->value) && (c->least ? value >= c->value : value <= c->value))) return;
    c->value = value;
    c->dof = reach == OF_MACHINE ? DOF_NONE : s->dof;
    c->hz = reach >= OF_TONES ? s->q->tone[s->dof][s->tone].hz : (double)NAN;
}

static struct quality_check judge(int row, const struct quality *q, const struct quality *before, const struct qualify_params *limits) {
    enum reach reach = rows[row].reach;
    struct quality_check c = {.key = rows[row].key, .unit = rows[row].unit, .what = rows[row].what, .least = rows[row].least};
    c.limit = *(const double *)(const void *)((const char *)limits + rows[row].limit);
    c.value = c.hz = (double)NAN, c.dof = DOF_NONE;
    struct subject s = {.q = q, .before = before};
    for (s.dof = 0; s.dof < (reach == OF_MACHINE ? 1 : DOFS); s.dof++)
        for (s.tone = 0; s.tone < (reach >= OF_TONES ? q->plan.tones : 1); s.tone++)
            if (counts(reach, q->tone[s.dof][s.tone].hz, limits)) take(&c, &s, rows[row].value(&s), reach);
    bool within = c.least ? c.value >= c.limit : c.value <= c.limit;
    if (!(c.limit > 0.0) || isnan(c.value)) c.status = VERDICT_NOT_EVALUATED;
    else if (!within) c.status = VERDICT_FAIL;
    else c.status = c.lacks ? VERDICT_NOT_EVALUATED : VERDICT_PASS;
    return c;
}

void quality_judge(const struct quality *q, const struct quality *before, const struct qualify_params *limits,
                   struct quality_check check[QUALITY_CHECKS]) {
    for (int i = 0; i < QUALITY_CHECKS; i++) check[i] = judge(i, q, before, limits);
}

enum verdict_status quality_verdict(const struct quality_check check[QUALITY_CHECKS]) {
    enum verdict_status v = VERDICT_NOT_EVALUATED;
    for (int i = 0; i < QUALITY_CHECKS; i++)
        if (check[i].status == VERDICT_PASS) v = VERDICT_PASS;
    for (int i = 0; i < QUALITY_CHECKS; i++)
        if (check[i].status == VERDICT_NOT_EVALUATED && check[i].limit > 0.0) v = VERDICT_NOT_EVALUATED;
    for (int i = 0; i < QUALITY_CHECKS; i++)
        if (check[i].status == VERDICT_FAIL) v = VERDICT_FAIL;
    return v;
}
