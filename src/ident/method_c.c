#include "method_c.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "inverse_dynamics.h"
#include "nominal.h"
#include "units.h"
#include "whiten.h"

enum { SHAPES = 3 }; /* of dry friction that is not the same all the time: at two low speeds, and with the pressures */
enum { ENTRIES = MATRIX_ENTRIES, VISCOUS = ENTRIES, DRY = VISCOUS + LEGS, SHAPE = DRY + 2 * LEGS, UNKNOWNS = SHAPE + SHAPES * LEGS,
       COLUMNS = UNKNOWNS + 1 };
enum { ROWS = LEGS * RESIDUAL_SIZE, PASSES = 3, COORDINATES = 6 /* of a leg's two joints, the keys of geometry_error */ };

static const double SURE = 3.0;        /* standard deviations of a leg's speed */
static const double RESOLVED = 0.125;  /* of the period of a motion's highest harmonic: so near to a reversal nobody knows when it was */
static const double STICK_MPS = 2e-3;
static const double LOW_MPS[2] = {0.01, 0.03}; /* Stribeck */
static const double STUCK = 0.6;       /* of dry friction: where it is anything between both directions', about their mean (1 / sqrt(3)) */
static const double LEAST_N = 1e-3;    /* of dry friction: none */
static const double FIRST_SHARE = 0.5; /* of the force's variation: what dry friction may be before any was found */
static const double MODEL_ERROR = 1e-4; /* of the force's variation: what no model meets */
static const double UNDETERMINED = 0.2; /* of sqrt(M_ii M_jj) */

/* One test or piece: rows of all legs, the last column is what is to be explained. */
struct rows {
    int count;
    double column[COLUMNS][ROWS];
    double hidden[LEGS][RESIDUAL_SIZE][RESIDUAL_SIZE]; /* covariance of a friction of 1 N that is anything where the leg may stick */
    double covariance[ROWS * ROWS];
};

struct normal {
    double product[UNKNOWNS * UNKNOWNS], with[UNKNOWNS], square;
    int rows;
};

struct work {
    const struct params *params; /* bare_machine() */
    struct residual_data data;
    struct rows rows;
    struct normal normal;
    double (*staircase)[LEGS][RESIDUAL_SIZE];          /* of each test, N */
    double (*gain)[UNKNOWNS][ROWS];                    /* of each test: covariance^-1 columns, of the last pass */
    double leg_mass[LEGS][LEGS], nominal[DOFS][DOFS];
    double x[UNKNOWNS], covariance[UNKNOWNS][UNKNOWNS];
    double dry_n[LEGS];                                /* dry friction as the pass before has it */
};

extern const struct effect geometry_error;
static const char no_pose[] = "method C: no pose of this machine has these lengths";

static double square(double x) { return x * x; }

/* Where column c of the unknowns stands in the matrix. */
static void entry(int c, int *row, int *column) {
    int i = 0;
    while (c >= DOFS - i) c -= DOFS - i, i++;
    *row = i, *column = i + c;
}

/* The configured bodies, without friction, and without effects: a simulated machine's are in the log's configuration, and are to be found. */
static void bare_machine(struct params *p) {
    for (int k = 0; k < LEGS; k++) p->hydraulics.viscous_n_s_per_m[k] = 0.0;
    for (int e = 0; e < EFFECTS_MAX; e++) p->effects[e].on = false;
}

/* What is measured of the motion at a phase. */
static void legs_at(const struct residual_test *t, int phase, double leg[LEGS][3]) {
    const struct spectrum *s = &t->spectrum;
    const double *basis = t->cycle + phase * (CYCLE_STEPS / PHASES) * SPECTRUM_SIZE;
    for (int k = 0; k < LEGS; k++) spectrum_at(s->mean[CHANNEL_LENGTH][k], s->harmonics, s->omega, basis, leg[k]);
}

static double slowest_mps(const struct residual_test *t, const struct params *params, int leg, double acceleration) {
    const struct spectrum *s = &t->spectrum;
    double step_m = params->sensors.enabled ? params->sensors.position_resolution_m : 0.0;
    double resolution_s = RESOLVED * 2.0 * PI / (s->omega * s->harmonics);
    double noise_mps = SURE * spectrum_speed_std(s, leg, s->harmonics, step_m, t->fitted);
    return fmax(fmax(fabs(acceleration) * resolution_s, noise_mps), STICK_MPS);
}

