#include "loop_poles.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "force.h"
#include "lin.h"
#include "params.h"
#include "units.h"

/* States of the sampled loop: first the plant's, then the controller's, then commands on their way.
 * For conditioning, pressures are in units of UNIT_PA and the spool's rate is in units of its
 * bandwidth. */
enum { LENGTH, RATE, P1, P2, SPOOL, SPOOL_RATE, PLANT, INTEGRAL = PLANT, DERIVATIVE, ERROR, FORCE_LP, SENT, INPUT = PLANT };
enum { READ_LENGTH, READ_FORCE, READINGS };
enum { HALVINGS = 10, TERMS = 12, DOUBLINGS = 24 /* at most 2^24 cycles are added up */ };
static const double UNIT_PA = 1e7;
static const double UNIFORM_SQUARE = 1.0 / 12.0; /* variance of an error that is uniform over an
                                                  * interval of 1 */
static const double LEAST_LAG_S = 1e-4;
static const double NOTHING = 1e-30; /* the square of a factor below this is lost in rounding */
static const double OSCILLATES = 0.95; /* a pair of poles counts as oscillating if its damping ratio
                                        * is less than this; with more a step hardly overshoots */

/* Frequencies of a response: a logarithmic sweep from LOW times the oil's frequency to
 * NYQUIST_SHARE of half the sampling rate, and more frequencies on either side of the oil's
 * frequency, at distances of PEAK_FROM to PEAK_TO times this frequency. */
enum { SWEEP = 120, PEAK = (LOOP_ANSWERS - SWEEP) / 2 };
static const double LOW = 1e-3, PEAK_FROM = 1e-3, PEAK_TO = 0.5, NYQUIST_SHARE = 0.98;

/* One cylinder with the mass that it moves. */
struct cylinder_loop {
    double mass_kg, gain;
    struct loop_leg leg;
    double a1_m2, a2_m2;
};

/* One cycle of the loop as a linear map of its states: those of the enum above, then commands on
 * their way, then lengths that are not yet read, newest first. */
struct cycle_map {
    int sent, read, size;
    double map[LOOP_POLES][LOOP_POLES];
    double noise[READINGS][LOOP_POLES]; /* change of the states by an error of 1 m or 1 N in a
                                         * reading */
};

static struct cylinder_loop mean_cylinder(const struct loop_leg leg[LEGS], const struct loop_mode_input *shape,
                                          const struct params *params) {
    struct cylinder_loop c = {.mass_kg = shape->mass_kg, .gain = shape->gain};
    struct cylinder_areas areas = cylinder_areas(&params->actuator);
    double sum = 0.0;
    for (int k = 0; k < LEGS; k++) sum += shape->motion[k] * shape->motion[k];
    for (int k = 0; k < LEGS; k++) {
        double weight = shape->motion[k] * shape->motion[k] / sum;
        const struct loop_leg *from = &leg[k];
        c.leg.viscous += weight * from->viscous, c.leg.feedback_cut += weight * from->feedback_cut;
        c.leg.spool_radps += weight * from->spool_radps, c.leg.spool_damping += weight * from->spool_damping;
        c.leg.command_delay_s += weight * from->command_delay_s, c.leg.length_delay_s += weight * from->length_delay_s;
        c.a1_m2 += weight * areas.a1_m2[k], c.a2_m2 += weight * areas.a2_m2[k];
        for (int i = 0; i < 2; i++) {
            struct oil_chamber *to = &c.leg.chamber[i];
            to->push += weight * from->chamber[i].push, to->other += weight * from->chamber[i].other;
            to->open += weight * from->chamber[i].open, to->sag += weight * from->chamber[i].sag;
        }
    }
    return c;
}

