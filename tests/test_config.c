#include "support.h"

#include <stdio.h>

#include "config_keys.h"
#include "harmonics.h"
#include "kinematics.h"

static const char shipped[] = "config/tian2015.yaml";

static int parse(struct params *params, const char *text, struct error *error) {
    return config_parse(params, text, strlen(text), "rig.yaml", error);
}

static int load(struct params *params, const char *setting, struct error *error) { return config_load(params, NULL, &setting, 1, error); }

static char *read_file(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    char *text = calloc(1, 1 << 16);
    *size = fread(text, 1, (1 << 16) - 1, file);
    fclose(file);
    return text;
}

/* Generates numbers by xorshift64*, so that values and mutations are the same in every run. */
static uint64_t random_next(uint64_t *state) {
    *state ^= *state >> 12, *state ^= *state << 25, *state ^= *state >> 27;
    return *state * 2685821657736338717u;
}

static double random_share(uint64_t *state) { return (double)(random_next(state) >> 11) * 0x1p-53; }

static bool is_number(const struct config_key *key) {
    return key->kind == CONFIG_REAL || key->kind == CONFIG_INTEGER || key->kind == CONFIG_REALS || key->kind == CONFIG_REALS_ALIKE;
}

static bool set_text(const struct config_key *key, const char *text, struct params *params) {
    struct config_value value;
    char reason[CONFIG_REASON_SIZE];
    return config_value_split(key, text, &value) && config_value_set(key, &value, params, reason);
}

static bool set_number(const struct config_key *key, double number, struct params *params) {
    char text[40];
    snprintf(text, sizeof text, "%.17g", number);
    return set_text(key, text, params);
}

static void default_is_the_shipped_file(void **state) {
    (void)state;
    struct params built_in, file;
    struct error error = {0};
    config_default(&built_in);
    if (config_load(&file, shipped, NULL, 0, &error) != 0) fail_msg("%s", error.text);
    assert_memory_equal(&built_in, &file, sizeof file);
}

/* Without this claim, the test above would pass for an empty file as well. */
static void shipped_file_names_every_key(void **state) {
    (void)state;
    size_t size;
    char *text = read_file(shipped, &size), line[CONFIG_PATH_SIZE + 8], *section = text;
    struct config_key key;
    for (int i = 0; config_key_at(i, &key) && key.effect < 0; i++) {
        int section_length = (int)strcspn(key.path, ".");
        snprintf(line, sizeof line, "\n%.*s:", section_length, key.path);
        section = strstr(text, line);
        const char *dot = strrchr(key.path, '.');
        snprintf(line, sizeof line, dot ? "  %s: " : "%s: ", dot ? dot + 1 : key.path);
        if (!section || !strstr(section + 1, line)) fail_msg("%s is missing", key.path);
    }
    free(text);
}

/* Returns the value of a symbol in tests/data/table*.csv: symbol,description,value,unit. The value
 * is the last field but one, because the description may contain commas. */
static double table_value(const char *path, const char *symbol) {
    size_t size, length = strlen(symbol);
    char *text = read_file(path, &size), *line = strtok(text, "\n");
    double value = NAN;
    for (; line; line = strtok(NULL, "\n")) {
        if (strncmp(line, symbol, length) != 0 || line[length] != ',') continue;
        *strrchr(line, ',') = '\0';
        value = strtod(strrchr(line, ',') + 1, NULL);
    }
    free(text);
    return value;
}

