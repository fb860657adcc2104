#include "leg_order.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "kinematics.h"
#include "leg_places.h"
#include "lin.h"
#include "numeric.h"
#include "params.h"
#include "whiten.h"

/* Quantities of each leg whose products are summed. */
enum quantity { LENGTH, RATE, ACCELERATION, SIGN, FORCE, QUANTITIES };
enum { ALL = QUANTITIES * LEGS, BODY = 10, VISCOUS = BODY, DRY = VISCOUS + LEGS, UNKNOWNS = DRY + LEGS };
enum target { OF_LENGTHS, OF_FORCES, OF_BOTH, TARGETS };

/* Least error that any model is assumed to have, as a share of the force's rms variation. */
static const double FLOOR = 0.02;
/* PRIOR: standard deviation of each of the payload's ten inertial parameters, as a share of the
 * configured mass, moment or inertia. PRIOR_COST: rise of the unexplained share for each parameter
 * that is off by one such deviation. */
static const double PRIOR = 0.5, PRIOR_COST = 0.02;
/* An order refutes the stated one if its unexplained share is less than DECISIVE times the stated
 * order's share, and if the stated order's share exceeds UNEXPLAINED, more than any sensor's error
 * or friction causes. A stated share above 1, as with another machine, counts as 1. */
static const double DECISIVE = 0.25, UNEXPLAINED = 0.05;
/* An order cannot be distinguished from the best one if the share that it leaves unexplained is at
 * most ALIKE times the best one's, plus SAME. */
static const double ALIKE = 1.3, SAME = 1e-4;

struct leg_space {
    double legs[LEGS][LEGS];            /* inertia of the configured legs, along the legs */
    double weight[LEGS][LEGS];          /* change of the leg forces that carry the weight, per
                                         * change of the lengths, N/m: W in leg_order.h */
    double body[BODY][LEGS][LEGS];      /* inertia along the legs for one unit of each of the
                                         * payload's ten inertial parameters */
    double configured[BODY], width[BODY]; /* the payload's inertial parameters as configured, and
                                           * the standard deviations of their priors */
    double inverse[DOFS][LEGS];         /* J^-1 at neutral */
};

struct work {
    struct leg_space space;
    /* sums over all coefficients of the products of two rows, divided by the coefficient's error
     * variance */
    double product[ALL][ALL];
    double rows[ALL][RESIDUAL_SIZE];
};

static int at(enum quantity q, int leg) { return (int)q * LEGS + leg; }

/* --- machine */

/* Computes the inertia matrix of a payload with one of its ten inertial parameters equal to 1 and
 * the others 0. number: 0 mass, 1-3 first moment m c, 4-9 inertia about the origin: xx yy zz xy xz
 * yz. */
static void unit_matrix(int number, double m[DOFS][DOFS]) {
    static const int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
    memset(m, 0, DOFS * sizeof m[0]);
    if (number == 0) m[0][0] = m[1][1] = m[2][2] = 1.0;
    if (number == 1) m[1][5] = m[5][1] = 1.0, m[2][4] = m[4][2] = -1.0;
    if (number == 2) m[0][5] = m[5][0] = -1.0, m[2][3] = m[3][2] = 1.0;
    if (number == 3) m[0][4] = m[4][0] = 1.0, m[1][3] = m[3][1] = -1.0;
    if (number >= 4) {
        int r = 3 + row[number - 4], c = 3 + column[number - 4];
        m[r][c] = m[c][r] = 1.0;
    }
}

/* Converts a matrix of the platform to one along the legs: J'^-1 M J^-1. */
static void along_legs(const struct leg_space *s, double m[DOFS][DOFS], double along[LEGS][LEGS]) {
    for (int k = 0; k < LEGS; k++)
        for (int l = 0; l < LEGS; l++) {
            along[k][l] = 0.0;
            for (int i = 0; i < DOFS; i++)
                for (int j = 0; j < DOFS; j++) along[k][l] += s->inverse[i][k] * m[i][j] * s->inverse[j][l];
        }
}

/* Computes the forces along the legs that carry the weight in a pose. */
static void holding(const struct kinematics *k, const double pose[DOFS], double weight_n, double force_n[LEGS]) {
    double j[LEGS][DOFS], wrench[DOFS] = {[DOF_Z] = -weight_n};
    ik_jacobian(k, pose, j);
    lin_solve_right(LEGS, 1, &j[0][0], wrench, force_n);
}

