/* The result as JSON and as a table: every number arrives, missing values are null, and memory is
 * freed. test_ident_messages.c tests the messages. */
#include "support.h"

#include <float.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>

#include "identification_json.h"
#include "identification_table.h"

struct report {
    struct identification id;
    struct verdicts verdicts;
    struct loop_statistics loop;
};

static uint64_t state;

/* Returns a number of any magnitude, sometimes one that printing may spoil. */
static double awkward(void) {
    static const double spoilt[] = {0.1, -0.0, 1.0 / 3, 5, 1e22, 1.2345678901234567e17, DBL_MAX, -DBL_MIN, 5e-324, 1 + DBL_EPSILON};
    int which = random_below(&state, 30);
    return which < 10 ? spoilt[which] : random_unit(&state) * pow(10, random_below(&state, 60) - 30);
}

static double not_a_number(void) {
    static const double none[] = {NAN, INFINITY, -INFINITY};
    return none[random_below(&state, 3)];
}

static void fill(double *numbers, int count, double (*source)(void)) {
    for (int i = 0; i < count; i++) numbers[i] = source();
}

static void fill_test(struct test_result *t, double (*source)(void)) {
    double *const single[] = {&t->frequency_hz, &t->amplitude, &t->achieved_amplitude, &t->phase_deg};
    for (int i = 0; i < 4; i++) fill(single[i], 1, source);
    fill(t->unwanted_pct, DOFS, source), fill(&t->pose[0][0], 2 * DOFS, source), fill(&t->wrench[0][0], 2 * DOFS, source);
    fill(t->pose_rms, DOFS, source), fill(t->wrench_rms, DOFS, source);
    fill(t->pose_std, DOFS, source), fill(t->wrench_std, DOFS, source);
}

static void fill_method(struct method_result *m, double (*source)(void)) {
    double *const matrix[] = {&m->mt[0][0], &m->bt[0][0], &m->mt_std[0][0], &m->bt_std[0][0]};
    for (int i = 0; i < 4; i++) fill(matrix[i], DOFS * DOFS, source);
    fill(&m->condition_number, 1, source);
    m->evaluated = true;
}

/* Returns a report with every field filled and the tests in reversed order. */
static struct report *report_full(double (*source)(void)) {
    static struct report report;
    struct report *r = &report;
    state = 1;
    *r = (struct report){.id.tests = DOFS, .loop = {.cycles = 28500, .overruns = 3, .lost = 2, .timed = true}};
    for (int i = 0; i < DOFS; i++) {
        r->id.test[i] = (struct test_result){
            .dof = (enum dof)(DOFS - 1 - i), .samples = 2500 - i, .excluded = i, .refused = i % 2 ? REFUSED_INCOMPLETE : REFUSED_NOT};
        fill_test(&r->id.test[i], source);
    }
    fill(&r->id.nominal_mt[0][0], DOFS * DOFS, source);
    fill_method(&r->id.method_a, source), fill_method(&r->id.modified_a, source), fill_method(&r->id.method_b, source);
    fill(&r->loop.period_s, 1, source), fill(r->loop.wake_us, 4, source), fill(r->loop.exec_us, 4, source);
    struct verdict *const every[] = {&r->verdicts.run, &r->verdicts.method_a, &r->verdicts.modified_a, &r->verdicts.method_b,
                                     &r->verdicts.method_c};
    for (size_t i = 0; i < sizeof every / sizeof *every; i++) every[i]->scope = "what it is about";
    verdict_add(&r->verdicts.method_b, VERDICT_FAIL, "method B's own");
    verdict_note(&r->verdicts.run, "nobody stated this");
    verdict_add(&r->verdicts.run, VERDICT_NOT_EVALUATED, "first");
    verdict_add(&r->verdicts.run, VERDICT_FAIL, "with a \"quote\", a \\ and a %%");
    return r;
}

static json_t *parsed(const struct report *r) {
    char *text = identification_json(&r->id, &r->verdicts, &r->loop);
    assert_non_null(text);
    json_error_t error;
    json_t *root = json_loads(text, JSON_REJECT_DUPLICATES, &error);
    if (!root) fail_msg("line %d: %s", error.line, error.text);
    free(text);
    return root;
}

