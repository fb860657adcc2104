#include "loop_poles.h"

#include <math.h>
#include <string.h>

#include "force.h"
#include "lin.h"
#include "units.h"

/* Pressures in units of UNIT_PA, the spool's rate in units of its bandwidth, so that all rates
 * are of one order. */
enum { LENGTH, RATE, P1, P2, SPOOL, SPOOL_RATE, PLANT, INTEGRAL = PLANT, DERIVATIVE, ERROR, FORCE_LP, STATES_ALL, INPUT = PLANT };
enum { HALVINGS = 10, TERMS = 12 };
static const double UNIT_PA = 1e7;
static const double LEAST_LAG_S = 1e-4;
static const double OSCILLATES = 0.95; /* damping ratio: above, a step shows no overshoot */

/* One cylinder and the mass that it moves. */
struct cylinder_loop {
    double mass_kg, viscous, lag_s;
    struct oil_chamber chamber[2];
    double a1_m2, a2_m2;
};

static struct cylinder_loop mean_cylinder(const struct oil_leg leg[LEGS], const struct oil_mode *mode, const double viscous[LEGS],
                                          const struct params *params) {
    struct cylinder_loop c = {.mass_kg = mode->mass_kg};
    struct cylinder_areas areas = cylinder_areas(&params->actuator);
    double sum = 0.0, delay_s = 0.0;
    for (int k = 0; k < LEGS; k++) sum += mode->motion[k] * mode->motion[k];
    for (int k = 0; k < LEGS; k++) {
        double weight = mode->motion[k] * mode->motion[k] / sum;
        c.viscous += weight * viscous[k], delay_s += weight * leg[k].delay_s;
        c.a1_m2 += weight * areas.a1_m2[k], c.a2_m2 += weight * areas.a2_m2[k];
        for (int i = 0; i < 2; i++) {
            const struct oil_chamber *from = &leg[k].chamber[i];
            c.chamber[i].push += weight * from->push, c.chamber[i].other += weight * from->other;
            c.chamber[i].open += weight * from->open, c.chamber[i].sag += weight * from->sag;
        }
    }
    c.lag_s = fmax(delay_s - 0.5 * params->loop.period_s, LEAST_LAG_S);
    return c;
}

/* Rates of the plant's states, the last column for the command. */
static void fill_rates(const struct cylinder_loop *c, double a[PLANT + 1][PLANT + 1]) {
    double bandwidth = 2.0 / c->lag_s;
    memset(a, 0, (PLANT + 1) * sizeof *a);
    a[LENGTH][RATE] = 1.0;
    a[RATE][RATE] = -c->viscous / c->mass_kg;
    a[RATE][P1] = c->a1_m2 * UNIT_PA / c->mass_kg, a[RATE][P2] = -c->a2_m2 * UNIT_PA / c->mass_kg;
    a[P1][RATE] = -c->chamber[0].push / UNIT_PA, a[P2][RATE] = c->chamber[1].push / UNIT_PA;
    a[P1][P1] = -c->chamber[0].sag, a[P1][P2] = c->chamber[0].other;
    a[P2][P2] = -c->chamber[1].sag, a[P2][P1] = c->chamber[1].other;
    a[P1][SPOOL] = c->chamber[0].open / UNIT_PA, a[P2][SPOOL] = c->chamber[1].open / UNIT_PA;
    a[SPOOL][SPOOL_RATE] = bandwidth;
    a[SPOOL_RATE][SPOOL] = -bandwidth, a[SPOOL_RATE][SPOOL_RATE] = -2.0 * bandwidth, a[SPOOL_RATE][INPUT] = bandwidth;
}

static void multiply(double a[PLANT + 1][PLANT + 1], double b[PLANT + 1][PLANT + 1], double product[PLANT + 1][PLANT + 1]) {
    double sum[PLANT + 1][PLANT + 1] = {{0}};
    for (int i = 0; i <= PLANT; i++)
        for (int j = 0; j <= PLANT; j++)
            for (int k = 0; k <= PLANT; k++) sum[i][j] += a[i][k] * b[k][j];
    memcpy(product, sum, sizeof sum);
}

