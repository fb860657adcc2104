/* The motion system's quality is measured in recordings with known results: they are made from the
 * reference with a gain, a delay, cross-talk, play and noise. tests/scenarios/qualify.sh measures
 * the simulated machine. */
#include "support.h"

#include <stdio.h>
#include <unistd.h>

#include "kinematics.h"
#include "quality_check.h"
#include "quality_report.h"
#include "trajectory_file.h"

/* The simple platform of these tests: how its pose follows from its reference. */
struct answer {
    double gain, delay_s, cross;   /* cross: y follows x by this factor */
    double play_m;                 /* width of the play of every axis [m, rad] */
    double noise_m;                /* rms of the white noise on every coordinate of the pose [m,
                                    * rad] */
    uint64_t seed;
};

struct rig {
    struct params params;
    struct kinematics kinematics;
    struct quality_plan plan;
    struct trajectory trajectory;
};

static struct rig rig;

static int set_up(void **unused) {
    (void)unused;
    struct error error;
    config_default(&rig.params);
    return kinematics_init(&rig.kinematics, &rig.params, &error) || quality_plan(&rig.plan, &rig.params, false, &error) ||
           quality_trajectory(&rig.plan, &rig.trajectory, &error);
}

static int tear_down(void **unused) {
    (void)unused;
    trajectory_free(&rig.trajectory);
    return 0;
}

static double play(double *held, double asked, double width) {
    *held = fmin(fmax(*held, asked - width / 2.0), asked + width / 2.0);
    return *held;
}

static struct cycle cycle_at(const struct answer *a, int n, double held[DOFS], uint64_t *random) {
    struct cycle c = {.test = 0, .dof = DOF_NONE, .phase = PHASE_EVALUATE, .test_time_s = rig.params.tests.ramp_s + n * rig.plan.step_s};
    double late[DOFS];
    trajectory_at(&rig.trajectory, n * rig.plan.step_s, c.ref);
    trajectory_at(&rig.trajectory, n * rig.plan.step_s - a->delay_s, late);
    for (int i = 0; i < DOFS; i++) c.pose[i] = a->gain * play(&held[i], late[i], a->play_m);
    c.pose[DOF_Y] += a->cross * c.pose[DOF_X];
    ik_lengths(&rig.kinematics, c.pose, c.in.length_m);
    for (int i = 0; i < DOFS; i++) c.pose[i] += a->noise_m * random_normal(random);
    return c;
}

static void record(struct quality_record *r, const struct answer *a) {
    struct error error;
    double held[DOFS] = {0};
    uint64_t random = a->seed;
    assert_int_equal(quality_record_init(r, &rig.plan, &error), 0);
    for (int n = 0; n < rig.plan.cycles; n++) {
        struct cycle c = cycle_at(a, n, held, &random);
        quality_record_take(r, &rig.plan, rig.params.tests.ramp_s, &c);
    }
}

static struct quality *measured(const struct answer *a) {
    struct error error;
    struct quality_record r;
    struct quality *q = calloc(1, sizeof *q);
    record(&r, a);
    struct quality_plan plan = rig.plan;
    assert_int_equal(quality_record_settle(&r, &plan, 1.0, &error), 0);
    assert_int_equal(quality_measure(q, &plan, &r, &rig.params, &error), 0);
    quality_record_free(&r);
    return q;
}

static void the_motion_lasts_ten_minutes_with_engaging_and_parking(void **unused) {
    (void)unused;
    const struct params *p = &rig.params;
    double s = rig.plan.cycles * rig.plan.step_s + p->tests.settle_s + p->tests.ramp_s + rig.plan.ramp_out_s + p->motion.engage_s +
               p->motion.park_s + p->motion.hold_s;
    assert_below(s, 600.0);
    assert_int_equal(rig.plan.tones, QUALITY_TONES);
    assert_int_equal(rig.plan.pieces, QUALITY_PIECES);
}

