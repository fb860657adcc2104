#include "inverse_dynamics.h"

#include <math.h>
#include <string.h>

#include "mechanism.h"
#include "numeric.h"
#include "vec.h"

static const double POSE_TOLERANCE_M = 1e-12;
static const double SPEED_STDS = 3.0; /* a leg may be held if its speed is less than this many of
                                       * its standard deviations */
static const double OVERSHOOT = 1.18; /* height of a jump of friction in the evaluated harmonics, as
                                       * a multiple of its true height (Gibbs) */
static const double STILL = 0.03;     /* a rod counts as resting while its speed stays below this
                                       * share of its rms speed, because the Fourier series rings at
                                       * rest */
static const double FORGOTTEN = 0.05; /* the seals' deflection before the first instant is ignored
                                       * once at most this share of it is left */
enum { POSE_ITERATIONS = 12, PASSES = 3 };

void inverse_dynamics_init(struct inverse_dynamics *d, const struct params *params, double window_s, double resolution_s) {
    *d = (struct inverse_dynamics){.params = params, .window_s = window_s, .resolution_s = resolution_s};
    rigid_model_init(&d->rigid, params);
    cylinder_model_init(&d->cylinder, params);
    d->joints = d->cylinder.machine.joint_friction.count > 0;
    rigid_rest(&d->state, (const double[DOFS]){0});
}

/* LU factors of a matrix, with partial pivoting: U in the upper triangle, L without its unit
 * diagonal below it. pivot[j]: row that was exchanged with row j. */
struct elimination {
    double m[6][6];
    int pivot[6];
};

/* Factors A, or its transpose A'. Returns false if the matrix is singular. */
static bool eliminate(double a[6][6], bool transposed, struct elimination *e) {
    double (*m)[6] = e->m;
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++) m[i][j] = transposed ? a[j][i] : a[i][j];
    for (int j = 0; j < 6; j++) {
        int pivot = j;
        for (int i = j + 1; i < 6; i++)
            if (fabs(m[i][j]) > fabs(m[pivot][j])) pivot = i;
        if (!(fabs(m[pivot][j]) > 1e-9)) return false;
        e->pivot[j] = pivot;
        for (int c = 0; c < 6 && pivot != j; c++) {
            double swap = m[j][c];
            m[j][c] = m[pivot][c], m[pivot][c] = swap;
        }
        for (int i = j + 1; i < 6; i++) {
            double factor = m[i][j] /= m[j][j];
            for (int c = j + 1; c < 6; c++) m[i][c] -= factor * m[j][c];
        }
    }
    return true;
}

/* Solves for one right-hand side in place. */
static void substitute(const struct elimination *e, double x[6]) {
    for (int j = 0; j < 6; j++) {
        double swap = x[j];
        x[j] = x[e->pivot[j]], x[e->pivot[j]] = swap;
    }
    for (int j = 0; j < 6; j++)
        for (int i = j + 1; i < 6; i++) x[i] -= e->m[i][j] * x[j];
    for (int i = 5; i >= 0; i--) {
        for (int j = i + 1; j < 6; j++) x[i] -= e->m[i][j] * x[j];
        x[i] /= e->m[i][i];
    }
}

/* Solves A x = b, or A' x = b, in place. Returns false if A is singular. */
static bool solve6(double a[6][6], bool transposed, double x[6]) {
    struct elimination e;
    if (!eliminate(a, transposed, &e)) return false;
    substitute(&e, x);
    return true;
}

/* Moves position and attitude by a small displacement d: translation of the origin and rotation
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

/* Finds the pose with these leg lengths by Newton's method. */
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

/* Returns the speed below which a leg may be held. It is the largest of INVERSE_DYNAMICS_SLOW_MPS,
 * the speed that the leg reaches within resolution_s after a reversal, and SPEED_STDS times the
 * speed's noise. */
static double slow_mps(const struct inverse_dynamics *d, int leg, double acceleration) {
    return fmax(fmax(fabs(acceleration) * d->resolution_s, SPEED_STDS * d->speed_std_mps[leg]), INVERSE_DYNAMICS_SLOW_MPS);
}

/* Share of sliding friction in a leg's dry friction: 0 below the slow speed, 1 from twice that
 * speed on, where the leg surely slides. */
static double sliding_share(const struct inverse_dynamics *d, int leg, const struct inverse_dynamics_input *in) {
    double speed = fabs(in->leg[leg][1] + in->ahead[leg][1]), acceleration = in->leg[leg][2] + in->ahead[leg][2];
    return fmin(fmax(speed / slow_mps(d, leg, acceleration) - 1.0, 0.0), 1.0);
}

