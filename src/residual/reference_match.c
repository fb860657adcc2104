#include "reference_match.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "leg_places.h"
#include "lin.h"
#include "numeric.h"
#include "params.h"
#include "units.h"

const char *const reference_names[DOFS] = {"ref_x_m", "ref_y_m", "ref_z_m", "ref_phi_rad", "ref_theta_rad", "ref_psi_rad"};

/* An axis is not judged if the reference moves the legs along it, in mean square, by less than this
 * share of the most that it moves them along any axis. */
static const double MOVED = 1e-3;
/* The lengths do not follow the reference if reference and rate explain less than FOLLOWS of the
 * lengths' squares, or if the reference alone explains less than FOLLOWS of what both explain. In
 * the second case the lengths lag by more than 45 degrees, or the explained part is noise. */
static const double FOLLOWS = 0.5;
/* Another drawing refutes the stated one if its unexplained share is less than DECISIVE times the
 * stated one's, and if the stated one's exceeds UNEXPLAINED, or MOST if work.planes is false. A
 * loop may move the other axes by 10 %, which leaves 0.01 unexplained. */
static const double UNEXPLAINED = 0.01, MOST = 0.5, DECISIVE = 0.25;
/* Drawings cannot be distinguished from the best one if the share that they leave unexplained is at
 * most ALIKE times the best one's, plus SAME. */
static const double ALIKE = 1.3, SAME = 2e-3;
/* Relative increase of the normal equations' diagonal, so that they have a solution even if axes
 * move as one. */
static const double RIDGE = 1e-9;

/* Regressor i is the reference along axis i, and regressor RATES + i its rate. */
enum { RATES = DOFS, REGRESSORS = 2 * DOFS };

struct work {
    struct kinematics drawn;    /* the drawing as it is */
    double center_m[2];         /* x and y of the mass centre in the drawing; turns are about the
                                 * drawing's z axis */
    double along[LEGS][REGRESSORS];        /* sum of a measured length times a regressor */
    double square[REGRESSORS][REGRESSORS]; /* sum of products of two regressors */
    double explainable;         /* part of the lengths' squares that the regressors explain with
                                 * free gains for each leg */
    int used, regressor[REGRESSORS]; /* regressors of axes along which the reference moves */
    bool lags[DOFS];            /* the legs' motion along this axis lags by more than 45 degrees */
    bool planes;                /* x and y move independently, and so do phi and theta */
};

/* How the drawing differs from the machine. */
struct drawing {
    struct leg_places order;
    bool mirrored;
    double angle; /* angle of the turn, rad; if mirrored, twice the angle from x to the mirror's
                   * plane */
    double share;
};

/* Turns or mirrors a list of joints back, about the z axis of the drawing. */
static void undo(const struct drawing *d, const double center_m[2], double joint[LEGS][3]) {
    double c = cos(d->angle), s = sin(d->angle), sign = d->mirrored ? -1.0 : 1.0;
    for (int k = 0; k < LEGS; k++) {
        double x = joint[k][0] + center_m[0], y = joint[k][1] + center_m[1];
        joint[k][0] = c * x + s * y - center_m[0];
        joint[k][1] = sign * (c * y - s * x) - center_m[1];
    }
}

/* Computes the machine's Jacobian at neutral, for a drawing that shows the machine turned or
 * mirrored by d. */
static void jacobian_of(const struct work *w, const struct drawing *d, double j[LEGS][DOFS]) {
    static const double neutral[DOFS] = {0};
    struct kinematics k = w->drawn;
    undo(d, w->center_m, k.upper), undo(d, w->center_m, k.lower);
    ik_jacobian(&k, neutral, j);
}

/* Solves for the gains of the regressors in `used`. Returns the sum of squares that they
 * explain. */
static double gains(const struct work *w, double (*normal)[REGRESSORS], const double with[REGRESSORS], const bool used[REGRESSORS],
                    double gain[REGRESSORS]) {
    double a[REGRESSORS * REGRESSORS] = {0}, b[REGRESSORS] = {0}, x[REGRESSORS], explained = 0.0;
    int n = 0, at[REGRESSORS];
    for (int i = 0; i < w->used; i++)
        if (used[i]) at[n++] = i;
    for (int i = 0; i < n; i++) {
        b[i] = with[at[i]];
        for (int j = 0; j < n; j++) a[i * n + j] = normal[at[i]][at[j]] * (i == j ? 1.0 + RIDGE : 1.0);
    }
    memset(gain, 0, REGRESSORS * sizeof *gain);
    if (!n) return 0.0;
    lin_solve_spd(n, 1, a, b, x);
    for (int i = 0; i < n; i++) gain[at[i]] = x[i], explained += x[i] * b[i];
    return explained;
}

