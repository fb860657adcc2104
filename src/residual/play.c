#include "play.h"

#include <math.h>
#include <string.h>

#include "dense.h"
#include "mechanism.h"

static const double FORCE_STDS = 3.0; /* the sign of a contact force is uncertain if the force is
                                       * less than this many of its standard deviations */
static const double SEEN = 1.2;    /* the path is used only if a rod's rms place in the backlash is
                                    * at least this times the noise of the path; see seen() */
static const double RIPPLE = 0.06; /* the sign of a contact force is uncertain if the force is less
                                    * than this share of the largest one: beside a knock the series
                                    * rings by 5 % of the jump (Gibbs) */

struct instant {
    int flank[LEGS];                 /* 1: the rod pushes; -1: the rod pulls; 0: its joint may be
                                      * loose */
    double contact_n[LEGS];          /* force of the rod on the platform */
    double imbalance_n[LEGS];
    double inertia[LEGS][LEGS];      /* inertia of the platform along the legs, without the rods */
    double ahead_mps2[LEGS];
    double response[LEGS][LEGS];     /* by how much ahead_mps2 of one leg (row) falls for each
                                      * newton of another leg's imbalance (column) */
};

/* Finds contact force, imbalance and inertia at an instant. The friction of a held leg is assumed
 * to balance the rod alone, because the joint may be loose. Returns false if no pose has these
 * lengths. */
static bool look(struct inverse_dynamics *d, const struct inverse_dynamics_input *in, struct instant *now) {
    struct rigid_legs legs;
    double bodies_n[LEGS];
    if (!params_mechanism(d->params)->forces(d, in, &legs, bodies_n)) return false;
    inverse_dynamics_inertia(d, now->inertia);
    for (int k = 0; k < LEGS; k++) {
        double rod_n = rigid_rod_force(&d->rigid, &legs, k, in->leg[k][0], in->leg[k][2]);
        double driven_n = in->push_n[k] - inverse_dynamics_friction(d, k, in, in->push_n[k] - rod_n);
        now->contact_n[k] = driven_n - rod_n;
        now->imbalance_n[k] = driven_n - bodies_n[k];
        now->inertia[k][k] -= d->rigid.upper_mass[k];
    }
    return true;
}

static void tell_flanks(const struct play_motion *m, int leg, double std_n, struct instant at[PHASES]) {
    double least_n = FORCE_STDS * std_n;
    for (int i = 0; i < m->phases; i++) least_n = fmax(least_n, RIPPLE * fabs(at[i].contact_n[leg]));
    for (int i = 0; i < m->phases; i++) {
        double contact_n = at[i].contact_n[leg];
        at[i].flank[leg] = fabs(contact_n) < least_n ? 0 : contact_n < 0.0 ? -1 : 1;
    }
}

/* Marks a leg's flank as unsure (0) at instants within resolution_s of a change of flank. */
static void leave_unsure(const struct play_motion *m, int leg, struct instant at[PHASES]) {
    int flank[PHASES], reach = (int)lround(m->resolution_s / m->step_s);
    for (int i = 0; i < m->phases; i++) {
        flank[i] = at[i].flank[leg];
        for (int j = i - reach; j <= i + reach; j++) {
            int place = m->cycle ? (j + m->phases) % m->phases : j < 0 ? 0 : j < m->phases ? j : m->phases - 1;
            if (at[place].flank[leg] != at[i].flank[leg]) flank[i] = 0;
        }
    }
    for (int i = 0; i < m->phases; i++) at[i].flank[leg] = flank[i];
}

/* Finds the accelerations in the joints of the legs that may be loose; legs at a flank do not move
 * in their joints. */
static void accelerate(const struct machine *machine, struct instant *now) {
    double a[LEGS * LEGS], x[LEGS];
    int leg[LEGS], n = 0;
    for (int k = 0; k < LEGS; k++)
        if (machine_has_play(machine, k) && now->flank[k] == 0) leg[n++] = k;
    for (int i = 0; i < n; i++) {
        x[i] = -now->imbalance_n[leg[i]];
        for (int j = 0; j <= i; j++) a[i * n + j] = now->inertia[leg[i]][leg[j]];
    }
    memset(now->ahead_mps2, 0, sizeof now->ahead_mps2);
    memset(now->response, 0, sizeof now->response);
    if (!dense_factor(n, n, a)) return;
    dense_solve(n, n, a, x);
    for (int i = 0; i < n; i++) now->ahead_mps2[leg[i]] = x[i];
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < n; i++) x[i] = i == j;
        dense_solve(n, n, a, x);
        for (int i = 0; i < n; i++) now->response[leg[i]][leg[j]] = x[i];
    }
}

/* Mean square noise of a leg's path between two flanks. The length noise of other legs is left out;
 * that of legs which are loose at the same time cancels, since M_uu^-1 M_uu = 1. */
