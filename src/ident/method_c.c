#include "method_c.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "friction_course.h"
#include "inverse_dynamics.h"
#include "matrix_forces.h"
#include "numeric.h"
#include "params.h"
#include "series.h"
#include "skews.h"
#include "units.h"
#include "whiten.h"

enum {
    ENTRIES = MATRIX_ENTRIES,
    VISCOUS = UNKNOWN_VISCOUS,
    DRY = UNKNOWN_DRY,
    SPRING = UNKNOWN_SPRING,
    SYSTEMATIC = UNKNOWN_SYSTEMATIC,
    BASIS = UNKNOWN_BASIS
};
enum { COLUMNS = UNKNOWNS + 1, ROWS = LEGS * RESIDUAL_SIZE, PASSES = 3 };

static const double FIRST_SHARE = 0.5; /* first guess of dry friction, as a share of the rms of the
                                        * force's variation */
static const double STEP = 0.1;        /* step of difference quotients, in standard deviations of
                                        * the errors' priors */
static const double RIGID = 0.1;       /* model.tolerance.rigidity from which on the matrix counts
                                        * as 21 free entries, not as the ten parameters of a body */
static const double DOUBT = 0.3;       /* relative error of the attenuation, which is as uncertain
                                        * as a noise variance from twenty cycles */
static const double MODEL_ERROR = 1e-4; /* error of any model, as a share of the rms of the force's
                                         * variation */

/* Coefficient rows of one test or segment, all legs. A column belongs to an unknown; the last
 * one is the right-hand side. */
struct rows {
    int count;
    double column[COLUMNS][ROWS];
    double covariance[ROWS * ROWS];
};

/* A machine whose sensors and joints have the systematic errors `error`, and a test's series with
 * these errors undone. */
struct suspect {
    double error[SYSTEMATICS];
    struct params machine;
    struct series series;
};

struct work {
    const struct params *params; /* configuration without friction and effects
                                  * (matrix_bare_machine) */
    struct cylinder_model cylinder;
    struct suspect found, other; /* found: machine with the errors as found so far; other: the same
                                  * with one error changed */
    struct residual_data data;
    struct rows rows;
    struct rigid_state state[PHASES]; /* states of the platform at the phases of the current test */
    struct equations *sum;  /* equations of the current pass, summed over the tests */
    double square;          /* sum of squares of the right-hand side, weighted by the inverse
                             * covariance */
    int count;              /* number of coefficient rows */
    double noise_share;     /* variance of the noise by the last pass's residuals, as a share of the
                             * stated variance; at most 1 */
    double (*staircase)[LEGS][RESIDUAL_SIZE];          /* [tests]: ripple of the force because
                                                        * commands are held, N */
    struct friction_course *course;                    /* [tests] */
    double (*doubt)[LEGS][RESIDUAL_SIZE][RESIDUAL_SIZE];
    double weight[ROWS][ROWS];                         /* inverse covariance of a test's rows */
    double more_mass[SYSTEMATICS][LEGS][LEGS]; /* change of leg_mass by a unit of each error */
    double leg_mass[LEGS][LEGS], prior[MATRIX_ENTRIES][MATRIX_ENTRIES];
    double along[DOFS][LEGS];                          /* leg forces of unit wrenches at neutral */
    double x[UNKNOWNS];
    double departure[SKEW_TESTS]; /* departures of the tests' skews from the common one, s */
    double more[DOFS][DOFS];     /* the entries of x as a matrix */
};

extern const struct effect external_stiffness;
static const char no_pose[] = "method C: no pose of this machine has these lengths";
static const char no_inertia[] = "method C: the configured machine has no inertia";
static const char no_such_machine[] = "method C: model.tolerance: no pose of a machine whose joints or sensors are off by so much has "
                                      "these lengths: make joints_m, length_gain or length_zero_m smaller";

/* Fills a suspect for given systematic errors: its machine has the errors of the joints, and its
 * series is the test's series, corrected for the errors of the sensors and pipes. */
static void suspect_init(const struct work *w, const double error[SYSTEMATICS], int test, struct suspect *s) {
    memcpy(s->error, error, sizeof s->error);
    s->machine = *w->params;
    systematic_joints(error, &s->machine);
    systematic_undo(&w->cylinder, error, &w->data.test[test], &s->series);
}

