#include "stick.h"

#include <string.h>

#include "vec.h"

static const double DEPENDENT = 1e-12;  /* a row counts as linearly dependent if at most this share
                                         * of its square lies outside the basis */
static const double GIVES_WAY = 1e-6;  /* acceleration above which friction gives way, m/s^2 or
                                        * rad/s^2: far above the solver's error, far below any real
                                        * motion (0.5 um in 1 s) */
static const double CONVERGED = 1e-12; /* the solver ends once complementarity(), divided by the sum
                                        * over all forces of the distance between the two limits, is
                                        * at most this, m/s^2 or rad/s^2 */
static const double LEAST_LIMIT = 1e-9; /* smallest limit, N or N m; a smaller one is raised to
                                         * this, because the solver needs a distance between the two
                                         * limits of a force */

enum { ITERATIONS = 60 };

void stick_basis_add(struct stick_basis *basis, const double row[DOFS], double bias) {
    double rest[DOFS], square = dot6(row, row);
    if (basis->rank == DOFS) return;
    for (int i = 0; i < DOFS; i++) rest[i] = row[i];
    for (int pass = 0; pass < 2; pass++) /* two passes are enough (Kahan) */
        for (int k = 0; k < basis->rank; k++) {
            double share = dot6(basis->row[k], rest);
            add6(-share, basis->row[k], rest);
            bias -= share * basis->bias[k];
        }
    double left = dot6(rest, rest);
    if (!(left > DEPENDENT * square)) return;
    double scale = 1.0 / sqrt(left);
    for (int i = 0; i < DOFS; i++) basis->row[basis->rank][i] = scale * rest[i];
    basis->bias[basis->rank++] = scale * bias;
}

void stick_hold(const struct stick_basis *basis, double bias_scale, double x[DOFS]) {
    for (int k = 0; k < basis->rank; k++) add6(-dot6(basis->row[k], x) - bias_scale * basis->bias[k], basis->row[k], x);
}

/* Interior point method: minimise |x + sum force_k row_k|^2 / 2 + sum bias_k force_k, with each
 * force between its limits. The gradient by a force is the acceleration of its coordinate, and
 * equals extend - retract, the multipliers of the lower and of the upper limit: a coordinate
 * that extends has its force at the lower limit. down, up: distances of the force from these two
 * limits. */
struct point {
    double force, down, up, extend, retract;
};

static void point_start(const struct stick_coordinate *c, struct point *p, double x[DOFS]) {
    double down = c->extend_limit > LEAST_LIMIT ? c->extend_limit : LEAST_LIMIT;
    double up = c->retract_limit > LEAST_LIMIT ? c->retract_limit : LEAST_LIMIT;
    p->force = 0.5 * (up - down);
    p->down = p->up = 0.5 * (up + down);
    add6(p->force, c->row, x);
}

/* Returns the sum of distance times multiplier over all limits; 0 at the solution. */
static double complementarity(const struct point *p, int count) {
    double sum = 0.0;
    for (int k = 0; k < count; k++) sum += p[k].down * p[k].extend + p[k].up * p[k].retract;
    return sum;
}

/* Computes a Newton step towards complementarity `target` at every limit. With y a coordinate's
 * row, d its stiffness[] and rho its residual[]: (I + sum y y'/d) dx = -sum y rho/d, change = -(rho
 * + y.dx)/d. */
static void newton(const struct stick_coordinate *c, const struct point *p, int count, double target, double *change) {
    struct factor6 metric = {0};
    double step[DOFS] = {0}, stiffness[STICK_MAX], residual[STICK_MAX];
    for (int i = 0; i < DOFS; i++) metric.c[i][i] = 1.0;
    for (int k = 0; k < count; k++) {
        stiffness[k] = p[k].extend / p[k].down + p[k].retract / p[k].up;
        residual[k] = p[k].extend - p[k].retract - target / p[k].down + target / p[k].up;
        for (int i = 0; i < DOFS; i++) add6(c[k].row[i] / stiffness[k], c[k].row, metric.c[i]);
        add6(-residual[k] / stiffness[k], c[k].row, step);
    }
    factor6(&metric);
    whiten6(&metric, step);
    unwhiten6(&metric, step);
    for (int k = 0; k < count; k++) change[k] = -(residual[k] + dot6(c[k].row, step)) / stiffness[k];
}

static void shorten(double value, double change, double *length) {
    if (value + *length * change < 0.0) *length = -value / change;
}

/* Adds the changes to forces and multipliers. The step is shortened so that forces stay within
 * their limits and multipliers positive. */
static void advance(struct point *p, int count, double target, const double *change) {
    double extend[STICK_MAX], retract[STICK_MAX], length = 1.0 / 0.99;
    for (int k = 0; k < count; k++) {
        extend[k] = (target - p[k].extend * change[k]) / p[k].down - p[k].extend;
        retract[k] = (target + p[k].retract * change[k]) / p[k].up - p[k].retract;
        shorten(p[k].down, change[k], &length);
        shorten(p[k].up, -change[k], &length);
        shorten(p[k].extend, extend[k], &length);
        shorten(p[k].retract, retract[k], &length);
    }
    length *= 0.99;
    for (int k = 0; k < count; k++) {
        p[k].force += length * change[k];
        p[k].down += length * change[k];
        p[k].up -= length * change[k];
        p[k].extend += length * extend[k];
        p[k].retract += length * retract[k];
    }
}

void stick_resolve(struct stick_coordinate *c, int count, const double x[DOFS]) {
    struct point p[STICK_MAX];
    double start[DOFS], change[STICK_MAX], room = 0.0;
    memcpy(start, x, sizeof start);
    for (int k = 0; k < count; k++) {
        point_start(&c[k], &p[k], start);
        room += 2.0 * p[k].down;
    }
    for (int k = 0; k < count; k++) {
        double acceleration = dot6(c[k].row, start) + c[k].bias;
        p[k].extend = 1.0 + (acceleration > 0.0 ? acceleration : 0.0);
        p[k].retract = 1.0 + (acceleration < 0.0 ? -acceleration : 0.0);
    }
    for (int i = 0; i < ITERATIONS; i++) {
        double sum = complementarity(p, count), target = 0.1 * sum / (2 * count);
        if (!(sum > CONVERGED * room)) break;
        newton(c, p, count, target, change);
        advance(p, count, target, change);
    }
    for (int k = 0; k < count; k++) {
        double acceleration = p[k].extend - p[k].retract;
        c[k].force = p[k].force;
        c[k].slip = acceleration > GIVES_WAY ? 1 : acceleration < -GIVES_WAY ? -1 : 0;
    }
}
