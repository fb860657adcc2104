#include "csv_speed.h"

#include <math.h>

#include "units.h"

static const double REST_S = 0.5;      /* length of an interval that is tested for rest */
static const double REST_SPEED = 0.05; /* largest speed at rest, as a share of the greatest speed */
static const double REST_NOISE = 2.0;  /* largest scatter of a resting interval, as a multiple of
                                        * the quietest interval's */

/* Mean and standard deviation of an interval of the series. */
struct moments {
    double mean, scatter;
};

static struct moments moments(const double *value, int64_t count) {
    double mean = 0.0, square = 0.0;
    for (int64_t i = 0; i < count; i++) mean += value[i] / (double)count;
    for (int64_t i = 0; i < count; i++) square += (value[i] - mean) * (value[i] - mean) / (double)count;
    return (struct moments){mean, sqrt(square)};
}

static double greatest(const struct csv_series *s) {
    double most = 0.0;
    for (int64_t i = 0; i < s->count; i++) most = fmax(most, fabs(s->value[i]));
    return most;
}

/* Speed while the axis rests. */
struct rest {
    double mean, noise; /* mean: NaN if the axis never rests; noise: root mean square of the resting
                         * intervals' scatters */
    int64_t samples;    /* number of samples at rest */
};

static struct rest rest_of(const struct csv_series *s) {
    int64_t piece = (int64_t)(REST_S * csv_series_rate(s)), pieces = piece > 1 ? s->count / piece : 0, resting = 0;
    double slow = REST_SPEED * greatest(s), quietest = (double)INFINITY, sum = 0.0, square = 0.0;
    for (int64_t i = 0; i < pieces; i++) {
        struct moments m = moments(s->value + i * piece, piece);
        if (fabs(m.mean) < slow && m.scatter < slow) quietest = fmin(quietest, m.scatter);
    }
    for (int64_t i = 0; i < pieces; i++) {
        struct moments m = moments(s->value + i * piece, piece);
        if (!(fabs(m.mean) < slow && m.scatter < slow && m.scatter <= REST_NOISE * quietest)) continue;
        sum += m.mean, square += m.scatter * m.scatter, resting++;
    }
    double count = (double)resting;
    return resting ? (struct rest){sum / count, sqrt(square / count), resting * piece} : (struct rest){.mean = (double)NAN};
}

/* Returns the standard deviation that white noise of the speed causes in the position after
 * span_s: by the random walk of the integral, and by the zero's error, noise / sqrt(samples),
 * times span_s. */
static double wander(const struct rest *rest, double span_s, double rate_hz) {
    return rest->noise * hypot(sqrt(span_s / rate_hz), span_s / sqrt((double)rest->samples));
}

static void note_holes(const struct csv_series *s, double rate_hz, char notes[CSV_NOTES_SIZE]) {
    int64_t holes = 0;
    double longest_s = 0.0;
    for (int64_t i = 1; i < s->count; i++) {
        double step_s = s->t_s[i] - s->t_s[i - 1];
        if (step_s * rate_hz > CSV_HOLE) holes++, longest_s = fmax(longest_s, step_s);
    }
    if (holes)
        csv_note(notes, "the speed has %lld hole%s, up to %.3g s, bridged by a straight line: the position behind may be off",
                 (long long)holes, holes == 1 ? "" : "s", longest_s);
}

/* Returns the mean under a Hann window, in which an unfinished cycle at an end counts little. */
static double windowed_mean(const struct csv_series *s) {
    double sum = 0.0, weights = 0.0, span_s = s->t_s[s->count - 1] - s->t_s[0];
    for (int64_t i = 0; i < s->count; i++) {
        double weight = 1.0 - cos(2.0 * PI * (s->t_s[i] - s->t_s[0]) / span_s);
        sum += weight * s->value[i], weights += weight;
    }
    return sum / weights;
}

static void integrate(struct csv_series *s, double zero) {
    double place = 0.0, before = s->value[0] - zero;
    s->value[0] = 0.0;
    for (int64_t i = 1; i < s->count; i++) {
        double now = s->value[i] - zero;
        place += 0.5 * (before + now) * (s->t_s[i] - s->t_s[i - 1]);
        s->value[i] = place, before = now;
    }
}

static void centre(struct csv_series *s, double middle_m) {
    double low = s->value[0], high = low;
    for (int64_t i = 1; i < s->count; i++) low = fmin(low, s->value[i]), high = fmax(high, s->value[i]);
    for (int64_t i = 0; i < s->count; i++) s->value[i] += middle_m - 0.5 * (low + high);
}

void csv_speed_integrate(struct csv_series *s, double middle_m, char notes[CSV_NOTES_SIZE]) {
    if (s->count < 2) return;
    const struct rest rest = rest_of(s);
    const bool rests = !isnan(rest.mean);
    const double zero = rests ? rest.mean : windowed_mean(s);
    const double span_s = s->t_s[s->count - 1] - s->t_s[0], rate_hz = csv_series_rate(s);
    integrate(s, zero);
    centre(s, middle_m);
    csv_note(notes,
             "position_m is integrated from a speed, less %.3g mm/s (%s), %.3g mm over the record; its middle is put to axis.middle_m",
             1e3 * zero, rests ? "its mean at rest" : "its mean, for there is no rest: a motion that comes back is assumed",
             1e3 * zero * span_s);
    if (rests) csv_note(notes, "the speed's noise makes it wander by %.2g mm", 1e3 * wander(&rest, span_s, rate_hz));
    note_holes(s, rate_hz, notes);
}
