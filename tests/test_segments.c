/* A recording is cut into rest, steady motion and other motion by its lengths alone, whatever the
 * motion, the rate and the sensor. */
#include "support.h"

#include <stdlib.h>

#include "noise.h"
#include "sampling.h"
#include "segments.h"

static const double TURN = 2.0 * 3.14159265358979323846;
static struct error error;

/* Returns the position of a machine, m, at a time. */
typedef double motion(double t_s);

struct sensor {
    /* lost: share of the samples; jitter: rms share of a period */
    double rate_hz, duration_s, noise_m, step_m, lost, jitter;
};

static const struct sensor good = {.rate_hz = 500, .duration_s = 20, .noise_m = 1e-6};

static double normal(uint64_t *state) {
    double sum = -6.0;
    for (int i = 0; i < 12; i++) {
        *state ^= *state << 13, *state ^= *state >> 7, *state ^= *state << 17;
        sum += (double)(*state >> 11) / 9007199254740992.0;
    }
    return sum;
}

/* The recordings have two legs; the second moves by half in the opposite direction. */
enum { TEST_LEGS = 2 };
static struct recording_test measure(motion *m, const struct sensor *s) {
    uint64_t state = 4;
    int rows = (int)(s->rate_hz * s->duration_s);
    struct recording_test t = {.sample = calloc((size_t)rows, sizeof *t.sample), .first = -1};
    for (int i = 0; i < rows; i++) {
        double t_s = (i + s->jitter * normal(&state)) / s->rate_hz;
        bool lost = fabs(normal(&state)) > 3.0 ? s->lost > 0.0 : (double)(i % 1000) / 1000.0 < s->lost && i % 3;
        if (lost && i) continue;
        struct recording_sample *x = &t.sample[t.count++];
        x->test_time_s = t_s;
        for (int k = 0; k < TEST_LEGS; k++) {
            x->length_m[k] = 1.8 + (k ? -0.5 : 1.0) * m(t_s) + s->noise_m * normal(&state);
            if (s->step_m > 0.0) x->length_m[k] = s->step_m * round(x->length_m[k] / s->step_m);
        }
    }
    return t;
}

static const char letters[] = "RSM";

/* Formats "R0-2.0 M-3.0 S4.0-8.0": kind, frequency of a steady one, end. */
static const char *show(const struct recording_test *t, const struct segments *p) {
    static char text[1000];
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; i < p->count && used < sizeof text - 40; i++) {
        const struct segment *q = &p->segment[i];
        used += (size_t)sprintf(text + used, "%c", letters[q->kind]);
        if (q->kind == SEGMENT_STEADY) used += (size_t)sprintf(text + used, "%.3f", q->frequency_hz);
        used += (size_t)sprintf(text + used, "-%.2f ", t->sample[q->end - 1].test_time_s);
    }
    return text;
}

/* Expected segments of the whole record in order: kind, hertz, end in seconds within a
 * tolerance. */
struct expected {
    char kind;
    double hz, end_s, within_s;
};

static void expect(const char *name, motion *m, const struct sensor *s, const struct expected *e, int count) {
    struct recording_test t = measure(m, s);
    struct segments p;
    assert_int_equal(segments_find(&p, &t, sampling_step_s(&t, 0, t.count), TEST_LEGS, &error), 0);
    bool same = p.count == count && p.segment[0].first == 0 && p.segment[p.count - 1].end == t.count;
    for (int i = 0; i < count && same; i++) {
        const struct segment *q = &p.segment[i];
        same = letters[q->kind] == e[i].kind && (!i || q->first == q[-1].end);
        same = same && (q->kind == SEGMENT_STEADY ? fabs(q->frequency_hz / e[i].hz - 1.0) < 2e-3 : isnan(q->frequency_hz));
        same = same && (e[i].within_s == 0.0 || fabs(t.sample[q->end - 1].test_time_s - e[i].end_s) < e[i].within_s);
    }
    if (!same) fail_msg("%s at %g Hz, noise %g, step %g, lost %g: %s", name, s->rate_hz, s->noise_m, s->step_m, s->lost, show(&t, &p));
    segments_free(&p);
    free(t.sample);
}
#define EXPECT(m, s, ...) expect(#m, m, s, (const struct expected[]){__VA_ARGS__}, \
                                 (int)(sizeof((const struct expected[]){__VA_ARGS__}) / sizeof(struct expected)))