static void every_piece_starts_and_ends_at_neutral_and_none_overlap(void **unused) {
    (void)unused;
    int end = 0;
    for (const struct quality_piece *p = rig.plan.piece; p < rig.plan.piece + rig.plan.pieces; p++) {
        assert_int_equal(p->begin - p->lead - p->ramp_in, end);
        end = p->begin + p->samples + p->ramp_out;
        assert_close(quality_piece_at(&rig.plan, p, -p->lead - p->ramp_in), 0.0, 1e-15);
        assert_close(quality_piece_at(&rig.plan, p, p->samples + p->ramp_out), 0.0, 1e-15);
    }
    assert_int_equal(end, rig.plan.cycles);
}

/* Half the rate at 0.1 Hz or more is a way of 0.8 s at that rate; 1.5 / 0.3 of it is 4 s. */
static void a_stop_takes_four_seconds_at_most_however_slow_the_legs(void **unused) {
    (void)unused;
    for (double rate_mps = 0.64; rate_mps > 0.01; rate_mps /= 2.0) {
        struct error error;
        struct quality_plan slow;
        struct params params = rig.params;
        params.limits.leg_rate_mps = rate_mps;
        assert_int_equal(quality_plan(&slow, &params, false, &error), 0);
        assert_below(slow.ramp_out_s, 4.0);
        assert_true(slow.ramp_out_s > 1.0);
    }
}

/* So a log of either is measured alike: amplitudes are taken from the recorded reference. */
static void a_bus_changes_amplitudes_only(void **unused) {
    (void)unused;
    struct error error;
    struct quality_plan bus;
    assert_int_equal(quality_plan(&bus, &rig.params, true, &error), 0);
    assert_int_equal(bus.cycles, rig.plan.cycles);
    for (int i = 0; i < QUALITY_PIECES; i++) {
        struct quality_piece a = bus.piece[i], b = rig.plan.piece[i];
        assert_true(a.begin == b.begin && a.samples == b.samples && a.periods == b.periods && a.lead == b.lead && a.ramp_in == b.ramp_in);
    }
}

/* A tone needs at most a tenth of the legs' rate limit, and of half their stroke. The tests' bounds
 * are higher, because legs move nonlinearly. */
static void legs_keep_to_the_shares_of_stroke_and_rate(void **unused) {
    (void)unused;
    for (const struct quality_piece *p = rig.plan.piece; p < rig.plan.piece + rig.plan.pieces; p++) {
        double before[LEGS], now[LEGS], pose[DOFS] = {0}, rate = 0.0, way = 0.0;
        for (int n = 0; n < p->samples && p->kind == QUALITY_TONE; n++) {
            pose[p->dof] = quality_piece_at(&rig.plan, p, n);
            ik_lengths(&rig.kinematics, pose, now);
            for (int k = 0; k < LEGS; k++) {
                way = fmax(way, fabs(now[k] - rig.kinematics.neutral_length_m[k]));
                if (n) rate = fmax(rate, fabs(now[k] - before[k]) / rig.plan.step_s);
            }
            memcpy(before, now, sizeof now);
        }
        assert_below(rate, 0.11 * rig.params.limits.leg_rate_mps);
        assert_below(way, 0.12 * rig.params.actuator.stroke_m[0] / 2.0); /* the legs' curvature */
    }
}

static void a_gain_a_delay_and_cross_talk_are_measured(void **unused) {
    (void)unused;
    const struct answer a = {.gain = 0.9, .delay_s = 0.0073, .cross = 0.1};
    struct quality *q = measured(&a);
    for (int dof = 0; dof < DOFS; dof++) {
        for (int i = 0; i < QUALITY_TONES; i++) {
            /* tolerance: the error of the spline between the cycles is (w dt)^4 = 4e-5 at 20 Hz */
            assert_close(cabs(q->tone[dof][i].gain[dof]), 0.9, 1e-4);
            assert_close(quality_phase_deg(q, dof, i), -360.0 * 0.0073 * q->tone[dof][i].hz, 0.02);
        }
        assert_close(q->axis[dof].dead_s, 0.0073, 0.0035); /* tolerance: with a gain of 0.9, a tenth
                                                            * of the reference's step is reached
                                                            * later */
        assert_close(q->axis[dof].lag_s, 0.0073, 1e-5);
        assert_close(q->axis[dof].hysteresis / (0.9 * 2.0 * 0.0073 * q->axis[dof].slope_rate), 1.0, 1e-3);
    }
    assert_close(quality_cross(q, DOF_X, 3, DOF_Y), 0.09, 1e-5);
    assert_below(quality_cross(q, DOF_Z, 3, DOF_Y), 1e-9);
    assert_close(cabs(q->leg[0] / q->leg[5]), 1.0, 1e-4);
    free(q);
}

