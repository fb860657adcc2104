/* The catalogue of effects: claims about every entry, and about each law. */
#include "support.h"

#include <dirent.h>

#include "cylinder.h"
#include "effect.h"
#include "plant.h"
#include "rigid.h"
#include "valve_line.h"

static int key_count(const struct effect *e) {
    int count = 0;
    while (count < EFFECT_KEYS && e->keys[count].name) count++;
    return count;
}

static struct params with(const char *name, const double *values) {
    struct params params;
    config_default(&params);
    int place = effect_find(name);
    assert_true(place >= 0);
    params.effects[place].on = true;
    for (int k = 0; k < key_count(effect_table[place]); k++)
        for (int leg = 0; leg < LEGS; leg++) params.effects[place].value[k][leg] = values[k];
    return params;
}

static struct leg_motion some_motion(uint64_t *seed) {
    double rate = random_unit(seed);
    return (struct leg_motion){.direction = rate < 0.0 ? -1 : 1,
                               .speed_mps = fabs(rate),
                               .p1_pa = 1e7 * fabs(random_unit(seed)),
                               .p2_pa = 1e7 * fabs(random_unit(seed)),
                               .deflection = random_unit(seed)};
}

static void every_effect_says_what_it_is(void **unused) {
    (void)unused;
    for (int i = 0; effect_table[i]; i++) {
        const struct effect *e = effect_table[i];
        assert_true(i < EFFECTS_MAX);
        assert_int_equal(effect_find(e->name), i); /* finding each by its name shows that names are
                                                    * unique */
        assert_true(strlen(e->plain) > 0 && strlen(e->law) > 0 && strlen(e->signature) > 0);
        assert_true(key_count(e) > 0);
        for (int k = 0; k < key_count(e); k++) {
            assert_non_null(e->keys[k].unit);
            assert_true(e->keys[k].min <= e->keys[k].neutral && e->keys[k].neutral <= e->keys[k].max);
        }
    }
    assert_int_equal(effect_find("cylinder_coulomb"), -1);
    assert_int_equal(effect_find(""), -1);
}

static void every_effect_file_is_in_the_table(void **unused) {
    (void)unused;
    DIR *folder = opendir("sim/effects");
    if (!folder) skip_because("not run from the root of the sources");
    for (struct dirent *file; (file = readdir(folder));) {
        char name[256] = "";
        size_t length = strlen(file->d_name);
        if (length < 2 || strcmp(file->d_name + length - 2, ".c") != 0 || strcmp(file->d_name, "effects.c") == 0) continue;
        memcpy(name, file->d_name, length - 2);
        if (effect_find(name) < 0) fail_msg("sim/effects/%s.c defines no effect of that name in the table", name);
    }
    closedir(folder);
}

static void neutral_values_add_nothing(void **unused) {
    (void)unused;
    uint64_t seed = 1;
    for (int i = 0; effect_table[i]; i++) {
        const struct effect *e = effect_table[i];
        struct effect_values v = {.on = true};
        for (int k = 0; k < key_count(e); k++)
            for (int leg = 0; leg < LEGS; leg++) v.value[k][leg] = e->keys[k].neutral;
        for (int n = 0; n < 100; n++) {
            struct friction add = {0};
            struct leg_motion motion = some_motion(&seed);
            if (e->leg_friction) e->leg_friction(&v, n % LEGS, &motion, &add);
            if (e->joint_friction) e->joint_friction(&v, n % LEGS, motion.speed_mps, &add);
            assert_true(add.dry == 0.0 && add.viscous == 0.0 && add.elastic == 0.0);
        }
    }
}

/* Groups of the machine's constants; each consists of numbers only. */
#define GROUP(member) {#member, offsetof(struct machine, member), sizeof ((struct machine *)0)->member}
static const struct {
    const char *name;
    size_t place, size;
} groups[] = {GROUP(bodies), GROUP(supply), GROUP(oil), GROUP(valve), GROUP(seals), GROUP(hose), GROUP(sensors), GROUP(timing)};

static const double *numbers(const struct machine *m, size_t place) { return (const double *)(const void *)((const char *)m + place); }