static json_t *member(const json_t *object, const char *key) {
    json_t *value = json_object_get(object, key);
    if (!value) fail_msg("no \"%s\"", key);
    return value;
}

/* Asserts that the numbers are equal bit for bit, so -0.0 is not 0.0. Values that JSON cannot
 * express are null. */
static void assert_number(const json_t *got, double expected) {
    double value = json_real_value(got);
    if (!isfinite(expected) ? !json_is_null(got) : !json_is_real(got) || memcmp(&value, &expected, sizeof value) != 0)
        fail_msg("%.17g (type %d), not %.17g", value, (int)json_typeof(got), expected);
}

static void assert_member(const json_t *object, const char *key, double expected) { assert_number(member(object, key), expected); }

/* Asserts that the array has `count` numbers: every step-th one of `expected`. */
static void assert_vector(const json_t *got, const double *expected, int count, int step) {
    assert_true(json_is_array(got));
    assert_int_equal(json_array_size(got), count);
    for (int i = 0; i < count; i++) assert_number(json_array_get(got, (size_t)i), expected[i * step]);
}

static void assert_matrix(const json_t *got, const double expected[DOFS][DOFS]) {
    assert_int_equal(json_array_size(got), DOFS);
    for (int i = 0; i < DOFS; i++) assert_vector(json_array_get(got, (size_t)i), expected[i], DOFS, 1);
}

static void assert_test(const json_t *got, const struct test_result *t) {
    double rms[2 * DOFS];
    memcpy(rms, t->pose_rms, sizeof t->pose_rms), memcpy(rms + DOFS, t->wrench_rms, sizeof t->wrench_rms);
    assert_string_equal(json_string_value(member(got, "dof")), dof_names[t->dof]);
    assert_member(got, "frequency_hz", t->frequency_hz), assert_member(got, "amplitude", t->amplitude);
    assert_member(got, "achieved_amplitude", t->achieved_amplitude), assert_member(got, "phase_deg", t->phase_deg);
    assert_int_equal(json_integer_value(member(got, "samples")), t->samples);
    assert_int_equal(json_integer_value(member(got, "excluded")), t->excluded);
    assert_true(json_is_boolean(member(got, "complete")) && json_is_true(member(got, "complete")) == !t->refused);
    assert_vector(member(got, "unwanted_pct"), t->unwanted_pct, DOFS, 1);
    assert_vector(member(got, "residual_rms"), rms, 2 * DOFS, 1);
    assert_vector(member(member(got, "pose"), "sin"), &t->pose[0][0], DOFS, 2);
    assert_vector(member(member(got, "pose"), "cos"), &t->pose[0][1], DOFS, 2);
    assert_vector(member(member(got, "wrench"), "sin"), &t->wrench[0][0], DOFS, 2);
    assert_vector(member(member(got, "wrench"), "cos"), &t->wrench[0][1], DOFS, 2);
    assert_vector(member(got, "wrench_std"), t->wrench_std, DOFS, 1);
}

static void assert_method(const json_t *root, const char *name, const struct method_result *m, bool damping) {
    const json_t *got = member(root, name);
    assert_matrix(member(got, "Mt"), m->mt), assert_matrix(member(got, "std"), m->mt_std);
    assert_member(got, "condition_number", m->condition_number);
    assert_true((json_object_get(got, "Bt") != NULL) == damping);
    if (damping) assert_matrix(member(got, "Bt"), m->bt), assert_matrix(member(got, "Bt_std"), m->bt_std);
}

static void assert_loop(const json_t *got, const struct loop_statistics *s) {
    static const char *const quantile[] = {"p50", "p99", "p999", "max"};
    assert_int_equal(json_integer_value(member(got, "cycles")), s->cycles);
    assert_int_equal(json_integer_value(member(got, "overruns")), s->overruns);
    assert_int_equal(json_integer_value(member(got, "lost_records")), s->lost);
    assert_member(got, "period_s", s->period_s);
    for (int i = 0; i < 4; i++) {
        assert_member(member(got, "wake_us"), quantile[i], s->wake_us[i]);
        assert_member(member(got, "exec_us"), quantile[i], s->exec_us[i]);
    }
}