static void geometry_and_inertia_are_the_papers_tables(void **state) {
    (void)state;
    static const char table1[] = "tests/data/table1_geometry.csv", table2[] = "tests/data/table2_inertia.csv";
    struct params p;
    struct error error = {0};
    assert_int_equal(config_load(&p, shipped, NULL, 0, &error), 0);
    const struct {
        const char *table, *symbol;
        double value;
    } rows[] = {
        {table1, "Ra", p.geometry.upper_radius_m},
        {table1, "Rb", p.geometry.lower_radius_m},
        {table1, "H", p.geometry.height_m},
        {table1, "alpha", p.geometry.upper_half_angle_rad},
        {table1, "beta", p.geometry.lower_half_angle_rad},
        {table1, "D", p.actuator.piston_diameter_m[0]},
        {table1, "d", p.actuator.rod_diameter_m[0]},
        {table2, "m", p.payload.mass_kg},
        {table2, "Icxx", p.payload.inertia_xx_kg_m2},
        {table2, "Icyy", p.payload.inertia_yy_kg_m2},
        {table2, "Iczz", p.payload.inertia_zz_kg_m2},
        {table2, "h", p.payload.center_height_m},
        {table2, "ia", p.actuator.upper_inertia_kg_m2[0]},
        {table2, "ib", p.actuator.lower_inertia_kg_m2[0]},
        {table2, "ma", p.actuator.upper_mass_kg[0]},
        {table2, "mb", p.actuator.lower_mass_kg[0]},
        {table2, "ra", p.actuator.upper_center_m[0]},
        {table2, "rb", p.actuator.lower_center_m[0]},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        if (!(table_value(rows[i].table, rows[i].symbol) == rows[i].value)) fail_msg("%s differs: %g", rows[i].symbol, rows[i].value);
}

static void keys_that_scripts_rely_on_exist(void **state) {
    (void)state;
    static const char *const settings[] = {
        "sensors.enabled=false", "sim.engine=closed_form", "sim.engine=ode",           "sim.substeps=16",
        "tests.frequency_hz=5",  "tests.amplitude_m=2e-3", "tests.amplitude_rad=3e-3", "tests.duration_s=2",
        "tests.ramp_s=0.5",      "tests.order=z",          "tests.order=x,psi",        "tests.order=[x, y]",
        "control.kp=39",         "control.ki=0",           "control.kd=0.1",           "control.kff=1.9",
        "control.kpf=0",         "control.tf=0.01",        "control.tp=0.1",           "lcm.url="};
    for (size_t i = 0; i < sizeof settings / sizeof settings[0]; i++) {
        struct params p, before;
        struct error error = {0};
        config_default(&before);
        if (load(&p, settings[i], &error) != 0) fail_msg("%s", error.text);
        if (strcmp(settings[i], "sim.engine=ode") != 0) assert_memory_not_equal(&p, &before, sizeof p);
    }
}

static void a_key_takes_its_bounds_and_nothing_beyond(void **state) {
    (void)state;
    struct config_key key;
    struct params p;
    int numbers = 0;
    config_default(&p);
    for (int i = 0; config_key_at(i, &key); i++) {
        assert_true(set_text(&key, key.value, &p)); /* the default is one of the allowed values */
        if (!is_number(&key)) continue;
        numbers++;
        assert_true(key.min < key.max);
        assert_true(set_number(&key, key.min, &p) && set_number(&key, key.max, &p));
        struct params kept = p;
        assert_false(set_number(&key, nextafter(key.min, -INFINITY), &p) || set_number(&key, nextafter(key.max, INFINITY), &p));
        static const char *const refused[] = {"nan",   "NaN", ".nan", "inf", "-inf", ".inf", "1e999", "-1e999", "",     " ",  "0x10",
                                              "1_000", "1,5", "--1",  "1e",  "e5",   ".",    "12 m",  "1.2.3",  "true", "[]", "[1, 2]"};
        for (size_t k = 0; k < sizeof refused / sizeof refused[0]; k++)
            if (set_text(&key, refused[k], &p)) fail_msg("%s took \"%s\"", key.path, refused[k]);
        assert_memory_equal(&p, &kept, sizeof p); /* a refusal changes nothing */
    }
    assert_true(numbers > 70);
}

static void numbers_are_read_in_any_decimal_notation(void **state) {
    (void)state;
    static const struct {
        const char *text;
        double value;
    } cases[] = {{"40", 40}, {"+40", 40}, {"4e1", 40}, {"4.0E+1", 40}, {".5", 0.5}, {"5.", 5}, {"2.0e-5", 2e-5}, {"0", 0}, {"1e3", 1000}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[80];
        struct params p;
        struct error error = {0};
        snprintf(text, sizeof text, "control: {kp: %s}\n", cases[i].text);
        if (parse(&p, text, &error) != 0) fail_msg("%s", error.text);
        assert_true(p.control.kp == cases[i].value);
    }
}

/* Sets every real number slightly off its default with all 53 bits in use, and every effect on with
 * six different values. */
static void randomize(struct params *p, uint64_t *seed) {
    struct config_key key;
    for (int i = 0; config_key_at(i, &key); i++) {
        double *place = (double *)((char *)p + key.offset);
        if (key.kind == CONFIG_REAL && !(*place == 0.0)) *place *= 1.0 - 1e-4 * random_share(seed);
        if (key.effect < 0) continue;
        p->effects[key.effect].on = true;
        for (int leg = 0; leg < LEGS; leg++)
            place[leg] = key.kind == CONFIG_REALS || leg == 0 ? key.min + (key.max - key.min) * random_share(seed) : place[0];
    }
}

static void text_turns_back_into_the_same_bits(void **state) {
    (void)state;
    uint64_t seed = 1;
    for (int round = 0; round < 50; round++) {
        struct params p, back;
        struct error error = {0};
        config_default(&p);
        if (round > 0) randomize(&p, &seed);
        for (int d = 0; d < DOFS && round > 0; d++) p.tests.hz[d] -= 1e-3 * d, p.tests.amplitude[d] *= 1.0 - 1e-3 * d;
        if (round > 1) p.tests.order[0] = DOF_PSI, p.tests.order[5] = DOF_X;
        if (round > 2) strcpy(p.lcm.url, "file:///tmp/\"odd\" name\\#1: x");
        if (round > 2) memset(p.lcm.url + strlen(p.lcm.url), 0, sizeof p.lcm.url - strlen(p.lcm.url));
        char *text = config_text(&p);
        assert_non_null(text);
        memset(&back, 0x55, sizeof back);
        if (parse(&back, text, &error) != 0) fail_msg("%s\n%s", error.text, text);
        assert_memory_equal(&p, &back, sizeof p);
        free(text);
    }
}

/* The tests of a log stand above those of the configuration that it is evaluated with, key by key,
 * and settings stand above both. */
static void tests_of_another_text_replace_those_that_it_states(void **state) {
    (void)state;
    static const char log[] = "payload:\n  mass_kg: 90\ntests:\n  frequency_hz: 3\n  amplitude_m: 0.4\n  ramp_s: 2\n";
    static const char *const settings[] = {"payload.mass_kg=80", "tests.ramp_s=1.5"};
    struct error error, unread;
    struct params p;
    assert_int_equal(parse(&p, "payload:\n  mass_kg: 200\ntests:\n  amplitude_rad: 0.001\n  ramp_s: 4\n", &error), 0);
    /* no machine reaches 0.4 m here, but what was recorded was reached */
    assert_int_equal(config_take_tests(&p, log, strlen(log), "a.lcm", settings, 2, &unread, &error), 0);
    assert_string_equal(unread.text, "");
    assert_true(p.tests.hz[DOF_PSI] == 3 && p.tests.amplitude[DOF_Z] == 0.4 && p.tests.ramp_s == 1.5);
    assert_true(p.payload.mass_kg == 200 && p.tests.amplitude[DOF_PHI] == 0.001);
    struct test_params before = p.tests;
    assert_int_equal(config_take_tests(&p, "colour: red\n", 12, "a.lcm", NULL, 0, &unread, &error), 0);
    assert_non_null(strstr(unread.text, "colour"));
    assert_int_equal(config_take_tests(&p, NULL, 0, "a.lcm", NULL, 0, &unread, &error), 0);
    assert_memory_equal(&p.tests, &before, sizeof before);
    static const char fast[] = "tests:\n  frequency_hz: 100\nloop:\n  period_s: 0.0001\n";
    p.loop.period_s = 0.01;
    assert_int_equal(config_take_tests(&p, fast, strlen(fast), "a.lcm", NULL, 0, &unread, &error), STATUS_USAGE);
    assert_non_null(strstr(error.text, "a.lcm: tests.frequency_hz of x, 100"));
}

static void a_text_can_leave_keys_and_sections_out(void **state) {
    (void)state;
    static const char *const left_out[] = {"tests.amplitude_m", "payload", NULL};
    struct error error;
    struct params p, again, built_in;
    config_default(&built_in);
    assert_int_equal(parse(&p, "payload:\n  mass_kg: 200\ntests:\n  amplitude_m: 0.001\n  ramp_s: 4\n", &error), 0);
    char *text = config_text_without(&p, left_out);
    assert_int_equal(parse(&again, text, &error), 0);
    free(text);
    p.payload = built_in.payload, memcpy(p.tests.amplitude, built_in.tests.amplitude, 3 * sizeof(double));
    assert_memory_equal(&again.payload, &p.payload, sizeof p.payload);
    assert_memory_equal(&again.tests, &p.tests, sizeof p.tests);
    text = config_text_without(&p, left_out);
    assert_true(config_states(text, strlen(text), "tests.amplitude_rad") && config_states(text, strlen(text), "loop.period_s"));
    assert_false(config_states(text, strlen(text), "tests.amplitude_m") || config_states(text, strlen(text), "payload.mass_kg"));
    free(text);
}

static void settings_override_the_file_and_the_last_one_wins(void **state) {
    (void)state;
    const char *const settings[] = {"control.kp=30", "tests.frequency_hz=5", "control.kp=31"};
    struct params p;
    struct error error = {0};
    assert_int_equal(config_load(&p, shipped, settings, 3, &error), 0);
    assert_true(p.control.kp == 31 && p.tests.hz[DOF_PSI] == 5);
}

/* Equal values are still written as one number. */
static void an_axis_has_a_frequency_and_an_amplitude_of_its_own(void **state) {
    (void)state;
    const char *const settings[] = {"tests.frequency_hz=[1, 2, 3, 4, 5, 6]", "tests.amplitude_m=1e-3,2e-3,3e-3",
                                    "tests.amplitude_rad=4e-3"};
    static const double hz[DOFS] = {1, 2, 3, 4, 5, 6}, amplitude[DOFS] = {1e-3, 2e-3, 3e-3, 4e-3, 4e-3, 4e-3};
    struct params p;
    struct error error = {0};
    assert_int_equal(config_load(&p, shipped, settings, 3, &error), 0);
    assert_memory_equal(p.tests.hz, hz, sizeof hz);
    assert_memory_equal(p.tests.amplitude, amplitude, sizeof amplitude);
    char *text = config_text(&p);
    assert_non_null(strstr(text, "frequency_hz: [1, 2, 3, 4, 5, 6]"));
    assert_non_null(strstr(text, "amplitude_m: [0.001, 0.002, 0.003]"));
    assert_non_null(strstr(text, "amplitude_rad: 0.004 "));
    free(text);
}

/* If a file for an axis omits a diameter, the default is the platform's and does not count as
 * stated; the text made from the configuration omits the diameter as well. */
static void diameters_of_an_axis_are_its_own_or_none(void **state) {
    (void)state;
    struct params p, back;
    struct error error = {0};
    config_default(&p);
    assert_true(p.actuator.stated.piston && p.actuator.stated.rod);
    assert_int_equal(parse(&p, "actuator: {rod_diameter_m: 0.028}\nmechanism: axis\n", &error), 0);
    assert_true(!p.actuator.stated.piston && p.actuator.stated.rod);
    char *text = config_text(&p);
    assert_non_null(strstr(text, "# piston_diameter_m: not stated"));
    assert_int_equal(parse(&back, text, &error), 0);
    assert_memory_equal(&p, &back, sizeof p);
    free(text);
    assert_int_equal(config_override(&p, "test", (const char *const[]){"actuator.piston_diameter_m=0.05"}, 1, &error), 0);
    assert_true(p.actuator.stated.piston && p.actuator.stated.rod);

    /* the rod is not stated, so a piston thinner than the default rod is accepted */
    assert_int_equal(parse(&p, "mechanism: axis\nactuator: {piston_diameter_m: 0.04}\n", &error), 0);
    const char *const settings[] = {"actuator.rod_diameter_m=0.028", "mechanism=axis"};
    assert_int_equal(config_load(&p, NULL, settings, 2, &error), 0);
    assert_true(!p.actuator.stated.piston && p.actuator.stated.rod);
}

static void an_effect_is_off_until_one_of_its_keys_is_set(void **state) {
    (void)state;
    struct config_key key;
    int keys = 0;
    for (int i = 0; config_key_at(i, &key); i++) {
        if (key.effect < 0) continue;
        struct params p, off;
        config_default(&off);
        p = off;
        for (int e = 0; e < EFFECTS_MAX; e++) assert_false(p.effects[e].on);
        double (*values)[LEGS] = p.effects[key.effect].value, *mine = (double *)((char *)&p + key.offset);
        assert_true(set_number(&key, key.max, &p)); /* the file has one number for all legs */
        for (int leg = 0; leg < LEGS; leg++) assert_true(mine[leg] == key.max);
        for (int k = 0; k < EFFECT_KEYS && effect_table[key.effect]->keys[k].name; k++)
            if (values[k] != mine) assert_true(values[k][3] == effect_table[key.effect]->keys[k].neutral);
        for (int e = 0; e < EFFECTS_MAX; e++) assert_int_equal(p.effects[e].on, e == key.effect);
        keys++;
    }
    assert_true(keys > 0);
}

static void a_list_gives_each_leg_its_value_where_the_effect_allows_it(void **state) {
    (void)state;
    struct config_key key;
    for (int i = 0; config_key_at(i, &key); i++) {
        if (key.effect < 0) continue;
        char five[200], six[240];
        double step = (key.max - key.min) / 8;
        snprintf(five, sizeof five, "%.9g,%.9g,%.9g,%.9g,%.9g", key.min, key.min + step, key.min + 2 * step, key.min + 3 * step,
                 key.min + 4 * step);
        snprintf(six, sizeof six, "[%s,%.9g]", five, key.min + 5 * step);
        struct params p;
        config_default(&p);
        assert_false(set_text(&key, five, &p));
        assert_int_equal(set_text(&key, six, &p), key.kind == CONFIG_REALS);
        const double *value = (const double *)((const char *)&p + key.offset);
        for (int leg = 1; leg < LEGS && key.kind == CONFIG_REALS; leg++) assert_true(value[leg] > value[leg - 1]);
    }
}

static const char points[] = "[[0.6, -0.1, 0], [0.6,0.1,0],[-0.2,0.5,1e-2],[-0.4,0.5,0],[-0.4,-0.5,0], [ -0.2 , -0.5 , 0 ] ]";

static void joints_are_six_points_on_the_command_line_and_in_a_file(void **state) {
    (void)state;
    static const double second[3] = {0.6, 0.1, 0.0};
    struct params set, read, again;
    struct error error = {0};
    char text[400];
    snprintf(text, sizeof text, "geometry.upper_joints_m=%s", points);
    if (load(&set, text, &error) != 0) fail_msg("%s", error.text);
    snprintf(text, sizeof text, "geometry:\n  upper_joints_m: %s\n", points);
    if (parse(&read, text, &error) != 0) fail_msg("%s", error.text);
    assert_memory_equal(&set, &read, sizeof set);
    assert_true(set.geometry.upper.given && !set.geometry.lower.given);
    assert_memory_equal(set.geometry.upper.leg[1], second, sizeof second);
    assert_true(set.geometry.upper.leg[2][2] == 0.01 && set.geometry.upper.leg[5][1] == -0.5);
    char *whole = config_text(&set);
    assert_int_equal(config_parse(&again, whole, strlen(whole), "rig.yaml", &error), 0);
    assert_memory_equal(&again, &set, sizeof set);
    free(whole);
    if (load(&set, "geometry.upper_joints_m=[]", &error) != 0) fail_msg("%s", error.text);
    assert_false(set.geometry.upper.given);
}

static void axes_of_joints_are_six_directions(void **state) {
    (void)state;
    static const double second[3] = {0.6, 0.1, 0.0};
    static const char *const ends[] = {"upper", "lower"};
    for (int lower = 0; lower < 2; lower++) {
        struct params set, again;
        struct error error = {0};
        char text[400];
        snprintf(text, sizeof text, "geometry.%s_joint_axes=%s", ends[lower], points);
        if (load(&set, text, &error) != 0) fail_msg("%s", error.text);
        assert_true(set.geometry.upper_axis.given == !lower && set.geometry.lower_axis.given == lower);
        assert_memory_equal((lower ? set.geometry.lower_axis : set.geometry.upper_axis).leg[1], second, sizeof second);
        char *whole = config_text(&set);
        assert_int_equal(config_parse(&again, whole, strlen(whole), "rig.yaml", &error), 0);
        assert_memory_equal(&again, &set, sizeof set);
        free(whole);
    }
}

static void a_leg_has_an_actuator_of_its_own(void **state) {
    (void)state;
    struct params p;
    struct error error = {0};
    if (load(&p, "actuator.piston_diameter_m=0.063,0.063,0.07,0.063,0.063,0.063", &error) != 0) fail_msg("%s", error.text);
    assert_true(p.actuator.piston_diameter_m[2] == 0.07 && p.actuator.piston_diameter_m[3] == 0.063);
    assert_int_equal(load(&p, "actuator.rod_diameter_m=0.045,0.045,0.045,0.045,0.064,0.045", &error), STATUS_USAGE);
    assert_non_null(strstr(error.text, "leg 5"));
    assert_int_equal(load(&p, "actuator.mid_stroke_m=0,0,0,0,0,0.5", &error), STATUS_USAGE);
    assert_non_null(strstr(error.text, "leg 6"));
}

/* Wrong texts, with parts of their messages, which state file, line, key and remedy. */
static const struct {
    const char *text, *message[3];
} mistakes[] = {
    {"control:\n  kp: -3\n", {"rig.yaml:2: control.kp: -3 is outside 0..10000 1/m", "valve command per length error"}},
    {"control:\n  kp: abc\n", {"rig.yaml:2: control.kp: \"abc\" is not a number"}},
    {"control:\n  kp: [1, 2]\n", {"rig.yaml:2: control.kp: a list", "single value"}},
    {"control:\n  kp: {a: 1}\n", {"rig.yaml:2: control.kp takes a value"}},
    {"control:\n  kp:\n", {"rig.yaml:2: control.kp: \"\" is not a number"}},
    {"geometry:\n  upper_joints_m: [1, 2, 3]\n", {"rig.yaml:2: geometry.upper_joints_m takes points, [[x, y, z], ...]"}},
    {"geometry:\n  upper_joints_m: [[1, 2], [3, 4, 5, 6]]\n", {"rig.yaml:2: geometry.upper_joints_m takes points"}},
    {"geometry:\n  upper_joints_m: [[[1, 2, 3]]]\n", {"rig.yaml:2: geometry.upper_joints_m takes"}},
    {"geometry:\n  upper_joints_m: [[1, 2, 3, 4, 5, 6], [1, 2, 3, 4, 5, 6], [1, 2, 3, 4, 5, 6]]\n",
     {"rig.yaml:2: geometry.upper_joints_m takes points"}},
    {"geometry:\n  upper_joints_m: [[], [1, 2, 3]]\n", {"rig.yaml:2: geometry.upper_joints_m takes points"}},
    {"geometry:\n  upper_joints_m: [[1, 2, 3], 4]\n", {"rig.yaml:2: geometry.upper_joints_m takes points"}},
    {"geometry:\n  upper_joints_m:\n    - [1, 2, 3]\n    - [1, 2, 4]\n",
     {"geometry.upper_joints_m: 6 numbers; it takes 6 times [x, y, z]"}},
    {"geometry:\n  lower_joint_axes: [[0, 0, 2]]\n", {"rig.yaml:2: geometry.lower_joint_axes: 3 numbers; it takes 6 times [x, y, z]"}},
    {"geometry:\n  upper_joints_m: 0.5\n", {"rig.yaml:2: geometry.upper_joints_m: 1 numbers; it takes 6 times [x, y, z]"}},
    {"geometry:\n  upper_joints_m: {a: 1}\n", {"rig.yaml:2: geometry.upper_joints_m takes a value"}},
    {"control:\n\n  kpp: 3\n", {"rig.yaml:3: unknown key control.kpp; did you mean control.kp?"}},
    {"contrl:\n  kp: 3\n", {"rig.yaml:1: unknown key contrl; did you mean control?"}},
    {"kp: 3\n", {"rig.yaml:1: unknown key kp; did you mean control.kp?"}},
    {"banana: 3\n", {"rig.yaml:1: unknown key banana; `hexid run --print-config`"}},
    {"control: 3\n", {"rig.yaml:1: control holds keys"}},
    {"control:\n  kp: 3\n  ki: 1\n  kp: 4\n", {"rig.yaml:4: control.kp stands already in line 2"}},
    {"control: {kp: 3}\nloop: {cpu: 0}\ncontrol: {ki: 3}\n", {"rig.yaml:3: control stands already in line 1"}},
    {"control:\n\tkp: 3\n", {"rig.yaml:2: not YAML", "indented with spaces"}},
    {"control: {kp: 3\n", {"rig.yaml:2: not YAML"}},
    {"control: &a {kp: 3}\n", {"rig.yaml:1: anchors, aliases and tags"}},
    {"control:\n  kp: *a\n", {"rig.yaml:2: anchors, aliases and tags"}},
    {"control:\n  kp: !!float 3\n", {"rig.yaml:2: anchors, aliases and tags"}},
    {"control:\n  <<: {kp: 3}\n", {"rig.yaml:2: unknown key control.<<"}},
    {"? [control]\n: 3\n", {"rig.yaml:1: a key is a plain word"}},
    {"\"\": 3\n", {"rig.yaml:1: a key is a plain word"}},
    {"\"control\\0x\": {kp: 3}\n", {"rig.yaml:1: a key is a plain word"}},
    {"control:\n  kp: \"4\\0\"\n", {"rig.yaml:2: control.kp: at most"}},
    {"loop:\n  cpu: 1\nnote\xff: 1\n", {"rig.yaml:3: ", "UTF-8"}},
    {"sim:\n  substeps: 8.5\n", {"rig.yaml:2: sim.substeps: 8.5 is not a whole number"}},
    {"sim:\n  engine: bullet\n", {"rig.yaml:2: sim.engine: \"bullet\" is none of ode, closed_form"}},
    {"sensors:\n  enabled: yes\n", {"rig.yaml:2: sensors.enabled: \"yes\" is neither true nor false"}},
    {"tests:\n  order: []\n", {"rig.yaml:2: tests.order: an empty list"}},
    {"tests:\n  order: [x, x]\n", {"rig.yaml:2: tests.order: x is listed twice"}},
    {"tests:\n  order: [x, w]\n", {"rig.yaml:2: tests.order: \"w\" is none of x, y, z"}},
    {"tests:\n  order: [x, [y]]\n", {"rig.yaml:2: tests.order takes a value"}},
    {"tests:\n  order: [x, y, z, phi, theta, psi, x]\n", {"rig.yaml:2: tests.order: at most 6 values"}},
    {"lcm:\n  url: \"a\\nb\"\n", {"rig.yaml:2: lcm.url: holds a character"}},
    {"effects:\n  valve_lga: {}\n", {"rig.yaml:2: unknown key effects.valve_lga"}},
    {"effects:\n  cylinder_coulomb_friction: {}\n", {"rig.yaml:2: effects.cylinder_coulomb_friction has no key", "hexid effects"}},
    {"effects:\n  cylinder_coulomb_friction:\n", {"rig.yaml:2: effects.cylinder_coulomb_friction has no key"}},
    {"effects: [a]\n", {"rig.yaml:1: effects holds keys"}},
    {"", {"rig.yaml:", "holds no configuration"}},
    {"# nothing\n", {"rig.yaml:", "holds no configuration"}},
    {"just words\n", {"rig.yaml:1: holds no configuration"}},
    {"- control\n", {"rig.yaml:1: holds no configuration"}},
    {"control: {kp: 3}\n---\ncontrol: {kp: 4}\n", {"rig.yaml:2: a second document"}},
    {"control:\n  kp: \"\x1b[2J\"\n", {"rig.yaml:2: ", "control characters"}},
    {"control:\n  kp: \"\\e[2J\"\n", {"rig.yaml:2: control.kp: \"?[2J\" is not a number"}},
};

static void a_mistake_is_reported_with_file_line_and_key(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof mistakes / sizeof mistakes[0]; i++) {
        struct params p;
        struct error error = {0};
        assert_int_equal(parse(&p, mistakes[i].text, &error), STATUS_USAGE);
        assert_int_equal(error.status, STATUS_USAGE);
        for (int k = 0; k < 3 && mistakes[i].message[k]; k++)
            if (!strstr(error.text, mistakes[i].message[k]))
                fail_msg("%s\nsays   %s\nwanted %s", mistakes[i].text, error.text, mistakes[i].message[k]);
    }
}

