#include "oscillation.h"

#include <math.h>
#include <string.h>

#include "dynamics.h"
#include "force.h"
#include "lin.h"
#include "params.h"
#include "units.h"

static const double lag_s = 0.016, block_s = 0.05, slow_s = 0.05;
/* Largest rms white noise that is subtracted from commanded, opened and forced, as a multiple of
 * limits.oscillation_mps2. The limit is needed because a command that alternates in every cycle
 * looks like noise, too. */
static const double white_most = 2.0;

/* Noise of the readings in `measured`: this share of the squared second difference over one cycle,
 * divided by lag^3, is subtracted. The share would be 1 for isolated steps of the readings and 1 /
 * lag for white noise; slow quantised readings lie in between. */
static const double steps_share = 0.5;

enum { WHITE_CYCLES = 400, FOURTH_DIFFERENCE_SQUARES = 1 + 16 + 36 + 16 + 1 };

static void init_to_platform(struct oscillation *o, const struct params *params, const struct kinematics *k) {
    double j[LEGS][DOFS], inverse[DOFS][LEGS], inertia[LEGS][LEGS], light[LEGS][LEGS];
    ik_jacobian(k, (const double[DOFS]){0}, j);
    lin_inverse(DOFS, j[0], inverse[0]);
    for (int i = 0; i < DOFS; i++)
        for (int leg = 0; leg < LEGS; leg++) o->to_platform[leg][i] = inverse[i][leg] * (i < DOF_PHI ? 1.0 : k->arm_m);
    if (!(o->weighs = dynamics_inertia(params, k, inertia))) return;
    lin_inverse(LEGS, inertia[0], light[0]);
    for (int leg = 0; leg < LEGS; leg++)
        for (int i = 0; i < DOFS; i++)
            for (int m = 0; m < LEGS; m++) o->push[leg][i] += o->to_platform[m][i] * light[m][leg];
}

/* Advances the valve's two lags by one cycle and returns the acceleration that results. */
static double valve_lags(double speed_mps, double follows, double period_s, double *half_mps, double *valve_mps) {
    double before = *valve_mps;
    *half_mps += follows * (speed_mps - *half_mps);
    *valve_mps += follows * (*half_mps - *valve_mps);
    return (*valve_mps - before) / period_s;
}

/* Returns the mean square of a leg's acceleration if its commanded speed is white noise of variance
 * 1; this is the sum of squares of the impulse response. */
static double white_gain(double follows, double period_s) {
    double half = 0.0, valve = 0.0, sum = 0.0;
    for (int n = 0; n < WHITE_CYCLES; n++) {
        double a = valve_lags(n == 0, follows, period_s, &half, &valve);
        sum += a * a;
    }
    return sum;
}

static int cycles_of(double seconds, double period_s, int most) {
    double cycles = round(seconds / period_s);
    return cycles < 1.0 ? 1 : cycles > most ? most : (int)cycles;
}

void oscillation_init(struct oscillation *o, const struct params *params, const struct kinematics *k) {
    const struct hydraulics_params *h = &params->hydraulics;
    struct cylinder_areas areas = cylinder_areas(&params->actuator);
    double period_s = params->loop.period_s, drop_pa = (h->supply_pa - h->tank_pa) / 2.0;
    *o = (struct oscillation){.limit_mps2 = params->limits.oscillation_mps2, .period_s = period_s, .arm_m = k->arm_m};
    o->lag = cycles_of(lag_s, period_s, (OSCILLATION_PAST - 1) / 2);
    o->past = 2 * o->lag + 1;
    o->every = cycles_of(block_s, period_s, (int)(block_s / 1e-4));
    o->follows = 1.0 - exp(-2.0 * PI * h->valve_frequency_hz * period_s);
    o->white = white_gain(o->follows, period_s) / FOURTH_DIFFERENCE_SQUARES;
    init_to_platform(o, params, k);
    o->slower = 1.0 - exp(-period_s / slow_s);
    for (int leg = 0; leg < LEGS; leg++) {
        double flow_m3_per_s = h->valve_flow_m3_per_s[leg] * sqrt(drop_pa / h->valve_drop_pa);
        valve_flow_init(&o->valve[leg], leg, params, k);
        /* SAFETY: only the law `model` jumps through the dead band. For the PID the dead band is
         * taken as 0, so that its whole command counts. */
        if (params->control.law != CONTROL_MODEL) o->valve[leg].dead = 0.0;
        o->jumps |= o->valve[leg].dead > 0.0;
        o->speed_mps[leg] = 2.0 * flow_m3_per_s / (areas.a1_m2[leg] + areas.a2_m2[leg]);
    }
}