static void the_machine_is_its_constants_and_its_laws(void **unused) {
    (void)unused;
    const struct machine *m = NULL;
    size_t size = sizeof m->params + sizeof m->leg_friction + sizeof m->joint_friction + sizeof m->wrench + sizeof m->opening +
                  sizeof m->command;
    for (size_t g = 0; g < sizeof groups / sizeof *groups; g++) size += groups[g].size;
    assert_int_equal(size, sizeof *m); /* the sum of all members: no group is missing above */
}

/* Compares all constants, the laws at a pose and a spool position, and the valves' input. */
static void neutral_values_leave_the_machine_as_it_is(void **unused) {
    (void)unused;
    static const double pose[DOFS] = {0.01, -0.02, 0.03, 0.04, -0.05, 0.06}, valve[LEGS] = {0.1, -0.2, 0.3, -0.4, 0.5, -0.6};
    struct params params;
    struct machine base, machine;
    config_default(&params);
    machine_init(&base, &params);
    for (int i = 0; effect_table[i]; i++) {
        struct params with = params;
        struct valve_line line;
        double wrench[DOFS] = {0}, received[LEGS];
        effect_at(effect_table[i], 0.0, &with.effects[i]);
        machine_init(&machine, &with);
        machine_wrench(&machine, pose, wrench);
        for (int k = 0; k < DOFS; k++) assert_true(wrench[k] == 0.0 && machine_opening(&machine, k, valve[k]) == valve[k]);
        valve_line_init(&line, &machine);
        valve_line_rest(&line);
        valve_line_send(&line, valve);
        valve_line_receive(&line, 0, received);
        assert_memory_equal(received, valve, sizeof valve);
        /* the diameter of a hose has no meaning without its length */
        memcpy(machine.hose.diameter_m, base.hose.diameter_m, sizeof base.hose.diameter_m);
        for (size_t g = 0; g < sizeof groups / sizeof *groups; g++) {
            const double *is = numbers(&machine, groups[g].place), *was = numbers(&base, groups[g].place);
            for (size_t c = 0; c < groups[g].size / sizeof *is; c++)
                if (!(is[c] == was[c]))
                    fail_msg("%s: %s, number %zu is %g instead of %g", effect_table[i]->name, groups[g].name, c, is[c], was[c]);
        }
    }
}

/* Returns the readings after 0.3 s of moving valves. */
static struct hal_sample moved(const struct params *params, enum engine_kind engine) {
    static const double neutral[DOFS] = {0};
    struct params p = *params;
    struct hal_sample sample = {0};
    struct error error;
    p.sim.engine = engine;
    p.sim.substeps = 32;
    p.sensors.enabled = false;
    struct plant *plant = plant_create(&p, 1, &error);
    if (!plant) fail_msg("%s", error.text);
    plant_place(plant, neutral);
    for (int i = 0; i < 150; i++) {
        double valve[LEGS];
        for (int k = 0; k < LEGS; k++) valve[k] = 0.02 * sin(0.05 * i + k);
        plant_step(plant, valve);
    }
    plant_measure(plant, &sample);
    plant_destroy(plant);
    return sample;
}

/* Computes the largest differences of lengths and pressures. */
static void differences(const struct hal_sample *a, const struct hal_sample *b, double *length_m, double *pressure_pa) {
    *length_m = *pressure_pa = 0.0;
    for (int k = 0; k < LEGS; k++) {
        *length_m = fmax(*length_m, fabs(a->length_m[k] - b->length_m[k]));
        *pressure_pa = fmax(*pressure_pa, fmax(fabs(a->p1_pa[k] - b->p1_pa[k]), fabs(a->p2_pa[k] - b->p2_pa[k])));
    }
}

static void both_engines_have_every_effect(void **unused) {
    (void)unused;
    slow_case();
    struct params params;
    config_default(&params);
    struct hal_sample base = moved(&params, ENGINE_CLOSED_FORM);
    for (int i = 0; effect_table[i]; i++) {
        struct params with = params;
        double length_m, pressure_pa, own_m, own_pa;
        effect_at(effect_table[i], 1.0, &with.effects[i]);
        struct hal_sample closed = moved(&with, ENGINE_CLOSED_FORM), ode = moved(&with, ENGINE_ODE);
        differences(&closed, &ode, &length_m, &pressure_pa);
        differences(&closed, &base, &own_m, &own_pa);
        /* tolerance: the engines differ by this much at 0.0625 ms, because they detect stiction in
         * the joints a substep apart */
        assert_below(length_m, 1e-7);
        assert_below(pressure_pa, 100.0);
        bool seen = own_m > 10.0 * length_m || own_pa > 10.0 * pressure_pa;
        /* these effects act on time stamps alone, or on sensors that the plant lacks */
        assert_true(seen || !strcmp(effect_table[i]->name, "clock_skew") || !strncmp(effect_table[i]->name, "force_sensor", 12));
    }
}

