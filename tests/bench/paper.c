/* `make bench-paper`: Tian 2015's tables beside hexid's own results under the same headings, method
 * C, and the results of other authors' methods, as text and as CSV.
 *
 *     paper HEXID TABLES LEAST_SQUARES OUT [KEY=VALUE ...]
 *
 * Runs HEXID once per case (viscous friction only; with 20..200 N of dry friction) with exact
 * sensors, then LEAST_SQUARES (tests/ident/least_squares.py) on the same logs, one process per
 * core. Leaves the JSON of both in OUT and compares them. hexid's errors are relative to the
 * nominal matrix of its configuration, the paper's errors to the paper's own matrix, because the
 * paper's inputs are rounded and its hydraulics and controller are not printed (docs/method.md). No
 * figure passes or fails here, but a NaN from hexid ends the benchmark with an error. Each table
 * starts with its build, `# hexid ...`.
 * */
#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { CASES = 11, STEP_N = 20, ENTRIES = 10, SETTINGS_MAX = 16 };
enum { METHOD_A, MODIFIED_A, METHOD_B, METHOD_C, LEAST_SQUARES, WAVELET, METHODS };
static const char *const method_names[METHODS] = {"method_a", "modified_a", "method_b", "method_c", "least_squares", "wavelet"};

/* Entries of the matrix in the paper's order. */
struct entry {
    const char *name;
    int row, col;
};
static const struct entry entries[ENTRIES] = {{"mx", 0, 0},  {"my", 1, 1},   {"mz", 2, 2},   {"Ixx", 3, 3},  {"Iyy", 4, 4},
                                              {"Izz", 5, 5}, {"Mt15", 0, 4}, {"Mt24", 1, 3}, {"Mt42", 3, 1}, {"Mt51", 4, 0}};
enum { MT15 = 6, MT24, MT42, MT51 };

struct result {
    double nominal[ENTRIES], value[METHODS][ENTRIES];
    const char *verdict;
};

struct table { /* numbers of a CSV file, NAN where a cell is no number */
    int rows, columns;
    double cell[16][16];
};

static void die(const char *what, const char *why) {
    fprintf(stderr, "bench-paper: %s: %s\n", what, why);
    exit(1);
}

static struct table table_read(const char *directory, const char *name) {
    struct table t = {0};
    char path[400], line[400];
    snprintf(path, sizeof path, "%s/%s", directory, name);
    FILE *in = fopen(path, "r");
    if (!in || !fgets(line, sizeof line, in)) die(path, "cannot be read");
    while (t.rows < 16 && fgets(line, sizeof line, in)) {
        t.columns = 0;
        for (char *cell = strtok(line, ",\n"); cell && t.columns < 16; cell = strtok(NULL, ",\n"), t.columns++) {
            char *end;
            t.cell[t.rows][t.columns] = strtod(cell, &end);
            if (*end) t.cell[t.rows][t.columns] = (double)NAN;
        }
        t.rows++;
    }
    fclose(in);
    return t;
}

/* Starts the child for one part of a case. Case 0: viscous friction only; case k: plus k * STEP_N
 * of dry friction in each cylinder. */
typedef void start_fn(const char *program, const char *out, int index, char *const extra[]);

static void case_path(char path[400], const char *out, int index, const char *ending) {
    snprintf(path, 400, "%s/dry_friction_%03d_n%s", out, index * STEP_N, ending);
}

static void start_hexid(const char *hexid, const char *out, int index, char *const extra[]) {
    char json[400], log[400], extend[80], retract[80];
    case_path(json, out, index, ".json");
    case_path(log, out, index, ".lcm");
    snprintf(extend, sizeof extend, "effects.cylinder_coulomb_friction.force_extend_n=%d", index * STEP_N);
    snprintf(retract, sizeof retract, "effects.cylinder_coulomb_friction.force_retract_n=%d", index * STEP_N);
    const char *argv[2 * SETTINGS_MAX + 18] = {
        hexid, "run", "--hal", "sim:", "--fast", "--json", json, "--log", log, "--set", "lcm.url=", "--set", "sensors.enabled=false"};
    int n = 13;
    if (index) {
        argv[n++] = "--set", argv[n++] = extend;
        argv[n++] = "--set", argv[n++] = retract;
    }
    for (int i = 0; extra[i] && i < SETTINGS_MAX; i++) argv[n++] = "--set", argv[n++] = extra[i];
    execv(hexid, (char *const *)(void *)argv);
}

