#include "config.h"
#include "config_keys.h"

#include <math.h>
#include <string.h>

#include "areas.h"
#include "blind_time.h"
#include "effect.h"
#include "kinematics.h"
#include "leg_places.h"
#include "machine_name.h"
#include "params.h"
#include "units.h"

static const double substep_max_s = 0.25e-3; /* largest substep of the simulation; with longer ones
                                              * its integration errors bias the identified inertia
                                              * (docs/method.md section 4) */

static const double ramp_min_s = 0.05;

enum { SAID = 32 };

/* Collects all violated requirements in one message. Requirements that only fail as a
 * consequence of others are skipped. */
struct checker {
    const char *name;
    struct error *error;
    int status; /* not 0: a requirement is violated */
    const char *said[SAID]; /* formats of the requirements reported so far; each is reported only
                             * for the first leg or axis that violates it */
    int count;
    bool full;
};

static void say(struct checker *c, const char *text) {
    size_t used = strlen(c->error->text), room = sizeof c->error->text - used;
    static const char more[] = "; and more";
    if (c->full) return;
    c->full = strlen(text) + 2 + sizeof more > room;
    snprintf(c->error->text + used, room, "%s%s", c->full ? more : "; ", c->full ? "" : text);
}

__attribute__((format(printf, 3, 4))) static bool require(struct checker *c, bool holds, const char *format, ...) {
    char text[300];
    va_list args;
    if (holds) return true;
    for (int i = 0; i < c->count; i++)
        if (c->said[i] == format) return false;
    if (c->count < SAID) c->said[c->count++] = format;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (c->status == STATUS_OK) c->status = error_set(c->error, STATUS_USAGE, "%.90s: %s", c->name, text);
    else say(c, text);
    return false;
}

/* Checks that a body with this inertia exists: the matrix of the second moments (integrals of
 * x^2, y^2, z^2 and of the products) must be positive semidefinite. */
static void check_payload(struct checker *c, const struct payload_params *p) {
    double half = 0.5 * (p->inertia_xx_kg_m2 + p->inertia_yy_kg_m2 + p->inertia_zz_kg_m2);
    double xx = half - p->inertia_xx_kg_m2, yy = half - p->inertia_yy_kg_m2, zz = half - p->inertia_zz_kg_m2;
    double xy = p->inertia_xy_kg_m2, xz = p->inertia_xz_kg_m2, yz = p->inertia_yz_kg_m2, none = -1e-9 * half;
    double determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz + yz * xz) - xz * (xy * yz + yy * xz);
    if (!require(c, xx >= none && yy >= none && zz >= none,
                 "payload.inertia_xx_kg_m2 %g, inertia_yy_kg_m2 %g, inertia_zz_kg_m2 %g: no body has them; each is at most the others' sum",
                 p->inertia_xx_kg_m2, p->inertia_yy_kg_m2, p->inertia_zz_kg_m2))
        return;
    require(c,
            xx * yy - xy * xy >= none * half && xx * zz - xz * xz >= none * half && yy * zz - yz * yz >= none * half &&
                determinant >= none * half * half,
            "payload.inertia_xy_kg_m2 %g, inertia_xz_kg_m2 %g, inertia_yz_kg_m2 %g: no body has them beside inertia_xx_kg_m2 %g, "
            "inertia_yy_kg_m2 %g, inertia_zz_kg_m2 %g; they are too large",
            xy, xz, yz, p->inertia_xx_kg_m2, p->inertia_yy_kg_m2, p->inertia_zz_kg_m2);
}

