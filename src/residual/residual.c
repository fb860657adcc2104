#include "residual.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hydraulics.h"
#include "inverse_dynamics.h"
#include "params.h"
#include "series.h"
#include "systematic.h"
#include "units.h"
#include "valve_line.h"

/* Converts a difference of values, as a coefficient row, to a difference of readings. The noise of
 * the row is then the noise that the whitener assumes, whatever the sensor's scale and lag. */
static void read_back(const struct sensor_path *path, const struct residual_test *t, double *row) {
    for (int a = 0; a < t->size; a++) row[a] *= path->scale / hypot(1.0, t->rate[a] * path->lag_s);
}

/* Converts a difference of forces to one of readings. For A1 P1 - A2 P2 the scale is that of the
 * noise of both pressures together, and the lag is that of P1. */
static void read_force_back(const struct cylinder_model *m, const struct residual_test *t, int leg, double *row) {
    if (!t->pressures) {
        read_back(&m->machine.sensors.force[leg], t, row);
        return;
    }
    struct sensor_path both = m->machine.sensors.p1[leg];
    double a1 = m->leg[leg].a1_m2, a2 = m->leg[leg].a2_m2;
    both.scale = hypot(a1, a2) / hypot(a1 / m->machine.sensors.p1[leg].scale, a2 / m->machine.sensors.p2[leg].scale);
    read_back(&both, t, row);
    systematic_read_back(m, t, leg, a1, a2, row);
}

static double at(const double *basis, int size, const double *row) {
    double sum = 0.0;
    for (int a = 0; a < size; a++) sum += basis[a] * row[a];
    return sum;
}

/* A spool at its rate limit has forgotten its start after this many cycles. */
enum { LIMITED_CYCLES = 12 };
static const double SPOOL_TIMES = 10.0; /* run-in of any other spool, in its time constants: e^-10
                                         * of its start is left */

/* A simulation of the hydraulics for the measured motion and commands. */
struct run {
    const struct residual_test *t;
    const struct series *rows;
    double dither;               /* -1..1: factor with which the commands' noise is added to their
                                  * mean cycle */
    struct params timing;        /* the model, with the recording's command period */
    struct cylinder_model cylinder;
    struct valve_line line;
    struct hydraulics_state state;
    struct rods_motion node[3]; /* motion at start, middle and end of a substep */
    /* series of the motion: the legs side by side in each coefficient, so that sums vectorise */
    struct rods_motion series[SPECTRUM_SIZE];
};

/* Coefficient rows of the pressures at the gauges (port), and of the pressures at the gauges less
 * those in the chambers (drop). */
struct pressure_rows {
    double port[PORTS][LEGS][RESIDUAL_SIZE], drop[PORTS][LEGS][RESIDUAL_SIZE];
};

/* Fourier basis at a node: from the table, or computed into `room`. */
static const double *basis_at(const struct residual_test *t, int node, double room[SPECTRUM_SIZE]) {
    if (t->node) return t->node + (size_t)node * (size_t)residual_motion_size(t);
    residual_node(t, node, room);
    return room;
}

/* Sums the series of one leg, in the order of sum_all(), so that the results are the same. */
static void sum_one(const struct rods_motion *series, int size, const double *basis, int k, struct rods_motion *sum) {
    for (int a = 0; a < size; a++) {
        sum->length_m[k] += basis[a] * series[a].length_m[k];
        sum->rate_mps[k] += basis[a] * series[a].rate_mps[k];
    }
}

static void sum_all(const struct rods_motion *series, int size, const double *basis, struct rods_motion *sum) {
    for (int a = 0; a < size; a++)
        for (int k = 0; k < LEGS; k++) {
            sum->length_m[k] += basis[a] * series[a].length_m[k];
            sum->rate_mps[k] += basis[a] * series[a].rate_mps[k];
        }
}

/* Lengths and rates at a node of the simulation: the series, and the fast motion, for which a
 * position sensor's lag is treated as a delay. */
