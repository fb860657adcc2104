/* Synthetic cycles of a machine whose matrices are known. */
#ifndef HEXID_TESTS_IDENT_RIG_H
#define HEXID_TESTS_IDENT_RIG_H

#include "support.h"

#include "ident.h"
#include "lin.h"
#include "units.h"

enum { RATE_HZ = 500, SAMPLES_MAX = 2500, HARMONICS = 3 };

static const double tank_pa = 1e6;

/* A machine as the method models it, and the record of its six tests. Poses and wrenches consist of
 * a constant, a drift and three harmonics. */
struct rig {
    struct params params;
    struct kinematics kinematics;
    struct cylinder_areas areas;
    double mt[DOFS][DOFS], bt[DOFS][DOFS];
    double pose[DOFS][DOFS][HARMONICS][2]; /* [test][axis][harmonic][sin, cos] */
    int samples;                           /* evaluated samples per test */
    struct cycle cycle[DOFS][SAMPLES_MAX]; /* [test] */
};

static inline double omega(const struct rig *r, int d) { return 2 * PI * r->params.tests.hz[d]; }

static inline double amplitude(const struct rig *r, int dof) { return r->params.tests.amplitude[dof]; }

/* Draws the motions: the tested axis follows the command with a phase lag, the others move by a few
 * percent of it; the harmonics are weaker. */
static inline void rig_motions(struct rig *r, uint64_t *state) {
    for (int d = 0; d < DOFS; d++)
        for (int i = 0; i < DOFS; i++)
            for (int k = 0; k < HARMONICS; k++) {
                double share = k > 0 ? 0.01 : i == d ? 0.0 : 0.05;
                r->pose[d][i][k][0] = amplitude(r, i) * (share * random_unit(state) + (k == 0 && i == d ? 0.97 : 0));
                r->pose[d][i][k][1] = amplitude(r, i) * (share * random_unit(state) - (k == 0 && i == d ? 0.30 : 0));
            }
}

/* Disturbs every entry of the nominal matrices and the legs' viscous friction, so that a transposed
 * or misplaced entry shows. */
static inline void rig_matrices(struct rig *r, uint64_t *state) {
    static const double neutral[DOFS] = {0};
    double j[LEGS][DOFS];
    nominal_matrix(&r->params, &r->kinematics, neutral, r->mt);
    ik_jacobian(&r->kinematics, neutral, j);
    for (int i = 0; i < DOFS; i++)
        for (int k = 0; k < DOFS; k++) {
            r->bt[i][k] = 0;
            for (int leg = 0; leg < LEGS; leg++) r->bt[i][k] += 2000 * j[leg][i] * j[leg][k];
        }
    for (int i = 0; i < DOFS; i++)
        for (int k = 0; k < DOFS; k++) {
            r->mt[i][k] += random_unit(state);
            r->bt[i][k] += 20 * random_unit(state);
        }
}

/* Computes the pose and its first and second time derivatives. */
static inline void rig_motion(const struct rig *r, int d, double t_s, double pose[3][DOFS]) {
    for (int i = 0; i < DOFS; i++) {
        pose[0][i] = amplitude(r, i) * (0.1 + 0.02 * (t_s - 1));
        pose[1][i] = pose[2][i] = 0; /* the rate of the drift is not part of the fundamental that
                                      * the method uses */
        for (int k = 0; k < HARMONICS; k++) {
            double w = (k + 1) * omega(r, d), s = sin(w * t_s), c = cos(w * t_s);
            const double *a = r->pose[d][i][k];
            pose[0][i] += a[0] * s + a[1] * c;
            pose[1][i] += w * (a[0] * c - a[1] * s);
            pose[2][i] -= w * w * (a[0] * s + a[1] * c);
        }
    }
}

static inline void rig_wrench(const struct rig *r, double t_s, double motion[3][DOFS], double wrench[DOFS]) {
    for (int i = 0; i < DOFS; i++) {
        wrench[i] = (i == 2 ? -3000 : 50) + 2 * t_s;
        for (int k = 0; k < DOFS; k++) wrench[i] += r->mt[i][k] * motion[2][k] + r->bt[i][k] * motion[1][k];
    }
}

/* Fills in the lengths and pressures that belong to this pose and wrench. */
static inline void sample_from(const struct rig *r, const double pose[DOFS], const double wrench[DOFS], struct hal_sample *in) {
    double j[LEGS][DOFS], force_n[LEGS];
    ik_lengths(&r->kinematics, pose, in->length_m);
    ik_jacobian(&r->kinematics, pose, j);
    lin_solve_right(LEGS, 1, &j[0][0], wrench, force_n); /* f' J = F' */
    for (int leg = 0; leg < LEGS; leg++) {
        in->p2_pa[leg] = tank_pa;
        in->p1_pa[leg] = (force_n[leg] + r->areas.a2_m2[leg] * tank_pa) / r->areas.a1_m2[leg];
    }
}

static inline void rig_record(struct rig *r) {
    for (int d = 0; d < DOFS; d++)
        for (int i = 0; i < r->samples; i++) {
            double motion[3][DOFS], wrench[DOFS], t = r->params.tests.ramp_s + (double)i / RATE_HZ;
            r->cycle[d][i] = (struct cycle){.test = d, .dof = (enum dof)d, .phase = PHASE_EVALUATE, .test_time_s = t};
            rig_motion(r, d, t, motion);
            rig_wrench(r, t, motion, wrench);
            sample_from(r, motion[0], wrench, &r->cycle[d][i].in);
        }
}

static inline struct rig *rig_create(uint64_t seed, double duration_s) {
    static struct rig rig;
    struct rig *r = &rig;
    struct error error;
    config_default(&r->params);
    r->params.tests.duration_s = duration_s;
    r->params.tests.harmonics = HARMONICS;
    assert_int_equal(kinematics_init(&r->kinematics, &r->params, &error), 0);
    r->areas = cylinder_areas(&r->params.actuator);
    rig_motions(r, &seed);
    rig_matrices(r, &seed);
    r->samples = (int)lround(duration_s * RATE_HZ);
    assert_true(r->samples <= SAMPLES_MAX);
    rig_record(r);
    return r;
}

static inline struct ident *ident_create(const struct rig *r) {
    static struct ident ident;
    struct error error;
    assert_int_equal(ident_init(&ident, &r->params, &error), 0);
    return &ident;
}

static const struct cycle ramp_out = {.test = 0, .dof = DOF_X, .phase = PHASE_RAMP_OUT};

static inline bool feed_part(struct ident *id, const struct rig *r, int d, int from, int to) {
    bool ended = false;
    for (int i = from; i < to; i++) ended |= ident_feed(id, &r->cycle[d][i]);
    return ended;
}

static inline void feed_all(struct ident *id, const struct rig *r) {
    for (int d = 0; d < DOFS; d++) feed_part(id, r, d, 0, r->samples);
    ident_end(id);
}

static inline const struct test_result *last_result(const struct ident *id) { return &id->result.test[id->result.tests - 1]; }

#endif
