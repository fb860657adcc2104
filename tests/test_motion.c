/* Any motion: recognises steady sinusoids and cuts everything else into segments. */
#include "support.h"

#include <math.h>
#include <stdlib.h>

#include "config.h"
#include "measured.h"
#include "motion.h"
#include "residual.h"
#include "sampling.h"
#include "units.h"

static const double AMPLITUDE_M = 5e-3;
static double step_s = 1e-3;
static struct params params;

static int set_up(void **unused) {
    (void)unused;
    struct error error;
    return config_load(&params, "config/axis.yaml", NULL, 0, &error);
}

typedef double path(double t_s);

static double sine(double t_s) { return sin(2.0 * PI * t_s); }
static double distorted(double t_s) { return sine(t_s) + 0.12 * sin(6.0 * PI * t_s); }
static double triangle(double t_s) { return 2.0 / PI * asin(sin(2.0 * PI * t_s)); }
static double rests(double t_s) { return fmod(t_s, 10.0) < 5.0 ? sine(t_s) : 0.0; }
static double sweep(double t_s) { return sin(2.0 * PI * (0.3 * t_s + 0.05 * t_s * t_s)); }
static double still(double t_s) { return 0.0 * t_s; }

/* Records a motion along a path for `seconds`, with a force and sensor noise. */
static void record(struct recording *r, path *along, double seconds, double stated_hz) {
    uint64_t state = 3;
    struct error error;
    recording_init(r, &params);
    r->run[0].hz[DOF_X] = stated_hz;
    for (int i = 0; i * step_s < seconds; i++) {
        struct cycle c = {.seq = (uint64_t)i, .test = 0, .dof = DOF_X, .phase = PHASE_EVALUATE, .test_time_s = i * step_s};
        for (int k = 0; k < LEGS; k++) c.in.length_m[k] = c.in.p1_pa[k] = c.in.p2_pa[k] = c.out.valve[k] = c.force_n[k] = (double)NAN;
        c.in.length_m[0] = AMPLITUDE_M * along(i * step_s) + 2e-6 * random_unit(&state);
        c.force_n[0] = 100.0 * along(i * step_s);
        assert_int_equal(recording_add(r, &c, &error), STATUS_OK);
    }
    recording_settle(r);
}

static enum cut_lacks cut(struct recording *r) {
    struct motion_cut found;
    struct error error;
    assert_int_equal(motion_cut(r, 0, &found, &error), STATUS_OK);
    return found.lacks;
}

static bool steady(path *along, double stated_hz, double hz) {
    struct recording r;
    record(&r, along, 12.0, stated_hz);
    bool is = motion_sinusoid(&r.test[0], 1, hz);
    recording_free(&r);
    return is;
}

static void a_sinusoid_is_told_from_other_motions(void **unused) {
    (void)unused;
    assert_true(steady(sine, 1.0, 1.0));
    assert_true(steady(sine, 3.0, 1.0)); /* whatever was stated */
    assert_false(steady(triangle, 3.0, 1.0));
    assert_false(steady(rests, 1.0, 1.0));
    assert_false(steady(sweep, 1.0, 1.0));
    assert_false(steady(still, 1.0, 1.0));
    assert_false(steady(sine, 1.0, (double)NAN));
    assert_true(steady(distorted, 1.0, 1.0)); /* the distorted motion of a weak loop, if its
                                               * frequency is stated; otherwise another motion */
    assert_false(steady(distorted, 3.0, 1.0));
}

/* Segments follow one another inside the record, each with its margins; no segment is at rest. */
static void segments_cover_what_moves(void **unused) {
    (void)unused;
    struct recording r;
    record(&r, rests, 30.0, 1.0);
    assert_int_equal(cut(&r), CUT_NOTHING);
    assert_in_range(r.tests, 6, 48);
    double moving_s = 0.0;
    for (int i = 0; i < r.tests; i++) {
        const struct recording_test *t = &r.test[i];
        double margin_s = residual_margin_s(t->segment_s);
        assert_true(t->segment_s > 0.0 && t->segment == i && t->borrowed == (i > 0) && t->sample == r.test[0].sample);
        assert_true(t->sample[t->first].test_time_s <= t->start_s - margin_s &&
                    t->start_s + t->segment_s + margin_s <= t->sample[t->end - 1].test_time_s + step_s);
        if (i) assert_true(t->start_s >= r.test[i - 1].start_s + 0.999 * t->segment_s);
        bool rest = fmod(t->start_s, 10.0) > 5.0 + margin_s && fmod(t->start_s + t->segment_s, 10.0) > 5.0;
        assert_false(rest && fmod(t->start_s + t->segment_s + margin_s, 10.0) > 5.0);
        moving_s += t->segment_s;
    }
    assert_true(moving_s > 10.0);
    recording_free(&r);
}