static void look(const struct run *r, int node, struct rods_motion *to) {
    int size = residual_motion_size(r->t), first = r->cylinder.first;
    double room[SPECTRUM_SIZE];
    const double *basis = basis_at(r->t, node, room);
    struct rods_motion sum = {0};
    if (r->cylinder.legs == first + 1) sum_one(r->series, size, basis, first, &sum);
    else sum_all(r->series, size, basis, &sum);
    *to = sum;
    for (int k = r->cylinder.first; k < r->cylinder.legs && r->t->fast.nodes; k++) {
        const struct sensor_path *path = &r->cylinder.machine.sensors.length[k];
        double t_s = r->t->first_s + node * r->t->step_s / (2 * r->t->substeps) + path->delay_s + path->lag_s;
        fast_motion_add(&r->t->fast, k, t_s, path->scale, &to->length_m[k], &to->rate_mps[k]);
    }
}

/* Returns the sample of the simulated cycle that has the same phase as a sample before the first
 * one. A cycle need not be a whole number of samples. */
static int sample_before(const struct residual_test *t, int sample) {
    double cycle = 2.0 * PI / t->spectrum.omega / t->step_s, place = fmod(sample, cycle);
    return (int)lround(place < 0.0 ? place + cycle : place);
}

static void command_at(const struct run *r, int sample, double valve[LEGS]) {
    const struct residual_test *t = r->t;
    int of = sample < 0 && t->spectrum.cycles ? sample_before(t, sample) : sample;
    for (int k = 0; k < LEGS; k++)
        valve[k] = t->valve[(t->lead + of) * LEGS + k] + (r->dither ? r->dither * t->dither[of * LEGS + k] : 0.0);
}

/* Number of samples after which the spools have forgotten their start, and the command path its
 * earlier commands; for a segment at most its lead. A cycle is first simulated without the
 * commands' noise and without the longer run-in of a rate limit; if a spool reaches its limit, the
 * cycle is simulated again with both. */
static int run_in(const struct run *r) {
    const struct residual_test *t = r->t;
    double slowest = HUGE_VAL, cycle = 2.0 * PI / t->spectrum.omega / t->step_s, samples;
    bool limited = false;
    for (int k = r->cylinder.first; k < r->cylinder.legs; k++) {
        const struct cylinder_leg *c = &r->cylinder.leg[k];
        double half = 0.5 * c->valve_damping_rate;
        slowest = fmin(slowest, half - sqrt(fmax(half * half - c->valve_omega_squared, 0.0)));
        limited = limited || (c->rate_limited && (r->dither || !t->spectrum.cycles));
    }
    samples = r->line.kept + ceil(SPOOL_TIMES / slowest / t->step_s);
    if (r->cylinder.machine.command.count > 0) samples = fmax(samples, cycle);
    if (limited) samples = fmax(samples, LIMITED_CYCLES * cycle);
    return t->spectrum.cycles ? (int)samples : (int)fmin(samples, t->lead);
}

/* Moves the spools alone through their run-in, up to the first sample, because they may forget
 * their start later than the chambers do. */
static void settle_spools(struct run *r) {
    const struct residual_test *t = r->t;
    double valve[LEGS];
    int samples = run_in(r);
    command_at(r, -samples, valve);
    valve_line_hold(&r->line, valve);
    for (int k = r->cylinder.first; k < r->cylinder.legs; k++) r->state.cylinder[k].spool = valve[k];
    for (int i = -samples; i < 0; i++) {
        command_at(r, i, valve);
        valve_line_send(&r->line, valve);
        for (int j = 0; j < t->substeps; j++) {
            valve_line_receive(&r->line, j, valve);
            for (int k = r->cylinder.first; k < r->cylinder.legs; k++)
                cylinder_spool_step(&r->cylinder, k, t->step_s / t->substeps, valve[k], &r->state.cylinder[k]);
        }
    }
}

static void begin_motion(struct run *r) {
    memset(r->series, 0, sizeof r->series);
    for (int k = 0; k < r->t->legs; k++) {
        double rate[SPECTRUM_SIZE];
        series_rate(r->t, r->rows->length[k], rate);
        rate[0] = r->rows->drift_mps[k];
        for (int a = 0; a < residual_motion_size(r->t); a++)
            r->series[a].length_m[k] = r->rows->length[k][a], r->series[a].rate_mps[k] = rate[a];
    }
    look(r, 0, &r->node[0]);
}