static void find_weight(struct leg_space *s, const struct kinematics *k, const struct params *p) {
    static const double step = 1e-4;
    double weight_n = p->payload.mass_kg * p->payload.gravity_mps2, change[DOFS][LEGS];
    for (int leg = 0; leg < LEGS; leg++) weight_n += p->actuator.upper_mass_kg[leg] * p->payload.gravity_mps2;
    for (int i = 0; i < DOFS; i++) {
        double pose[DOFS] = {0}, there[LEGS], back[LEGS];
        pose[i] = step, holding(k, pose, weight_n, there);
        pose[i] = -step, holding(k, pose, weight_n, back);
        for (int leg = 0; leg < LEGS; leg++) change[i][leg] = (there[leg] - back[leg]) / (2.0 * step);
    }
    for (int a = 0; a < LEGS; a++)
        for (int b = 0; b < LEGS; b++)
            for (int i = 0; i < DOFS; i++) s->weight[a][b] += change[i][a] * s->inverse[i][b];
}

static void find_leg_space(struct leg_space *s, const struct params *configured) {
    static const double neutral[DOFS] = {0};
    struct params legs = *configured;
    struct kinematics k;
    const struct payload_params *p = &configured->payload;
    double j[LEGS][DOFS], m[DOFS][DOFS];
    kinematics_place(&k, configured);
    ik_jacobian(&k, neutral, j);
    lin_inverse(DOFS, j[0], s->inverse[0]);
    legs.payload.mass_kg = legs.payload.inertia_xx_kg_m2 = legs.payload.inertia_yy_kg_m2 = legs.payload.inertia_zz_kg_m2 = 0.0;
    legs.payload.inertia_xy_kg_m2 = legs.payload.inertia_xz_kg_m2 = legs.payload.inertia_yz_kg_m2 = 0.0;
    params_mechanism(&legs)->leg_mass(&legs, s->legs);
    find_weight(s, &k, configured);
    double inertia = (p->inertia_xx_kg_m2 + p->inertia_yy_kg_m2 + p->inertia_zz_kg_m2) / 3.0, mass = p->mass_kg;
    const double value[BODY] = {mass,
                                0.0,
                                0.0,
                                0.0,
                                p->inertia_xx_kg_m2,
                                p->inertia_yy_kg_m2,
                                p->inertia_zz_kg_m2,
                                p->inertia_xy_kg_m2,
                                p->inertia_xz_kg_m2,
                                p->inertia_yz_kg_m2};
    memcpy(s->configured, value, sizeof value);
    for (int i = 0; i < BODY; i++) {
        unit_matrix(i, m);
        along_legs(s, m, s->body[i]);
        s->width[i] = PRIOR * (i == 0 ? mass : i < 4 ? sqrt(mass * inertia) : inertia);
    }
}

/* --- products of the channels */

/* Removes the constant from a row, because a test's mean contains no information about its
 * motion. */
static void vary(const struct residual_test *t, double row[RESIDUAL_SIZE]) {
    double along = 0.0, sum = 0.0;
    for (int a = 0; a < t->size; a++) along += row[a] * t->coupling[a][0], sum += square(t->coupling[a][0]);
    for (int a = 0; a < t->size; a++) row[a] -= along / sum * t->coupling[a][0];
}

static void fill_rows(struct work *w, const struct residual_test *t) {
    const struct spectrum *s = &t->spectrum;
    memset(w->rows, 0, sizeof w->rows);
    for (int phase = 0; phase < t->phases; phase++) {
        const double *basis = t->cycle + phase * SPECTRUM_SIZE;
        for (int k = 0; k < LEGS; k++) {
            double l[3];
            spectrum_at(s->mean[CHANNEL_LENGTH][k], t->harmonics, s->omega, basis, l);
            double sign = l[1] / (fabs(l[1]) + t->speed_std_mps[k] + 1e-6);
            for (int a = 0; a < t->size; a++) {
                double add = t->project[phase][a];
                w->rows[at(LENGTH, k)][a] += add * l[0], w->rows[at(RATE, k)][a] += add * l[1];
                w->rows[at(ACCELERATION, k)][a] += add * l[2], w->rows[at(SIGN, k)][a] += add * sign;
            }
        }
    }
    for (int k = 0; k < LEGS; k++) memcpy(w->rows[at(FORCE, k)], t->row[CHANNEL_FORCE][k], sizeof w->rows[0]);
    for (int i = 0; i < ALL; i++) vary(t, w->rows[i]);
}

