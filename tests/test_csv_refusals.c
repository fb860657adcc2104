/* Incomplete or wrong CSV is refused with file, line and column, or counted. */
#include "csv_rig.h"

static void files_that_disagree_are_refused(void **unused) {
    (void)unused;
    empty(NULL);
    put("1_x.csv", file_of("# dof: x\n# amplitude: 0.004\n# frequency_hz: 4\n# ramp_s: 1\n", 0, 2000));
    put("2_phi.csv", file_of("# dof: phi\n# amplitude: 0.006\n# frequency_hz: 4\n", 0, 2000));
    assert_imports(); /* amplitudes in metres and radians are separate */
    assert_false(report.several);
    put("10_y.csv", file_of("# dof: y\n# amplitude: 0.005\n# frequency_hz: 5\n", 0, 2000));
    assert_imports(); /* each axis has its own frequency */
    assert_false(report.several);
    put("10_x.csv", file_of("# dof: x\n# amplitude: 0.005\n# frequency_hz: 5\n", 0, 2000));
    assert_imports(); /* two tests of one axis differ, which is reported */
    assert_true(report.several);
    put("11_z.csv", file_of("# dof: z\n# ramp_s: 2\n", 0, 2000));
    assert_int_equal(import(), STATUS_USAGE);
    assert_says("11_z.csv:2|ramp_s: 2|1_x.csv has 1");
}

static void rows_that_are_missing_are_counted(void **unused) {
    (void)unused;
    char text[BUFFER];
    int used = sprintf(text, "# dof: x\n# rate_hz: 500\nt_s,u1\n");
    for (int i = 0; i < 3000; i++)
        if (i % 100 != 50) used += sprintf(text + used, "%.10g,0\n", 0.002 * i);
    empty(NULL);
    put("1_x.csv", text);
    assert_imports();
    assert_true(report.rows == 2970 && report.lost == 30);
    const struct recording *r = load(log_a);
    /* a lost row is a gap in seq, as in hexid's own logs */
    assert_int_equal(r->cycle[2969].seq - r->cycle[0].seq, 2999);
}

/* A deviation up to 1 % is due to clocks; a larger one is an error, which would shift the
 * frequency. */
static void a_rate_that_lies_is_refused(void **unused) {
    (void)unused;
    static const struct {
        const char *head, *says; /* NULL: accepted */
    } cases[] = {
        {"# dof: x\n# rate_hz: 500\n", NULL},
        {"# dof: x\n# rate_hz: 504\n", NULL},
        {"# dof: x\n# rate_hz: 496\n", NULL},
        {"# dof: x\n# rate_hz: 506\n", "1_x.csv:2|rate_hz: 506|500 Hz"},
        {"# dof: x\n# rate_hz: 494\n", "1_x.csv:2|rate_hz: 494|500 Hz"},
        {"# dof: x\n# rate_hz: 1000\n", "1_x.csv:2|rate_hz: 1000|500 Hz"},
        {"# dof: x\n# rate_hz: 250\n", "1_x.csv:2|rate_hz: 250|500 Hz"},
        {"# dof: x\n# rate_hz: 5000\n", "1_x.csv:2|rate_hz: 5000|500 Hz"},
        {"# dof: x\n", NULL}, /* the configuration states 500 Hz */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        empty(NULL);
        put("1_x.csv", file_of(cases[i].head, 0, 2000));
        int status = import();
        if (!cases[i].says && status) fail_msg("%s", error.text);
        if (!cases[i].says) continue;
        assert_int_equal(status, STATUS_USAGE);
        assert_says(cases[i].says);
    }
    empty(NULL);
    put("1_x.csv", file_of("# dof: x\n# rate_hz: 504\n", 0, 2000));
    assert_imports();
    /* accepted and reported */
    assert_true(report.stated_hz == 504.0 && fabs(report.rate_hz - 500.0) < 0.01);
    assert_true(fabs(load(log_a)->params.loop.period_s - 0.002) < 1e-7);
}

/* Returns a file whose time stamps are rounded to milliseconds: at 992 Hz there is an occasional
 * step of 2 ms, at 454.5 Hz steps are 2 and 3 ms. */
static const char *rounded(const char *head, double rate_hz) {
    static char text[BUFFER];
    int used = sprintf(text, "%st_s,u1\n", head);
    for (int i = 0; i < 2000; i++) used += sprintf(text + used, "%.3f,0\n", i / rate_hz);
    return text;
}

static void times_that_are_rounded_do_not_move_the_rate(void **unused) {
    (void)unused;
    empty(NULL);
    put("1_x.csv", rounded("# dof: x\n# rate_hz: 992\n", 992.0));
    assert_imports();
    assert_true(report.stated_hz == 0.0 && fabs(load(log_a)->params.loop.period_s * 992.0 - 1.0) < 1e-6);
    put("1_x.csv", rounded("# dof: x\n", 454.5));
    assert_imports();
    assert_true(report.lost == 0 && fabs(report.rate_hz - 454.5) < 0.1);
}

