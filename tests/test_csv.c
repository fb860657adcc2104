/* CSV: values that pass through a log keep every bit, and files of other programs can be read. */
#include "csv_rig.h"

#include "csv_reader.h"
#include "units.h"

#define assert_same(a, b, member) assert_memory_equal(&(a)->member, &(b)->member, sizeof(a)->member)

/* Asserts equal bits; any NaN equals any other, because text has only one. */
static void assert_numbers(const double *a, const double *b, int count) {
    for (int i = 0; i < count; i++)
        if (!(isnan(a[i]) && isnan(b[i]))) assert_memory_equal(&a[i], &b[i], sizeof a[i]);
}

/* Compares everything that the identifier and the gap workflow read. */
static void assert_equal_cycles(const struct cycle *a, const struct cycle *b) {
    assert_numbers(&a->test_time_s, &b->test_time_s, 1);
    assert_numbers(a->in.length_m, b->in.length_m, LEGS);
    assert_numbers(a->in.p1_pa, b->in.p1_pa, LEGS);
    assert_numbers(a->in.p2_pa, b->in.p2_pa, LEGS);
    assert_numbers(a->out.valve, b->out.valve, LEGS);
    assert_numbers(a->ref, b->ref, DOFS);
    assert_same(a, b, in.flags), assert_same(a, b, phase), assert_same(a, b, test), assert_same(a, b, dof);
}

static void log_to_csv_to_log_keeps_what_identification_reads(void **unused) {
    (void)unused;
    slow_case();
    static const double periods[] = {0.002, 0.001, 1.0 / 300, 0.0037};
    for (int i = 0; i < 4; i++) {
        struct params params = short_tests(periods[i]);
        empty(NULL);
        write_log(log_a, &params);
        if (csv_export(log_a, 0, out, &report, &error)) fail_msg("%s", error.text);
        assert_int_equal(report.files, 7);
        assert_true(report.lost > 0 && !report.cut && report.unreadable == 0);
        if (import_of(out, log_b, NULL)) fail_msg("%s", error.text);
        struct recording *a = load(log_a), *b = load(log_b);
        assert_true(a->count > 1000 && report.rows == a->count && report.files == 7);
        assert_int_equal(b->count, a->count);
        for (int k = 0; k < a->count; k++) assert_equal_cycles(&b->cycle[k], &a->cycle[k]);
        char *before = config_text(&a->params), *after = config_text(&b->params);
        assert_string_equal(after, before);
        free(before), free(after);
    }
}

/* The expected values are the ones that this test wrote, not ones that a reader returned. */
static void csv_to_log_to_csv_gives_the_same_values(void **unused) {
    (void)unused;
    enum { ROWS = 2000 };
    static struct cycle original[ROWS];
    static char path[2 * PATHS];
    uint64_t state = 4;
    empty(NULL);
    snprintf(path, sizeof path, "%s/1_theta.csv", in);
    FILE *f = fopen(path, "w");
    fprintf(f, "# dof: theta\n# rate_hz: 500\nt_s");
    for (int i = 1; i < CSV_FLAGS_COLUMN; i++) fprintf(f, ",%s", csv_columns[i].name);
    for (int i = 0; i < ROWS; i++) {
        struct cycle *c = &original[i];
        fill_cycle(c, &state);
        /* time stamps with a third of a millisecond of jitter */
        c->test_time_s = i * 0.002 + 1e-5 * (double)(random_bits(&state) % 100) / 3.0;
        c->test = DOF_THETA, c->dof = DOF_THETA;
        c->phase = llround(c->test_time_s / 0.002) < 500 ? PHASE_RAMP_IN : PHASE_EVALUATE;
        for (int k = 0; k < CSV_FLAGS_COLUMN; k++)
            fprintf(f, "%s%.*g", k ? "," : "\n", 17 + i % 4, *(const double *)((const char *)c + csv_columns[k].offset));
    }
    fclose(f);
    assert_imports();
    struct recording *r = load(log_a);
    assert_int_equal(r->count, ROWS);
    for (int i = 0; i < ROWS; i++) assert_equal_cycles(&r->cycle[i], &original[i]);

    assert_int_equal(csv_export(log_a, 0, out, &report, &error), 0);
    snprintf(path, sizeof path, "%s/1_theta.csv", out);
    f = fopen(path, "r");
    static char line[20000];
    int row = 0;
    while (fgets(line, sizeof line, f)) {
        char *cell = line;
        if (*line == '#' || *line == 't') continue;
        for (int k = 0; k < CSV_FLAGS_COLUMN; k++, cell++) {
            double value = strtod(cell, &cell);
            assert_numbers(&value, (const double *)((const char *)&original[row] + csv_columns[k].offset), 1);
            assert_int_equal(*cell, ',');
        }
        row++;
    }
    fclose(f);
    assert_int_equal(row, ROWS);
}

