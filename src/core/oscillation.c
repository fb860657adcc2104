#include "oscillation.h"

#include <math.h>
#include <string.h>

#include "force.h"
#include "params.h"
#include "units.h"

static const double lag_s = 0.016, block_s = 0.05;
/* At most this times limits.oscillation_mps2 is subtracted from the command's acceleration as white
 * noise: a command that alternates every cycle looks like noise, too. */
static const double white_most = 2.0;

/* Steps of the readings are subtracted as this share of lag^-3 times the mean square over one
 * cycle. Isolated steps would need a share of 1, white noise one of 1 / lag; slow quantised
 * readings lie between. */
static const double steps_share = 0.5;

enum { WHITE_CYCLES = 400, FOURTH_DIFFERENCE_SQUARES = 1 + 16 + 36 + 16 + 1 };

/* Inverts a matrix by Gauss-Jordan elimination with pivots; kinematics_init() has found the
 * Jacobian regular. */
static void invert(double m[DOFS][2 * DOFS]) {
    for (int c = 0; c < DOFS; c++) {
        int best = c;
        for (int r = c; r < DOFS; r++)
            if (fabs(m[r][c]) > fabs(m[best][c])) best = r;
        for (int j = 0; j < 2 * DOFS; j++) {
            double swap = m[c][j];
            m[c][j] = m[best][j], m[best][j] = swap;
        }
        double pivot = m[c][c];
        for (int j = 0; j < 2 * DOFS; j++) m[c][j] /= pivot;
        for (int r = 0; r < DOFS; r++) {
            double factor = m[r][c];
            for (int j = 0; j < 2 * DOFS && r != c; j++) m[r][j] -= factor * m[c][j];
        }
    }
}

static void init_to_platform(struct oscillation *o, const struct kinematics *k) {
    double j[LEGS][DOFS], m[DOFS][2 * DOFS] = {{0}};
    ik_jacobian(k, (const double[DOFS]){0}, j);
    for (int r = 0; r < DOFS; r++) {
        memcpy(m[r], j[r], sizeof j[r]);
        m[r][DOFS + r] = 1.0;
    }
    invert(m);
    for (int i = 0; i < DOFS; i++)
        for (int leg = 0; leg < LEGS; leg++) o->to_platform[leg][i] = m[i][DOFS + leg] * (i < DOF_PHI ? 1.0 : k->arm_m);
}

/* Advances the valve's two lags by one cycle and returns the acceleration that results. */
static double valve_lags(double speed_mps, double follows, double period_s, double *half_mps, double *valve_mps) {
    double before = *valve_mps;
    *half_mps += follows * (speed_mps - *half_mps);
    *valve_mps += follows * (*half_mps - *valve_mps);
    return (*valve_mps - before) / period_s;
}

/* Returns the mean square of the acceleration from white commands: the sum of squares of the
 * impulse response. */
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
    init_to_platform(o, k);
    for (int leg = 0; leg < LEGS; leg++) {
        double flow_m3_per_s = h->valve_flow_m3_per_s[leg] * sqrt(drop_pa / h->valve_drop_pa);
        o->speed_mps[leg] = 2.0 * flow_m3_per_s / (areas.a1_m2[leg] + areas.a2_m2[leg]);
    }
}

static void weigh(const struct oscillation *o, const double pose[DOFS], double weighed[DOFS]) {
    for (int i = 0; i < DOFS; i++) weighed[i] = pose[i] * (i < DOF_PHI ? 1.0 : o->arm_m);
}

void oscillation_reset(struct oscillation *o, const double pose[DOFS]) {
    memset(&o->sum, 0, sizeof o->sum);
    memset(o->block, 0, sizeof o->block);
    memset(o->asked_mps, 0, sizeof o->asked_mps);
    memset(o->half_mps, 0, sizeof o->half_mps);
    memset(o->valve_mps, 0, sizeof o->valve_mps);
    for (int n = 0; n < o->past; n++) {
        weigh(o, pose, o->pose[n]);
        weigh(o, pose, o->ref[n]);
    }
    o->newest = 0, o->in_block = 0, o->legs = 0;
    o->found_mps2 = o->allowed_mps2 = 0.0;
}