/* Adds a test's products of rows to the sums in struct work. The error variance of a coefficient,
 * by which they are divided, is a mean over all legs, so that no order is favoured. It contains the
 * noise of the force, the length's noise in the acceleration, and the error of any model. */
static void add_test(struct work *w, const struct residual_test *t, double lambda[LEGS][LEGS]) {
    double varies = 0.0, mass = 0.0;
    fill_rows(w, t);
    for (int k = 0; k < LEGS; k++) varies += residual_variation(t, CHANNEL_FORCE, k) / LEGS, mass += lambda[k][k] / LEGS;
    for (int a = 0; a < t->size; a++) {
        double error = square(FLOOR) * varies;
        for (int k = 0; k < LEGS; k++) {
            double length_n = mass * t->curve[a] * t->std[CHANNEL_LENGTH][k][a];
            error += (square(t->std[CHANNEL_FORCE][k][a]) + square(length_n)) / LEGS;
        }
        for (int i = 0; i < ALL && error > 0.0; i++)
            for (int j = 0; j < ALL; j++) w->product[i][j] += w->rows[i][a] * w->rows[j][a] / error;
    }
}

/* --- share of the force that an order of the legs leaves unexplained */

/* A form is a weighted sum of one quantity of all six legs; a row of a matrix holds its weights.
 * Returns the sum of the products of two forms over all evaluated coefficients (struct work,
 * product). The first form has quantity p and the weights `one`; the second has quantity q and the
 * weights `other`. */
static double between(const struct work *w, const double *one, enum quantity p, const double *other, enum quantity q,
                      const struct leg_places *lengths) {
    double sum = 0.0;
    for (int i = 0; i < LEGS; i++)
        for (int j = 0; j < LEGS; j++) sum += one[i] * other[j] * w->product[at(p, lengths->place[i])][at(q, lengths->place[j])];
    return sum;
}

/* One unit of an unknown puts a force on a leg that is a form (see between()). Returns the weights
 * of this form, and sets *q to its quantity. */
static const double *form_of(const struct leg_space *s, int unknown, int leg, double unit[LEGS], enum quantity *q) {
    memset(unit, 0, LEGS * sizeof *unit);
    *q = unknown < BODY ? ACCELERATION : unknown < DRY ? RATE : SIGN;
    if (unknown < BODY) return s->body[unknown][leg];
    unit[leg] = leg == (unknown - VISCOUS) % LEGS;
    return unit;
}

/* The target of a leg is the force that the unknowns must explain: its measured force less the
 * forces of the configured legs and weight. Returns the sum of the products of a form and this
 * target. */
static double with_target(const struct work *w, const double *form, enum quantity q, int leg, const struct leg_places *lengths,
                          const struct leg_places *forces) {
    double sum = 0.0;
    for (int i = 0; i < LEGS; i++) sum += form[i] * w->product[at(q, lengths->place[i])][at(FORCE, forces->place[leg])];
    return sum - between(w, form, q, w->space.legs[leg], ACCELERATION, lengths) -
           between(w, form, q, w->space.weight[leg], LENGTH, lengths);
}

/* Returns the sum of the squares of the target of a leg (see with_target()). */
static double target_square(const struct work *w, int leg, const struct leg_places *lengths, const struct leg_places *forces) {
    const double *legs = w->space.legs[leg], *weight = w->space.weight[leg];
    int f = at(FORCE, forces->place[leg]);
    double sum = w->product[f][f] + between(w, legs, ACCELERATION, legs, ACCELERATION, lengths) +
                 between(w, weight, LENGTH, weight, LENGTH, lengths) + 2.0 * between(w, legs, ACCELERATION, weight, LENGTH, lengths);
    for (int i = 0; i < LEGS; i++)
        sum -= 2.0 *
               (legs[i] * w->product[at(ACCELERATION, lengths->place[i])][f] + weight[i] * w->product[at(LENGTH, lengths->place[i])][f]);
    return sum;
}