static void numbers_are_read_as_strtod_reads_them(void **unused) {
    (void)unused;
    /* clang-format off */
    static const char *const fixed[] = {"0", "-0", "1", "-1.5", ".5", "-.5", "5.", "999999999999999", "9999999999999999",
                                        "0.000000000000001", "123456789012345.6", "12345678.1234567", "1e22", "1E-3", "-2.5e+7",
                                        "+3", " 4 ", "00012.50", "1e400", "4.9e-324", "0.1", "9007199254740993",
                                        "900719925474099.3", "inf", "-inf"};
    /* clang-format on */
    enum { FIXED = sizeof fixed / sizeof *fixed, ROWS = 20000 };
    static double expected[ROWS];
    static char text[64 * ROWS];
    struct csv_reader *r;
    struct cycle c;
    uint64_t state = 6;
    int used = sprintf(text, "# dof: none\nt_s,u1\n");
    for (int i = 0; i < ROWS; i++) {
        char number[48];
        uint64_t bits = random_bits(&state);
        if (i < FIXED) snprintf(number, sizeof number, "%s", fixed[i]);
        else if (i % 2)
            snprintf(number, sizeof number, "%s%llu.%0*llu", bits % 2 ? "-" : "", (unsigned long long)(bits >> 20) % 1000000,
                     1 + (int)(bits % 9), (unsigned long long)(bits >> 40) % 10);
        else snprintf(number, sizeof number, "%.*g", 1 + (int)(bits >> 5) % 17, (double)(int64_t)bits / (double)(1 + bits % 1000));
        expected[i] = strtod(number, NULL);
        used += sprintf(text + used, "%d,%s\n", i, number);
    }
    empty(NULL);
    put("1.csv", text);
    char path[2 * PATHS];
    snprintf(path, sizeof path, "%s/1.csv", in);
    assert_int_equal(csv_open(&r, path, NULL, &error), 0);
    for (int i = 0; i < ROWS; i++) {
        assert_int_equal(csv_read_row(r, &c, &error), 1);
        assert_memory_equal(&c.out.valve[0], &expected[i], sizeof expected[i]);
    }
    assert_int_equal(csv_read_row(r, &c, &error), 0);
    csv_close(r);
}

/* Without the column `phase` the phases follow from the time since the start of the test, to the
 * row. */
static void phases_follow_from_time(void **unused) {
    (void)unused;
    static const double periods[] = {0.002, 0.001, 1.0 / 300, 0.0037};
    static const double ramps[] = {0.3, 0.0, 0.1, 1.0 / 3};
    static char text[BUFFER];
    for (int i = 0; i < 16; i++) {
        struct params p = short_tests(periods[i / 4]);
        struct reference r;
        struct reference_sample s;
        static enum phase expected[CYCLES_MAX];
        int used, count = 0;
        p.tests.ramp_s = ramps[i % 4];
        empty(NULL);
        used = sprintf(text, "# dof: z\n# rate_hz: %.12g\n# ramp_s: %.17g\n# duration_s: 1\nt_s,u1\n", 1.0 / p.loop.period_s,
                       p.tests.ramp_s);
        reference_test(&r, DOF_Z, NULL, &p.tests, p.loop.period_s);
        while (s = reference_step(&r, &p.tests, p.loop.period_s), !s.done) {
            expected[count++] = s.phase;
            used += sprintf(text + used, "%.17g,0\n", s.test_time_s);
        }
        put("1_z.csv", text);
        assert_imports();
        struct recording *b = load(log_a);
        assert_int_equal(b->count, count);
        for (int k = 0; k < count; k++) assert_int_equal(b->cycle[k].phase, expected[k]);
    }
}