/* The logger has irregular steps of 10 to 18 ms and a gap of a second. */
static void times_that_jitter_have_a_rate(void **unused) {
    (void)unused;
    static char text[BUFFER];
    int used = sprintf(text, "# dof: x\nt_s,u1\n");
    double t_s = 0.0;
    for (int i = 0; i < 2000; i++) {
        used += sprintf(text + used, "%.3f,0\n", t_s);
        t_s += i == 1000 ? 1.0 : i % 50 == 0 ? 0.018 : i % 3 ? 0.010 : 0.011;
    }
    empty(NULL);
    put("1_x.csv", text);
    assert_imports();
    assert_true(fabs(report.rate_hz - 97.0) < 1.0 && report.lost > 90 && report.lost < 150);
}

static void another_unit_of_time_is_no_rate(void **unused) {
    (void)unused;
    empty(NULL);
    for (int ms = 1; ms <= 10; ms *= 10) { /* rates of 1 kHz and 100 Hz */
        put("1_x.csv", rounded("# dof: x\n", 1.0 / ms));
        assert_int_equal(import(), STATUS_USAGE);
        assert_says("1_x.csv:2|no rate_hz|milliseconds");
    }
    put("1_x.csv", rounded("# dof: x\n", 1e-3));
    assert_int_equal(import(), STATUS_USAGE);
    assert_says("1_x.csv:2|microseconds");
}

/* A single file is imported like a directory with that file alone, but the configuration beside it
 * is not used. */
static void one_file_is_enough(void **unused) {
    (void)unused;
    char path[2 * PATHS];
    empty(NULL);
    put("config.yaml", "loop: {period_s: 0.004}\n");
    put("1_x.csv", file_of("# dof: x\n# rate_hz: 500\n", 0, 2000));
    put("2_x.csv", "no CSV");
    snprintf(path, sizeof path, "%s/1_x.csv", in);
    if (import_of(path, log_a, NULL)) fail_msg("%s", error.text);
    assert_true(report.files == 1 && report.rows == load(log_a)->count && !strcmp(report.file[0].name, "1_x.csv"));
    snprintf(path, sizeof path, "%s/3_x.csv", in);
    assert_int_equal(import_of(path, log_a, NULL), STATUS_IO);
    assert_says("3_x.csv|No such file");
}

static void a_rate_that_no_file_states_is_that_of_the_times(void **unused) {
    (void)unused;
    empty(NULL);
    put("config.yaml", "loop: {period_s: 0.001}\n");
    put("1_x.csv", file_of("# dof: x\n", 0, 2000));
    assert_imports();
    assert_true(report.stated_hz == 0.0 && fabs(report.rate_hz - 500.0) < 0.01 && report.lost == 0);
    assert_true(fabs(load(log_a)->params.loop.period_s - 0.002) < 1e-7);
}