/* Returns the index of a test's skew in w->departure. All segments of one recorded test share
 * it. */
static int skew_of(const struct work *w, int test) {
    int place = 0;
    for (int i = 1; i <= test; i++) place += w->data.test[i].of != w->data.test[i - 1].of;
    return place;
}

/* Fills w->found for a test: the machine with the errors as found so far, and the test's own
 * skew. */
static void suspect_found(struct work *w, int test) {
    double error[SYSTEMATICS];
    memcpy(error, w->x + SYSTEMATIC, sizeof error);
    error[SYSTEMATIC_SKEW] += w->departure[skew_of(w, test)];
    suspect_init(w, error, test, &w->found);
}

/* Computes the motion of the legs at a phase: length, rate and acceleration of each. */
static void legs_at(const struct suspect *s, const struct residual_test *t, int phase, double leg[LEGS][3]) {
    const double *basis = t->cycle + phase * SPECTRUM_SIZE;
    for (int k = 0; k < LEGS; k++) spectrum_at(s->series.length[k], t->spectrum.harmonics, t->spectrum.omega, basis, leg[k]);
}

/* Finds the coefficient rows of the measured forces, without the ripple of held commands. */
static void measured_force(const struct work *w, const struct suspect *s, int test, double row[ROWS]) {
    const struct residual_test *t = &w->data.test[test];
    for (int k = 0; k < LEGS; k++) {
        double push_n[SPECTRUM_SIZE], force_n[RESIDUAL_SIZE];
        series_push(&w->cylinder, t, &s->series, k, push_n);
        series_row(t, push_n, force_n);
        for (int a = 0; a < t->size; a++) row[k * t->size + a] = force_n[a] - w->staircase[test][k][a];
    }
}

/* Adds the wrench of springs of this stiffness at the present pose. */
static void springs_wrench(const struct inverse_dynamics *d, const double stiffness[DOFS], double wrench[DOFS]) {
    double pose[DOFS];
    struct effect_values springs = {0};
    rigid_pose(&d->state, pose);
    for (int i = 0; i < DOFS; i++) springs.value[i][0] = stiffness[i];
    external_stiffness.wrench(&springs, pose, wrench);
}

/* Finds the leg forces for one unit of each spring. Returns false if the Jacobian is singular. */
static bool springs_at(const struct work *w, const struct inverse_dynamics *d, double j[LEGS][DOFS], double value[COLUMNS][LEGS]) {
    for (int i = 0; i < DOFS; i++) {
        double wrench[DOFS] = {0}, unit[DOFS] = {0};
        if (!(w->sum->spring[i] > 0.0)) continue;
        unit[i] = 1.0;
        springs_wrench(d, unit, wrench);
        if (!inverse_dynamics_along_legs(j, wrench)) return false;
        for (int k = 0; k < LEGS; k++) value[SPRING + i][k] = -wrench[k];
    }
    return true;
}

/* Finds the coefficients of all unknowns except the systematic errors in the force of each leg at a
 * phase, and in value[UNKNOWNS] the force that depends on no unknown. Returns false if no pose has
 * these lengths or the Jacobian is singular. */
static bool values_at(const struct work *w, const struct suspect *s, struct inverse_dynamics *d, int test, int phase,
                      double value[COLUMNS][LEGS]) {
    const struct friction_course *course = &w->course[test];
    struct rigid_legs legs;
    double j[LEGS][DOFS], acceleration[DOFS], leg[LEGS][3];
    legs_at(s, &w->data.test[test], phase, leg);
    if (!inverse_dynamics_bodies(d, (const double (*)[3])leg, &legs, j, acceleration, value[UNKNOWNS])) return false;
    if (!inverse_dynamics_along_legs(j, value[UNKNOWNS])) return false;
    if (!matrix_forces(&legs, j, acceleration, w->params->payload.gravity_mps2, value)) return false;
    if (!springs_at(w, d, j, value)) return false;
    for (int k = 0; k < LEGS; k++) {
        double direction = course->direction[phase][k];
        value[VISCOUS + k][k] = leg[k][1];
        value[DRY + 2 * k][k] = 0.5 * (1.0 + direction);
        value[DRY + 2 * k + 1][k] = -0.5 * (1.0 - direction);
        for (int i = 0; i < BASIS_SIZE; i++) value[BASIS + BASIS_SIZE * k + i][k] = course->basis[i][phase][k];
    }
    return true;
}

