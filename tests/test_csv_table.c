/* Channels with different clocks, and sparse, repeated or integrated channels, are brought onto one
 * clock without a change of their values. */
#include "csv_rig.h"

#include <math.h>

#include "csv_hold.h"
#include "csv_map.h"
#include "csv_series.h"
#include "csv_speed.h"
#include "units.h"

enum { SECONDS_ALL = 10 };
static const double HZ = 1.0, AMPLITUDE_MM = 20.0, PEAK_N = 500.0;

static double place_mm(double t_s) { return AMPLITUDE_MM * sin(2.0 * PI * HZ * t_s); }
static double force_n(double t_s) { return PEAK_N * cos(2.0 * PI * HZ * t_s); }

static double uniform(uint64_t *state) { return (double)(random_bits(state) >> 11) * 0x1p-53; }

static double gaussian(uint64_t *state) { return sqrt(-2.0 * log(1.0 - uniform(state))) * cos(2.0 * PI * uniform(state)); }

static char text[4 * BUFFER];
static struct csv_map map;

#define assert_near(a, b, within) assert_true(fabs((a) - (b)) <= (within))

static int import_by(const char *names) {
    if (names && csv_map_parse(&map, names, &error)) fail_msg("%s", error.text);
    return csv_import(&(struct csv_source){.path = in, .map = names ? &map : NULL}, log_a, &report, &error);
}

/* Imports the file and compares every cycle with the truth at the cycle's own time. Returns the
 * number of rows. */
static int assert_truth(const char *names, double place_within_mm, double force_within_n) {
    if (import_by(names)) fail_msg("%s", error.text);
    struct recording *r = load(log_a);
    for (int i = 0; i < r->count; i++) {
        double t_s = r->cycle[i].test_time_s, mm = 1e3 * r->cycle[i].in.length_m[0], n = r->cycle[i].force_n[0];
        if (!(fabs(mm - place_mm(t_s)) <= place_within_mm)) fail_msg("at %g s: %.9g mm, not %.9g", t_s, mm, place_mm(t_s));
        if (!(fabs(n - force_n(t_s)) <= force_within_n)) fail_msg("at %g s: %.9g N, not %.9g", t_s, n, force_n(t_s));
    }
    return r->count;
}

/* Tolerance: halfway between samples, a cubic's error is 3/128 (w step)^4 of the amplitude, which
 * is 2.3e-8 at 200 Hz. */
static void two_clocks_in_one_file_are_brought_together(void **unused) {
    (void)unused;
    int used = sprintf(text, "t_s,position_mm,Time [ms],force_n\n");
    for (int i = 0; i < SECONDS_ALL * 200; i++) {
        double a_s = 0.005 * i, b_s = 0.005 * i + 0.0017;
        used += sprintf(text + used, "%.6f,%.9f,%.6f,%.9f\n", a_s, place_mm(a_s), 1e3 * b_s, force_n(b_s));
    }
    empty(NULL);
    put("1.csv", text);
    int rows = assert_truth("t=t_s:s,t=Time [ms]", 1e-6 * AMPLITUDE_MM, 1e-8);
    assert_int_equal(rows, SECONDS_ALL * 200 - 1);
    assert_non_null(strstr(report.notes, "rows are those of force_n, 200 Hz"));
}

/* Columns of time with the same name are told apart by their place: each is the clock of the
 * columns after it. */
static void a_name_of_time_that_is_there_twice_is_two_clocks(void **unused) {
    (void)unused;
    int used = sprintf(text, "Name,pos,Name,F\n");
    for (int i = 0; i < SECONDS_ALL * 200; i++)
        used += sprintf(text + used, "%.4f,%.9f,%.4f,%.9f\n", 0.005 * i, place_mm(0.005 * i), 0.005 * i, force_n(0.005 * i));
    empty(NULL);
    put("1.csv", text);
    assert_int_equal(assert_truth("t=Name:s,position=pos:mm,force=F:N", 1e-8, 1e-8), SECONDS_ALL * 200);
}

