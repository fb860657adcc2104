/* Times of the rows: their rate, missing rows, and the start of a test whose clock has another
 * origin. */
#include "csv_rig.h"

#include "units.h"

enum { ROWS = 5000 };

static const double PERIOD_S = 0.002;

/* Returns the time stamp of a row, NaN if the row is lost. */
typedef double stamp_function(int row);

static double uniform(int row) {
    uint64_t state = 88172645463325252u + 2654435761u * (uint64_t)row;
    random_bits(&state), random_bits(&state);
    return (double)(random_bits(&state) >> 11) * 0x1p-53;
}

static double even(int row) { return PERIOD_S * row; }
static double late(int row) { return even(row) + (row == 1000 ? 1.0e-3 : row == 2000 ? 1.9e-3 : 0.0); }
static double normal(int row) {
    double radius = sqrt(-2.0 * log(1.0 - uniform(row)));
    return even(row) + 0.3e-3 * radius * cos(2.0 * PI * uniform(row + ROWS));
}
static double spread(int row) { return even(row) + 0.9 * PERIOD_S * (uniform(row) - 0.5); }
static double hole(int row) { return row > 1000 && row <= 2500 ? (double)NAN : even(row); }
static double tenth(int row) { return row && row < ROWS - 1 && uniform(row) < 0.1 ? (double)NAN : even(row); }
static double fast(int row) { return even(row) * (1.0 + 200e-6); }
static double wander(int row) { return even(row) + 0.01 * sin(2.0 * PI * row / ROWS); }

static const char *file_of_stamps(const char *head, stamp_function *stamp, int64_t *rows) {
    static char text[BUFFER];
    int used = sprintf(text, "%st_s,u1\n", head);
    *rows = 0;
    for (int i = 0; i < ROWS; i++)
        if (!isnan(stamp(i))) used += sprintf(text + used, "%.7f,0\n", stamp(i) + 0.01), ++*rows;
    return text;
}

static const struct {
    const char *name;
    stamp_function *stamp;
} recordings[] = {{"even", even},          {"two stamps late", late}, {"normal jitter", normal}, {"jitter of 0.9 periods", spread},
                  {"a hole of 3 s", hole}, {"a tenth lost", tenth},   {"200 ppm fast", fast},    {"a clock that wanders", wander}};
enum { RECORDINGS = sizeof recordings / sizeof *recordings };

/* Each row gets its place, and missing rows are counted exactly, whether the file states the rate
 * or not. */
static void rows_have_their_places(void **unused) {
    (void)unused;
    static const char *const heads[] = {"# dof: x\n# rate_hz: 500\n", "# dof: x\n"};
    for (int i = 0; i < RECORDINGS; i++)
        for (int stated = 0; stated < 2; stated++) {
            int64_t rows;
            empty(NULL);
            put("1_x.csv", file_of_stamps(heads[stated], recordings[i].stamp, &rows));
            if (import()) fail_msg("%s: %s", recordings[i].name, error.text);
            if (report.rows != rows || report.lost != ROWS - rows || report.rate_hz > 0.0)
                fail_msg("%s: %lld rows, %lld lost, %g Hz", recordings[i].name, (long long)report.rows, (long long)report.lost,
                         report.rate_hz);
            const struct recording *r = load(log_a);
            assert_int_equal(r->cycle[rows - 1].seq - r->cycle[0].seq, ROWS - 1);
        }
}

/* A wrong rate is refused, however irregular the times are. */
static void a_wrong_rate_is_found(void **unused) {
    (void)unused;
    for (int i = 0; i < RECORDINGS; i++)
        for (int high = 0; high < 2; high++) {
            int64_t rows;
            empty(NULL);
            put("1_x.csv", file_of_stamps(high ? "# dof: x\n# rate_hz: 506\n" : "# dof: x\n# rate_hz: 494\n", recordings[i].stamp, &rows));
            if (import() != STATUS_USAGE) fail_msg("%s: taken", recordings[i].name);
            assert_says("1_x.csv:2|rate_hz|is not what t_s has|true rate_hz");
        }
}

