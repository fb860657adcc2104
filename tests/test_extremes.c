/* Every numeric key at the ends of its range: hexid either works with any permitted configuration
 * or refuses it in words, without an abort or NaN. Each case runs in its own process.
 * `make test-long` tries more values per key and everything that doctor and a run check before
 * motion. */
#include "platform_rig.h"

#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "config_keys.h"
#include "doctor.h"
#include "motion_check.h"
#include "trajectory_file.h"

static bool all;

enum outcome { WORKS, REFUSED, REFUSED_WITHOUT_WORDS, NOT_FINITE, DIED, OUTCOMES };
static const char *const outcomes[] = {"works", "is refused", "is refused without words", "makes NaN"};

static bool said(const struct error *error) {
    return strlen(error->text) > 10 && !strstr(error->text, "nan") && !strstr(error->text, "inf ");
}

static enum outcome look(const struct params *p) {
    static doctor_check *const checks[] = {check_kinematics, check_workspace,    check_strokes, check_cylinders, check_payload,
                                           check_loop,       check_feed_forward, check_limits,  check_blind_time};
    const struct doctor d = {.params = p, .url = "sim:", .root = ""};
    for (size_t i = 0; i < sizeof checks / sizeof *checks; i++) {
        struct finding f = checks[i](&d);
        if (strstr(f.found, "nan")) return NOT_FINITE;
        json_decref(f.data);
    }
    return WORKS;
}

static bool finite_plant(const struct plant *plant) {
    struct plant_truth t;
    plant_get_truth(plant, &t);
    for (int i = 0; i < LEGS; i++)
        if (!isfinite(t.pose[i]) || !isfinite(t.length_m[i]) || !isfinite(t.p1_pa[i]) || !isfinite(t.p2_pa[i]) || !isfinite(t.spool[i]))
            return false;
    return isfinite(t.kinetic_j) && isfinite(t.potential_j);
}

/* Runs the loop from its first cycle, parks, and engages. */
static enum outcome drive(const struct params *p, struct error *error) {
    struct platform platform;
    struct cycle now = {0};
    static const double centred[LEGS] = {0};
    int cycles = all ? 200 : 70;
    struct plant *plant = plant_create(p, 1, error);
    if (!plant) return said(error) ? REFUSED : REFUSED_WITHOUT_WORDS;
    if (platform_init(&platform, p, error)) return said(error) ? REFUSED : REFUSED_WITHOUT_WORDS;
    for (int n = 0; n < cycles; n++) {
        struct hal_sample in = {.time_ns = ns_from_seconds(n * p->loop.period_s), .device_seq = (uint64_t)n + 1};
        plant_measure(plant, &in);
        platform_step(&platform, &in, (struct request){0}, &now);
        plant_step(plant, now.out.enable ? now.out.valve : centred);
        for (int i = 0; i < LEGS; i++)
            if (!isfinite(now.out.valve[i]) || !isfinite(now.pose[i]) || !isfinite(now.ref[i])) return NOT_FINITE;
    }
    bool finite = finite_plant(plant);
    plant_destroy(plant);
    return finite ? WORKS : NOT_FINITE;
}

/* checks: doctor's checks and those of a motion are made, too. */
static enum outcome try_setting(const char *const settings[], int count, bool checks) {
    struct params p;
    struct trajectory trajectory = {0};
    struct error error = {0};
    if (config_load(&p, NULL, settings, count, &error)) return said(&error) ? REFUSED : REFUSED_WITHOUT_WORDS;
    if (p.mechanism != MECHANISM_STEWART) return WORKS;
    enum outcome looked = checks ? look(&p) : WORKS;
    if (looked != WORKS) return looked;
    /* checking the tests simulates all of their duration */
    bool brief = p.tests.ramp_s + p.tests.ramp_out_s + p.tests.duration_s < 60.0;
    if (checks && brief && motion_check_tests(&p, &trajectory, &error)) return said(&error) ? REFUSED : REFUSED_WITHOUT_WORDS;
    p.interlocks = (struct interlock_params){0};
    return drive(&p, &error);
}