/* The payload's mass is the mean of three entries of Mt, each of its moments m c that of two. Adds the wrench that holds the weight of what one unit
 * of an entry stands for. */
static void add_weight(int row, int column, const double rotation[3][3], double gravity_mps2, double wrench[DOFS]) {
    static const struct {
        int row, column, axis; /* of the moment */
        double share;
    } moment[] = {{0, 4, 2, 0.5}, {1, 3, 2, -0.5}, {2, 3, 1, 0.5}, {0, 5, 1, -0.5}, {1, 5, 0, 0.5}, {2, 4, 0, -0.5}};
    if (row == column && row < 3) wrench[2] -= gravity_mps2 / 3.0;
    for (int i = 0; i < 6; i++) {
        if (moment[i].row != row || moment[i].column != column) continue;
        wrench[3] -= moment[i].share * gravity_mps2 * rotation[1][moment[i].axis];
        wrench[4] += moment[i].share * gravity_mps2 * rotation[0][moment[i].axis];
    }
}

/* Dry friction that is higher at low speed, and that goes with the pressures (their mean apart). */
static void fill_shapes(const struct residual_test *t, int phase, int leg, double rate_mps, double value[SHAPES][LEGS]) {
    const struct spectrum *s = &t->spectrum;
    const double *basis = t->cycle + phase * (CYCLE_STEPS / PHASES) * SPECTRUM_SIZE;
    double p1[3], p2[3], sign = (rate_mps > 0.0) - (rate_mps < 0.0), mean = s->mean[CHANNEL_P1][leg][0] + s->mean[CHANNEL_P2][leg][0];
    spectrum_at(s->mean[CHANNEL_P1][leg], s->harmonics, s->omega, basis, p1);
    spectrum_at(s->mean[CHANNEL_P2][leg], s->harmonics, s->omega, basis, p2);
    for (int i = 0; i < 2; i++) value[i][leg] = sign * exp(-square(rate_mps / LOW_MPS[i]));
    value[2][leg] = t->pressures && mean > 0.0 ? sign * ((p1[0] + p2[0]) / mean - 1.0) : 0.0;
}

/* Values of all unknowns along the legs at a phase. */
static bool values_at(struct work *w, struct inverse_dynamics *d, const struct residual_test *t, int phase, double value[COLUMNS][LEGS],
                      bool stuck[LEGS]) {
    struct inverse_dynamics_input in = {0};
    struct rigid_legs legs;
    double j[LEGS][DOFS], acceleration[DOFS];
    legs_at(t, phase, in.leg);
    if (!inverse_dynamics_step(d, &in, value[UNKNOWNS])) return false;
    if (!inverse_dynamics_move(d, (const double(*)[3])in.leg, &legs, j, acceleration)) return false;
    for (int c = 0; c < ENTRIES; c++) {
        int row, column;
        double wrench[DOFS] = {0};
        entry(c, &row, &column);
        wrench[row] += acceleration[column];
        if (row != column) wrench[column] += acceleration[row];
        add_weight(row, column, (const double(*)[3])legs.rotation, w->params->payload.gravity_mps2, wrench);
        if (!inverse_dynamics_along_legs(j, wrench)) return false;
        memcpy(value[c], wrench, sizeof wrench);
    }
    for (int k = 0; k < LEGS; k++) {
        const double *leg = in.leg[k];
        value[VISCOUS + k][k] = leg[1];
        double slow_mps = slowest_mps(t, w->params, k, leg[2]), sign = fmin(fmax(leg[1] / slow_mps, -1.0), 1.0);
        value[DRY + 2 * k][k] = 0.5 * (1.0 + sign);
        value[DRY + 2 * k + 1][k] = -0.5 * (1.0 - sign);
        fill_shapes(t, phase, k, leg[1], &value[SHAPE + SHAPES * k]);
        stuck[k] = fabs(leg[1]) < slow_mps;
    }
    return true;
}