/* When a ramp has moved by the width of the play, the platform has moved by half of it. */
static void a_play_is_threshold_and_hysteresis(void **unused) {
    (void)unused;
    const struct answer a = {.gain = 1.0, .play_m = 2e-4};
    struct quality *q = measured(&a);
    for (int dof = 0; dof < DOFS; dof++) {
        assert_close(q->axis[dof].hysteresis, 2e-4, 1e-9);
        assert_close(q->axis[dof].threshold, 2e-4, 6e-5); /* tolerance: the axis may start anywhere
                                                           * in its play */
        assert_true(q->tone[dof][2].low > 1e-3 && q->axis[dof].turn_around > 0.01);
    }
    free(q);
}

/* A width of which the triangle shows nothing, wherever the platform rests in it, is not 0. */
static void a_play_wider_than_the_triangle_is_not_measured(void **unused) {
    (void)unused;
    slow_case();
    for (double factor = 0.6; factor < 4.0; factor += 0.8) {
        struct quality_check c[QUALITY_CHECKS];
        const struct qualify_params limits = {.up_to_hz = 2.0, .threshold_m = 1.0, .hysteresis_m = 1.0};
        double least = HUGE_VAL;
        for (const struct quality_piece *p = rig.plan.piece; p < rig.plan.piece + rig.plan.pieces; p++)
            if (p->kind == QUALITY_SLOPE) least = fmin(least, p->amplitude);
        struct quality *q = measured(&(struct answer){.gain = 1.0, .play_m = factor * least});
        int lacking = 0;
        for (int dof = 0; dof < DOFS; dof++) {
            lacking += isnan(q->axis[dof].hysteresis);
            assert_true(isnan(q->axis[dof].hysteresis) || fabs(q->axis[dof].hysteresis / (factor * least) - 1.0) < 1e-6);
        }
        assert_true(lacking > 0);
        quality_judge(q, NULL, &limits, c);
        assert_string_equal(c[8].key, "hysteresis_m");
        assert_int_equal(c[8].status, VERDICT_NOT_EVALUATED);
        if (factor > 1.0) assert_int_equal(c[7].status, VERDICT_NOT_EVALUATED);
        free(q);
    }
}

/* The standard deviations state the difference between two recordings: over 66 tones it agrees
 * within a fifth. */
static void the_stated_noise_is_that_between_two_recordings(void **unused) {
    (void)unused;
    slow_case();
    struct quality *one = measured(&(struct answer){.gain = 1.0, .noise_m = 1e-5, .seed = 1});
    struct quality *other = measured(&(struct answer){.gain = 1.0, .noise_m = 1e-5, .seed = 2});
    assert_close(quality_change_of_noise(one, other), 1.0, 0.2);
    /* up to f, white noise of 1e-5 has the rms 1e-5 sqrt(2 f / rate); its acceleration rises with
     * f^2 */
    double band = 1e-5 * pow(2.0 * PI * 20.0, 2.0) * sqrt(20.0 / 250.0 / 5.0);
    assert_close(quality_rest(one, DOF_X) / band, 1.0, 0.1);
    free(one), free(other);
}

