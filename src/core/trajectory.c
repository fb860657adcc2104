#include "trajectory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double step_s(const struct trajectory *t, int i) { return t->knot[i + 1].time_s - t->knot[i].time_s; }

static double slope(const struct trajectory *t, int i, int axis) {
    return (t->knot[i + 1].pose[axis] - t->knot[i].pose[axis]) / step_s(t, i);
}

/* Equations for the unknown second derivatives b[i] at the knots; h[i] is the time from knot i to
 * the next:
 *
 *   h[i-1] b[i-1] + 2 (h[i-1] + h[i]) b[i] + h[i] b[i+1] = 6 (slope[i] - slope[i-1])
 *
 * A natural spline has an unknown at each inner knot. A periodic spline has one more, at the first
 * knot. Its neighbours are the second knot and the last inner one, so that the tridiagonal matrix
 * gets two corner entries; they are split off as a rank-one term (Sherman-Morrison formula), which
 * is 0 for a natural spline. The matrix is diagonally dominant. */
struct system {
    int size, first;      /* number of unknowns, and index of the first unknown's knot */
    double corner, gamma;
    double *above;        /* the matrix's superdiagonal after elimination */
    double *rank_one;     /* solution for the rank-one term */
};

static int before(const struct trajectory *t, int i) { return i ? i - 1 : t->knots - 2; }

static void eliminate(const struct trajectory *t, const struct system *s, struct trajectory_knot *k) {
    double pivot = 0.0;
    for (int row = 0; row < s->size; row++) {
        int i = s->first + row;
        double below = row ? step_s(t, i - 1) : 0.0, diagonal = 2.0 * (step_s(t, before(t, i)) + step_s(t, i));
        bool last = row == s->size - 1;
        if (row == 0) diagonal -= s->gamma;
        if (last) diagonal -= s->corner * s->corner / s->gamma;
        pivot = diagonal - (row ? below * s->above[row - 1] : 0.0);
        s->above[row] = last ? 0.0 : step_s(t, i) / pivot;
        s->rank_one[row] = ((row == 0 ? s->gamma : 0.0) + (last ? s->corner : 0.0) - (row ? below * s->rank_one[row - 1] : 0.0)) / pivot;
        for (int axis = 0; axis < DOFS; axis++) {
            double right = 6.0 * (slope(t, i, axis) - slope(t, before(t, i), axis));
            k[i].bend[axis] = (right - (row ? below * k[i - 1].bend[axis] : 0.0)) / pivot;
        }
    }
}

static void substitute(const struct system *s, struct trajectory_knot *k) {
    for (int row = s->size - 2; row >= 0; row--) {
        int i = s->first + row;
        s->rank_one[row] -= s->above[row] * s->rank_one[row + 1];
        for (int axis = 0; axis < DOFS; axis++) k[i].bend[axis] -= s->above[row] * k[i + 1].bend[axis];
    }
    int end = s->first + s->size - 1;
    double ratio = s->corner / s->gamma, whole = 1.0 + s->rank_one[0] + ratio * s->rank_one[s->size - 1];
    for (int axis = 0; axis < DOFS; axis++) {
        double share = (k[s->first].bend[axis] + ratio * k[end].bend[axis]) / whole;
        for (int row = 0; row < s->size; row++) k[s->first + row].bend[axis] -= share * s->rank_one[row];
    }
}

bool trajectory_bend(struct trajectory *t) {
    bool closed = t->passes > 1;
    int last = t->knots - 1, first = closed ? 0 : 1;
    struct system s = {.size = last - first, .first = first, .corner = closed ? step_s(t, last - 1) : 0.0};
    s.gamma = -2.0 * (step_s(t, before(t, first)) + step_s(t, first));
    s.above = malloc((size_t)s.size * sizeof(double)), s.rank_one = malloc((size_t)s.size * sizeof(double));
    bool fits = s.above && s.rank_one;
    if (fits) {
        eliminate(t, &s, t->knot);
        substitute(&s, t->knot);
    }
    for (int axis = 0; axis < DOFS; axis++) {
        if (!closed) t->knot[0].bend[axis] = 0.0;
        t->knot[last].bend[axis] = t->knot[0].bend[axis];
    }
    free(s.above);
    free(s.rank_one);
    return fits;
}

static double pass_s(const struct trajectory *t) { return t->knot[t->knots - 1].time_s; }

double trajectory_s(const struct trajectory *t) { return t->passes * pass_s(t); }

/* Returns the index of the last knot at or before the time; never that of the very last knot. */
static int find(const struct trajectory *t, double time_s) {
    int low = 0, high = t->knots - 1;
    while (high - low > 1) {
        int middle = low + (high - low) / 2;
        if (t->knot[middle].time_s <= time_s) low = middle;
        else high = middle;
    }
    return low;
}

void trajectory_motion(const struct trajectory *t, double time_s, double motion[MOTION_ORDERS][DOFS]) {
    double inside_s = fmin(fmax(time_s, 0.0), trajectory_s(t)), beyond_s = time_s - inside_s;
    double pass = fmin(floor(inside_s / pass_s(t)), t->passes - 1), local_s = inside_s - pass * pass_s(t);
    int i = find(t, local_s);
    const struct trajectory_knot *a = &t->knot[i], *b = a + 1;
    double h = step_s(t, i), q = (local_s - a->time_s) / h, p = 1.0 - q;
    bool straight = beyond_s != 0.0;
    for (int axis = 0; axis < DOFS; axis++) {
        double rate = slope(t, i, axis) + h / 6.0 * ((1.0 - 3.0 * p * p) * a->bend[axis] + (3.0 * q * q - 1.0) * b->bend[axis]);
        motion[MOTION_POSE][axis] = p * a->pose[axis] + q * b->pose[axis] +
                                    h * h / 6.0 * ((p * p * p - p) * a->bend[axis] + (q * q * q - q) * b->bend[axis]) + beyond_s * rate;
        motion[MOTION_RATE][axis] = rate;
        motion[MOTION_ACCEL][axis] = straight ? 0.0 : p * a->bend[axis] + q * b->bend[axis];
        motion[MOTION_JERK][axis] = straight ? 0.0 : (b->bend[axis] - a->bend[axis]) / h;
    }
}

void trajectory_at(const struct trajectory *t, double time_s, double pose[DOFS]) {
    double motion[MOTION_ORDERS][DOFS];
    trajectory_motion(t, time_s, motion);
    memcpy(pose, motion[MOTION_POSE], sizeof motion[MOTION_POSE]);
}