/* What friction within a stay at rest can do: as much as if it were the same all through it, whatever its course. */
static void hide(struct rows *r, const struct residual_test *t, int leg, bool stuck[PHASES][LEGS]) {
    int n = t->phases;
    bool cycle = t->spectrum.cycles > 0; /* closed: its end is its start */
    for (int i = 0; i < n; i++) {
        int from = i, to = i;
        if (!stuck[i][leg]) continue;
        while (to - from < n - 1 && (cycle || from > 0) && stuck[(from - 1 + n) % n][leg]) from--;
        while (to - from < n - 1 && (cycle || to < n - 1) && stuck[(to + 1) % n][leg]) to++;
        for (int a = 0; a < t->size; a++)
            for (int b = 0; b < t->size; b++) r->hidden[leg][a][b] += (to - from + 1) * t->project[i][a] * t->project[i][b];
    }
}

static bool fill_columns(struct work *w, const struct params *machine, int test) {
    const struct residual_test *t = &w->data.test[test];
    struct rows *r = &w->rows;
    struct inverse_dynamics d;
    bool stuck[PHASES][LEGS];
    memset(r, 0, sizeof *r);
    r->count = LEGS * t->size;
    inverse_dynamics_init(&d, machine, 0.0, 0.0);
    for (int i = 0; i < t->phases; i++) {
        double value[COLUMNS][LEGS] = {{0}};
        if (!values_at(w, &d, t, i, value, stuck[i])) return false;
        for (int c = 0; c < COLUMNS; c++)
            for (int k = 0; k < LEGS; k++)
                for (int a = 0; a < t->size && value[c][k] != 0.0; a++) r->column[c][k * t->size + a] += t->project[i][a] * value[c][k];
    }
    for (int k = 0; k < LEGS; k++) {
        hide(r, t, k, stuck);
        double *target = &r->column[UNKNOWNS][k * t->size];
        for (int a = 0; a < t->size; a++) target[a] = t->row[CHANNEL_FORCE][k][a] - w->staircase[test][k][a] - target[a];
    }
    return true;
}

static void expect_friction(struct work *w, int pass) {
    for (int k = 0; k < LEGS; k++) {
        double most = 0.0, mean = 0.5 * fabs(w->x[DRY + 2 * k] + w->x[DRY + 2 * k + 1]); /* of both directions: free of a constant */
        for (int i = 0; i < w->data.tests; i++) most = fmax(most, residual_variation(&w->data.test[i], CHANNEL_FORCE, k));
        w->dry_n[k] = FIRST_SHARE * sqrt(most);
        if (pass) w->dry_n[k] = fmin(w->dry_n[k], mean); /* a leg that hardly moves has any */
    }
}

static void fill_covariance(struct work *w, const struct residual_test *t) {
    struct rows *r = &w->rows;
    double length[LEGS][RESIDUAL_SIZE];
    for (int k = 0; k < LEGS; k++)
        for (int a = 0; a < t->size; a++) length[k][a] = whiten_in_step(t, w->params, k) + square(t->std[CHANNEL_LENGTH][k][a]);
    for (int i = 0; i < LEGS; i++) {
        double friction = square(STUCK * w->dry_n[i]), floor = square(MODEL_ERROR) * residual_variation(t, CHANNEL_FORCE, i);
        for (int a = 0; a < t->size; a++) {
            double *row = r->covariance + (size_t)((i * t->size + a) * r->count);
            for (int k = 0; k <= i; k++)
                for (int j = 0; j < LEGS; j++)
                    row[k * t->size + a] += w->leg_mass[i][j] * w->leg_mass[k][j] * square(t->curve[a]) * length[j][a];
            for (int b = 0; b < t->size; b++) row[i * t->size + b] += friction * r->hidden[i][a][b];
            row[i * t->size + a] += square(t->std[CHANNEL_FORCE][i][a]) + floor;
        }
    }
}

static bool accumulate(struct work *w, int test) {
    struct rows *r = &w->rows;
    struct normal *n = &w->normal;
    double solved[ROWS];
    if (!dense_factor(r->count, r->count, r->covariance)) return false;
    for (int c = 0; c < COLUMNS; c++) {
        memcpy(solved, r->column[c], sizeof solved);
        dense_solve(r->count, r->count, r->covariance, solved);
        if (c < UNKNOWNS) memcpy(w->gain[test][c], solved, sizeof solved);
        for (int e = c; e < COLUMNS; e++) {
            double sum = 0.0;
            for (int i = 0; i < r->count; i++) sum += solved[i] * r->column[e][i];
            if (e < UNKNOWNS) n->product[e * UNKNOWNS + c] += sum;
            else if (c < UNKNOWNS) n->with[c] += sum;
            else n->square += sum;
        }
    }
    n->rows += r->count;
    return true;
}

