#include "quality_plan.h"

#include <math.h>
#include <stdlib.h>

#include "kinematics.h"
#include "loop_margin.h"
#include "loop_places.h"
#include "multisine.h"
#include "params.h"
#include "units.h"

static const double tone_hz[QUALITY_TONES] = {0.1, 0.2, 0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 14.0, 20.0};
/* Frequency of the highest tone, as a share of the loop's rate: above it the lag by half a cycle,
 * which the held commands have, is more than a fifth of a radian. */
static const double OF_RATE = 1.0 / 16.0;
/* Shortest cycle: the motion has a knot of 104 bytes for each cycle, which makes 120 MB with this
 * cycle. */
static const double LEAST_STEP_S = 5e-4;
/* Longest cycle: half its rate is the highest frequency at which noise is measured. */
static const double MOST_STEP_S = 0.01;
/* A tone has at least this many periods, and lasts at least this long. */
static const int LEAST_PERIODS = 2;
static const double LEAST_TONE_S = 2.0;
/* The controller's integral settles in about kp / ki, 2 s as shipped. So a tone below LEAD_BELOW_HZ
 * runs for LEAD_S before it is evaluated. */
static const double LEAD_BELOW_HZ = 1.5, LEAD_S = 1.5;
/* Shares of the legs' free stroke and highest rate (steps and slopes: of the rate only) that the
 * pieces use; REACH_SHARE is for the long and the fast ones. AGARD-AR-144 takes a tenth for
 * describing functions. */
static const double TONE_SHARE = 0.1, STEP_SHARE = 0.2, SLOPE_SHARE = 0.005, REACH_SHARE = 0.5;
/* Share of the highest rate that a stop's ramp-out may add: the motion goes on while its amplitude
 * is ramped out. */
static const double STOP_SHARE = 0.3;
/* Largest acceleration of the legs in tones and steps, as a multiple of limits.oscillation_mps2. */
static const double OF_OSCILLATION = 2.0;
/* Share of limits.oscillation_mps2 by which the rms acceleration of the platform may exceed that of
 * its reference, as the linear loop predicts it. */
static const double OF_ALLOWED = 0.7;
/* Largest angle of a long motion: 20 degrees, well before legs meet. */
static const double ANGLE_MOST_RAD = 0.35;
static const double REST_S = 8.0, RISE_S = 0.1, STEP_S = 0.75, QUARTER_S = 1.0, BEFORE_S = 0.3, FAST_HZ = 2.0, LONG_LEAST_HZ = 0.1,
                    FAR_RAMP = 0.3;
static const double RAMP_OUT_RATE = 1.5; /* largest rate of reference.h's envelope in unit time */
/* Largest rate and acceleration of a smooth step of unit height in unit time. */
static const double RISE_RATE = 15.0 / 8.0, RISE_ACCEL = 5.7735;

/* The linear loop at neutral, mode by mode. */
struct response {
    struct loop_plant plant[DOFS];
    const struct params *params;
    double resonance; /* largest resonance() from 1 Hz to the highest tone, at least 1; steps, and
                       * harmonics of a fast motion, may excite it */
};

/* Largest amplitude of a mode at this frequency, relative to its reference. */
static double resonance(const struct response *r, double hz) {
    double most = 0.0;
    for (int mode = 0; mode < DOFS; mode++) {
        double answer = cabs(loop_follow(&r->plant[mode], &r->params->control, 2.0 * PI * hz, r->params->loop.period_s));
        if (!(answer <= most)) most = isnan(answer) ? HUGE_VAL : answer;
    }
    return most;
}

/* Returns false if the loop cannot be computed. */
static bool find_response(struct response *r, const struct params *params, bool bus) {
    static const double neutral[DOFS] = {0};
    struct loop_place place;
    *r = (struct response){.params = params, .resonance = 1.0};
    if (!loop_place_find(&place, params, neutral, loop_delay_s(params, bus))) return false;
    for (int mode = 0; mode < DOFS; mode++) {
        const struct loop_mode_input shape = loop_place_mode(&place, mode);
        loop_plant_find(place.leg, &shape, params, &r->plant[mode]);
    }
    for (double hz = 1.0; hz <= tone_hz[QUALITY_TONES - 1]; hz *= 1.02) r->resonance = fmax(r->resonance, resonance(r, hz));
    return true;
}

/* SAFETY: the monitor of oscillations stops a motion whose rms acceleration exceeds 1.8 times the
 * reference's by limits.oscillation_mps2, and a resonance rings on when the reference has faded
 * out. Returns the amplitude of the reference's acceleration at which a response `answers` times as
 * large exceeds the reference's rms by OF_ALLOWED of that limit; infinite if answers <= 1. */