static void assert_all(const json_t *root, const struct report *r) {
    assert_int_equal(json_array_size(member(root, "tests")), r->id.tests);
    for (int i = 0; i < r->id.tests; i++) assert_test(json_array_get(member(root, "tests"), (size_t)i), &r->id.test[i]);
    assert_matrix(member(member(root, "nominal"), "Mt"), r->id.nominal_mt);
    assert_method(root, "method_a", &r->id.method_a, true);
    assert_method(root, "modified_a", &r->id.modified_a, false);
    assert_method(root, "method_b", &r->id.method_b, false);
    assert_loop(member(root, "loop"), &r->loop);
}

static void json_keeps_every_number_bit_for_bit(void **unused) {
    (void)unused;
    struct report *r = report_full(awkward);
    json_t *root = parsed(r);
    assert_all(root, r);
    json_decref(root);
}

static void json_names_its_schema_and_has_its_keys_and_no_others(void **unused) {
    (void)unused;
    static const char *const keys[] = {"schema",   "tests",           "nominal",    "method_a", "modified_a", "method_b",
                                       "method_c", "method_c_reason", "errors_pct", "loop",     "verdict"};
    json_t *root = parsed(report_full(awkward));
    assert_string_equal(json_string_value(member(root, "schema")), "hexid.identification/1");
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) member(root, keys[i]);
    assert_int_equal(json_object_size(root), sizeof keys / sizeof *keys);
    assert_true(json_is_null(member(root, "method_c")) && json_is_null(member(root, "method_c_reason")));
    json_decref(root);
}

static void json_has_method_c_with_its_friction_or_why_not(void **unused) {
    (void)unused;
    struct report *r = report_full(awkward);
    struct method_c *c = &r->id.method_c;
    fill_method(&c->matrix, awkward);
    fill(c->viscous, LEGS, awkward), fill(&c->dry[0][0], 2 * LEGS, awkward), fill(&c->dry_std[0][0], 2 * LEGS, awkward);
    c->matrix.mt[2][3] = NAN;
    c->payload.evaluated = true;
    fill(c->payload.value, PAYLOAD_VALUES, awkward), fill(c->payload.std, PAYLOAD_VALUES, awkward);
    json_t *root = parsed(r), *m = member(root, "method_c"), *dry = member(m, "dry_friction_n");
    assert_true(json_is_null(json_array_get(json_array_get(member(m, "Mt"), 2), 3)));
    for (int k = 0; k < LEGS; k++) {
        assert_number(json_array_get(member(m, "viscous_n_s_per_m"), (size_t)k), c->viscous[k]);
        assert_number(json_array_get(member(dry, "extend"), (size_t)k), c->dry[k][0]);
        assert_number(json_array_get(member(dry, "retract"), (size_t)k), c->dry[k][1]);
        assert_number(json_array_get(member(dry, "retract_std"), (size_t)k), c->dry_std[k][1]);
    }
    json_t *payload = member(m, "payload");
    for (int i = 0; i < PAYLOAD_VALUES; i++) {
        assert_member(member(payload, "value"), payload_names[i], c->payload.value[i]);
        assert_member(member(payload, "std"), payload_names[i], c->payload.std[i]);
    }
    assert_false(json_boolean_value(member(payload, "possible")));
    json_decref(root);
    c->matrix.evaluated = false;
    error_set(&r->id.no_method_c, STATUS_USAGE, "some leg does not move");
    root = parsed(r);
    assert_true(json_is_null(member(root, "method_c")));
    assert_string_equal(json_string_value(member(root, "method_c_reason")), "some leg does not move");
    json_decref(root);
}

static void json_keeps_the_verdict_word_by_word(void **unused) {
    (void)unused;
    struct report *r = report_full(awkward);
    json_t *root = parsed(r), *verdict = member(root, "verdict"), *reasons = member(verdict, "reasons");
    assert_string_equal(json_string_value(member(verdict, "status")), "fail");
    assert_string_equal(json_string_value(member(verdict, "scope")), r->verdicts.run.scope);
    assert_int_equal(json_array_size(reasons), 2);
    for (int i = 0; i < 2; i++) assert_string_equal(json_string_value(json_array_get(reasons, (size_t)i)), r->verdicts.run.reason[i]);
    assert_string_equal(json_string_value(json_array_get(member(verdict, "notes"), 0)), "nobody stated this");
    json_decref(root);
}