/* exp(a t), in place: series of a thousandth of it, squared ten times. */
static void exponential(double a[PLANT + 1][PLANT + 1], double t_s) {
    double sum[PLANT + 1][PLANT + 1] = {{0}}, term[PLANT + 1][PLANT + 1] = {{0}};
    for (int i = 0; i <= PLANT; i++) {
        sum[i][i] = term[i][i] = 1.0;
        for (int j = 0; j <= PLANT; j++) a[i][j] *= ldexp(t_s, -HALVINGS);
    }
    for (int n = 1; n <= TERMS; n++) {
        multiply(term, a, term);
        for (int i = 0; i <= PLANT; i++)
            for (int j = 0; j <= PLANT; j++) term[i][j] /= n, sum[i][j] += term[i][j];
    }
    for (int n = 0; n < HALVINGS; n++) multiply(sum, sum, sum);
    memcpy(a, sum, sizeof sum);
}

/* From one sample to the next, the reference at rest: the controller as in pid.h,
 * without its limits. */
static void fill_cycle(const struct cylinder_loop *c, const struct control_params *g, double dt_s, double cycle[STATES_ALL][STATES_ALL]) {
    double plant[PLANT + 1][PLANT + 1], command[STATES_ALL] = {0}, force[STATES_ALL] = {0};
    double derive = dt_s / (g->tf + dt_s), low_pass = dt_s / (g->tp + dt_s), unit_n = UNIT_PA * c->a1_m2;
    memset(cycle, 0, STATES_ALL * sizeof *cycle);
    force[P1] = c->a1_m2 * UNIT_PA / unit_n, force[P2] = -c->a2_m2 * UNIT_PA / unit_n;
    cycle[INTEGRAL][INTEGRAL] = 1.0, cycle[INTEGRAL][LENGTH] = -g->ki * dt_s;
    cycle[DERIVATIVE][DERIVATIVE] = 1.0 - derive, cycle[DERIVATIVE][LENGTH] = -derive / dt_s, cycle[DERIVATIVE][ERROR] = -derive / dt_s;
    cycle[ERROR][LENGTH] = -1.0;
    for (int i = 0; i < STATES_ALL; i++) cycle[FORCE_LP][i] = low_pass * force[i] + (i == FORCE_LP ? 1.0 - low_pass : 0.0);
    for (int i = 0; i < STATES_ALL; i++)
        command[i] = (i == LENGTH ? -g->kp : 0.0) + cycle[INTEGRAL][i] + g->kd * cycle[DERIVATIVE][i] -
                     g->kpf * unit_n * (force[i] - cycle[FORCE_LP][i]);
    fill_rates(c, plant);
    exponential(plant, dt_s);
    for (int r = 0; r < PLANT; r++)
        for (int i = 0; i < STATES_ALL; i++) cycle[r][i] = (i < PLANT ? plant[r][i] : 0.0) + plant[r][INPUT] * command[i];
}

struct loop_mode loop_poles(const struct oil_leg leg[LEGS], const struct oil_mode *mode, const double viscous[LEGS],
                            const struct params *params) {
    struct loop_mode found = {.hz = (double)NAN, .damping = (double)NAN};
    struct cylinder_loop c = mean_cylinder(leg, mode, viscous, params);
    double cycle[STATES_ALL][STATES_ALL], re[STATES_ALL], im[STATES_ALL], least = HUGE_VAL, dt_s = params->loop.period_s;
    fill_cycle(&c, &params->control, dt_s, cycle);
    if (lin_poles(STATES_ALL, cycle[0], re, im)) return found;
    for (int i = 0; i < STATES_ALL; i++) {
        double decay = log(hypot(re[i], im[i])) / dt_s, omega = atan2(im[i], re[i]) / dt_s, size = hypot(decay, omega);
        if (!(omega > 0.0) || !(-decay < OSCILLATES * size) || !(size < least)) continue;
        least = size;
        found = (struct loop_mode){.hz = size / (2.0 * PI), .damping = -decay / size};
    }
    return found;
}