/* Dry friction of a leg that may be held. A leg that sticks resists any load, so its friction is
 * the balance of forces, up to the limit F. The balance is noisy, and the friction of a held leg
 * may be anywhere within +-F, with variance F^2 / 3. So the result lies between sliding friction
 * and balance: the share F^2 / 3 / (F^2 / 3 + noise^2) of their difference is added to sliding
 * friction. The limit includes the harmonics' Gibbs overshoot; a limit of F would cut the balance's
 * ringing on one side only, and fitted friction would be 1 to 4 % too large. */
static double held_friction(double balance_n, double noise_n, double extend_n, double retract_n, double sliding_n) {
    double reach_n = 0.5 * (extend_n + retract_n), variance = reach_n * reach_n / 3.0;
    double gain = variance > 0.0 ? variance / (variance + noise_n * noise_n) : 0.0;
    return fmin(fmax(sliding_n + gain * (balance_n - sliding_n), -OVERSHOOT * retract_n), OVERSHOOT * extend_n);
}

double inverse_dynamics_friction(const struct inverse_dynamics *d, int leg, const struct inverse_dynamics_input *in, double balance_n) {
    struct cylinder_state s = {.p1_pa = in->p1_pa[leg], .p2_pa = in->p2_pa[leg], .deflection = in->deflection[leg]};
    double motion[3];
    for (int i = 0; i < 3; i++) motion[i] = in->leg[leg][i] + in->ahead[leg][i];
    double sign = inverse_dynamics_direction(motion[1], motion[2], d->window_s), speed = fabs(motion[1]);
    struct friction extend = cylinder_friction(&d->cylinder, leg, &s, 1, speed);
    struct friction retract = cylinder_friction(&d->cylinder, leg, &s, -1, speed);
    double other = (motion[1] > 0.0 ? extend.viscous : -retract.viscous) + extend.elastic;
    double sliding = 0.5 * (1.0 + sign) * extend.dry - 0.5 * (1.0 - sign) * retract.dry;
    double held = held_friction(balance_n - other, d->force_std_n[leg], extend.dry, retract.dry, sliding);
    double share = d->slides ? 1.0 : sliding_share(d, leg, in);
    return other + share * sliding + (1.0 - share) * held;
}

double inverse_dynamics_held_variance(const struct inverse_dynamics *d, int leg, const struct inverse_dynamics_input *in) {
    struct cylinder_state s = {.p1_pa = in->p1_pa[leg], .p2_pa = in->p2_pa[leg], .deflection = in->deflection[leg]};
    double speed = fabs(in->leg[leg][1] + in->ahead[leg][1]), share = sliding_share(d, leg, in);
    double limit_n = 0.5 *
                     (cylinder_friction(&d->cylinder, leg, &s, 1, speed).dry + cylinder_friction(&d->cylinder, leg, &s, -1, speed).dry);
    /* half of the second moment of a uniform density about one of its ends, (1 + 1/3) limit^2 */
    return square(1.0 - share) * square(limit_n) * 2.0 / 3.0;
}

bool inverse_dynamics_move(struct inverse_dynamics *d, const double leg[LEGS][3], struct rigid_legs *legs, double j[LEGS][DOFS],
                           double acceleration[DOFS]) {
    struct elimination e;
    if (!find_pose(d, leg, legs, j) || !eliminate(j, false, &e)) return false;
    for (int k = 0; k < LEGS; k++) d->state.twist[k] = leg[k][1];
    substitute(&e, d->state.twist);
    rigid_legs(&d->rigid, &d->state, legs);
    for (int k = 0; k < LEGS; k++) {
        acceleration[k] = leg[k][2];
        for (int i = 0; i < 3; i++)
            acceleration[k] -= legs->n[i][k] * legs->centripetal[i][k] + legs->across[i][k] * legs->across[i][k] / legs->length[k];
    }
    substitute(&e, acceleration);
    return true;
}

bool inverse_dynamics_bodies(struct inverse_dynamics *d, const double leg[LEGS][3], struct rigid_legs *legs, double j[LEGS][DOFS],
                             double acceleration[DOFS], double wrench[DOFS]) {
    double mass[DOFS][DOFS], load[DOFS];
    if (!inverse_dynamics_move(d, leg, legs, j, acceleration)) return false;
    rigid_dynamics(&d->rigid, &d->state, legs, mass, load);
    for (int i = 0; i < DOFS; i++) {
        wrench[i] = -load[i];
        for (int c = 0; c < DOFS; c++) wrench[i] += (i >= c ? mass[i][c] : mass[c][i]) * acceleration[c];
    }
    return true;
}