static void lost_samples_are_joined_and_many_are_refused(void **unused) {
    (void)unused;
    slow_case();
    struct error error;
    struct quality_record r;
    struct quality q;
    const struct answer a = {.gain = 1.0};
    record(&r, &a);
    for (int n = 0; n < r.cycles; n += 211) r.there[n] = false, r.pose[n][0] = 1e3;
    struct quality_plan plan = rig.plan;
    assert_int_equal(quality_record_settle(&r, &plan, 1.0, &error), 0);
    assert_int_equal(quality_measure(&q, &plan, &r, &rig.params, &error), 0);
    assert_close(cabs(q.tone[0][8].gain[0]), 1.0, 1e-4);
    quality_record_free(&r);
    record(&r, &a);
    for (int n = 0; n < r.cycles; n += 90) r.there[n] = false;
    plan = rig.plan;
    assert_int_equal(quality_record_settle(&r, &plan, 1.0, &error), STATUS_USAGE);
    quality_record_free(&r);
}

/* Thirty samples are 0.01 % of the motion, and 3 % of this tone. */
static void a_gap_in_one_piece_is_refused_and_named(void **unused) {
    (void)unused;
    struct error error;
    struct quality_record r;
    struct quality_plan plan = rig.plan;
    int piece = 1 + DOF_PSI * (QUALITY_TONES + 4) + 6;
    assert_true(plan.piece[piece].kind == QUALITY_TONE && plan.piece[piece].dof == DOF_PSI);
    record(&r, &(struct answer){.gain = 1.0});
    for (int n = 0; n < 30; n++) r.there[plan.piece[piece].begin + 200 + n] = false;
    assert_int_equal(quality_record_settle(&r, &plan, 1.0, &error), STATUS_USAGE);
    assert_non_null(strstr(error.text, "30 of "));
    assert_non_null(strstr(error.text, "tone of psi"));
    quality_record_free(&r);
}

/* A motion that was stopped and started again is that of the last start, and nothing of a ramp-out
 * is taken. */
static void the_last_start_counts_and_a_ramp_out_does_not(void **unused) {
    (void)unused;
    struct error error;
    struct quality_record r;
    double held[DOFS] = {0};
    uint64_t random = 1;
    assert_int_equal(quality_record_init(&r, &rig.plan, &error), 0);
    for (int start = 0; start < 2; start++)
        for (int n = 0; n < 1000 - 500 * start; n++) {
            struct cycle c = cycle_at(&(struct answer){.gain = 1.0}, n, held, &random);
            if (n >= 400) c.phase = PHASE_RAMP_OUT;
            quality_record_take(&r, &rig.plan, rig.params.tests.ramp_s, &c);
            if (!start && n == 399) assert_true(r.there[399]);
            if (start && n == 100) assert_true(r.there[100] && !r.there[101] && !r.there[399]);
        }
    assert_true(r.there[399] && !r.there[400]);
    quality_record_free(&r);
}

static void a_ramp_of_half_a_cycle_more_is_as_the_loop_rounds_it(void **unused) {
    (void)unused;
    struct error error;
    struct quality_record r;
    struct cycle c = {.phase = PHASE_EVALUATE};
    double step_s = rig.plan.step_s;
    assert_int_equal(quality_record_init(&r, &rig.plan, &error), 0);
    c.test_time_s = round(250.6) * step_s;
    quality_record_take(&r, &rig.plan, 250.6 * step_s, &c);
    assert_true(r.there[0] && !r.there[1]);
    quality_record_free(&r);
}

static void a_loop_that_is_not_known_is_refused(void **unused) {
    (void)unused;
    struct error error;
    struct quality_plan plan;
    struct params params = rig.params;
    params.hydraulics.supply_pa = 1.5e5;
    assert_int_equal(quality_plan(&plan, &params, false, &error), STATUS_USAGE);
    assert_non_null(strstr(error.text, "hexid doctor"));
    params = rig.params;
    params.loop.period_s = 0.011;
    assert_int_equal(quality_plan(&plan, &params, false, &error), STATUS_USAGE);
    assert_non_null(strstr(error.text, "loop.period_s"));
}

static void another_motion_is_refused_with_axis_and_time(void **unused) {
    (void)unused;
    struct error error;
    struct quality_record r;
    struct quality_plan plan = rig.plan;
    record(&r, &(struct answer){.gain = 1.0});
    for (int n = 0; n < r.cycles; n++) r.ref[n][DOF_THETA] = 1.001 * r.ref[n][DOF_THETA] + 1e-5 * sin(n);
    assert_int_equal(quality_record_settle(&r, &plan, 1.0, &error), STATUS_USAGE);
    assert_non_null(strstr(error.text, "theta"));
    quality_record_free(&r);
}