/* Fills the matrix of the plant's state equation; its last column is for the command. */
static void fill_rates(const struct cylinder_loop *c, double a[PLANT + 1][PLANT + 1]) {
    const struct oil_chamber *chamber = c->leg.chamber;
    double bandwidth = c->leg.spool_radps;
    memset(a, 0, (PLANT + 1) * sizeof *a);
    a[LENGTH][RATE] = 1.0;
    a[RATE][RATE] = -c->leg.viscous / c->mass_kg;
    a[RATE][P1] = c->a1_m2 * UNIT_PA / c->mass_kg, a[RATE][P2] = -c->a2_m2 * UNIT_PA / c->mass_kg;
    a[P1][RATE] = -chamber[0].push / UNIT_PA, a[P2][RATE] = chamber[1].push / UNIT_PA;
    a[P1][P1] = -chamber[0].sag, a[P1][P2] = chamber[0].other;
    a[P2][P2] = -chamber[1].sag, a[P2][P1] = chamber[1].other;
    a[P1][SPOOL] = chamber[0].open / UNIT_PA, a[P2][SPOOL] = chamber[1].open / UNIT_PA;
    a[SPOOL][SPOOL_RATE] = bandwidth;
    a[SPOOL_RATE][SPOOL] = -bandwidth, a[SPOOL_RATE][INPUT] = bandwidth;
    a[SPOOL_RATE][SPOOL_RATE] = -2.0 * c->leg.spool_damping * bandwidth;
}

static void multiply(double a[PLANT + 1][PLANT + 1], double b[PLANT + 1][PLANT + 1], double product[PLANT + 1][PLANT + 1]) {
    double sum[PLANT + 1][PLANT + 1] = {{0}};
    for (int i = 0; i <= PLANT; i++)
        for (int j = 0; j <= PLANT; j++)
            for (int k = 0; k <= PLANT; k++) sum[i][j] += a[i][k] * b[k][j];
    memcpy(product, sum, sizeof sum);
}

/* Computes exp(a t): halves the argument until the series converges quickly, then squares the
 * result as often. */
static void exponential(double rates[PLANT + 1][PLANT + 1], double t_s, double result[PLANT + 1][PLANT + 1]) {
    double sum[PLANT + 1][PLANT + 1] = {{0}}, term[PLANT + 1][PLANT + 1] = {{0}}, a[PLANT + 1][PLANT + 1], norm = 0.0;
    for (int i = 0; i <= PLANT; i++) {
        double row = 0.0;
        for (int j = 0; j <= PLANT; j++) row += fabs(rates[i][j]) * t_s;
        norm = fmax(norm, row);
    }
    int halvings = norm > 1.0 && isfinite(norm) ? HALVINGS + ilogb(norm) : HALVINGS;
    for (int i = 0; i <= PLANT; i++) {
        sum[i][i] = term[i][i] = 1.0;
        for (int j = 0; j <= PLANT; j++) a[i][j] = ldexp(rates[i][j] * t_s, -halvings);
    }
    for (int n = 1; n <= TERMS; n++) {
        multiply(term, a, term);
        for (int i = 0; i <= PLANT; i++)
            for (int j = 0; j <= PLANT; j++) term[i][j] /= n, sum[i][j] += term[i][j];
    }
    for (int n = 0; n < halvings; n++) multiply(sum, sum, sum);
    memcpy(result, sum, sizeof sum);
}

/* A delay as a number of whole cycles and a part of one. */
struct delay {
    int whole;
    double part;
};

static struct delay delay_cycles(double delay_s, double dt_s) {
    double cycles = fmin(fmax(delay_s / dt_s, 0.0), LOOP_DELAY_MOST), whole = floor(cycles + 1e-9);
    return (struct delay){.whole = (int)whole, .part = fmax(cycles - whole, 0.0)};
}

/* Number of earlier commands, or lengths, that a delay needs: one for each whole cycle, and one
 * more for a part of a cycle. */
static int kept(struct delay d) { return d.whole + (d.part > 0.0); }

/* Fills the rows of the controller's states, and the command, each as a combination of the states
 * at a sample. The controller is pid.h without its limits, with a constant reference. late: delay
 * of the length's reading. error: change of the command by an error of each reading. */