static bool fill_columns(struct work *w, int test) {
    const struct residual_test *t = &w->data.test[test];
    struct rows *r = &w->rows;
    struct inverse_dynamics d;
    double force_n[ROWS];
    memset(r, 0, sizeof *r);
    r->count = LEGS * t->size;
    inverse_dynamics_init(&d, &w->found.machine, 0.0, 0.0);
    for (int i = 0; i < t->phases; i++) {
        double value[COLUMNS][LEGS] = {{0}};
        if (!values_at(w, &w->found, &d, test, i, value)) return false;
        w->state[i] = d.state;
        for (int c = 0; c < COLUMNS; c++)
            for (int k = 0; k < LEGS; k++)
                for (int a = 0; a < t->size && value[c][k] != 0.0; a++) r->column[c][k * t->size + a] += t->project[i][a] * value[c][k];
    }
    measured_force(w, &w->found, test, force_n);
    for (int row = 0; row < r->count; row++) r->column[UNKNOWNS][row] = force_n[row] - r->column[UNKNOWNS][row];
    return true;
}

/* Finds the force of each leg that a machine needs for the motion at a phase, with all unknowns as
 * found so far. Dry friction is left out, because no systematic error changes it. Returns false if
 * the machine cannot move as measured. */
static bool needed_at(const struct work *w, const struct suspect *s, struct inverse_dynamics *d, int test, int phase,
                      double force_n[LEGS]) {
    struct rigid_legs legs;
    double j[LEGS][DOFS], acceleration[DOFS], leg[LEGS][3], spring[DOFS] = {0};
    legs_at(s, &w->data.test[test], phase, leg);
    if (!inverse_dynamics_bodies(d, (const double (*)[3])leg, &legs, j, acceleration, force_n)) return false;
    matrix_wrench(&legs, acceleration, w->params->payload.gravity_mps2, w->more, force_n);
    springs_wrench(d, w->x + SPRING, spring);
    for (int i = 0; i < DOFS; i++) force_n[i] -= spring[i];
    if (!inverse_dynamics_along_legs(j, force_n)) return false;
    for (int k = 0; k < LEGS; k++) force_n[k] += w->x[VISCOUS + k] * leg[k][1];
    return true;
}

/* Finds the coefficient rows of the force of needed_at(). state: states of the machine at all
 * phases, near which the poses are searched; updated. */
static bool needed_force(const struct work *w, const struct suspect *s, int test, struct rigid_state state[PHASES], double row[ROWS]) {
    const struct residual_test *t = &w->data.test[test];
    struct inverse_dynamics d;
    memset(row, 0, ROWS * sizeof *row);
    inverse_dynamics_init(&d, &s->machine, 0.0, 0.0);
    for (int i = 0; i < t->phases; i++) {
        double force_n[LEGS];
        d.state = state[i];
        if (!needed_at(w, s, &d, test, i, force_n)) return false;
        state[i] = d.state;
        for (int k = 0; k < LEGS; k++)
            for (int a = 0; a < t->size; a++) row[k * t->size + a] += t->project[i][a] * force_n[k];
    }
    return true;
}

/* Finds the rows of the measured force for a machine in which one error differs by `by` from its
 * value found so far. Afterwards w->other is this machine. */
static void measured_off(struct work *w, int test, int error, double by, double row[ROWS]) {
    double off[SYSTEMATICS];
    memcpy(off, w->found.error, sizeof off);
    off[error] += by;
    suspect_init(w, off, test, &w->other);
    measured_force(w, &w->other, test, row);
}

/* Linearises the rows in the systematic errors, about their values found so far. The column of an
 * error is the change of the needed force less the change of the measured force; the right-hand
 * side is extrapolated to errors of zero. Returns false if a machine with such an error cannot move
 * as measured. */
