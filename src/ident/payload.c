#include "payload.h"

#include <math.h>
#include <string.h>

#include "dense.h"
#include "nominal.h"
#include "numeric.h"
#include "params.h"

const char *const payload_names[PAYLOAD_VALUES] = {"mass_kg",          "center_x_m",       "center_y_m",       "center_z_m",
                                                   "inertia_xx_kg_m2", "inertia_yy_kg_m2", "inertia_zz_kg_m2", "inertia_xy_kg_m2",
                                                   "inertia_xz_kg_m2", "inertia_yz_kg_m2"};

enum { BODY = 4, STEPS_MOST = 200 };
static const double UNDETERMINED_MASS = 0.1; /* nothing is determined if the mass's standard
                                              * deviation reaches this share of the mass: then no
                                              * centre is known */
/* A value is determined if its standard deviation is less than this share of the mean principal
 * inertia (inertias), or of the radius of gyration (centres). */
static const double UNDETERMINED = 0.2;

/* Ten numbers in which the payload's matrix is linear: m, h, Io in the order of payload_names. */
typedef double linear[PAYLOAD_VALUES];

static void matrix_of(const linear x, double m[DOFS][DOFS]) {
    memset(m, 0, DOFS * sizeof m[0]);
    const double *h = x + PAYLOAD_CENTER, *io = x + PAYLOAD_INERTIA;
    for (int i = 0; i < 3; i++) m[i][i] = x[PAYLOAD_MASS], m[3 + i][3 + i] = io[i];
    m[0][4] = h[2], m[0][5] = -h[1], m[1][3] = -h[2], m[1][5] = h[0], m[2][3] = h[1], m[2][4] = -h[0];
    m[3][4] = io[3], m[3][5] = io[4], m[4][5] = io[5];
}

static void entries_of(double m[DOFS][DOFS], double entry[MATRIX_ENTRIES]) {
    int n = 0;
    for (int i = 0; i < DOFS; i++)
        for (int j = i; j < DOFS; j++) entry[n++] = m[i][j];
}

static void legs_matrix(const struct params *params, const struct kinematics *k, const double pose[DOFS], double m[DOFS][DOFS]) {
    struct params bare = *params;
    bare.payload = (struct payload_params){0};
    nominal_matrix(&bare, k, pose, m);
}

static void legs_of(const struct params *params, const struct kinematics *k, double entry[MATRIX_ENTRIES]) {
    static const double neutral[DOFS] = {0};
    double m[DOFS][DOFS];
    legs_matrix(params, k, neutral, m);
    entries_of(m, entry);
}

/* Adds the covariance by errors of the legs' masses, which are uniform within their tolerance: one
 * error common to all rods, one common to all cylinders, and one of each rod and each cylinder. */
static void add_legs(const struct params *params, const struct kinematics *k, double covariance[MATRIX_ENTRIES][MATRIX_ENTRIES]) {
    double legs[MATRIX_ENTRIES], share = params->model.tolerance.mass / sqrt(3.0);
    legs_of(params, k, legs);
    for (int part = 0; part < 2; part++) {
        double all[MATRIX_ENTRIES] = {0};
        for (int leg = 0; leg <= LEGS; leg++) {
            struct params other = *params;
            double change[MATRIX_ENTRIES];
            if (leg < LEGS) (part ? other.actuator.lower_mass_kg : other.actuator.upper_mass_kg)[leg] *= 1.0 + share;
            legs_of(&other, k, change);
            for (int i = 0; i < MATRIX_ENTRIES; i++) change[i] = leg < LEGS ? change[i] - legs[i] : all[i];
            for (int i = 0; i < MATRIX_ENTRIES; i++) all[i] += change[i];
            for (int i = 0; i < MATRIX_ENTRIES; i++)
                for (int j = 0; j < MATRIX_ENTRIES; j++) covariance[i][j] += change[i] * change[j];
        }
    }
}

/* Row and column in the tensor of each of the six inertias. */
static const int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};