static void heads_replace_the_configuration(void **unused) {
    (void)unused;
    empty(NULL);
    put("1_psi.csv", file_of("# dof: psi\n# frequency_hz: 2.5\n# amplitude: 0.01\n# ramp_s: 0.5\n# settle_s: 0\n", 0.0, 1500));
    put("2_y.csv", file_of("# dof: y\n# frequency_hz: 5\n# amplitude: 0.003\n", 0.0, 1400));
    put("3_z.csv", file_of("# dof: z\n# amplitude: 0.002\n", 0.0, 1400));
    assert_imports();
    const struct test_params *t = &load(log_a)->params.tests;
    static const double hz[DOFS] = {2.5, 5, 2.5, 2.5, 2.5, 2.5}, amplitude[DOFS] = {0.003, 0.003, 0.002, 0.01, 0.01, 0.01};
    assert_memory_equal(t->hz, hz, sizeof hz); /* each axis has its own frequency; an axis without
                                                * one has the first file's */
    assert_memory_equal(t->amplitude, amplitude, sizeof amplitude);
    assert_true(t->ramp_s == 0.5 && t->settle_s == 0.0);
    /* the shorter file without the ramp: 1400 * 2 ms - 0.5 s */
    assert_float_equal(t->duration_s, 2.3, 1e-9);
    assert_true(t->count == 6 && t->order[5] == DOF_PSI);
    assert_true(load(log_a)->cycle[0].test == 5 && load(log_a)->cycle[1500].test == 1);
}

static void another_rate_makes_another_period(void **unused) {
    (void)unused;
    char text[BUFFER];
    int used = sprintf(text, "# dof: x\n# rate_hz: 200\nt_s,u1\n");
    for (int i = 0; i < 600; i++) used += sprintf(text + used, "%.10g,0\n", 0.005 * i);
    empty(NULL);
    put("1_x.csv", text);
    assert_imports();
    const struct params *p = &load(log_a)->params;
    assert_true(p->loop.period_s == 0.005 && p->sim.substeps == 20);
    assert_int_equal(load(log_a)->cycle[599].in.time_ns, 599 * 5000000LL);
}

/* Values that the headers omit come from the configuration in the directory, otherwise from the
 * given one. */
static void the_configuration_beside_the_files_is_used(void **unused) {
    (void)unused;
    empty(NULL);
    put("1_x.csv", file_of("# dof: x\n", 0, 2000));
    if (import_of(in, log_a, "payload: {mass_kg: 200}\n")) fail_msg("%s", error.text);
    assert_true(load(log_a)->params.payload.mass_kg == 200.0);
    put("config.yaml", "payload:\n  mass_kg: 150\n");
    if (import_of(in, log_a, "payload: {mass_kg: 200}\n")) fail_msg("%s", error.text);
    assert_true(load(log_a)->params.payload.mass_kg == 150.0);
    put("config.yaml", "payload:\n  mass: 150\n");
    assert_int_equal(import(), STATUS_USAGE);
    assert_says("config.yaml:2|payload.mass");
}

static void other_programs_files_are_read(void **unused) {
    (void)unused;
    char text[BUFFER];
    int used = sprintf(text, "\xef\xbb\xbf# recorded by hand\r\n# dof: x\r\n#rate_hz : 500\r\n# operator: Ann\r\n\r\n"
                             "\"t_s\", \"l2_m\" ,p1_3_pa,temperature\r\n");
    for (int i = 0; i < 1000; i++)
        used += sprintf(text + used, "%.10g, 1.83 ,%s,warm, very\r\n", 0.002 * i, i % 10 ? "8e6" : i % 20 ? "" : "nan");
    sprintf(text + used, "\r\n");
    empty(NULL);
    put("1_x.csv", text);
    assert_int_equal(import(), STATUS_USAGE); /* the file has a comma too many */
    assert_says("1_x.csv:7|5 cells|line 6 names 4");
    for (char *comma; (comma = strstr(text, "warm, very"));) memcpy(comma, "warm; very", 10);
    put("1_x.csv", text);
    assert_imports();
    const struct cycle *c = &load(log_a)->cycle[999];
    assert_true(c->in.length_m[1] == 1.83 && isnan(c->in.length_m[0]) && c->in.p1_pa[2] == 8e6 && isnan(c[-9].in.p1_pa[2]));
    assert_true(isnan(c->ref[0]) && isnan(c->out.valve[5]));
    assert_int_equal(c->in.flags, 0);
    assert_int_equal(report.empty, 100);
    assert_string_equal(report.missing,
                        "1_x.csv: ref_x_m..ref_psi_rad, l1_m, l3_m, l4_m, l5_m, l6_m, p1_1_pa, p1_2_pa, p1_4_pa, p1_5_pa, p1_6_pa, "
                        "p2_1_pa..p2_6_pa, u1..u6");
    assert_string_equal(report.ignored, "1_x.csv: operator, temperature");
}