static double ramp(double t_s, double from_s, double until_s) {
    double share = fmin(fmax((t_s - from_s) / (until_s - from_s), 0.0), 1.0);
    return share * share * (3.0 - 2.0 * share);
}

/* Rests for 3 s, moves at 4 Hz for 10 s between ramps of 1 s, and rests again. */
static double test_cycle(double t_s) { return 4e-3 * (ramp(t_s, 3, 4) - ramp(t_s, 14, 15)) * sin(TURN * 4.0 * (t_s - 3.0)); }

static void a_test_with_ramps_and_rests(void **unused) {
    (void)unused;
    slow_case();
    static const struct sensor sensors[] = {
        {.rate_hz = 500, .duration_s = 20},
        {.rate_hz = 500, .duration_s = 20, .noise_m = 1e-6},
        {.rate_hz = 500, .duration_s = 20, .noise_m = 5e-5},
        {.rate_hz = 500, .duration_s = 20, .step_m = 5e-5},
        {.rate_hz = 500, .duration_s = 20, .noise_m = 1e-5, .step_m = 2e-5, .lost = 0.03},
        {.rate_hz = 1000, .duration_s = 20, .noise_m = 1e-5, .jitter = 0.2},
        {.rate_hz = 100, .duration_s = 20, .noise_m = 1e-5, .lost = 0.02},
        {.rate_hz = 10000, .duration_s = 20, .noise_m = 2e-5, .step_m = 1e-6, .lost = 0.01},
        {.rate_hz = 333.3, .duration_s = 20, .noise_m = 2e-5, .step_m = 1e-6},
    };
    for (size_t i = 0; i < sizeof sensors / sizeof *sensors; i++)
        EXPECT(test_cycle, &sensors[i], {'R', 0, 3.0, 0.25}, {'M', 0, 3.75, 0.3}, {'S', 4.0, 14.2, 0.3}, {'M', 0, 15.0, 0.3},
               {'R', 0, 0, 0});
}

static double from_the_start(double t_s) { return 5e-3 * sin(TURN * 2.5 * t_s); }
static double hunting(double t_s) { return from_the_start(t_s) + 4e-4 * sin(TURN * 0.87 * t_s) + 2e-4 * sin(TURN * 89.0 * t_s); }
static double slow(double t_s) { return 5e-3 * sin(TURN * 0.21 * t_s); }
static double fast(double t_s) { return 1e-3 * sin(TURN * 22.0 * t_s); }
static double triangle_of(double hz, double t_s) { return 4.0 * fabs(hz * t_s - floor(hz * t_s + 0.5)) - 1.0; }
static double triangle(double t_s) { return 10e-3 * triangle_of(0.7, t_s); }
static double harmonics(double t_s) {
    double x = 0.0;
    for (int n = 1; n <= 7; n++) x += 1e-3 * cos(TURN * 0.8 * n * t_s + n * n);
    return x;
}

static void whatever_repeats_is_steady_from_end_to_end(void **unused) {
    (void)unused;
    slow_case();
    struct sensor coarse = good;
    coarse.noise_m = 1e-5, coarse.step_m = 2e-5;
    EXPECT(from_the_start, &good, {'S', 2.5, 20, 0.01});
    EXPECT(from_the_start, &coarse, {'S', 2.5, 20, 0.01});
    EXPECT(hunting, &good, {'S', 2.5, 20, 0.01});
    EXPECT(slow, &good, {'S', 0.21, 20, 0.01});
    EXPECT(slow, &coarse, {'S', 0.21, 20, 0.01});
    EXPECT(fast, &good, {'S', 22.0, 20, 0.01});
    EXPECT(triangle, &good, {'S', 0.7, 20, 0.01});
    EXPECT(triangle, &coarse, {'S', 0.7, 20, 0.01});
    EXPECT(harmonics, &good, {'S', 0.8, 20, 0.01});
}

