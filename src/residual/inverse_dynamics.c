#include "inverse_dynamics.h"

#include <math.h>
#include <string.h>

#include "joint_axes.h"
#include "vec.h"

static const double POSE_TOLERANCE_M = 1e-12;
static const double SURE = 3.0;       /* standard deviations of a leg's speed */
static const double OVERSHOOT = 1.18; /* of a force that jumps from one side to the other, in the
                                       * harmonics evaluated (Gibbs) */
enum { POSE_ITERATIONS = 12 };

void inverse_dynamics_init(struct inverse_dynamics *d, const struct params *params, double window_s, double resolution_s) {
    *d = (struct inverse_dynamics){.params = params, .window_s = window_s, .resolution_s = resolution_s};
    rigid_model_init(&d->rigid, params);
    cylinder_model_init(&d->cylinder, params);
    d->joints = d->cylinder.machine.joint_friction.count > 0;
    rigid_rest(&d->state, (const double[DOFS]){0});
}

/* x := A^-1 x, or A'^-1 x, by elimination with pivots. False: singular. */
static bool solve6(double a[6][6], bool transposed, double x[6]) {
    double m[6][7];
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) m[i][j] = transposed ? a[j][i] : a[i][j];
        m[i][6] = x[i];
    }
    for (int j = 0; j < 6; j++) {
        int pivot = j;
        for (int i = j + 1; i < 6; i++)
            if (fabs(m[i][j]) > fabs(m[pivot][j])) pivot = i;
        if (!(fabs(m[pivot][j]) > 1e-9)) return false;
        for (int c = j; c < 7 && pivot != j; c++) {
            double swap = m[j][c];
            m[j][c] = m[pivot][c], m[pivot][c] = swap;
        }
        for (int i = j + 1; i < 6; i++) {
            double factor = m[i][j] / m[j][j];
            for (int c = j; c < 7; c++) m[i][c] -= factor * m[j][c];
        }
    }
    for (int i = 5; i >= 0; i--) {
        x[i] = m[i][6];
        for (int j = i + 1; j < 6; j++) x[i] -= m[i][j] * x[j];
        x[i] /= m[i][i];
    }
    return true;
}

/* Position and attitude by a small displacement: velocity of the origin and rotation
 * vector, both in {B}. */
static void displace(struct rigid_state *s, const double d[6]) {
    double q[4], half[3] = {0.5 * d[3], 0.5 * d[4], 0.5 * d[5]}, *p = s->attitude, norm = 0.0;
    for (int i = 0; i < 3; i++) s->position[i] += d[i];
    q[0] = p[0] - dot3(half, p + 1);
    cross3(half, p + 1, q + 1);
    for (int i = 0; i < 3; i++) q[1 + i] += p[1 + i] + half[i] * p[0];
    for (int i = 0; i < 4; i++) norm += q[i] * q[i];
    for (int i = 0; i < 4; i++) p[i] = q[i] / sqrt(norm);
}

static void jacobian(const struct rigid_legs *legs, double j[LEGS][DOFS]) {
    for (int k = 0; k < LEGS; k++) rigid_row(legs, k, j[k]);
}

/* Newton on the lengths. */
static bool find_pose(struct inverse_dynamics *d, const double leg[LEGS][3], struct rigid_legs *legs, double j[LEGS][DOFS]) {
    memset(d->state.twist, 0, sizeof d->state.twist);
    for (int iteration = 0; iteration < POSE_ITERATIONS; iteration++) {
        double step[DOFS], size = 0.0;
        rigid_legs(&d->rigid, &d->state, legs);
        jacobian(legs, j);
        for (int k = 0; k < LEGS; k++) step[k] = leg[k][0] - legs->length[k], size = fmax(size, fabs(step[k]));
        if (size < POSE_TOLERANCE_M) return true;
        if (!solve6(j, false, step)) return false;
        displace(&d->state, step);
    }
    return false;
}