/* The channels have different lengths, so cells are empty below the end of the shorter one. */
static void a_slow_channel_beside_a_fast_one_makes_the_rows(void **unused) {
    (void)unused;
    int used = sprintf(text, "t_s,position_mm,t2,force_n\n");
    for (int i = 0; i < SECONDS_ALL * 500; i++) {
        used += sprintf(text + used, "%.4f,%.9f,", 0.002 * i, place_mm(0.002 * i));
        if (i < SECONDS_ALL * 50) used += sprintf(text + used, "%.4f,%.9f\n", 0.02 * i, force_n(0.02 * i));
        else used += sprintf(text + used, ",\n");
    }
    empty(NULL);
    put("1.csv", text);
    assert_int_equal(assert_truth("t=t_s:s,t=t2:s", 1e-8, 1e-8), SECONDS_ALL * 50);
}

/* A table as ros2 and PlotJuggler write it when they merge two topics: it has a row for each
 * message, and two rows for messages of the same time. */
static void rows_with_one_channel_each_are_merged(void **unused) {
    (void)unused;
    for (int apart_us = 0; apart_us <= 700; apart_us += 700) {
        int used = sprintf(text, "t_s,position_mm,force_n\n");
        for (int i = 0; i < SECONDS_ALL * 200; i++) {
            double a_s = 0.005 * i, b_s = a_s + 1e-6 * apart_us;
            used += sprintf(text + used, "%.6f,%.9f,\n%.6f,,%.9f\n", a_s, place_mm(a_s), b_s, force_n(b_s));
        }
        empty(NULL);
        put("1.csv", text);
        assert_true(assert_truth(NULL, 1e-6 * AMPLITUDE_MM, 1e-8) >= SECONDS_ALL * 200 - 1);
        assert_true(report.lost == 0);
    }
}

/* A topic of 1 kHz is read, another one of 100 Hz is not, or is a command. Its rows come at the
 * same times, or between them; ten of eleven rows are the first topic's. */
static void rows_of_a_topic_that_is_not_read_are_left_out(void **unused) {
    (void)unused;
    for (int kind = 0; kind < 4; kind++) {
        int used = sprintf(text, "t_s,position_mm,force_n,%s\n", kind < 2 ? "temperature" : "u");
        for (int i = 0; i < 4000; i++) {
            double t_s = 0.001 * i;
            used += sprintf(text + used, "%.6f,%.9f,%.9f,\n", t_s, place_mm(t_s), force_n(t_s));
            if (i % 10 == 0) used += sprintf(text + used, "%.6f,,,0.25\n", t_s + (kind % 2 ? 0.0003 : 0.0));
        }
        empty(NULL);
        put("1.csv", text);
        assert_int_equal(assert_truth(NULL, 1e-8, 1e-8), 4000);
        assert_int_equal(report.lost, 0);
        assert_near(report.rate_hz > 0.0 ? report.rate_hz : 500.0, 1000.0, 0.1);
        assert_true(kind < 2 || load(log_a)->cycle[500].out.valve[0] == 0.25);
    }
}

static void files_without_a_common_column_are_one_test(void **unused) {
    (void)unused;
    empty(NULL);
    int used = sprintf(text, "t_ms,position_mm\n");
    for (int i = 0; i < SECONDS_ALL * 250; i++) used += sprintf(text + used, "%d,%.9f\n", 4 * i, place_mm(0.004 * i));
    put("position.csv", text);
    used = sprintf(text, "stamp;Kraft\n");
    for (int i = 0; i < SECONDS_ALL * 100; i++) used += sprintf(text + used, "%.4f;%.9f\n", 0.01 * i + 0.003, force_n(0.01 * i + 0.003));
    put("force.csv", text);
    put("temperature.csv", "t_s,degC\n0,20\n1,21\n");
    assert_true(assert_truth("t=t_ms:ms,t=stamp:s,t=t_s:s,force=Kraft:N", 1e-6 * AMPLITUDE_MM, 1e-8) >= SECONDS_ALL * 100 - 2);
    assert_int_equal(report.files, 1);
    /* the two clocks have no time in common */
    used = sprintf(text, "stamp;Kraft\n");
    for (int i = 0; i < SECONDS_ALL * 100; i++) used += sprintf(text + used, "%.4f;%.9f\n", 1.6e9 + 0.01 * i, force_n(0.01 * i));
    put("force.csv", text);
    assert_int_equal(import_by("t=t_ms:ms,t=stamp:s,t=t_s:s,force=Kraft:N"), STATUS_USAGE);
    assert_says("no time in common|position_m from 0|force_n from 1600000000|SECONDS");
    assert_int_equal(assert_truth("t=t_ms:ms,t=stamp:s-1600000000,t=t_s:s,force=Kraft:N", 1e-6 * AMPLITUDE_MM, 1e-3), SECONDS_ALL * 100);
}

