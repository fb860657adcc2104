#include "residual.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "hydraulics.h"
#include "inverse_dynamics.h"
#include "units.h"
#include "valve_line.h"

static const double SETTLE_CYCLES = 1.5; /* then a spool at its rate limit has forgotten the start, too */
static const double SUBSTEP_S = 0.5e-3;   /* RK4: 1e-4 of a 100 Hz spool's lag */

/* Of a piece: the windows of neighbours overlap by so much of it on either side; the series' period is so many times what it is fitted to. */
static const double OVERLAP = 0.15, STRETCH = 1.2;
enum { COUPLING_POINTS = 2048 };

/* Samples to coefficients, by least squares: exact also where a cycle is no whole number of samples. */
static bool project_cycle(struct residual_test *t) {
    double product[RESIDUAL_SIZE][RESIDUAL_SIZE] = {0}, basis[RESIDUAL_SIZE];
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < t->fitted; i++) {
            double t_s = t->first_s + (t->samples - t->fitted + i) * t->step_s;
            spectrum_basis(t->spectrum.omega * t_s, t->harmonics, basis);
            if (pass) dense_solve(t->size, RESIDUAL_SIZE, product[0], basis);
            for (int a = 0; a < t->size; a++) {
                if (pass) t->projection[a * t->fitted + i] = basis[a];
                else for (int b = 0; b <= a; b++) product[a][b] += basis[a] * basis[b];
            }
        }
        if (!pass && !dense_factor(t->size, RESIDUAL_SIZE, product[0])) return false;
    }
    return true;
}

static int motion_size(const struct residual_test *t) { return 1 + 2 * t->harmonics; }

static int nodes_of(const struct residual_test *t) { return 2 * t->substeps * t->samples + 1; }

static void tabulate(struct residual_test *t, double first_phase) {
    const struct spectrum *s = &t->spectrum;
    for (int i = 0; i < nodes_of(t) && t->chambers; i++) {
        double t_s = t->first_s + i * t->step_s / (2 * t->substeps);
        spectrum_basis(s->omega * t_s, t->harmonics, t->node + (size_t)i * (size_t)motion_size(t));
    }
    for (int i = 0; i < CYCLE_STEPS; i++)
        spectrum_basis(first_phase + 2.0 * PI * i / CYCLE_STEPS, SPECTRUM_HARMONICS, t->cycle + i * SPECTRUM_SIZE);
}

static int allocate(struct residual_test *t, struct error *error) {
    t->coupling = calloc(RESIDUAL_SIZE, sizeof *t->coupling);
    t->cycle = malloc((size_t)CYCLE_STEPS * SPECTRUM_SIZE * sizeof(double));
    t->shape = calloc(PHASES, sizeof *t->shape);
    t->project = calloc(PHASES, sizeof *t->project);
    t->series = calloc(PHASES, sizeof *t->series);
    t->node = malloc((t->chambers ? (size_t)nodes_of(t) * (size_t)motion_size(t) : 1) * sizeof(double));
    t->valve = malloc((size_t)(LEGS * t->samples) * sizeof(double));
    t->projection = malloc((size_t)(RESIDUAL_SIZE * t->fitted) * sizeof(double));
    bool all = t->coupling && t->cycle && t->shape && t->project && t->series && t->node && t->valve && t->projection;
    return all ? STATUS_OK : error_set(error, STATUS_IO, "out of memory");
}