static bool fill_systematic(struct work *w, int test) {
    struct rows *r = &w->rows;
    double needed_n[ROWS], below_n[ROWS], above_n[ROWS];
    if (!needed_force(w, &w->found, test, w->state, needed_n)) return false;
    for (int s = 0; s < SYSTEMATICS; s++) {
        double step = STEP * w->sum->systematic[s], *column = r->column[SYSTEMATIC + s];
        if (!(step > 0.0)) continue;
        /* The quotient of the measured force is central. The second-order error of a one-sided
         * quotient would correlate a skew's column with the noise of the right-hand side. */
        measured_off(w, test, s, -step, below_n);
        measured_off(w, test, s, step, above_n);
        for (int row = 0; row < r->count; row++) column[row] = (below_n[row] - above_n[row]) / (2.0 * step);
        if (systematic_moves(s)) {
            if (!needed_force(w, &w->other, test, w->state, above_n)) return false;
            for (int row = 0; row < r->count; row++) column[row] += (above_n[row] - needed_n[row]) / step;
        }
        for (int row = 0; row < r->count; row++) r->column[UNKNOWNS][row] += column[row] * w->found.error[s];
    }
    return true;
}

static void expect_friction(struct work *w, int pass) {
    for (int k = 0; k < LEGS; k++) {
        /* A constant error of the force does not change the mean of both directions. */
        double most = 0.0, mean = 0.5 * fabs(w->x[DRY + 2 * k] + w->x[DRY + 2 * k + 1]);
        for (int i = 0; i < w->data.tests; i++) most = fmax(most, residual_variation(&w->data.test[i], CHANNEL_FORCE, k));
        w->sum->dry_n[k] = FIRST_SHARE * sqrt(most);
        /* The first guess is an upper bound, because the estimate for a leg that hardly moves may
         * take any value. */
        if (pass) w->sum->dry_n[k] = fmin(w->sum->dry_n[k], mean);
    }
}

static void fill_covariance(struct work *w, int test) {
    const struct residual_test *t = &w->data.test[test];
    struct rows *r = &w->rows;
    double length[LEGS][RESIDUAL_SIZE];
    for (int k = 0; k < LEGS; k++)
        for (int a = 0; a < t->size; a++) length[k][a] = square(t->std[CHANNEL_LENGTH][k][a]);
    for (int i = 0; i < LEGS; i++) {
        double friction = square(w->sum->dry_n[i]), floor = square(MODEL_ERROR) * residual_variation(t, CHANNEL_FORCE, i);
        for (int a = 0; a < t->size; a++) {
            double *row = r->covariance + (size_t)((i * t->size + a) * r->count);
            for (int k = 0; k <= i; k++)
                for (int j = 0; j < LEGS; j++)
                    row[k * t->size + a] += w->leg_mass[i][j] * w->leg_mass[k][j] * square(t->curve[a]) * length[j][a];
            for (int b = 0; b < t->size; b++) row[i * t->size + b] += friction * w->doubt[test][i][a][b];
            row[i * t->size + a] += square(t->std[CHANNEL_FORCE][i][a]) + floor;
        }
    }
}

static bool accumulate(struct work *w) {
    struct rows *r = &w->rows;
    double solved[ROWS];
    int column[COLUMNS], columns = 0; /* columns that are not zero */
    if (!dense_factor(r->count, r->count, r->covariance)) return false;
    for (int c = 0; c < COLUMNS; c++)
        if (c == UNKNOWNS || dense_dot(r->count, r->column[c], r->column[c]) != 0.0) column[columns++] = c;
    for (int a = 0; a < columns; a++) {
        int c = column[a];
        memcpy(solved, r->column[c], sizeof solved);
        dense_solve(r->count, r->count, r->covariance, solved);
        for (int b = a; b < columns; b++) {
            int e = column[b];
            double sum = dense_dot(r->count, solved, r->column[e]);
            if (e < UNKNOWNS) w->sum->product[e][c] += sum;
            else if (c < UNKNOWNS) w->sum->with[c] += sum;
            else w->square += sum;
        }
    }
    w->count += r->count;
    return true;
}

/* Inverts the covariance, which accumulate() has replaced by its Cholesky factor. */
static void invert(struct work *w) {
    const struct rows *r = &w->rows;
    for (int i = 0; i < r->count; i++) {
        double *row = w->weight[i];
        memset(row, 0, sizeof w->weight[i]);
        row[i] = 1.0;
        dense_solve(r->count, r->count, r->covariance, row);
    }
}

/* Adds the attenuation by the noise n of one leg's acceleration in one coefficient. weighted: noise
 * of the right-hand side, -L n, weighted by the inverse covariance, for n = -1. */