static void limits_are_held_missed_or_not_evaluated(void **unused) {
    (void)unused;
    slow_case();
    struct quality *q = measured(&(struct answer){.gain = 0.97, .delay_s = 0.005});
    struct quality_check c[QUALITY_CHECKS];
    struct qualify_params limits = {.up_to_hz = 2.0, .amplitude_pct = 2.0, .phase_deg = 5.0, .excursion_m = 0.05, .repeat_mps2 = 0.5};
    quality_judge(q, NULL, &limits, c);
    assert_string_equal(c[0].key, "amplitude_pct");
    assert_true(c[0].status == VERDICT_FAIL && fabs(c[0].value - 3.0) < 0.01);
    assert_true(c[1].status == VERDICT_PASS && fabs(c[1].value - 3.6) < 0.01); /* 360 degrees times
                                                                                * 2 Hz times 5 ms */
    assert_int_equal(c[2].status, VERDICT_NOT_EVALUATED);
    /* there is a limit, but no baseline */
    assert_int_equal(c[QUALITY_CHECKS - 1].status, VERDICT_NOT_EVALUATED);
    assert_int_equal(quality_verdict(c), VERDICT_FAIL);
    limits.amplitude_pct = 3.1;
    quality_judge(q, NULL, &limits, c);
    assert_int_equal(quality_verdict(c), VERDICT_NOT_EVALUATED);
    quality_judge(q, q, &limits, c);
    assert_int_equal(quality_verdict(c), VERDICT_PASS);
    limits.excursion_m = 1.0; /* reached at least */
    quality_judge(q, q, &limits, c);
    assert_int_equal(quality_verdict(c), VERDICT_FAIL);
    free(q);
}

/* An axis without a value is no axis that holds the limit. */
static void a_value_that_is_missing_does_not_pass(void **unused) {
    (void)unused;
    struct quality *q = measured(&(struct answer){.gain = 0.97, .delay_s = 0.005}), *other = calloc(1, sizeof *other);
    struct quality_check c[QUALITY_CHECKS];
    struct qualify_params limits = {
        .up_to_hz = 20.0, .amplitude_pct = 99.0, .cross_talk_pct = 99.0, .harmonics_pct = 99.0, .balance_pct = 99.0, .repeat_mps2 = 99.0};
    *other = *q;
    quality_judge(q, other, &limits, c);
    for (int i = 0; i < QUALITY_CHECKS; i++) assert_int_equal(c[i].status, c[i].limit > 0.0 ? VERDICT_PASS : VERDICT_NOT_EVALUATED);
    q->tone[DOF_Z][2].gain[DOF_Z] = q->tone[DOF_X][1].gain[DOF_PHI] = q->leg[3] = q->tone[DOF_Y][4].low = (double)NAN;
    quality_judge(q, other, &limits, c);
    for (int i = 0; i < QUALITY_CHECKS; i++) assert_int_equal(c[i].status, VERDICT_NOT_EVALUATED);
    assert_true(c[0].lacks && !isnan(c[0].value) && isnan(quality_cross_most(q, DOF_X, 1)));
    limits.amplitude_pct = 1.0; /* the axes that are measured miss it */
    quality_judge(q, other, &limits, c);
    assert_int_equal(c[0].status, VERDICT_FAIL);
    free(q), free(other);
}

static void other_amplitudes_are_not_compared(void **unused) {
    (void)unused;
    struct quality *q = measured(&(struct answer){.gain = 0.97}), *other = calloc(1, sizeof *other);
    *other = *q;
    other->tone[DOF_X][3].amplitude *= 1.01;
    assert_close(quality_change(q, other, DOF_X, 3).mps2, 0.0, 1e-12);
    other->tone[DOF_X][3].amplitude *= 1.02;
    assert_true(isnan(quality_change(q, other, DOF_X, 3).mps2));
    free(q), free(other);
}

