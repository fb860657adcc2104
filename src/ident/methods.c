#include "methods.h"

#include <math.h>
#include <string.h>

#include "lin.h"
#include "numeric.h"
#include "units.h"

enum { N_MAX = 2 * DOFS };

/* Equations X U = H with n unknowns in each row of X; columns belong to tests. Rows of U are
 * divided by `unit`, their ideal size, so that the condition number has no unit; x is in SI units
 * again. */
struct equations {
    int n;
    double u[N_MAX * N_MAX], inverse[N_MAX * N_MAX];
    double h[DOFS][N_MAX];
    double unit[N_MAX];
    double x[DOFS][N_MAX]; /* solution, SI units; NaN if U is singular */
};

static double omega(const struct test_result *t) { return 2.0 * PI * t->frequency_hz; }

static struct lin_report equations_solve(struct equations *e) {
    struct lin_report report = lin_inverse(e->n, e->u, e->inverse);
    for (int i = 0; i < DOFS; i++)
        for (int k = 0; k < e->n; k++) {
            double sum = 0.0;
            for (int c = 0; c < e->n; c++) sum += e->h[i][c] * e->inverse[c * e->n + k];
            e->x[i][k] = report.rank == e->n ? sum / e->unit[k] : (double)NAN;
        }
    return report;
}

/* Standard deviation of an entry x[.][k], from the variances of dH - X dU in its row, since dX =
 * (dH - X dU) U^-1. */
static double entry_std(const struct equations *e, int k, const double variance[N_MAX]) {
    double sum = 0.0;
    for (int c = 0; c < e->n; c++) sum += variance[c] * square(e->inverse[c * e->n + k]);
    return sqrt(sum) / e->unit[k];
}

/* Variance of either coefficient of wrench - Mt acceleration - Bt velocity, in one row of the
 * matrices. */
static double row_variance(const struct test_result *t, int row, const double m[DOFS], const double b[DOFS]) {
    double w = omega(t), sum = square(t->wrench_std[row]);
    for (int j = 0; j < DOFS; j++) sum += (square(w * w * m[j]) + square(w * b[j])) * square(t->pose_std[j]);
    return sum;
}

static void fill_a(struct equations *e, const struct test_result *const test[DOFS]) {
    e->n = 2 * DOFS;
    for (int i = 0; i < DOFS; i++) {
        double w_own = omega(test[i]);
        double *acceleration = e->u + i * e->n, *velocity = e->u + (DOFS + i) * e->n;
        e->unit[i] = w_own * w_own * test[i]->amplitude;
        e->unit[DOFS + i] = w_own * test[i]->amplitude;
        for (int d = 0; d < DOFS; d++) {
            double w = omega(test[d]);
            const double *pose = test[d]->pose[i];
            acceleration[2 * d] = -w * w * pose[0] / e->unit[i];
            acceleration[2 * d + 1] = -w * w * pose[1] / e->unit[i];
            velocity[2 * d] = -w * pose[1] / e->unit[DOFS + i];
            velocity[2 * d + 1] = w * pose[0] / e->unit[DOFS + i];
            memcpy(&e->h[i][2 * d], test[d]->wrench[i], sizeof test[d]->wrench[i]);
        }
    }
}

struct method_result method_a(const struct test_result *const test[DOFS]) {
    struct method_result r = {0};
    struct equations e;
    fill_a(&e, test);
    struct lin_report report = equations_solve(&e);
    r.evaluated = report.rank == e.n;
    r.condition_number = report.condition;
    for (int i = 0; i < DOFS; i++) {
        const double *m = e.x[i], *b = e.x[i] + DOFS;
        double variance[N_MAX];
        for (int d = 0; d < DOFS; d++) variance[2 * d] = variance[2 * d + 1] = row_variance(test[d], i, m, b);
        for (int k = 0; k < DOFS; k++) {
            r.mt[i][k] = m[k];
            r.bt[i][k] = b[k];
            r.mt_std[i][k] = entry_std(&e, k, variance);
            r.bt_std[i][k] = entry_std(&e, DOFS + k, variance);
        }
    }
    return r;
}

struct method_result method_modified_a(const struct method_result *a, double nominal_mt[DOFS][DOFS]) {
    static const int coupling[4][2] = {{DOF_X, DOF_THETA}, {DOF_THETA, DOF_X}, {DOF_Y, DOF_PHI}, {DOF_PHI, DOF_Y}};
    struct method_result r = {.evaluated = a->evaluated, .condition_number = a->condition_number};
    memcpy(r.mt, a->mt, sizeof r.mt);
    memcpy(r.mt_std, a->mt_std, sizeof r.mt_std);
    double m_qz = (fabs(a->mt[DOF_X][DOF_THETA]) + fabs(a->mt[DOF_PHI][DOF_Y])) / 2;
    double m_qz_std = hypot(a->mt_std[DOF_X][DOF_THETA], a->mt_std[DOF_PHI][DOF_Y]) / 2;
    for (int i = 0; i < 4; i++) {
        int row = coupling[i][0], column = coupling[i][1];
        r.mt[row][column] = copysign(m_qz, nominal_mt[row][column]);
        r.mt_std[row][column] = m_qz_std;
    }
    return r;
}

/* Parts of a channel in phase with the tested axis, and a quarter of a period ahead of it. */
struct phasor {
    double in_phase, quadrature;
};

static struct phasor rotated(const struct test_result *t, const double coefficient[2]) {
    const double *own = t->pose[t->dof];
    double amplitude = hypot(own[0], own[1]), c = own[0] / amplitude, s = own[1] / amplitude;
    return (struct phasor){coefficient[0] * c + coefficient[1] * s, coefficient[1] * c - coefficient[0] * s};
}

static void fill_b(struct equations *e, const struct test_result *const test[DOFS]) {
    e->n = DOFS;
    for (int i = 0; i < DOFS; i++) {
        e->unit[i] = square(omega(test[i])) * test[i]->amplitude;
        for (int d = 0; d < DOFS; d++) {
            e->u[i * e->n + d] = -square(omega(test[d])) * rotated(test[d], test[d]->pose[i]).in_phase / e->unit[i];
            e->h[i][d] = rotated(test[d], test[d]->wrench[i]).in_phase;
        }
    }
}

/* Variance as by row_variance(), plus the effect of a phase error of the tested axis, which mixes
 * the parts in quadrature into those in phase. */
static double row_variance_b(const struct test_result *t, int row, const double m[DOFS]) {
    static const double no_damping[DOFS] = {0};
    double phase_std = t->pose_std[t->dof] / t->achieved_amplitude, w = omega(t);
    double quadrature = rotated(t, t->wrench[row]).quadrature;
    for (int j = 0; j < DOFS; j++) quadrature += w * w * m[j] * rotated(t, t->pose[j]).quadrature;
    return row_variance(t, row, m, no_damping) + square(quadrature * phase_std);
}

struct method_result method_b(const struct test_result *const test[DOFS]) {
    struct method_result r = {0};
    struct equations e;
    fill_b(&e, test);
    struct lin_report report = equations_solve(&e);
    r.evaluated = report.rank == e.n;
    r.condition_number = report.condition;
    for (int i = 0; i < DOFS; i++) {
        double variance[N_MAX];
        for (int d = 0; d < DOFS; d++) variance[d] = row_variance_b(test[d], i, e.x[i]);
        for (int k = 0; k < DOFS; k++) {
            r.mt[i][k] = e.x[i][k];
            r.mt_std[i][k] = entry_std(&e, k, variance);
        }
    }
    return r;
}