double inverse_dynamics_direction(double value, double rate, double window_s) {
    double swing = 0.5 * window_s * fabs(rate);
    if (fabs(value) >= swing) return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : 0.0;
    return value / swing;
}

/* Below this speed a leg may be held: as near to a reversal as the harmonics resolve time, and
 * noise resolves speed. */
static double slow_mps(const struct inverse_dynamics *d, int leg, double acceleration) {
    return fmax(fmax(fabs(acceleration) * d->resolution_s, SURE * d->speed_std_mps[leg]), INVERSE_DYNAMICS_SLOW_MPS);
}

/* Dry friction of a leg that may be held: what the balance of forces leaves for it, as far as it
 * reaches, since a leg that sticks holds against any load. Noise of the balance is not friction. A
 * held one is anywhere within its reach, with a variance of F^2 / 3, and the linear estimate of
 * least variance takes that share of what the balance has beyond sliding. A limit without the
 * overshoot would be met from one side only, and friction come out too large. */
static double held_friction(double balance_n, double noise_n, double extend_n, double retract_n, double sliding_n) {
    double reach_n = 0.5 * (extend_n + retract_n), variance = reach_n * reach_n / 3.0;
    double gain = variance > 0.0 ? variance / (variance + noise_n * noise_n) : 0.0;
    return fmin(fmax(sliding_n + gain * (balance_n - sliding_n), -OVERSHOOT * retract_n), OVERSHOOT * extend_n);
}

/* balance_n: hydraulic force left for friction. Dry friction has its full size only where the leg
 * surely slides, from twice the slow speed on. */
double inverse_dynamics_friction(const struct inverse_dynamics *d, int leg, const struct inverse_dynamics_input *in, double balance_n) {
    struct cylinder_state s = {.p1_pa = in->p1_pa[leg], .p2_pa = in->p2_pa[leg]};
    double motion[3];
    for (int i = 0; i < 3; i++) motion[i] = in->leg[leg][i] + in->ahead[leg][i];
    double sign = inverse_dynamics_direction(motion[1], motion[2], d->window_s), speed = fabs(motion[1]);
    struct friction extend = cylinder_friction(&d->cylinder, leg, &s, 1, speed);
    struct friction retract = cylinder_friction(&d->cylinder, leg, &s, -1, speed);
    double viscous = motion[1] > 0.0 ? extend.viscous : -retract.viscous;
    double sliding = 0.5 * (1.0 + sign) * extend.dry - 0.5 * (1.0 - sign) * retract.dry;
    double held = held_friction(balance_n - viscous, d->force_std_n[leg], extend.dry, retract.dry, sliding);
    double share = fmin(fmax(speed / slow_mps(d, leg, motion[2]) - 1.0, 0.0), 1.0);
    return viscous + share * sliding + (1.0 - share) * held;
}

/* The moments that joint friction takes, as a wrench on the platform. */
static void push_joints(const struct inverse_dynamics *d, const struct rigid_legs *legs, const double acceleration[DOFS],
                        double load[DOFS]) {
    struct joint_axes axes;
    joint_axes(&d->rigid, &d->state, legs, &axes);
    for (int k = 0; k < JOINT_AXES; k++) {
        double rate = dot6(axes.row[k], d->state.twist), turn = dot6(axes.row[k], acceleration) + axes.bias[k];
        struct friction f = machine_joint_friction(&d->cylinder.machine, k / JOINT_AXES_PER_LEG, fabs(rate));
        double moment = inverse_dynamics_direction(rate, turn, d->window_s) * f.dry + copysign(f.viscous, rate);
        add6(-moment, axes.row[k], load);
    }
}