/* Finds the share that a drawing leaves unexplained. against: set for the axes along which the
 * lengths move against the reference; NULL: no gain may be negative, except on an axis that
 * lags. */
static double unexplained(const struct work *w, const struct drawing *d, bool against[DOFS]) {
    double j[LEGS][DOFS], form[LEGS][REGRESSORS], normal[REGRESSORS][REGRESSORS] = {{0}}, with[REGRESSORS] = {0}, gain[REGRESSORS],
                                                  explained;
    bool used[REGRESSORS], negative = true;
    jacobian_of(w, d, j);
    for (int i = 0; i < w->used; i++) {
        int of = w->regressor[i];
        used[i] = true;
        for (int k = 0; k < LEGS; k++) {
            form[k][i] = j[k][of % DOFS];
            with[i] += form[k][i] * w->along[d->order.place[k]][of];
        }
    }
    for (int i = 0; i < w->used; i++)
        for (int other = 0; other < w->used; other++)
            for (int k = 0; k < LEGS; k++)
                normal[i][other] += form[k][i] * form[k][other] * w->square[w->regressor[i]][w->regressor[other]];
    do {
        explained = gains(w, normal, with, used, gain);
        negative = false;
        for (int i = 0; i < w->used; i++) {
            int of = w->regressor[i];
            if (of >= RATES || w->lags[of]) continue;
            if (against) against[of] = gain[i] < 0.0;
            else if (gain[i] < 0.0) used[i] = false, negative = true;
        }
    } while (negative);
    return 1.0 - explained / w->explainable;
}

static void rate(const struct work *w, struct drawing *d) { d->share = unexplained(w, d, NULL); }

/* Finds the best angle of a turn or mirror, in steps of 5 degrees and then in ever smaller ones. */
static struct drawing best_angle(const struct work *w, bool mirrored) {
    static const int steps = 72;
    static const double fine = 1e-5;
    struct leg_places common[LEG_PLACES_COMMON];
    leg_places_common(common);
    struct drawing best = {.order = common[0], .mirrored = mirrored, .share = HUGE_VAL};
    for (int i = 0; i < steps; i++) {
        struct drawing d = best;
        d.angle = 2.0 * PI * i / steps;
        rate(w, &d);
        if (d.share < best.share) best = d;
    }
    for (double step = PI / steps; step > fine; step *= 0.5)
        for (int sign = -1; sign <= 1; sign += 2) {
            struct drawing d = best;
            d.angle += sign * step;
            rate(w, &d);
            if (d.share < best.share) best = d;
        }
    return best;
}

static bool explains_more(const struct drawing *d, const struct drawing *than) { return ALIKE * d->share + SAME < than->share; }

/* Tries all orders of the legs whose first `leg` places are those of `order`. Among orders that
 * explain as much, the one with the fewest exchanges is kept. */
static void try_orders(const struct work *w, const struct leg_places *order, int leg, struct drawing *best) {
    for (int other = leg; other < LEGS; other++) {
        struct leg_places next = leg_places_exchanged(order, leg, other);
        try_orders(w, &next, leg + 1, best);
    }
    if (leg < LEGS || leg_places_stated(order)) return;
    struct drawing d = {.order = *order};
    rate(w, &d);
    bool fewer = leg_places_exchanges(&d.order) < leg_places_exchanges(&best->order);
    if (explains_more(&d, best) || (!explains_more(best, &d) && fewer)) *best = d;
}

/* Finds the best order of the legs; a common one is preferred to others that explain as much. */
static struct drawing best_order(const struct work *w) {
    struct leg_places common[LEG_PLACES_COMMON];
    struct drawing best = {.share = HUGE_VAL}, any;
    leg_places_common(common);
    for (int i = 1; i < LEG_PLACES_COMMON; i++) {
        struct drawing d = {.order = common[i]};
        rate(w, &d);
        if (d.share < best.share) best = d;
    }
    any = best;
    try_orders(w, &common[0], 0, &any);
    return explains_more(&any, &best) ? any : best;
}