static void json_is_read_back_as_it_was(void **unused) {
    (void)unused;
    struct error error;
    struct quality_report *r = calloc(1, sizeof *r);
    struct quality *q = measured(&(struct answer){.gain = 0.97, .delay_s = 0.02, .noise_m = 1e-6});
    char path[] = "/tmp/hexid-quality-XXXXXX";
    int file = mkstemp(path);
    r->version = "1", r->log = "a\xff.lcm", r->law = "pid", r->quality = *q;
    quality_judge(q, NULL, &r->limits, r->check);
    char *json = quality_json(r);
    assert_true(file >= 0 && json && write(file, json, strlen(json)) == (ssize_t)strlen(json));
    assert_int_equal(quality_json_read(path, &r->before, &error), 0);
    for (int dof = 0; dof < DOFS; dof++)
        for (int i = 0; i < QUALITY_TONES; i++) assert_below(quality_change(q, &r->before, dof, i).of_noise, 1e-6);
    assert_close(r->before.axis[DOF_PSI].dead_s, q->axis[DOF_PSI].dead_s, 1e-12);
    r->quality.plan.tones = 0; /* a baseline without tones would compare nothing */
    free(json);
    json = quality_json(r);
    assert_int_equal(pwrite(file, json, strlen(json), 0), strlen(json));
    assert_int_equal(ftruncate(file, (off_t)strlen(json)), 0);
    assert_int_equal(quality_json_read(path, &r->before, &error), STATUS_USAGE);
    assert_int_equal(ftruncate(file, 100), 0);
    assert_int_equal(quality_json_read(path, &r->before, &error), STATUS_USAGE);
    assert_int_equal(quality_json_read("/nowhere/q.json", &r->before, &error), STATUS_IO);
    close(file), unlink(path);
    free(json), free(q), free(r);
}

/* Makes a report against a baseline: every gain is 3 % less than that of the reference, one tone of
 * z has no number, and one limit is missed. */
static struct quality_report *reported(void) {
    struct quality_report *r = calloc(1, sizeof *r);
    struct quality *before = measured(&(struct answer){.gain = 1.0, .noise_m = 1e-9, .seed = 1}),
                   *now = measured(&(struct answer){.gain = 0.97, .noise_m = 1e-9, .seed = 2});
    r->version = "1.2.3", r->log = "a<b>.lcm", r->law = "pid", r->baseline = "base&line.json";
    r->quality = *now, r->before = *before;
    r->quality.missing = 7;
    r->quality.tone[DOF_Z][2].gain[DOF_Z] = (double)NAN;
    r->limits = (struct qualify_params){.up_to_hz = 2.0, .amplitude_pct = 2.0, .phase_deg = 5.0};
    quality_judge(&r->quality, &r->before, &r->limits, r->check);
    free(now), free(before);
    return r;
}

static int times(const char *text, const char *words) {
    int n = 0;
    for (; (text = strstr(text, words)); text += strlen(words)) n++;
    return n;
}

#define assert_says(text, words)                                           \
    do {                                                                   \
        if (!strstr(text, words)) fail_msg("\"%s\" is not in\n%s", words, text); \
    } while (0)

static void the_text_has_every_tone_axis_and_limit(void **unused) {
    (void)unused;
    slow_case();
    struct quality_report *r = reported();
    char *text, samples[99];
    size_t size;
    FILE *out = open_memstream(&text, &size);
    quality_text(r, out);
    fclose(out);
    snprintf(samples, sizeof samples, "measured as, by %d samples, 7 of them missing; control.law pid;", rig.plan.cycles);
    assert_says(text, samples);
    assert_int_equal(times(text, " 0.9700 "), DOFS * QUALITY_TONES - 1);
    assert_int_equal(times(text, "\n"), 2 + DOFS * QUALITY_TONES + 3 + DOFS + 2 + QUALITY_CHECKS + 3);
    assert_says(text, "\nfail          amplitude");
    assert_says(text, ", limit 2  (");
    assert_says(text, "; some are not measured");
    assert_says(text, "\nagainst base&line.json: tones differ by ");
    assert_says(text, "\nverdict   fail\n");
    assert_null(strstr(text, "nan"));
    free(text), free(r);
}