static void start_least_squares(const char *least_squares, const char *out, int index, char *const extra[]) {
    (void)extra;
    char json[400], log[400];
    case_path(json, out, index, ".least_squares.json");
    case_path(log, out, index, ".lcm");
    execl(least_squares, least_squares, log, "-o", json, (char *)NULL);
}

/* Removes an earlier benchmark's files, so that they cannot pass for results of this one. */
static void forget(const char *out, int index) {
    static const char *const endings[] = {".json", ".least_squares.json", ".lcm"};
    char path[400];
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
        case_path(path, out, index, endings[i]);
        remove(path);
    }
}

static void run_all(start_fn *start, const char *program, const char *out, char *const extra[]) {
    int at_a_time = (int)sysconf(_SC_NPROCESSORS_ONLN), started = 0, status;
    for (int ended = 0; ended < CASES; ended++) {
        for (; started < CASES && started - ended < at_a_time; started++) {
            pid_t child = fork();
            if (child < 0) die(program, "cannot be started");
            if (child) continue;
            if (freopen("/dev/null", "w", stdout)) start(program, out, started, extra);
            _exit(127);
        }
        if (wait(&status) < 0 || !WIFEXITED(status) || WEXITSTATUS(status) > 1) die(program, "failed: see its message above");
        fprintf(stderr, "bench-paper: %s: %d of %d done\n", program, ended + 1, CASES);
    }
}

static double matrix_entry(const json_t *matrix, const struct entry *e) {
    const json_t *number = json_array_get(json_array_get(matrix, (size_t)e->row), (size_t)e->col);
    return json_is_number(number) ? json_number_value(number) : (double)NAN;
}

static double measured_entry(const json_t *method, const struct entry *e, const char *name) {
    double value = matrix_entry(json_object_get(method, "Mt"), e);
    if (!isfinite(value)) die(name, "has no number for an entry of its matrix: nothing was measured");
    return value;
}

static json_t *read_json(const char *out, int index, const char *ending) {
    char path[400];
    json_error_t error;
    case_path(path, out, index, ending);
    json_t *root = json_load_file(path, 0, &error);
    if (!root) die(path, error.text);
    return root;
}

static struct result result_read(const char *out, int index) {
    struct result r;
    json_t *root = read_json(out, index, ".json"), *others = read_json(out, index, ".least_squares.json");
    for (int i = 0; i < ENTRIES; i++) {
        r.nominal[i] = measured_entry(json_object_get(root, "nominal"), &entries[i], "nominal");
        for (int m = 0; m < METHODS; m++) {
            const json_t *method = json_object_get(m < LEAST_SQUARES ? root : others, method_names[m]);
            r.value[m][i] = measured_entry(method, &entries[i], method_names[m]);
        }
    }
    json_decref(others);
    const char *status = json_string_value(json_object_get(json_object_get(root, "verdict"), "status"));
    r.verdict = !status ? "none" : !strcmp(status, "pass") ? "pass" : !strcmp(status, "fail") ? "fail" : "not_evaluated";
    json_decref(root);
    return r;
}

static double error_pct(double value, double nominal) { return 100.0 * fabs(value - nominal) / fabs(nominal); }

/* Prints a row of numbers to the terminal and to the CSV file. */
static void print_row(FILE *csv, const char *name, const double *cell, int count) {
    printf("%-8s", name);
    fprintf(csv, "%s", name);
    for (int i = 0; i < count; i++) {
        printf(" %10.2f", cell[i]);
        fprintf(csv, ",%.6g", cell[i]);
    }
    printf("\n");
    fprintf(csv, "\n");
}

static char build[120]; /* output of `hexid --version` */