static void fill_controller(const struct cylinder_loop *c, const struct control_params *g, double dt_s, struct delay late,
                            struct cycle_map *m, double command[LOOP_POLES], double error[READINGS]) {
    double derive = dt_s / (g->tf + dt_s), low_pass = dt_s / (g->tp + dt_s), unit_n = UNIT_PA * c->a1_m2;
    double kp = c->gain * g->kp, ki = c->gain * g->ki, kd = c->gain * g->kd, kpf = g->kpf * (1.0 - c->leg.feedback_cut);
    double length[LOOP_POLES] = {0}, force[LOOP_POLES] = {0};
    int oldest = SENT + m->sent;
    if (late.whole > 0) length[oldest + late.whole - 1] = 1.0 - late.part;
    else length[LENGTH] = 1.0 - late.part;
    if (late.part > 0.0) length[oldest + late.whole] = late.part;
    force[P1] = c->a1_m2 * UNIT_PA / unit_n, force[P2] = -c->a2_m2 * UNIT_PA / unit_n;
    m->map[INTEGRAL][INTEGRAL] = m->map[FORCE_LP][FORCE_LP] = 1.0;
    m->map[FORCE_LP][FORCE_LP] -= low_pass;
    m->map[DERIVATIVE][DERIVATIVE] = 1.0 - derive, m->map[DERIVATIVE][ERROR] = -derive / dt_s;
    for (int i = 0; i < m->size; i++) {
        m->map[INTEGRAL][i] -= ki * dt_s * length[i];
        m->map[DERIVATIVE][i] -= derive / dt_s * length[i];
        m->map[ERROR][i] = -length[i];
        m->map[FORCE_LP][i] += low_pass * force[i];
        command[i] = -kp * length[i] + m->map[INTEGRAL][i] + kd * m->map[DERIVATIVE][i] - kpf * unit_n * (force[i] - m->map[FORCE_LP][i]);
    }
    m->noise[READ_LENGTH][INTEGRAL] = -ki * dt_s, m->noise[READ_LENGTH][DERIVATIVE] = -derive / dt_s;
    m->noise[READ_LENGTH][ERROR] = -1.0, m->noise[READ_FORCE][FORCE_LP] = low_pass / unit_n;
    error[READ_LENGTH] = -kp - ki * dt_s - kd * derive / dt_s;
    error[READ_FORCE] = -kpf * (1.0 - low_pass);
}

/* Fills the rows of the plant's states for one cycle, in which the older command acts for d.part of
 * the cycle, then the newer one. */
static void fill_plant(const struct cylinder_loop *c, double dt_s, struct delay d, const double command[LOOP_POLES],
                       const double error[READINGS], struct cycle_map *m) {
    double rates[PLANT + 1][PLANT + 1], first[PLANT + 1][PLANT + 1], then[PLANT + 1][PLANT + 1], all[PLANT + 1][PLANT + 1];
    fill_rates(c, rates);
    exponential(rates, d.part * dt_s, first);
    exponential(rates, (1.0 - d.part) * dt_s, then);
    multiply(then, first, all);
    for (int r = 0; r < PLANT; r++) {
        double before = 0.0; /* effect of the older command */
        for (int i = 0; i < PLANT; i++) before += then[r][i] * first[i][INPUT];
        for (int i = 0; i < PLANT; i++) m->map[r][i] = all[r][i];
        if (d.part > 0.0) m->map[r][SENT + d.whole] += before;
        if (d.whole > 0) m->map[r][SENT + d.whole - 1] += then[r][INPUT];
        for (int i = 0; i < m->size && d.whole == 0; i++) m->map[r][i] += then[r][INPUT] * command[i];
        for (int n = 0; n < READINGS && d.whole == 0; n++) m->noise[n][r] = then[r][INPUT] * error[n];
    }
}

