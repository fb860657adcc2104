#include "machine_found.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "agreement.h"
#include "kinematics.h"
#include "loop_found.h"
#include "loop_places.h"
#include "numeric.h"
#include "units.h"
#include "valve_flow.h"

static const double UNIFORM = 0.57735026918962576; /* standard deviation of a uniform error, as a
                                                    * share of its largest value, 1 / sqrt(3) */
static const double DELAY_MOST_S = 0.1;            /* largest control.delay_s */

struct found_value found_mean(struct found_value x, double nominal, double tolerance_std) {
    double t = square(tolerance_std), s = square(x.std), weight = isinf(t) ? 1.0 : t + s > 0.0 ? t / (t + s) : 0.0;
    return (struct found_value){nominal + weight * (x.value - nominal), sqrt(weight) * x.std};
}

static bool determined(struct found_value x) { return isfinite(x.value) && isfinite(x.std); }

/* True if the values are so far from the configured ones that the configuration is that of another
 * machine (machine_found.h). */
static bool contradicted(int count, const struct found_value x[], const double nominal[], const double tolerance_std[]) {
    double sum = 0.0;
    int degrees = 0;
    for (int i = 0; i < count; i++) {
        if (!determined(x[i])) continue;
        sum += square(x[i].value - nominal[i]) / (square(x[i].std) + square(tolerance_std[i]));
        degrees++;
    }
    return degrees > 0 && agreement_chi_square_above(sum, degrees) < FOUND_CONTRADICTED;
}

/* Replaces each measured value by the mean of measured and configured value, by found_mean(). A
 * value that is not determined becomes the configured value, with std NaN. */
static void weigh(int count, struct found_value x[], const double nominal[], const double tolerance_std[]) {
    bool other = contradicted(count, x, nominal, tolerance_std);
    for (int i = 0; i < count; i++) {
        if (determined(x[i])) x[i] = found_mean(x[i], nominal[i], other ? (double)INFINITY : tolerance_std[i]);
        else x[i] = (struct found_value){nominal[i], (double)NAN};
    }
}

__attribute__((format(printf, 3, 4))) static void note(struct machine_found *f, const char *key, const char *format, ...) {
    va_list args;
    if (f->notes == FOUND_NOTES) return;
    struct config_note *n = &f->note[f->notes++];
    snprintf(n->key, sizeof n->key, "%s", key);
    va_start(args, format);
    vsnprintf(n->text, sizeof n->text, format, args);
    va_end(args);
}

__attribute__((format(printf, 2, 3))) static void keep(struct machine_found *f, const char *format, ...) {
    va_list args;
    if (f->kept == FOUND_KEPT) return;
    va_start(args, format);
    vsnprintf(f->kept_why[f->kept++], FOUND_KEPT_SIZE, format, args);
    va_end(args);
}

/* Notes the widest interval of the values of one key. Values that stay as configured have none. */
static void note_values(struct machine_found *f, const char *key, int count, const struct found_value x[], const double was[]) {
    double widest = 0.0;
    bool alike = true;
    for (int i = 0; i < count; i++) {
        if (isfinite(x[i].std)) widest = fmax(widest, x[i].std);
        alike = alike && was[i] == was[0];
    }
    if (!(widest > 0.0)) return;
    if (alike) note(f, key, "+- %.2g%s (95 %%); was %.6g", NUMERIC_95 * widest, count > 1 ? " at most" : "", was[0]);
    else note(f, key, "+- %.2g at most (95 %%)", NUMERIC_95 * widest);
}

/* Rounds a value to the second significant digit of its standard deviation. */
static double rounded(struct found_value x) {
    if (!(x.std > 0.0 && isfinite(x.std))) return x.value;
    double power = 1.0 - floor(log10(x.std)), unit = pow(10.0, fabs(power));
    return power > 0.0 ? round(x.value * unit) / unit : round(x.value / unit) * unit;
}

/* ---- payload ---- */