static void begin_run(struct run *r, const struct residual_test *t, const struct params *model, int leg, double dither,
                      const struct series *rows) {
    r->t = t;
    r->rows = rows;
    r->dither = dither;
    r->timing = *model;
    r->timing.loop.period_s = t->step_s;
    r->timing.sim.substeps = t->substeps;
    cylinder_model_init(&r->cylinder, &r->timing);
    if (leg != ALL_LEGS) r->cylinder.first = leg, r->cylinder.legs = leg + 1;
    valve_line_init(&r->line, &r->cylinder.machine);
    memset(&r->state, 0, sizeof r->state);
    double room[SPECTRUM_SIZE];
    const double *first = basis_at(t, 0, room);
    for (int k = 0; k < t->legs; k++) {
        double p1 = at(first, residual_motion_size(t), rows->p1[k]), p2 = at(first, residual_motion_size(t), rows->p2[k]);
        r->state.cylinder[k] = (struct cylinder_state){.p1_pa = p1, .p2_pa = p2};
    }
    hydraulics_rest(&r->state);
    settle_spools(r);
    begin_motion(r);
}

static void add_forces(const struct run *r, double weight, double sum_n[LEGS]) {
    for (int k = r->cylinder.first; k < r->cylinder.legs; k++)
        sum_n[k] += weight * cylinder_hydraulic_force(&r->cylinder, k, &r->state.cylinder[k]);
}

/* Weight of the instant after j substeps in a mean over an even number of substeps, by Simpson's
 * rule. */
static double mean_weight(int substeps, int j) { return (!j || j == substeps ? 1.0 : j % 2 ? 4.0 : 2.0) / (3.0 * substeps); }

/* Subtracts one step of the measured drift from the pressures. The simulated flows cause the drift
 * as well as the mean cycle; with the drift subtracted the pressures repeat, as the measured mean
 * cycle does. */
static void take_drift_off(struct run *r, double dt_s) {
    for (int k = r->cylinder.first; k < r->cylinder.legs; k++) {
        double *chamber[PORTS] = {&r->state.cylinder[k].p1_pa, &r->state.cylinder[k].p2_pa};
        for (int i = 0; i < PORTS; i++) {
            double step_pa = r->rows->drift_pa_per_s[i][k] * dt_s;
            *chamber[i] -= step_pa;
            r->state.hose[k][i].pressure_pa -= step_pa;
        }
    }
}

/* Simulates up to the next sample. mean_n: the mean force of each leg over this time is added to
 * it; NULL: not wanted. */
static void run_on(struct run *r, int sample, double mean_n[LEGS]) {
    const struct residual_test *t = r->t;
    double valve[LEGS];
    struct hydraulics_input in[3];
    for (int i = 0; i < 3; i++) in[i] = (struct hydraulics_input){r->node[i].length_m, r->node[i].rate_mps, valve};
    command_at(r, sample, valve);
    valve_line_send(&r->line, valve);
    if (mean_n) add_forces(r, mean_weight(t->substeps, 0), mean_n);
    for (int j = 0; j < t->substeps; j++) {
        int node = 2 * (sample * t->substeps + j);
        valve_line_receive(&r->line, j, valve);
        look(r, node + 1, &r->node[1]);
        look(r, node + 2, &r->node[2]);
        hydraulics_step(&r->cylinder, t->step_s / t->substeps, in, &r->state);
        take_drift_off(r, t->step_s / t->substeps);
        r->node[0] = r->node[2];
        if (mean_n) add_forces(r, mean_weight(t->substeps, j + 1), mean_n);
    }
}

static void add_sample(const struct run *r, int place, double share, struct pressure_rows *p) {
    for (int k = r->cylinder.first; k < r->cylinder.legs; k++) {
        const struct cylinder_state *s = &r->state.cylinder[k];
        bool hose = r->cylinder.leg[k].hose_volume_m3 > 0.0;
        double chamber[PORTS] = {s->p1_pa, s->p2_pa};
        for (int i = 0; i < PORTS; i++) {
            double port = hose ? r->state.hose[k][i].pressure_pa : chamber[i];
            for (int a = 0; a < r->t->size; a++) {
                double weight = share * r->t->projection[a * r->t->fitted + place];
                p->port[i][k][a] += weight * port;
                p->drop[i][k][a] += weight * (port - chamber[i]);
            }
        }
    }
}

/* True if a spool moves at its rate limit. */
static bool at_limit(const struct run *r) {
    bool limited = false;
    for (int k = r->cylinder.first; k < r->cylinder.legs; k++)
        limited = limited || fabs(r->state.cylinder[k].spool_rate) >= r->cylinder.machine.valve.rate_per_s[k];
    return limited;
}