/* Returns the place of the pose of `ago` cycles before the newest. */
static int place(const struct oscillation *o, int ago) { return o->newest - ago + (o->newest < ago ? o->past : 0); }

/* Returns the squared norm of the second difference over `lag` cycles, of all six coordinates. */
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

static void take_command(struct oscillation *o, const double valve[LEGS]) {
    double mps2[DOFS] = {0}, fourth_mps[DOFS] = {0};
    for (int leg = 0; leg < LEGS; leg++) {
        double *v = o->asked_mps[leg];
        memmove(v + 1, v, 4 * sizeof *v);
        v[0] = o->speed_mps[leg] * valve[leg];
        double leg_fourth_mps = v[0] - 4.0 * v[1] + 6.0 * v[2] - 4.0 * v[3] + v[4];
        double leg_mps2 = valve_lags(v[0], o->follows, o->period_s, &o->half_mps[leg], &o->valve_mps[leg]);
        o->sum.leg[leg] += leg_mps2 * leg_mps2;
        for (int i = 0; i < DOFS; i++) {
            mps2[i] += o->to_platform[leg][i] * leg_mps2;
            fourth_mps[i] += o->to_platform[leg][i] * leg_fourth_mps;
        }
    }
    for (int i = 0; i < DOFS; i++) {
        o->sum.commanded += mps2[i] * mps2[i];
        o->sum.white += o->white * fourth_mps[i] * fourth_mps[i];
    }
}

/* Returns the second smallest value, which four of the five blocks reach or exceed. */
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
    double measured[OSCILLATION_BLOCKS], commanded[OSCILLATION_BLOCKS], asked_measured = 0.0, asked_commanded = 0.0;
    double white_mps2 = white_most * o->limit_mps2;
    for (int n = 0; n < OSCILLATION_BLOCKS; n++) {
        measured[n] = o->block[n].measured;
        commanded[n] = o->block[n].commanded - fmin(o->block[n].white, white_mps2 * white_mps2);
        asked_measured += o->block[n].asked_measured, asked_commanded += o->block[n].asked_commanded;
    }
    double found[] = {four_of_five(measured), four_of_five(commanded)};
    double allowed[] = {o->limit_mps2 + OSCILLATION_ASKED * sqrt(asked_measured / OSCILLATION_BLOCKS),
                        o->limit_mps2 + OSCILLATION_ASKED * sqrt(asked_commanded / OSCILLATION_BLOCKS)};
    int worse = found[1] - allowed[1] > found[0] - allowed[0];
    o->found_mps2 = found[worse], o->allowed_mps2 = allowed[worse];
    o->legs = o->found_mps2 > o->allowed_mps2 ? swinging_legs(o) : 0;
}

/* Turns the sums of a complete block into its means. */
static void close_block(struct oscillation *o) {
    struct oscillation_block *s = &o->sum;
    double *const sums[] = {&s->measured, &s->commanded, &s->white, &s->asked_measured, &s->asked_commanded};
    for (size_t n = 0; n < sizeof sums / sizeof *sums; n++) *sums[n] /= o->every;
    memmove(o->block + 1, o->block, (OSCILLATION_BLOCKS - 1) * sizeof *o->block);
    o->block[0] = *s;
    memset(s, 0, sizeof *s);
}

bool oscillation_step(struct oscillation *o, const double pose[DOFS], const double ref[DOFS], const double valve[LEGS]) {
    take_pose(o, pose, ref);
    take_command(o, valve);
    if (++o->in_block == o->every) {
        o->in_block = 0;
        close_block(o);
        judge(o);
    }
    return o->legs != 0;
}