static const char *const payload_keys[PAYLOAD_VALUES] = {"payload.mass_kg",          "payload.center_x_m",       "payload.center_y_m",
                                                         "payload.center_height_m",  "payload.inertia_xx_kg_m2", "payload.inertia_yy_kg_m2",
                                                         "payload.inertia_zz_kg_m2", "payload.inertia_xy_kg_m2", "payload.inertia_xz_kg_m2",
                                                         "payload.inertia_yz_kg_m2"};

/* The configured values as payload.h counts them, and the standard deviations of their tolerance.
 * The tolerance is a share of the mass. If this part of the mass is elsewhere in the body, it moves
 * the centre by this share of the radius of gyration, and changes products of inertia by this share
 * of sqrt(I_ii I_jj). */
static void configured_payload(const struct params *p, double nominal[PAYLOAD_VALUES], double std[PAYLOAD_VALUES]) {
    const struct payload_params *load = &p->payload;
    double share = UNIFORM * p->model.tolerance.mass, xx = load->inertia_xx_kg_m2, yy = load->inertia_yy_kg_m2, zz = load->inertia_zz_kg_m2;
    double radius_m = sqrt((xx + yy + zz) / (3.0 * load->mass_kg));
    const double values[PAYLOAD_VALUES] = {load->mass_kg,         0.0, 0.0, 0.0, xx, yy, zz, load->inertia_xy_kg_m2, load->inertia_xz_kg_m2,
                                           load->inertia_yz_kg_m2};
    const double sizes[PAYLOAD_VALUES] = {load->mass_kg, radius_m,      radius_m,     radius_m, xx, yy, zz,
                                          sqrt(xx * yy), sqrt(xx * zz), sqrt(yy * zz)};
    for (int i = 0; i < PAYLOAD_VALUES; i++) nominal[i] = values[i], std[i] = share * sizes[i];
}

static void note_payload(struct machine_found *f, const struct params *configured, const struct found_value x[PAYLOAD_VALUES]) {
    const struct payload_params *p = &configured->payload;
    const double was[PAYLOAD_VALUES] = {p->mass_kg,          p->center_x_m,       p->center_y_m,       p->center_height_m,
                                        p->inertia_xx_kg_m2, p->inertia_yy_kg_m2, p->inertia_zz_kg_m2, p->inertia_xy_kg_m2,
                                        p->inertia_xz_kg_m2, p->inertia_yz_kg_m2};
    for (int i = 0; i < PAYLOAD_VALUES; i++) note_values(f, payload_keys[i], 1, &x[i], &was[i]);
}

/* True if an effect of the configuration changes the payload. If `off`, switches these effects off,
 * because method C's payload already contains them. */
static bool payload_effects(struct params *p, bool off) {
    static const char *const names[] = {"payload_mass", "payload_center_of_mass", "payload_rotational_inertia"};
    bool any = false;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        struct effect_values *e = &p->effects[effect_find(names[i])];
        any = any || e->on;
        if (off) e->on = false;
    }
    return any;
}

static void take_payload(struct machine_found *f, const struct params *configured, const struct payload *payload) {
    double nominal[PAYLOAD_VALUES], std[PAYLOAD_VALUES], value[PAYLOAD_VALUES];
    struct found_value x[PAYLOAD_VALUES];
    if (!payload->evaluated) {
        keep(f, "the payload: its mass is not determined to a tenth");
        return;
    }
    bool twice = payload_effects(&f->params, false);
    if (twice && !payload->whole) {
        keep(f, "the payload: effects change it in the configuration, and their sum is not wholly determined");
        return;
    }
    configured_payload(configured, nominal, std);
    /* Method C found the sum of the configured payload and these effects, so the configured values
     * alone get no weight. */
    for (int i = 0; i < PAYLOAD_VALUES && twice; i++) std[i] = (double)INFINITY;
    for (int i = 0; i < PAYLOAD_VALUES; i++)
        x[i] = (struct found_value){payload->whole ? payload->nearest[i] : payload->value[i], payload->std[i]};
    weigh(PAYLOAD_VALUES, x, nominal, std);
    for (int i = 0; i < PAYLOAD_VALUES; i++) value[i] = rounded(x[i]);
    if (!payload_possible(value) && payload->whole)
        for (int i = 0; i < PAYLOAD_VALUES; i++) value[i] = payload->nearest[i], x[i].std = payload->std[i];
    if (!payload_possible(value)) {
        keep(f, "the payload: what is determined of it and the configured rest are no body");
        return;
    }
    if (!payload->whole) keep(f, "values of the payload without an interval: they are not determined");
    payload_configure(value, &f->params.payload);
    payload_effects(&f->params, true);
    note_payload(f, configured, x);
}