/* Simulates the pressures and adds their coefficient rows, times `share`, to p. Sets `limited` if a
 * spool reaches its rate limit. */
static void add_pressures(struct run *r, const struct residual_test *t, const struct params *model, int leg, const struct series *rows,
                          double dither, double share, struct pressure_rows *p, bool *limited) {
    begin_run(r, t, model, leg, dither, rows);
    for (int i = 0; i < t->samples; i++) {
        int place = i - (t->samples - t->fitted);
        if (place >= 0) add_sample(r, place, share, p);
        run_on(r, i, NULL);
        *limited = *limited || at_limit(r);
    }
}

/* Simulates the pressures' coefficient rows. The commands' noise smooths a dead band or limit in
 * the command path, but the mean command has no noise. With such a path, or if a spool reaches its
 * rate limit, the simulation runs twice, with the noise added and with it subtracted; in the mean
 * of both responses the part that is linear in the noise cancels. */
static void simulate_pressures(const struct residual_test *t, const struct params *model, const struct machine *machine, int leg,
                               const struct series *rows, struct pressure_rows *p) {
    struct run r;
    bool gap = machine->command.count > 0, limited = false;
    memset(p, 0, sizeof *p);
    if (!t->dither || !gap) add_pressures(&r, t, model, leg, rows, 0.0, 1.0, p, &limited);
    if (t->dither && (gap || limited)) {
        memset(p, 0, sizeof *p);
        for (int sign = -1; sign <= 1; sign += 2) add_pressures(&r, t, model, leg, rows, sign, 0.5, p, &limited);
    }
}

/* Excess of the sample force_n[1] over the mean force. mean_n: mean forces of the intervals before
 * and after this sample. The force is smooth except for a ripple with the sampling period, which
 * all samples read at the same phase; Simpson's rule averages the smooth part of the three
 * samples. */
static double above_mean(const double force_n[3], const double mean_n[2]) {
    return (force_n[0] + 4.0 * force_n[1] + force_n[2]) / 6.0 - 0.5 * (mean_n[0] + mean_n[1]);
}

bool residual_staircase(const struct residual_test *t, const struct params *model, double row[LEGS][RESIDUAL_SIZE]) {
    memset(row, 0, LEGS * sizeof row[0]);
    if (t->substeps % 2 || !t->in_step) return true;
    struct run r;
    double (*force_n)[LEGS] = calloc((size_t)t->samples + 1, sizeof *force_n), (*mean_n)[LEGS] = calloc((size_t)t->samples, sizeof *mean_n);
    struct cylinder_model cylinder;
    struct series rows;
    cylinder_model_init(&cylinder, model);
    systematic_series(&cylinder, t, &rows);
    bool ok = force_n && mean_n && t->chambers;
    if (ok) begin_run(&r, t, model, ALL_LEGS, 0.0, &rows);
    for (int i = 0; i < t->samples && ok; i++) {
        add_forces(&r, 1.0, force_n[i]);
        run_on(&r, i, mean_n[i]);
    }
    if (ok) add_forces(&r, 1.0, force_n[t->samples]);
    for (int i = t->samples - t->fitted; i < t->samples && ok && i > 0; i++)
        for (int k = 0; k < t->legs; k++) {
            double above_n = above_mean((double[]){force_n[i - 1][k], force_n[i][k], force_n[i + 1][k]},
                                        (double[]){mean_n[i - 1][k], mean_n[i][k]});
            for (int a = 0; a < t->size; a++) row[k][a] += t->projection[a * t->fitted + i - (t->samples - t->fitted)] * above_n;
        }
    free(force_n);
    free(mean_n);
    return ok;
}

/* Tabulates the measured values at each phase, from the given number of harmonics. p: pressure
 * drops from gauge to chamber, or NULL for none. Returns false if no pose has these lengths. */