static void attenuate_lengths(struct work *w, bool pipes, int leg, double variance, const double weighted[LEGS]) {
    double *to = w->sum->attenuation, oil = pipes ? variance * systematic_pipe_mass(&w->cylinder, leg) * weighted[leg] : 0.0;
    to[SYSTEMATIC + SYSTEMATIC_PIPE] -= oil;
    to[SYSTEMATIC + SYSTEMATIC_PIPE_REST + leg] -= oil;
    for (int c = 0; c < ENTRIES; c++) {
        int i, j;
        equations_entry(c, &i, &j);
        for (int k = 0; k < LEGS; k++) {
            double t_km = w->along[i][k] * w->along[j][leg] + (i != j ? w->along[j][k] * w->along[i][leg] : 0.0);
            to[c] -= variance * t_km * weighted[k];
        }
    }
    for (int s = SYSTEMATIC_LENGTH_GAIN; s < SYSTEMATICS; s++)
        for (int k = 0; k < LEGS; k++) to[SYSTEMATIC + s] -= variance * w->more_mass[s][k][leg] * weighted[k];
}

/* Adds the attenuation by the noise of one leg's pressures. A pipe amplifies this noise with the
 * square of its frequency. */
static void attenuate_pipes(struct work *w, const struct residual_test *t, int a, int leg, double p1, double p2) {
    double *to = &w->sum->attenuation[SYSTEMATIC], length_m = w->found.series.length[leg][0];
    double each = square(t->rate[a]) * (p1 * systematic_pipe_gain(&w->cylinder, leg, PORT_A, length_m) +
                                        p2 * systematic_pipe_gain(&w->cylinder, leg, PORT_B, length_m));
    if (!t->pressures || !(w->sum->systematic[SYSTEMATIC_PIPE] > 0.0)) return;
    to[SYSTEMATIC_PIPE] -= each;
    to[SYSTEMATIC_PIPE_REST + leg] -= each;
}

/* Adds the attenuation of the lag T by the noise n of one leg's force. Undoing the lag amplifies
 * this noise: the right-hand side has (1 + i w T) n, and the lag's column has -i w n. Without this
 * correction the bias alone would decide between lag and skew, because a skew leaves noise as it is
 * and can replace a small lag. */
static void attenuate_lags(struct work *w, const struct residual_test *t, int a, int leg, double force) {
    const double *found = w->found.error;
    double pull = square(t->rate[a]) * (found[SYSTEMATIC_LAG] + found[SYSTEMATIC_LAG_REST + leg]) * force;
    w->sum->attenuation[SYSTEMATIC + SYSTEMATIC_LAG] -= pull;
    w->sum->attenuation[SYSTEMATIC + SYSTEMATIC_LAG_REST + leg] -= pull;
}

/* Adds the attenuation of the compliance c by the noise n of one leg's force, whose variance is
 * `force`. Per unit of c, n compresses the leg by n, which looks like an acceleration of w^2 n. The
 * column of c therefore has the noise w^2 L n, where L is the mass along the legs. The right-hand
 * side has the noise n - c w^2 L n, because the compliance found so far is undone there. */
static void attenuate_compliance(struct work *w, const struct residual_test *t, int a, int leg, double force, const double weighted[LEGS]) {
    double twice = 0.0;
    if (!(w->sum->systematic[SYSTEMATIC_COMPLIANCE] > 0.0)) return;
    for (int i = 0; i < LEGS; i++) twice += w->leg_mass[i][leg] * weighted[i];
    w->sum->attenuation[SYSTEMATIC + SYSTEMATIC_COMPLIANCE] += t->curve[a] * force *
                                                               (weighted[leg] -
                                                                w->found.error[SYSTEMATIC_COMPLIANCE] * t->curve[a] * twice);
}

/* Adds the attenuation of a test: the mean product of the noise in the columns and the noise in the
 * right-hand side. The noise n of a leg's acceleration is in the column of entry c as T_c n, T_c
 * the leg forces for one unit of the entry, and in the right-hand side as -L n, L the configured
 * mass along the legs. It is also in the columns of errors that change L, as dL n: joints, and
 * zeros and gains of lengths. The noise of a pressure is in the column of its gain and in the
 * right-hand side. Call this after invert(). */