static void friction_resists_and_its_viscous_part_vanishes_at_rest(void **unused) {
    (void)unused;
    uint64_t seed = 2;
    for (int i = 0; effect_table[i]; i++) {
        const struct effect *e = effect_table[i];
        for (int n = 0; n < 1000; n++) {
            struct effect_values v = {.on = true};
            struct friction moving = {0}, resting = {0};
            struct leg_motion motion = some_motion(&seed), rest = motion;
            int leg = n % LEGS;
            rest.speed_mps = 0.0;
            for (int k = 0; k < key_count(e); k++)
                v.value[k][leg] = fmax(e->keys[k].min, 0.0) + (e->keys[k].max - fmax(e->keys[k].min, 0.0)) * fabs(random_unit(&seed));
            if (e->leg_friction) e->leg_friction(&v, leg, &motion, &moving), e->leg_friction(&v, leg, &rest, &resting);
            if (e->joint_friction) e->joint_friction(&v, leg, motion.speed_mps, &moving), e->joint_friction(&v, leg, 0.0, &resting);
            assert_true(moving.dry >= 0.0 && moving.viscous >= 0.0 && resting.dry >= 0.0);
            assert_true(resting.viscous == 0.0 && moving.elastic * motion.deflection >= 0.0);
        }
    }
}

/* The law as it is written, for a turn above and below 0, and at 0, where it is a parabola. */
static void a_lever_bends_as_its_law_says(void **unused) {
    (void)unused;
    const struct effect *lever = effect_table[effect_find("lever_load")];
    static const double turns[] = {4.0, 0.0, -4.0};
    double slope = 300.0, bend = -200.0, x = 0.7, w = 2.0;
    const double needed[] = {slope * sin(w * x) / w + bend * (1.0 - cos(w * x)) / (w * w), slope * x + 0.5 * bend * x * x,
                             slope * sinh(w * x) / w + bend * (cosh(w * x) - 1.0) / (w * w)};
    for (int i = 0; i < 3; i++) {
        struct effect_values v = {.on = true, .value = {{slope}, {bend}, {turns[i]}}};
        double wrench[DOFS] = {0};
        lever->wrench(&v, (const double[DOFS]){x}, wrench);
        assert_close(wrench[DOF_X], -needed[i], 1e-9);
    }
}

static void coulomb_friction_knows_its_direction_and_no_speed(void **unused) {
    (void)unused;
    struct params params = with("cylinder_coulomb_friction", (const double[]){300.0, 100.0});
    struct cylinder_model m;
    struct cylinder_state s = {0};
    params.hydraulics.viscous_n_s_per_m[0] = 0.0;
    cylinder_model_init(&m, &params);
    for (double speed = 0.0; speed < 1.0; speed += 0.3) {
        assert_true(cylinder_friction(&m, 0, &s, 1, speed).dry == 300.0 && cylinder_friction(&m, 0, &s, -1, speed).dry == 100.0);
        assert_true(cylinder_friction(&m, 0, &s, 1, speed).viscous == 0.0);
    }
}

static void viscous_friction_adds_to_the_base_by_direction(void **unused) {
    (void)unused;
    struct params params = with("cylinder_viscous_friction", (const double[]){500.0, 1500.0});
    struct cylinder_model m;
    struct cylinder_state s = {0};
    cylinder_model_init(&m, &params);
    double base = params.hydraulics.viscous_n_s_per_m[3];
    assert_close(cylinder_friction(&m, 3, &s, 1, 0.2).viscous, (base + 500.0) * 0.2, 1e-12);
    assert_close(cylinder_friction(&m, 3, &s, -1, 0.2).viscous, (base + 1500.0) * 0.2, 1e-12);
}

