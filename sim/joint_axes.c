#include "joint_axes.h"

#include <stddef.h>

#include "vec.h"

/* A leg's upper joint at this instant. */
struct tip {
    double n[3], n_rate[3], rho[3], v[3], centripetal[3];
    double length, rate;
};

static struct tip tip_of(const struct rigid_legs *legs, int leg) {
    struct tip t = {.length = legs->length[leg], .rate = legs->rate[leg]};
    for (int i = 0; i < 3; i++) {
        t.n[i] = legs->n[i][leg];
        t.rho[i] = legs->rho[i][leg];
        t.n_rate[i] = legs->across[i][leg] / t.length;
        t.v[i] = legs->across[i][leg] + t.rate * t.n[i];
        t.centripetal[i] = legs->centripetal[i][leg];
    }
    return t;
}

/* Computes the row of an axis d, so that row . twist is the rate about d: (n x v / L - w) . d = v .
 * (d x n) / L - w . d. For a joint at the base w is zero and is given as NULL. Returns the
 * acceleration about d while the twist is constant. */
static double axis_row(const struct tip *t, const double d[3], const double d_rate[3], const double *w, double row[DOFS]) {
    double lever[3], turned[3], swung[3], change = 0.0;
    cross3(d, t->n, lever);
    cross3(d_rate, t->n, turned);
    cross3(d, t->n_rate, swung);
    for (int i = 0; i < 3; i++) {
        row[i] = lever[i] / t->length;
        change += t->centripetal[i] * row[i] + t->v[i] * ((turned[i] + swung[i]) / t->length - row[i] * t->rate / t->length);
    }
    cross3(t->rho, row, row + 3);
    if (!w) return change;
    for (int i = 0; i < 3; i++) row[3 + i] -= d[i];
    return change - dot3(w, d_rate);
}

/* Computes the rows of both axes of a joint. first: its first axis, which turns with angular
 * velocity w; NULL: w is zero. */
static void joint_rows(const struct tip *t, const double first[3], const double *w, double row[2][DOFS], double bias[2]) {
    double first_rate[3] = {0}, d1[3], d2[3], d1_rate[3], d2_rate[3], turned[3], swung[3];
    if (w) cross3(w, first, first_rate);
    double c = dot3(t->n, first), c_rate = dot3(t->n_rate, first) + dot3(t->n, first_rate);
    /* shrink is -sdot/s; the bound only avoids a division by zero if a leg lies along its first
     * axis */
    double s_squared = fmax(1.0 - c * c, 1e-4), s = sqrt(s_squared), shrink = c * c_rate / s_squared;
    cross3(first, t->n, d2);
    cross3(first_rate, t->n, turned);
    cross3(first, t->n_rate, swung);
    for (int i = 0; i < 3; i++) {
        d1[i] = (first[i] - c * t->n[i]) / s_squared;
        d1_rate[i] = (first_rate[i] - c * t->n_rate[i] - c_rate * t->n[i]) / s_squared + 2.0 * shrink * d1[i];
        d2[i] /= s;
        d2_rate[i] = (turned[i] + swung[i]) / s + shrink * d2[i];
    }
    bias[0] = axis_row(t, d1, d1_rate, w, row[0]);
    bias[1] = axis_row(t, d2, d2_rate, w, row[1]);
}

void joint_axes(const struct rigid_model *m, const struct rigid_state *s, const struct rigid_legs *legs, struct joint_axes *axes) {
    for (int leg = 0; leg < LEGS; leg++) {
        struct tip t = tip_of(legs, leg);
        int at = JOINT_AXES_PER_LEG * leg;
        double platform_axis[3];
        for (int i = 0; i < 3; i++) platform_axis[i] = dot3(legs->rotation[i], m->geometry.upper_axis[leg]);
        joint_rows(&t, m->geometry.lower_axis[leg], NULL, axes->row + at, axes->bias + at);
        joint_rows(&t, platform_axis, s->twist + 3, axes->row + at + 2, axes->bias + at + 2);
    }
}