/* A steady sinusoid: the harmonics of its mean cycle, once the start is forgotten. */
static int prepare_cycle(struct residual_test *t, const struct recording_test *test, enum cycles which, struct error *error) {
    const struct spectrum *s = &t->spectrum;
    if (!spectrum_measure(&t->spectrum, test, which))
        return error_set(error, STATUS_USAGE, "test %s: fewer than two whole cycles of %g Hz: the others miss more than a tenth of their "
                                              "samples, or a piece at once: lost, flagged or no number", dof_names[test->dof], test->frequency_hz);
    t->harmonics = s->harmonics < RESIDUAL_HARMONICS ? s->harmonics : RESIDUAL_HARMONICS;
    t->size = motion_size(t);
    t->first_s = test->sample[test->first].test_time_s;
    double cycle = 1.0 / test->frequency_hz / t->step_s;
    t->fitted = (int)ceil(cycle - 1e-6);
    t->samples = (int)ceil(fmax(SETTLE_CYCLES * cycle, RESIDUAL_SETTLE_S / t->step_s)) + t->fitted;
    t->phases = PHASES;
    int status = allocate(t, error);
    if (status) return status;
    if (!project_cycle(t)) return error_set(error, STATUS_USAGE, "test %d: too few samples a cycle", test->test + 1);
    tabulate(t, 0.0);
    for (int a = 0; a < t->size; a++) {
        t->rate[a] = (a + 1) / 2 * s->omega;
        t->curve[a] = t->rate[a] * t->rate[a];
        t->weight[a] = a ? 0.5 : 1.0;
        t->coupling[a][a] = 1.0;
        for (int ch = 0; ch < CHANNELS; ch++)
            for (int k = 0; k < LEGS; k++) t->row[ch][k][a] = s->mean[ch][k][a], t->std[ch][k][a] = s->std[ch][k][a];
        for (int i = 0; i < PHASES; i++) {
            t->shape[i][a] = t->cycle[i * (CYCLE_STEPS / PHASES) * SPECTRUM_SIZE + a];
            t->project[i][a] = t->series[i][a] = t->shape[i][a] / PHASES / t->weight[a];
        }
    }
    for (int i = 0; i < t->samples; i++)
        for (int k = 0; k < LEGS; k++) {
            double value[3];
            spectrum_value(s->mean[CHANNEL_VALVE][k], s->harmonics, s->omega, t->first_s + i * t->step_s, value);
            t->valve[i * LEGS + k] = value[0];
        }
    return STATUS_OK;
}

/* From 0 to 1 while x goes from -1 to 1, smoothly, with squares of both sides that add up to 1. */
static double rise(double x) { return x <= -1.0 ? 0.0 : x >= 1.0 ? 1.0 : sin(0.25 * PI * (1.0 + sin(0.5 * PI * x))); }

/* Local cosines of the piece from start_s on. */
static void local_cosines(double t_s, double start_s, double piece_s, double value[RESIDUAL_SIZE]) {
    double x = (t_s - start_s) / piece_s, window = rise(x / OVERLAP) * rise((1.0 - x) / OVERLAP);
    for (int a = 0; a < RESIDUAL_SIZE; a++) value[a] = window * cos(PI * (a + 0.5) * x);
}

/* The sampling instant next to a time: commands change there and nowhere else. */
static double sampled_s(const struct recording_test *test, double t_s) {
    int i = test->first;
    while (i + 1 < test->end && test->sample[i + 1].test_time_s <= t_s) i++;
    double before_s = test->sample[i].test_time_s, after_s = test->sample[i + 1 < test->end ? i + 1 : i].test_time_s;
    return t_s - before_s < after_s - t_s ? before_s : after_s;
}

/* Commands are held from sample to sample. */
static void hold_commands(struct residual_test *t, const struct recording_test *test) {
    double held[LEGS] = {0};
    int j = 0;
    while (j < test->count && !test->sample[j].good) j++;
    if (j < test->count) memcpy(held, test->sample[j].valve, sizeof held);
    for (int i = 0; i < t->samples; i++) {
        for (; j < test->count && test->sample[j].test_time_s <= t->first_s + (i + 0.5) * t->step_s; j++)
            if (test->sample[j].good) memcpy(held, test->sample[j].valve, sizeof held);
        memcpy(t->valve + (size_t)i * LEGS, held, sizeof held);
    }
}

/* The samples simulated go to the row as those measured do, by way of the series; the run-up to the piece is left out of both. */
static void project_samples(struct residual_test *t, int settling, double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE]) {
    double basis[SPECTRUM_SIZE], weight[RESIDUAL_SIZE][SPECTRUM_SIZE] = {{0}};
    for (int a = 0; a < t->size; a++)
        for (int b = 0; b < SPECTRUM_SIZE; b++)
            for (int c = 0; c < SPECTRUM_SIZE; c++) weight[a][b] += t->coupling[a][c] * inverse[c][b];
    memset(t->coupling, 0, RESIDUAL_SIZE * sizeof *t->coupling);
    for (int i = 0; i < t->fitted; i++) {
        spectrum_basis(t->spectrum.omega * (t->first_s + (settling + i) * t->step_s), SPECTRUM_HARMONICS, basis);
        for (int a = 0; a < t->size; a++) {
            double value = 0.0;
            for (int b = 0; b < SPECTRUM_SIZE; b++) value += weight[a][b] * basis[b];
            t->projection[a * t->fitted + i] = value;
            for (int b = 0; b < SPECTRUM_SIZE; b++) t->coupling[a][b] += value * basis[b];
        }
    }
}