static void check_leg(struct checker *c, const struct params *p, int i, const struct kinematics *k, double parked) {
    const struct actuator_params *a = &p->actuator;
    const struct limit_params *l = &p->limits;
    struct stroke stroke = kinematics_stroke(k, a, i);
    double neutral = k->neutral_length_m[i], shortest = stroke.least_m, drop = p->motion.park_z_m;

    if (!require(c, shortest >= a->stroke_m[i],
                 "actuator.stroke_m %g of leg %d does not fit: the geometry makes legs of %.4g m at mid-stroke, and a cylinder is at least "
                 "its stroke long when it is in; give a stroke up to %.4g m, or a larger geometry.height_m",
                 a->stroke_m[i], i + 1, stroke.middle_m, stroke.middle_m / 1.5))
        return;
    require(c, a->upper_center_m[i] <= shortest && a->lower_center_m[i] <= shortest,
            "actuator.upper_center_m %g and lower_center_m %g of leg %d must lie within the shortest leg, %.4g m", a->upper_center_m[i],
            a->lower_center_m[i], i + 1, shortest);
    require(c, l->length_min_m[i] < neutral && neutral < l->length_max_m[i],
            "limits.length_min_m %g and length_max_m %g must enclose the neutral leg length, %.4g m (leg %d)", l->length_min_m[i],
            l->length_max_m[i], neutral, i + 1);
    require(c, shortest < neutral && neutral < stroke.most_m,
            "actuator.mid_stroke_m %g of leg %d: its stroke, %.4g to %.4g m, must enclose the neutral leg length, %.4g m",
            a->mid_stroke_m[i], i + 1, shortest, stroke.most_m, neutral);
    if (p->geometry.height_m < 0.0) return; /* a platform suspended from its legs is never parked */
    if (!require(c, drop < p->geometry.height_m, "motion.park_z_m %g must be below geometry.height_m %g", drop, p->geometry.height_m))
        return;
    require(c, parked >= shortest,
            "motion.park_z_m %g makes leg %d %.4g m long, and its stroke ends at %.4g m (%.4g m at neutral): park higher (smaller z)", drop,
            i + 1, parked, shortest, neutral);
    /* if parked < shortest, the message above already asks for a higher park position, with which
     * the leg is at least `shortest` long; that length is compared */
    require(c, fmax(parked, shortest) > l->length_min_m[i],
            "motion.park_z_m %g makes leg %d %.4g m long, limits.length_min_m is %g: lower that below the leg that is in, %.4g m, or park "
            "higher (smaller z)",
            drop, i + 1, parked, l->length_min_m[i], shortest);
}

/* Finds the shortest and the longest leg at neutral if leg k has the joint order->place[k] of the
 * platform. Returns true if the limits enclose all legs. */
static bool neutral_range(const struct params *p, const struct kinematics *k, const struct leg_places *order, double range_m[2]) {
    struct kinematics listed = *k;
    double length_m[LEGS];
    bool within = true;
    for (int i = 0; i < LEGS; i++) memcpy(listed.upper[i], k->upper[order->place[i]], sizeof listed.upper[i]);
    ik_lengths(&listed, (double[DOFS]){0}, length_m);
    range_m[0] = HUGE_VAL, range_m[1] = 0.0;
    for (int i = 0; i < LEGS; i++) {
        range_m[0] = fmin(range_m[0], length_m[i]), range_m[1] = fmax(range_m[1], length_m[i]);
        within = within && p->limits.length_min_m[i] < length_m[i] && length_m[i] < p->limits.length_max_m[i];
    }
    return within;
}

/* Refuses the lists of joints if another common order of the platform's joints makes the legs much
 * more equal than the stated order and fits the limits: the two lists then probably do not begin
 * with the same leg. The message names that order. */
static void check_lists(struct checker *c, const struct params *p, const struct kinematics *k) {
    static const double alike = 0.25; /* range of the legs' lengths, as a share of the range in the
                                       * stated order, below which another order is suspected to be
                                       * the right one */
    struct leg_places order[LEG_PLACES_COMMON];
    double range_m[LEG_PLACES_COMMON][2], least_m;
    char name[LEG_PLACES_NAME];
    int best = 0;
    leg_places_common(order);
    neutral_range(p, k, &order[0], range_m[0]);
    least_m = alike * (range_m[0][1] - range_m[0][0]);
    for (int i = 1; i < LEG_PLACES_COMMON; i++) {
        bool within = neutral_range(p, k, &order[i], range_m[i]);
        if (within && range_m[i][1] - range_m[i][0] < least_m) best = i, least_m = range_m[i][1] - range_m[i][0];
    }
    leg_places_name(&order[best], name);
    require(
        c, !best,
        "the joints of the platform seem to be listed otherwise than those of the base: with %s, the legs would be %.4g to %.4g m long at "
        "neutral, not %.4g to %.4g m",
        name, range_m[best][0], range_m[best][1], range_m[0][0], range_m[0][1]);
}

/* Checks each leg's stroke and limits. Returns false if a requirement is violated; the reach of the
 * tests, which depends on stroke and limits, is then not checked. */