/* Fills the map of the states from one sample to the next. */
static void fill_cycle(const struct cylinder_loop *c, const struct params *params, struct cycle_map *m) {
    double dt_s = params->loop.period_s, command[LOOP_POLES] = {0}, error[READINGS];
    struct delay sent = delay_cycles(c->leg.command_delay_s, dt_s), late = delay_cycles(c->leg.length_delay_s, dt_s);
    memset(m, 0, sizeof *m);
    m->sent = kept(sent), m->read = kept(late), m->size = SENT + m->sent + m->read;
    fill_controller(c, &params->control, dt_s, late, m, command, error);
    fill_plant(c, dt_s, sent, command, error, m);
    for (int n = 0; n < READINGS && m->sent; n++) m->noise[n][SENT] = error[n];
    for (int i = 0; i < m->sent; i++)
        for (int s = 0; s < m->size; s++) m->map[SENT + i][s] = i ? s == SENT + i - 1 : command[s];
    for (int i = 0; i < m->read; i++) m->map[SENT + m->sent + i][i ? SENT + m->sent + i - 1 : LENGTH] = 1.0;
}

int loop_poles_all(const struct loop_leg leg[LEGS], const struct loop_mode_input *shape, const struct params *params,
                   struct loop_pole pole[LOOP_POLES]) {
    struct cylinder_loop c = mean_cylinder(leg, shape, params);
    struct cycle_map m;
    double square[LOOP_POLES * LOOP_POLES], re[LOOP_POLES], im[LOOP_POLES], dt_s = params->loop.period_s;
    int count = 0;
    fill_cycle(&c, params, &m);
    for (int r = 0; r < m.size; r++) memcpy(square + r * m.size, m.map[r], (size_t)m.size * sizeof *square);
    if (lin_poles(m.size, square, re, im)) return 0;
    for (int i = 0; i < m.size; i++) {
        double size = hypot(re[i], im[i]);
        if (im[i] < 0.0 || !(size > 0.0)) continue;
        pole[count++] = (struct loop_pole){.decay_per_s = -log(size) / dt_s, .radps = atan2(im[i], re[i]) / dt_s};
    }
    return count;
}

/* Solves a x = b for the plant's states by elimination with pivots. x holds b before and the
 * solution after; a is overwritten. */
static void solve(double complex a[PLANT][PLANT], double complex x[PLANT]) {
    for (int i = 0; i < PLANT; i++) {
        int pivot = i;
        for (int r = i + 1; r < PLANT; r++)
            if (cabs(a[r][i]) > cabs(a[pivot][i])) pivot = r;
        for (int k = 0; k < PLANT; k++) {
            double complex swapped = a[i][k];
            a[i][k] = a[pivot][k], a[pivot][k] = swapped;
        }
        double complex swapped = x[i];
        x[i] = x[pivot], x[pivot] = swapped;
        for (int r = i + 1; r < PLANT; r++) {
            double complex factor = a[r][i] / a[i][i];
            for (int k = i; k < PLANT; k++) a[r][k] -= factor * a[i][k];
            x[r] -= factor * x[i];
        }
    }
    for (int i = PLANT - 1; i >= 0; i--) {
        for (int k = i + 1; k < PLANT; k++) x[i] -= a[i][k] * x[k];
        x[i] /= a[i][i];
    }
}

static int ascending(const void *a, const void *b) {
    double first = ((const struct loop_answer *)a)->radps, second = ((const struct loop_answer *)b)->radps;
    return (first > second) - (first < second);
}

static void fill_frequencies(struct loop_plant *p, double dt_s) {
    double most = NYQUIST_SHARE * PI / dt_s, low = fmin(p->oil_radps, most) * LOW;
    for (int i = 0; i < SWEEP; i++) p->answer[i].radps = low * pow(most / low, (double)i / (SWEEP - 1));
    for (int i = 0; i < PEAK; i++) {
        double off = PEAK_FROM * pow(PEAK_TO / PEAK_FROM, (double)i / (PEAK - 1));
        p->answer[SWEEP + 2 * i].radps = fmin(p->oil_radps * (1.0 - off), most);
        p->answer[SWEEP + 2 * i + 1].radps = fmin(p->oil_radps * (1.0 + off), most);
    }
    qsort(p->answer, LOOP_ANSWERS, sizeof *p->answer, ascending);
}