static void read_build(const char *hexid) {
    char command[500];
    snprintf(command, sizeof command, "'%s' --version", hexid);
    FILE *said = popen(command, "r");
    bool read = said && fgets(build, sizeof build, said);
    if (!said || pclose(said) || !read || strncmp(build, "hexid ", 6) != 0) die(hexid, "does not say its version");
    build[strcspn(build, "\n")] = 0;
    printf("%s\n", build);
    fflush(stdout); /* forked children must not inherit buffered output */
}

static FILE *begin(const char *out, const char *name, const char *title, const char *columns) {
    char path[400], heads[400];
    snprintf(path, sizeof path, "%s/%s.csv", out, name);
    FILE *csv = fopen(path, "w");
    if (!csv) die(path, "cannot be written");
    fprintf(csv, "# %s\n%s\n", build, columns);
    snprintf(heads, sizeof heads, "%s", columns);
    printf("\n%s\n", title);
    const char *first = strtok(heads, ",");
    printf("%-8s", first);
    for (const char *head = strtok(NULL, ","); head; head = strtok(NULL, ",")) printf(" %10s", head);
    printf("\n");
    return csv;
}

/* Prints table 3 or 4. `value` and `error` are the columns of the paper's table for each method, -1
 * if the table has none. */
static void print_methods(FILE *csv, const struct table *paper, const int value[METHODS], const int error[METHODS],
                          const struct result *r) {
    for (int i = 0; i < ENTRIES; i++) {
        double cell[2 + 4 * METHODS] = {paper->cell[i][paper->columns - 2], r->nominal[i]};
        int n = 2;
        for (int m = 0; m < METHODS; m++) {
            if (value[m] < 0 && m < METHOD_C) continue;
            if (value[m] >= 0) cell[n++] = paper->cell[i][value[m]];
            cell[n++] = r->value[m][i];
            if (value[m] >= 0) cell[n++] = paper->cell[i][error[m]];
            cell[n++] = error_pct(r->value[m][i], r->nominal[i]);
        }
        print_row(csv, entries[i].name, cell, n);
    }
    fclose(csv);
}

static void print_sweep(const char *out, const char *tables, const struct result r[CASES]) {
    struct table paper = table_read(tables, "tableC1_dry_friction_sweep.csv");
    FILE *csv = begin(out, "tableC1",
                      "Table C1: dry friction of each cylinder against the coupling entries, method A; m_qz: modified method A. "
                      "p: paper, h: hexid",
                      "force_n,p Mt15,h Mt15,p Mt24,h Mt24,p Mt42,h Mt42,p Mt51,h Mt51,p m_qz,h m_qz,p m_qz %,h m_qz %");
    for (int k = 0; k < paper.rows && k + 1 < CASES; k++) {
        const struct result *h = &r[k + 1];
        double cell[12], m_qz = h->value[MODIFIED_A][MT15];
        char name[16];
        for (int i = 0; i < 4; i++) {
            cell[2 * i] = paper.cell[k][1 + i];
            cell[2 * i + 1] = h->value[METHOD_A][MT15 + i];
        }
        cell[8] = paper.cell[k][5], cell[9] = m_qz;
        cell[10] = paper.cell[k][6], cell[11] = error_pct(m_qz, h->nominal[MT15]);
        snprintf(name, sizeof name, "%g", paper.cell[k][0]);
        print_row(csv, name, cell, 12);
    }
    fclose(csv);
}

/* Prints the errors of a method that the paper does not list. */
static void print_errors(const char *out, const char *title, int method, const struct result r[CASES]) {
    FILE *csv = begin(out, method_names[method], title, "force_n,mx,my,mz,Ixx,Iyy,Izz,Mt15,Mt24,Mt42,Mt51");
    for (int k = 0; k < CASES; k++) {
        double cell[ENTRIES];
        char name[16];
        for (int i = 0; i < ENTRIES; i++) cell[i] = error_pct(r[k].value[method][i], r[k].nominal[i]);
        snprintf(name, sizeof name, "%d", k * STEP_N);
        print_row(csv, name, cell, ENTRIES);
    }
    fclose(csv);
}

/* Prints the errors that docs/method.md, section 4, expects, from an independent simulation of the
 * same machine. */