/* What was measured as a row, and how sure it is. */
static void take_rows(struct residual_test *t, double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE]) {
    for (int a = 0; a < t->size; a++) {
        double variance = 0.0, curve = 0.0;
        for (int b = 0; b < SPECTRUM_SIZE; b++)
            for (int c = 0; c < SPECTRUM_SIZE; c++) {
                double both = t->coupling[a][b] * inverse[b][c] * t->coupling[a][c], rate = t->spectrum.omega * ((b + 1) / 2) * ((c + 1) / 2);
                variance += both, curve += both * rate * rate * t->spectrum.omega * t->spectrum.omega;
            }
        t->curve[a] = sqrt(fmax(curve, 0.0) / fmax(variance, 1e-300));
        for (int ch = 0; ch < CHANNELS; ch++)
            for (int k = 0; k < LEGS; k++) {
                t->std[ch][k][a] = t->spectrum.noise[ch][k] * sqrt(fmax(variance, 0.0));
                for (int b = 0; b < SPECTRUM_SIZE; b++) t->row[ch][k][a] += t->coupling[a][b] * t->spectrum.mean[ch][k][b];
            }
    }
}

/* Values at the phases of a piece to the series, by least squares, and by that to the row. */
static bool fit_series(struct residual_test *t) {
    double product[SPECTRUM_SIZE][SPECTRUM_SIZE] = {0};
    for (int i = 0; i < t->phases; i++) {
        memcpy(t->series[i], t->cycle + i * (CYCLE_STEPS / PHASES) * SPECTRUM_SIZE, sizeof t->series[i]);
        for (int a = 0; a < SPECTRUM_SIZE; a++)
            for (int b = 0; b <= a; b++) product[a][b] += t->series[i][a] * t->series[i][b];
    }
    for (int a = 0; a < SPECTRUM_SIZE; a++) product[a][a] += 1e-6 * t->phases;
    if (!dense_factor(SPECTRUM_SIZE, SPECTRUM_SIZE, product[0])) return false;
    for (int i = 0; i < t->phases; i++) dense_solve(SPECTRUM_SIZE, SPECTRUM_SIZE, product[0], t->series[i]);
    for (int i = 0; i < t->phases; i++)
        for (int a = 0; a < t->size; a++)
            for (int b = 0; b < SPECTRUM_SIZE; b++) t->project[i][a] += t->coupling[a][b] * t->series[i][b];
    return true;
}

/* Any motion: local cosines of a piece, whose chambers are simulated from a little before. */
static int prepare_piece(struct residual_test *t, const struct recording_test *test, struct error *error) {
    double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE], value[RESIDUAL_SIZE], basis[SPECTRUM_SIZE];
    double piece_s = test->piece_s, begin_s = test->start_s - OVERLAP * piece_s, span_s = (1.0 + 2.0 * OVERLAP) * piece_s;
    int settling = t->chambers ? (int)ceil(RESIDUAL_SETTLE_S / t->step_s) : 0;
    t->first_s = sampled_s(test, begin_s - settling * t->step_s);
    t->fitted = (int)(span_s / t->step_s) + 1;
    t->samples = settling + t->fitted;
    t->harmonics = SPECTRUM_HARMONICS;
    t->size = RESIDUAL_SIZE;
    double period_s = STRETCH * (begin_s + span_s - t->first_s), omega = 2.0 * PI / period_s;
    t->phases = (int)(PHASES * span_s / period_s);
    int status = allocate(t, error);
    if (status) return status;
    if (!spectrum_cut(&t->spectrum, test, t->first_s, begin_s + span_s, omega, inverse))
        return error_set(error, STATUS_USAGE, "at %.4g s: too many samples of a piece of %.3g s are lost, flagged or no number", test->start_s,
                         piece_s);
    tabulate(t, omega * begin_s);
    hold_commands(t, test);
    for (int a = 0; a < t->size; a++) t->rate[a] = PI * (a + 0.5) / piece_s, t->weight[a] = 0.5;
    for (int i = 0; i < t->phases; i++) local_cosines(begin_s + i * period_s / PHASES, test->start_s, piece_s, t->shape[i]);
    for (int i = 0; i < COUPLING_POINTS; i++) {
        double t_s = begin_s + (i + 0.5) * span_s / COUPLING_POINTS;
        local_cosines(t_s, test->start_s, piece_s, value);
        spectrum_basis(omega * t_s, SPECTRUM_HARMONICS, basis);
        for (int a = 0; a < t->size; a++)
            for (int b = 0; b < SPECTRUM_SIZE; b++) t->coupling[a][b] += 2.0 / piece_s * span_s / COUPLING_POINTS * value[a] * basis[b];
    }
    project_samples(t, settling, inverse);
    take_rows(t, inverse);
    return fit_series(t) ? STATUS_OK : error_set(error, STATUS_USAGE, "at %.4g s: too short a piece", test->start_s);
}