static void a_wrong_setting_is_reported_with_its_text(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {"control.kp=abc", "--set control.kp=abc: \"abc\" is not a number"},
        {"control.kp=", "--set control.kp=: \"\" is not a number"},
        {"control.kp", "--set control.kp: no value; write --set KEY=VALUE"},
        {"control.kq=3", "--set control.kq=3: unknown key control.kq; did you mean control.k"},
        {"control=3", "--set control=3: control holds keys; write --set control.KEY=VALUE"},
        {"=3", "--set =3: unknown key"},
        {"", "--set : no value"},
        {"tests.frequency_hz=4,4,4,4,4", "a list of 5; it takes one value for all, or 6"},
        {"tests.amplitude_m=1e-3,1e-3,1e-3,1e-3", "a list of 4; it takes one value for all, or 3"},
        {"tests.order=x,,y", "--set tests.order=x,,y: \"\" is none of"},
        {"tests.order=x,y,z,x,y,z,x", "at most 6 values"},
        {"loop.period_s=1e999", "--set loop.period_s=1e999: 1e999 is outside"},
        {"effects.position_sensor_scale.zero_m=0.3", "zero_m alone does nothing: state effects.position_sensor_scale.scale, too"},
        {"effects.pipeline_dynamics.diameter_m=0.03", "diameter_m alone does nothing: state effects.pipeline_dynamics.length_m, too"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct params p;
        struct error error = {0};
        assert_int_equal(load(&p, cases[i][0], &error), STATUS_USAGE);
        if (!strstr(error.text, cases[i][1])) fail_msg("%s says %s", cases[i][0], error.text);
    }
}