bool inverse_dynamics_along_legs(double j[LEGS][DOFS], double wrench[DOFS]) { return solve6(j, true, wrench); }

bool inverse_dynamics_unit_wrenches(double j[LEGS][DOFS], double force_n[DOFS][LEGS]) {
    struct elimination e;
    double x[LEGS][DOFS]; /* all right-hand sides side by side, so that sums vectorise */
    if (!eliminate(j, true, &e)) return false;
    for (int k = 0; k < LEGS; k++)
        for (int i = 0; i < DOFS; i++) x[k][i] = i == k;
    for (int k = 0; k < LEGS; k++)
        for (int i = 0; i < DOFS; i++) {
            double swap = x[k][i];
            x[k][i] = x[e.pivot[k]][i], x[e.pivot[k]][i] = swap;
        }
    for (int k = 0; k < LEGS; k++)
        for (int l = k + 1; l < LEGS; l++) add6(-e.m[l][k], x[k], x[l]);
    for (int k = LEGS - 1; k >= 0; k--) {
        for (int l = k + 1; l < LEGS; l++) add6(-e.m[k][l], x[l], x[k]);
        for (int i = 0; i < DOFS; i++) force_n[i][k] = x[k][i] /= e.m[k][k];
    }
    return true;
}

bool inverse_dynamics_step(struct inverse_dynamics *d, const struct inverse_dynamics_input *in, double force_n[LEGS]) {
    struct rigid_legs legs;
    if (!params_mechanism(d->params)->forces(d, in, &legs, force_n)) return false;
    for (int k = 0; k < params_legs(d->params); k++) force_n[k] += inverse_dynamics_friction(d, k, in, in->push_n[k] - force_n[k]);
    return true;
}

/* Deflection of a leg's seals at an instant, as a linear function of their deflection `first`
 * before the first instant: at + left * first. */
struct seals {
    double at, left;
};

/* Slides the seals by way_m: updates `now`, and adds the mean deflection over this path to `sum`,
 * weighted by `share`, the share of the time that the path takes. */
static void slide(double way_m, double distance_m, double share, struct seals *now, struct seals *sum) {
    double ratio = fabs(way_m) / distance_m, to = copysign(1.0, way_m), mean = ratio > 0.0 ? -expm1(-ratio) / ratio : 1.0;
    sum->at += share * (to + (now->at - to) * mean), sum->left += share * now->left * mean;
    now->at = to + (now->at - to) * exp(-ratio), now->left *= exp(-ratio);
}

/* Slides the seals for time_s, within which the rod may reverse, and updates `now`. Returns the
 * mean deflection. */
static struct seals slide_on(double speed, double acceleration, double time_s, double distance_m, struct seals *now) {
    double first = speed - 0.5 * acceleration * time_s, last = speed + 0.5 * acceleration * time_s;
    double before = first * last < 0.0 ? first / (first - last) : 0.0;
    struct seals mean = {0};
    if (before > 0.0) slide(0.5 * first * before * time_s, distance_m, before, now, &mean);
    slide((before > 0.0 ? 0.5 * last : speed) * (1.0 - before) * time_s, distance_m, 1.0 - before, now, &mean);
    return mean;
}

/* Speed of a leg's rod in its cylinder. */
static double rod_speed(const struct inverse_dynamics_input *in, int leg) { return in->leg[leg][1] + in->ahead[leg][1]; }

/* Follows a leg's seals along its motion. course: mean deflection about each instant. Returns the
 * deflection at the end. */
static struct seals run_seals(const struct inverse_dynamics *d, int leg, int instants, const struct inverse_dynamics_input in[],
                              struct seals course[PHASES]) {
    double square = 0.0;
    struct seals now = {.left = 1.0};
    for (int i = 0; i < instants; i++) square += pow(rod_speed(&in[i], leg), 2.0) / instants;
    for (int i = 0; i < instants; i++) {
        double speed = rod_speed(&in[i], leg), acceleration = in[i].leg[leg][2] + in[i].ahead[leg][2];
        bool moves = fabs(speed) + 0.5 * d->window_s * fabs(acceleration) > STILL * sqrt(square);
        course[i] = moves ? slide_on(speed, acceleration, d->window_s, d->cylinder.leg[leg].seal_distance_m, &now) : now;
    }
    return now;
}