/* The same rows as five programs write them. */
static void every_dialect_gives_the_same_log(void **unused) {
    (void)unused;
    static const struct {
        const char *names, *row; /* t_s, l1_m, p1_1_pa, note */
        double time, length, pressure;
    } dialects[] = {
        {"t_s,l1_m,p1_1_pa,note", "%.4f,%.5f,%.1f,a\n", 1.0, 1.0, 1.0},
        {"t_ms;l1_mm;p1_1_bar;note", "%.1f;%.2f;%.5f;a\r\n", 1e3, 1e3, 1e-5},
        {"\"Note\"\t\"P1_1 [MPa]\"\tl1 (cm)\tt [us]", NULL, 1e6, 1e2, 1e-6},
        {"\"t_s\",\"l1_m\",\"p1_1_kPa\",\"note, free\"", "\"%.4f\",\"%.5f\", \"%.3f\",\"a, b\"\n# pause\n", 1.0, 1.0, 1e-3},
    };
    enum { ROWS = 1000 };
    static struct cycle first[ROWS];
    static char text[BUFFER];
    for (size_t d = 0; d < sizeof dialects / sizeof *dialects; d++) {
        int used = sprintf(text, "# dof: x\n%s\n", dialects[d].names);
        for (int i = 0; i < ROWS; i++) {
            double t = 0.002 * i * dialects[d].time, l = (1.83 + 1e-5 * i) * dialects[d].length, p = (4e6 + 1e3 * i) * dialects[d].pressure;
            char row[120];
            if (dialects[d].row) snprintf(row, sizeof row, dialects[d].row, t, l, p);
            else snprintf(row, sizeof row, "\t%.5f\t%.4f\t%.0f\n", p, l, t);
            for (char *point = row; strpbrk(dialects[d].names, ";\t") && (point = strchr(point, '.'));) *point = ',';
            used += sprintf(text + used, "%s", row);
        }
        empty(NULL);
        put("1_x.csv", text);
        assert_imports();
        assert_string_equal(report.doubtful, "");
        struct recording *r = load(log_a);
        assert_int_equal(r->count, ROWS);
        if (d == 0) memcpy(first, r->cycle, sizeof first);
        for (int i = 0; i < ROWS; i++) {
            assert_float_equal(r->cycle[i].test_time_s, first[i].test_time_s, 1e-12);
            assert_float_equal(r->cycle[i].in.length_m[0], first[i].in.length_m[0], 1e-12);
            assert_float_equal(r->cycle[i].in.p1_pa[0], first[i].in.p1_pa[0], 1e-6);
        }
    }
}

