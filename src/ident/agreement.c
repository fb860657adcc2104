#include "agreement.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"

enum { VALUES = AGREEMENT_VALUES, JOINED = VALUES + COMMON };

struct others {
    struct equations sum;
    struct estimate estimate;
    struct method_c result;
};

/* The probability is Q(degrees / 2, x / 2), Q the regularised upper incomplete gamma function. It
 * is summed by Q(a + 1, z) = Q(a, z) + z^a exp(-z) / Gamma(a + 1), from Q(1/2, z) = erfc(sqrt(z))
 * for odd degrees or Q(1, z) = exp(-z) for even ones. */
double agreement_chi_square_above(double x, int degrees) {
    double half = 0.5 * x, sum = degrees % 2 ? erfc(sqrt(half)) : exp(-half);
    int sign;
    if (!(x > 0.0)) return 1.0;
    for (double a = degrees % 2 ? 0.5 : 1.0; a < 0.5 * degrees - 0.25; a += 1.0)
        sum += exp(a * log(half) - half - lgamma_r(a + 1.0, &sign));
    return fmin(sum, 1.0);
}

static double deviation(const struct estimate *one, const struct estimate *other, int c) {
    double variance = one->noise[c][c] + other->noise[c][c], compliance = fmax(one->compliance_prior, other->compliance_prior);
    for (int j = 0; j < COMMON; j++)
        variance += pow(estimate_common(one, j, c, compliance) - estimate_common(other, j, c, compliance), 2.0);
    return (one->value[c] - other->value[c]) / sqrt(variance);
}

/* Compares a log's values with the estimate from all other logs together. If the other logs have no
 * solution, no value of the log is compared. */
static void compare(int logs, const struct agreement_log *log, int l, const struct params *configured, struct others *o,
                    struct agreement *a) {
    struct error none;
    double std;
    o->sum = (struct equations){0};
    for (int m = 0; m < logs; m++)
        if (m != l) equations_add(&o->sum, log[m].equations);
    bool solved = !method_c_solve(&o->sum, configured, &o->estimate, &o->result, &none);
    for (int c = 0; c < VALUES; c++) {
        bool known = solved && !isnan(method_c_value(log[l].result, c, &std)) && !isnan(method_c_value(&o->result, c, &std));
        a->deviation[l][c] = known ? deviation(log[l].estimate, &o->estimate, c) : (double)NAN;
        a->compared += known;
    }
}

/* Normal equations whose unknowns are the values common to all logs, relative to the first log's
 * values, and the shared errors. square: weighted sum of squares of the right-hand sides. */
struct joined {
    double product[JOINED][JOINED], with[JOINED], square;
};

/* Adds a log's determined values, relative to `from`, to the normal equations, weighted by their
 * noise alone, because the shared errors are unknowns. compliance: unit in which the error of the
 * compliance is counted, m/N. Returns the number of these values, or -1 if their covariance is not
 * positive definite. */
static int join(const struct agreement_log *log, const struct estimate *from, double compliance, struct joined *n) {
    double covariance[VALUES * VALUES], difference[VALUES], column[JOINED][VALUES], solved[VALUES], std;
    int at[VALUES], count = 0;
    for (int c = 0; c < VALUES; c++)
        if (!isnan(method_c_value(log->result, c, &std))) at[count++] = c;
    memset(column, 0, sizeof column);
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < count; j++) covariance[i * count + j] = log->estimate->noise[at[i]][at[j]];
        difference[i] = log->estimate->value[at[i]] - from->value[at[i]];
        column[at[i]][i] = 1.0;
        for (int j = 0; j < COMMON; j++) column[VALUES + j][i] = estimate_common(log->estimate, j, at[i], compliance);
    }
    if (!dense_factor(count, count, covariance)) return -1;
    for (int a = 0; a <= JOINED; a++) {
        memcpy(solved, a < JOINED ? column[a] : difference, sizeof solved);
        dense_solve(count, count, covariance, solved);
        for (int i = 0; i < count; i++) {
            for (int b = 0; b <= a && a < JOINED; b++) n->product[a][b] += solved[i] * column[b][i];
            *(a < JOINED ? &n->with[a] : &n->square) += solved[i] * difference[i];
        }
    }
    return count;
}

static bool compare_whole(int logs, const struct agreement_log *log, struct agreement *a) {
    struct joined n = {0};
    double x[JOINED], compliance = 0.0;
    for (int l = 0; l < logs; l++) compliance = fmax(compliance, log[l].estimate->compliance_prior);
    for (int l = 0; l < logs; l++) {
        int count = join(&log[l], log[0].estimate, compliance, &n);
        if (count < 0) return false;
        a->degrees += count;
    }
    for (int c = 0; c < JOINED; c++) {
        bool open = c < VALUES && !(n.product[c][c] > 0.0); /* no log determines this value */
        if (c < VALUES && !open) a->degrees--;
        if (c >= VALUES || open) n.product[c][c] += 1.0;
    }
    memcpy(x, n.with, sizeof x);
    if (!dense_factor(JOINED, JOINED, n.product[0])) return false;
    dense_solve(JOINED, JOINED, n.product[0], x);
    a->chi_square = n.square;
    for (int c = 0; c < JOINED; c++) a->chi_square -= x[c] * n.with[c];
    return true;
}

int agreement_find(int logs, const struct agreement_log *log, const struct params *configured, struct agreement *a, struct error *error) {
    struct others *o = calloc(1, sizeof *o);
    *a = (struct agreement){.logs = logs, .probability = 1.0};
    if (!o) return error_set(error, STATUS_IO, "out of memory");
    for (int l = 0; l < logs; l++) compare(logs, log, l, configured, o, a);
    free(o);
    bool compared = compare_whole(logs, log, a), apart = false;
    if (compared && a->degrees > 0) a->probability = agreement_chi_square_above(a->chi_square, a->degrees);
    for (int l = 0; l < logs; l++)
        for (int c = 0; c < VALUES; c++) {
            a->apart[l][c] = a->compared * erfc(fabs(a->deviation[l][c]) / sqrt(2.0)) < AGREEMENT_PROBABILITY;
            apart = apart || a->apart[l][c];
        }
    a->evaluated = compared && a->compared > 0;
    a->agree = a->evaluated && a->probability >= AGREEMENT_PROBABILITY && !apart;
    return STATUS_OK;
}

bool agreement_worst(const struct agreement *a, bool used[AGREEMENT_LOGS][AGREEMENT_VALUES], struct agreement_place *place) {
    double most = -1.0;
    for (int l = 0; l < a->logs; l++)
        for (int c = 0; c < VALUES; c++)
            if (!used[l][c] && fabs(a->deviation[l][c]) > most) most = fabs(a->deviation[l][c]), *place = (struct agreement_place){l, c};
    if (most < 0.0) return false;
    used[place->log][place->value] = true;
    return true;
}