/* Share of the varying force that an order leaves unexplained, plus the prior's penalty on the
 * payload that is fitted for this order. 1 if the fit is singular. */
static double unexplained(const struct work *w, const struct leg_places *lengths, const struct leg_places *forces) {
    const struct leg_space *s = &w->space;
    double normal[UNKNOWNS * UNKNOWNS] = {0}, with[UNKNOWNS] = {0}, left = 0.0, whole = 0.0;
    for (int k = 0; k < LEGS; k++) {
        whole += w->product[at(FORCE, k)][at(FORCE, k)];
        left += target_square(w, k, lengths, forces);
    }
    for (int c = 0; c < UNKNOWNS; c++)
        for (int k = 0; k < LEGS; k++) {
            double unit[LEGS], other[LEGS];
            enum quantity p, q;
            if (c >= BODY && k != (c - VISCOUS) % LEGS) continue;
            const double *form = form_of(s, c, k, unit, &p);
            with[c] += with_target(w, form, p, k, lengths, forces);
            for (int d = 0; d <= c; d++) {
                if (d >= BODY && k != (d - VISCOUS) % LEGS) continue;
                const double *second = form_of(s, d, k, other, &q);
                normal[c * UNKNOWNS + d] += between(w, form, p, second, q, lengths);
            }
        }
    for (int c = 0; c < UNKNOWNS; c++) {
        double prior = c < BODY ? PRIOR_COST * whole / square(s->width[c]) : 0.0;
        normal[c * (UNKNOWNS + 1)] += prior + 1e-9 * normal[c * (UNKNOWNS + 1)];
        if (c >= BODY) continue;
        with[c] += prior * s->configured[c];
        left += prior * square(s->configured[c]);
    }
    double x[UNKNOWNS];
    memcpy(x, with, sizeof x);
    if (!dense_factor(UNKNOWNS, UNKNOWNS, normal)) return 1.0;
    dense_solve(UNKNOWNS, UNKNOWNS, normal, x);
    for (int c = 0; c < UNKNOWNS; c++) left -= x[c] * with[c];
    return fmax(left, 0.0) / whole;
}

static double apart(const double a[3], const double b[3]) { return sqrt(square(a[0] - b[0]) + square(a[1] - b[1]) + square(a[2] - b[2])); }

/* True if the drawing with its legs in this order is the same up to a rotation or a reflection,
 * that is, if all distances between its joints are the same. */
static bool symmetric(const struct kinematics *k, const struct leg_places *order) {
    static const double same_m = 1e-4;
    for (int a = 0; a < LEGS; a++)
        for (int b = 0; b < LEGS; b++) {
            int c = order->place[a], d = order->place[b];
            if (fabs(apart(k->upper[a], k->upper[b]) - apart(k->upper[c], k->upper[d])) > same_m) return false;
            if (fabs(apart(k->lower[a], k->lower[b]) - apart(k->lower[c], k->lower[d])) > same_m) return false;
            if (fabs(apart(k->upper[a], k->lower[b]) - apart(k->upper[c], k->lower[d])) > same_m) return false;
        }
    return true;
}

static bool any_symmetry(const struct kinematics *k) {
    struct leg_places order[LEG_PLACES_COMMON];
    bool any = false;
    leg_places_common(order);
    for (int i = 1; i < LEG_PLACES_COMMON; i++) any = any || symmetric(k, &order[i]);
    return any;
}

void leg_order_symmetries(const struct params *params, char text[LEG_ORDER_TEXT]) {
    struct kinematics k;
    struct leg_places order[LEG_PLACES_COMMON];
    char name[LEG_PLACES_NAME];
    leg_places_common(order);
    kinematics_place(&k, params);
    text[0] = '\0';
    for (int i = 1; i < LEG_PLACES_COMMON; i++) {
        size_t used = strlen(text);
        if (!symmetric(&k, &order[i])) continue;
        leg_places_name(&order[i], name);
        snprintf(text + used, LEG_ORDER_TEXT - used, "%s%s", used ? "; " : "", name);
    }
}