static double accel_allowed_mps2(double answers, const struct params *params) {
    return answers > 1.0 ? sqrt(2.0) * OF_ALLOWED * params->limits.oscillation_mps2 / (answers - 1.0) : HUGE_VAL;
}

/* Room that the legs have on one axis. */
struct room {
    const struct response *response;
    double metres;             /* motion of the platform, m, for a displacement of 1 */
    double leg_per_unit;       /* largest change of a leg's length for a displacement of 1 */
    double stroke_m, rate_mps, accel_mps2;
    double reach;              /* displacement with all legs within REACH_SHARE of the stroke */
};

static int cycles_of(double seconds, double step_s) { return (int)lround(seconds / step_s); }

static int divisor(int a, int b) { return b ? divisor(b, a % b) : a; }

static double free_stroke(const struct kinematics *k, const struct params *p, int leg) {
    struct stroke s = kinematics_stroke(k, &p->actuator, leg);
    double in_m = k->neutral_length_m[leg] - fmax(s.least_m, p->limits.length_min_m[leg]);
    return fmin(in_m, fmin(s.most_m, p->limits.length_max_m[leg]) - k->neutral_length_m[leg]);
}

static bool reaches(const struct kinematics *k, enum dof dof, double displacement, double most_m) {
    double pose[DOFS] = {0}, length_m[LEGS];
    pose[dof] = displacement;
    ik_lengths(k, pose, length_m);
    for (int leg = 0; leg < LEGS; leg++)
        if (!(fabs(length_m[leg] - k->neutral_length_m[leg]) <= most_m)) return false;
    return true;
}

/* Largest displacement that is reached to both sides, in steps of a hundredth of the displacement
 * that the Jacobian at neutral predicts; an angle is at most ANGLE_MOST_RAD. */
static double find_reach(const struct kinematics *k, enum dof dof, const struct room *r) {
    double most_m = REACH_SHARE * r->stroke_m, step = most_m / r->leg_per_unit / 100.0, reach = 0.0;
    for (int i = 1; i <= 100 && reaches(k, dof, i * step, most_m) && reaches(k, dof, -i * step, most_m); i++) reach = i * step;
    return dof < DOF_PHI ? reach : fmin(reach, ANGLE_MOST_RAD);
}

static struct room find_room(const struct kinematics *k, const struct response *response, enum dof dof) {
    static const double neutral[DOFS] = {0};
    const struct params *p = response->params;
    double j[LEGS][DOFS];
    struct room r = {.response = response,
                     .metres = dof < DOF_PHI ? 1.0 : k->arm_m,
                     .stroke_m = HUGE_VAL,
                     .rate_mps = multisine_rate_limit_mps(p),
                     .accel_mps2 = OF_OSCILLATION * p->limits.oscillation_mps2};
    ik_jacobian(k, neutral, j);
    for (int leg = 0; leg < LEGS; leg++) {
        r.leg_per_unit = fmax(r.leg_per_unit, fabs(j[leg][dof]));
        r.stroke_m = fmin(r.stroke_m, free_stroke(k, p, leg));
    }
    r.reach = find_reach(k, dof, &r);
    return r;
}

/* Amplitude of a sine within the share of stroke and rate, the acceleration of the legs, and the
 * limit of accel_allowed_mps2(). */
static double sine_amplitude(const struct room *r, double hz, double share, double accel_mps2, double answers) {
    double w = 2.0 * PI * hz, leg_m = fmin(share * r->stroke_m, fmin(share * r->rate_mps / w, accel_mps2 / (w * w)));
    return fmin(leg_m / r->leg_per_unit, accel_allowed_mps2(answers, r->response->params) / (w * w) / r->metres);
}

/* Appends a piece, whose evaluated cycles begin after its ramp-in and lead. */
static void add(struct quality_plan *plan, struct quality_piece piece) {
    piece.begin = plan->cycles + piece.ramp_in + piece.lead;
    plan->cycles = piece.begin + piece.samples + piece.ramp_out;
    plan->piece[plan->pieces++] = piece;
}

static struct quality_piece sine(const struct quality_plan *plan, enum quality_kind kind, enum dof dof, double hz, int periods) {
    struct quality_piece p = {.kind = kind, .dof = dof, .periods = periods, .samples = cycles_of(periods / hz, plan->step_s)};
    while (divisor(p.samples, periods) > 1) p.samples++;
    p.hz = periods / (p.samples * plan->step_s);
    p.ramp_in = cycles_of(fmax(0.4, 0.25 / hz), plan->step_s);
    p.ramp_out = cycles_of(fmax(0.4, 0.2 / hz), plan->step_s);
    return p;
}