static double stepped_sine(double t_s) {
    return t_s < 6.0 ? 5e-3 * sin(TURN * 1.0 * t_s) : t_s < 12.0 ? 3e-3 * sin(TURN * 3.0 * t_s) : 1e-3 * sin(TURN * 7.5 * t_s);
}
static double two_amplitudes(double t_s) { return (t_s < 8.0 ? 2e-3 : 4e-3) * sin(TURN * 2.0 * t_s); }
static double stumble(double t_s) { return from_the_start(t_s) + (fabs(t_s - 9.0) < 0.05 ? 2e-3 : 0.0); }
static double pauses(double t_s) { return (t_s < 6.0 || t_s >= 9.0 ? 4e-3 : 0.0) * sin(TURN * 2.0 * t_s); }

static void sines_in_succession_are_told_apart(void **unused) {
    (void)unused;
    slow_case();
    EXPECT(stepped_sine, &good, {'S', 1.0, 6.0, 0.2}, {'S', 3.0, 12.0, 0.1}, {'S', 7.5, 0, 0});
    EXPECT(pauses, &good, {'S', 2.0, 6.0, 0.05}, {'R', 0, 9.0, 0.05}, {'S', 2.0, 0, 0});
    EXPECT(stumble, &good, {'S', 2.5, 20, 0.01}); /* the motion stands still for a quarter of a
                                                   * cycle */
    EXPECT(two_amplitudes, &good, {'S', 2.0, 8.0, 0.3}, {'S', 2.0, 0, 0});
}

static double chirp(double t_s) { return 5e-3 * sin(TURN * (0.2 * t_s + 0.5 * (8.0 - 0.2) / 20.0 * t_s * t_s)); }
static double slow_chirp(double t_s) { return 5e-3 * sin(TURN * (1.0 * t_s + 0.5 * (3.0 - 1.0) / 60.0 * t_s * t_s)); }
static double log_chirp(double t_s) { return 5e-3 * sin(TURN * 0.2 * 20.0 / log(50.0) * (pow(50.0, t_s / 20.0) - 1.0)); }
static double multisine(double t_s) {
    static const double hz[] = {0.31, 0.83, 1.27, 1.93, 2.71, 3.37, 4.19, 5.03, 5.87, 6.71, 7.93, 8.89};
    double x = 0.0;
    for (int i = 0; i < 12; i++) x += 1e-3 * sin(TURN * hz[i] * t_s + 1.7 * i * i);
    return x;
}
static double drift(double t_s) { return 2e-3 * t_s; }
static double swell(double t_s) { return 2e-4 * t_s * sin(TURN * 3.0 * t_s); }

static void what_does_not_repeat_is_not_steady(void **unused) {
    (void)unused;
    slow_case();
    struct sensor coarse = good, minute = good;
    coarse.step_m = 5e-5, minute.duration_s = 60.0;
    motion *const motions[] = {chirp, log_chirp, multisine, drift};
    for (int i = 0; i < 4; i++) {
        expect("motion", motions[i], &good, (const struct expected[]){{'M', 0, 0, 0}}, 1);
        expect("motion", motions[i], &coarse, (const struct expected[]){{'M', 0, 0, 0}}, 1);
    }
    EXPECT(slow_chirp, &minute, {'M', 0, 0, 0});
    /* at first the motion is below 0.3 % of its final amplitude */
    EXPECT(swell, &minute, {'R', 0, 0.5, 0.2}, {'M', 0, 0, 0});
}