static int prepare(struct residual_test *t, const struct recording *recording, int of, enum cycles which, struct error *error) {
    const struct recording_test *test = &recording->test[of];
    t->of = of;
    t->legs = params_legs(recording->params);
    t->pressures = recording->measured.pressures;
    t->chambers = recording->measured.pressures && recording->measured.valve;
    t->step_s = recording_step_s(test);
    t->substeps = (int)ceil(t->step_s / SUBSTEP_S - 1e-6);
    return test->piece_s > 0.0 ? prepare_piece(t, test, error) : prepare_cycle(t, test, which, error);
}

/* Every other piece is kept from the fits, as every other cycle is. */
static bool wanted(const struct recording_test *test, enum cycles which) {
    return !(test->piece_s > 0.0) || which & (test->piece % 2 ? CYCLES_ODD : CYCLES_EVEN);
}

double residual_margin_s(double piece_s) { return OVERLAP * piece_s; }

double residual_gap_s(double piece_s, double step_s) {
    return fmax(STRETCH * (1.0 + 2.0 * OVERLAP) * piece_s / (2 * SPECTRUM_HARMONICS), 2.5 * step_s);
}

int residual_prepare(struct residual_data *d, const struct recording *recording, enum cycles which, struct error *error) {
    *d = (struct residual_data){.test = calloc((size_t)recording->tests + 1, sizeof *d->test)};
    if (!d->test) return error_set(error, STATUS_IO, "out of memory");
    for (int i = 0; i < recording->tests; i++) {
        if (!wanted(&recording->test[i], which)) continue;
        int status = prepare(&d->test[d->tests++], recording, i, which, error);
        if (status) return status;
        d->parts = d->test[0].chambers ? PART_ALL : PART_FORCE;
    }
    return STATUS_OK;
}

void residual_free(struct residual_data *d) {
    for (int i = 0; i < d->tests; i++) {
        free(d->test[i].coupling);
        free(d->test[i].cycle);
        free(d->test[i].shape);
        free(d->test[i].project);
        free(d->test[i].series);
        free(d->test[i].node);
        free(d->test[i].valve);
        free(d->test[i].projection);
    }
    free(d->test);
    *d = (struct residual_data){0};
}

/* Fourier coefficients of a test's lengths and pressures. */
struct series {
    double length[LEGS][SPECTRUM_SIZE], p1[LEGS][SPECTRUM_SIZE], p2[LEGS][SPECTRUM_SIZE];
};

/* Of a series. */
static void to_row(const struct residual_test *t, const double *series, double row[RESIDUAL_SIZE]) {
    memset(row, 0, RESIDUAL_SIZE * sizeof *row);
    for (int a = 0; a < t->size; a++) {
        for (int b = 0; b < motion_size(t); b++) row[a] += t->coupling[a][b] * series[b];
    }
}

/* What moves the legs: chambers' pressures, or what the force sensor says. */
static void push(const struct cylinder_model *m, const struct residual_test *t, const struct series *rows, int leg,
                 double force_n[SPECTRUM_SIZE]) {
    for (int a = 0; a < motion_size(t); a++)
        force_n[a] = t->pressures ? m->a1_m2 * rows->p1[leg][a] - m->a2_m2 * rows->p2[leg][a] : t->spectrum.mean[CHANNEL_FORCE][leg][a];
    if (m->machine.params->mechanism == MECHANISM_AXIS) force_n[0] -= m->machine.params->axis.force_offset_n;
}