static void units_that_cannot_be_are_named(void **unused) {
    (void)unused;
    static const struct {
        const char *name, *says;
        double mean, swing;
    } cases[] = {
        {"l3_m", "", 1.83, 0.004},
        {"l3_m", "l3_m is up to 1834, in mm?", 1830.0, 4.0},
        {"l1_mm", "l1_m is up to 0.001834 (possible: 0.", 1.83, 0.004},
        {"p2_5_pa", "", 4e6, 1e6},
        {"p2_5_pa", "p2_5_pa is up to 50, in bar?", 40.0, 10.0},
        {"p2_5_pa", "p2_5_pa is up to 5, in MPa?", 4.0, 1.0},
        {"p2_5_bar", "p2_5_pa is up to 5e+11 (possible: 2e+04 to 4.8e+07 Pa), and no unit fits", 4e6, 1e6},
        {"ref_phi_rad", "", 0.0, 0.006},
        {"ref_phi_rad", "ref_phi_rad swings by 0.34", 0.0, 0.344},
        {"u2", "", 0.0, 0.5},
        {"u2", "u2 is up to 50, in percent?", 0.0, 50.0},
        {"ref_z_m", "ref_z_m swings by 4, in mm?", 0.0, 4.0},
        {"position_m", "position_m swings by 20, in mm?", 0.0, 20.0},
        {"position_mm", "", 0.0, 20.0},
        {"position_m", "", 0.0, 0.02},
    };
    static char text[BUFFER];
    for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
        int used = sprintf(text, "# dof: x\nt_s,%s\n", cases[n].name);
        for (int i = 0; i < 1000; i++)
            used += sprintf(text + used, "%.4f,%.7g\n", 0.002 * i, cases[n].mean + cases[n].swing * sin(0.05 * i));
        empty(NULL);
        put("1_x.csv", text);
        assert_imports();
        if (!*cases[n].says) assert_string_equal(report.doubtful, "");
        if (!strstr(report.doubtful, cases[n].says)) fail_msg("\"%s\" does not say \"%s\"", report.doubtful, cases[n].says);
    }
    int used = sprintf(text, "# dof: x\n# rate_hz: 500\nt_s,u1\n");
    for (int i = 0; i < 1000; i++) used += sprintf(text + used, "%d,0\n", 2 * i);
    put("1_x.csv", text);
    assert_int_equal(import(), STATUS_USAGE);
    assert_says("1_x.csv:2|milliseconds|t_ms");
}

/* Writes rows of lengths, pressures and references, scaled into the file's units. */
static void put_platform(const char *name, double length, double pressure) {
    static char text[BUFFER];
    int used = sprintf(text, "# dof: x\nt_s,ref_x_m,l1_m,l2_m,p1_1_pa,p2_1_pa,p1_2_pa\n");
    for (int i = 0; i < 1000; i++) {
        double s = sin(0.05 * i);
        used += sprintf(text + used, "%.4f,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g\n", 0.002 * i, 0.004 * s * length, (1.83 + 0.002 * s) * length,
                        (1.82 + 0.002 * s) * length, (3e6 + 1.5e6 * s) * pressure, (2e6 + 1e6 * s) * pressure,
                        (3e6 + 0.5e6 * s) * pressure);
    }
    put(name, text);
}

static void one_unit_is_named_for_all_channels_of_a_kind(void **unused) {
    (void)unused;
    /* the supply has 10 MPa, so 45 means bar, though 45 MPa would be within three times the
     * sensors' full scale */
    static const struct {
        double length, pressure;
        const char *says;
    } cases[] = {
        {1.0, 1.0, ""},
        {1.0, 1e-5, "1_x.csv and 1 more: p1_1_pa is up to 45, in bar?"},
        {1.0, 1e-6, "1_x.csv and 1 more: p1_1_pa is up to 4.5, in MPa?"},
        {1.0, 1e-3, "1_x.csv and 1 more: p1_1_pa is up to 4500, in kPa?"},
        {1.0, 1.0 / 6894.76, "1_x.csv and 1 more: p1_1_pa is up to 652.7, in psi?"},
        {1e3, 1e-5,
         "1_x.csv and 1 more: l1_m is up to 1832, ref_x_m swings by 4, in mm?; 1_x.csv and 1 more: p1_1_pa is up to 45, in bar?"},
    };
    for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
        empty(NULL);
        put_platform("1_x.csv", cases[n].length, cases[n].pressure);
        put_platform("2_x.csv", cases[n].length, cases[n].pressure);
        assert_imports();
        assert_string_equal(report.doubtful, cases[n].says);
    }
}