/* One axis: mass, weight and springs along it. */
static void axis_bodies(const struct inverse_dynamics *d, const struct inverse_dynamics_input *in, double force_n[LEGS]) {
    const struct machine *m = &d->cylinder.machine;
    memset(force_n, 0, LEGS * sizeof *force_n);
    double pose[DOFS] = {in->leg[0][0] - d->params->axis.middle_m}, wrench[DOFS] = {0};
    machine_wrench(m, pose, wrench);
    force_n[0] = m->bodies.payload_kg * (in->leg[0][2] + m->bodies.gravity_mps2) - wrench[0];
}

bool inverse_dynamics_move(struct inverse_dynamics *d, const double leg[LEGS][3], struct rigid_legs *legs, double j[LEGS][DOFS],
                           double acceleration[DOFS]) {
    if (!find_pose(d, leg, legs, j)) return false;
    for (int k = 0; k < LEGS; k++) d->state.twist[k] = leg[k][1];
    if (!solve6(j, false, d->state.twist)) return false;
    rigid_legs(&d->rigid, &d->state, legs);
    for (int k = 0; k < LEGS; k++) {
        acceleration[k] = leg[k][2];
        for (int i = 0; i < 3; i++)
            acceleration[k] -= legs->n[i][k] * legs->centripetal[i][k] + legs->across[i][k] * legs->across[i][k] / legs->length[k];
    }
    return solve6(j, false, acceleration);
}

bool inverse_dynamics_along_legs(double j[LEGS][DOFS], double wrench[DOFS]) { return solve6(j, true, wrench); }

bool inverse_dynamics_bodies(struct inverse_dynamics *d, const struct inverse_dynamics_input *in, struct rigid_legs *legs,
                             double force_n[LEGS]) {
    double j[LEGS][DOFS], acceleration[DOFS], mass[DOFS][DOFS], load[DOFS];
    if (d->params->mechanism == MECHANISM_AXIS) {
        axis_bodies(d, in, force_n);
        return true;
    }
    if (!inverse_dynamics_move(d, in->leg, legs, j, acceleration)) return false;
    rigid_dynamics(&d->rigid, &d->state, legs, mass, load);
    if (d->joints) push_joints(d, legs, acceleration, load);
    for (int i = 0; i < DOFS; i++) {
        force_n[i] = -load[i];
        for (int c = 0; c < DOFS; c++) force_n[i] += (i >= c ? mass[i][c] : mass[c][i]) * acceleration[c];
    }
    if (!solve6(j, true, force_n)) return false;
    for (int k = 0; k < LEGS; k++) force_n[k] += d->rigid.upper_mass[k] * in->ahead[k][2];
    return true;
}

bool inverse_dynamics_step(struct inverse_dynamics *d, const struct inverse_dynamics_input *in, double force_n[LEGS]) {
    struct rigid_legs legs;
    if (!inverse_dynamics_bodies(d, in, &legs, force_n)) return false;
    for (int k = 0; k < params_legs(d->params); k++) force_n[k] += inverse_dynamics_friction(d, k, in, in->push_n[k] - force_n[k]);
    return true;
}

void inverse_dynamics_inertia(const struct inverse_dynamics *d, double inertia[LEGS][LEGS]) {
    struct rigid_legs legs;
    double j[LEGS][DOFS], mass[DOFS][DOFS], load[DOFS], twist[LEGS][DOFS];
    rigid_legs(&d->rigid, &d->state, &legs);
    rigid_dynamics(&d->rigid, &d->state, &legs, mass, load);
    jacobian(&legs, j);
    for (int k = 0; k < LEGS; k++) {
        for (int i = 0; i < DOFS; i++) twist[k][i] = i == k;
        solve6(j, false, twist[k]);
    }
    for (int k = 0; k < LEGS; k++)
        for (int l = 0; l < LEGS; l++) {
            inertia[k][l] = 0.0;
            for (int i = 0; i < DOFS; i++)
                for (int c = 0; c < DOFS; c++) inertia[k][l] += twist[k][i] * (i >= c ? mass[i][c] : mass[c][i]) * twist[l][c];
        }
}