/* The value of which the sensor makes the reading. */
static void undo(const struct sensor_path *path, const struct residual_test *t, const double *reading, double *value) {
    memset(value, 0, SPECTRUM_SIZE * sizeof *value);
    value[0] = (reading[0] - path->offset) / path->scale;
    for (int h = 1; h <= t->harmonics; h++) {
        double w = h * t->spectrum.omega, lag = w * path->lag_s, s1 = sin(w * path->delay_s), c1 = cos(w * path->delay_s);
        double s = (reading[2 * h - 1] - lag * reading[2 * h]) / path->scale, c = (reading[2 * h] + lag * reading[2 * h - 1]) / path->scale;
        value[2 * h - 1] = s * c1 - c * s1;
        value[2 * h] = s * s1 + c * c1;
    }
}

/* What a difference of values is in the reading: there its noise is what the whitener takes it for, whatever the sensor's scale and lag. */
static void read_back(const struct sensor_path *path, const struct residual_test *t, double *row) {
    for (int a = 0; a < t->size; a++) row[a] *= path->scale / hypot(1.0, t->rate[a] * path->lag_s);
}

/* The same for A1 P1 - A2 P2: as the noise of both readings is in it; lag and delay are those of P1. */
static void read_force_back(const struct cylinder_model *m, const struct residual_test *t, int leg, double *row) {
    struct sensor_path both = m->machine.p1[leg];
    double a1 = m->a1_m2, a2 = m->a2_m2;
    both.scale = hypot(a1, a2) / hypot(a1 / m->machine.p1[leg].scale, a2 / m->machine.p2[leg].scale);
    read_back(&both, t, row);
}

static void undo_all(const struct machine *m, const struct residual_test *t, struct series *rows) {
    const struct spectrum *s = &t->spectrum;
    for (int k = 0; k < LEGS; k++) {
        undo(&m->length[k], t, s->mean[CHANNEL_LENGTH][k], rows->length[k]);
        undo(&m->p1[k], t, s->mean[CHANNEL_P1][k], rows->p1[k]);
        undo(&m->p2[k], t, s->mean[CHANNEL_P2][k], rows->p2[k]);
    }
}

static double at(const double *basis, int size, const double *row) {
    double sum = 0.0;
    for (int a = 0; a < size; a++) sum += basis[a] * row[a];
    return sum;
}

_Static_assert(CYCLE_STEPS % PHASES == 0, "phases are steps of the cycle");

static const double *basis_at(const struct residual_test *t, int step) { return t->cycle + step % CYCLE_STEPS * SPECTRUM_SIZE; }

/* Series of the rates. */
static void differentiate(const struct residual_test *t, const double *row, double *rate) {
    rate[0] = 0.0;
    for (int h = 1; h <= t->harmonics; h++) {
        rate[2 * h - 1] = -h * t->spectrum.omega * row[2 * h];
        rate[2 * h] = h * t->spectrum.omega * row[2 * h - 1];
    }
}

/* Motion at a node. */
struct node {
    double length_m[LEGS], rate_mps[LEGS];
};

/* The hydraulics while they run through the cycles. */
struct run {
    const struct residual_test *t;
    struct params timing;        /* the model's, with the recording's sampling for a cycle of the loop */
    struct cylinder_model cylinder;
    struct valve_line line;
    struct hydraulics_state state;
    struct node node[3];
    double rate[LEGS][SPECTRUM_SIZE];
};

/* Pressures at the gauges, and how far they are above the chambers'. */
struct pressure_rows {
    double port[PORTS][LEGS][RESIDUAL_SIZE], drop[PORTS][LEGS][RESIDUAL_SIZE];
};

static void look(const struct run *r, const struct series *rows, int node, struct node *to) {
    int size = motion_size(r->t);
    const double *basis = r->t->node + (size_t)node * (size_t)size;
    for (int k = 0; k < LEGS; k++) {
        to->length_m[k] = at(basis, size, rows->length[k]);
        to->rate_mps[k] = at(basis, size, r->rate[k]);
    }
}