void loop_plant_find(const struct loop_leg leg[LEGS], const struct loop_mode_input *shape, const struct params *params,
                     struct loop_plant *p) {
    struct cylinder_loop c = mean_cylinder(leg, shape, params);
    double dt_s = params->loop.period_s, rates[PLANT + 1][PLANT + 1], first[PLANT + 1][PLANT + 1], then[PLANT + 1][PLANT + 1];
    double all[PLANT + 1][PLANT + 1], stiffness = c.a1_m2 * c.leg.chamber[0].push + c.a2_m2 * c.leg.chamber[1].push;
    struct delay sent = delay_cycles(c.leg.command_delay_s, dt_s), late = delay_cycles(c.leg.length_delay_s, dt_s);
    fill_rates(&c, rates);
    exponential(rates, sent.part * dt_s, first);
    exponential(rates, (1.0 - sent.part) * dt_s, then);
    multiply(then, first, all);
    *p = (struct loop_plant){.oil_radps = sqrt(stiffness / c.mass_kg), .feedback_cut = c.leg.feedback_cut, .gain = c.gain};
    fill_frequencies(p, dt_s);
    for (int i = 0; i < LOOP_ANSWERS; i++) {
        double complex z = cexp(CMPLX(0.0, p->answer[i].radps * dt_s)), a[PLANT][PLANT], x[PLANT];
        for (int r = 0; r < PLANT; r++) {
            double before = 0.0; /* effect of the older command, as in fill_plant() */
            for (int k = 0; k < PLANT; k++) a[r][k] = (r == k ? z : 0.0) - all[r][k], before += then[r][k] * first[k][INPUT];
            x[r] = (then[r][INPUT] + before / z) * cpow(z, -sent.whole);
        }
        solve(a, x);
        p->answer[i].length_m = x[LENGTH] * (1.0 - late.part + late.part / z) * cpow(z, -late.whole);
        p->answer[i].force_n = UNIT_PA * (c.a1_m2 * x[P1] - c.a2_m2 * x[P2]);
    }
}

/* Computes the mean square errors of a mode's length and force. Each leg errs independently: its
 * length by rounding, its force by noise and rounding of both pressures. */
static void mean_errors(const struct loop_mode_input *shape, const struct params *params, double square[READINGS]) {
    const struct sensor_params *s = &params->sensors;
    struct cylinder_areas areas = cylinder_areas(&params->actuator);
    double step_pa = 2.0 * s->pressure_full_scale_pa / exp2(round(s->adc_bits));
    double noise_pa = s->pressure_noise_v * s->pressure_full_scale_pa / s->adc_range_v, sum = 0.0;
    square[READ_LENGTH] = square[READ_FORCE] = 0.0;
    for (int k = 0; k < LEGS; k++) sum += shape->motion[k] * shape->motion[k];
    for (int k = 0; k < LEGS && s->enabled; k++) {
        double weight = shape->motion[k] * shape->motion[k] / (sum * sum) * UNIFORM_SQUARE;
        square[READ_LENGTH] += weight * s->position_resolution_m * s->position_resolution_m;
        square[READ_FORCE] += weight * (step_pa * step_pa + noise_pa * noise_pa) *
                              (areas.a1_m2[k] * areas.a1_m2[k] + areas.a2_m2[k] * areas.a2_m2[k]);
    }
}

/* Computes product = a b for n x n matrices. The innermost loop runs along rows, so that the
 * compiler can vectorise it. */
static void multiply_maps(int n, double a[LOOP_POLES][LOOP_POLES], double b[LOOP_POLES][LOOP_POLES],
                          double product[LOOP_POLES][LOOP_POLES]) {
    for (int i = 0; i < n; i++) {
        double *row = product[i];
        memset(row, 0, (size_t)n * sizeof *row);
        for (int k = 0; k < n; k++) {
            const double factor = a[i][k], *other = b[k];
            for (int j = 0; j < n; j++) row[j] += factor * other[j];
        }
    }
}