/* Parallel axis theorem: inertia i of m (c'c 1 - c c'). */
static double steiner(double mass, const double c[3], int i) {
    double radius = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    return mass * ((row[i] == column[i] ? radius : 0.0) - c[row[i]] * c[column[i]]);
}

/* Converts the ten numbers to the reported values: mass, centre, and inertia about the centre. */
static void for_people(const linear x, double value[PAYLOAD_VALUES]) {
    double m = x[PAYLOAD_MASS], *c = value + PAYLOAD_CENTER;
    value[PAYLOAD_MASS] = m;
    for (int i = 0; i < 3; i++) c[i] = x[PAYLOAD_CENTER + i] / m;
    for (int i = 0; i < 6; i++) value[PAYLOAD_INERTIA + i] = x[PAYLOAD_INERTIA + i] - steiner(m, c, i);
}

static void from_people(const double value[PAYLOAD_VALUES], linear x) {
    double m = value[PAYLOAD_MASS];
    const double *c = value + PAYLOAD_CENTER;
    x[PAYLOAD_MASS] = m;
    for (int i = 0; i < 3; i++) x[PAYLOAD_CENTER + i] = m * c[i];
    for (int i = 0; i < 6; i++) x[PAYLOAD_INERTIA + i] = value[PAYLOAD_INERTIA + i] + steiner(m, c, i);
}

/* Pseudo-inertia: integrals over the body of x_i x_j, of x_i and of 1. */
static void pseudo_inertia(const linear x, double j[BODY * BODY]) {
    const double *io = x + PAYLOAD_INERTIA, half = 0.5 * (io[0] + io[1] + io[2]);
    const double s[BODY][BODY] = {{half - io[0], -io[3], -io[4], x[1]},
                                  {-io[3], half - io[1], -io[5], x[2]},
                                  {-io[4], -io[5], half - io[2], x[3]},
                                  {x[1], x[2], x[3], x[0]}};
    memcpy(j, s, sizeof s);
}

/* Computes the ten numbers of the pseudo-inertia L L'; l is the lower triangle of L, row by row. */
static void from_factor(const double l[PAYLOAD_VALUES], linear x) {
    double s[BODY][BODY] = {{0}}, f[BODY][BODY] = {{0}};
    int n = 0;
    for (int i = 0; i < BODY; i++)
        for (int j = 0; j <= i; j++) f[i][j] = l[n++];
    for (int i = 0; i < BODY; i++)
        for (int j = 0; j < BODY; j++)
            for (int k = 0; k < BODY; k++) s[i][j] += f[i][k] * f[j][k];
    const double of[PAYLOAD_VALUES] = {s[3][3],           s[0][3],           s[1][3],  s[2][3],  s[1][1] + s[2][2],
                                       s[0][0] + s[2][2], s[0][0] + s[1][1], -s[0][1], -s[0][2], -s[1][2]};
    memcpy(x, of, sizeof of);
}

/* Squared distance (x - best)' weight (x - best). */
static double distance(const linear x, const linear best, double weight[PAYLOAD_VALUES][PAYLOAD_VALUES]) {
    double sum = 0.0;
    for (int i = 0; i < PAYLOAD_VALUES; i++)
        for (int j = 0; j < PAYLOAD_VALUES; j++) sum += (x[i] - best[i]) * weight[i][j] * (x[j] - best[j]);
    return sum;
}

/* Tries one Levenberg-Marquardt step on the Cholesky factor l. Returns false if no damping brings
 * the ten numbers nearer to `best`. */