static double two_tones(double t_s) { return sin(2.0 * PI * 1.7 * t_s) + 0.5 * sin(2.0 * PI * 2.9 * t_s); }

/* A record in bursts has the same motion, and so the same segments. */
static void a_record_in_bursts_is_cut_as_it_moves(void **unused) {
    (void)unused;
    static const double lasts_s[] = {5.0, 2.0, 1.5}, every_s[] = {5.0, 5.0, 4.0};
    double whole_s = (double)NAN;
    step_s = 2e-3;
    for (int n = 0; n < 3; n++) {
        struct recording r;
        record(&r, two_tones, 60.0, 1.0);
        struct recording_test *t = &r.test[0];
        int kept = 0;
        for (int i = 0; i < t->count; i++)
            if (fmod(t->sample[i].test_time_s, every_s[n]) < lasts_s[n]) t->sample[kept++] = t->sample[i];
        t->count = t->end = kept;
        if (cut(&r)) fail_msg("%g s of %g s", lasts_s[n], every_s[n]);
        if (!n) whole_s = t->segment_s;
        assert_close(t->segment_s, whole_s, 0.2 * whole_s); /* tolerance: one bin of the shortest
                                                             * segments */
        recording_free(&r);
    }
    step_s = 1e-3;
}

static void what_is_too_short_or_still_is_refused(void **unused) {
    (void)unused;
    struct recording r;
    record(&r, sweep, 1.0, 1.0);
    assert_int_equal(cut(&r), CUT_SEGMENTS);
    assert_int_equal(r.tests, 1);
    recording_free(&r);
    record(&r, sweep, 20.0, 1.0);
    /* two of three samples are lost */
    for (int i = 0; i < r.test[0].count; i++) r.test[0].sample[i].refused = i % 3 ? REFUSED_LATE : REFUSED_NOT;
    assert_int_equal(cut(&r), CUT_SEGMENTS);
    recording_free(&r);
}

/* In a short record with slow sampling, the samples limit the band, but suffice for every segment's
 * series. */
static void a_slow_rate_limits_the_band(void **unused) {
    (void)unused;
    struct recording r;
    struct residual_data d;
    struct error error;
    step_s = 0.01;
    record(&r, sweep, 8.0, 1.0);
    step_s = 1e-3;
    /* occasionally a sample is lost */
    for (int i = 0; i < r.test[0].count; i += 23) r.test[0].sample[i].refused = REFUSED_LATE;
    assert_int_equal(cut(&r), CUT_NOTHING);
    assert_int_equal(measured_make(&r, 0, &error), STATUS_OK);
    if (residual_prepare(&d, &r, CYCLES_ALL, &error)) fail_msg("%s", error.text);
    assert_int_equal(d.tests, r.tests);
    residual_free(&d);
    recording_free(&r);
}

/* A segment's row reproduces the signal: a known acceleration is recovered from noisy lengths
 * within its stated deviation. */
static void a_segment_knows_its_acceleration(void **unused) {
    (void)unused;
    struct recording r;
    struct residual_data d;
    struct error error;
    double needed[LEGS][RESIDUAL_SIZE], square = 0.0, off = 0.0;
    record(&r, sweep, 20.0, 1.0);
    assert_int_equal(cut(&r), CUT_NOTHING);
    for (int i = 0; i < r.test[0].count; i++) { /* the force is what a mass without friction
                                                 * needs */
        double t = i * step_s, phase = 2.0 * PI * (0.3 * t + 0.05 * t * t), w = 2.0 * PI * (0.3 + 0.1 * t);
        r.test[0].sample[i].force_n[0] = params.axis.mass_kg * AMPLITUDE_M * (0.2 * PI * cos(phase) - w * w * sin(phase));
    }
    struct params bare = params;
    for (int k = 0; k < LEGS; k++) bare.hydraulics.viscous_n_s_per_m[k] = 0.0;
    assert_int_equal(measured_make(&r, 0, &error), STATUS_OK);
    if (residual_prepare(&d, &r, CYCLES_ALL, &error)) fail_msg("%s", error.text);
    assert_int_equal(d.tests, r.tests);
    for (int i = 0; i < d.tests; i++) {
        assert_true(residual_required(&d.test[i], &bare, needed));
        for (int a = 0; a < d.test[i].size; a++) {
            square += pow(d.test[i].row[CHANNEL_FORCE][0][a], 2.0);
            off += pow(d.test[i].row[CHANNEL_FORCE][0][a] - needed[0][a], 2.0);
        }
    }
    assert_below(sqrt(off / square), 0.02);
    residual_free(&d);
    assert_int_equal(residual_prepare(&d, &r, CYCLES_EVEN, &error), STATUS_OK);
    assert_int_equal(d.tests, (r.tests + 1) / 2); /* every other segment */
    residual_free(&d);
    recording_free(&r);
}