static void json_has_the_verdict_of_each_method_in_its_place(void **unused) {
    (void)unused;
    struct report *r = report_full(awkward);
    fill_method(&r->id.method_c.matrix, awkward);
    verdict_add(&r->verdicts.method_c, VERDICT_NOT_EVALUATED, "method C's own");
    json_t *root = parsed(r);
    static const struct {
        const char *method, *status, *reason;
    } expected[] = {{"method_a", "pass", NULL},
                    {"modified_a", "pass", NULL},
                    {"method_b", "fail", "method B's own"},
                    {"method_c", "not_evaluated", "method C's own"}};
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        const json_t *verdict = member(member(root, expected[i].method), "verdict"), *reasons = member(verdict, "reasons");
        assert_string_equal(json_string_value(member(verdict, "status")), expected[i].status);
        assert_int_equal(json_array_size(reasons), expected[i].reason != NULL);
        if (expected[i].reason) assert_string_equal(json_string_value(json_array_get(reasons, 0)), expected[i].reason);
    }
    json_decref(root);
}

static void json_errors_are_against_the_nominal_entries(void **unused) {
    (void)unused;
    static const struct {
        const char *name;
        int row, col;
    } entry[] = {{"mx", 0, 0},  {"my", 1, 1},   {"mz", 2, 2},   {"Ixx", 3, 3},  {"Iyy", 4, 4},
                 {"Izz", 5, 5}, {"Mt15", 0, 4}, {"Mt24", 1, 3}, {"Mt42", 3, 1}, {"Mt51", 4, 0}};
    struct report *r = report_full(awkward);
    const struct method_result *method[] = {&r->id.method_a, &r->id.modified_a, &r->id.method_b};
    static const char *const name[] = {"method_a", "modified_a", "method_b"};
    for (int i = 0; i < DOFS; i++)
        for (int k = 0; k < DOFS; k++) r->id.nominal_mt[i][k] = i + k == 4 || i + k == 3 ? -14.9 : 272.0;
    r->id.nominal_mt[5][5] = 0; /* without a nominal value there is nothing to compare with, so the
                                 * error is null */
    json_t *root = parsed(r);
    for (int m = 0; m < 3; m++) {
        const json_t *errors = member(member(root, "errors_pct"), name[m]);
        assert_int_equal(json_object_size(errors), 10);
        for (int e = 0; e < 10; e++) {
            int row = entry[e].row, col = entry[e].col;
            double nominal = r->id.nominal_mt[row][col];
            assert_member(errors, entry[e].name, 100.0 * (method[m]->mt[row][col] - nominal) / nominal);
        }
    }
    json_decref(root);
}

static void json_has_null_for_what_was_not_evaluated(void **unused) {
    (void)unused;
    static const char *const method[] = {"method_a", "modified_a", "method_b"};
    struct report *r = report_full(awkward);
    r->id.method_a.evaluated = r->id.modified_a.evaluated = r->id.method_b.evaluated = false;
    r->id.tests = 0;
    r->loop.timed = false;
    json_t *root = parsed(r);
    for (int m = 0; m < 3; m++) {
        assert_true(json_is_null(member(root, method[m])));
        assert_true(json_is_null(member(member(root, "errors_pct"), method[m])));
    }
    assert_true(json_is_null(member(member(root, "loop"), "wake_us")) && json_is_null(member(member(root, "loop"), "exec_us")));
    assert_int_equal(json_array_size(member(root, "tests")), 0);
    json_decref(root);
}

/* A strict parser would refuse a bare nan. */
static void json_never_has_what_is_not_a_number(void **unused) {
    (void)unused;
    struct report *r = report_full(not_a_number);
    json_t *root = parsed(r);
    assert_all(root, r);
    for (int m = 0; m < IDENT_ENTRIES; m++)
        assert_true(json_is_null(member(member(member(root, "errors_pct"), "method_a"), ident_entries[m].name)));
    json_decref(root);
}

/* Jansson's allocations: number of blocks in use, number of the request that fails (-1: none), and
 * number of requests. */