static void weigh(const struct oscillation *o, const double pose[DOFS], double weighed[DOFS]) {
    for (int i = 0; i < DOFS; i++) weighed[i] = pose[i] * (i < DOF_PHI ? 1.0 : o->arm_m);
}

void oscillation_reset(struct oscillation *o, const double pose[DOFS]) {
    memset(&o->sum, 0, sizeof o->sum);
    memset(o->block, 0, sizeof o->block);
    memset(&o->commanded, 0, sizeof o->commanded);
    memset(&o->opened, 0, sizeof o->opened);
    memset(o->forced_mps2, 0, sizeof o->forced_mps2);
    o->knows_force = false;
    for (int n = 0; n < o->past; n++) {
        weigh(o, pose, o->pose[n]);
        weigh(o, pose, o->ref[n]);
    }
    o->newest = 0, o->in_block = 0, o->legs = 0;
    o->found_mps2 = o->allowed_mps2 = 0.0;
}

/* Returns the index of the pose that is `ago` cycles older than the newest. */
static int place(const struct oscillation *o, int ago) { return o->newest - ago + (o->newest < ago ? o->past : 0); }

/* Returns the squared norm, over all six coordinates, of the second difference with a step of `lag`
 * cycles. */
static double second_difference(const struct oscillation *o, double (*past)[DOFS], int lag) {
    const double *now = past[o->newest], *then = past[place(o, lag)], *before = past[place(o, 2 * lag)];
    double square = 0.0, dt_s = lag * o->period_s;
    for (int i = 0; i < DOFS; i++) {
        double d = (now[i] - 2.0 * then[i] + before[i]) / (dt_s * dt_s);
        square += d * d;
    }
    return square;
}

static void take_pose(struct oscillation *o, const double pose[DOFS], const double ref[DOFS]) {
    double cubed = (double)o->lag * o->lag * o->lag;
    o->newest = place(o, 2 * o->lag); /* overwrites the oldest pose */
    weigh(o, pose, o->pose[o->newest]);
    weigh(o, ref, o->ref[o->newest]);
    double steps = o->lag > 1 ? steps_share * second_difference(o, o->pose, 1) / cubed : 0.0;
    o->sum.measured += second_difference(o, o->pose, o->lag) - steps;
    o->sum.asked_measured += second_difference(o, o->ref, o->lag);
    o->sum.asked_commanded += second_difference(o, o->ref, 1);
}

/* Adds a value to the last five, and returns their fourth difference. */
static double fourth_difference(double past[5], double now) {
    memmove(past + 1, past, 4 * sizeof *past);
    past[0] = now;
    return past[0] - 4.0 * past[1] + 6.0 * past[2] - 4.0 * past[3] + past[4];
}

/* Adds to *square the squared acceleration of the platform that corresponds to these valve
 * openings, to *white the noise in it, and to leg_square the squared acceleration of each leg. */
static void take_valves(const struct oscillation *o, struct oscillation_valves *v, const double opening[LEGS], double *square,
                        double *white, double leg_square[LEGS]) {
    double mps2[DOFS] = {0}, fourth_mps[DOFS] = {0};
    for (int leg = 0; leg < LEGS; leg++) {
        double leg_fourth_mps = fourth_difference(v->asked_mps[leg], o->speed_mps[leg] * opening[leg]);
        double leg_mps2 = valve_lags(v->asked_mps[leg][0], o->follows, o->period_s, &v->half_mps[leg], &v->valve_mps[leg]);
        leg_square[leg] += leg_mps2 * leg_mps2;
        for (int i = 0; i < DOFS; i++) {
            mps2[i] += o->to_platform[leg][i] * leg_mps2;
            fourth_mps[i] += o->to_platform[leg][i] * leg_fourth_mps;
        }
    }
    for (int i = 0; i < DOFS; i++) {
        *square += mps2[i] * mps2[i];
        *white += o->white * fourth_mps[i] * fourth_mps[i];
    }
}

static void take_command(struct oscillation *o, const double valve[LEGS]) {
    double opening[LEGS];
    for (int leg = 0; leg < LEGS; leg++) opening[leg] = valve_flow_opened(&o->valve[leg], valve[leg]);
    take_valves(o, &o->opened, opening, &o->sum.opened, &o->sum.opened_white, o->sum.leg);
    if (o->jumps) take_valves(o, &o->commanded, valve, &o->sum.commanded, &o->sum.white, o->sum.leg);
}

/* SAFETY: without trusted forces, or with an unknown inertia, `forced` counts as infinite, so that
 * jumps of the commands are not disregarded. */