bool leg_order_of_drawing(const struct params *params, const double length_m[LEGS], double tolerance_m, char text[LEG_ORDER_TEXT]) {
    struct kinematics k;
    struct leg_places order[LEG_PLACES_COMMON];
    char name[LEG_PLACES_NAME];
    leg_places_common(order);
    kinematics_place(&k, params);
    for (int i = 0; i < LEG_PLACES_COMMON; i++) {
        bool fits = true;
        for (int leg = 0; leg < LEGS; leg++)
            fits = fits && fabs(apart(k.upper[order[i].place[leg]], k.lower[leg]) - length_m[leg]) <= tolerance_m;
        if (!fits) continue;
        leg_places_name(&order[i], name);
        snprintf(text, LEG_ORDER_TEXT, "%s", name);
        return i > 0;
    }
    return false;
}

/* Orders of both channels, and the share of the varying force that they leave unexplained. */
struct candidate {
    struct leg_places of[2]; /* orders of the lengths and of the forces */
    double share;
};

static void rate(const struct work *w, struct candidate *c) { c->share = unexplained(w, &c->of[0], &c->of[1]); }

/* True if a candidate explains more than another one by more than chance (ALIKE, SAME). */
static bool explains_more(const struct candidate *c, const struct candidate *than) { return ALIKE * c->share + SAME < than->share; }

/* Exchanges two legs of the lengths, of the forces or of both, as long as that explains more. */
static void go_on(const struct work *w, struct candidate *best) {
    for (bool better = true; better;) {
        struct candidate from = *best;
        better = false;
        for (enum target target = OF_LENGTHS; target < TARGETS; target++)
            for (int a = 0; a < LEGS; a++)
                for (int b = a + 1; b < LEGS; b++) {
                    struct candidate c = from;
                    if (target != OF_FORCES) c.of[0] = leg_places_exchanged(&from.of[0], a, b);
                    if (target != OF_LENGTHS) c.of[1] = leg_places_exchanged(&from.of[1], a, b);
                    rate(w, &c);
                    if (!explains_more(&c, &from) || c.share >= best->share) continue;
                    *best = c, better = true;
                }
    }
}

static void describe(const struct candidate *c, const char *force, char *text, size_t size) {
    char lengths[LEG_PLACES_NAME], forces[LEG_PLACES_NAME];
    leg_places_name(&c->of[0], lengths), leg_places_name(&c->of[1], forces);
    if (leg_places_stated(&c->of[1])) snprintf(text, size, "lengths: %s", lengths);
    else if (leg_places_stated(&c->of[0])) snprintf(text, size, "%s: %s", force, forces);
    else if (!strcmp(lengths, forces)) snprintf(text, size, "lengths and %s, or the drawing: %s", force, lengths);
    else snprintf(text, size, "lengths: %s, and %s: %s", lengths, force, forces);
}

static enum target target_of(const struct candidate *c) {
    return leg_places_stated(&c->of[1]) ? OF_LENGTHS : leg_places_stated(&c->of[0]) ? OF_FORCES : OF_BOTH;
}

/* Writes, for the lengths, the forces and both, the first order that explains as much as the best
 * one. A further such order is not listed: it is taken to differ by a symmetry of the machine, and
 * the text says that there are such orders. others: the machine has a symmetry. */
static void describe_all(const struct candidate *c, int candidates, const char *force, double best, bool others,
                         char text[LEG_ORDER_TEXT]) {
    int named[TARGETS] = {0};
    text[0] = '\0';
    for (int i = 0; i < candidates; i++) {
        size_t used = strlen(text);
        if (c[i].share > ALIKE * best + SAME) continue;
        if (named[target_of(&c[i])]++) {
            others = true;
            continue;
        }
        snprintf(text + used, LEG_ORDER_TEXT - used, "%s", used ? "; or " : "");
        used = strlen(text);
        describe(&c[i], force, text + used, LEG_ORDER_TEXT - used);
    }
    size_t used = strlen(text);
    if (others) snprintf(text + used, LEG_ORDER_TEXT - used, ", or what a symmetry of the machine makes of it");
}

/* Rates the common orders, each applied to the lengths, to the forces and to both. Orders that are
 * symmetries of the machine are not applied to both, because this would change nothing. Returns the
 * number of candidates. */
static int rate_common(const struct work *w, const struct kinematics *k, struct candidate *candidate) {
    struct leg_places order[LEG_PLACES_COMMON];
    int n = 0;
    leg_places_common(order);
    for (enum target target = OF_LENGTHS; target < TARGETS; target++)
        for (int i = 1; i < LEG_PLACES_COMMON; i++) {
            if (target == OF_BOTH && symmetric(k, &order[i])) continue;
            candidate[n] = (struct candidate){.of = {order[target == OF_FORCES ? 0 : i], order[target == OF_LENGTHS ? 0 : i]}};
            rate(w, &candidate[n++]);
        }
    return n;
}