/* Doubles the number of cycles whose errors are added up: sum += map sum map', then map = map
 * map. */
static void double_cycles(int n, double map[LOOP_POLES][LOOP_POLES], double sum[LOOP_POLES][LOOP_POLES]) {
    double half[LOOP_POLES][LOOP_POLES], transposed[LOOP_POLES][LOOP_POLES], later[LOOP_POLES][LOOP_POLES];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) transposed[j][i] = map[i][j];
    multiply_maps(n, map, sum, half);
    multiply_maps(n, half, transposed, later);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) sum[i][j] += later[i][j];
    multiply_maps(n, map, map, half);
    for (int i = 0; i < n; i++) memcpy(map[i], half[i], (size_t)n * sizeof half[i][0]);
}

/* True if an error has died away over the cycles that `map` spans. */
static bool forgotten(int n, double map[LOOP_POLES][LOOP_POLES]) {
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            if (!(fabs(map[i][j]) < NOTHING)) return false;
    return true;
}

double loop_noise(const struct loop_leg leg[LEGS], const struct loop_mode_input *shape, const struct params *params) {
    struct cylinder_loop c = mean_cylinder(leg, shape, params);
    struct cycle_map m;
    double square[READINGS], sum[LOOP_POLES][LOOP_POLES] = {{0}}, rates[PLANT + 1][PLANT + 1], result = 0.0;
    fill_cycle(&c, params, &m);
    fill_rates(&c, rates);
    mean_errors(shape, params, square);
    for (int n = 0; n < READINGS; n++)
        for (int i = 0; i < m.size; i++)
            for (int j = 0; j < m.size; j++) sum[i][j] += square[n] * m.noise[n][i] * m.noise[n][j];
    for (int n = 0; n < DOUBLINGS && !forgotten(m.size, m.map); n++) double_cycles(m.size, m.map, sum);
    for (int i = 0; i < PLANT; i++)
        for (int j = 0; j < PLANT; j++) result += rates[RATE][i] * rates[RATE][j] * sum[i][j];
    return sqrt(result);
}

double loop_pole_hz(const struct loop_pole *p) { return hypot(p->decay_per_s, p->radps) / (2.0 * PI); }

double loop_pole_damping(const struct loop_pole *p) { return p->decay_per_s / hypot(p->decay_per_s, p->radps); }

struct loop_mode loop_poles(const struct oil_leg leg[LEGS], const struct oil_mode *mode, double gain, const double viscous[LEGS],
                            const struct params *params) {
    struct loop_mode found = {.hz = (double)NAN, .damping = (double)NAN};
    struct loop_leg legs[LEGS];
    struct loop_pole pole[LOOP_POLES];
    const struct loop_mode_input shape = {.motion = mode->motion, .mass_kg = mode->mass_kg, .gain = gain};
    double square = 0.0, delay_s = 0.0, least = HUGE_VAL;
    for (int k = 0; k < LEGS; k++) square += mode->motion[k] * mode->motion[k];
    for (int k = 0; k < LEGS; k++) delay_s += mode->motion[k] * mode->motion[k] / square * leg[k].delay_s;
    double lag_s = fmax(delay_s - 0.5 * params->loop.period_s, LEAST_LAG_S);
    for (int k = 0; k < LEGS; k++) {
        legs[k] = (struct loop_leg){.viscous = viscous[k], .spool_radps = 2.0 / lag_s, .spool_damping = 1.0};
        memcpy(legs[k].chamber, leg[k].chamber, sizeof legs[k].chamber);
    }
    int count = loop_poles_all(legs, &shape, params, pole);
    for (int i = 0; i < count; i++) {
        double size = loop_pole_hz(&pole[i]), damping = loop_pole_damping(&pole[i]);
        if (!(pole[i].radps > 0.0) || !(damping < OSCILLATES) || !(size < least)) continue;
        least = size;
        found = (struct loop_mode){.hz = size, .damping = damping};
    }
    return found;
}