static double cosine(double t_s) { return cos(2.0 * PI * t_s); }

/* The axis, with 100 N of dry friction. */
static struct params with_friction(void) {
    struct params dry = params;
    struct effect_values *coulomb = &dry.effects[effect_find("cylinder_coulomb_friction")];
    coulomb->on = true;
    coulomb->value[0][0] = coulomb->value[1][0] = 100.0;
    return dry;
}

/* Returns the variance of a cycle's mean force by the friction of a leg while it is held. */
static double mean_by_held_leg(path *along) {
    static double covariance[LEGS][RESIDUAL_SIZE][RESIDUAL_SIZE];
    struct recording r;
    struct residual_data d;
    struct error error;
    struct params dry = with_friction();
    record(&r, along, 12.0, 1.0);
    r.test[0].frequency_hz = 1.0;
    assert_int_equal(measured_make(&r, 0, &error), STATUS_OK);
    if (residual_prepare(&d, &r, CYCLES_ALL, &error)) fail_msg("%s", error.text);
    assert_true(d.test[0].spectrum.cycles > 0);
    residual_held(&d.test[0], &dry, covariance);
    residual_free(&d);
    recording_free(&r);
    return covariance[0][0][0];
}

/* A leg that is held when a cycle ends is still held when the next one begins. */
static void where_a_cycle_begins_is_no_matter(void **unused) {
    (void)unused;
    double sine_n2 = mean_by_held_leg(sine), cosine_n2 = mean_by_held_leg(cosine);
    assert_true(sine_n2 > 0.0);
    assert_close(cosine_n2 / sine_n2, 1.0, 0.01);
}

/* A lagging force sensor shows less of what a held leg does, as it shows less of any force. */
static void friction_of_a_held_leg_is_seen_through_the_sensor(void **unused) {
    (void)unused;
    static double sure[LEGS][RESIDUAL_SIZE][RESIDUAL_SIZE], lags[LEGS][RESIDUAL_SIZE][RESIDUAL_SIZE];
    struct recording r;
    struct residual_data d;
    struct error error;
    struct params dry = with_friction();
    record(&r, sweep, 20.0, 1.0);
    assert_int_equal(cut(&r), CUT_NOTHING);
    assert_int_equal(measured_make(&r, 0, &error), STATUS_OK);
    if (residual_prepare(&d, &r, CYCLES_ALL, &error)) fail_msg("%s", error.text);
    const struct residual_test *t = &d.test[0];
    residual_held(t, &dry, sure);
    dry.axis.force_lag_s = 0.02;
    residual_held(t, &dry, lags);
    assert_true(t->rate[t->size - 1] * dry.axis.force_lag_s > 0.5);
    for (int a = 0; a < t->size; a++) {
        assert_true(sure[0][a][a] > 0.0);
        assert_close(lags[0][a][a] / sure[0][a][a] * (1.0 + pow(t->rate[a] * dry.axis.force_lag_s, 2.0)), 1.0, 1e-9);
    }
    residual_free(&d);
    recording_free(&r);
}

/* Differences from the recorded path away from its ends, of the series alone and with the fast
 * motion added. Lengths have the maximum; rates have the rms, because a corner has no rate. */
struct differences {
    double series_m, length_m, series_mps, rate_mps;
};