static double way_noise_m2(const struct play_motion *m, const struct instant at[PHASES], int leg, int from, int steps) {
    double sum = m->noise->length_m2[steps][leg];
    for (int k = 0; k < LEGS; k++)
        for (int i = 1; i < steps; i++)
            sum += pow(at[(from + i) % m->phases].response[leg][k], 2.0) / (steps - 1) * m->noise->push_n2s4[steps][k];
    return sum;
}

/* Share s, 0..1, of the integrated path that is used. noise_m2: mean square noise of the path.
 * far_m: how far the rod goes; half the backlash if it crosses to the other flank.
 * The path follows the noise of the residuals: if the noise of the forces is white, the path lowers
 * the residuals' sum of squares by the share 2 s - 5/3 s^2, so that a joint without backlash would
 * seem to have some. A rod that crosses raises the sum again: its straight path alone adds the
 * share 0.27 r^2, where r^2 is the mean square of a place in the backlash, half^2 / 3, divided by
 * the noise's mean square. With s rising from 0 at r = 1.2 to 1 at r = 2.4, a crossing adds more
 * than following the noise takes off. A rod that returns to its flank adds nothing, so its path
 * must itself go that far from the flank. */
static double seen(double noise_m2, double far_m) {
    double least_m = SEEN * sqrt(3.0 * noise_m2);
    return least_m > 0.0 ? fmin(fmax(far_m / least_m - 1.0, 0.0), 1.0) : 1.0;
}

/* Integrates the acceleration of a rod in its joint twice between two instants at a flank, `steps`
 * apart, and tilts the path so that it begins and ends at the flanks. A path that noise would hide
 * becomes straight. */
static void integrate(const struct play_motion *m, const struct instant at[PHASES], int leg, int from, int steps, double half_m,
                      double ahead_m[PHASES][LEGS]) {
    double way_m[PHASES + 1] = {0}, speed = 0.0, last_m, away_m = 0.0;
    int begin = at[from].flank[leg], end = at[(from + steps) % m->phases].flank[leg];
    for (int i = 1; i <= steps; i++) {
        way_m[i] = way_m[i - 1] + m->step_s * speed;
        speed += m->step_s * at[(from + i) % m->phases].ahead_mps2[leg];
    }
    last_m = way_m[steps];
    for (int i = 1; i <= steps; i++) way_m[i] -= last_m * i / steps, away_m = fmax(away_m, -begin * way_m[i]);
    double share = seen(way_noise_m2(m, at, leg, from, steps), begin == end ? fmin(half_m, away_m) : half_m);
    for (int i = 0; i < steps; i++) {
        double place_m = half_m * (begin + (double)(end - begin) * i / steps) + share * way_m[i];
        ahead_m[(from + i) % m->phases][leg] = fmin(fmax(place_m, -half_m), half_m);
    }
}

/* Follows a rod from flank to flank. In a motion that does not repeat, the rod is assumed to stay
 * on its first known flank before the first instant at which a flank is known, and on its last
 * known flank after the last such instant. If no flank is sure, the rod pushes. */
static void follow(const struct play_motion *m, const struct instant at[PHASES], int leg, double half_m, double ahead_m[PHASES][LEGS]) {
    int first = 0, last;
    while (first < m->phases && at[first].flank[leg] == 0) first++;
    for (int i = 0; i < m->phases; i++) ahead_m[i][leg] = first < m->phases ? half_m * at[first].flank[leg] : half_m;
    if (first == m->phases) return;
    last = first;
    for (int i = first + 1; i <= (m->cycle ? first + m->phases : m->phases - 1); i++)
        if (at[i % m->phases].flank[leg] != 0) {
            integrate(m, at, leg, last, i - last, half_m, ahead_m);
            last = i;
        }
    for (int i = last; i < m->phases && !m->cycle; i++) ahead_m[i][leg] = half_m * at[last].flank[leg];
}

bool play_find(struct inverse_dynamics *d, const struct play_motion *m, double ahead_m[PHASES][LEGS]) {
    struct instant at[PHASES];
    const struct machine *machine = &d->cylinder.machine;
    memset(ahead_m, 0, PHASES * sizeof ahead_m[0]);
    for (int i = 0; i < m->phases; i++)
        if (!look(d, &m->at[i], &at[i])) return false;
    for (int k = 0; k < LEGS; k++) tell_flanks(m, k, d->force_std_n[k], at), leave_unsure(m, k, at);
    for (int i = 0; i < m->phases; i++) accelerate(machine, &at[i]);
    for (int k = 0; k < LEGS; k++)
        if (machine_has_play(machine, k)) follow(m, at, k, 0.5 * machine->bodies.clearance_m[k], ahead_m);
    return true;
}