static bool begin_run(struct run *r, const struct residual_test *t, const struct params *model, const struct series *rows) {
    double force_n[LEGS], p1[LEGS], p2[LEGS];
    r->t = t;
    r->timing = *model;
    r->timing.loop.period_s = t->step_s;
    r->timing.sim.substeps = t->substeps;
    cylinder_model_init(&r->cylinder, &r->timing);
    memset(r->cylinder.machine.clearance_m, 0, sizeof r->cylinder.machine.clearance_m); /* the piston's motion is measured */
    if (valve_line_init(&r->line, &r->cylinder.machine)) return false;
    valve_line_rest(&r->line);
    memset(&r->state, 0, sizeof r->state);
    for (int k = 0; k < LEGS; k++) {
        differentiate(t, rows->length[k], r->rate[k]);
        p1[k] = at(t->node, motion_size(t), rows->p1[k]);
        p2[k] = at(t->node, motion_size(t), rows->p2[k]);
        r->state.cylinder[k] = (struct cylinder_state){.p1_pa = p1[k], .p2_pa = p2[k], .spool = t->valve[k]};
        force_n[k] = cylinder_hydraulic_force(&r->cylinder, &r->state.cylinder[k]);
    }
    hydraulics_rest(&r->cylinder, force_n, &r->state);
    look(r, rows, 0, &r->node[0]);
    return true;
}

/* To the next sample. */
static void run_on(struct run *r, const struct series *rows, int sample) {
    const struct residual_test *t = r->t;
    double valve[LEGS];
    struct hydraulics_input in[3];
    for (int i = 0; i < 3; i++) in[i] = (struct hydraulics_input){r->node[i].length_m, r->node[i].rate_mps, valve};
    valve_line_send(&r->line, t->valve + (size_t)sample * LEGS);
    for (int j = 0; j < t->substeps; j++) {
        int node = 2 * (sample * t->substeps + j);
        valve_line_receive(&r->line, j, valve);
        look(r, rows, node + 1, &r->node[1]);
        look(r, rows, node + 2, &r->node[2]);
        hydraulics_step(&r->cylinder, t->step_s / t->substeps, in, &r->state);
        r->node[0] = r->node[2];
    }
}

static void add_sample(const struct run *r, int place, struct pressure_rows *p) {
    for (int k = 0; k < LEGS; k++) {
        const struct cylinder_state *s = &r->state.cylinder[k];
        bool line = r->cylinder.leg[k].line_volume_m3 > 0.0;
        double chamber[PORTS] = {s->p1_pa, s->p2_pa};
        for (int i = 0; i < PORTS; i++) {
            double port = line ? r->state.line[k][i].pressure_pa : chamber[i];
            for (int a = 0; a < r->t->size; a++) {
                double weight = r->t->projection[a * r->t->fitted + place];
                p->port[i][k][a] += weight * port;
                p->drop[i][k][a] += weight * (port - chamber[i]);
            }
        }
    }
}

static bool simulate_pressures(const struct residual_test *t, const struct params *model, const struct series *rows,
                               struct pressure_rows *p) {
    struct run *r = malloc(sizeof *r);
    bool ok = r && begin_run(r, t, model, rows);
    memset(p, 0, sizeof *p);
    for (int i = 0; i < t->samples && ok; i++) {
        int place = i - (t->samples - t->fitted);
        if (place >= 0) add_sample(r, place, p);
        run_on(r, rows, i);
    }
    if (ok) valve_line_free(&r->line);
    free(r);
    return ok;
}

/* What is measured at each phase, pressures in the chambers: so far below the gauges. */
static void tabulate_cycle(const struct residual_test *t, const struct cylinder_model *m, const struct series *rows,
                           const struct pressure_rows *p, struct inverse_dynamics_input table[PHASES]) {
    int size = motion_size(t);
    for (int k = 0; k < LEGS; k++) {
        double force_n[SPECTRUM_SIZE];
        push(m, t, rows, k, force_n);
        for (int i = 0; i < t->phases; i++) {
            const double *basis = basis_at(t, i * (CYCLE_STEPS / PHASES));
            double drop[PORTS] = {0};
            for (int port = 0; port < PORTS && p; port++) drop[port] = at(t->shape[i], t->size, p->drop[port][k]);
            spectrum_at(rows->length[k], t->harmonics, t->spectrum.omega, basis, table[i].leg[k]);
            table[i].p1_pa[k] = at(basis, size, rows->p1[k]) - drop[PORT_A];
            table[i].p2_pa[k] = at(basis, size, rows->p2[k]) - drop[PORT_B];
            table[i].push_n[k] = at(basis, size, force_n) - m->a1_m2 * drop[PORT_A] + m->a2_m2 * drop[PORT_B];
        }
    }
}