static void viscous_friction_is_taken_off_but_never_below_nothing(void **unused) {
    (void)unused;
    struct params base;
    struct error error;
    config_default(&base);
    double most = base.hydraulics.viscous_n_s_per_m[0];
    static const struct {
        double extend, retract; /* changes relative to the configuration's values */
        int status;
    } cases[] = {{-1.0, -1.0, 0}, {-0.5, 0.0, 0}, {-1.001, 0.0, STATUS_USAGE}, {1.0, -1.001, STATUS_USAGE}};
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct params params = with("cylinder_viscous_friction", (const double[]){cases[i].extend * most, cases[i].retract * most});
        struct machine m;
        machine_init(&m, &params);
        assert_int_equal(machine_check(&m, &error), cases[i].status);
    }
    assert_non_null(strstr(error.text, "viscous friction of leg 1"));
}

static void joint_friction_has_both_parts(void **unused) {
    (void)unused;
    struct params params = with("passive_joint_friction", (const double[]){5.0, 20.0});
    struct machine m;
    machine_init(&m, &params);
    struct friction f = machine_joint_friction(&m, 2, 0.1);
    assert_close(f.dry, 5.0, 1e-15);
    assert_close(f.viscous, 2.0, 1e-15);
}

/* Computes the mass matrix and the load of the rigid model at one pose and motion. */
static void bodies(const struct params *params, double mass[DOFS][DOFS], double load[DOFS]) {
    struct rigid_model m;
    struct rigid_state s;
    struct rigid_legs legs;
    rigid_model_init(&m, params);
    rigid_rest(&s, (const double[DOFS]){0.02, -0.03, 0.05, 0.06, -0.04, 0.1});
    memcpy(s.twist, (const double[DOFS]){0.3, -0.2, 0.4, 0.5, -0.6, 0.7}, sizeof s.twist);
    rigid_legs(&m, &s, &legs);
    rigid_dynamics(&m, &s, &legs, mass, load);
}

static void heavier_actuators_move_and_weigh_as_the_configurations_would(void **unused) {
    (void)unused;
    struct params effect = with("actuator_inertia", (const double[]){4.0, 13.0, 1.5}), heavier;
    double mass[2][DOFS][DOFS], load[2][DOFS];
    config_default(&heavier);
    struct actuator_params *a = &heavier.actuator;
    for (int k = 0; k < LEGS; k++) a->upper_mass_kg[k] += 4.0, a->lower_mass_kg[k] += 13.0, a->lower_inertia_kg_m2[k] += 1.5;
    bodies(&effect, mass[0], load[0]);
    bodies(&heavier, mass[1], load[1]);
    for (int i = 0; i < DOFS; i++) {
        assert_close(load[0][i], load[1][i], 1e-9);
        for (int j = 0; j <= i; j++) assert_close(mass[0][i][j], mass[1][i][j], 1e-9);
    }
}

static void a_length_sensor_is_right_at_its_zero(void **unused) {
    (void)unused;
    struct params params = with("position_sensor_scale", (const double[]){1.05, 0.2});
    struct machine m;
    machine_init(&m, &params);
    for (int k = 0; k < LEGS; k++) {
        double zero_m = m.bodies.neutral_length_m[k] + 0.2, scale = m.sensors.length[k].scale, offset = m.sensors.length[k].offset;
        assert_close(scale * zero_m + offset, zero_m, 1e-12);
        assert_close(scale * (zero_m + 0.1) + offset, zero_m + 0.105, 1e-12);
    }
}

/* Air softens oil. But the configured modulus may itself be too low, so the effective modulus may
 * be above it. */
static void oil_has_the_effective_modulus_above_the_configured_one_too(void **unused) {
    (void)unused;
    static const double modulus_pa[] = {6e8, 1.1e9};
    for (int n = 0; n < 2; n++) {
        struct params params = with("entrained_air", &modulus_pa[n]);
        struct machine m;
        machine_init(&m, &params);
        assert_close(m.oil.bulk_modulus_pa[3], modulus_pa[n], 1.0);
    }
}