/* ---- friction ---- */

/* True if the configuration has an effect of friction along the legs besides viscous and dry
 * friction, whose values method C replaces. name: set to the name of the first such effect. */
static bool other_friction(const struct params *p, int viscous, int dry, const char **name) {
    for (int i = 0; effect_table[i]; i++) {
        if (!p->effects[i].on || !effect_table[i]->leg_friction || i == viscous || i == dry) continue;
        *name = effect_table[i]->name;
        return true;
    }
    return false;
}

static void take_viscous(struct machine_found *f, const struct params *configured, const struct method_c *c, int effect) {
    double was[LEGS], std[LEGS];
    struct found_value x[LEGS];
    for (int leg = 0; leg < LEGS; leg++) {
        was[leg] = configured->hydraulics.viscous_n_s_per_m[leg];
        if (configured->effects[effect].on) was[leg] += configured->effects[effect].value[0][leg];
        std[leg] = UNIFORM * configured->model.tolerance.viscous * was[leg];
        x[leg] = (struct found_value){c->viscous[leg], c->viscous_std[leg]};
    }
    weigh(LEGS, x, was, std);
    for (int leg = 0; leg < LEGS; leg++) f->params.hydraulics.viscous_n_s_per_m[leg] = fmax(rounded(x[leg]), 0.0);
    f->params.effects[effect].on = false; /* the value found includes this effect's part */
    note_values(f, "hydraulics.viscous_n_s_per_m", LEGS, x, was);
}

/* The mean dry friction of both directions. */
static struct found_value dry_of(const struct estimate *e, int leg) {
    int extend = UNKNOWN_DRY + 2 * leg, retract = extend + 1;
    double variance = estimate_covariance(e, extend, extend) + estimate_covariance(e, retract, retract) +
                      2.0 * estimate_covariance(e, extend, retract);
    return (struct found_value){0.5 * (e->value[extend] + e->value[retract]), 0.5 * sqrt(fmax(variance, 0.0))};
}

static bool dry_determined(const struct method_c *c, int leg) { return isfinite(c->dry_std[leg][0]) && isfinite(c->dry_std[leg][1]); }

static void take_dry(struct machine_found *f, const struct params *configured, const struct method_c *c, const struct estimate *e,
                     int effect) {
    struct effect_values *to = &f->params.effects[effect];
    const struct effect_values *from = &configured->effects[effect];
    struct found_value x[LEGS];
    double sum = 0.0, was[LEGS], most = 0.0;
    int legs = 0;
    for (int leg = 0; leg < LEGS; leg++) {
        x[leg] = dry_determined(c, leg) ? dry_of(e, leg) : (struct found_value){(double)NAN, (double)NAN};
        was[leg] = from->on ? 0.5 * (from->value[0][leg] + from->value[1][leg]) : 0.0;
        if (determined(x[leg])) sum += square(x[leg].value) - square(x[leg].std), legs++;
    }
    if (legs < LEGS) keep(f, "dry friction of %d leg(s): it is not determined", LEGS - legs);
    for (int leg = 0; leg < LEGS; leg++) {
        if (determined(x[leg])) {
            x[leg] = found_mean(x[leg], 0.0, sqrt(fmax(sum / legs, 0.0)));
            to->value[0][leg] = to->value[1][leg] = fmax(rounded(x[leg]), 0.0);
        } else {
            for (int way = 0; way < 2; way++) to->value[way][leg] = from->on ? from->value[way][leg] : 0.0;
        }
        most = fmax(most, fmax(to->value[0][leg], to->value[1][leg]));
    }
    to->on = most > 0.0;
    note_values(f, "effects.cylinder_coulomb_friction.force_extend_n", LEGS, x, was);
    note_values(f, "effects.cylinder_coulomb_friction.force_retract_n", LEGS, x, was);
}

