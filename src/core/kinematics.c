#include "kinematics.h"

#include <math.h>
#include <string.h>

#include "params.h"
#include "units.h"

/*  symbol  meaning                                     unit  frame
 *  c       origin of {M}                               m     {B}
 *  T       rotation of {M}                             -     {M} to {B}
 *  a, b    upper and lower joint                       m     {M}, {B}
 *  q = Ta  lever arm of the upper joint                m     {B}
 *  l, L, n leg vector, its length and direction        m     {B}
 *  E       angular velocity = E [phi theta psi]dot     -     {B} */

static const double tolerance_m = 1e-13;
static const double last_step_m = 1e-7; /* length of a Newton step after which the remaining error
                                         * (about the step squared over arm_m) is below the
                                         * tolerance */

static const double LEG_THIN = 0.01;   /* two legs collide if the distance of their centre lines is
                                        * below this share of the shorter leg's neutral length; no
                                        * real leg is thinner than this */
static const double LEG_MIDDLE = 0.45; /* half-length of the middle part of a leg that counts for
                                        * collisions, as a share of the leg's length */
/* Sine of the smallest permitted angle between a joint's axis and its leg at neutral. The angle is
 * 20 degrees, because a leg swings by up to 10 degrees. */
static const double AXIS_ACROSS = 0.35;
static const double AXIS_LEAST = 1e-6; /* shortest configured axis vector that has a direction; a
                                        * shorter one is refused */

/* Computes the joints in the frame of their body: as given, or in pairs on a circle. */
static void joints(const struct leg_vectors *given, double radius, const double angle[LEGS], double point[LEGS][3]) {
    memset(point, 0, LEGS * sizeof point[0]);
    for (int i = 0; i < LEGS && !given->given; i++) point[i][0] = radius * cos(angle[i]), point[i][1] = radius * sin(angle[i]);
    if (given->given) memcpy(point, given->leg, sizeof given->leg);
}

static double arm(double upper[LEGS][3]) {
    double square = 0.0;
    for (int r = 0; r < 3; r++) {
        double middle = 0.0;
        for (int i = 0; i < LEGS; i++) middle += upper[i][r] / LEGS;
        for (int i = 0; i < LEGS; i++) square += (upper[i][r] - middle) * (upper[i][r] - middle);
    }
    return sqrt(square / LEGS);
}

/* Computes the joints' positions. The origin of {M} is the payload's mass centre; the origin of {B}
 * is the point where that centre is at neutral. */
void kinematics_place(struct kinematics *k, const struct params *params) {
    const struct geometry_params *g = &params->geometry;
    const struct payload_params *p = &params->payload;
    const double center[3] = {p->center_x_m, p->center_y_m, -p->center_height_m};
    double alpha = g->upper_half_angle_rad, beta = g->lower_half_angle_rad, third = 2.0 * PI / 3.0;
    const double upper_angle[LEGS] = {-alpha, alpha, third - alpha, third + alpha, 2 * third - alpha, 2 * third + alpha};
    const double lower_angle[LEGS] = {beta - third / 2,   third / 2 - beta,   third / 2 + beta,
                                      1.5 * third - beta, 1.5 * third + beta, 2.5 * third - beta};
    memset(k, 0, sizeof *k);
    joints(&g->upper, g->upper_radius_m, upper_angle, k->upper);
    joints(&g->lower, g->lower_radius_m, lower_angle, k->lower);
    k->arm_m = arm(k->upper);
    for (int i = 0; i < LEGS; i++)
        for (int r = 0; r < 3; r++) {
            k->upper[i][r] -= center[r];
            k->lower[i][r] += (r == 2 ? g->height_m : 0.0) - center[r];
        }
    ik_lengths(k, (double[DOFS]){0}, k->neutral_length_m);
}

struct stroke kinematics_stroke(const struct kinematics *k, const struct actuator_params *actuator, int leg) {
    double middle_m = k->neutral_length_m[leg] + actuator->mid_stroke_m[leg], half_m = actuator->stroke_m[leg] / 2;
    return (struct stroke){.least_m = middle_m - half_m, .middle_m = middle_m, .most_m = middle_m + half_m};
}

static inline void cross(const double a[3], const double b[3], double c[3]) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Returns true if two legs collide at neutral. The ends of the legs do not count, because two legs
 * may share a joint. Parallel legs give NaN, with which all comparisons are false, so they never
 * collide. */
static bool legs_cross(const struct kinematics *k, int one, int other) {
    double u[3], v[3], between[3], normal[3], moment[3];
    for (int r = 0; r < 3; r++) {
        u[r] = k->upper[one][r] - k->lower[one][r];
        v[r] = k->upper[other][r] - k->lower[other][r];
        between[r] = k->lower[other][r] - k->lower[one][r];
    }
    cross(u, v, normal);
    double square = dot(normal, normal), distance_m = fabs(dot(between, normal)) / sqrt(square);
    cross(between, v, moment);
    double along_one = dot(moment, normal) / square;
    cross(between, u, moment);
    double along_other = dot(moment, normal) / square;
    bool inside = fabs(along_one - 0.5) < LEG_MIDDLE && fabs(along_other - 0.5) < LEG_MIDDLE;
    return inside && distance_m < LEG_THIN * fmin(k->neutral_length_m[one], k->neutral_length_m[other]);
}