/* Writes a file with stamps in whole milliseconds, of which one row in `every` is lost (0:
 * none). */
static void put_milliseconds(double true_hz, double stated_hz, int every) {
    static char text[BUFFER];
    int used = sprintf(text, "# dof: x\n# rate_hz: %g\nt_s,u1\n", stated_hz);
    for (int i = 0; i < ROWS; i++)
        if (!every || i % every != every - 1) used += sprintf(text + used, "%.3f,0\n", i / true_hz);
    empty(NULL);
    put("1_x.csv", text);
}

/* Stamps in milliseconds are not taken for 1000 Hz with lost rows. A rate at which not every row
 * has a place is refused. */
static void stamps_in_milliseconds_have_the_stated_rate(void **unused) {
    (void)unused;
    static const double rates_hz[] = {640.0, 750.0, 800.0, 900.0, 960.0, 980.0};
    for (size_t i = 0; i < sizeof rates_hz / sizeof *rates_hz; i++) {
        put_milliseconds(rates_hz[i], rates_hz[i], 0);
        if (import()) fail_msg("%g Hz: %s", rates_hz[i], error.text);
        if (report.rows != ROWS || report.lost || report.rate_hz > 0.0)
            fail_msg("%g Hz: %lld lost, %g Hz", rates_hz[i], (long long)report.lost, report.rate_hz);
        assert_close(load(log_a)->params.loop.period_s, 1.0 / rates_hz[i], 1e-9);
    }
    put_milliseconds(800.0, 800.0, 10);
    assert_imports();
    assert_int_equal(report.lost, ROWS / 10 - 1);
    put_milliseconds(1000.0, 750.0, 5);
    assert_int_equal(import(), STATUS_USAGE);
    assert_says("1_x.csv:2|true rate_hz");
}

/* Returns a file of one axis: rest, ramp-in and steady motion, each in seconds; more_s is added to
 * the time stamps. */
static const char *motion(const char *head, double rest_s, double ramp_s, double steady_s, double more_s) {
    static char text[4 * BUFFER];
    int used = sprintf(text, "# mechanism: axis\n# rate_hz: 500\n# frequency_hz: 4\n# ramp_s: 1\n%st_s,position_m,force_n\n", head);
    for (int i = 0; i < (rest_s + ramp_s + steady_s) / PERIOD_S; i++) {
        double t_s = i * PERIOD_S - rest_s, share = ramp_s > 0.0 ? fmin(fmax(t_s / ramp_s, 0.0), 1.0) : 1.0;
        used += sprintf(text + used, "%.3f,%.7f,0\n", i * PERIOD_S + more_s, 0.01 * share * sin(2.0 * PI * 4.0 * t_s));
    }
    return text;
}

static int evaluated(double *begin_s) {
    const struct recording *r = load(log_a);
    int count = 0;
    for (int i = 0; i < r->count; i++) {
        if (r->cycle[i].phase != PHASE_EVALUATE) continue;
        if (!count++) *begin_s = r->cycle[i].test_time_s;
    }
    return count;
}

