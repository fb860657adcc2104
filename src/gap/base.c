#include "base.h"

#include <math.h>
#include <stddef.h>

#include "params.h"
#include "systematic.h"

struct base_entry {
    const char *name;
    size_t offset;
    enum {
        MACHINE,
        EACH_LEG,
        LEGS_ALIKE
    } of; /* EACH_LEG: there is one variable for each leg, because valves, seals and volumes differ.
           * LEGS_ALIKE: if the configuration gives all legs one value, they share one variable,
           * because their parts are made to one drawing. */
    size_t stated;    /* offset in struct params of the tolerance that the configuration states; 0:
                       * it states none */
    double tolerance; /* relative tolerance, if the configuration states none */
    size_t to;      /* offset in struct params of the value to which the tolerance is relative; 0:
                     * the tolerance is relative to the parameter itself */
    enum residual_equations equations;
};

#define PLACE(member) #member, offsetof(struct params, member), MACHINE
#define EACH(member) #member, offsetof(struct params, member), EACH_LEG
#define STATED(member) offsetof(struct params, model.tolerance.member), 0.0, 0
#define UNSTATED(tolerance) 0, tolerance, 0
#define DIFFERENCE(tolerance, member) 0, tolerance, offsetof(struct params, member)

/* Entries of every mechanism; the variables of its masses are listed before these. */
static const struct base_entry entries[] = {
    {EACH(hydraulics.viscous_n_s_per_m), STATED(viscous), EQUATIONS_FORCE},
    {EACH(hydraulics.bulk_modulus_pa), STATED(bulk_modulus), EQUATIONS_PRESSURE},
    {EACH(hydraulics.leakage_m3_per_s_pa), STATED(leakage), EQUATIONS_PRESSURE},
    {EACH(hydraulics.valve_flow_m3_per_s), STATED(valve_gain), EQUATIONS_PRESSURE},
    {PLACE(hydraulics.supply_pa), UNSTATED(0.02), EQUATIONS_PRESSURE},
    {EACH(hydraulics.valve_damping), UNSTATED(0.20), EQUATIONS_PRESSURE},
    {EACH(hydraulics.dead_volume_m3), UNSTATED(0.30), EQUATIONS_PRESSURE},
    {EACH(hydraulics.dead_volume_difference_m3), DIFFERENCE(0.60, hydraulics.dead_volume_m3), EQUATIONS_PRESSURE},
};

static const double NULL_TOLERANCE = 0.005; /* accuracy to which makers adjust a valve's null, as a
                                             * share of full opening */
static const double SENSOR_MOST = 3.0; /* largest error of a sensor that is no finding, in standard
                                        * deviations of its prior */
/* Steps of difference quotients, as shares of a variable's largest deviation: about as large as the
 * uncertainty that the data leave. ERROR_STEP is for errors of sensors, ZERO_STEP for zeros of
 * pressure sensors. ZERO_STEP is a compromise. Friction that holds a leg follows the balance of
 * forces only up to the friction's own limit, which a larger step would pass; the slope would then
 * be another one. Rods with play in their joints knock at other instants after any step, and in the
 * quotient of a smaller step these jumps would hide the slope. */
static const double STEP = 0.1, ERROR_STEP = 7e-3, ZERO_STEP = 2e-3;
static const double OFFSET_MOST_N = 1e6;
static const double FORCE_LAG_S = 1e-3; /* largest error of the force sensor's stated lag: the lag
                                         * of an amplifier with a filter of 160 Hz */

/* Effects that every machine has to a small degree, so that the base has their variables. */
extern const struct effect geometry_error, valve_null_bias, external_stiffness, pressure_sensor_offset;

/* Returns the base variable for one key of an effect, for one leg or for the machine (leg -1). Its
 * box is the configured value plus and minus the tolerance. */
