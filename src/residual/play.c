#include "play.h"

#include <math.h>
#include <string.h>

#include "dense.h"

static const double SURE = 3.0; /* standard deviations of a push */

/* At every instant: the balance of forces and what the rods push with. */
struct balance {
    int side[LEGS];                  /* flank: 1, the rod pushes; -1, it pulls; 0, it may
                                      * be loose */
    double short_n[LEGS];            /* measured, less what the motion needs */
    double inertia[LEGS][LEGS];      /* of the platform along the legs, without the rods */
    double ahead_mps2[LEGS];
};

static bool balance(struct inverse_dynamics *d, const struct inverse_dynamics_input *in, const double std_n[LEGS], struct balance *b) {
    double bodies_n[LEGS], friction_n[LEGS], rod_n[LEGS];
    if (!inverse_dynamics_split(d, in, bodies_n, friction_n)) return false;
    inverse_dynamics_rods(d, in, rod_n);
    inverse_dynamics_inertia(d, b->inertia);
    for (int k = 0; k < LEGS; k++) {
        double push_n = in->push_n[k] - friction_n[k] - rod_n[k];
        b->short_n[k] = in->push_n[k] - friction_n[k] - bodies_n[k];
        b->inertia[k][k] -= d->rigid.upper_mass[k];
        b->side[k] = fabs(push_n) < SURE * std_n[k] ? 0 : push_n < 0.0 ? -1 : 1;
    }
    return true;
}

/* The sign at an instant is sure where it is the same before and after. */
static void blur(const struct play_motion *m, int leg, struct balance b[PHASES]) {
    int sure[PHASES], reach = (int)lround(m->resolution_s / m->step_s);
    for (int i = 0; i < m->phases; i++) {
        sure[i] = b[i].side[leg];
        for (int j = i - reach; j <= i + reach; j++) {
            int at = m->cycle ? (j + m->phases) % m->phases : j < 0 ? 0 : j < m->phases ? j : m->phases - 1;
            if (b[at].side[leg] != b[i].side[leg]) sure[i] = 0;
        }
    }
    for (int i = 0; i < m->phases; i++) b[i].side[leg] = sure[i];
}

/* Of the legs that may be loose; the others do not move in their joints. */
static void accelerate(const struct machine *machine, struct balance *b) {
    double a[LEGS * LEGS], x[LEGS];
    int leg[LEGS], n = 0;
    for (int k = 0; k < LEGS; k++)
        if (machine_has_play(machine, k) && b->side[k] == 0) leg[n++] = k;
    for (int i = 0; i < n; i++) {
        x[i] = -b->short_n[leg[i]];
        for (int j = 0; j <= i; j++) a[i * n + j] = b->inertia[leg[i]][leg[j]];
    }
    memset(b->ahead_mps2, 0, sizeof b->ahead_mps2);
    if (!dense_factor(n, n, a)) return;
    dense_solve(n, n, a, x);
    for (int i = 0; i < n; i++) b->ahead_mps2[leg[i]] = x[i];
}

/* Between two instants at a flank, `steps` apart: the acceleration integrated twice, and moved and
 * turned so that it begins and ends there. */
static void cross(const struct play_motion *m, const struct balance b[PHASES], int leg, int from, int steps, double half_m,
                  double ahead_m[PHASES][LEGS]) {
    double way[PHASES + 1] = {0}, speed = 0.0;
    int to = (from + steps) % m->phases;
    double begin_m = half_m * b[from].side[leg], end_m = half_m * b[to].side[leg];
    for (int i = 1; i <= steps; i++) {
        way[i] = way[i - 1] + m->step_s * speed;
        speed += m->step_s * b[(from + i) % m->phases].ahead_mps2[leg];
    }
    for (int i = 0; i < steps; i++) {
        double place_m = begin_m + way[i] + (end_m - begin_m - way[steps]) * i / steps;
        ahead_m[(from + i) % m->phases][leg] = fmin(fmax(place_m, -half_m), half_m);
    }
}

/* From flank to flank. Before the first and after the last of a motion that does not repeat the rod
 * is at the nearest one; where none is sure it pushes. */
static void follow(const struct play_motion *m, const struct balance b[PHASES], int leg, double half_m, double ahead_m[PHASES][LEGS]) {
    int first = 0, at;
    while (first < m->phases && b[first].side[leg] == 0) first++;
    for (int i = 0; i < m->phases; i++) ahead_m[i][leg] = first < m->phases ? half_m * b[first].side[leg] : half_m;
    if (first == m->phases) return;
    at = first;
    for (int i = first + 1; i <= (m->cycle ? first + m->phases : m->phases - 1); i++)
        if (b[i % m->phases].side[leg] != 0) {
            cross(m, b, leg, at, i - at, half_m, ahead_m);
            at = i;
        }
    for (int i = at; i < m->phases && !m->cycle; i++) ahead_m[i][leg] = half_m * b[at].side[leg];
}

bool play_find(const struct params *model, const struct play_motion *m, double ahead_m[PHASES][LEGS]) {
    struct inverse_dynamics d;
    struct balance b[PHASES];
    const struct machine *machine = &d.cylinder.machine;
    inverse_dynamics_init(&d, model, m->step_s, 0.0);
    memset(ahead_m, 0, PHASES * sizeof ahead_m[0]);
    for (int i = 0; i < m->phases; i++)
        if (!balance(&d, &m->at[i], m->force_std_n, &b[i])) return false;
    for (int k = 0; k < LEGS; k++) blur(m, k, b);
    for (int i = 0; i < m->phases; i++) accelerate(machine, &b[i]);
    for (int k = 0; k < LEGS; k++)
        if (machine_has_play(machine, k)) follow(m, b, k, 0.5 * machine->bodies.clearance_m[k], ahead_m);
    return true;
}