static void take_force(struct oscillation *o, const double force_n[LEGS]) {
    double mps2[DOFS] = {0};
    if (!force_n || !o->weighs) {
        o->sum.forced = (double)INFINITY;
        return;
    }
    for (int leg = 0; leg < LEGS; leg++) {
        if (!o->knows_force) o->slow_n[leg] = force_n[leg];
        o->slow_n[leg] += o->slower * (force_n[leg] - o->slow_n[leg]);
        for (int i = 0; i < DOFS; i++) mps2[i] += o->push[leg][i] * (force_n[leg] - o->slow_n[leg]);
    }
    o->knows_force = true;
    for (int i = 0; i < DOFS; i++) {
        double fourth_mps2 = fourth_difference(o->forced_mps2[i], mps2[i]);
        o->sum.forced += mps2[i] * mps2[i];
        o->sum.forced_white += fourth_mps2 * fourth_mps2 / FOURTH_DIFFERENCE_SQUARES;
    }
}

/* Returns the root of the second smallest mean square; four of the five blocks reach it. */
static double four_of_five(const double square[OSCILLATION_BLOCKS]) {
    double least = (double)INFINITY, second = (double)INFINITY;
    for (int n = 0; n < OSCILLATION_BLOCKS; n++) {
        second = fmin(second, fmax(least, square[n]));
        least = fmin(least, square[n]);
    }
    return sqrt(fmax(second, 0.0));
}

static uint32_t swinging_legs(const struct oscillation *o) {
    double leg[LEGS] = {0}, most = 0.0;
    uint32_t legs = 0;
    for (int i = 0; i < LEGS; i++) {
        for (int n = 0; n < OSCILLATION_BLOCKS; n++) leg[i] += o->block[n].leg[i];
        most = fmax(most, leg[i]);
    }
    for (int i = 0; i < LEGS; i++)
        if (leg[i] >= 0.25 * most) legs |= fault_leg(i); /* half of the largest amplitude or more */
    return legs;
}

static void judge(struct oscillation *o) {
    double measured[OSCILLATION_BLOCKS], commanded[OSCILLATION_BLOCKS], opened[OSCILLATION_BLOCKS], forced[OSCILLATION_BLOCKS];
    double asked_measured = 0.0, asked_commanded = 0.0, white_mps2 = white_most * o->limit_mps2, white = white_mps2 * white_mps2;
    for (int n = 0; n < OSCILLATION_BLOCKS; n++) {
        const struct oscillation_block *b = &o->block[n];
        measured[n] = b->measured, commanded[n] = b->commanded - fmin(b->white, white);
        opened[n] = b->opened - fmin(b->opened_white, white), forced[n] = b->forced - fmin(b->forced_white, white);
        asked_measured += b->asked_measured, asked_commanded += b->asked_commanded;
    }
    double allowed[] = {o->limit_mps2 + OSCILLATION_ASKED * sqrt(asked_measured / OSCILLATION_BLOCKS),
                        o->limit_mps2 + OSCILLATION_ASKED * sqrt(asked_commanded / OSCILLATION_BLOCKS)};
    /* SAFETY: `opened` counts by itself; `commanded`, which also contains jumps through the dead
     * band, counts only together with `forced`. */
    double jump_mps2 = fmin(four_of_five(commanded), four_of_five(forced) - o->limit_mps2);
    double found[] = {four_of_five(measured), fmax(four_of_five(opened), jump_mps2)};
    int worse = found[1] - allowed[1] > found[0] - allowed[0];
    o->found_mps2 = found[worse], o->allowed_mps2 = allowed[worse];
    o->legs = o->found_mps2 > o->allowed_mps2 ? swinging_legs(o) : 0;
}

/* Divides the sums of a complete block, except those of the legs, by its number of cycles. */
static void close_block(struct oscillation *o) {
    struct oscillation_block *s = &o->sum;
    double *const sums[] = {&s->measured,     &s->commanded,    &s->opened,         &s->forced,         &s->white,
                            &s->opened_white, &s->forced_white, &s->asked_measured, &s->asked_commanded};
    for (size_t n = 0; n < sizeof sums / sizeof *sums; n++) *sums[n] /= o->every;
    memmove(o->block + 1, o->block, (OSCILLATION_BLOCKS - 1) * sizeof *o->block);
    o->block[0] = *s;
    memset(s, 0, sizeof *s);
}

bool oscillation_step(struct oscillation *o, const double pose[DOFS], const double ref[DOFS], const double valve[LEGS],
                      const double force_n[LEGS]) {
    take_pose(o, pose, ref);
    take_command(o, valve);
    if (o->jumps) take_force(o, force_n);
    if (++o->in_block == o->every) {
        o->in_block = 0;
        close_block(o);
        judge(o);
    }
    return o->legs != 0;
}