static struct variable effect_variable(const struct params *model, const struct effect *of, int key, int leg, double tolerance) {
    int effect = effect_find(of->name);
    const double *place = model->effects[effect].value[key];
    return (struct variable){.name = of->keys[key].name,
                             .offset = (size_t)((const char *)place - (const char *)model),
                             .leg = leg,
                             .legs = LEGS,
                             .effect = effect,
                             .key = key,
                             .base = true,
                             .min = place[leg < 0 ? 0 : leg] - tolerance,
                             .max = place[leg < 0 ? 0 : leg] + tolerance,
                             .step = STEP * tolerance,
                             .equations = EQUATIONS_FORCE};
}

/* Lists the errors of the sensors. Their priors are those of `hexid identify`, and their ranges end
 * at SENSOR_MOST standard deviations. Errors of lags and pipes are not negative, because no gauge
 * is ahead of its chamber. */
static int sensor_variables(const struct params *model, bool pressures, struct variable *v) {
    double std[SYSTEMATICS];
    int n = 0, first;
    systematic_priors(model, pressures, std);
    for (int i = 0; i < SYSTEMATIC_JOINT; i++) {
        if (!(std[i] > 0.0)) continue;
        const char *name = systematic_kind(i, &first);
        bool common = systematic_common(i), positive = i >= SYSTEMATIC_LAG; /* a lag or a pipe */
        v[n++] = (struct variable){.name = name,
                                   .offset = offsetof(struct params, errors) + (size_t)first * sizeof(double),
                                   .leg = common ? -1 : i - first,
                                   .legs = common ? 1 : LEGS,
                                   .own = !common && !systematic_moves(i),
                                   .effect = -1,
                                   .base = true,
                                   .penalised = true,
                                   .min = positive ? 0.0 : -SENSOR_MOST * std[i],
                                   .max = SENSOR_MOST * std[i],
                                   .prior_inverse_std = 1.0 / std[i],
                                   .step = ERROR_STEP * SENSOR_MOST * std[i],
                                   .equations = EQUATIONS_ALL};
    }
    return n;
}

/* Lists the zero errors of the pressure sensors. */
static int zero_variables(const struct params *model, struct variable *v) {
    double std = model->model.tolerance.pressure_zero * model->sensors.pressure_full_scale_pa;
    int n = 0;
    for (int key = 0; key < PORTS && std > 0.0 && model->sensors.enabled; key++)
        for (int leg = 0; leg < LEGS; leg++) {
            v[n] = effect_variable(model, &pressure_sensor_offset, key, leg, SENSOR_MOST * std);
            v[n].own = v[n].penalised = true, v[n].equations = EQUATIONS_ALL;
            v[n].step = ZERO_STEP * SENSOR_MOST * std;
            v[n].neutral = 0.5 * (v[n].min + v[n].max), v[n].prior_inverse_std = 1.0 / std;
            n++;
        }
    return n;
}

static int null_variables(const struct params *model, struct variable *v) {
    for (int leg = 0; leg < params_legs(model); leg++) {
        v[leg] = effect_variable(model, &valve_null_bias, 0, leg, NULL_TOLERANCE);
        v[leg].own = true, v[leg].equations = EQUATIONS_PRESSURE;
    }
    return params_legs(model);
}

static int joint_variables(const struct params *model, struct variable *v) {
    double tolerance = model->model.tolerance.joints_m;
    int n = 0;
    for (int key = 0; key < EFFECT_KEYS && geometry_error.keys[key].name && tolerance > 0.0; key++)
        for (int leg = 0; leg < LEGS; leg++) v[n++] = effect_variable(model, &geometry_error, key, leg, tolerance);
    return n;
}

/* Lists the stiffnesses of springs, one for each axis. A spring only pulls back, so its stiffness
 * is not negative. */
static int spring_variables(const struct params *model, struct variable *v) {
    const struct tolerance_params *tolerance = &model->model.tolerance;
    int n = 0;
    for (int key = 0; key < params_mechanism(model)->axes; key++) {
        double most = key < 3 ? tolerance->springs_n_per_m : tolerance->springs_nm_per_rad;
        if (!(most > 0.0)) continue;
        v[n] = effect_variable(model, &external_stiffness, key, -1, most);
        v[n].min = fmax(v[n].min, 0.0), n++;
    }
    return n;
}