void machine_found(const struct params *configured, const struct method_c *c, const struct estimate *estimate,
                   struct machine_found *found) {
    int viscous = effect_find("cylinder_viscous_friction"), dry = effect_find("cylinder_coulomb_friction");
    const char *other;
    memset(found, 0, sizeof *found);
    found->params = *configured;
    take_payload(found, configured, &c->payload);
    if (other_friction(configured, viscous, dry, &other)) {
        keep(found, "friction: the configuration has %s, and method C's constants hold its part, too", other);
        return;
    }
    take_viscous(found, configured, c, viscous);
    take_dry(found, configured, c, estimate, dry);
}

/* ---- oil, valves, leakage and delay ---- */

bool machine_found_is_survey(const struct params *p) {
    return !strcmp(p->tests.trajectory, "survey") && p->tests.repeat == MULTISINE_PASSES;
}

/* Takes a parameter of each leg. by: factor from the configured value to the value that a survey
 * found. */
static void take_factors(struct machine_found *f, const char *key, double value[LEGS], double tolerance,
                         const struct found_value by[LEGS]) {
    double was[LEGS], std[LEGS];
    struct found_value x[LEGS];
    for (int leg = 0; leg < LEGS; leg++) {
        was[leg] = value[leg], std[leg] = UNIFORM * tolerance * was[leg];
        x[leg] = (struct found_value){by[leg].value * was[leg], by[leg].std * was[leg]};
    }
    weigh(LEGS, x, was, std);
    for (int leg = 0; leg < LEGS; leg++) value[leg] = rounded(x[leg]);
    note_values(f, key, LEGS, x, was);
}

/* Factor from the configured to the found flow of the valve. In the laws of oil_columns.h, g / c of
 * a chamber is the valve's gain divided by the piston's area. The standard deviations of both
 * chambers are averaged, as for fully correlated errors, because the chambers share length and
 * delay. */
static struct found_value flow_factor(const struct oil_leg *found, const struct valve_flow *configured) {
    struct found_value by = {.std = isnan(found->stiffness) ? (double)NAN : 0.0};
    for (int i = 0; i < 2; i++) {
        const struct oil_chamber *c = &found->chamber[i];
        by.value += 0.5 * loop_found_factor(c->gain * configured->area_m2[i] / c->push, configured->gain[i]);
        by.std += 0.5 * c->flow_std;
    }
    return by;
}

/* Takes the oil's stiffness and the valves' flow. A chamber's `push` is E A / V, so its factor is
 * that of the bulk modulus E. */
static void take_legs(struct machine_found *f, const struct loop_place *neutral, const struct kinematics *k,
                      const struct loop_survey *survey) {
    const struct tolerance_params *tolerance = &f->params.model.tolerance;
    struct found_value oil[LEGS], flow[LEGS];
    for (int leg = 0; leg < LEGS; leg++) {
        const struct oil_leg *found = &survey->leg[leg];
        struct valve_flow valve;
        valve_flow_init(&valve, leg, &f->params, k);
        oil[leg] = (struct found_value){.std = found->stiffness_std / found->stiffness};
        for (int i = 0; i < 2; i++) oil[leg].value += 0.5 * loop_found_factor(found->chamber[i].push, neutral->leg[leg].chamber[i].push);
        flow[leg] = flow_factor(found, &valve);
        if (!determined(oil[leg]) || !determined(flow[leg]))
            keep(f, "oil or valve of leg %d: the survey did not determine it, or it is more than %g times off", leg + 1, LOOP_FOUND_MOST);
    }
    take_factors(f, "hydraulics.bulk_modulus_pa", f->params.hydraulics.bulk_modulus_pa, tolerance->bulk_modulus, oil);
    take_factors(f, "hydraulics.valve_flow_m3_per_s", f->params.hydraulics.valve_flow_m3_per_s, tolerance->valve_gain, flow);
}