static bool tabulate_cycle(const struct residual_test *t, int harmonics, struct inverse_dynamics *d, const struct series *rows,
                           const struct pressure_rows *p, struct inverse_dynamics_input table[PHASES]) {
    const struct cylinder_model *m = &d->cylinder;
    int size = 1 + 2 * harmonics;
    memset(table, 0, (size_t)t->phases * sizeof *table);
    for (int k = 0; k < t->legs; k++) {
        double force_n[SPECTRUM_SIZE];
        bool play = machine_has_play(&m->machine, k);
        series_push(m, t, rows, k, force_n);
        for (int i = 0; i < t->phases; i++) {
            const double *basis = t->cycle + i * SPECTRUM_SIZE;
            struct inverse_dynamics_input *in = &table[i];
            double drop[PORTS] = {0};
            for (int port = 0; port < PORTS && p; port++) drop[port] = at(t->basis[i], t->size, p->drop[port][k]);
            spectrum_at(rows->length[k], harmonics, t->spectrum.omega, basis, in->leg[k]);
            in->leg[k][1] += rows->drift_mps[k];
            if (play) spectrum_at(rows->ahead[k], harmonics, t->spectrum.omega, basis, in->ahead[k]);
            for (int a = 0; a < 3; a++) in->leg[k][a] -= in->ahead[k][a];
            in->p1_pa[k] = at(basis, size, rows->p1[k]) - drop[PORT_A];
            in->p2_pa[k] = at(basis, size, rows->p2[k]) - drop[PORT_B];
            in->push_n[k] = at(basis, size, force_n) - m->leg[k].a1_m2 * drop[PORT_A] + m->leg[k].a2_m2 * drop[PORT_B];
        }
    }
    return inverse_dynamics_seals(d, t->phases, t->spectrum.cycles > 0, table);
}

/* Adds what a value at a phase contributes to a coefficient row. */
static void project_phase(const struct residual_test *t, int phase, double value, double *row) {
    for (int a = 0; a < t->size; a++) row[a] += t->project[phase][a] * value;
}

static void prepare_inverse(const struct residual_test *t, const struct params *model, struct inverse_dynamics *inverse) {
    double period_s = 2.0 * PI / t->spectrum.omega;
    /* Only with short strokes may a leg count as held about a reversal: with long strokes this
     * would lose more information than reversals spoil. */
    bool spare = params_mechanism(model)->short_strokes;
    inverse_dynamics_init(inverse, model, period_s / PHASES, spare && t->spectrum.cycles ? period_s / (4 * t->harmonics) : 0.0);
    if (spare) memcpy(inverse->speed_std_mps, t->speed_std_mps, sizeof inverse->speed_std_mps);
    memcpy(inverse->force_std_n, t->force_std_n, sizeof inverse->force_std_n);
}

/* Finds the positions of the rods in joints with backlash, as a series. Returns false if no pose
 * has these lengths. */
static bool find_play(const struct residual_test *t, struct inverse_dynamics *inverse, const struct pressure_rows *p, struct series *rows) {
    struct inverse_dynamics_input table[PHASES];
    double ahead_m[PHASES][LEGS], period_s = 2.0 * PI / t->spectrum.omega;
    bool play = false;
    for (int k = 0; k < t->legs; k++) play = play || machine_has_play(&inverse->cylinder.machine, k);
    if (!play) return true;
    const struct play_motion motion = {.at = table,
                                       .phases = t->phases,
                                       .cycle = t->spectrum.cycles > 0,
                                       .step_s = period_s / PHASES,
                                       .resolution_s = period_s / (4 * t->spectrum.harmonics),
                                       .noise = &t->play_noise};
    if (!tabulate_cycle(t, t->spectrum.harmonics, inverse, rows, p, table)) return false;
    if (!play_find(inverse, &motion, ahead_m)) return false;
    for (int k = 0; k < t->legs; k++)
        for (int i = 0; i < t->phases; i++)
            for (int a = 0; a < residual_motion_size(t); a++) rows->ahead[k][a] += t->series[i][a] * ahead_m[i][k];
    return true;
}

static bool required(const struct residual_test *t, const struct params *model, struct series *rows, const struct pressure_rows *p,
                     double force_n[LEGS][RESIDUAL_SIZE]) {
    struct inverse_dynamics inverse;
    struct inverse_dynamics_input table[PHASES];
    double force[LEGS];
    prepare_inverse(t, model, &inverse);
    if (!find_play(t, &inverse, p, rows) || !tabulate_cycle(t, t->harmonics, &inverse, rows, p, table)) return false;
    memset(force_n, 0, LEGS * sizeof force_n[0]);
    inverse.slides = t->slides; /* set only here, because positions in the backlash and deflections
                                 * of the seals always follow from the balance of forces */
    for (int i = 0; i < t->phases; i++) {
        if (!inverse_dynamics_step(&inverse, &table[i], force)) return false;
        for (int k = 0; k < t->legs; k++) project_phase(t, i, force[k], force_n[k]);
    }
    return true;
}