/* Solves for what is to be added to the configured machine. A weak prior, of the size of the matrix itself, keeps finite what the data leave open. */
static bool solve(struct work *w) {
    struct normal *n = &w->normal;
    for (int c = 0; c < UNKNOWNS; c++) {
        int row, column;
        double prior = 1e-12 * n->product[c * UNKNOWNS + c];
        if (c >= SHAPE) prior = 1.0 / square(fmax(w->dry_n[(c - SHAPE) / SHAPES], LEAST_N));
        if (c < ENTRIES) entry(c, &row, &column), prior = 1.0 / (w->nominal[row][row] * w->nominal[column][column]);
        n->product[c * UNKNOWNS + c] += prior;
        w->x[c] = n->with[c];
    }
    if (!dense_factor(UNKNOWNS, UNKNOWNS, n->product)) return false;
    dense_solve(UNKNOWNS, UNKNOWNS, n->product, w->x);
    bool finite = true;
    for (int c = 0; c < UNKNOWNS; c++) finite = finite && isfinite(w->x[c]);
    return finite;
}

/* Of the machine as it is configured: a part of a part of the force. */
static int find_staircases(struct work *w, struct error *error) {
    w->staircase = calloc((size_t)w->data.tests + 1, sizeof *w->staircase);
    w->gain = calloc((size_t)w->data.tests + 1, sizeof *w->gain);
    if (!w->staircase || !w->gain) return error_set(error, STATUS_IO, "out of memory");
    bool ok = true;
    for (int i = 0; i < w->data.tests; i++)
        ok = ok && (!w->data.test[i].chambers || residual_staircase(&w->data.test[i], w->params, w->staircase[i]));
    return ok ? STATUS_OK : error_set(error, STATUS_USAGE, "method C: the configured chambers cannot follow the commands");
}

static int pass(struct work *w, int number, struct error *error) {
    memset(&w->normal, 0, sizeof w->normal);
    expect_friction(w, number);
    for (int i = 0; i < w->data.tests; i++) {
        const struct residual_test *t = &w->data.test[i];
        if (!fill_columns(w, w->params, i)) return error_set(error, STATUS_USAGE, no_pose);
        fill_covariance(w, t);
        if (!accumulate(w, i)) return error_set(error, STATUS_USAGE, "method C: a force that is constant, or no number");
    }
    if (!solve(w)) return error_set(error, STATUS_USAGE, "method C: some leg does not move both ways");
    return STATUS_OK;
}

/* Gradient of the fit's sum of squares at the estimate, for a machine whose joints are elsewhere. False: it cannot move so. */
static bool add_gradient(struct work *w, const struct params *machine, double sign, double gradient[UNKNOWNS]) {
    const struct rows *r = &w->rows;
    for (int i = 0; i < w->data.tests; i++) {
        if (!fill_columns(w, machine, i)) return false;
        for (int row = 0; row < r->count; row++) {
            double left = r->column[UNKNOWNS][row];
            for (int c = 0; c < UNKNOWNS; c++) left -= r->column[c][row] * w->x[c];
            for (int c = 0; c < UNKNOWNS; c++) gradient[c] += sign * w->gain[i][c][row] * left;
        }
    }
    return true;
}

/* Joints that are off by their tolerance, uniform, one coordinate at a time: to first order. */
static int spread_joints(struct work *w, const struct params *configured, struct error *error) {
    struct params *machine = malloc(sizeof *machine);
    double configured_too[UNKNOWNS] = {0};
    int status = machine ? STATUS_OK : error_set(error, STATUS_IO, "out of memory"), effect = effect_find(geometry_error.name);
    if (!status && !add_gradient(w, w->params, -1.0, configured_too)) status = error_set(error, STATUS_USAGE, no_pose);
    for (int i = 0; i < COORDINATES * LEGS && !status && configured->model.tolerance.joints_m > 0.0; i++) {
        double change[UNKNOWNS];
        *machine = *w->params;
        machine->effects[effect] = (struct effect_values){.on = true};
        machine->effects[effect].value[i % COORDINATES][i / COORDINATES] = configured->model.tolerance.joints_m / sqrt(3.0);
        memcpy(change, configured_too, sizeof change);
        if (!add_gradient(w, machine, 1.0, change)) status = error_set(error, STATUS_USAGE, "method C: model.tolerance.joints_m: no pose of a machine "
                                                                       "whose joints are off by so much has these lengths: make it smaller");
        dense_solve(UNKNOWNS, UNKNOWNS, w->normal.product, change);
        for (int c = 0; c < UNKNOWNS; c++)
            for (int e = 0; e < UNKNOWNS; e++) w->covariance[c][e] += change[c] * change[e];
    }
    free(machine);
    return status;
}