static void parts_of_different_kinds_are_refused(void **unused) {
    (void)unused;
    static const struct {
        const char *force, *says;
    } cases[] = {
        {"force [N]", "position.csv:1|turns|force.csv|slides|factor in --map"},
        {"force [stone]", "force.csv:1|force [stone]: no unit that hexid knows"},
    };
    for (int i = 0; i < 2; i++) {
        empty(NULL);
        int used = sprintf(text, "t_s,position [deg]\n");
        for (int k = 0; k < SECONDS_ALL * 250; k++) used += sprintf(text + used, "%.4f,%.9f\n", 0.004 * k, place_mm(0.004 * k));
        put("position.csv", text);
        used = sprintf(text, "t_s,%s\n", cases[i].force);
        for (int k = 0; k < SECONDS_ALL * 100; k++) used += sprintf(text + used, "%.4f,%.9f\n", 0.01 * k, force_n(0.01 * k));
        put("force.csv", text);
        assert_int_equal(import_by(NULL), STATUS_USAGE);
        assert_says(cases[i].says);
    }
}

static void too_many_clocks_are_refused(void **unused) {
    (void)unused;
    int used = 0;
    for (int i = 0; i < CSV_CLOCKS + 1; i++) used += sprintf(text + used, "Time,%s,", i == 0 ? "x" : i == CSV_CLOCKS ? "f" : "other");
    text[used - 1] = '\n';
    for (int row = 0; row < 100; row++) {
        for (int i = 0; i < CSV_CLOCKS + 1; i++) used += sprintf(text + used, "%.3f,%d,", 0.005 * row, row);
        text[used - 1] = '\n';
    }
    empty(NULL);
    put("1.csv", text);
    assert_int_equal(import_by("t=Time:s,position=x:mm,force=f:N"), STATUS_USAGE);
    assert_says("1.csv:1|more than 16 columns of time|--map t=#1:s");
    assert_int_equal(import_by("t=#1:s,t=#33:s,position=x:mm,force=f:N"), STATUS_OK);
}

/* The force is new in every fifth row, the position in every row. */
static void a_repeated_channel_counts_where_it_is_new(void **unused) {
    (void)unused;
    int used = sprintf(text, "t_s,position_mm,force_n\n");
    double held = 0.0;
    for (int i = 0; i < SECONDS_ALL * 500; i++) {
        if (i % 5 == 0) held = force_n(0.002 * i);
        used += sprintf(text + used, "%.4f,%.9f,%.9f\n", 0.002 * i, place_mm(0.002 * i), held);
    }
    empty(NULL);
    put("1.csv", text);
    assert_int_equal(assert_truth(NULL, 1e-8, 1e-8), SECONDS_ALL * 100);
    assert_non_null(strstr(report.notes, "force_n is repeated 5 times, at 100 Hz in rows of 500 Hz"));
    assert_non_null(strstr(report.notes, "mean delay of 4 ms"));
}

/* Returns for how many rows csv_hold finds a sine of 1 Hz repeated. A device samples the sine with
 * noise every device_s and rounds it to the step (0: not). A calibration curve bends the reading by
 * the factor `curve` of its square. */
static double curved_hold_of(double row_s, double device_s, double step, double noise, double jitter_s, double curve) {
    struct csv_hold *hold = calloc(1, sizeof *hold);
    uint64_t state = 5;
    double value = 0.0, next_s = 0.0;
    for (int i = 0; i * row_s < 20.0; i++) {
        double t_s = i * row_s;
        if (t_s >= next_s - 1e-9) {
            value = sin(2.0 * PI * t_s) + noise * gaussian(&state);
            next_s += device_s;
            if (jitter_s > 0.0) next_s += jitter_s * (uniform(&state) - 0.5);
        }
        double read = step > 0.0 ? step * round(value / step) : value;
        csv_hold_take(hold, read + curve * read * read);
    }
    double rows = csv_hold_rows(hold);
    free(hold);
    return rows;
}

