#include "dynamics.h"

#include <math.h>

#include "lin.h"
#include "params.h"

static const double LEAST_PIVOT = 1e-3; /* smallest pivot at which J counts as regular, angles in
                                         * units of 1/arm_m; the shipped machines have pivots of 0.2
                                         * or more in their workspaces */

void dynamics_init(struct dynamics *d, const struct params *params, const struct kinematics *kinematics) {
    const struct actuator_params *a = &params->actuator;
    struct machine machine;
    machine_init(&machine, params);
    const double *square = machine.bodies.payload_inertia_kg_m2, *product = machine.bodies.payload_products_kg_m2;
    *d = (struct dynamics){
        .kinematics = kinematics,
        .mass_kg = machine.bodies.payload_kg,
        .inertia_kg_m2 = {{square[0], product[0], product[1]}, {product[0], square[1], product[2]}, {product[1], product[2], square[2]}},
        .wrench = machine.wrench};
    for (int r = 0; r < 3; r++) {
        d->center_m[r] = machine.bodies.payload_center_m[r];
        d->gravity_mps2[r] = machine.bodies.gravity_mps2 * machine.bodies.down[r];
    }
    for (int i = 0; i < LEGS; i++) {
        double moment = machine.bodies.lower_kg[i] * a->lower_center_m[i];
        d->leg[i].rod_kg = machine.bodies.upper_kg[i], d->leg[i].rod_center_m = a->upper_center_m[i];
        d->leg[i].moment_kg_m = moment;
        d->leg[i].inertia_kg_m2 = moment * a->lower_center_m[i] + a->upper_inertia_kg_m2[i] + a->lower_inertia_kg_m2[i] +
                                  machine.bodies.transverse_kg_m2[i];
    }
}

static inline double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Adds a x b to sum. */
static inline void add_cross(const double a[3], const double b[3], double sum[3]) {
    sum[0] += a[1] * b[2] - a[2] * b[1];
    sum[1] += a[2] * b[0] - a[0] * b[2];
    sum[2] += a[0] * b[1] - a[1] * b[0];
}

/* Rotation of the platform: attitude, angular rate w and its derivative, in {B}. */
struct turn {
    double t[3][3], rate[3], accel[3];
};

/* Computes attitude, rate and acceleration. The rates of phi, theta and psi act about the axes e1 =
 * T x, e2 = Rz y and z: w = phi' e1 + theta' e2 + psi' z, and e1' = (theta' e2 + psi' z) x e1, e2'
 * = psi' z x e2. */
static void turn_of(double motion[MOTION_ORDERS][DOFS], struct turn *w) {
    const double *b = &motion[MOTION_POSE][3], *rate = &motion[MOTION_RATE][3], *accel = &motion[MOTION_ACCEL][3];
    double sine, cosine;
    rotation_from_angles(b[0], b[1], b[2], w->t);
    sincos(b[2], &sine, &cosine);
    const double e1[3] = {w->t[0][0], w->t[1][0], w->t[2][0]}, e2[3] = {-sine, cosine, 0.0};
    const double carrier[3] = {rate[1] * e2[0], rate[1] * e2[1], rate[2]};
    double turned[3] = {0};
    add_cross(carrier, e1, turned);
    const double e2_rate[3] = {-rate[2] * cosine, -rate[2] * sine, 0.0};
    for (int r = 0; r < 3; r++) {
        double z = r == 2;
        w->rate[r] = rate[0] * e1[r] + rate[1] * e2[r] + rate[2] * z;
        w->accel[r] = accel[0] * e1[r] + accel[1] * e2[r] + accel[2] * z + rate[0] * turned[r] + rate[1] * e2_rate[r];
    }
}

/* Computes the rate w x q and the acceleration w' x q + w x (w x q) of a lever arm. */
static inline void arm_motion(const struct turn *w, const double q[3], double rate[3], double accel[3]) {
    for (int r = 0; r < 3; r++) rate[r] = accel[r] = 0.0;
    add_cross(w->rate, q, rate);
    add_cross(w->accel, q, accel);
    add_cross(w->rate, rate, accel);
}

/* Computes the platform's own part of the wrench: p - F, and I w' + w x I w + s x p - M. */
static void platform_wrench(const struct dynamics *d, double motion[MOTION_ORDERS][DOFS], const struct turn *w, double wrench[DOFS]) {
    const double *accel = motion[MOTION_ACCEL];
    double body[2][3], momentum[2][3]; /* angular rate and acceleration in {M}, and I times them */
    double center[3], rate[3], turned[3], push[3], springs[DOFS] = {0};
    for (int r = 0; r < 3; r++) center[r] = dot(w->t[r], d->center_m);
    arm_motion(w, center, rate, turned);
    for (int r = 0; r < 3; r++) {
        push[r] = d->mass_kg * (accel[r] + turned[r] - d->gravity_mps2[r]);
        body[0][r] = w->t[0][r] * w->rate[0] + w->t[1][r] * w->rate[1] + w->t[2][r] * w->rate[2];
        body[1][r] = w->t[0][r] * w->accel[0] + w->t[1][r] * w->accel[1] + w->t[2][r] * w->accel[2];
    }
    for (int k = 0; k < 2; k++)
        for (int r = 0; r < 3; r++) momentum[k][r] = dot(d->inertia_kg_m2[r], body[k]);
    add_cross(body[0], momentum[0], momentum[1]);
    for (int r = 0; r < 3; r++) wrench[r] = push[r], wrench[3 + r] = dot(w->t[r], momentum[1]);
    add_cross(center, push, wrench + 3);
    for (int i = 0; i < d->wrench.count; i++) d->wrench.of[i].effect->wrench(d->wrench.of[i].values, motion[MOTION_POSE], springs);
    for (int i = 0; i < DOFS; i++) wrench[i] -= springs[i];
}