static void time_may_begin_anywhere(void **unused) {
    (void)unused;
    static const struct {
        const char *head;
        double rest_s, ramp_s, steady_s, more_s, zero_s; /* zero_s: time stamp at which the test's
                                                          * time is 0 */
        int evaluated;
    } cases[] = {
        {"# duration_s: 4\n", 0.0, 1.0, 5.0, 0.0, 0.0, 2000},
        {"# duration_s: 4\n", 0.0, 1.0, 5.0, 6.5, 6.5, 2000},                  /* the logger's clock
                                                                                * started earlier */
        {"# duration_s: 4\n", 2.0, 1.0, 5.0, 1732478400.0, 1732478402.0, 2000}, /* the platform
                                                                                 * rests first */
        {"# duration_s: 4\n", 1.0, 1.0, 5.0, -500.0, -499.0, 2000}, /* the time stamps are negative
                                                                     * and rise towards 0 */
        {"", 0.0, 1.0, 5.0, 3.0, 3.0, 2500},
        {"# duration_s: 4\n", 0.0, 0.0, 5.0, 1.5, 0.0, 1750},  /* the file's time counts from the
                                                                * ramp-in, which is cut off */
        /* the ramp-in is cut off, and the clock has another origin */
        {"# duration_s: 4\n", 0.0, 0.0, 5.0, 100.0, 99.0, 2000},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double begin_s = 0.0, zero_s = 0.0;
        empty(NULL);
        put("1_x.csv", motion(cases[i].head, cases[i].rest_s, cases[i].ramp_s, cases[i].steady_s, cases[i].more_s));
        assert_imports();
        assert_int_equal(report.zero[0] != '\0', cases[i].zero_s != 0.0);
        if (report.zero[0]) assert_int_equal(sscanf(report.zero, "1_x.csv: %lf", &zero_s), 1);
        /* tolerance: half a cycle, because the ends of a ramp are found no more exactly */
        if (!(fabs(zero_s - cases[i].zero_s) <= 0.125)) fail_msg("case %zu: t = 0 at %.3f", i, zero_s);
        int count = evaluated(&begin_s);
        if (abs(count - cases[i].evaluated) > 126) fail_msg("case %zu: %d evaluated", i, count);
        assert_true(begin_s >= 1.0 - 1e-6 && begin_s < 1.6);
    }
}

static double chirp(double t_s) { return t_s < 20.0 ? 0.01 * sin(2.0 * PI * (0.3 + 0.05 * t_s) * t_s) : 0.0; }

/* Moves to another place within 1 s, and 4 s later back. */
static double point_to_point(double t_s) {
    double share = fmin(fmod(t_s, 4.0), 1.0), way = share * share * (3.0 - 2.0 * share);
    return 0.01 * (fmod(t_s, 8.0) < 4.0 ? way : 1.0 - way);
}

/* The motion need not be steady: the test's time begins at the end of the first rest. */
static void time_begins_with_any_motion(void **unused) {
    (void)unused;
    static const struct {
        const char *name;
        double (*path)(double t_s);
    } motions[] = {{"chirp", chirp}, {"point to point", point_to_point}};
    static const double rate_hz = 100.0, more_s = 1732478400.0, rest_s = 2.0, lasts_s = 21.0;
    for (size_t n = 0; n < sizeof motions / sizeof *motions; n++) {
        static char text[BUFFER];
        double begin_s = 0.0, zero_s = 0.0;
        int used = sprintf(text, "# mechanism: axis\n# rate_hz: %g\n# ramp_s: 1\nt_s,position_m,force_n\n", rate_hz);
        for (int i = 0; i < (rest_s + lasts_s) * rate_hz; i++) {
            double t_s = i / rate_hz - rest_s;
            used += sprintf(text + used, "%.3f,%.7f,0\n", i / rate_hz + more_s, t_s > 0.0 ? motions[n].path(t_s) : 0.0);
        }
        empty(NULL);
        put("1_x.csv", text);
        if (import()) fail_msg("%s: %s", motions[n].name, error.text);
        assert_int_equal(sscanf(report.zero, "1_x.csv: %lf", &zero_s), 1);
        if (!(fabs(zero_s - more_s - rest_s) <= 0.125)) fail_msg("%s: t = 0 at %.3f", motions[n].name, zero_s - more_s);
        assert_true(abs(evaluated(&begin_s) - (int)((lasts_s - 1.0) * rate_hz)) < 13 && begin_s >= 1.0 - 1e-6);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_have_their_places),
        cmocka_unit_test(a_wrong_rate_is_found),
        cmocka_unit_test(stamps_in_milliseconds_have_the_stated_rate),
        cmocka_unit_test(time_may_begin_anywhere),
        cmocka_unit_test(time_begins_with_any_motion),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