bool residual_required(const struct residual_test *t, const struct params *model, double force_n[LEGS][RESIDUAL_SIZE]) {
    struct series rows;
    struct cylinder_model cylinder;
    cylinder_model_init(&cylinder, model);
    systematic_series(&cylinder, t, &rows);
    return required(t, model, &rows, NULL, force_n);
}

/* Adds `share` times the covariance of a force that has the standard deviations std_n and is fully
 * correlated over the instants begin to end - 1. Instants beyond the last one are those of the next
 * cycle. */
static void add_shared(const struct residual_test *t, int begin, int end, const double *std_n, double share,
                       double covariance[RESIDUAL_SIZE][RESIDUAL_SIZE]) {
    double sum[RESIDUAL_SIZE] = {0};
    for (int i = begin; i < end; i++) project_phase(t, i % t->phases, std_n[i % t->phases], sum);
    for (int a = 0; a < t->size; a++)
        for (int b = 0; b < t->size; b++) covariance[a][b] += share * sum[a] * sum[b];
}

/* Adds the covariance of a force that has these standard deviations at the instants. Half of the
 * variance is from a part that is constant while the leg is held, half from a part that changes as
 * fast as the row resolves. */
static void add_held(const struct residual_test *t, const double std_n[PHASES], double covariance[RESIDUAL_SIZE][RESIDUAL_SIZE]) {
    int first = 0; /* first instant at which the leg slides, if the motion is a cycle; otherwise
                    * 0 */
    while (t->spectrum.cycles > 0 && first < t->phases && std_n[first] > 0.0) first++;
    for (int i = first, end; i < first + t->phases; i = end + 1) {
        for (end = i; end < first + t->phases && std_n[end % t->phases] > 0.0; end++)
            add_shared(t, end, end + 1, std_n, 0.5 * t->phases / t->size, covariance);
        if (end > i) add_shared(t, i, end, std_n, 0.5, covariance);
    }
}

/* Converts the covariance of a leg's force to that of its readings. */
static void read_covariance_back(const struct cylinder_model *m, const struct residual_test *t, int leg,
                                 double covariance[RESIDUAL_SIZE][RESIDUAL_SIZE]) {
    double share[RESIDUAL_SIZE];
    for (int a = 0; a < t->size; a++) share[a] = 1.0;
    read_force_back(m, t, leg, share);
    for (int a = 0; a < t->size; a++)
        for (int b = 0; b < t->size; b++) covariance[a][b] *= share[a] * share[b];
}

void residual_held(const struct residual_test *t, const struct params *model, double covariance[LEGS][RESIDUAL_SIZE][RESIDUAL_SIZE]) {
    struct series rows;
    struct inverse_dynamics inverse;
    struct inverse_dynamics_input table[PHASES];
    prepare_inverse(t, model, &inverse);
    systematic_series(&inverse.cylinder, t, &rows);
    memset(covariance, 0, LEGS * sizeof covariance[0]);
    if (!find_play(t, &inverse, NULL, &rows) || !tabulate_cycle(t, t->harmonics, &inverse, &rows, NULL, table)) return;
    for (int k = 0; k < t->legs; k++) {
        double std_n[PHASES];
        for (int i = 0; i < t->phases; i++) std_n[i] = sqrt(inverse_dynamics_held_variance(&inverse, k, &table[i]));
        add_held(t, std_n, covariance[k]);
        read_covariance_back(&inverse.cylinder, t, k, covariance[k]);
    }
}

void residual_rate(const struct residual_test *t, int leg, double row[RESIDUAL_SIZE]) {
    double rate[SPECTRUM_SIZE];
    series_rate(t, t->spectrum.mean[CHANNEL_LENGTH][leg], rate);
    series_row(t, rate, row);
}

double residual_variation(const struct residual_test *t, enum channel channel, int leg) {
    const struct spectrum *s = &t->spectrum;
    double sum = 0.0, square_sum = 0.0;
    for (int i = 0; i < t->phases; i++) {
        const double *basis = t->cycle + i * SPECTRUM_SIZE;
        double value = 0.0;
        for (int a = 1; a < 1 + 2 * t->harmonics; a++) value += basis[a] * s->mean[channel][leg][a];
        sum += value, square_sum += value * value;
    }
    return fmax(square_sum - sum * sum / t->phases, 0.0) / t->phases;
}