/* Adds what a phase contributes to a row. */
static void project_phase(const struct residual_test *t, int phase, double value, double *row) {
    for (int a = 0; a < t->size; a++) row[a] += t->project[phase][a] * value;
}

/* What the leg's chambers and friction together give to its joint. */
static double net_force(const struct residual_test *t, const struct cylinder_model *m, int leg, const double *basis, double *length_m) {
    const struct spectrum *all = &t->spectrum;
    int size = 1 + 2 * all->harmonics;
    double motion[3];
    spectrum_at(all->mean[CHANNEL_LENGTH][leg], all->harmonics, all->omega, basis, motion);
    *length_m = motion[0];
    struct cylinder_state s = {.p1_pa = at(basis, size, all->mean[CHANNEL_P1][leg]), .p2_pa = at(basis, size, all->mean[CHANNEL_P2][leg])};
    int direction = motion[1] < 0.0 ? -1 : 1;
    struct friction f = cylinder_friction(m, leg, &s, direction, fabs(motion[1]));
    return cylinder_hydraulic_force(m, &s) - direction * (f.dry + f.viscous);
}

/* From piston to joint: the play is crossed at the speed at which the leg's force meets the drag of the film (hydraulics.h). */
static void take_play(const struct residual_test *t, const struct cylinder_model *m, struct series *rows) {
    enum { FINER = CYCLE_STEPS / PHASES };
    double step_s = 2.0 * PI / t->spectrum.omega / CYCLE_STEPS;
    for (int k = 0; k < LEGS; k++) {
        double half_m = 0.5 * m->machine.clearance_m[k], play_m = 0.0;
        int steps = FINER * t->phases, before = t->spectrum.cycles ? steps : 0; /* a first cycle finds where the second one starts */
        struct series joint = *rows;
        for (int i = -before; i < steps && half_m > 0.0; i++) {
            double length_m, force_n = net_force(t, m, k, basis_at(t, i < 0 ? i + steps : i), &length_m);
            for (int a = 0; a < motion_size(t) && i >= 0 && i % FINER == 0; a++)
                joint.length[k][a] -= t->series[i / FINER][a] * play_m;
            play_m = fmin(fmax(play_m + step_s * force_n / hydraulics_film(m, k, length_m), -half_m), half_m);
        }
        memcpy(rows->length[k], joint.length[k], sizeof joint.length[k]);
    }
}

static bool required(const struct residual_test *t, const struct params *model, const struct series *rows,
                     const struct pressure_rows *p, double force_n[LEGS][RESIDUAL_SIZE]) {
    struct inverse_dynamics inverse;
    struct inverse_dynamics_input table[PHASES];
    double force[LEGS];
    double period_s = 2.0 * PI / t->spectrum.omega, step_m = model->sensors.enabled ? model->sensors.position_resolution_m : 0.0;
    bool axis = model->mechanism == MECHANISM_AXIS; /* its strokes are long: to leave the reversals out would cost more than they hide */
    inverse_dynamics_init(&inverse, model, period_s / PHASES, axis || !t->spectrum.cycles ? 0.0 : period_s / (4 * t->harmonics));
    for (int k = 0; k < LEGS && !axis; k++) inverse.speed_std_mps[k] = spectrum_speed_std(&t->spectrum, k, t->harmonics, step_m, t->fitted);
    tabulate_cycle(t, &inverse.cylinder, rows, p, table);
    memset(force_n, 0, LEGS * sizeof force_n[0]);
    for (int i = 0; i < t->phases; i++) {
        if (!inverse_dynamics_step(&inverse, &table[i], force)) return false;
        for (int k = 0; k < LEGS; k++) project_phase(t, i, force[k], force_n[k]);
    }
    return true;
}

bool residual_required(const struct residual_test *t, const struct params *model, double force_n[LEGS][RESIDUAL_SIZE]) {
    struct series rows;
    struct cylinder_model cylinder;
    cylinder_model_init(&cylinder, model);
    undo_all(&cylinder.machine, t, &rows);
    take_play(t, &cylinder, &rows);
    return required(t, model, &rows, NULL, force_n);
}