/* Force that the balance of forces leaves for a leg's seals. sure: set if no other dry friction may
 * hold the leg. */
static double left_for_seals(const struct inverse_dynamics *d, int leg, const struct inverse_dynamics_input *in, double force_n,
                             bool *sure) {
    struct inverse_dynamics_input without = *in;
    struct cylinder_state s = {.p1_pa = in->p1_pa[leg], .p2_pa = in->p2_pa[leg]};
    double dry_n = cylinder_friction(&d->cylinder, leg, &s, 1, 0.0).dry + cylinder_friction(&d->cylinder, leg, &s, -1, 0.0).dry;
    *sure = !(dry_n > 0.0) || sliding_share(d, leg, in) >= 1.0;
    without.deflection[leg] = 0.0;
    return in->push_n[leg] - force_n - inverse_dynamics_friction(d, leg, &without, 0.0);
}

/* Finds a leg's first deflection by least squares over the forces left for its seals, with a prior
 * of variance 1/3 (uniform from -1 to 1). The seal's force may differ by direction, so the passes
 * repeat the fit with the sign of the deflection that the pass before found. */
static double first_deflection(const struct inverse_dynamics *d, int leg, int instants, const struct seals course[PHASES],
                               const double left_n[PHASES], const bool sure[PHASES]) {
    struct cylinder_state in = {.deflection = -1.0}, out = {.deflection = 1.0};
    double retract_n = cylinder_seal_force(&d->cylinder, leg, &in), extend_n = -cylinder_seal_force(&d->cylinder, leg, &out), first = 0.0;
    for (int pass = 0; pass < PASSES; pass++) {
        double product = 0.0, square = 3.0 * pow(d->force_std_n[leg], 2.0);
        for (int i = 0; i < instants && course[i].left > FORGOTTEN; i++) {
            double sense = pass ? course[i].at + first * course[i].left : left_n[i], most_n = sense > 0.0 ? extend_n : retract_n;
            if (!sure[i]) continue;
            product += most_n * course[i].left * (left_n[i] - most_n * course[i].at);
            square += pow(most_n * course[i].left, 2.0);
        }
        first = square > 0.0 ? fmin(fmax(product / square, -1.0), 1.0) : 0.0;
    }
    return first;
}

/* Finds the first deflection of each leg's seals. Returns false if no pose has these lengths. */
static bool find_first(struct inverse_dynamics *d, int instants, struct seals (*course)[PHASES], const struct inverse_dynamics_input in[],
                       double first[LEGS]) {
    double force_n[LEGS], left_n[LEGS][PHASES];
    bool sure[LEGS][PHASES];
    struct rigid_legs rods;
    bool more = true;
    for (int i = 0; i < instants && more; i++) {
        if (!params_mechanism(d->params)->forces(d, &in[i], &rods, force_n)) return false;
        more = false;
        for (int k = 0; k < params_legs(d->params); k++) {
            left_n[k][i] = left_for_seals(d, k, &in[i], force_n[k], &sure[k][i]);
            more = more || (d->cylinder.leg[k].seal_distance_m > 0.0 && course[k][i].left > FORGOTTEN);
        }
    }
    for (int k = 0; k < params_legs(d->params); k++)
        if (d->cylinder.leg[k].seal_distance_m > 0.0) first[k] = first_deflection(d, k, instants, course[k], left_n[k], sure[k]);
    return true;
}

bool inverse_dynamics_seals(struct inverse_dynamics *d, int instants, bool cycle, struct inverse_dynamics_input in[]) {
    struct seals course[LEGS][PHASES];
    double first[LEGS] = {0};
    bool any = false;
    for (int k = 0; k < params_legs(d->params); k++) {
        if (!(d->cylinder.leg[k].seal_distance_m > 0.0)) continue;
        struct seals end = run_seals(d, k, instants, in, course[k]);
        /* the deflection at the cycle's end equals that at its start */
        if (cycle && end.left < 1.0) first[k] = fmin(fmax(end.at / (1.0 - end.left), -1.0), 1.0);
        any = true;
    }
    if (any && !cycle && !find_first(d, instants, course, in, first)) return false;
    for (int k = 0; k < params_legs(d->params); k++)
        for (int i = 0; i < instants && d->cylinder.leg[k].seal_distance_m > 0.0; i++)
            in[i].deflection[k] = course[k][i].at + first[k] * course[k][i].left;
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
