#include "workspace.h"

#include <math.h>
#include <string.h>

#include "lin.h"
#include "params.h"

enum { PLACES = 3, CORNERS = 729, SMOOTH = 3 };

static const double LONGEST = 1.0 / 8.0, SHORTEST = 1.0 / 1024.0; /* longest and shortest step along
                                                                   * a path, as a share of the whole
                                                                   * path */
static const double ROUNDING = 1.0 + 1e-6; /* factor that keeps condition_bound() an upper bound in
                                            * spite of its rounding errors, even near a singular
                                            * pose */

/* Jacobian with its angles in units of 1/arm_m. */
static void scaled_jacobian(const struct kinematics *k, const double pose[DOFS], double j[LEGS][DOFS]) {
    ik_jacobian(k, pose, j);
    for (int i = 0; i < LEGS; i++)
        for (int r = 3; r < DOFS; r++) j[i][r] /= k->arm_m;
}

static double determinant(double m[DOFS][DOFS]) {
    double product = 1.0;
    for (int c = 0; c < DOFS; c++) {
        int pivot = c;
        for (int r = c + 1; r < DOFS; r++)
            if (fabs(m[r][c]) > fabs(m[pivot][c])) pivot = r;
        product *= m[pivot][c];
        for (int r = c; r < DOFS; r++) {
            double factor = m[r][c] / m[pivot][c];
            for (int j = c + 1; j < DOFS && r != pivot; j++) m[r][j] -= factor * m[pivot][j];
        }
        if (pivot != c) memcpy(m[pivot], m[c], sizeof m[c]), product = -product;
    }
    return product;
}

/* Returns an upper bound of a matrix's condition number, 2 (|M|F / sqrt(n))^n / |det M|
 * (Guggenheimer, Edelman and Johnson 1995), in a tenth of the time that singular values take. The
 * bound of a singular matrix is infinite or NaN. */
static double condition_bound(double j[LEGS][DOFS]) {
    double m[DOFS][DOFS], squares = 0.0;
    memcpy(m, j, sizeof m);
    for (int i = 0; i < LEGS; i++)
        for (int r = 0; r < DOFS; r++) squares += j[i][r] * j[i][r];
    return 2.0 * pow(squares / DOFS, 0.5 * DOFS) / fabs(determinant(m));
}

static double condition(double j[LEGS][DOFS]) {
    double value[DOFS];
    if (lin_singular_values(LEGS, DOFS, j[0], value) || !(value[DOFS - 1] > 0.0)) return (double)INFINITY;
    return value[0] / value[DOFS - 1];
}

/* Finds each leg's shortest, neutral and longest length within both stroke and limits. */
static void places(const struct kinematics *k, const struct params *p, double length_m[LEGS][PLACES]) {
    for (int i = 0; i < LEGS; i++) {
        struct stroke stroke = kinematics_stroke(k, &p->actuator, i);
        length_m[i][0] = fmax(stroke.least_m, p->limits.length_min_m[i]);
        length_m[i][1] = k->neutral_length_m[i];
        length_m[i][2] = fmin(stroke.most_m, p->limits.length_max_m[i]);
    }
}

/* A path from neutral. gone: share of the path that was followed. condition, worst_pose: largest
 * condition number on this path and on all earlier paths that reached their end, and its pose if it
 * is on this path. */
struct way {
    double gone, condition;
    double pose[DOFS], worst_pose[DOFS]; /* end of the path, and its worst pose */
};

static void look(const struct kinematics *k, struct way *w) {
    double j[LEGS][DOFS], here;
    scaled_jacobian(k, w->pose, j);
    if (ROUNDING * condition_bound(j) <= w->condition) return;
    here = condition(j);
    if (here <= w->condition) return;
    w->condition = here;
    memcpy(w->worst_pose, w->pose, sizeof w->worst_pose);
}

/* Follows a path on which all legs move in proportion. If a step takes more than SMOOTH Newton
 * iterations, it may have jumped to another assembly mode of the machine, so it is shortened. */
static struct way go(const struct kinematics *k, const double to_m[LEGS], double worst) {
    struct way w = {.condition = worst};
    double length_m[LEGS], step = LONGEST;
    while (w.gone < 1.0 && step >= SHORTEST) {
        double next = fmin(w.gone + step, 1.0), there[DOFS];
        for (int i = 0; i < LEGS; i++) length_m[i] = k->neutral_length_m[i] + next * (to_m[i] - k->neutral_length_m[i]);
        memcpy(there, w.pose, sizeof there);
        struct fk_result fk = fk_solve(k, length_m, there);
        if (!fk.converged || fk.iterations > SMOOTH) {
            step *= 0.5;
            continue;
        }
        memcpy(w.pose, there, sizeof w.pose);
        w.gone = next;
        look(k, &w);
    }
    return w;
}

static void add(struct workspace *all, const struct way *w) {
    if (w->gone < all->nearest) {
        all->nearest = w->gone;
        memcpy(all->nearest_pose, w->pose, sizeof all->nearest_pose);
    }
    if (w->gone < 1.0) return;
    all->reached++;
    if (w->condition <= all->worst_condition) return;
    all->worst_condition = w->condition;
    memcpy(all->worst_pose, w->worst_pose, sizeof all->worst_pose);
}

struct workspace workspace_find(const struct kinematics *k, const struct params *params) {
    static const double neutral[DOFS] = {0};
    struct workspace all = {.corners = CORNERS, .nearest = 1.0};
    double place[LEGS][PLACES], to_m[LEGS], j[LEGS][DOFS];
    scaled_jacobian(k, neutral, j);
    all.neutral_condition = condition(j);
    places(k, params, place);
    for (int corner = 0; corner < CORNERS; corner++) {
        for (int i = 0, rest = corner; i < LEGS; i++, rest /= PLACES) to_m[i] = place[i][rest % PLACES];
        struct way way = go(k, to_m, all.worst_condition);
        add(&all, &way);
    }
    return all;
}