static void add_attenuation(struct work *w, const struct residual_test *t) {
    for (int a = 0; a < t->size; a++)
        for (int k = 0; k < LEGS; k++) {
            double weighted[LEGS] = {0}, own = w->weight[k * t->size + a][k * t->size + a];
            double a1 = t->pressures ? w->cylinder.leg[k].a1_m2 * t->std[CHANNEL_P1][k][a] : t->std[CHANNEL_FORCE][k][a];
            double a2 = t->pressures ? w->cylinder.leg[k].a2_m2 * t->std[CHANNEL_P2][k][a] : 0.0;
            for (int i = 0; i < LEGS; i++)
                for (int l = 0; l < LEGS; l++) weighted[i] += w->weight[i * t->size + a][l * t->size + a] * w->leg_mass[l][k];
            attenuate_lengths(w, t->pressures && w->sum->systematic[SYSTEMATIC_PIPE] > 0.0, k,
                              square(t->curve[a]) * square(t->std[CHANNEL_LENGTH][k][a]), weighted);
            w->sum->attenuation[SYSTEMATIC + SYSTEMATIC_P1_GAIN + k] += own * square(a1);
            w->sum->attenuation[SYSTEMATIC + SYSTEMATIC_P2_GAIN + k] += own * square(a2);
            attenuate_lags(w, t, a, k, own * (square(a1) + square(a2)));
            attenuate_compliance(w, t, a, k, square(a1) + square(a2), weighted);
            attenuate_pipes(w, t, a, k, own * square(a1), own * square(a2));
        }
}

/* Adds the variance that rounding errors which repeat in every cycle give to a test's sum of
 * squared residuals. These errors follow from the places of the lengths within the sensor's step.
 * The places are one draw for the whole test, and legs that move alike have the same errors;
 * therefore all rows together count as one degree of freedom. Call this after invert(). */
static void add_repeating(struct work *w, const struct residual_test *t) {
    double share = 0.0;
    for (int a = 0; a < t->size; a++)
        for (int k = 0; k < LEGS; k++) {
            double along = 0.0, own = w->weight[k * t->size + a][k * t->size + a];
            for (int i = 0; i < LEGS; i++)
                for (int l = 0; l < LEGS; l++) along += w->leg_mass[i][k] * w->weight[i * t->size + a][l * t->size + a] * w->leg_mass[l][k];
            share += along * square(t->curve[a] * t->spectrum.in_step[CHANNEL_LENGTH][k][a]) +
                     own * square(t->spectrum.in_step[CHANNEL_FORCE][k][a]);
        }
    w->sum->repeating += 2.0 * square(share);
}

/* Subtracts the attenuation of all unknowns except the gains from the right-hand sides. share:
 * variance of the noise, as a share of the stated one. The attenuation is known only as well as
 * this variance; its uncertainty, an error that all logs share, replaces it in e->attenuation. The
 * gains are left out, because their scales are held at zero (equations.c). */
static void take_attenuation_off(struct equations *e, double share) {
    for (int c = 0; c < UNKNOWNS; c++) {
        if (c >= SYSTEMATIC && c < SYSTEMATIC + SYSTEMATIC_LENGTH_ZERO) continue;
        e->attenuation[c] *= share;
        e->with[c] -= e->attenuation[c], e->attenuation[c] *= DOUBT;
    }
}

static bool find_along(struct work *w, const double neutral_length_m[LEGS]) {
    struct inverse_dynamics d;
    struct rigid_legs legs;
    double leg[LEGS][3] = {{0}}, j[LEGS][DOFS], acceleration[DOFS];
    for (int k = 0; k < LEGS; k++) leg[k][0] = neutral_length_m[k];
    inverse_dynamics_init(&d, w->params, 0.0, 0.0);
    bool ok = inverse_dynamics_move(&d, (const double (*)[3])leg, &legs, j, acceleration);
    for (int i = 0; i < DOFS && ok; i++) {
        memset(w->along[i], 0, sizeof w->along[i]);
        w->along[i][i] = 1.0;
        ok = inverse_dynamics_along_legs(j, w->along[i]);
    }
    return ok;
}