static bool check_legs(struct checker *c, const struct params *p) {
    struct kinematics k;
    int wrong = c->count;
    double parked[LEGS];
    kinematics_place(&k, p);
    ik_lengths(&k, (double[DOFS]){[DOF_Z] = p->motion.park_z_m}, parked);
    for (int i = 0; i < LEGS; i++) check_leg(c, p, i, &k, parked[i]);
    if (c->count > wrong && (p->geometry.upper.given || p->geometry.lower.given)) check_lists(c, p, &k);
    return c->count == wrong;
}

/* Refuses actuator.retracted_std_m without retracted_m, the measured length of a leg on its stop.
 * Otherwise the sensor's reading on the stop would be compared with a length of 0, and the whole
 * reading would be taken for the sensor's zero error. */
static void check_stops(struct checker *c, const struct actuator_params *a) {
    for (int i = 0; i < LEGS && a->retracted_std_m > 0.0; i++)
        require(c, a->retracted_m[i] > 0.0,
                "actuator.retracted_std_m %g without actuator.retracted_m of leg %d: state the length that was measured, or leave both out",
                a->retracted_std_m, i + 1);
}

static void check_hydraulics(struct checker *c, const struct params *p) {
    const struct hydraulics_params *h = &p->hydraulics;
    const struct actuator_params *a = &p->actuator;
    for (int i = 0; i < LEGS; i++) {
        require(c, !areas_stated(p) || a->rod_diameter_m[i] < a->piston_diameter_m[i],
                "actuator.rod_diameter_m %g must be below actuator.piston_diameter_m %g (leg %d)", a->rod_diameter_m[i],
                a->piston_diameter_m[i], i + 1);
        require(c, h->dead_volume_m3[i] + h->dead_volume_difference_m3[i] > 0.0,
                "hydraulics.dead_volume_difference_m3 %g of leg %d leaves no volume on the rod side: it must be above -dead_volume_m3, %g",
                h->dead_volume_difference_m3[i], i + 1, -h->dead_volume_m3[i]);
    }
    require(c, h->tank_pa < h->supply_pa, "hydraulics.tank_pa %g must be below hydraulics.supply_pa %g", h->tank_pa, h->supply_pa);
    require(c, h->supply_pa <= p->sensors.pressure_full_scale_pa, "sensors.pressure_full_scale_pa %g must reach hydraulics.supply_pa %g",
            p->sensors.pressure_full_scale_pa, h->supply_pa);
}

static void check_limits(struct checker *c, const struct params *p) {
    const struct limit_params *l = &p->limits;
    const struct hydraulics_params *h = &p->hydraulics;

    require(c, l->pressure_min_pa < h->tank_pa && h->supply_pa < l->pressure_max_pa,
            "limits.pressure_min_pa %g and pressure_max_pa %g must enclose hydraulics.tank_pa %g and supply_pa %g", l->pressure_min_pa,
            l->pressure_max_pa, h->tank_pa, h->supply_pa);
    require(c, p->motion.rate_mps < l->leg_rate_mps, "motion.rate_mps %g must be below limits.leg_rate_mps %g: a move is no fault",
            p->motion.rate_mps, l->leg_rate_mps);
    require(c, l->sensor_age_s >= p->loop.period_s, "limits.sensor_age_s %g must be at least loop.period_s %g", l->sensor_age_s,
            p->loop.period_s);
}

/* Returns the distance by which the upper joints may move from neutral, in any direction, before a
 * leg reaches an end of its stroke or a limit of its length. */
static double room_m(const struct params *p, const struct kinematics *k) {
    double room = (double)INFINITY;
    for (int i = 0; i < LEGS; i++) {
        double neutral = k->neutral_length_m[i];
        struct stroke stroke = kinematics_stroke(k, &p->actuator, i);
        room = fmin(room, fmin(stroke.most_m, p->limits.length_max_m[i]) - neutral);
        room = fmin(room, neutral - fmax(stroke.least_m, p->limits.length_min_m[i]));
    }
    return room;
}

