#include "csv_hold.h"

#include <math.h>

enum { GAPS_LEAST = 12 };            /* with fewer gaps, a channel never counts as repeated */

static const double MORE = 1.5;       /* a change is too large for a coarse sensor if it exceeds one
                                       * step per row of its gap by more than this many steps */
static const double MULTIPLE = 0.05; /* largest distance of a change from a multiple of the step, as
                                      * a share of the step */
static const double COARSE = 0.95;   /* least share of changes that are such multiples if the sensor
                                      * has a step */
static const double ALIKE = 0.3, ALIKE_LEAST = 0.7; /* a sensor has unequal steps if at least a
                                                     * share ALIKE_LEAST of its changes after gaps
                                                     * of two or more rows differs from the mean of
                                                     * these changes by less than ALIKE times that
                                                     * mean; in a repeated sinusoid that share is a
                                                     * third */
static const double LIKE_LEAST = 0.6; /* least share of gaps that have the commonest lengths */
static const double SHORTER_MOST = 0.05; /* largest share of shorter gaps: no device delivers faster
                                          * than its rate, but clocks slip */
static const double LONGER_MOST = 0.03; /* largest share of longer gaps in a repeated channel whose
                                         * commonest gaps have one and two rows; values that are
                                         * equal only by chance make more gaps of three */
static const double ROWS_LEAST = 1.5;   /* least mean number of rows for which a repeated channel
                                         * keeps a value; with fewer, the grid of csv_times.h could
                                         * not follow its samples */

void csv_hold_take(struct csv_hold *h, double value) {
    double change = fabs(value - h->last);
    if (h->rows++ > 0 && change == 0.0) return;
    int64_t gap = h->rows - h->changed_at;
    if (h->changed_at && h->changes < CSV_CHANGES) {
        h->gap[h->changes] = gap < CSV_GAPS ? (int)gap : CSV_GAPS - 1;
        h->change[h->changes++] = change;
    }
    h->changed_at = h->rows, h->last = value;
}

/* Returns the upper limit of the steps of a coarse sensor whose steps differ, as after a
 * calibration curve; 0 for any other channel. Such a sensor changes by about one step, however many
 * rows have passed since the change before, whereas a repeated channel changes by more when the
 * signal is faster. */
static double uneven_step(const struct csv_hold *h) {
    double mean = 0.0;
    int n = 0, alike = 0;
    for (int i = 0; i < h->changes; i++)
        if (h->gap[i] > 1) mean += h->change[i], n++;
    mean /= n > 0 ? n : 1;
    for (int i = 0; i < h->changes; i++) alike += h->gap[i] > 1 && fabs(h->change[i] - mean) < ALIKE * mean;
    return n > 0 && alike >= ALIKE_LEAST * n ? mean * (1.0 + ALIKE) : 0.0;
}

/* Returns the step of a coarse sensor; 0 if it has none. */
static double step_of(const struct csv_hold *h) {
    double step = h->changes ? h->change[0] : 0.0;
    int multiples = 0;
    for (int i = 0; i < h->changes; i++) step = fmin(step, h->change[i]);
    for (int i = 0; i < h->changes; i++) multiples += fabs(remainder(h->change[i], step)) < MULTIPLE * step;
    return multiples >= COARSE * h->changes ? step : uneven_step(h);
}

/* Number of gaps of each length, in rows, between changes that no coarse sensor makes. */
struct gaps {
    int number[CSV_GAPS];
};

static struct gaps gaps_of(const struct csv_hold *h) {
    struct gaps gaps = {0};
    double step = step_of(h);
    bool moved = false;
    for (int i = 0; i < h->changes; i++) {
        bool moves = h->change[i] > (h->gap[i] + MORE) * step;
        if (moved && moves) gaps.number[h->gap[i]]++;
        moved = moves;
    }
    return gaps;
}

static int sum(const struct gaps *g, int from, int to) {
    int n = 0;
    for (int i = from; i < to && i < CSV_GAPS; i++) n += g->number[i];
    return n;
}

/* Returns the shortest of the `width` consecutive gap lengths that together occur most often. */
static int commonest(const struct gaps *g, int width) {
    int best = 1;
    for (int i = 2; i < CSV_GAPS - width; i++)
        if (sum(g, i, i + width) > sum(g, best, best + width)) best = i;
    return best;
}

double csv_hold_rows(const struct csv_hold *h) {
    const struct gaps g = gaps_of(h);
    int all = sum(&g, 1, CSV_GAPS), first = commonest(&g, 2), width = 2;
    if (all < GAPS_LEAST) return 1.0;
    /* in a channel that is repeated three times or more, gaps jitter by a row in either direction,
     * so three lengths count */
    if (first >= 3) first = commonest(&g, 3), width = 3;
    double like = sum(&g, first, first + width), shorter = sum(&g, 1, first), longer = all - like - shorter, mean = 0.0;
    for (int i = first; i < first + width; i++) mean += g.number[i] * i / like;
    bool regular = like >= LIKE_LEAST * all && shorter <= SHORTER_MOST * all && (first > 1 || longer <= LONGER_MOST * all);
    return regular && mean >= ROWS_LEAST ? mean : 1.0;
}