/* Finds how the errors change the mass along the legs. */
static bool find_more_mass(struct work *w, const double neutral_length_m[LEGS]) {
    double std[SYSTEMATICS];
    struct inverse_dynamics d;
    struct rigid_legs legs;
    systematic_priors(w->params, w->data.tests && w->data.test[0].pressures, std);
    for (int s = SYSTEMATIC_LENGTH_GAIN; s < SYSTEMATICS; s++) {
        double error[SYSTEMATICS] = {0}, leg[LEGS][3] = {{0}}, j[LEGS][DOFS], acceleration[DOFS], step = STEP * std[s];
        if (!systematic_moves(s) || !(step > 0.0)) continue;
        error[s] = step;
        w->other.machine = *w->params;
        systematic_joints(error, &w->other.machine);
        for (int k = 0; k < LEGS; k++) leg[k][0] = neutral_length_m[k] - error[SYSTEMATIC_LENGTH_ZERO + k];
        inverse_dynamics_init(&d, &w->other.machine, 0.0, 0.0);
        if (!inverse_dynamics_move(&d, (const double (*)[3])leg, &legs, j, acceleration)) return false;
        inverse_dynamics_inertia(&d, w->more_mass[s]);
        for (int k = 0; k < LEGS; k++)
            for (int l = 0; l < LEGS; l++) w->more_mass[s][k][l] = (w->more_mass[s][k][l] - w->leg_mass[k][l]) / step;
    }
    for (int k = 0; k < LEGS; k++)
        for (int l = 0; l < LEGS; l++) w->more_mass[SYSTEMATIC_LENGTH_GAIN + k][l][k] -= w->leg_mass[l][k];
    return true;
}

/* Prepares for each test the course of friction, and the ripple of the force by held commands. The
 * ripple is so small that the configured machine describes it well enough. */
static int prepare_tests(struct work *w, struct error *error) {
    w->staircase = calloc((size_t)w->data.tests + 1, sizeof *w->staircase);
    w->course = calloc((size_t)w->data.tests + 1, sizeof *w->course);
    w->doubt = calloc((size_t)w->data.tests + 1, sizeof *w->doubt);
    if (!w->staircase || !w->course || !w->doubt) return error_set(error, STATUS_IO, "out of memory");
    double load_pa = friction_course_load(&w->data);
    bool ok = true;
    for (int i = 0; i < w->data.tests; i++) {
        const struct residual_test *t = &w->data.test[i];
        ok = ok && (!t->chambers || residual_staircase(t, w->params, w->staircase[i]));
        friction_course_find(&w->course[i], t, load_pa);
        for (int k = 0; k < LEGS; k++) friction_course_covariance(&w->course[i], t, k, w->doubt[i][k]);
    }
    return ok ? STATUS_OK : error_set(error, STATUS_USAGE, "method C: the configured chambers cannot follow the commands");
}

/* Finds the weighted sum of squared residuals, y' W y - x' X' W y. Because x minimises residuals
 * and prior together, this equals y' V^-1 y, where V is the rows' covariance plus the covariance
 * that the priors of the unknowns give the rows. */
static void find_rest(struct work *w) {
    /* With the prior that the payload is rigid, the matrix has only the ten parameters of a
     * body. */
    int entries = w->params->model.tolerance.rigidity < RIGID ? PAYLOAD_VALUES : MATRIX_ENTRIES;
    w->sum->rest = w->square, w->sum->free = w->count - entries - (UNKNOWN_SPRING - MATRIX_ENTRIES);
    for (int i = 0; i < DOFS; i++) w->sum->free -= w->sum->spring[i] > 0.0;
    for (int c = 0; c < UNKNOWNS; c++) w->sum->rest -= w->x[c] * w->sum->with[c];
    for (int t = 0; t < w->sum->skews; t++) w->sum->rest -= w->departure[t] * w->sum->skew[t].with;
}

/* Makes the equations of a pass. The first pass finds the size of friction and a matrix, with
 * sensors and joints as configured; each later one is linearised about the errors found before. */