static const double *at(const struct params *p, size_t offset) { return (const double *)(const void *)((const char *)p + offset); }

static bool alike(const double *value, int numbers) {
    for (int i = 1; i < numbers; i++)
        if (value[i] != value[0]) return false;
    return true;
}

/* Adds the variables of a table entry: one for the machine, or one for each leg. Returns their
 * number. */
static int entry_variables(const struct params *model, const struct base_entry *e, struct variable *v) {
    int n = 0, numbers = e->of == MACHINE ? 1 : params_legs(model);
    bool one = numbers == 1 || (e->of == LEGS_ALIKE && alike(at(model, e->offset), numbers));
    double tolerance = e->stated ? *at(model, e->stated) : e->tolerance;
    for (int leg = 0; leg < (one ? 1 : numbers); leg++) {
        double value = at(model, e->offset)[leg], width = tolerance * fabs(at(model, e->to ? e->to : e->offset)[leg]);
        if (!(width > 0.0)) continue; /* a tolerance of 0 means that the value is exact */
        v[n++] = (struct variable){.name = e->name,
                                   .offset = e->offset,
                                   .leg = one ? -1 : leg,
                                   .legs = numbers,
                                   .own = e->of == EACH_LEG && numbers > 1,
                                   .effect = -1,
                                   .base = true,
                                   .min = value - width,
                                   .max = value + width,
                                   .step = STEP * width,
                                   .equations = e->equations};
    }
    return n;
}

/* Returns the variable of a constant force on the leg: the sensor's zero, the weight on a slope, or
 * a hose. It belongs to the base, because no effect of the catalogue describes it. */
static struct variable offset_variable(void) {
    return (struct variable){.name = "axis.force_offset_n",
                             .offset = offsetof(struct params, axis.force_offset_n),
                             .leg = -1,
                             .legs = 1,
                             .effect = -1,
                             .base = true,
                             .min = -OFFSET_MOST_N,
                             .max = OFFSET_MOST_N,
                             .step = 1.0,
                             .equations = EQUATIONS_FORCE};
}

/* Returns the variable of the lag of the force sensor behind the position sensor. */
static struct variable lag_variable(const struct params *model) {
    return (struct variable){.name = "axis.force_lag_s",
                             .offset = offsetof(struct params, axis.force_lag_s),
                             .leg = -1,
                             .legs = 1,
                             .effect = -1,
                             .base = true,
                             .min = model->axis.force_lag_s - FORCE_LAG_S,
                             .max = model->axis.force_lag_s + FORCE_LAG_S,
                             .step = STEP * FORCE_LAG_S,
                             .equations = EQUATIONS_FORCE};
}

int base_variables(const struct params *model, enum residual_equations evaluated, struct variable v[FIT_VARIABLES]) {
    int n = 0;
    const struct mechanism *mechanism = params_mechanism(model);
    for (const struct mechanism_mass *m = mechanism->masses; m->offset && evaluated & EQUATIONS_FORCE; m++)
        n += entry_variables(
            model, &(struct base_entry){m->name, m->offset, m->per_leg ? LEGS_ALIKE : MACHINE, STATED(mass), EQUATIONS_FORCE}, v + n);
    for (size_t i = 0; i < sizeof entries / sizeof *entries; i++)
        if (entries[i].equations & evaluated) n += entry_variables(model, &entries[i], v + n);
    if (evaluated & EQUATIONS_PRESSURE) n += null_variables(model, v + n);
    n += spring_variables(model, v + n);
    if (mechanism->force_sensor && evaluated & EQUATIONS_FORCE_SENSOR) v[n++] = lag_variable(model);
    if (mechanism->force_sensor) v[n++] = offset_variable();
    if (mechanism->pose) n += joint_variables(model, v + n);
    bool pressures = !(evaluated & EQUATIONS_FORCE_SENSOR);
    if (mechanism->pose) n += sensor_variables(model, pressures, v + n);
    if (mechanism->pose && pressures) n += zero_variables(model, v + n);
    return n;
}