/* Takes the leakage, which is determined for each leg whose oil stiffness is determined. It
 * replaces the configured leakage times the factor of the effect internal_leakage. */
static void take_leakage(struct machine_found *f, const struct loop_survey *survey) {
    struct hydraulics_params *h = &f->params.hydraulics;
    struct effect_values *effect = &f->params.effects[effect_find("internal_leakage")];
    double was[LEGS], std[LEGS];
    struct found_value x[LEGS];
    for (int leg = 0; leg < LEGS; leg++) {
        was[leg] = h->leakage_m3_per_s_pa[leg] * (effect->on ? effect->value[0][leg] : 1.0);
        std[leg] = UNIFORM * f->params.model.tolerance.leakage * was[leg];
        x[leg] = (struct found_value){survey->leg[leg].leakage, survey->leg[leg].leakage_std};
    }
    weigh(LEGS, x, was, std);
    for (int leg = 0; leg < LEGS; leg++) h->leakage_m3_per_s_pa[leg] = fmax(rounded(x[leg]), 0.0);
    effect->on = false;
    note_values(f, "hydraulics.leakage_m3_per_s_pa", LEGS, x, was);
}

/* Takes the mean over the legs of the delay beyond the valve's own and half a cycle of holding. The
 * scatter of the legs gives its interval. */
static void take_delay(struct machine_found *f, const struct kinematics *k, const struct loop_survey *survey) {
    double sum = 0.0, squares = 0.0, was = f->params.control.delay_s;
    int legs = 0;
    for (int leg = 0; leg < LEGS; leg++) {
        struct valve_flow valve;
        valve_flow_init(&valve, leg, &f->params, k);
        double later_s = survey->leg[leg].delay_s - valve.delay_s - 0.5 * f->params.loop.period_s;
        if (!isfinite(later_s) || isnan(survey->leg[leg].stiffness)) continue;
        sum += later_s, squares += square(later_s), legs++;
    }
    if (legs < LEGS) {
        keep(f, "control.delay_s: the survey did not determine it of every leg");
        return;
    }
    double mean = sum / legs, std = sqrt(fmax(squares / legs - square(mean), 0.0) / (legs - 1));
    if (mean < -2.0 * std) keep(f, "the valves are %.2g ms faster than hydraulics.valve_frequency_hz and valve_damping say", -1e3 * mean);
    f->params.control.delay_s = fmin(fmax(rounded((struct found_value){mean, std}), 0.0), DELAY_MOST_S);
    note(f, "control.delay_s", "+- %.2g (95 %%), by the scatter of the legs; was %.6g", NUMERIC_95 * std, was);
}

void machine_found_survey(const struct loop_survey *survey, struct machine_found *f) {
    struct loop_places places;
    struct kinematics k;
    struct test_params *t = &f->params.tests;
    kinematics_place(&k, &f->params);
    if (loop_places_find(&places, &f->params, false)) take_legs(f, &places.place[0], &k, survey);
    else keep(f, "oil and valves: the supply cannot hold the platform up at neutral");
    take_leakage(f, survey), take_delay(f, &k, survey);
    if (!machine_found_is_survey(&f->params)) return;
    memset(t->trajectory, 0, sizeof t->trajectory);
    t->repeat = 1;
}
