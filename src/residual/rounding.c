#include "rounding.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "numeric.h"
#include "spectrum.h"
#include "units.h"

enum { BISECTIONS = 30, SIZES = 7 };
static const double WEAK = 1e-6; /* a tone does not count if its mean square is less than this share
                                  * of 1 / 12, the mean square of all rounding errors in steps^2 */
static const double SURE = 3.0;  /* a harmonic that exceeds this many of its standard deviations is
                                  * motion, not rounding error */

/* Mean square, in steps^2, of tone k of the rounding error averaged over many cycles, if x varies
 * from cycle to cycle like Gaussian noise. shaken: standard deviation of this noise, in steps. */
static double tone_square(int k, double shaken) { return 0.5 * square(exp(-2.0 * square(PI * k * shaken)) / (PI * k)); }

/* Standard deviation of the signal from one cycle to the next, in steps. scatter: standard
 * deviation of samples at one place, in steps; the signal's variation and the rounding errors that
 * do not repeat cause it. */
static double shaking(double scatter) {
    double least = 0.0, most = scatter;
    for (int i = 0; i < BISECTIONS; i++) {
        double shaken = 0.5 * (least + most), unlike = square(shaken) + 1.0 / 12.0;
        for (int k = 1; k <= ROUNDING_TONES; k++) unlike -= tone_square(k, shaken);
        if (unlike > square(scatter)) most = shaken;
        else least = shaken;
    }
    return least;
}

/* Mean square of each tone in a signal's mean cycle, in steps^2. */
static void find_mean_squares(const struct rounding *r, double mean_square[ROUNDING_TONES]) {
    double shaken = shaking(r->scatter / r->step);
    for (int k = 0; k < ROUNDING_TONES; k++) {
        double s = 0.0, c = 0.0;
        for (int i = 0; i < r->cycles; i++) {
            double turn = 2.0 * PI * (k + 1) * r->middle[i] / r->step;
            s += sin(turn) / r->cycles, c += cos(turn) / r->cycles;
        }
        mean_square[k] = tone_square(k + 1, shaken) * (square(s) + square(c));
    }
}

/* Fourier coefficients of the sine and the cosine of each tone, for SIZES sizes of the motion,
 * whose peaks are spread evenly over a step. */
struct tones {
    double sine[ROUNDING_TONES][SIZES][1 + 2 * ROUNDING_HARMONICS], cosine[ROUNDING_TONES][SIZES][1 + 2 * ROUNDING_HARMONICS];
};

/* Value of the mean cycle, without its mean, at one of the places. basis: the Fourier basis
 * there. */
static double course_at(const struct rounding *r, int harmonics, const double *row, int place, double *basis) {
    double x = 0.0;
    spectrum_basis(r->first_phase + 2.0 * PI * place / r->places, harmonics, basis);
    for (int a = 1; a < 1 + 2 * harmonics; a++) x += row[a] * basis[a];
    return x;
}

/* Turns a unit vector by the angle of another one. */
static void turn_by(double *s, double *c, double by_s, double by_c) {
    double turned = *s * by_c + *c * by_s;
    *c = *c * by_c - *s * by_s, *s = turned;
}

static void find_tones(struct tones *t, const struct rounding *r, int harmonics, const double *row, int tones) {
    double basis[1 + 2 * ROUNDING_HARMONICS], peak = 0.0;
    memset(t, 0, sizeof *t);
    for (int i = 0; i < r->places; i++) peak = fmax(peak, fabs(course_at(r, harmonics, row, i, basis)));
    for (int i = 0; i < r->places; i++) {
        double x = course_at(r, harmonics, row, i, basis), larger = peak > 0.0 ? x / peak / SIZES : 0.0;
        double turn = 2.0 * PI * (x / r->step - 0.5 * (SIZES - 1) * larger), first_s = sin(turn), first_c = cos(turn);
        double larger_s = sin(2.0 * PI * larger), larger_c = cos(2.0 * PI * larger);
        for (int j = 0; j < SIZES; j++, turn_by(&first_s, &first_c, larger_s, larger_c)) {
            double s = first_s, c = first_c;
            for (int k = 0; k < tones; k++, turn_by(&s, &c, first_s, first_c)) {
                double *sine = t->sine[k][j], *cosine = t->cosine[k][j];
                for (int a = 0; a < 1 + 2 * harmonics; a++) sine[a] += s * basis[a], cosine[a] += c * basis[a];
            }
        }
    }
}

/* Finds the shares for this motion. */
static void find_shares(struct rounding_shares *shares, const struct rounding *r, int harmonics, const double *row) {
    struct tones t;
    find_tones(&t, r, harmonics, row, shares->tones);
    for (int k = 0; k < shares->tones; k++)
        for (int a = 0; a < 1 + 2 * harmonics; a++) {
            double sum = 0.0;
            for (int j = 0; j < SIZES; j++) sum += square(t.sine[k][j][a]) + square(t.cosine[k][j][a]);
            shares->of[k][a] = square(r->step * (a ? 2.0 : 1.0) / r->places) * sum / SIZES;
        }
}

/* Sums the variances that the tones give each coefficient. */
static void add_up(const struct rounding_shares *shares, const double mean_square[ROUNDING_TONES], int harmonics, double *variance) {
    memset(variance, 0, (size_t)(1 + 2 * harmonics) * sizeof *variance);
    for (int k = 0; k < shares->tones; k++)
        for (int a = 0; a < 1 + 2 * harmonics; a++) variance[a] += mean_square[k] * shares->of[k][a];
}

void rounding_find_shares(const struct rounding *r, int harmonics, const double *row, struct rounding_shares *shares) {
    double mean_square[ROUNDING_TONES], variance[1 + 2 * ROUNDING_HARMONICS];
    shares->tones = 0;
    if (!(r->step > 0.0) || r->places < 1) return;
    find_mean_squares(r, mean_square);
    for (int k = 0; k < ROUNDING_TONES; k++)
        if (mean_square[k] > WEAK / 12.0) shares->tones = k + 1;
    if (!shares->tones) return;
    /* The motion is the fundamental, and those harmonics that cannot be errors. */
    double motion[1 + 2 * ROUNDING_HARMONICS] = {0.0, row[1], row[2]};
    bool more = false;
    find_shares(shares, r, harmonics, motion);
    add_up(shares, mean_square, harmonics, variance);
    for (int a = 3; a < 1 + 2 * harmonics; a += 2)
        if (square(row[a]) + square(row[a + 1]) > square(SURE) * (variance[a] + variance[a + 1]))
            motion[a] = row[a], motion[a + 1] = row[a + 1], more = true;
    if (more) find_shares(shares, r, harmonics, motion);
}

void rounding_in_step(const struct rounding *r, const struct rounding_shares *shares, int harmonics, double *variance) {
    double mean_square[ROUNDING_TONES] = {0};
    if (shares->tones) find_mean_squares(r, mean_square);
    add_up(shares, mean_square, harmonics, variance);
}