static bool step_nearer(double l[PAYLOAD_VALUES], const linear best, double weight[PAYLOAD_VALUES][PAYLOAD_VALUES], double *damping) {
    linear x, moved;
    double jacobian[PAYLOAD_VALUES][PAYLOAD_VALUES], product[PAYLOAD_VALUES * PAYLOAD_VALUES], step[PAYLOAD_VALUES], next[PAYLOAD_VALUES];
    from_factor(l, x);
    for (int c = 0; c < PAYLOAD_VALUES; c++) {
        double d = 1e-6 * (fabs(l[c]) + 1e-3);
        memcpy(next, l, sizeof next);
        next[c] += d;
        from_factor(next, moved);
        for (int i = 0; i < PAYLOAD_VALUES; i++) jacobian[i][c] = (moved[i] - x[i]) / d;
    }
    for (; *damping < 1e12; *damping *= 10.0) {
        memset(product, 0, sizeof product), memset(step, 0, sizeof step);
        for (int a = 0; a < PAYLOAD_VALUES; a++)
            for (int i = 0; i < PAYLOAD_VALUES; i++)
                for (int k = 0; k < PAYLOAD_VALUES; k++) {
                    step[a] -= jacobian[i][a] * weight[i][k] * (x[k] - best[k]);
                    for (int b = 0; b <= a; b++) product[a * PAYLOAD_VALUES + b] += jacobian[i][a] * weight[i][k] * jacobian[k][b];
                }
        for (int a = 0; a < PAYLOAD_VALUES; a++)
            product[a * (PAYLOAD_VALUES + 1)] *= 1.0 + *damping, product[a * (PAYLOAD_VALUES + 1)] += 1e-12;
        if (!dense_factor(PAYLOAD_VALUES, PAYLOAD_VALUES, product)) continue;
        dense_solve(PAYLOAD_VALUES, PAYLOAD_VALUES, product, step);
        for (int c = 0; c < PAYLOAD_VALUES; c++) next[c] = l[c] + step[c];
        from_factor(next, moved);
        if (distance(moved, best, weight) >= distance(x, best, weight)) continue;
        memcpy(l, next, sizeof next);
        *damping *= 0.1;
        return true;
    }
    return false;
}

/* Finds the body of positive density that is nearest to the ten numbers `best`. The search starts
 * from a body of the same mass with three equal principal inertias. */
static void find_nearest(const linear best, double weight[PAYLOAD_VALUES][PAYLOAD_VALUES], linear nearest) {
    double size = sqrt(fmax(fabs(best[4]) + fabs(best[5]) + fabs(best[6]), 1e-6) / 6.0), mass = sqrt(fmax(best[PAYLOAD_MASS], 1e-6));
    double l[PAYLOAD_VALUES] = {size, 0.0, size, 0.0, 0.0, size, 0.0, 0.0, 0.0, mass}, damping = 1e-3;
    for (int i = 0; i < STEPS_MOST && step_nearer(l, best, weight, &damping); i++) {
    }
    from_factor(l, nearest);
}

/* Computes the matrix entries for one unit of each of the ten numbers. */
static void bases(double base[PAYLOAD_VALUES][MATRIX_ENTRIES]) {
    for (int i = 0; i < PAYLOAD_VALUES; i++) {
        linear unit = {0};
        double m[DOFS][DOFS];
        unit[i] = 1.0;
        matrix_of(unit, m);
        entries_of(m, base[i]);
    }
}

bool payload_prior(const struct params *params, const struct kinematics *k, double rigidity,
                   double inverse[MATRIX_ENTRIES][MATRIX_ENTRIES]) {
    static const double neutral[DOFS] = {0};
    double nominal[DOFS][DOFS], base[PAYLOAD_VALUES][MATRIX_ENTRIES], size[MATRIX_ENTRIES];
    double covariance[MATRIX_ENTRIES][MATRIX_ENTRIES] = {{0}}, solved[MATRIX_ENTRIES];
    nominal_matrix(params, k, neutral, nominal);
    bases(base);
    add_legs(params, k, covariance);
    for (int i = 0, n = 0; i < DOFS; i++)
        for (int j = i; j < DOFS; j++, n++) size[n] = sqrt(nominal[i][i] * nominal[j][j]);
    for (int v = 0; v < PAYLOAD_VALUES; v++) {
        double widest = 0.0;
        for (int i = 0; i < MATRIX_ENTRIES; i++) widest = base[v][i] != 0.0 ? fmax(widest, size[i]) : widest;
        for (int i = 0; i < MATRIX_ENTRIES; i++)
            for (int j = 0; j < MATRIX_ENTRIES; j++) covariance[i][j] += square(widest) * base[v][i] * base[v][j];
    }
    for (int i = 0; i < MATRIX_ENTRIES; i++) covariance[i][i] += square(rigidity * size[i]);
    if (!dense_factor(MATRIX_ENTRIES, MATRIX_ENTRIES, covariance[0])) return false;
    for (int i = 0; i < MATRIX_ENTRIES; i++) {
        memset(solved, 0, sizeof solved);
        solved[i] = 1.0;
        dense_solve(MATRIX_ENTRIES, MATRIX_ENTRIES, covariance[0], solved);
        memcpy(inverse[i], solved, sizeof solved);
    }
    return true;
}