static void one_axis_goes_to_csv_and_back(void **unused) {
    (void)unused;
    char text[BUFFER], path[2 * PATHS];
    int used = sprintf(text, "# mechanism: axis\nforce_kN,t_s,position_mm,l1_m\n");
    for (int i = 0; i < 1000; i++) used += sprintf(text + used, "%.4f,%.4f,%d,0\n", 0.001 * i, 0.002 * i, i % 50);
    empty(NULL);
    put("1_axis.csv", text);
    assert_imports();
    assert_string_equal(report.missing, "1_axis.csv: ref_m, p1_pa, p2_pa, u");
    assert_string_equal(report.ignored, "1_axis.csv: l1_m");
    struct recording *r = load(log_a);
    assert_int_equal(r->params.mechanism, MECHANISM_AXIS);
    const struct cycle *c = &r->cycle[777];
    assert_true(c->dof == DOF_X && c->in.length_m[0] == 27 * 1e-3 && isnan(c->in.length_m[1]) && isnan(c->in.p1_pa[0]));
    assert_float_equal(c->force_n[0], 777.0, 1e-9);
    assert_int_equal(csv_export(log_a, 0, out, &report, &error), 0);
    if (import_of(out, log_b, NULL)) fail_msg("%s", error.text);
    assert_int_equal(load(log_b)->count, 1000);
    assert_float_equal(load(log_b)->cycle[777].force_n[0], 777.0, 1e-9);
    snprintf(path, sizeof path, "%s/1_x.csv", out);
    assert_int_equal(access(path, R_OK), 0);
    put("2_x.csv", file_of("# dof: x\n", 0, 2000));
    assert_int_equal(import(), STATUS_USAGE);
    assert_says("2_x.csv:2|platform|1_axis.csv");
}

/* Beside a whole test, a stroke of 0.4 s neither keeps it from being read nor shortens it. */
static void a_record_too_short_for_a_test_is_any_motion(void **unused) {
    (void)unused;
    static const int rows[] = {2000, 200};
    empty(NULL);
    for (int file = 0; file < 2; file++) {
        char text[BUFFER], name[16];
        int used = sprintf(text, "t_s,position_mm,force_n\n");
        for (int i = 0; i < rows[file]; i++) used += sprintf(text + used, "%.4f,%.4f,%d\n", 0.002 * i, 10.0 * sin(0.05 * i), i % 7);
        snprintf(name, sizeof name, "%d.csv", file + 1);
        put(name, text);
    }
    assert_imports();
    assert_non_null(strstr(report.notes, "2.csv: shorter than tests.ramp_s, 1 s"));
    const struct recording *r = load(log_a);
    assert_int_equal(r->count, 2200);
    assert_true(r->cycle[0].dof == DOF_X && r->cycle[2000].dof == DOF_NONE && r->cycle[2000].test != r->cycle[0].test);
    assert_true(fabs(r->params.tests.duration_s - 3.0) < 1e-9);
}

static void a_recording_without_a_sinusoid_is_kept(void **unused) {
    (void)unused;
    empty(NULL);
    put("1_free.csv", file_of("# dof: none\n", 5.0, 100));
    put("2_x.csv", file_of("# dof: x\n", 0.0, 2000));
    assert_imports();
    const struct cycle *c = load(log_a)->cycle;
    assert_true(c[0].test >= 0 && c[0].dof == DOF_NONE && c[0].phase == PHASE_NONE && c[0].test_time_s == 5.0 && c[99].out.valve[0] == 99);
    assert_true(c[100].test == 0 && c[100].dof == DOF_X);
    assert_int_equal(csv_export(log_a, 0, out, &report, &error), 0);
    assert_int_equal(report.files, 2);
    assert_int_equal(report.rows, 2100);
    char path[2 * PATHS];
    snprintf(path, sizeof path, "%s/1_none.csv", out);
    assert_int_equal(access(path, R_OK), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(log_to_csv_to_log_keeps_what_identification_reads),
        cmocka_unit_test(csv_to_log_to_csv_gives_the_same_values),
        cmocka_unit_test(numbers_are_read_as_strtod_reads_them),
        cmocka_unit_test(phases_follow_from_time),
        cmocka_unit_test(heads_replace_the_configuration),
        cmocka_unit_test(another_rate_makes_another_period),
        cmocka_unit_test(the_configuration_beside_the_files_is_used),
        cmocka_unit_test(other_programs_files_are_read),
        cmocka_unit_test(every_dialect_gives_the_same_log),
        cmocka_unit_test(units_that_cannot_be_are_named),
        cmocka_unit_test(one_unit_is_named_for_all_channels_of_a_kind),
        cmocka_unit_test(one_axis_goes_to_csv_and_back),
        cmocka_unit_test(a_record_too_short_for_a_test_is_any_motion),
        cmocka_unit_test(a_recording_without_a_sinusoid_is_kept),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