/* Adds leg i. row: set to row i of J. wrench: gets the force across the leg that swings the leg,
 * and its moment. course: length, rate and acceleration of leg i are set, and force_n to the force
 * along the leg that its rod needs. In the formulas v is L', square is |n'|^2. */
static void add_leg(const struct dynamics *d, int i, double motion[MOTION_ORDERS][DOFS], const struct turn *w, double row[DOFS],
                    double wrench[DOFS], struct leg_course *course) {
    const double *a = d->kinematics->upper[i], *b = d->kinematics->lower[i];
    double q[3], q_rate[3], q_accel[3], l[3], rate[3], accel[3], across[3];
    for (int r = 0; r < 3; r++) q[r] = dot(w->t[r], a), l[r] = motion[MOTION_POSE][r] + q[r] - b[r], row[3 + r] = 0.0;
    arm_motion(w, q, q_rate, q_accel);
    for (int r = 0; r < 3; r++) rate[r] = motion[MOTION_RATE][r] + q_rate[r], accel[r] = motion[MOTION_ACCEL][r] + q_accel[r];
    double length = sqrt(dot(l, l)), per_m = 1.0 / length;
    for (int r = 0; r < 3; r++) row[r] = l[r] * per_m;
    add_cross(q, row, row + 3);
    double v = dot(row, rate), square = fmax(dot(rate, rate) - v * v, 0.0) * per_m * per_m;
    double v_rate = dot(row, accel) + length * square, rod_m = length - d->leg[i].rod_center_m, rod_kg = d->leg[i].rod_kg;
    double inertia = d->leg[i].inertia_kg_m2 + rod_kg * rod_m * rod_m, moment = d->leg[i].moment_kg_m + rod_kg * rod_m;
    double along = dot(row, d->gravity_mps2);

    /* L n' = P l', and L P n'' = P l'' - 2 L' n' */
    for (int r = 0; r < 3; r++) {
        double turn = (rate[r] - v * row[r]) * per_m, turn_rate = (accel[r] - dot(row, accel) * row[r] - 2.0 * v * turn) * per_m;
        across[r] = (2.0 * rod_kg * rod_m * v * turn + inertia * turn_rate - moment * (d->gravity_mps2[r] - along * row[r])) * per_m;
        wrench[r] += across[r];
    }
    add_cross(q, across, wrench + 3);
    course->length_m[i] = length, course->rate_mps[i] = v, course->accel_mps2[i] = v_rate;
    course->force_n[i] = rod_kg * (v_rate - rod_m * square - along);
}

/* Solves J' h = wrench by Gauss elimination with pivots; the solution replaces the wrench. Rows of
 * moments are divided by arm_m first, so that all entries of J have similar size. Returns false if
 * J is singular. */
static bool along_legs(double j[LEGS][DOFS], double arm_m, double wrench[DOFS]) {
    double m[DOFS][LEGS + 1];
    for (int r = 0; r < DOFS; r++) {
        double scale = r < DOF_PHI ? 1.0 : 1.0 / arm_m;
        for (int i = 0; i < LEGS; i++) m[r][i] = scale * j[i][r];
        m[r][LEGS] = scale * wrench[r];
    }
    for (int c = 0; c < LEGS; c++) {
        int pivot = c;
        for (int r = c + 1; r < DOFS; r++)
            if (fabs(m[r][c]) > fabs(m[pivot][c])) pivot = r;
        if (!(fabs(m[pivot][c]) > LEAST_PIVOT)) return false;
        for (int k = c; k <= LEGS; k++) {
            double keep = m[c][k];
            m[c][k] = m[pivot][k], m[pivot][k] = keep;
        }
        for (int r = c + 1; r < DOFS; r++) {
            double factor = m[r][c] / m[c][c];
            for (int k = c + 1; k <= LEGS; k++) m[r][k] -= factor * m[c][k];
        }
    }
    for (int r = DOFS - 1; r >= 0; r--) {
        for (int k = r + 1; k < LEGS; k++) m[r][LEGS] -= m[r][k] * wrench[k];
        wrench[r] = m[r][LEGS] / m[r][r];
    }
    return true;
}

bool dynamics_solve(const struct dynamics *d, double motion[MOTION_ORDERS][DOFS], struct leg_course *course) {
    struct turn w;
    double j[LEGS][DOFS], wrench[DOFS], sum = 0.0;
    turn_of(motion, &w);
    platform_wrench(d, motion, &w, wrench);
    for (int i = 0; i < LEGS; i++) add_leg(d, i, motion, &w, j[i], wrench, course);
    if (!along_legs(j, d->kinematics->arm_m, wrench)) return false;
    for (int i = 0; i < LEGS; i++) sum += course->force_n[i] += wrench[i];
    return isfinite(sum);
}

bool dynamics_inertia(const struct params *params, const struct kinematics *k, double inertia[LEGS][LEGS]) {
    struct dynamics d;
    struct leg_course rest, moved;
    double motion[MOTION_ORDERS][DOFS] = {{0}}, accel[LEGS][DOFS], force[LEGS][DOFS];
    dynamics_init(&d, params, k);
    if (!dynamics_solve(&d, motion, &rest)) return false;
    for (int i = 0; i < DOFS; i++) {
        motion[MOTION_ACCEL][i] = 1.0;
        if (!dynamics_solve(&d, motion, &moved)) return false;
        for (int leg = 0; leg < LEGS; leg++) accel[leg][i] = moved.accel_mps2[leg], force[leg][i] = moved.force_n[leg] - rest.force_n[leg];
        motion[MOTION_ACCEL][i] = 0.0;
    }
    return lin_solve_right(DOFS, LEGS, accel[0], force[0], inertia[0]).rank == DOFS;
}