static void a_file_that_cannot_be_read_is_named(void **state) {
    (void)state;
    static const char *const cases[][2] = {{"tests/data/absent.yaml", "tests/data/absent.yaml: cannot be read: No such file"},
                                           {"tests", "tests: cannot be read: Is a directory"},
                                           {"/dev/null", "/dev/null: cannot be read: a device"},
                                           {"/dev/zero", "/dev/zero: cannot be read: a device"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct params p;
        struct error error = {0};
        assert_int_equal(config_load(&p, cases[i][0], NULL, 0, &error), STATUS_USAGE);
        if (!strstr(error.text, cases[i][1])) fail_msg("%s says %s", cases[i][0], error.text);
    }
}

static void keys_that_contradict_each_other_are_named(void **state) {
    (void)state;
    static const struct {
        const char *settings[3], *message[2];
    } cases[] = {
        {{"payload.inertia_zz_kg_m2=30"}, {"inertia_zz_kg_m2 30", "no body has them"}},
        {{"actuator.rod_diameter_m=0.063"}, {"actuator.rod_diameter_m", "actuator.piston_diameter_m"}},
        {{"actuator.retracted_std_m=1e-4"}, {"actuator.retracted_std_m", "actuator.retracted_m of leg 1"}},
        {{"hydraulics.dead_volume_difference_m3=-1e-4"}, {"hydraulics.dead_volume_difference_m3", "dead_volume_m3"}},
        {{"actuator.stroke_m=1.3"}, {"actuator.stroke_m", "geometry.height_m"}},
        {{"geometry.height_m=0.5"}, {"actuator.stroke_m", "geometry.height_m"}},
        {{"actuator.upper_center_m=1.5"}, {"actuator.upper_center_m", "shortest leg"}},
        {{"limits.length_min_m=1.9"}, {"limits.length_min_m", "neutral leg length"}},
        {{"limits.length_max_m=1.8"}, {"length_max_m", "neutral leg length"}},
        {{"motion.park_z_m=1.64"}, {"motion.park_z_m", "geometry.height_m"}},
        {{"motion.park_z_m=0.47"}, {"motion.park_z_m", "stroke ends"}},
        {{"limits.length_min_m=1.45"}, {"motion.park_z_m", "limits.length_min_m"}},
        {{"hydraulics.tank_pa=1e7"}, {"hydraulics.tank_pa", "hydraulics.supply_pa"}},
        {{"limits.pressure_max_pa=9e6"}, {"pressure_max_pa", "supply_pa"}},
        {{"limits.pressure_min_pa=1e3"}, {"limits.pressure_min_pa", "tank_pa"}},
        {{"sensors.pressure_full_scale_pa=9e6"}, {"sensors.pressure_full_scale_pa", "hydraulics.supply_pa"}},
        {{"motion.rate_mps=0.6"}, {"motion.rate_mps 0.6", "limits.leg_rate_mps 0.6"}},
        {{"limits.sensor_age_s=0.001"}, {"limits.sensor_age_s", "loop.period_s"}},
        {{"loop.period_s=0.005", "sim.substeps=20", "tests.frequency_hz=51"}, {"tests.frequency_hz", "loop.period_s"}},
        {{"loop.period_s=0.01", "sim.substeps=40", "tests.frequency_hz=10"}, {"tests.harmonics", "tests.frequency_hz"}},
        {{"tests.duration_s=0.4"}, {"tests.duration_s", "at least 0.5 s"}},
        {{"tests.frequency_hz=45", "tests.duration_s=0.046", "limits.leg_rate_mps=2"}, {"tests.duration_s", "tests.harmonics"}},
        {{"tests.amplitude_m=0.41", "tests.frequency_hz=0.1", "tests.duration_s=30"}, {"tests.amplitude_m", "actuator.stroke_m"}},
        {{"tests.amplitude_rad=0.05"}, {"amplitude_rad", "limits.leg_rate_mps"}},
        {{"tests.amplitude_rad=0.001,0.05,0.001"}, {"amplitude_rad of theta, 0.05", "limits.leg_rate_mps"}},
        {{"tests.frequency_hz=4,4,4,4,0.3,4"}, {"tests.duration_s", "(theta): at least 6.66667 s"}},
        {{"sim.substeps=7"}, {"sim.substeps", "at least 8"}},
        {{"sim.smooth_friction_mps=0.0002"}, {"sim.smooth_friction_mps", "closed_form"}},
        {{"loop.period_s=0.004"}, {"sim.substeps", "at least 16"}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct params p;
        struct error error = {0};
        int count = 1;
        while (count < 3 && cases[i].settings[count]) count++;
        if (config_load(&p, shipped, cases[i].settings, count, &error) != STATUS_USAGE) fail_msg("%s was accepted", cases[i].settings[0]);
        assert_non_null(strstr(error.text, shipped));
        for (int k = 0; k < 2; k++)
            if (!strstr(error.text, cases[i].message[k])) fail_msg("%s says %s", cases[i].settings[0], error.text);
    }
}

/* Lists of joints that begin with different legs make legs of unequal lengths, which no limit
 * encloses. */
static void lists_of_joints_in_different_orders_are_named(void **state) {
    (void)state;
    static const char *const names[2] = {"leg 1 in place 5, counted on", "leg 1 in place 2, counted backwards"};
    for (int n = 0; n < 2; n++) {
        struct params p;
        struct kinematics k;
        struct error error = {0};
        config_default(&p);
        kinematics_place(&k, &p);
        p.geometry.upper.given = true;
        for (int i = 0; i < LEGS; i++)
            for (int x = 0; x < 2; x++) p.geometry.upper.leg[i][x] = k.upper[n ? (7 - i) % LEGS : (i + 2) % LEGS][x];
        assert_int_equal(config_check(&p, "rig.yaml", &error), STATUS_USAGE);
        if (!strstr(error.text, "listed otherwise than those of the base") || !strstr(error.text, names[n]))
            fail_msg("\"%s\" does not say \"%s\"", error.text, names[n]);
    }
}

/* All contradictions are listed in one message, so that a new geometry is corrected in one round;
 * each key is named once. */
static void all_that_contradicts_is_said_at_once(void **state) {
    (void)state;
    static const char *const settings[] = {"geometry.height_m=1.2", "motion.park_z_m=0.6", "hydraulics.tank_pa=1e7", "sim.substeps=7"};
    static const char *const says[] = {"hydraulics.tank_pa 1e+07 must be below", "stroke ends", "is in, ", "sim.substeps"};
    struct params p;
    struct error error = {0};
    assert_int_equal(config_load(&p, shipped, settings, 4, &error), STATUS_USAGE);
    for (size_t i = 0; i < sizeof says / sizeof *says; i++) {
        const char *at = strstr(error.text, says[i]);
        if (!at || strstr(at + 1, says[i])) fail_msg("\"%s\" does not have \"%s\" once", error.text, says[i]);
    }
}

static void as_many_harmonics_as_the_regression_has_are_accepted(void **state) {
    (void)state;
    struct config_key key;
    assert_true(config_key_find("tests.harmonics", &key));
    assert_true(key.max == HARMONICS_MAX);
}

/* The texts are so large or so deeply nested that a careless parser becomes slow or crashes. */
static void big_and_deep_text_is_refused(void **state) {
    (void)state;
    enum { SIZE = (1 << 20) + 1 };
    static const char *const patterns[] = {"[", "{", "{control: ", "- ", "a: ", "? ", "a", "\"", "#", "\n", "&a ", "control: [", "%"};
    char *text = malloc(SIZE);
    assert_non_null(text);
    for (size_t i = 0; i < sizeof patterns / sizeof patterns[0]; i++)
        for (int size = SIZE - 1; size <= SIZE; size++) {
            size_t length = strlen(patterns[i]);
            struct params p;
            struct error error = {0};
            for (size_t k = 0; k < SIZE; k++) text[k] = patterns[i][k % length];
            assert_int_equal(config_parse(&p, text, (size_t)size, "big.yaml", &error), STATUS_USAGE);
            assert_non_null(strstr(error.text, size == SIZE ? "big.yaml: larger than" : "big.yaml:"));
        }
    free(text);
}

/* Mutated bytes are accepted, with all values in range, or refused with a message; the sanitizer
 * builds check the memory. */
static void mutated_text_is_accepted_or_refused_never_worse(void **state) {
    (void)state;
    static const char spice[] = "[]{}:,-&*!#|>'\"%@`\t\n\r ?\\.0e\xff\xc3\xa9\x00\x7f";
    size_t size;
    char *text = read_file(shipped, &size), *copy = malloc(2 * size);
    uint64_t seed = 7;
    int accepted = 0, refused = 0;
    for (int round = 0; round < random_cases(3000); round++) {
        size_t length = size;
        memcpy(copy, text, size);
        for (uint64_t n = 1 + random_next(&seed) % 4; n > 0; n--) {
            size_t at = random_next(&seed) % length, other = random_next(&seed) % length, span = random_next(&seed) % 40;
            switch (random_next(&seed) % 4) {
            case 0: copy[at] = spice[random_next(&seed) % (sizeof spice - 1)]; break;
            case 1: copy[at] = (char)random_next(&seed); break;
            case 2: length = at + 1; break;
            default: memmove(copy + at, copy + other, span < length - (at > other ? at : other) ? span : 0); break;
            }
        }
        struct params p;
        struct error error = {0};
        int status = config_parse(&p, copy, length, "rig.yaml", &error);
        if (status == STATUS_OK) {
            struct config_key key;
            for (int i = 0; config_key_at(i, &key); i++) {
                double value = key.kind == CONFIG_REAL ? *(const double *)((const char *)&p + key.offset) : key.min;
                assert_true(value >= key.min && value <= key.max);
            }
            accepted++;
        } else {
            assert_int_equal(status, STATUS_USAGE);
            assert_int_equal(strncmp(error.text, "rig.yaml", 8), 0);
            refused++;
        }
    }
    assert_true(accepted > 100 && refused > 100); /* both outcomes occurred */
    free(text);
    free(copy);
}

/* Checks the list of values that a configuration takes from the built-in machine: `begins` is its
 * beginning ("": the list is empty), and `lacks` is a word that it does not contain. */
static void assert_defaults(const char *file, const char *setting, const char *begins, const char *lacks) {
    struct params p;
    struct error error;
    char text[CONFIG_DEFAULTS_SIZE];
    if (config_load(&p, file, &setting, setting != NULL, &error)) fail_msg("%s", error.text);
    config_defaults(&p, text);
    if (strncmp(text, begins, strlen(begins)) || (!*begins && *text)) fail_msg("\"%s\" does not begin with \"%s\"", text, begins);
    if (lacks && strstr(text, lacks)) fail_msg("\"%s\" has %s", text, lacks);
}

static void what_another_machine_took_from_the_default_is_said(void **state) {
    (void)state;
    assert_defaults(NULL, NULL, "", NULL);
    assert_defaults(NULL, "payload.mass_kg=300", "", NULL); /* another payload does not make another
                                                             * machine */
    assert_defaults(NULL, "geometry.lower_joint_axes=[[1,0,0],[1,0,0],[1,0,0],[1,0,0],[1,0,0],[1,0,0]]", "", NULL);
    assert_defaults(NULL, "geometry.upper_radius_m=0.58", "actuator.piston_diameter_m 0.063, actuator.rod_diameter_m 0.045, hydraulics.",
                    NULL);
    assert_defaults("config/desktop.yaml", NULL, "hydraulics.valve_drop_pa 5e6, hydraulics.valve_damping 0.8", "supply");
    assert_defaults("config/axis.yaml", NULL, "hydraulics.supply_pa 10e6, hydraulics.valve_flow_m3_per_s 1.57e-3", "diameter");
    assert_defaults("config/axis.yaml", "hydraulics.supply_pa=14e6", "hydraulics.valve_flow", "supply");
}

static void the_listing_has_every_key_once(void **state) {
    (void)state;
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    config_print_keys(out);
    fclose(out);
    struct config_key key;
    for (int i = 0; config_key_at(i, &key); i++) {
        char start[CONFIG_PATH_SIZE + 8];
        snprintf(start, sizeof start, "\n| `%s` |", key.path);
        char *found = strstr(text, start);
        if (!found || strstr(found + 1, start)) fail_msg("%s", key.path);
    }
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(default_is_the_shipped_file),
        cmocka_unit_test(shipped_file_names_every_key),
        cmocka_unit_test(geometry_and_inertia_are_the_papers_tables),
        cmocka_unit_test(keys_that_scripts_rely_on_exist),
        cmocka_unit_test(a_key_takes_its_bounds_and_nothing_beyond),
        cmocka_unit_test(numbers_are_read_in_any_decimal_notation),
        cmocka_unit_test(text_turns_back_into_the_same_bits),
        cmocka_unit_test(settings_override_the_file_and_the_last_one_wins),
        cmocka_unit_test(an_axis_has_a_frequency_and_an_amplitude_of_its_own),
        cmocka_unit_test(diameters_of_an_axis_are_its_own_or_none),
        cmocka_unit_test(an_effect_is_off_until_one_of_its_keys_is_set),
        cmocka_unit_test(a_list_gives_each_leg_its_value_where_the_effect_allows_it),
        cmocka_unit_test(joints_are_six_points_on_the_command_line_and_in_a_file),
        cmocka_unit_test(axes_of_joints_are_six_directions),
        cmocka_unit_test(a_leg_has_an_actuator_of_its_own),
        cmocka_unit_test(a_mistake_is_reported_with_file_line_and_key),
        cmocka_unit_test(a_wrong_setting_is_reported_with_its_text),
        cmocka_unit_test(a_file_that_cannot_be_read_is_named),
        cmocka_unit_test(keys_that_contradict_each_other_are_named),
        cmocka_unit_test(lists_of_joints_in_different_orders_are_named),
        cmocka_unit_test(all_that_contradicts_is_said_at_once),
        cmocka_unit_test(tests_of_another_text_replace_those_that_it_states),
        cmocka_unit_test(a_text_can_leave_keys_and_sections_out),
        cmocka_unit_test(as_many_harmonics_as_the_regression_has_are_accepted),
        cmocka_unit_test(big_and_deep_text_is_refused),
        cmocka_unit_test(mutated_text_is_accepted_or_refused_never_worse),
        cmocka_unit_test(what_another_machine_took_from_the_default_is_said),
        cmocka_unit_test(the_listing_has_every_key_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