static void what_is_wrong_is_named_with_file_line_and_column(void **unused) {
    (void)unused;
    static const struct {
        const char *text, *says;
    } cases[] = {
        {"", "1_x.csv|dof"},
        {"\n\n\n", "1_x.csv|dof"},
        {"# dof: x\n", "1_x.csv:1|names of the columns"},
        {"t_s,u1\n0,0\n", "1_x.csv:1|# dof: x"},
        {"# dof: roll\nt_s,u1\n0,0\n", "1_x.csv:1|dof: roll|phi"},
        {"# dof: x\n# dof: y\nt_s,u1\n0,0\n", "1_x.csv:2|twice"},
        {"# dof: x\n# ramp_s: 1\n# ramp_s: 2\nt_s,u1\n0,0\n", "1_x.csv:3|ramp_s|twice"},
        {"# dof: x\n# rate_hz: fast\nt_s,u1\n0,0\n", "1_x.csv:2|rate_hz: fast"},
        {"# dof: x\n# rate_hz: 0\nt_s,u1\n0,0\n", "1_x.csv:2|rate_hz: 0"},
        {"# dof: x\n# frequency_hz: -4\nt_s,u1\n0,0\n", "1_x.csv:2|frequency_hz: -4"},
        {"# dof: x\n# frequency_hz: nan\nt_s,u1\n0,0\n", "1_x.csv:2|frequency_hz: nan"},
        {"# dof: x\n# amplitude: 4 mm\nt_s,u1\n0,0\n", "1_x.csv:2|amplitude: 4 mm"},
        {"# mechanism: hexapod\n# dof: x\nt_s,u1\n0,0\n", "1_x.csv:1|mechanism: hexapod|axis"},
        {"# mechanism: axis\nt_s,force_n\n0,0\n", "1_x.csv:2|position_m"},
        {"# mechanism: axis\n# dof: psi\nt_s,position_m\n0,0\n", "1_x.csv:3|dof: psi"},
        {"# dof: x\nu1,u2\n0,0\n", "1_x.csv:2|t_s"},
        {"# dof: x\nt_s,u1,u2,u1\n0,0,0,0\n", "1_x.csv:2|u1|twice"},
        {"# dof: x\nt_s,u1\n", "1_x.csv:2|no rows"},
        {"# dof: x\n# ramp_s: 3\nt_s,u1\n2.998,0\n", "1_x.csv:4|ramp_s|2.998"},
        {"# dof: x\n# rate_hz: 1e-9\nt_s,u1\n0,0\n", "1_x.csv:2|rate_hz: 1e-9|10"},
        {"# dof: x\n# duration_s: 0.01\nt_s,u1\n0,0\n", "/in|tests.duration_s"},
        {"# dof: x\nt_s,u1\n0,0\n0.002\n", "1_x.csv:4|1 cells|2 columns"},
        {"# dof: x\nt_s,u1\n0,0\n0.002,0,0\n", "1_x.csv:4|3 cells|2 columns"},
        {"# dof: x\nt_s,u1\n0,0\n0.002,zero\n", "1_x.csv:4|u1|zero"},
        {"# dof: x\nt_s,u1\n0,0\n0.002,\"0\n", "1_x.csv:4|quote"},
        {"# dof: x\nt_s;u1\n0;0\n0,002;1.234,5\n", "1_x.csv:4|u1|1.234,5|thousands"},
        {"# dof: x\nt_s;u1;u2\n0;\"0;5\";\"1.2,3\"\n", "1_x.csv:3|u1: \"0;5\" is"},
        {"# dof: x\nt_s,u1\n0,002,1,5\n", "1_x.csv:3|4 cells|2 columns"},
        {"# dof: x\nt_s,u1,u1_\n0,0,zero\n", "1_x.csv:3|ramp_s"}, /* not understood, not read */
        {"t_s,position [furlong],force_n\n0,0,0\n", "1_x.csv:1|position [furlong]|m, cm, mm|--map position"},
        {"# dof: x\nt_s,u1\n0,0\n0.002,1.2.3\n", "1_x.csv:4|u1|1.2.3"},
        {"# dof: x\nt_s,u1\n0,0\n0.002,--1\n", "1_x.csv:4|u1|--1"},
        {"# dof: x\nt_s,u1\n0,0\n,0\n", "1_x.csv:4|t_s|time"},
        {"# dof: x\nt_s,u1\nnan,0\n", "1_x.csv:3|t_s"},
        {"# dof: x\nt_s,u1\n0,0\ninf,0\n", "1_x.csv:4|t_s"},
        {"# dof: x\nt_s,u1\n0,0\n0.002,0\n0.002,0\n", "1_x.csv:5|t_s|increase"},
        {"# dof: x\nt_s,u1\n0,0\n0.002,0\n0.001,0\n", "1_x.csv:5|t_s|increase"},
        {"# dof: x\nt_s,u1\n0,0\n1e9,0\n", "1_x.csv:4|t_s|gap"},
        {"# dof: x\nt_s,flags\n0,-1\n", "1_x.csv:3|flags|-1"},
        {"# dof: x\nt_s,flags\n0,4294967296\n", "1_x.csv:3|flags"},
        {"# dof: x\nt_s,phase\n0,5\n", "1_x.csv:3|phase|5"},
        {"# dof: x\nt_s,phase\n0,2.5\n", "1_x.csv:3|phase|2.5"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        empty(NULL);
        put("1_x.csv", cases[i].text);
        if (import() != STATUS_USAGE) fail_msg("accepted: %s", cases[i].text);
        assert_says(cases[i].says);
        assert_int_not_equal(access(log_a, F_OK), 0); /* no log was created */
    }
}

static void lines_without_an_end_are_refused(void **unused) {
    (void)unused;
    static char text[20000];
    int used = sprintf(text, "# dof: x\nt_s,u1\n0,0\n");
    memset(text + used, '1', sizeof text - (size_t)used - 1);
    empty(NULL);
    put("1_x.csv", text);
    assert_int_equal(import(), STATUS_USAGE);
    assert_says("1_x.csv:4|bytes");
    static const char zeros[] = "# dof: x\nt_s,u1\n0,0\n0.002,\0 0\n0.004,0\n";
    put_bytes("1_x.csv", zeros, sizeof zeros - 1);
    assert_int_equal(import(), STATUS_USAGE);
    assert_says("1_x.csv:4|zero byte");
    used = sprintf(text, "# dof: x\nt_s");
    for (int i = 0; i < 600; i++) used += sprintf(text + used, ",c%d", i);
    put("1_x.csv", text);
    assert_int_equal(import(), STATUS_USAGE);
    assert_says("1_x.csv:2|columns");
}

/* Any bytes are refused or make a readable log; sanitizers check the memory. */
static void damaged_files_are_survived(void **unused) {
    (void)unused;
    static const char characters[] = "0123456789.,-+e#:; \t\"\n\r\x00\xff"
                                     "naifx";
    static char text[BUFFER];
    uint64_t state = 11;
    int accepted = 0;
    empty(NULL);
    for (int round = 0; round < 400; round++) {
        int size = sprintf(text, "%s", file_of("# dof: x\n# rate_hz: 500\n# amplitude: 0.004\n# duration_s: 1\n", -0.1, 150));
        for (int i = 0; i < 1 + round % 3; i++) {
            uint64_t bits = random_bits(&state);
            text[(bits >> 20) % (i ? (uint64_t)size : 120)] = characters[bits % (sizeof characters - 1)];
        }
        put_bytes("1_x.csv", text, (size_t)size);
        if (import()) assert_says(root); /* the message names the file or the configuration */
        else accepted++, assert_true(load(log_a)->count > 0);
    }
    assert_true(accepted > 10 && accepted < 390); /* both outcomes occur often enough */
}

static void directories_and_logs_that_cannot_be_are_named(void **unused) {
    (void)unused;
    empty(NULL);
    assert_int_equal(import(), STATUS_USAGE);
    assert_says("/in|no CSV file");
    assert_int_equal(import_of("/nowhere", log_a, NULL), STATUS_IO);
    assert_says("/nowhere|No such file");
    put("1_x.csv", file_of("# dof: x\n", 0, 2000));
    assert_int_equal(import_of(in, "/dev/full", NULL), STATUS_IO);
    assert_says("/dev/full|No space left");
    assert_int_equal(import_of(in, "/nowhere/a.lcm", NULL), STATUS_IO);
    assert_says("/nowhere/a.lcm|No such file");
    assert_imports();
    assert_int_equal(csv_export(log_a, 0, in, &report, &error), STATUS_IO);
    assert_says("/in|CSV files already");
    assert_int_equal(csv_export(log_a, 0, "/nowhere/out", &report, &error), STATUS_IO);
    assert_says("/nowhere/out|No such file");
    assert_int_equal(csv_export("/nowhere/a.lcm", 0, out, &report, &error), STATUS_IO);
    assert_says("/nowhere/a.lcm|No such file");
    empty(NULL);
    put("config.yaml", "# mine\n");
    put("../only.lcm", "");
    char only[2 * PATHS];
    snprintf(only, sizeof only, "%s/only.lcm", root);
    assert_int_equal(csv_export(only, 0, out, &report, &error), STATUS_IO);
    assert_says("only.lcm|no test");
    struct params params = short_tests(0.002);
    write_log(log_a, &params);
    /* an existing configuration is never overwritten */
    assert_int_equal(csv_export(log_a, 0, in, &report, &error), STATUS_IO);
    assert_says("config.yaml|File exists");
}

static void a_cut_log_is_exported_up_to_the_cut(void **unused) {
    (void)unused;
    struct params params = short_tests(0.002);
    struct stat whole;
    empty(NULL);
    write_log(log_a, &params);
    stat(log_a, &whole);
    assert_int_equal(truncate(log_a, whole.st_size / 2), 0);
    assert_int_equal(csv_export(log_a, 0, out, &report, &error), 0);
    assert_true(report.cut && report.cut_offset <= whole.st_size / 2 && report.files >= 3 && report.files < 7);
    if (import_of(out, log_b, NULL)) fail_msg("%s", error.text);
    assert_int_equal(load(log_b)->count, load(log_a)->count);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_that_disagree_are_refused),
        cmocka_unit_test(rows_that_are_missing_are_counted),
        cmocka_unit_test(a_rate_that_lies_is_refused),
        cmocka_unit_test(times_that_are_rounded_do_not_move_the_rate),
        cmocka_unit_test(times_that_jitter_have_a_rate),
        cmocka_unit_test(another_unit_of_time_is_no_rate),
        cmocka_unit_test(one_file_is_enough),
        cmocka_unit_test(a_rate_that_no_file_states_is_that_of_the_times),
        cmocka_unit_test(what_is_wrong_is_named_with_file_line_and_column),
        cmocka_unit_test(lines_without_an_end_are_refused),
        cmocka_unit_test(damaged_files_are_survived),
        cmocka_unit_test(directories_and_logs_that_cannot_be_are_named),
        cmocka_unit_test(a_cut_log_is_exported_up_to_the_cut),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