/* Weighted least squares fit of the ten numbers to the payload's part of the matrix. */
struct least_squares {
    double base[PAYLOAD_VALUES][MATRIX_ENTRIES];
    double weight[PAYLOAD_VALUES][PAYLOAD_VALUES], factor[PAYLOAD_VALUES * PAYLOAD_VALUES];
    linear x;
    double misfit;
};

/* Solves the least squares. covariance: its Cholesky factor. Returns false if the ten numbers are
 * not determined. */
static bool solve(struct least_squares *s, const double part[MATRIX_ENTRIES], double covariance[MATRIX_ENTRIES][MATRIX_ENTRIES]) {
    double solved[MATRIX_ENTRIES], rest[MATRIX_ENTRIES], sum = 0.0;
    memset(s, 0, sizeof *s);
    bases(s->base);
    for (int i = 0; i < PAYLOAD_VALUES; i++) {
        memcpy(solved, s->base[i], sizeof solved);
        dense_solve(MATRIX_ENTRIES, MATRIX_ENTRIES, covariance[0], solved);
        for (int e = 0; e < MATRIX_ENTRIES; e++) {
            s->x[i] += solved[e] * part[e];
            for (int j = 0; j < PAYLOAD_VALUES; j++) s->weight[i][j] += solved[e] * s->base[j][e];
        }
    }
    memcpy(s->factor, s->weight, sizeof s->factor);
    if (!dense_factor(PAYLOAD_VALUES, PAYLOAD_VALUES, s->factor)) return false;
    dense_solve(PAYLOAD_VALUES, PAYLOAD_VALUES, s->factor, s->x);
    for (int e = 0; e < MATRIX_ENTRIES; e++) {
        rest[e] = part[e];
        for (int i = 0; i < PAYLOAD_VALUES; i++) rest[e] -= s->x[i] * s->base[i][e];
    }
    memcpy(solved, rest, sizeof solved);
    dense_solve(MATRIX_ENTRIES, MATRIX_ENTRIES, covariance[0], solved);
    for (int e = 0; e < MATRIX_ENTRIES; e++) sum += solved[e] * rest[e];
    s->misfit = sqrt(fmax(sum, 0.0) / (MATRIX_ENTRIES - PAYLOAD_VALUES));
    return true;
}

/* Finds standard deviations to first order, along ten directions in which the ten numbers scatter
 * independently: the columns of the inverse of the transposed factor. */
static void find_std(const struct least_squares *s, const double value[PAYLOAD_VALUES], double std[PAYLOAD_VALUES]) {
    static const double part = 1e-3;
    for (int i = 0; i < PAYLOAD_VALUES; i++) {
        double direction[PAYLOAD_VALUES] = {0}, there[PAYLOAD_VALUES];
        linear moved;
        for (int r = PAYLOAD_VALUES - 1; r >= 0; r--) {
            double sum = r == i;
            for (int j = r + 1; j < PAYLOAD_VALUES; j++) sum -= s->factor[j * PAYLOAD_VALUES + r] * direction[j];
            direction[r] = sum / s->factor[r * (PAYLOAD_VALUES + 1)];
        }
        for (int j = 0; j < PAYLOAD_VALUES; j++) moved[j] = s->x[j] + part * direction[j];
        for_people(moved, there);
        for (int j = 0; j < PAYLOAD_VALUES; j++) std[j] = hypot(std[j], (there[j] - value[j]) / part);
    }
}