void residual_rate(const struct residual_test *t, int leg, double row[RESIDUAL_SIZE]) {
    double rate[SPECTRUM_SIZE];
    differentiate(t, t->spectrum.mean[CHANNEL_LENGTH][leg], rate);
    to_row(t, rate, row);
}

double residual_variation(const struct residual_test *t, enum channel channel, int leg) {
    const struct spectrum *s = &t->spectrum;
    double sum = 0.0, square_sum = 0.0;
    for (int i = 0; i < t->phases; i++) {
        const double *basis = t->cycle + i * (CYCLE_STEPS / PHASES) * SPECTRUM_SIZE;
        double value = 0.0;
        for (int a = 1; a < 1 + 2 * t->harmonics; a++) value += basis[a] * s->mean[channel][leg][a];
        sum += value, square_sum += value * value;
    }
    return fmax(square_sum - sum * sum / t->phases, 0.0) / t->phases;
}

static bool has_lines(const struct cylinder_model *m) {
    bool lines = false;
    for (int k = 0; k < LEGS; k++) lines = lines || m->leg[k].line_volume_m3 > 0.0;
    return lines;
}

bool residual_legs_apart(const struct params *model) {
    struct machine m;
    machine_init(&m, model);
    bool apart = !(m.supply_resistance_pa_s_per_m3 > 0.0 || m.tank_resistance_pa_s_per_m3 > 0.0);
    for (int k = 0; k < LEGS; k++) apart = apart && !(m.clearance_m[k] > 0.0);
    return apart;
}

/* Rows that are never evaluated. */
static void clear_others(const struct residual_test *t, residual_row row) {
    for (int k = 0; k < LEGS; k++)
        for (int q = 0; q < RESIDUALS; q++)
            if (k >= t->legs || (q != RESIDUAL_FORCE && !t->chambers)) memset(row[k][q], 0, sizeof row[k][q]);
}

bool residual_evaluate(const struct residual_test *t, const struct params *model, enum residual_part parts, residual_row row) {
    struct cylinder_model cylinder;
    struct series rows;
    struct pressure_rows p;
    double force[LEGS][RESIDUAL_SIZE];
    struct error impossible;
    cylinder_model_init(&cylinder, model);
    if (machine_check(&cylinder.machine, &impossible)) return false;
    undo_all(&cylinder.machine, t, &rows);
    if (has_lines(&cylinder)) parts = PART_ALL; /* the gauge is not at the chamber */
    if (!t->chambers) parts &= PART_FORCE;
    bool lines = has_lines(&cylinder) && parts & PART_PRESSURE;
    clear_others(t, row);
    if (parts & PART_PRESSURE) {
        if (!simulate_pressures(t, model, &rows, &p)) return false;
        for (int k = 0; k < t->legs; k++) {
            to_row(t, rows.p1[k], row[k][RESIDUAL_P1]);
            to_row(t, rows.p2[k], row[k][RESIDUAL_P2]);
            for (int a = 0; a < t->size; a++)
                row[k][RESIDUAL_P1][a] -= p.port[PORT_A][k][a], row[k][RESIDUAL_P2][a] -= p.port[PORT_B][k][a];
            read_back(&cylinder.machine.p1[k], t, row[k][RESIDUAL_P1]);
            read_back(&cylinder.machine.p2[k], t, row[k][RESIDUAL_P2]);
        }
    }
    if (!(parts & PART_FORCE)) return true;
    take_play(t, &cylinder, &rows);
    if (!required(t, model, &rows, lines ? &p : NULL, force)) return false;
    for (int k = 0; k < t->legs; k++) {
        double push_n[SPECTRUM_SIZE], *net = row[k][RESIDUAL_FORCE];
        push(&cylinder, t, &rows, k, push_n);
        to_row(t, push_n, net);
        for (int a = 0; a < t->size; a++) {
            if (lines) net[a] -= cylinder.a1_m2 * p.drop[PORT_A][k][a] - cylinder.a2_m2 * p.drop[PORT_B][k][a];
            net[a] -= force[k][a];
        }
        if (t->pressures) read_force_back(&cylinder, t, k, net);
    }
    return true;
}