/* Refuses a joint's axis, fixed in platform or base, that lies nearly along its leg. */
static int check_axes(const struct kinematics *k, const char *key, const struct leg_vectors *axis, struct error *error) {
    for (int i = 0; i < LEGS && axis->given; i++) {
        double leg[3], across[3];
        for (int r = 0; r < 3; r++) leg[r] = k->upper[i][r] - k->lower[i][r];
        cross(axis->leg[i], leg, across);
        double square = dot(axis->leg[i], axis->leg[i]);
        bool direction = square > AXIS_LEAST * AXIS_LEAST;
        if (!direction || dot(across, across) < AXIS_ACROSS * AXIS_ACROSS * square * dot(leg, leg))
            return error_set(error, STATUS_USAGE,
                             "geometry.%s: leg %d: [%g, %g, %g] is %s: of a universal joint's two axes, take the one that is fixed in "
                             "platform or base; it lies across the leg",
                             key, i + 1, axis->leg[i][0], axis->leg[i][1], axis->leg[i][2],
                             direction ? "within 20 degrees of the leg at neutral" : "no direction");
    }
    return STATUS_OK;
}

int kinematics_init(struct kinematics *k, const struct params *params, struct error *error) {
    const struct actuator_params *a = &params->actuator;
    kinematics_place(k, params);
    for (int i = 0; i < LEGS; i++) {
        double length_m = k->neutral_length_m[i], half = a->stroke_m[i] / 2;
        struct stroke stroke = kinematics_stroke(k, a, i);
        if (!(isfinite(length_m) && stroke.least_m > 0.0))
            return error_set(error, STATUS_USAGE,
                             "leg %d: the neutral length %.3f m and actuator.mid_stroke_m %g are not above half of "
                             "actuator.stroke_m (%.3f m): correct geometry.height_m, geometry.upper_radius_m and "
                             "geometry.lower_radius_m (or upper_joints_m and lower_joints_m), or the stroke",
                             i + 1, length_m, a->mid_stroke_m[i], half);
        if (!(stroke.least_m < length_m && length_m < stroke.most_m))
            return error_set(error, STATUS_USAGE,
                             "leg %d: actuator.mid_stroke_m %g is not within half of actuator.stroke_m (%.3f m): the stroke "
                             "does not reach the neutral length %.3f m",
                             i + 1, a->mid_stroke_m[i], half, length_m);
    }
    for (int i = 0; i < LEGS; i++)
        for (int other = 0; other < i; other++)
            if (legs_cross(k, other, i))
                return error_set(error, STATUS_USAGE,
                                 "legs %d and %d go through each other at neutral: geometry.upper_joints_m and lower_joints_m must name "
                                 "the joints in one order, leg by leg",
                                 other + 1, i + 1);
    int status = check_axes(k, "upper_joint_axes", &params->geometry.upper_axis, error);
    if (!status) status = check_axes(k, "lower_joint_axes", &params->geometry.lower_axis, error);
    if (status) return status;
    struct fk_result fk = fk_solve(k, k->neutral_length_m, (double[DOFS]){[DOF_Z] = 1e-4});
    if (!fk.converged || !(fk.pivot_ratio > 1e-3))
        return error_set(error, STATUS_USAGE,
                         "the legs do not hold the platform at neutral (singular): correct geometry.upper_radius_m, "
                         "geometry.lower_radius_m, geometry.upper_half_angle_rad and geometry.lower_half_angle_rad, or upper_joints_m and "
                         "lower_joints_m");
    return STATUS_OK;
}

void rotation_from_angles(double phi, double theta, double psi, double t[3][3]) {
    double sp, cp, st, ct, ss, cs;
    sincos(phi, &sp, &cp);
    sincos(theta, &st, &ct);
    sincos(psi, &ss, &cs);
    t[0][0] = cs * ct, t[0][1] = cs * st * sp - ss * cp, t[0][2] = cs * st * cp + ss * sp;
    t[1][0] = ss * ct, t[1][1] = ss * st * sp + cs * cp, t[1][2] = ss * st * cp - cs * sp;
    t[2][0] = -st, t[2][1] = ct * sp, t[2][2] = ct * cp;
}

/* Computes lever arm q and direction n; returns the length. */
static inline double leg(const struct kinematics *k, int i, const double pose[DOFS], double t[3][3], double q[3], double n[3]) {
    const double *a = k->upper[i], *b = k->lower[i];
    for (int r = 0; r < 3; r++) {
        q[r] = t[r][0] * a[0] + t[r][1] * a[1] + t[r][2] * a[2];
        n[r] = pose[r] + q[r] - b[r];
    }
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), inverse = 1.0 / length;
    for (int r = 0; r < 3; r++) n[r] *= inverse;
    return length;
}