static void add_tone(struct quality_plan *plan, enum dof dof, const struct room *r, double hz) {
    struct quality_piece p = sine(plan, QUALITY_TONE, dof, hz, (int)fmax(LEAST_PERIODS, ceil(LEAST_TONE_S * hz)));
    p.amplitude = sine_amplitude(r, p.hz, TONE_SHARE, r->accel_mps2, resonance(r->response, p.hz));
    p.lead = hz < LEAD_BELOW_HZ ? cycles_of(LEAD_S, plan->step_s) : 0;
    add(plan, p);
}

static void add_slope(struct quality_plan *plan, enum dof dof, const struct room *r) {
    add(plan, (struct quality_piece){.kind = QUALITY_SLOPE,
                                     .dof = dof,
                                     .amplitude = SLOPE_SHARE * r->rate_mps * QUARTER_S / r->leg_per_unit,
                                     .samples = QUALITY_QUARTERS * cycles_of(QUARTER_S, plan->step_s),
                                     .ramp_in = cycles_of(BEFORE_S, plan->step_s)});
}

static void add_steps(struct quality_plan *plan, enum dof dof, const struct room *r) {
    double leg_m = fmin(STEP_SHARE * r->rate_mps * RISE_S / RISE_RATE, r->accel_mps2 * RISE_S * RISE_S / RISE_ACCEL);
    double allowed = accel_allowed_mps2(r->response->resonance, r->response->params) * RISE_S * RISE_S / RISE_ACCEL / r->metres;
    add(plan, (struct quality_piece){.kind = QUALITY_STEP,
                                     .dof = dof,
                                     .amplitude = fmin(leg_m / r->leg_per_unit, allowed),
                                     .samples = QUALITY_STEPS * cycles_of(STEP_S, plan->step_s),
                                     .ramp_in = cycles_of(BEFORE_S, plan->step_s)});
}

/* Adds the long and the fast motion, which show the excursion, rate and acceleration that are
 * reached. */
static void add_reach(struct quality_plan *plan, enum dof dof, const struct room *r) {
    double rate = REACH_SHARE * r->rate_mps / r->leg_per_unit, hz = rate / (2.0 * PI * r->reach);
    struct quality_piece far = sine(plan, QUALITY_LONG, dof, fmin(fmax(hz, LONG_LEAST_HZ), FAST_HZ), 1);
    far.amplitude = fmin(r->reach, rate / (2.0 * PI * far.hz));
    far.ramp_in = far.ramp_out = (int)(FAR_RAMP * far.samples);
    add(plan, far);
    struct quality_piece fast = sine(plan, QUALITY_FAST, dof, FAST_HZ, (int)(LEAST_TONE_S * FAST_HZ));
    fast.amplitude = fmin(r->reach, sine_amplitude(r, fast.hz, REACH_SHARE, HUGE_VAL, r->response->resonance));
    add(plan, fast);
}

/* Largest change of a leg's length in an axis's pieces, by the Jacobian at neutral. */
static double way_m(const struct quality_plan *plan, enum dof dof, const struct room *r) {
    double most = 0.0;
    for (const struct quality_piece *p = plan->piece; p < plan->piece + plan->pieces; p++)
        if (p->dof == dof) most = fmax(most, p->amplitude * r->leg_per_unit);
    return most;
}

/* Returns -2 if a piece has no safe amplitude: the legs have no room, or the linear loop resonates
 * without bound. */
static int check_amplitudes(const struct quality_plan *plan, struct error *error) {
    for (const struct quality_piece *p = plan->piece; p < plan->piece + plan->pieces; p++)
        if (p->dof != DOF_NONE && !(p->amplitude > 0.0 && isfinite(p->amplitude)))
            return error_set(error, STATUS_USAGE,
                             "--qualify: no amplitude of %s is known to be safe: the legs have no room at neutral, or a mode of the linear "
                             "loop there grows: look at `hexid doctor`",
                             dof_names[p->dof]);
    return STATUS_OK;
}

