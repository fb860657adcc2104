#include "noise.h"

#include <math.h>

#include "sort.h"

enum { BLOCKS = 2048, BLOCK_LEAST = 32 };

static const double FOURTH = 70.0;      /* sum of squares of 1 -4 6 -4 1: a fourth difference's
                                         * variance */
static const double ROUNDING = 1e-12;   /* relative; smaller differences are rounding, not steps */
static const double MULTIPLE = 0.05;    /* distance from a whole number of steps in a multiple */
static const double MULTIPLES = 0.95;   /* least share of differences that are multiples */
static const double STEPS_MOST = 1e6;   /* beyond, every difference looks like a multiple */

/* White noise, rms: from the median over blocks of the mean square of fourth differences. */
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

/* The smallest difference above rounding, if nearly all others are multiples of it; else 0. */
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
    /* fmax skips NaN: too few values for the white part leave the quantization noise */
    if (n.step > 0.0) n.rms = fmax(n.rms, n.step / sqrt(12.0));
    return n;
}