static int held, fail_at, requests;

static void *counting_malloc(size_t size) {
    if (requests++ == fail_at) return NULL;
    held++;
    return malloc(size);
}

static void counting_free(void *memory) {
    held -= memory != NULL;
    free(memory);
}

/* Makes JSON while counting Jansson's allocations. At the end only the text may remain
 * allocated. */
static char *json_counted(const struct report *r, int failing) {
    held = requests = 0;
    fail_at = failing;
    json_set_alloc_funcs(counting_malloc, counting_free);
    char *text = identification_json(&r->id, &r->verdicts, &r->loop);
    json_set_alloc_funcs(malloc, free);
    return text;
}

static void json_gives_back_all_memory_but_the_text(void **unused) {
    (void)unused;
    struct report *r = report_full(awkward);
    for (int evaluated = 0; evaluated < 2; evaluated++) {
        r->id.method_a.evaluated = r->id.modified_a.evaluated = r->id.method_b.evaluated = evaluated;
        char *text = json_counted(r, -1);
        assert_non_null(text);
        assert_int_equal(held, 1);
        free(text);
    }
}

static void json_without_memory_is_null_never_a_part_of_the_result(void **unused) {
    (void)unused;
    struct report *r = report_full(awkward);
    r->id.tests = 1;
    char *whole = json_counted(r, -1);
    int all = requests;
    for (int failing = 0; failing < all; failing++) {
        char *text = json_counted(r, failing);
        if (text && strcmp(text, whole) != 0) fail_msg("allocation %d of %d failed: a part of the result", failing, all);
        if (held != (text != NULL)) fail_msg("allocation %d of %d failed: %d pieces not given back", failing, all, held);
        free(text);
    }
    free(whole);
}

static void print_table(const struct identification *id, char *text, size_t size) {
    memset(text, 0, size);
    FILE *out = fmemopen(text, size, "w");
    assert_non_null(out);
    identification_table_print(out, id, true);
    fclose(out);
}

/* Reads the eight numbers of an entry's row. */
static void read_row(const char *text, const struct ident_entry *e, double number[8]) {
    char label[20];
    const char *row = text;
    snprintf(label, sizeof label, "\n%s ", e->name);
    row = strstr(row, label);
    if (!row) fail_msg("no row %s", e->name);
    row += strlen(label);
    row += strspn(row, " ");
    assert_memory_equal(row, e->unit, strlen(e->unit));
    row += strlen(e->unit);
    for (int i = 0; i < 8; i++) {
        char *end;
        number[i] = strtod(row, &end);
        if (end == row) fail_msg("row %s has %d numbers", e->name, i);
        row = end;
    }
    assert_int_equal(*row, '\n');
}

static double plain(void) { return (random_unit(&state) < 0 ? -1 : 1) * (100 + 200 * fabs(random_unit(&state))); }

static void table_has_a_row_an_entry_with_its_numbers(void **unused) {
    (void)unused;
    struct identification *id = &report_full(plain)->id;
    char text[4096];
    print_table(id, text, sizeof text);
    for (int i = 0; i < IDENT_ENTRIES; i++) {
        const struct ident_entry *e = &ident_entries[i];
        const struct method_result *method[] = {&id->method_a, &id->modified_a, &id->method_b};
        double number[8], nominal = id->nominal_mt[e->row][e->col];
        double whole = sqrt(fabs(id->nominal_mt[e->row][e->row] * id->nominal_mt[e->col][e->col]));
        read_row(text, e, number);
        assert_close(number[0], nominal, 0.000501); /* tolerance: values have three decimals, errors
                                                     * two */
        for (int m = 0; m < 3; m++) {
            double found = method[m]->mt[e->row][e->col];
            assert_close(number[1 + 2 * m], found, 0.000501);
            assert_close(number[2 + 2 * m], 100 * (found - nominal) / whole, 0.00501);
        }
        assert_close(number[7], 1.96 * id->method_a.mt_std[e->row][e->col], 0.000501);
    }
    double bt[DOFS];
    const char *line = strstr(text, "diagonal of Bt:");
    assert_non_null(line);
    int read = sscanf(line, "diagonal of Bt: %lf %lf %lf N s/m, %lf %lf %lf N m s", bt, bt + 1, bt + 2, bt + 3, bt + 4, bt + 5);
    assert_int_equal(read, DOFS);
    for (int i = 0; i < DOFS; i++) assert_close(bt[i], id->method_a.bt[i][i], i < 3 ? 0.0501 : 0.00501);
}