static bool has_hoses(const struct cylinder_model *m) {
    bool hoses = false;
    for (int k = 0; k < LEGS; k++) hoses = hoses || m->leg[k].hose_volume_m3 > 0.0;
    return hoses;
}

enum residual_equations residual_legs_apart(const struct params *model) {
    struct machine m;
    bool play = false, hoses = false;
    machine_init(&m, model);
    for (int k = 0; k < LEGS; k++) play = play || machine_has_play(&m, k), hoses = hoses || m.hose.length_m[k] > 0.0;
    bool shared = m.supply.resistance_pa_s_per_m3 > 0.0 || m.supply.tank_resistance_pa_s_per_m3 > 0.0;
    if (shared || (play && hoses)) return 0;
    return play ? EQUATIONS_PRESSURE : EQUATIONS_ALL | EQUATIONS_FORCE_SENSOR;
}

/* Clears the rows of legs that the mechanism lacks, and of pressures that are not evaluated. */
static void clear_others(const struct residual_test *t, residual_row row) {
    for (int k = 0; k < LEGS; k++)
        for (int q = 0; q < RESIDUALS; q++)
            if (k >= t->legs || (q != RESIDUAL_FORCE && !t->chambers)) memset(row[k][q], 0, sizeof row[k][q]);
}

bool residual_evaluate(const struct residual_test *t, const struct params *model, enum residual_equations equations, int leg,
                       residual_row row) {
    struct cylinder_model cylinder;
    struct series rows;
    struct pressure_rows p;
    double force[LEGS][RESIDUAL_SIZE];
    struct error impossible;
    cylinder_model_init(&cylinder, model);
    if (machine_check(&cylinder.machine, &impossible)) return false;
    systematic_series(&cylinder, t, &rows);
    /* With hoses between gauges and chambers the force needs the pressure drops from gauge to
     * chamber of all legs. */
    if (has_hoses(&cylinder)) equations = EQUATIONS_ALL, leg = ALL_LEGS;
    if (!t->chambers) equations &= EQUATIONS_FORCE;
    bool hoses = has_hoses(&cylinder) && equations & EQUATIONS_PRESSURE;
    clear_others(t, row);
    if (equations & EQUATIONS_PRESSURE) {
        simulate_pressures(t, model, &cylinder.machine, leg, &rows, &p);
        for (int k = 0; k < t->legs; k++) {
            if (leg != ALL_LEGS && leg != k) continue;
            series_row(t, rows.p1[k], row[k][RESIDUAL_P1]);
            series_row(t, rows.p2[k], row[k][RESIDUAL_P2]);
            for (int a = 0; a < t->size; a++)
                row[k][RESIDUAL_P1][a] -= p.port[PORT_A][k][a], row[k][RESIDUAL_P2][a] -= p.port[PORT_B][k][a];
            read_back(&cylinder.machine.sensors.p1[k], t, row[k][RESIDUAL_P1]);
            read_back(&cylinder.machine.sensors.p2[k], t, row[k][RESIDUAL_P2]);
            systematic_read_back(&cylinder, t, k, 1.0, 0.0, row[k][RESIDUAL_P1]);
            systematic_read_back(&cylinder, t, k, 0.0, 1.0, row[k][RESIDUAL_P2]);
        }
    }
    if (!(equations & EQUATIONS_FORCE)) return true;
    if (!required(t, model, &rows, hoses ? &p : NULL, force)) return false;
    for (int k = 0; k < t->legs; k++) {
        double push_n[SPECTRUM_SIZE], *net = row[k][RESIDUAL_FORCE];
        series_push(&cylinder, t, &rows, k, push_n);
        series_row(t, push_n, net);
        for (int a = 0; a < t->size; a++) {
            if (hoses) net[a] -= cylinder.leg[k].a1_m2 * p.drop[PORT_A][k][a] - cylinder.leg[k].a2_m2 * p.drop[PORT_B][k][a];
            net[a] -= force[k][a];
        }
        read_force_back(&cylinder, t, k, net);
    }
    return true;
}