/* Stays for 1 s at each place, and takes 0.2 s to the next. */
static double steps(double t_s) {
    static const double place[] = {0, 5e-3, -2e-3, 8e-3, 1e-3, -6e-3, 3e-3, 9e-3};
    int i = (int)(t_s / 1.2);
    return i > 6 ? place[7] : place[i] + (place[i + 1] - place[i]) * ramp(t_s - 1.2 * i, 1.0, 1.2);
}

static void steps_are_rests_and_moves(void **unused) {
    (void)unused;
    struct sensor s = good;
    s.duration_s = 1.2 * 7 + 1.0;
    struct expected e[15];
    for (int i = 0; i < 15; i++) e[i] = (struct expected){i % 2 ? 'M' : 'R', 0, 1.2 * (i / 2) + (i % 2 ? 1.2 : 1.0), 0.05};
    expect("steps", steps, &s, e, 15);
    s.step_m = 5e-5;
    expect("steps", steps, &s, e, 15);
}

/* Half a second of a steady motion is lost, and later two seconds. */
static void a_hole_is_no_rest(void **unused) {
    (void)unused;
    struct recording_test t = measure(from_the_start, &good);
    struct segments p;
    int kept = 0;
    for (int i = 0; i < t.count; i++)
        if (fabs(t.sample[i].test_time_s - 9.0) > 0.25 && fabs(t.sample[i].test_time_s - 14.0) > 1.0) t.sample[kept++] = t.sample[i];
    t.count = kept;
    assert_int_equal(segments_find(&p, &t, sampling_step_s(&t, 0, t.count), TEST_LEGS, &error), 0);
    if (p.count != 1 || p.segment[0].kind != SEGMENT_STEADY || !(fabs(p.segment[0].frequency_hz / 2.5 - 1.0) < 1e-4))
        fail_msg("%s", show(&t, &p));
    segments_free(&p);
    free(t.sample);
}

static double jump(double t_s) { return t_s < 8.0 ? 0.0 : 5e-3; }

static void a_jump_between_two_samples_parts_two_rests(void **unused) {
    (void)unused;
    EXPECT(jump, &good, {'R', 0, 8.0, 0.02}, {'M', 0, 8.0, 0.02}, {'R', 0, 0, 0});
}

static double nothing(double t_s) { return 0.0 * t_s; }

static void a_machine_that_stands_still_rests(void **unused) {
    (void)unused;
    struct sensor silent = good, coarse = good;
    silent.noise_m = 0.0, coarse.step_m = 1e-6;
    EXPECT(nothing, &good, {'R', 0, 20, 0.01});
    EXPECT(nothing, &silent, {'R', 0, 20, 0.01});
    EXPECT(nothing, &coarse, {'R', 0, 20, 0.01});
}

/* Covers defects that no recording should have, and defects of a hostile one. */
static void too_little_is_one_segment(void **unused) {
    (void)unused;
    struct recording_test t = measure(from_the_start, &good);
    struct segments p;
    for (int count = 0; count < 12; count++) {
        t.count = count;
        assert_int_equal(segments_find(&p, &t, sampling_step_s(&t, 0, t.count), TEST_LEGS, &error), 0);
        assert_true(p.count == (count > 0));
        segments_free(&p);
    }
    t.count = 9000;
    for (int i = 0; i < 9000; i++) t.sample[i].refused = REFUSED_NO_NUMBER, t.sample[i].length_m[0] = (double)NAN;
    assert_int_equal(segments_find(&p, &t, sampling_step_s(&t, 0, t.count), TEST_LEGS, &error), 0);
    assert_true(p.count == 1 && p.segment[0].kind == SEGMENT_MOVING);
    segments_free(&p);
    for (int i = 0; i < 9000; i++) {
        struct recording_sample *s = &t.sample[i];
        s->refused = REFUSED_NOT, s->length_m[0] = i % 2 ? 1e300 : -1e300, s->test_time_s = i < 9 ? i : 1e15 * i;
    }
    assert_int_equal(segments_find(&p, &t, sampling_step_s(&t, 0, t.count), TEST_LEGS, &error), 0);
    assert_true(p.count >= 1 && p.segment[p.count - 1].end == 9000);
    segments_free(&p);
    free(t.sample);
}