static void method_cs_matrix_is_followed_by_the_nominal_one(void **unused) {
    (void)unused;
    struct identification *id = &report_full(plain)->id;
    static char text[8192];
    id->method_c.matrix.evaluated = true;
    print_table(id, text, sizeof text);
    char *at = strstr(text, "nominal Mt, from the configuration\n");
    assert_non_null(at);
    at = strchr(at, '\n') + 1;
    for (int i = 0; i < DOFS; i++) {
        at += strspn(at, " ") + strlen(dof_names[i]);
        for (int j = 0; j < DOFS; j++) assert_close(strtod(at, &at), id->nominal_mt[i][j], 0.000501);
        assert_int_equal(*at++, '\n');
    }
}

static void table_is_one_line_without_numbers_when_not_evaluated(void **unused) {
    (void)unused;
    struct identification *id = &report_full(plain)->id;
    char text[4096];
    id->method_a.evaluated = id->modified_a.evaluated = id->method_b.evaluated = false;
    print_table(id, text, sizeof text);
    assert_string_equal(text, "\nmatrix    not evaluated: needs complete tests of all six axes\n");
}

static void brief_table_has_the_diagonal_and_what_is_not_determined(void **unused) {
    (void)unused;
    char text[4000] = "";
    struct identification *id = &report_full(plain)->id;
    struct method_result *m = &id->method_c.matrix;
    fill_method(m, plain);
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < DOFS; j++) m->mt[i][j] = m->mt[j][i];
    m->mt[2][2] = NAN;
    FILE *out = fmemopen(text, sizeof text, "w");
    assert_non_null(out);
    identification_brief_print(out, id, true);
    fclose(out);
    const char *nominal = strstr(text, "\nnominal ") + 9, *found = strstr(text, "\nmethod C ") + 10, *error = strstr(text, "\nerror ") + 7,
               *interval = strstr(text, "\n+- 95 % ") + 9;
    for (int i = 0; i < DOFS; i++) {
        char *end;
        assert_close(strtod(nominal, &end), id->nominal_mt[i][i], 0.000501);
        nominal = end;
        if (i == 2) found = strchr(found, '-') + 1, error = strchr(error, '-') + 1, interval = strchr(interval, '-') + 1;
        if (i == 2) continue;
        assert_close(strtod(found, &end), m->mt[i][i], 0.000501);
        found = end;
        assert_close(strtod(error, &end), 100.0 * (m->mt[i][i] / id->nominal_mt[i][i] - 1.0), 0.00501);
        error = end;
        assert_close(strtod(interval, &end), 196.0 * m->mt_std[i][i] / id->nominal_mt[i][i], 0.00501);
        interval = end;
    }
    assert_non_null(strstr(text, "not determined: Mt33\n"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(brief_table_has_the_diagonal_and_what_is_not_determined),
        cmocka_unit_test(json_keeps_every_number_bit_for_bit),
        cmocka_unit_test(json_names_its_schema_and_has_its_keys_and_no_others),
        cmocka_unit_test(json_has_method_c_with_its_friction_or_why_not),
        cmocka_unit_test(json_keeps_the_verdict_word_by_word),
        cmocka_unit_test(json_has_the_verdict_of_each_method_in_its_place),
        cmocka_unit_test(json_errors_are_against_the_nominal_entries),
        cmocka_unit_test(json_has_null_for_what_was_not_evaluated),
        cmocka_unit_test(json_never_has_what_is_not_a_number),
        cmocka_unit_test(json_gives_back_all_memory_but_the_text),
        cmocka_unit_test(json_without_memory_is_null_never_a_part_of_the_result),
        cmocka_unit_test(table_has_a_row_an_entry_with_its_numbers),
        cmocka_unit_test(method_cs_matrix_is_followed_by_the_nominal_one),
        cmocka_unit_test(table_is_one_line_without_numbers_when_not_evaluated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