/* Both pictures are drawn although a tone has no number. */
static void the_page_has_verdict_pictures_tones_and_baseline(void **unused) {
    (void)unused;
    slow_case();
    struct quality_report *r = reported();
    struct error error;
    char *page;
    if (quality_html(r, &page, &error)) fail_msg("%s", error.text);
    assert_says(page, "a&lt;b&gt;.lcm</code>");
    assert_says(page, "Measured as outside the operator&#39;s limits");
    assert_says(page, "<td class=\"off\">fail</td>");
    assert_int_equal(times(page, "<div class=\"picture\">"), 2);
    assert_int_equal(times(page, ">0.9700<"), DOFS * QUALITY_TONES - 1 + LEGS);
    assert_says(page, "<h2>Cross-talk</h2>");
    assert_says(page, "<h3>Leg balance: z at 0.5 Hz</h3>");
    assert_says(page, "Dashed: the baseline.");
    assert_says(page, "<h2>Against the baseline</h2>\n<p><code>base&amp;line.json</code>");
    assert_int_equal(times(page, ">-3.00 %<"), DOFS * QUALITY_TONES - 1);
    assert_null(strstr(page, "nan"));
    assert_says(page, "</html>\n");
    free(page);
    r->baseline = NULL, r->limits = (struct qualify_params){.up_to_hz = 2.0};
    quality_judge(&r->quality, NULL, &r->limits, r->check);
    assert_int_equal(quality_html(r, &page, &error), 0);
    assert_says(page, "Measured; not evaluated against all limits");
    assert_null(strstr(page, "gainst the baseline"));
    free(page), free(r);
}

/* Whatever share of the samples may be missing, a piece without any cannot be interpolated. */
static void a_record_without_a_sample_is_refused_at_any_limit(void **unused) {
    (void)unused;
    static struct quality_record r;
    struct quality_plan plan = rig.plan;
    struct error error;
    assert_int_equal(quality_record_init(&r, &plan, &error), 0);
    assert_int_equal(quality_record_settle(&r, &plan, 100.0, &error), STATUS_USAGE);
    quality_record_free(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_motion_lasts_ten_minutes_with_engaging_and_parking),
        cmocka_unit_test(a_record_without_a_sample_is_refused_at_any_limit),
        cmocka_unit_test(every_piece_starts_and_ends_at_neutral_and_none_overlap),
        cmocka_unit_test(a_stop_takes_four_seconds_at_most_however_slow_the_legs),
        cmocka_unit_test(a_bus_changes_amplitudes_only),
        cmocka_unit_test(legs_keep_to_the_shares_of_stroke_and_rate),
        cmocka_unit_test(a_gain_a_delay_and_cross_talk_are_measured),
        cmocka_unit_test(a_play_is_threshold_and_hysteresis),
        cmocka_unit_test(a_play_wider_than_the_triangle_is_not_measured),
        cmocka_unit_test(the_stated_noise_is_that_between_two_recordings),
        cmocka_unit_test(lost_samples_are_joined_and_many_are_refused),
        cmocka_unit_test(a_gap_in_one_piece_is_refused_and_named),
        cmocka_unit_test(the_last_start_counts_and_a_ramp_out_does_not),
        cmocka_unit_test(a_ramp_of_half_a_cycle_more_is_as_the_loop_rounds_it),
        cmocka_unit_test(a_loop_that_is_not_known_is_refused),
        cmocka_unit_test(another_motion_is_refused_with_axis_and_time),
        cmocka_unit_test(limits_are_held_missed_or_not_evaluated),
        cmocka_unit_test(a_value_that_is_missing_does_not_pass),
        cmocka_unit_test(other_amplitudes_are_not_compared),
        cmocka_unit_test(json_is_read_back_as_it_was),
        cmocka_unit_test(the_text_has_every_tone_axis_and_limit),
        cmocka_unit_test(the_page_has_verdict_pictures_tones_and_baseline),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