/* Converts the legs' moments to moments along the axes. */
static void take_moments(struct work *w, const struct leg_moments *m, double inverse[DOFS][LEGS]) {
    for (int i = 0; i < DOFS; i++) {
        for (int a = 0; a < LEGS; a++)
            for (int b = 0; b < LEGS; b++) {
                w->along[a][i] += m->product[a][b] * inverse[i][b];
                w->along[a][RATES + i] += m->late[a][b] * inverse[i][b];
            }
        for (int j = 0; j < DOFS; j++)
            for (int a = 0; a < LEGS; a++)
                for (int b = 0; b < LEGS; b++) {
                    w->square[i][j] += inverse[i][a] * m->asked[a][b] * inverse[j][b];
                    w->square[RATES + i][j] += inverse[i][a] * m->mixed[a][b] * inverse[j][b];
                    w->square[j][RATES + i] += inverse[i][a] * m->mixed[a][b] * inverse[j][b];
                    w->square[RATES + i][RATES + j] += inverse[i][a] * m->rates[a][b] * inverse[j][b];
                }
    }
}

/* Finds w->explainable and w->lags. Returns the part of the lengths' squares that the reference
 * explains without its rate, with free gains for each leg. */
static double find_explainable(struct work *w) {
    double normal[REGRESSORS][REGRESSORS], with[REGRESSORS], gain[REGRESSORS], in_phase[DOFS] = {0}, late[DOFS] = {0}, sum = 0.0;
    bool all[REGRESSORS], values[REGRESSORS];
    for (int i = 0; i < w->used; i++) {
        all[i] = true, values[i] = w->regressor[i] < RATES;
        for (int j = 0; j < w->used; j++) normal[i][j] = w->square[w->regressor[i]][w->regressor[j]];
    }
    for (int leg = 0; leg < LEGS; leg++) {
        for (int i = 0; i < w->used; i++) with[i] = w->along[leg][w->regressor[i]];
        sum += gains(w, normal, with, values, gain);
        w->explainable += gains(w, normal, with, all, gain);
        for (int i = 0; i < w->used; i++)
            *(values[i] ? &in_phase[w->regressor[i]] : &late[w->regressor[i] - RATES]) += square(gain[i]) * normal[i][i];
    }
    for (int i = 0; i < DOFS; i++) w->lags[i] = late[i] > in_phase[i];
    return sum;
}

/* True if the reference moves along two axes independently. On a circle it does not: the motion
 * along one axis is the motion along the other with a gain and a lag. */
static bool apart(const struct work *w, const bool moved[DOFS], int one, int other) {
    const double (*s)[REGRESSORS] = w->square;
    if (!moved[one] || !moved[other]) return false;
    int rate = RATES + one;
    double a = s[one][one], b = s[one][rate], c = s[rate][rate], determinant = a * c - b * b, p = s[other][one], q = s[other][rate];
    double share = (c * p * p - 2.0 * b * p * q + a * q * q) / determinant;
    return determinant > 0.0 && share < 0.5 * s[other][other];
}

/* Prepares the comparison. Returns false if the lengths do not follow the reference at all. */
static bool work_init(struct work *w, const struct params *params, const struct leg_moments *m) {
    static const double neutral[DOFS] = {0};
    double jacobian[LEGS][DOFS], inverse[DOFS][LEGS], moves[DOFS], most = 0.0, measured = 0.0;
    bool moved[DOFS];
    memset(w, 0, sizeof *w);
    kinematics_place(&w->drawn, params);
    w->center_m[0] = params->payload.center_x_m, w->center_m[1] = params->payload.center_y_m;
    ik_jacobian(&w->drawn, neutral, jacobian);
    lin_inverse(DOFS, jacobian[0], inverse[0]);
    take_moments(w, m, inverse);
    for (int i = 0; i < DOFS; i++) {
        double length = 0.0;
        measured += m->measured[i];
        for (int a = 0; a < LEGS; a++) length += square(jacobian[a][i]);
        moves[i] = w->square[i][i] * length, most = fmax(most, moves[i]);
    }
    for (int i = 0; i < DOFS; i++) {
        moved[i] = moves[i] > MOVED * most;
        if (moved[i]) w->regressor[w->used++] = i;
        if (moved[i] && w->square[RATES + i][RATES + i] > 0.0) w->regressor[w->used++] = RATES + i;
    }
    w->planes = apart(w, moved, DOF_X, DOF_Y) && apart(w, moved, DOF_PHI, DOF_THETA);
    double in_phase = find_explainable(w);
    return w->explainable > FOLLOWS * measured && in_phase > FOLLOWS * w->explainable;
}