static void print_expected(const char *out, const struct result *r) {
    static const char *const expected[ENTRIES] = {"0.55", "0.55", "1.0", "4.4", "6.9", "1.2", "2-46", "2-46", "2-46", "2-46"};
    char path[400];
    snprintf(path, sizeof path, "%s/dry_friction_100_n.csv", out);
    FILE *csv = fopen(path, "w");
    if (!csv) die(path, "cannot be written");
    fprintf(csv, "# %s\nentry,expected_pct,method_a_pct\n", build);
    printf("\n100 N of dry friction, method A, error in %%: an independent simulation (docs/method.md), hexid\n");
    for (int i = 0; i < ENTRIES; i++) {
        double pct = error_pct(r->value[METHOD_A][i], r->nominal[i]);
        printf("%-8s %10s %10.2f\n", entries[i].name, expected[i], pct);
        fprintf(csv, "%s,%s,%.6g\n", entries[i].name, expected[i], pct);
    }
    fclose(csv);
}

static void print_experiment(const char *out, const char *tables) {
    struct table paper = table_read(tables, "table5_experiment.csv");
    FILE *csv = begin(out, "table5",
                      "Table 5, for reference: the paper's real machine (no simulation can be held against it without its data)",
                      "entry,nominal,method A,error %,modified A,error %,method B,error %");
    for (int i = 0; i < ENTRIES; i++) {
        double nominal = paper.cell[i][6], cell[7] = {nominal};
        for (int m = 0; m < METHOD_C; m++) {
            cell[1 + 2 * m] = paper.cell[i][3 + m];
            cell[2 + 2 * m] = error_pct(paper.cell[i][3 + m], nominal);
        }
        print_row(csv, entries[i].name, cell, 7);
    }
    fclose(csv);
}

int main(int argc, char **argv) {
    if (argc < 5 || argc > 5 + SETTINGS_MAX) die("usage", "paper HEXID TABLES LEAST_SQUARES OUT [KEY=VALUE ...]");
    const char *tables = argv[2], *out = argv[4];
    struct result r[CASES];
    mkdir(out, 0777);
    read_build(argv[1]);
    for (int i = 0; i < CASES; i++) forget(out, i);
    setenv("HEXID", argv[1], 1);
    run_all(start_hexid, argv[1], out, argv + 5);
    run_all(start_least_squares, argv[3], out, argv + 5);
    for (int i = 0; i < CASES; i++) {
        char log[400];
        case_path(log, out, i, ".lcm");
        remove(log);
        r[i] = result_read(out, i);
    }

    struct table table3 = table_read(tables, "table3_linear_friction.csv"), table4 = table_read(tables, "table4_nonlinear_friction.csv");
    print_methods(begin(out, "table3", "Table 3: viscous friction only. p: paper, h: hexid, LS: least squares; %: against the own nominal",
                        "entry,p nominal,h nominal,p A,h A,p A %,h A %,p B,h B,p B %,h B %,h C,h C %,LS,LS %,wavelet,wavelet %"),
                  &table3, (const int[METHODS]){3, -1, 5, -1, -1, -1}, (const int[METHODS]){4, -1, 6, -1, -1, -1}, &r[0]);
    print_methods(begin(out, "table4", "Table 4: 200 N of dry friction added; mod: modified method A",
                        "entry,p nominal,h nominal,p A,h A,p A %,h A %,p mod,h mod,p mod %,h mod %,p B,h B,p B %,h B %,h C,h C %,LS,LS %,"
                        "wavelet,wavelet %"),
                  &table4, (const int[METHODS]){3, 5, 7, -1, -1, -1}, (const int[METHODS]){4, 6, 8, -1, -1, -1}, &r[CASES - 1]);
    print_sweep(out, tables, r);
    print_errors(out, "Method C: dry friction of each cylinder, N, against the error of each entry in %", METHOD_C, r);
    print_errors(out, "The same of the conventional least squares (tests/ident/least_squares.py)", LEAST_SQUARES, r);
    print_errors(out, "The same of wavelets between reversals", WAVELET, r);
    print_expected(out, &r[5]);
    print_experiment(out, tables);
    printf("\nverdicts of hexid's own checks, 0..200 N:");
    for (int i = 0; i < CASES; i++) printf(" %s", r[i].verdict);
    printf("\nalso in %s/*.csv and *.json\n", out);
    return 0;
}