static int pass(struct work *w, int number, struct error *error) {
    const struct tolerance_params *tolerance = &w->params->model.tolerance;
    struct test_skew before;
    *w->sum = (struct equations){0};
    for (int i = 0; i < DOFS; i++) w->sum->spring[i] = i < 3 ? tolerance->springs_n_per_m : tolerance->springs_nm_per_rad;
    systematic_priors(w->params, w->data.tests && w->data.test[0].pressures, w->sum->systematic);
    w->sum->skew_test_s = systematic_test_skew(w->params);
    w->square = 0.0, w->count = 0;
    expect_friction(w, number);
    for (int i = 0; i < w->data.tests; i++) {
        const struct residual_test *t = &w->data.test[i];
        bool first = i == 0 || t->of != t[-1].of, last = i + 1 == w->data.tests || t->of != t[1].of;
        if (first) before = skews_now(w->sum);
        suspect_found(w, i);
        if (!fill_columns(w, i)) return error_set(error, STATUS_USAGE, no_pose);
        if (number > 0 && !fill_systematic(w, i)) return error_set(error, STATUS_USAGE, no_such_machine);
        fill_covariance(w, i);
        if (!accumulate(w)) return error_set(error, STATUS_USAGE, "method C: a force that is constant, or no number");
        if (number == 0) continue;
        if (last && w->sum->skew_test_s > 0.0) skews_add(w->sum, &before);
        invert(w);
        add_attenuation(w, t);
        add_repeating(w, t);
    }
    take_attenuation_off(w->sum, w->noise_share);
    bool solved = equations_values(w->sum, w->prior, w->x, w->departure);
    for (int c = 0; c < ENTRIES; c++) {
        int i, j;
        equations_entry(c, &i, &j);
        w->more[i][j] = w->more[j][i] = w->x[c];
    }
    if (solved) find_rest(w), w->noise_share = fmin(square(equations_scatter(w->sum)), 1.0);
    return solved ? STATUS_OK : error_set(error, STATUS_USAGE, "method C: some leg does not move both ways");
}

/* Reduces the weight of rows that scatter by more than their noise. */
static void weigh_scatter(struct equations *e) {
    double weight = 1.0 / square(fmax(equations_scatter(e), 1.0));
    for (int c = 0; c < UNKNOWNS; c++) {
        e->with[c] *= weight;
        for (int d = 0; d <= c; d++) e->product[c][d] *= weight;
        e->attenuation[c] *= weight;
    }
    for (int t = 0; t < e->skews; t++) {
        e->skew[t].with *= weight;
        for (int c = 0; c < UNKNOWNS; c++) e->skew[t].product[c] *= weight;
    }
}

static void find_scales(struct work *w) {
    w->sum->cycles = HUGE_VAL;
    for (int i = 0; i < w->data.tests; i++) {
        const struct residual_test *t = &w->data.test[i];
        double rate[LEGS] = {0}, leg[LEGS][3];
        if (t->spectrum.cycles) w->sum->cycles = fmin(w->sum->cycles, t->spectrum.cycles);
        suspect_found(w, i);
        for (int phase = 0; phase < t->phases; phase++) {
            legs_at(&w->found, t, phase, leg);
            for (int k = 0; k < LEGS; k++) rate[k] += square(leg[k][1]) / t->phases;
        }
        for (int k = 0; k < LEGS; k++) {
            w->sum->rate_mps = fmax(w->sum->rate_mps, sqrt(rate[k]));
            w->sum->force_n = fmax(w->sum->force_n, sqrt(residual_variation(t, CHANNEL_FORCE, k)));
        }
    }
}

int method_c_equations(const struct recording *recording, struct equations *e, struct error *error) {
    struct work *w = calloc(1, sizeof *w);
    struct params *params = malloc(sizeof *params);
    struct kinematics k;
    int status = w && params ? STATUS_OK : error_set(error, STATUS_IO, "out of memory");
    if (!status) {
        *params = *recording->params;
        matrix_bare_machine(params);
        w->params = params, w->sum = e, w->noise_share = 1.0;
        cylinder_model_init(&w->cylinder, params);
        status = kinematics_init(&k, params, error);
    }
    if (!status) {
        if (!payload_prior(params, &k, params->model.tolerance.rigidity, w->prior)) status = error_set(error, STATUS_USAGE, no_inertia);
    }
    if (!status) {
        params_mechanism(params)->leg_mass(params, w->leg_mass);
        status = residual_prepare(&w->data, recording, CYCLES_ALL, error);
        if (!status && (!find_along(w, k.neutral_length_m) || !find_more_mass(w, k.neutral_length_m)))
            status = error_set(error, STATUS_USAGE, no_pose);
        if (!status) status = prepare_tests(w, error);
        for (int i = 0; i < PASSES && !status; i++) status = pass(w, i, error);
        if (!status) find_scales(w), weigh_scatter(e);
        residual_free(&w->data);
    }
    if (w) free(w->staircase), free(w->course), free(w->doubt);
    free(params);
    free(w);
    return status;
}