static double degrees(double angle) { return 180.0 / PI * remainder(angle, 2.0 * PI); }

static void describe_turn(const struct drawing *d, char *text, size_t size) {
    double turn = degrees(d->angle);
    snprintf(text, size,
             "the drawing is turned by %.1f degrees about z against the reference: turn both lists of joints by %.1f degrees, or the axes "
             "of the reference by %.1f",
             turn, -turn, turn);
}

static void describe_mirror(const struct drawing *d, char *text, size_t size) {
    double twice = degrees(d->angle);
    if (twice == 0.0 || fabs(twice) == 180.0) {
        const char *axis = twice == 0.0 ? "y" : "x";
        snprintf(
            text, size,
            "the drawing is mirrored in %s against the reference: change the sign of %s in both lists of joints, or of ref_%s_m, %s and "
            "ref_psi_rad",
            axis, axis, axis, twice == 0.0 ? "ref_phi_rad" : "ref_theta_rad");
    } else
        snprintf(
            text, size,
            "the drawing is mirrored against the reference, in the plane through z at %.1f degrees from x: mirror both lists of joints "
            "back, or the axes of the reference",
            0.5 * twice);
}

/* Replaces a mirror by a change of the sign of y or x, if this explains as much. */
static void prefer_axis(const struct work *w, struct drawing *mirror) {
    for (int i = 0; i < 2; i++) {
        struct drawing d = *mirror;
        d.angle = i * PI;
        rate(w, &d);
        if (!explains_more(mirror, &d)) *mirror = d;
    }
}

/* Writes which columns of the reference have the wrong sign. */
static void describe_signs(const bool against[DOFS], char *text, size_t size) {
    int used = 0, count = 0, named = 0;
    for (int i = 0; i < DOFS; i++) count += against[i];
    used += snprintf(text, size, "the sign%s of", count > 1 ? "s" : "");
    for (int i = 0; i < DOFS; i++)
        if (against[i]) used += snprintf(text + used, size - (size_t)used, "%s %s", named++ ? "," : "", reference_names[i]);
    snprintf(text + used, size - (size_t)used, " %s wrong", count > 1 ? "are" : "is");
}

/* Appends "; or " unless the text is empty. Returns the end of the text, and sets *left to the room
 * from there on. */
static char *or_else(char text[REFERENCE_MATCH_TEXT], size_t *left) {
    size_t used = strlen(text);
    if (used) strncat(text, "; or ", REFERENCE_MATCH_TEXT - 1 - used);
    used = strlen(text);
    *left = REFERENCE_MATCH_TEXT - used;
    return text + used;
}

void reference_match_find(const struct params *params, const struct leg_moments *m, struct reference_match *match) {
    struct work w;
    struct leg_places common[LEG_PLACES_COMMON];
    bool against[DOFS] = {false};
    char name[LEG_PLACES_NAME];
    size_t left;
    *match = (struct reference_match){0};
    if (!work_init(&w, params, m)) return;
    leg_places_common(common);
    const struct drawing stated = {.order = common[0]};
    match->stated = match->best = unexplained(&w, &stated, NULL);
    if (!(match->stated > (w.planes ? UNEXPLAINED : MOST))) return;

    struct drawing order = best_order(&w), turn = best_angle(&w, false), mirror = best_angle(&w, true);
    prefer_axis(&w, &mirror);
    match->best = fmin(order.share, fmin(turn.share, mirror.share));
    match->refuted = match->best < DECISIVE * match->stated;
    if (!match->refuted) return;

    double alike = ALIKE * match->best + SAME;
    if (order.share <= alike) {
        leg_places_name(&order.order, name);
        snprintf(match->text, REFERENCE_MATCH_TEXT, "the lengths follow the reference with %s, not as stated", name);
    }
    if (turn.share <= alike) {
        char *to = or_else(match->text, &left);
        describe_turn(&turn, to, left);
    }
    if (mirror.share <= alike) {
        char *to = or_else(match->text, &left);
        describe_mirror(&mirror, to, left);
    }
    if (mirror.share > alike && unexplained(&w, &stated, against) <= alike) {
        char *to = or_else(match->text, &left);
        describe_signs(against, to, left);
    }
}
