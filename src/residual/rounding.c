#include "rounding.h"

#include <math.h>
#include <string.h>

#include "numeric.h"
#include "spectrum.h"
#include "units.h"

enum { BISECTIONS = 30 };
static const double WEAK = 1e-6; /* share of 1 / 12, the mean square of all errors, below which a
                                  * tone does not count */

/* Mean square of tone k of the errors to steps of 1, if x varies by a Gaussian of this standard
 * deviation. */
static double tone_square(int k, double shaken) { return 0.5 * square(exp(-2.0 * square(PI * k * shaken)) / (PI * k)); }

/* Standard deviation of the signal from one cycle to the next, in steps. scatter: standard
 * deviation of samples at one place, in steps; it is caused by this variation, and by the rounding
 * errors that do not repeat. */
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

/* Adds the variance by tone k, whose mean square is mean_square. */
static void add_tone(const struct rounding *r, int harmonics, const double *row, int k, double mean_square, double *variance) {
    int size = 1 + 2 * harmonics;
    double sine[1 + 2 * ROUNDING_HARMONICS] = {0}, cosine[1 + 2 * ROUNDING_HARMONICS] = {0}, basis[1 + 2 * ROUNDING_HARMONICS];
    for (int i = 0; i < r->places; i++) {
        double x = 0.0;
        spectrum_basis(r->first_phase + 2.0 * PI * i / r->places, harmonics, basis);
        for (int a = 1; a < size; a++) x += row[a] * basis[a];
        double s = sin(2.0 * PI * k * x / r->step), c = cos(2.0 * PI * k * x / r->step);
        for (int a = 0; a < size; a++) sine[a] += s * basis[a], cosine[a] += c * basis[a];
    }
    for (int a = 0; a < size; a++) variance[a] += mean_square * (square(sine[a]) + square(cosine[a])) * square((a ? 2.0 : 1.0) / r->places);
}

void rounding_in_step(const struct rounding *r, int harmonics, const double *row, double *variance) {
    memset(variance, 0, (size_t)(1 + 2 * harmonics) * sizeof *variance);
    if (!(r->step > 0.0) || r->places < 1) return;
    double shaken = shaking(r->scatter / r->step);
    for (int k = 1; k <= ROUNDING_TONES; k++) {
        double s = 0.0, c = 0.0;
        for (int i = 0; i < r->cycles; i++) {
            double turn = 2.0 * PI * k * r->middle[i] / r->step;
            s += sin(turn) / r->cycles, c += cos(turn) / r->cycles;
        }
        double mean_square = tone_square(k, shaken) * (square(s) + square(c));
        if (mean_square > WEAK / 12.0) add_tone(r, harmonics, row, k, mean_square * square(r->step), variance);
    }
}
