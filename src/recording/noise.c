#include "noise.h"

#include <math.h>

#include "sort.h"

enum { BLOCKS = 2048, BLOCK_LEAST = 32 };

static const double FOURTH = 70.0;      /* variance of the fourth difference of white noise, as a
                                         * multiple of the noise's variance: sum of the squares of 1
                                         * -4 6 -4 1 */
static const double ROUNDING = 1e-12;   /* a difference of up to this share of the value's magnitude
                                         * is rounding, not a step */
static const double MULTIPLE = 0.05;    /* a difference counts as a multiple of the step if it
                                         * differs from a whole number of steps by less than this
                                         * share of a step */
static const double MULTIPLES = 0.95;   /* share of the differences that must be multiples of the
                                         * smallest difference */
static const double STEPS_MOST = 1e6;   /* a difference of more steps counts as no multiple, because
                                         * a very large quotient of two doubles is always a whole
                                         * number */

/* Rms of the white noise. Each block of samples gives the mean square of its fourth differences;
 * the result follows from the median of the blocks. NaN without five successive finite values. */
static double white(int count, const double *x, size_t stride) {
    double block[BLOCKS], sum = 0.0;
    int size = count / BLOCKS + 1 > BLOCK_LEAST ? count / BLOCKS + 1 : BLOCK_LEAST, blocks = 0, n = 0;
    for (int i = 4; i < count; i++) {
        const double *p = x + (size_t)(i - 4) * stride;
        double d = p[0] - 4.0 * p[stride] + 6.0 * p[2 * stride] - 4.0 * p[3 * stride] + p[4 * stride];
        if (isfinite(d)) sum += d * d, n++;
        if ((n < size && i < count - 1) || n == 0 || blocks == BLOCKS) continue;
        block[blocks++] = sum / n;
        sum = 0.0, n = 0;
    }
    if (!blocks) return (double)NAN;
    sort_ascending(blocks, block);
    return sqrt(block[blocks / 2] / FOURTH);
}

/* Smallest difference above rounding, if at least the share MULTIPLES of all differences are
 * multiples of it; otherwise 0. */
static double step_of(int count, const double *x, size_t stride) {
    double step = HUGE_VAL;
    int differences = 0, multiples = 0;
    for (int pass = 0; pass < 2; pass++) {
        double before = (double)NAN;
        for (int i = 0; i < count; i++) {
            double value = x[(size_t)i * stride], d = fabs(value - before);
            if (!isfinite(value)) continue;
            before = value;
            if (!(d > ROUNDING * fabs(value))) continue;
            if (!pass) step = fmin(step, d);
            else differences++, multiples += fabs(d / step - round(d / step)) < MULTIPLE && d < STEPS_MOST * step;
        }
    }
    return differences && multiples >= MULTIPLES * differences ? step : 0.0;
}

struct noise noise_measure(int count, const double *x, size_t stride) {
    struct noise n = {.rms = white(count, x, stride), .step = step_of(count, x, stride)};
    /* fmax skips NaN, so with too few values for white noise only quantisation noise is returned */
    if (n.step > 0.0) n.rms = fmax(n.rms, n.step / sqrt(12.0));
    return n;
}