static double hold_of(double row_s, double device_s, double step, double noise, double jitter_s) {
    return curved_hold_of(row_s, device_s, step, noise, jitter_s, 0.0);
}

static void repetition_is_told_from_coarse_steps_and_noise(void **unused) {
    (void)unused;
    assert_true(hold_of(0.002, 0.002, 0.0, 0.0, 0.0) == 1.0);
    assert_true(hold_of(0.002, 0.002, 0.01, 0.0, 0.0) == 1.0);  /* a value stays for up to 15
                                                                 * rows */
    assert_true(hold_of(0.002, 0.002, 0.05, 0.0, 0.0) == 1.0);
    assert_true(hold_of(0.002, 0.002, 0.01, 0.003, 0.0) == 1.0);
    assert_true(hold_of(0.002, 0.002, 0.01, 0.01, 0.0) == 1.0);
    assert_true(hold_of(0.001, 0.001, 0.3, 0.15, 0.0) == 1.0);
    for (double step = 0.06; step > 0.002; step *= 0.8) /* a calibration curve makes them unequal */
        assert_true(curved_hold_of(0.002, 0.002, step, 0.0, 0.0, 0.1) == 1.0);
    assert_near(curved_hold_of(0.002, 0.01, 0.001, 0.0, 0.0, 0.1), 5.0, 0.05);
    assert_near(hold_of(0.002, 0.01, 0.0, 0.0, 0.0), 5.0, 1e-9);
    assert_near(hold_of(0.002, 0.01, 0.001, 0.0, 0.0), 5.0, 0.05);
    assert_near(hold_of(0.001, 0.010, 0.0, 0.02, 0.002), 10.0, 0.3);
    assert_near(hold_of(0.001, 1.0 / 300.0, 0.0, 0.0, 0.0), 10.0 / 3.0, 0.05);
    assert_near(hold_of(0.001, 0.05, 0.0, 0.0, 0.0), 50.0, 0.1);
}

/* A speed with a peak of 126 mm/s, from a sensor that reads 2 mm/s at rest. This offset would
 * integrate to 24 mm in 12 s. */
static void a_speed_is_integrated_without_its_zero(void **unused) {
    (void)unused;
    for (int rests = 0; rests < 2; rests++) {
        struct csv_series s = {0};
        char notes[CSV_NOTES_SIZE] = "";
        uint64_t state = 3;
        double worst_mm = 0.0, w = 2.0 * PI * HZ;
        for (int i = 0; i < 6000; i++) {
            double t_s = 0.002 * i, run_s = t_s - 1.0;
            bool moves = !rests || (run_s > 0.0 && run_s < 10.0);
            assert_true(csv_series_add(&s, t_s, 2e-3 + 1e-4 * gaussian(&state) + (moves ? 0.02 * w * sin(w * run_s) : 0.0)));
        }
        csv_speed_integrate(&s, 0.1, notes);
        assert_non_null(strstr(notes, rests ? "its mean at rest" : "there is no rest"));
        assert_non_null(strstr(notes, "less 2 mm/s"));
        for (int i = 0; i < 6000; i++) {
            double run_s = s.t_s[i] - 1.0, truth = 0.1 - 0.02 * (!rests || (run_s > 0.0 && run_s < 10.0) ? cos(w * run_s) : 1.0);
            worst_mm = fmax(worst_mm, 1e3 * fabs(s.value[i] - truth));
        }
        if (!(worst_mm < 0.25)) fail_msg("%s rest: off by %g mm", rests ? "with" : "without", worst_mm);
        csv_series_free(&s);
    }
}

/* Returns the distance between the ends of an integrated rest-motion-rest, which should be zero.
 * said_mm: the wander in the notes. */