void ik_lengths(const struct kinematics *k, const double pose[DOFS], double length_m[LEGS]) {
    double t[3][3], q[3], n[3];
    rotation_from_angles(pose[3], pose[4], pose[5], t);
    for (int i = 0; i < LEGS; i++) length_m[i] = leg(k, i, pose, t, q, n);
}

void ik_jacobian(const struct kinematics *k, const double pose[DOFS], double j[LEGS][DOFS]) {
    double t[3][3], q[3];
    rotation_from_angles(pose[3], pose[4], pose[5], t);
    for (int i = 0; i < LEGS; i++) {
        leg(k, i, pose, t, q, j[i]);
        cross(q, j[i], j[i] + 3);
    }
}

void wrench_from_forces(const struct kinematics *k, const double pose[DOFS], const double force_n[LEGS], double wrench[DOFS]) {
    double j[LEGS][DOFS];
    ik_jacobian(k, pose, j);
    for (int r = 0; r < DOFS; r++) {
        wrench[r] = 0.0;
        for (int i = 0; i < LEGS; i++) wrench[r] += j[i][r] * force_n[i];
    }
}

/* Fills in row i of m: d L_i / d pose, with angles in units of 1/arm_m, and the length error in the
 * last column. Returns the largest error. */
static double fk_equations(const struct kinematics *k, const double length_m[LEGS], const double pose[DOFS], double m[LEGS][DOFS + 1]) {
    double t[3][3], q[3], moment[3], largest = 0.0, scale = 1.0 / k->arm_m;
    rotation_from_angles(pose[3], pose[4], pose[5], t);
    /* E = [Rz Ry ex, Rz ey, ez]: the first column of E is that of T. The second needs cos and sin
     * of psi, which follow from the first column of T. */
    double ct = sqrt(t[0][0] * t[0][0] + t[1][0] * t[1][0]), cs = t[0][0] / ct, ss = t[1][0] / ct;
    for (int i = 0; i < LEGS; i++) {
        double error = leg(k, i, pose, t, q, m[i]) - length_m[i];
        cross(q, m[i], moment);
        m[i][3] = scale * (t[0][0] * moment[0] + t[1][0] * moment[1] + t[2][0] * moment[2]);
        m[i][4] = scale * (cs * moment[1] - ss * moment[0]);
        m[i][5] = scale * moment[2];
        m[i][6] = error;
        /* a NaN in `largest` stays there, because comparisons with NaN are false */
        if (fabs(error) > largest || isnan(error)) largest = fabs(error);
    }
    return largest;
}

/* Gauss elimination with row pivoting of the 6 x 7 system; the solution is left in the last column.
 * Returns the pivot ratio. */
static double eliminate(double m[LEGS][DOFS + 1]) {
    double smallest = INFINITY, largest = 0.0;
#pragma GCC unroll 6 /* constant bounds save a third of the instructions */
    for (int c = 0; c < DOFS; c++) {
        int pivot = c;
        for (int r = c + 1; r < LEGS; r++)
            if (fabs(m[r][c]) > fabs(m[pivot][c])) pivot = r;
        double size = fabs(m[pivot][c]);
        if (!(size > 1e-12)) return 0.0;
        smallest = size < smallest ? size : smallest;
        largest = size > largest ? size : largest;

        for (int j = c; j <= DOFS && pivot != c; j++) {
            double keep = m[c][j];
            m[c][j] = m[pivot][j];
            m[pivot][j] = keep;
        }

        double inverse = 1.0 / m[c][c];
        for (int r = c + 1; r < LEGS; r++) {
            double factor = m[r][c] * inverse;
            for (int j = c + 1; j <= DOFS; j++) m[r][j] -= factor * m[c][j];
        }
    }

    for (int r = DOFS - 1; r >= 0; r--) {
        for (int j = r + 1; j < DOFS; j++) m[r][DOFS] -= m[r][j] * m[j][DOFS];
        m[r][DOFS] /= m[r][r];
    }
    return smallest / largest;
}

struct fk_result fk_solve(const struct kinematics *k, const double length_m[LEGS], double pose[DOFS]) {
    struct fk_result result = {.pivot_ratio = 1.0};
    double m[LEGS][DOFS + 1], s[DOFS];
    memcpy(s, pose, sizeof s);
    for (;;) {
        result.residual_m = fk_equations(k, length_m, s, m);
        result.converged = result.residual_m <= tolerance_m;
        if (result.converged || result.iterations == FK_ITERATIONS) break;
        result.pivot_ratio = eliminate(m);
        if (!(result.pivot_ratio > 0.0)) break;
        double step_m = 0.0;
        for (int r = 0; r < DOFS; r++) {
            s[r] -= r < 3 ? m[r][DOFS] : m[r][DOFS] / k->arm_m;
            step_m = fmax(step_m, fabs(m[r][DOFS]));
        }
        result.iterations++;
        if (step_m <= last_step_m && result.residual_m <= last_step_m) {
            result.residual_m = step_m * step_m / k->arm_m;
            result.converged = true;
            break;
        }
    }
    if (result.converged) memcpy(pose, s, sizeof s);
    return result;
}