/* A tenth of the time is recorded, 0.2 s of every 2 s. */
static void bursts_have_the_period_of_their_samples(void **unused) {
    (void)unused;
    struct recording_test t = measure(from_the_start, &good);
    int kept = 0;
    for (int i = 0; i < t.count; i++)
        if (i % 1000 < 100) t.sample[kept++] = t.sample[i];
    t.count = kept;
    struct sampling s = sampling_measure(&t);
    assert_close(s.step_s, 2e-3, 1e-9);
    assert_close(s.gap_s, 901 * 2e-3, 1e-9);
    assert_int_equal(s.lost, 9 * 900);
    assert_true(sampling_step_s(&t, 0, t.count) == s.step_s);
    free(t.sample);
}

/* A column with gaps has no five values in a row. */
static void noise_that_cannot_be_measured_is_nan_but_steps_are(void **unused) {
    (void)unused;
    const double nan = (double)NAN, still[] = {1.0, 1.0, 1.0, 1.0, nan, 1.0, 1.0, 1.0},
                 stepped[] = {1.0, 1.5, 3.0, nan, 1.5, 1.0, nan, 4.0};
    const double resting[] = {1.0, 1.0, 1.0, 1.0, 1.0};
    struct noise n = noise_measure(8, still, 1);
    assert_true(isnan(n.rms) && n.step == 0.0);
    n = noise_measure(8, stepped, 1);
    assert_float_equal(n.step, 0.5, 1e-12);
    assert_true(fabs(n.rms - 0.5 / sqrt(12.0)) < 1e-12);
    n = noise_measure(5, resting, 1);
    assert_true(n.rms == 0.0 && n.step == 0.0);
}

static void noise_and_steps_of_a_sensor_are_seen(void **unused) {
    (void)unused;
    static const struct sensor sensors[] = {{.rate_hz = 500, .duration_s = 20, .noise_m = 2e-5},
                                            {.rate_hz = 500, .duration_s = 20, .noise_m = 2e-5, .step_m = 1e-5},
                                            {.rate_hz = 500, .duration_s = 20, .step_m = 5e-5}};
    for (int i = 0; i < 3; i++) {
        struct recording_test t = measure(from_the_start, &sensors[i]);
        struct noise n = noise_measure(t.count, t.sample->length_m, sizeof *t.sample / sizeof(double));
        double rms = sqrt(sensors[i].noise_m * sensors[i].noise_m + sensors[i].step_m * sensors[i].step_m / 12.0);
        /* tolerance: the median of blocks of 32 is 4 % low, and steps of a slow sine are not quite
         * white */
        assert_close(n.rms / rms, 1.0, 0.15);
        assert_close(n.step, sensors[i].step_m, 1e-9);
        free(t.sample);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_test_with_ramps_and_rests),
        cmocka_unit_test(whatever_repeats_is_steady_from_end_to_end),
        cmocka_unit_test(sines_in_succession_are_told_apart),
        cmocka_unit_test(what_does_not_repeat_is_not_steady),
        cmocka_unit_test(steps_are_rests_and_moves),
        cmocka_unit_test(a_hole_is_no_rest),
        cmocka_unit_test(a_jump_between_two_samples_parts_two_rests),
        cmocka_unit_test(a_machine_that_stands_still_rests),
        cmocka_unit_test(too_little_is_one_segment),
        cmocka_unit_test(bursts_have_the_period_of_their_samples),
        cmocka_unit_test(noise_that_cannot_be_measured_is_nan_but_steps_are),
        cmocka_unit_test(noise_and_steps_of_a_sensor_are_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