/* Sets values that the data do not determine to NaN. */
static void leave_out(struct payload *p, const struct payload_params *configured) {
    double inertia = (configured->inertia_xx_kg_m2 + configured->inertia_yy_kg_m2 + configured->inertia_zz_kg_m2) / 3.0;
    double radius_m = sqrt(inertia / configured->mass_kg);
    p->whole = p->evaluated;
    for (int i = PAYLOAD_CENTER; i < PAYLOAD_VALUES; i++) {
        if (p->std[i] < UNDETERMINED * (i < PAYLOAD_INERTIA ? radius_m : inertia)) continue;
        p->value[i] = p->std[i] = NAN;
        p->whole = false;
    }
    for (int i = 0; i < PAYLOAD_VALUES && !p->whole; i++) p->nearest[i] = NAN;
    p->possible = p->possible && p->whole;
}

bool payload_possible(const double value[PAYLOAD_VALUES]) {
    double body[BODY * BODY];
    linear x;
    from_people(value, x);
    pseudo_inertia(x, body);
    return x[PAYLOAD_MASS] > 0.0 && dense_factor(BODY, BODY, body);
}

struct payload payload_find(const struct params *params, const struct kinematics *k, const double entry[MATRIX_ENTRIES],
                            double covariance[MATRIX_ENTRIES][MATRIX_ENTRIES]) {
    struct payload p = {0};
    struct least_squares s;
    double part[MATRIX_ENTRIES], factor[MATRIX_ENTRIES][MATRIX_ENTRIES];
    memcpy(factor, covariance, sizeof factor);
    add_legs(params, k, factor);
    legs_of(params, k, part);
    for (int i = 0; i < MATRIX_ENTRIES; i++) part[i] = entry[i] - part[i];
    if (!dense_factor(MATRIX_ENTRIES, MATRIX_ENTRIES, factor[0]) || !solve(&s, part, factor)) return p;
    linear nearest;
    memcpy(nearest, s.x, sizeof nearest);
    for_people(s.x, p.value);
    p.possible = payload_possible(p.value);
    if (!p.possible) find_nearest(s.x, s.weight, nearest);
    p.impossible = distance(nearest, s.x, s.weight);
    for_people(nearest, p.nearest);
    find_std(&s, p.value, p.std);
    p.misfit = s.misfit;
    p.evaluated = isfinite(p.misfit) && p.std[PAYLOAD_MASS] < UNDETERMINED_MASS * fabs(p.value[PAYLOAD_MASS]);
    leave_out(&p, &params->payload);
    return p;
}

void payload_configure(const double value[PAYLOAD_VALUES], struct payload_params *to) {
    const double *center = value + PAYLOAD_CENTER, *inertia = value + PAYLOAD_INERTIA;
    to->mass_kg = value[PAYLOAD_MASS];
    /* z of {M} points down, center_height_m up */
    to->center_x_m += center[0], to->center_y_m += center[1], to->center_height_m -= center[2];
    to->inertia_xx_kg_m2 = inertia[0], to->inertia_yy_kg_m2 = inertia[1], to->inertia_zz_kg_m2 = inertia[2];
    to->inertia_xy_kg_m2 = inertia[3], to->inertia_xz_kg_m2 = inertia[4], to->inertia_yz_kg_m2 = inertia[5];
}

/* Adds the payload's matrix at neutral, rotated into the pose, to the matrix of the legs: each 3x3
 * block B becomes T B T'. */
void payload_matrix(const struct payload *p, const struct params *params, const struct kinematics *k, const double pose[DOFS],
                    double mt[DOFS][DOFS]) {
    double t[3][3], body[DOFS][DOFS];
    linear x;
    from_people(p->value, x);
    matrix_of(x, body);
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < i; j++) body[i][j] = body[j][i];
    rotation_from_angles(pose[DOF_PHI], pose[DOF_THETA], pose[DOF_PSI], t);
    legs_matrix(params, k, pose, mt);
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < DOFS; j++)
            for (int a = 0; a < 3; a++)
                for (int b = 0; b < 3; b++) mt[i][j] += t[i % 3][a] * body[i / 3 * 3 + a][j / 3 * 3 + b] * t[j % 3][b];
}