static double least_share(const struct candidate *c, int candidates, double least) {
    for (int i = 0; i < candidates; i++) least = fmin(least, c[i].share);
    return least;
}

/* Number of exchanges of two legs that make both orders from the stated one. */
static int exchanges(const struct candidate *c) { return leg_places_exchanges(&c->of[0]) + leg_places_exchanges(&c->of[1]); }

/* Replaces a candidate by one that explains more, or as much with fewer exchanges. */
static void prefer(struct candidate *best, const struct candidate *c) {
    if (explains_more(c, best) || (!explains_more(best, c) && exchanges(c) < exchanges(best))) *best = *c;
}

/* Rates all orders, except the stated one, whose first `leg` places are those of `order`, and keeps
 * the best one for the lengths, the forces and both. */
static void rate_all(const struct work *w, const struct leg_places *order, int leg, struct candidate best[TARGETS]) {
    const struct leg_places *stated = &best[OF_LENGTHS].of[1];
    if (leg == LEGS && leg_places_stated(order)) return;
    for (int other = leg; other < LEGS; other++) {
        struct leg_places next = leg_places_exchanged(order, leg, other);
        rate_all(w, &next, leg + 1, best);
    }
    for (enum target target = OF_LENGTHS; leg == LEGS && target < TARGETS; target++) {
        struct candidate c = {.of = {target == OF_FORCES ? *stated : *order, target == OF_LENGTHS ? *stated : *order}};
        rate(w, &c);
        prefer(&best[target], &c);
    }
}

/* Finds the best of all orders for the lengths, the forces and both. If none of them is decisive,
 * lengths and forces may be in two different orders, which are found from these by further
 * exchanges. Returns the number of candidates. */
static int rate_rare(const struct work *w, double decisive, struct candidate best[TARGETS]) {
    struct leg_places order[LEG_PLACES_COMMON];
    leg_places_common(order);
    for (enum target target = OF_LENGTHS; target < TARGETS; target++)
        best[target] = (struct candidate){.of = {order[0], order[0]}, .share = HUGE_VAL};
    rate_all(w, &order[0], 0, best);
    double least = HUGE_VAL;
    for (enum target target = OF_LENGTHS; target < TARGETS; target++) least = fmin(least, best[target].share);
    for (enum target target = OF_LENGTHS; target < TARGETS && !(least < decisive); target++) go_on(w, &best[target]);
    return TARGETS;
}

static void compare(const struct work *w, const struct params *params, bool pressures, struct leg_order *result) {
    struct leg_places order[LEG_PLACES_COMMON];
    struct candidate candidate[TARGETS * LEG_PLACES_COMMON];
    struct kinematics k;
    leg_places_common(order);
    kinematics_place(&k, params);
    result->stated = unexplained(w, &order[0], &order[0]);
    int n = rate_common(w, &k, candidate);
    result->best = least_share(candidate, n, result->stated);
    double decisive = DECISIVE * fmin(result->stated, 1.0);
    if (result->stated > UNEXPLAINED && !(result->best < decisive)) {
        n = rate_rare(w, decisive, candidate);
        result->best = least_share(candidate, n, result->stated);
    }
    result->refuted = result->stated > UNEXPLAINED && result->best < decisive;
    if (result->refuted) describe_all(candidate, n, pressures ? "pressures" : "forces", result->best, any_symmetry(&k), result->text);
}

int leg_order_find(const struct residual_data *data, const struct recording *r, int first, struct leg_order *order, struct error *error) {
    double lambda[LEGS][LEGS];
    struct work *w = calloc(1, sizeof *w);
    *order = (struct leg_order){0};
    if (!w) return error_set(error, STATUS_IO, "out of memory");
    find_leg_space(&w->space, r->params);
    params_mechanism(r->params)->leg_mass(r->params, lambda);
    for (int i = 0; i < data->tests; i++)
        if (data->test[i].of >= first) add_test(w, &data->test[i], lambda);
    compare(w, r->params, r->measured.pressures, order);
    free(w);
    return STATUS_OK;
}