static void legs_differ_where_the_configuration_says_so(void **unused) {
    (void)unused;
    struct params params;
    struct cylinder_model m;
    struct cylinder_state s = {.p1_pa = 5e6, .p2_pa = 5e6, .spool = 0.5};
    config_default(&params);
    params.hydraulics.viscous_n_s_per_m[4] = 2500.0;
    params.hydraulics.valve_flow_m3_per_s[4] *= 2.0;
    params.hydraulics.bulk_modulus_pa[5] *= 0.5;
    params.hydraulics.dead_volume_m3[2] *= 3.0;
    params.hydraulics.leakage_m3_per_s_pa[1] = 0.0;
    cylinder_model_init(&m, &params);
    struct mains mains = cylinder_mains(&m);
    double length_m = m.machine.bodies.neutral_length_m[0], rate[LEGS], leaking[LEGS];
    for (int k = 0; k < LEGS; k++) rate[k] = cylinder_derivative(&m, k, &mains, &s, s.spool, length_m, 0.0, 0.5).p1_pa;
    s = (struct cylinder_state){.p1_pa = 6e6, .p2_pa = 4e6};
    for (int k = 0; k < LEGS; k++) leaking[k] = cylinder_derivative(&m, k, &mains, &s, 0.0, length_m, 0.0, 0.0).p1_pa;
    assert_close(cylinder_friction(&m, 4, &s, 1, 0.1).viscous, 250.0, 1e-9);
    assert_close(cylinder_friction(&m, 3, &s, 1, 0.1).viscous, 200.0, 1e-9);
    assert_close(rate[4] / rate[0], 2.0, 1e-9);
    assert_close(rate[5] / rate[0], 0.5, 1e-9);
    assert_true(rate[2] < 0.95 * rate[0] && rate[3] == rate[0] && rate[1] == rate[0]);
    assert_true(leaking[1] == 0.0 && leaking[0] < 0.0);
}

static void an_effect_that_is_off_does_nothing(void **unused) {
    (void)unused;
    struct params params = with("cylinder_coulomb_friction", (const double[]){300.0, 100.0});
    struct cylinder_model m;
    struct cylinder_state s = {0};
    params.effects[effect_find("cylinder_coulomb_friction")].on = false;
    cylinder_model_init(&m, &params);
    assert_true(cylinder_friction(&m, 0, &s, 1, 0.1).dry == 0.0);
    assert_false(cylinder_can_stick(&m));
}

static void one_leg_alone_can_have_friction(void **unused) {
    (void)unused;
    struct params params = with("cylinder_coulomb_friction", (const double[]){0.0, 0.0});
    struct cylinder_model m;
    struct cylinder_state s = {0};
    cylinder_model_init(&m, &params);
    assert_false(cylinder_can_stick(&m)); /* the effect is on, but its force is 0 */
    params.effects[effect_find("cylinder_coulomb_friction")].value[1][4] = 80.0;
    for (int leg = 0; leg < LEGS; leg++) assert_true(cylinder_friction(&m, leg, &s, -1, 0.1).dry == (leg == 4 ? 80.0 : 0.0));
    assert_true(cylinder_can_stick(&m));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_effect_says_what_it_is),
        cmocka_unit_test(every_effect_file_is_in_the_table),
        cmocka_unit_test(neutral_values_add_nothing),
        cmocka_unit_test(oil_has_the_effective_modulus_above_the_configured_one_too),
        cmocka_unit_test(the_machine_is_its_constants_and_its_laws),
        cmocka_unit_test(neutral_values_leave_the_machine_as_it_is),
        cmocka_unit_test(both_engines_have_every_effect),
        cmocka_unit_test(friction_resists_and_its_viscous_part_vanishes_at_rest),
        cmocka_unit_test(a_lever_bends_as_its_law_says),
        cmocka_unit_test(coulomb_friction_knows_its_direction_and_no_speed),
        cmocka_unit_test(viscous_friction_adds_to_the_base_by_direction),
        cmocka_unit_test(viscous_friction_is_taken_off_but_never_below_nothing),
        cmocka_unit_test(joint_friction_has_both_parts),
        cmocka_unit_test(heavier_actuators_move_and_weigh_as_the_configurations_would),
        cmocka_unit_test(a_length_sensor_is_right_at_its_zero),
        cmocka_unit_test(legs_differ_where_the_configuration_says_so),
        cmocka_unit_test(an_effect_that_is_off_does_nothing),
        cmocka_unit_test(one_leg_alone_can_have_friction),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