/* What the rows scatter by, in units of the noise that they should have. */
static double scatter_of(const struct normal *n, const double x[UNKNOWNS]) {
    double rest = n->square;
    for (int c = 0; c < UNKNOWNS; c++) rest -= x[c] * n->with[c];
    int free = n->rows - UNKNOWNS;
    return free > 0 ? sqrt(fmax(rest, 0.0) / free) : (double)NAN;
}

/* Of the sensors' noise, or of what the rows scatter by, where that is more. */
static void spread_noise(struct work *w, double scatter) {
    for (int c = 0; c < UNKNOWNS; c++) {
        double *column = w->covariance[c];
        memset(column, 0, sizeof w->covariance[c]);
        column[c] = square(fmax(scatter, 1.0));
        dense_solve(UNKNOWNS, UNKNOWNS, w->normal.product, column);
    }
}

static void find_payload(const struct work *w, const struct params *configured, const struct kinematics *k, struct method_c *m) {
    double value[ENTRIES], covariance[ENTRIES][ENTRIES];
    for (int c = 0; c < ENTRIES; c++) {
        int i, j;
        entry(c, &i, &j);
        value[c] = w->nominal[i][j] + w->x[c];
        memcpy(covariance[c], w->covariance[c], sizeof covariance[c]);
    }
    m->payload = payload_find(configured, k, value, covariance);
}

static void report(const struct work *w, struct method_c *m) {
    for (int c = 0; c < ENTRIES; c++) {
        int i, j;
        entry(c, &i, &j);
        double std = sqrt(w->covariance[c][c]), most = UNDETERMINED * sqrt(w->nominal[i][i] * w->nominal[j][j]);
        bool known = std < most;
        m->matrix.mt[i][j] = m->matrix.mt[j][i] = known ? w->nominal[i][j] + w->x[c] : (double)NAN;
        m->matrix.mt_std[i][j] = m->matrix.mt_std[j][i] = known ? std : (double)NAN;
    }
    for (int k = 0; k < LEGS; k++) {
        m->viscous[k] = w->x[VISCOUS + k], m->viscous_std[k] = sqrt(w->covariance[VISCOUS + k][VISCOUS + k]);
        for (int s = 0; s < 2; s++) {
            int c = DRY + 2 * k + s;
            m->dry[k][s] = w->x[c], m->dry_std[k][s] = sqrt(w->covariance[c][c]);
        }
    }
    m->matrix.evaluated = true;
}

int method_c(const struct recording *recording, struct method_c *result, struct error *error) {
    static const double neutral[DOFS] = {0};
    struct work *w = calloc(1, sizeof *w);
    struct params *params = malloc(sizeof *params);
    struct kinematics k;
    *result = (struct method_c){0};
    int status = w && params ? STATUS_OK : error_set(error, STATUS_IO, "out of memory");
    if (!status) {
        *params = *recording->params;
        bare_machine(params);
        w->params = params;
        status = kinematics_init(&k, params, error);
    }
    if (!status) {
        nominal_matrix(params, &k, neutral, w->nominal);
        whiten_leg_mass(params, w->leg_mass);
        status = residual_prepare(&w->data, recording, CYCLES_ALL, error);
        if (!status) status = find_staircases(w, error);
        for (int i = 0; i < PASSES && !status; i++) status = pass(w, i, error);
        if (!status) {
            result->scatter = scatter_of(&w->normal, w->x);
            spread_noise(w, result->scatter);
            status = spread_joints(w, recording->params, error);
        }
        if (!status) {
            report(w, result);
            find_payload(w, recording->params, &k, result);
        }
        residual_free(&w->data);
    }
    if (w) free(w->staircase), free(w->gain);
    free(params);
    free(w);
    return status;
}