static double end_drift_mm(uint64_t seed, double *said_mm, int hole) {
    struct csv_series s = {0};
    char notes[CSV_NOTES_SIZE] = "";
    for (int i = 0; i < 6000; i++) {
        double t_s = 0.002 * i, run_s = t_s - 1.0, noise = 1e-4 * gaussian(&seed);
        if (i >= 3000 && i < 3000 + hole) continue;
        assert_true(csv_series_add(&s, t_s, 2e-3 + noise + (run_s > 0.0 && run_s < 10.0 ? 0.12 * sin(2.0 * PI * run_s) : 0.0)));
    }
    csv_speed_integrate(&s, 0.1, notes);
    const char *wander = strstr(notes, "wander by ");
    assert_non_null(wander);
    *said_mm = atof(wander + strlen("wander by "));
    assert_true((hole > 0) == (strstr(notes, "the speed has 1 hole, up to 0.202 s") != NULL));
    double drift_mm = 1e3 * (s.value[s.count - 1] - s.value[0]);
    csv_series_free(&s);
    return drift_mm;
}

/* The drift between the ends has the variance (noise dt)^2 n (n - rest) / rest. With a rest of 2 s
 * in 12 s its root is 0.85 of what is said, the hypot of the walk and of the zero's error; 40
 * trials measure it within 11 %. */
static void the_wander_of_an_integral_is_said(void **unused) {
    (void)unused;
    double square = 0.0, said_mm;
    for (uint64_t seed = 1; seed <= 40; seed++) square += pow(end_drift_mm(977 * seed, &said_mm, 0), 2.0) / 40.0;
    if (!(fabs(sqrt(square) / said_mm - 0.85) < 0.3)) fail_msg("%g mm, said to be %g mm", sqrt(square), said_mm);
    end_drift_mm(5, &said_mm, 100);
}

static void an_axis_that_turns_does_so_in_both(void **unused) {
    (void)unused;
    int used = sprintf(text, "t,q,tau\n");
    for (int i = 0; i < SECONDS_ALL * 200; i++)
        used += sprintf(text + used, "%.4f,%.9f,%.9f\n", 0.005 * i, place_mm(0.005 * i), force_n(0.005 * i));
    empty(NULL);
    put("1.csv", text);
    if (import_by("t=t:s,position=q:deg,force=tau:N m")) fail_msg("%s", error.text);
    assert_true(report.turns);
    assert_near(load(log_a)->cycle[100].in.length_m[0], place_mm(0.5) * PI / 180.0, 1e-12);
    assert_int_equal(import_by("t=t:s,position=q:deg,force=tau:N"), STATUS_USAGE);
    assert_says("1.csv:1|turns|slides");
}

static void time_may_be_the_number_of_the_row(void **unused) {
    (void)unused;
    int used = sprintf(text, "q,tau\n");
    for (int i = 0; i < SECONDS_ALL * 200; i++) used += sprintf(text + used, "%.9f,%.9f\n", place_mm(0.005 * i), force_n(0.005 * i));
    empty(NULL);
    put("1.csv", text);
    assert_int_equal(assert_truth("t=#0:5 ms,position=q:mm,force=tau:N", 1e-8, 1e-8), SECONDS_ALL * 200);
    const double first_s = load(log_a)->cycle[0].test_time_s;
    assert_int_equal(import_by("t=#0:5 ms+250,position=q:mm,force=tau:N"), STATUS_OK);
    assert_near(load(log_a)->cycle[0].test_time_s - first_s, 0.25, 1e-9);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_clocks_in_one_file_are_brought_together),
        cmocka_unit_test(a_name_of_time_that_is_there_twice_is_two_clocks),
        cmocka_unit_test(a_slow_channel_beside_a_fast_one_makes_the_rows),
        cmocka_unit_test(rows_with_one_channel_each_are_merged),
        cmocka_unit_test(files_without_a_common_column_are_one_test),
        cmocka_unit_test(rows_of_a_topic_that_is_not_read_are_left_out),
        cmocka_unit_test(parts_of_different_kinds_are_refused),
        cmocka_unit_test(too_many_clocks_are_refused),
        cmocka_unit_test(a_repeated_channel_counts_where_it_is_new),
        cmocka_unit_test(repetition_is_told_from_coarse_steps_and_noise),
        cmocka_unit_test(a_speed_is_integrated_without_its_zero),
        cmocka_unit_test(the_wander_of_an_integral_is_said),
        cmocka_unit_test(an_axis_that_turns_does_so_in_both),
        cmocka_unit_test(time_may_be_the_number_of_the_row),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