int quality_plan(struct quality_plan *plan, const struct params *params, bool bus, struct error *error) {
    struct kinematics k;
    const char *refusal = params_mechanism(params)->refuses.run;
    *plan = (struct quality_plan){.step_s = params->loop.period_s};
    if (refusal) return error_set(error, STATUS_USAGE, "%s", refusal);
    if (plan->step_s < LEAST_STEP_S)
        return error_set(error, STATUS_USAGE, "--qualify: loop.period_s %g is below %g: its ten minutes would not fit the memory",
                         plan->step_s, LEAST_STEP_S);
    if (plan->step_s > MOST_STEP_S)
        return error_set(error, STATUS_USAGE, "--qualify: loop.period_s %g is above %g: noise up to 50 Hz would not be measured",
                         plan->step_s, MOST_STEP_S);
    int status = kinematics_init(&k, params, error);
    if (status) return status;
    struct response *response = malloc(sizeof *response);
    if (!response) return error_set(error, STATUS_IO, "out of memory");
    if (!find_response(response, params, bus)) {
        free(response);
        return error_set(error, STATUS_USAGE,
                         "--qualify: the linear loop at neutral is not known, and so is no amplitude (can the supply hold the platform?): "
                         "look at `hexid doctor`");
    }
    plan->arm_m = k.arm_m;
    while (plan->tones < QUALITY_TONES && tone_hz[plan->tones] * plan->step_s <= OF_RATE) plan->tones++;
    add(plan, (struct quality_piece){.dof = DOF_NONE, .samples = cycles_of(REST_S, plan->step_s)});
    for (int dof = 0; dof < DOFS; dof++) {
        struct room r = find_room(&k, response, (enum dof)dof);
        for (int i = 0; i < plan->tones; i++) add_tone(plan, (enum dof)dof, &r, tone_hz[i]);
        add_slope(plan, (enum dof)dof, &r);
        add_steps(plan, (enum dof)dof, &r);
        add_reach(plan, (enum dof)dof, &r);
        /* SAFETY: a shorter ramp-out would move the legs too fast in a stop. The planned
         * displacement counts, not the free stroke. A sine's displacement is bounded by its rate
         * over its frequency, so slow legs have a bounded ramp-out, too. */
        plan->ramp_out_s = fmax(plan->ramp_out_s, RAMP_OUT_RATE * way_m(plan, (enum dof)dof, &r) / (STOP_SHARE * r.rate_mps));
    }
    free(response);
    return check_amplitudes(plan, error);
}

/* Rises from 0 to 1 over 0 <= q <= 1, with rate and acceleration 0 at both ends. */
static double rise(double q) {
    double in = fmin(fmax(q, 0.0), 1.0);
    return in * in * in * (10.0 + in * (6.0 * in - 15.0));
}

static double steps_at(const struct quality_plan *plan, const struct quality_piece *p, int cycle) {
    int every = p->samples / QUALITY_STEPS, step = cycle / every;
    double share = rise((cycle - step * every) * plan->step_s / RISE_S);
    return p->amplitude * (step % 2 ? 1.0 - share : share);
}

/* A triangle: 0, 1, 0, -1, 0, 1, 0 at the quarters' ends. */
static double slope_at(const struct quality_piece *p, int cycle) {
    double quarter = (double)cycle * QUALITY_QUARTERS / p->samples, along = fmod(quarter + 1.0, 4.0);
    return p->amplitude * (along < 2.0 ? along - 1.0 : 3.0 - along);
}

static double sine_at(const struct quality_piece *p, int cycle) {
    double in = p->ramp_in ? rise((double)(cycle + p->lead + p->ramp_in) / p->ramp_in) : 1.0;
    double out = p->ramp_out ? rise((double)(p->samples + p->ramp_out - cycle) / p->ramp_out) : 1.0;
    return in * out * p->amplitude * sin(2.0 * PI * p->periods * ((double)cycle / p->samples));
}

double quality_piece_at(const struct quality_plan *plan, const struct quality_piece *p, int cycle) {
    if (p->periods) return sine_at(p, cycle);
    if (p->kind == QUALITY_REST || cycle < 0 || cycle >= p->samples) return 0.0;
    return p->kind == QUALITY_STEP ? steps_at(plan, p, cycle) : slope_at(p, cycle);
}

int quality_trajectory(const struct quality_plan *plan, struct trajectory *t, struct error *error) {
    *t = (struct trajectory){.knots = plan->cycles + 1, .passes = 1};
    t->knot = calloc((size_t)t->knots, sizeof *t->knot);
    if (!t->knot) return error_set(error, STATUS_IO, "out of memory");
    for (int n = 0; n < t->knots; n++) t->knot[n].time_s = n * plan->step_s;
    for (const struct quality_piece *p = plan->piece; p < plan->piece + plan->pieces; p++)
        for (int n = -p->lead - p->ramp_in; n < p->samples + p->ramp_out && p->dof != DOF_NONE; n++)
            t->knot[p->begin + n].pose[p->dof] = quality_piece_at(plan, p, n);
    return trajectory_bend(t) ? STATUS_OK : error_set(error, STATUS_IO, "out of memory");
}