/* Checks a setting in a process of its own, so that an abort is detected. */
static void check_setting(const char *setting, const char *engine, bool checks, int count[]) {
    const char *const settings[] = {engine, setting};
    int status;
    fflush(NULL);
    pid_t child = fork();
    assert_true(child >= 0);
    if (!child) {
        const struct rlimit hung = {120, 120};
        setrlimit(RLIMIT_CPU, &hung);
        /* discards the assertions that ODE prints */
        if (!freopen("/dev/null", "w", stderr)) _exit(100);
        _exit(try_setting(settings, 2, checks));
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    int outcome = WIFSIGNALED(status) ? DIED : WEXITSTATUS(status);
    if (outcome > REFUSED)
        print_message("# %s, %s: %s (signal %d)\n", setting, engine, outcome < DIED ? outcomes[outcome] : "died",
                      WIFSIGNALED(status) ? WTERMSIG(status) : 0);
    count[outcome < DIED ? outcome : DIED]++;
}

static int values_of(const struct config_key *key, double value[16]) {
    const double shares[] = {1e-9, 1e-6, 1e-3, 0.1, 10.0, 1e3};
    double usual = strtod(key->value, NULL);
    int n = 0;
    value[n++] = key->min;
    value[n++] = key->max;
    if (key->min < 0.0 && key->max > 0.0) value[n++] = 0.0;
    for (int i = 0; i < 6 && all; i++) {
        double x = (usual == 0.0 ? 1.0 : usual) * shares[i];
        if (x > key->min && x < key->max && key->kind != CONFIG_INTEGER) value[n++] = x;
    }
    return n;
}

static void sweep(const char *engine, int every) {
    struct config_key key;
    int count[OUTCOMES] = {0};
    for (int i = 0; config_key_at(i, &key); i += every) {
        double value[16];
        bool number = key.kind == CONFIG_REAL || key.kind == CONFIG_INTEGER || key.kind == CONFIG_REALS || key.kind == CONFIG_REALS_ALIKE;
        for (int n = number ? values_of(&key, value) : 0; n > 0; n--) {
            char setting[160];
            snprintf(setting, sizeof setting, "%s=%.17g", key.path, value[n - 1]);
            /* the checks, which take most of the time, do not depend on the engine */
            bool end = value[n - 1] == key.min || value[n - 1] == key.max || value[n - 1] == 0.0;
            check_setting(setting, engine, all && end && !strcmp(engine, "sim.engine=ode"), count);
        }
    }
    print_message("# %s: %d work, %d are refused in words\n", engine, count[WORKS], count[REFUSED]);
    assert_true(count[WORKS] > 100 / every && count[REFUSED] > 20 / every);
    assert_int_equal(count[REFUSED_WITHOUT_WORDS] + count[NOT_FINITE] + count[DIED], 0);
}

static void every_key_at_its_ends_works_or_is_refused_with_ode(void **unused) {
    (void)unused;
    slow_sweep();
    sweep("sim.engine=ode", all ? 1 : 3); /* ODE takes eight times as long */
}

static void every_key_at_its_ends_works_or_is_refused_with_the_closed_form(void **unused) {
    (void)unused;
    slow_sweep();
    sweep("sim.engine=closed_form", 1);
}

/* ODE aborts on a body without mass or inertia; the closed form accepts such a body. */
static void a_leg_without_mass_is_refused_by_its_key_or_simulated(void **unused) {
    (void)unused;
    static const char *const keys[] = {"upper_mass_kg", "lower_mass_kg", "upper_inertia_kg_m2", "lower_inertia_kg_m2"};
    for (int i = 0; i < 4; i++)
        for (int engine = ENGINE_ODE; engine <= ENGINE_CLOSED_FORM; engine++) {
            char setting[80];
            const char *const one = setting;
            struct params p;
            struct error error = {0};
            snprintf(setting, sizeof setting, "actuator.%s=0", keys[i]);
            assert_int_equal(config_load(&p, NULL, &one, 1, &error), 0);
            p.sim.engine = (enum engine_kind)engine;
            struct plant *plant = plant_create(&p, 1, &error);
            assert_true((plant != NULL) == (engine == ENGINE_CLOSED_FORM));
            if (plant) plant_destroy(plant);
            else {
                assert_int_equal(error.status, STATUS_USAGE);
                assert_non_null(strstr(error.text, keys[i]));
                assert_non_null(strstr(error.text, "closed_form"));
            }
        }
}

int main(void) {
    all = more_cases();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_leg_without_mass_is_refused_by_its_key_or_simulated),
        cmocka_unit_test(every_key_at_its_ends_works_or_is_refused_with_ode),
        cmocka_unit_test(every_key_at_its_ends_works_or_is_refused_with_the_closed_form),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