static void check_reach(struct checker *c, const struct params *p, enum dof axis) {
    bool turns = axis >= DOF_PHI;
    const char *key = turns ? "amplitude_rad" : "amplitude_m", *name = dof_names[axis];
    double amplitude = p->tests.amplitude[axis], hz = p->tests.hz[axis], arm = 0.0;
    struct kinematics k;
    kinematics_place(&k, p);
    for (int i = 0; i < LEGS; i++) arm = fmax(arm, sqrt(pow(k.upper[i][0], 2) + pow(k.upper[i][1], 2) + pow(k.upper[i][2], 2)));
    double reach = turns ? amplitude * arm : amplitude, speed = 2 * PI * hz * reach, room = room_m(p, &k);

    require(c, reach < room,
            "tests.%s of %s, %g (%.3g m at a joint), leaves the legs' room round neutral, %.3g m by actuator.stroke_m, "
            "limits.length_min_m and length_max_m",
            key, name, amplitude, reach, room);
    require(c, speed < p->limits.leg_rate_mps,
            "tests.%s of %s, %g, at its tests.frequency_hz %g takes %.3g m/s, above limits.leg_rate_mps %g; lower one", key, name,
            amplitude, hz, speed, p->limits.leg_rate_mps);
}

static void check_frequency(struct checker *c, const struct params *p, enum dof axis) {
    const struct test_params *t = &p->tests;
    const char *name = dof_names[axis];
    double hz = t->hz[axis], rate_hz = 1 / p->loop.period_s;

    require(c, hz <= rate_hz / 4, "tests.frequency_hz of %s, %g, must be at most a quarter of the loop's %g Hz (loop.period_s)", name, hz,
            rate_hz);
    require(c, t->harmonics * hz < rate_hz / 2,
            "tests.harmonics %d of tests.frequency_hz %g (%s) must stay below half the loop's %g Hz: give fewer harmonics", t->harmonics,
            hz, name, rate_hz);
    require(c, t->duration_s * hz >= 2, "tests.duration_s %g must hold two periods of tests.frequency_hz %g (%s): at least %g s",
            t->duration_s, hz, name, 2 / hz);
}

/* Checks each tested axis by itself. reach: also checks that the legs reach the amplitudes. */
static void check_tests(struct checker *c, const struct params *p, bool reach) {
    const struct test_params *t = &p->tests;
    double rate_hz = 1 / p->loop.period_s, samples = t->duration_s * rate_hz;
    int regressors = 2 + 2 * t->harmonics;

    require(c, !t->multisine || !t->trajectory[0], "tests.multisine and tests.trajectory %.60s: one of them; a trajectory has its own axes",
            t->trajectory);
    require(c, t->trajectory[0] || t->repeat == 1, "tests.repeat %d is of a trajectory, and tests.trajectory names none", t->repeat);
    if (t->trajectory[0]) return;
    for (int i = 0; i < t->count; i++) {
        check_frequency(c, p, t->order[i]);
        if (reach) check_reach(c, p, t->order[i]);
    }
    require(c, samples >= 2 * regressors, "tests.duration_s %g holds %.0f samples; tests.harmonics %d needs %d: at least %g s",
            t->duration_s, samples, t->harmonics, 2 * regressors, 2 * regressors / rate_hz);
}

static void check_sim(struct checker *c, const struct params *p) {
    double substep_s = p->loop.period_s / p->sim.substeps;
    require(c, substep_s <= substep_max_s * (1 + 1e-9), "sim.substeps %d makes substeps of %g s, the longest is %g s: at least %.0f",
            p->sim.substeps, substep_s, substep_max_s, ceil(p->loop.period_s / substep_max_s - 1e-9));
    require(c, p->sim.smooth_friction_mps == 0.0 || p->sim.engine == ENGINE_CLOSED_FORM,
            "sim.smooth_friction_mps %g needs sim.engine closed_form: so steep a damper is not stable with ode",
            p->sim.smooth_friction_mps);
    require(c, (p->sim.base_hz == 0.0 && p->sim.ripple_pa == 0.0) || p->sim.engine == ENGINE_ODE,
            "sim.base_hz %g and ripple_pa %g need sim.engine ode", p->sim.base_hz, p->sim.ripple_pa);
}

static void check_rest(struct checker *c, const struct params *p) {
    struct kinematics k;
    kinematics_place(&k, p);
    for (int i = 0; i < LEGS; i++) {
        double in_m = kinematics_stroke(&k, &p->actuator, i).least_m;
        require(c, p->limits.length_min_m[i] < in_m,
                "limits.length_min_m %g: leg %d is %.4g m long when it is in, so that a platform put down is a fault from the start; lower "
                "it (or does the leg not go in so far? actuator.stroke_m, mid_stroke_m)",
                p->limits.length_min_m[i], i + 1, in_m);
    }
}

