#include "base.h"

#include <math.h>
#include <stddef.h>

enum { PLATFORM = 1 << MECHANISM_STEWART, AXIS = 1 << MECHANISM_AXIS, ANY = PLATFORM | AXIS };

struct base_entry {
    int mechanisms;
    const char *name;
    size_t offset;
    size_t stated;    /* place of its tolerance in struct params; 0: not stated */
    double tolerance; /* relative, where none is stated */
    enum residual_part parts;
};

#define PLACE(member) #member, offsetof(struct params, member)
#define STATED(member) offsetof(struct params, model.tolerance.member), 0.0
#define UNSTATED(tolerance) 0, tolerance

static const struct base_entry entries[] = {
    {PLATFORM, PLACE(payload.mass_kg), STATED(mass), PART_FORCE},
    {PLATFORM, PLACE(payload.inertia_xx_kg_m2), STATED(mass), PART_FORCE},
    {PLATFORM, PLACE(payload.inertia_yy_kg_m2), STATED(mass), PART_FORCE},
    {PLATFORM, PLACE(payload.inertia_zz_kg_m2), STATED(mass), PART_FORCE},
    {PLATFORM, PLACE(actuator.upper_mass_kg), STATED(mass), PART_FORCE},
    {PLATFORM, PLACE(actuator.lower_mass_kg), STATED(mass), PART_FORCE},
    {AXIS, PLACE(axis.mass_kg), STATED(mass), PART_FORCE},
    {ANY, PLACE(hydraulics.viscous_n_s_per_m), STATED(viscous), PART_FORCE},
    {ANY, PLACE(hydraulics.bulk_modulus_pa), STATED(bulk_modulus), PART_PRESSURE},
    {ANY, PLACE(hydraulics.leakage_m3_per_s_pa), STATED(leakage), PART_PRESSURE},
    {ANY, PLACE(hydraulics.valve_flow_m3_per_s), STATED(valve_gain), PART_PRESSURE},
    {ANY, PLACE(hydraulics.supply_pa), UNSTATED(0.02), PART_PRESSURE},
    {ANY, PLACE(hydraulics.valve_damping), UNSTATED(0.20), PART_PRESSURE},
    {ANY, PLACE(hydraulics.dead_volume_m3), UNSTATED(0.30), PART_PRESSURE},
};

/* Where the joints are, as far as a drawing and a fitter can be off; and pressure transducers of class 0.25 on 20 MPa. */
static const struct {
    int mechanisms;
    const char *effect;
    double tolerance;
    enum residual_part parts;
    const char *name[2]; /* of its keys, all legs alike; NULL: leg by leg, without a name */
} small_effects[] = {
    {PLATFORM, "geometry_error", 0.5e-3, PART_FORCE, {NULL}},
    {ANY, "pressure_sensor_scale", 2.5e-3, PART_ALL, {"pressure_sensor_scale.p1", "pressure_sensor_scale.p2"}},
    {ANY, "pressure_sensor_offset", 20e3, PART_ALL, {"pressure_sensor_offset.p1", "pressure_sensor_offset.p2"}},
};
static const double OFFSET_MOST_N = 1e6;

/* Every key of a small effect, about the value given. */
static int small_variables(const struct params *model, int i, struct variable *v) {
    int n = 0, effect = effect_find(small_effects[i].effect);
    double width = small_effects[i].tolerance;
    bool alike = small_effects[i].name[0];
    for (int key = 0; key < EFFECT_KEYS && effect_table[effect]->keys[key].name; key++) {
        const double *place = model->effects[effect].value[key];
        for (int leg = 0; leg < (alike ? 1 : LEGS); leg++)
            v[n++] = (struct variable){.name = alike ? small_effects[i].name[key] : effect_table[effect]->keys[key].name,
                                       .offset = (size_t)((const char *)place - (const char *)model),
                                       .leg = alike ? -1 : leg, .legs = LEGS, .effect = effect, .key = key, .base = true,
                                       .min = place[leg] - width, .max = place[leg] + width, .step = 0.1 * width,
                                       .parts = small_effects[i].parts};
    }
    return n;
}

static double at(const struct params *p, size_t offset) { return *(const double *)(const void *)((const char *)p + offset); }

/* On one axis a constant force is the sensor's zero, the weight's inclination, a hose: whatever it is, no effect of the catalogue. */
static struct variable offset_variable(void) {
    return (struct variable){.name = "axis.force_offset_n", .offset = offsetof(struct params, axis.force_offset_n), .leg = -1, .legs = 1,
                             .effect = -1, .base = true,
                             .min = -OFFSET_MOST_N, .max = OFFSET_MOST_N, .step = 1.0, .parts = PART_FORCE};
}

int base_variables(const struct params *model, struct variable v[FIT_VARIABLES]) {
    int n = 0;
    bool axis = model->mechanism == MECHANISM_AXIS;
    for (size_t i = 0; i < sizeof entries / sizeof *entries; i++) {
        const struct base_entry *e = &entries[i];
        double value = at(model, e->offset), width = (e->stated ? at(model, e->stated) : e->tolerance) * fabs(value);
        if (!(width > 0.0) || !(e->mechanisms & 1 << model->mechanism)) continue; /* 0: exact by decree */
        v[n++] = (struct variable){.name = e->name, .offset = e->offset, .leg = -1, .legs = 1, .effect = -1, .base = true, .min = value - width,
                                   .max = value + width, .step = 0.1 * width, .parts = e->parts};
    }
    if (axis) v[n++] = offset_variable();
    for (size_t i = 0; i < sizeof small_effects / sizeof *small_effects; i++)
        if (small_effects[i].mechanisms & 1 << model->mechanism) n += small_variables(model, (int)i, v + n);
    return n;
}
