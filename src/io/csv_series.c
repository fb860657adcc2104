#include "csv_series.h"

#include <math.h>
#include <stdlib.h>

enum { POINTS = 4 };
static const double UNEVEN_MOST = 4.0; /* largest ratio of the longest to the shortest step */

bool csv_series_add(struct csv_series *s, double t_s, double value) {
    if (s->count == s->capacity) {
        int64_t capacity = s->capacity ? 2 * s->capacity : 4096;
        double *times = realloc(s->t_s, (size_t)capacity * sizeof *times);
        if (times) s->t_s = times;
        double *values = realloc(s->value, (size_t)capacity * sizeof *values);
        if (values) s->value = values;
        if (!times || !values) return false;
        s->capacity = capacity;
    }
    s->t_s[s->count] = t_s, s->value[s->count++] = value;
    return true;
}

double csv_series_rate(const struct csv_series *s) {
    if (s->count < 2 || !s->t_s) return 0.0;
    double mean_s = (s->t_s[s->count - 1] - s->t_s[0]) / (double)(s->count - 1), sum_s = 0.0;
    int64_t steps = 0;
    for (int64_t i = 1; i < s->count; i++) {
        double step_s = s->t_s[i] - s->t_s[i - 1];
        if (step_s < 2.0 * mean_s) sum_s += step_s, steps++;
    }
    return sum_s > 0.0 ? (double)steps / sum_s : 0.0;
}

/* Returns the value at t of the polynomial through `count` samples (Lagrange). */
static double through(const double *t_s, const double *value, int count, double t) {
    double sum = 0.0;
    for (int i = 0; i < count; i++) {
        double share = value[i];
        for (int j = 0; j < count; j++)
            if (j != i) share *= (t - t_s[j]) / (t_s[i] - t_s[j]);
        sum += share;
    }
    return sum;
}

/* Returns true if the samples are near enough to each other for one polynomial, and not so uneven
 * that it would oscillate. */
static bool are_even(const double *t_s, int count, double hole_s) {
    double least_s = (double)INFINITY, most_s = 0.0;
    for (int i = 1; i < count; i++) least_s = fmin(least_s, t_s[i] - t_s[i - 1]), most_s = fmax(most_s, t_s[i] - t_s[i - 1]);
    return most_s <= hole_s && most_s <= UNEVEN_MOST * least_s;
}

double csv_series_at(const struct csv_series *s, int64_t at, double t_s, double hole_s) {
    const double *t = s->t_s + at;
    if (t_s == *t) return s->value[at];
    if (t_s < *t || at + 1 == s->count || t[1] - t[0] > hole_s) return (double)NAN;
    int64_t first = at > 0 ? at - 1 : 0;
    /* at the end of the series, take its last samples */
    if (first + POINTS > s->count) first = s->count - POINTS;
    bool cubic = first >= 0 && are_even(s->t_s + first, POINTS, hole_s);
    return cubic ? through(s->t_s + first, s->value + first, POINTS, t_s) : through(t, s->value + at, 2, t_s);
}

void csv_series_free(struct csv_series *s) {
    free(s->t_s), free(s->value);
    *s = (struct csv_series){0};
}
