#include "csv_times.h"

#include <math.h>
#include <stdlib.h>

enum {
    PASSES = 8,
    APART = 64,   /* largest distance in rows over which the step is measured */
    WARM_UP = 256 /* number of rows from which the grid's position at the first row is found */
};

static const double FOLLOW = 1.0 / 32.0; /* share of a row's deviation by which the grid follows it:
                                          * a step that is off by 1 % makes the grid lag by a third
                                          * of a step, and jitter averages out */
static const double NEXT = 0.75;         /* share of a step; a row that is nearer than this to the
                                          * next place gets that place, because so much jitter is
                                          * commoner than a lost row */
static const double STEP_LEAST_S = 1e-7; /* shorter steps mean a wrong unit of time */

int csv_times_add(struct csv_times *t, double t_s, struct error *error) {
    if (t->rows == t->capacity) {
        int64_t capacity = t->capacity ? 2 * t->capacity : 4096;
        double *more = realloc(t->t_s, (size_t)capacity * sizeof *more);
        if (!more) return error_set(error, STATUS_IO, "out of memory for the times of a file");
        t->t_s = more, t->capacity = capacity;
    }
    t->t_s[t->rows++] = t_s;
    return STATUS_OK;
}

/* Returns the mean of the steps between `least` and `most`. */
static double mean_within(const struct csv_times *t, double least, double most) {
    double sum = 0.0;
    int64_t n = 0;
    for (int64_t i = 1; i < t->rows; i++) {
        double step_s = t->t_s[i] - t->t_s[i - 1];
        if (step_s > least && step_s < most) sum += step_s, n++;
    }
    return n ? sum / (double)n : 0.0;
}

/* Finds the usual step, starting from the mean of all steps: first the mean without gaps, then the
 * mean of steps near it. The median would fail for times of 400 Hz rounded to milliseconds, which
 * have steps of 2 and 3 ms. */
static double usual_step(const struct csv_times *t) {
    double step_s = t->mean_s;
    for (int pass = 0; pass < 2 * PASSES; pass++) {
        double mean_s = mean_within(t, pass < PASSES ? 0.0 : 0.5 * step_s, 1.5 * step_s);
        if (mean_s > 0.0) step_s = mean_s;
    }
    return step_s;
}

/* Refines the step over growing distances, each a whole number of steps, over which jitter
 * counts less and less. */
static double refine(const struct csv_times *t, double step_s) {
    for (int64_t apart = 1; apart <= APART && 4 * apart < t->rows; apart *= 2) {
        double sum = 0.0, steps = 0.0;
        for (int64_t i = apart; i < t->rows; i++) {
            double passed_s = t->t_s[i] - t->t_s[i - apart];
            sum += passed_s, steps += round(passed_s / step_s);
        }
        if (steps > 0.0) step_s = sum / steps;
    }
    return step_s;
}

/* Moves the grid to the row at t_s, and a little towards t_s. Returns the number of grid steps. */
static int64_t follow(double *at_s, double t_s, double step_s) {
    double steps = (t_s - *at_s) / step_s, lines = fabs(steps - 1.0) < NEXT ? 1.0 : round(steps);
    *at_s += lines * step_s;
    *at_s += FOLLOW * (t_s - *at_s);
    return (int64_t)lines;
}

static void follow_places(struct csv_times *t) {
    int64_t begin = t->rows < WARM_UP ? t->rows : WARM_UP, place = 0;
    double at_s = t->t_s[begin - 1];
    for (int64_t i = begin - 1; i >= 0; i--) follow(&at_s, t->t_s[i], t->step_s);
    at_s -= t->step_s;
    for (int64_t i = 0; i < t->rows; i++) t->place[i] = place += follow(&at_s, t->t_s[i], t->step_s);
}

/* Gives each row its own place on the grid. Of two rows at one place the later one moves on if the
 * next place is free; otherwise the earlier ones move back. */
static void part_places(struct csv_times *t) {
    int64_t *p = t->place, last = t->rows - 1;
    for (int64_t i = 1; i < last; i++)
        if (p[i] <= p[i - 1] && p[i + 1] > p[i - 1] + 1) p[i] = p[i - 1] + 1;
    for (int64_t i = last - 1; i >= 0; i--)
        if (p[i] >= p[i + 1]) p[i] = p[i + 1] - 1;
}

/* Places all rows on a grid of this step. Returns the number of rows that do not directly follow
 * their predecessor on the grid. */
static int64_t place_rows(struct csv_times *t, double step_s) {
    int64_t unexplained = 0;
    t->step_s = step_s;
    follow_places(t);
    for (int64_t i = 1; i < t->rows; i++) unexplained += t->place[i] != t->place[i - 1] + 1;
    part_places(t);
    return unexplained;
}

int csv_times_measure(struct csv_times *t, double stated_s, struct error *error) {
    t->place = calloc((size_t)t->rows + 1, sizeof *t->place);
    if (!t->place) return error_set(error, STATUS_IO, "out of memory for the times of a file");
    if (t->rows < 2) return STATUS_OK;
    double span_s = t->t_s[t->rows - 1] - t->t_s[0];
    t->mean_s = span_s / (double)(t->rows - 1);
    t->step_s = usual_step(t);
    if (!(t->step_s >= STEP_LEAST_S)) return STATUS_OK;
    double step_s = refine(t, t->step_s);
    int64_t unexplained = place_rows(t, step_s);
    /* if the stated step leaves fewer than half as many rows unexplained, it is the right one; a
     * small error of the step does no harm, since the grid follows the rows */
    if (unexplained && stated_s >= STEP_LEAST_S && 2 * place_rows(t, stated_s) >= unexplained) place_rows(t, step_s);
    t->step_s = span_s / (double)(csv_times_places(t) - 1);
    return STATUS_OK;
}

int64_t csv_times_places(const struct csv_times *t) { return t->rows ? t->place[t->rows - 1] - t->place[0] + 1 : 0; }

int64_t csv_times_lost(const struct csv_times *t) { return csv_times_places(t) - t->rows; }

void csv_times_free(struct csv_times *t) {
    free(t->t_s), free(t->place);
    *t = (struct csv_times){0};
}