static struct differences differ(const struct recording *r, path *along) {
    static const double from_s = 2.0, until_s = 5.0, h = 1e-4;
    double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE], value[3];
    struct spectrum s;
    struct fast_motion f;
    struct differences d = {0};
    int n = 0;
    assert_true(spectrum_cut(&s, &r->test[0], from_s, until_s, 2.0 * PI / (1.2 * (until_s - from_s)), inverse));
    assert_true(fast_motion_fit(&f, &r->test[0], sampling_step_s(&r->test[0], r->test[0].first, r->test[0].end), &s, from_s, until_s));
    for (double t_s = from_s + 0.2; t_s < until_s - 0.2; t_s += 3.7e-4, n++) {
        double x = AMPLITUDE_M * along(t_s), v = AMPLITUDE_M * (along(t_s + h) - along(t_s - h)) / (2.0 * h);
        spectrum_value(s.mean[CHANNEL_LENGTH][0], s.harmonics, s.omega, t_s, value);
        double length_m = value[0], rate_mps = value[1];
        fast_motion_add(&f, 0, t_s, 1.0, &length_m, &rate_mps);
        d.series_m = fmax(d.series_m, fabs(value[0] - x)), d.length_m = fmax(d.length_m, fabs(length_m - x));
        d.series_mps += pow(value[1] - v, 2.0), d.rate_mps += pow(rate_mps - v, 2.0);
    }
    d.series_mps = sqrt(d.series_mps / n), d.rate_mps = sqrt(d.rate_mps / n);
    fast_motion_free(&f);
    return d;
}

/* Returns the differences for a record with a gap of lost_s about every half second, shifted by
 * shift_s. */
static struct differences differ_without(path *along, double lost_s, double shift_s) {
    struct recording r;
    record(&r, along, 7.0, 1.0);
    for (int i = 0; i < r.test[0].count; i++) {
        struct recording_sample *sample = &r.test[0].sample[i];
        bool lost = fmod(sample->test_time_s - shift_s + 0.5 + 0.5 * lost_s, 0.5) < lost_s;
        if (lost) sample->refused = REFUSED_NO_NUMBER, sample->length_m[0] = (double)NAN;
    }
    struct differences d = differ(&r, along);
    recording_free(&r);
    return d;
}

/* At a triangle's corners a series of 4.4 Hz is off by 0.5 mm and a third of the speed. Local lines
 * over 19 ms to either side round the corners by 0.1 mm (20 mm/s times a quarter of that), over 30
 * ms by 0.15 mm. */
static void what_the_series_lacks_is_in_the_fast_motion(void **unused) {
    (void)unused;
    struct differences d = differ_without(triangle, 0.0, 0.0);
    assert_true(d.series_m > 4e-4 && d.series_mps > 6e-3);
    assert_below(d.length_m, 1.1e-4);
    assert_below(d.rate_mps, 2.6e-3);
    /* gaps on the straight parts, then at the corners */
    d = differ_without(triangle, 0.06, 0.0);
    assert_below(d.length_m, 1.1e-4);
    assert_below(d.rate_mps, 2.6e-3);
    d = differ_without(triangle, 0.06, 0.25);
    assert_true(d.length_m < d.series_m && d.rate_mps < d.series_mps);
    /* each window has three samples */
    step_s = 0.01;
    d = differ_without(triangle, 0.0, 0.0);
    step_s = 1e-3;
    assert_below(d.length_m, 1.6e-4);
    assert_below(d.rate_mps, 3.2e-3);
    /* a complete series leaves only noise of 2 um */
    d = differ_without(two_tones, 0.0, 0.0);
    assert_below(d.length_m, 1e-6);
    assert_below(d.rate_mps, 5e-5);
}

/* The motion in a gap at a corner is unknown; a gap between two corners hides nothing unknown. */
static void a_gap_is_bridged_where_the_motion_goes_on(void **unused) {
    (void)unused;
    static const struct {
        path *along;
        double at_s;
    } cases[] = {{two_tones, 0.25}, {triangle, 0.5}, {triangle, 0.25}};
    for (int n = 0; n < 3; n++) {
        struct recording r;
        record(&r, cases[n].along, 30.0, 1.0);
        for (int i = 0; i < r.test[0].count; i++)
            if (fabs(fmod(i * step_s, 0.5) - fmod(cases[n].at_s, 0.5)) <= 0.0025) r.test[0].sample[i].refused = REFUSED_LATE;
        assert_int_equal(cut(&r), n == 2 ? CUT_TURNS : CUT_NOTHING);
        recording_free(&r);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sinusoid_is_told_from_other_motions),
        cmocka_unit_test(segments_cover_what_moves),
        cmocka_unit_test(a_record_in_bursts_is_cut_as_it_moves),
        cmocka_unit_test(what_is_too_short_or_still_is_refused),
        cmocka_unit_test(a_slow_rate_limits_the_band),
        cmocka_unit_test(a_segment_knows_its_acceleration),
        cmocka_unit_test(where_a_cycle_begins_is_no_matter),
        cmocka_unit_test(friction_of_a_held_leg_is_seen_through_the_sensor),
        cmocka_unit_test(what_the_series_lacks_is_in_the_fast_motion),
        cmocka_unit_test(a_gap_is_bridged_where_the_motion_goes_on),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}