static const double height_least_m = 0.05; /* with less, the legs lie almost in the joints' plane */

int config_check_motion(const struct params *p, struct error *error) {
    struct checker c = {.name = "not run", .error = error};
    struct blind_time blind = blind_time(p);
    const char *refusal = params_mechanism(p)->refuses.run;
    if (!require(&c, !refusal, "%s", refusal)) return c.status;
    /* SAFETY: start, parking and end stops suit only a platform that stands on its legs. */
    require(&c, !params_mechanism(p)->pose || p->geometry.height_m > 0.0,
            "geometry.height_m %g: the platform hangs; hexid moves platforms that stand on their legs, and of others reads recordings",
            p->geometry.height_m);
    check_rest(&c, p);
    require(&c, p->tests.ramp_s >= ramp_min_s && p->tests.ramp_out_s >= ramp_min_s,
            "tests.ramp_s %g and ramp_out_s %g must be at least %g s: less is a blow to the machine", p->tests.ramp_s, p->tests.ramp_out_s,
            ramp_min_s);
    require(&c, blind.allowed,
            "with %s the machine moves for %.3g s without a controller (%s), more than limits.blind_time_s %g: lower these keys, or, for "
            "tests without a machine, raise that one",
            blind.when, blind.s, blind.sum, p->limits.blind_time_s);
    return c.status;
}

static void check_channel(struct checker *c, const char *section, const struct channel_params *p) {
    for (int i = 0; i < LEGS; i++) {
        require(c, p->raw_min[i] != p->raw_max[i], "%s.raw_min and raw_max of leg %d are both %g: no scale", section, i + 1, p->raw_min[i]);
        require(c, p->si_min[i] != p->si_max[i], "%s.si_min and si_max of leg %d are both %g: no scale", section, i + 1, p->si_min[i]);
        require(c, p->low[i] < p->high[i], "%s.low %g must be below high %g (leg %d)", section, p->low[i], p->high[i], i + 1);
    }
}

/* Refuses keys that shape a law whose strength is not set: alone they have no effect, so the
 * strength was probably forgotten. */
static void check_effects(struct checker *c, const struct params *p) {
    for (int e = 0; effect_table[e]; e++) {
        const struct effect_key *keys = effect_table[e]->keys, *shape = NULL, *strength = NULL;
        if (!p->effects[e].on || effect_acts(effect_table[e], &p->effects[e])) continue;
        for (int k = 0; k < EFFECT_KEYS && keys[k].name; k++) {
            if (!keys[k].shapes_law) strength = strength ? strength : &keys[k];
            else if (!effect_neutral(&keys[k], p->effects[e].value[k])) shape = &keys[k];
        }
        require(c, !shape || !strength, "effects.%s.%s alone does nothing: state effects.%s.%s, too", effect_table[e]->name,
                shape ? shape->name : "", effect_table[e]->name, strength ? strength->name : "");
    }
}

int config_check(const struct params *params, const char *name, struct error *error) {
    struct checker c = {.name = name, .error = error};
    bool pose = params_mechanism(params)->pose, driven = !params_mechanism(params)->refuses.run;
    check_payload(&c, &params->payload);
    check_stops(&c, &params->actuator);
    check_hydraulics(&c, params);
    if (pose)
        require(&c, fabs(params->geometry.height_m) >= height_least_m, "geometry.height_m %g: its amount must be at least %g m",
                params->geometry.height_m, height_least_m);
    bool moves = pose && check_legs(&c, params);
    if (driven) check_limits(&c, params);
    /* hexid only reads recordings of a mechanism that it does not drive, and measures their
     * frequency and duration, so `tests` is not checked */
    if (driven) check_tests(&c, params, moves);
    check_effects(&c, params);
    require(&c, !params->machine.name[0] || machine_name_valid(params->machine.name),
            "machine.name \"%.60s\": not 1 to %d of A-Z a-z 0-9 - _", params->machine.name, MACHINE_NAME_SIZE - 1);
    if (driven) check_sim(&c, params);
    check_channel(&c, "length_channel", &params->length_channel);
    check_channel(&c, "p1_channel", &params->p1_channel);
    check_channel(&c, "p2_channel", &params->p2_channel);
    check_channel(&c, "valve_channel", &params->valve_channel);
    return c.status;
}
