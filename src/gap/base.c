#include "base.h"

#include <math.h>
#include <stddef.h>

struct base_entry {
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
    {PLACE(payload.mass_kg), STATED(mass), PART_FORCE},
    {PLACE(payload.inertia_xx_kg_m2), STATED(mass), PART_FORCE},
    {PLACE(payload.inertia_yy_kg_m2), STATED(mass), PART_FORCE},
    {PLACE(payload.inertia_zz_kg_m2), STATED(mass), PART_FORCE},
    {PLACE(actuator.upper_mass_kg), STATED(mass), PART_FORCE},
    {PLACE(actuator.lower_mass_kg), STATED(mass), PART_FORCE},
    {PLACE(hydraulics.viscous_n_s_per_m), STATED(viscous), PART_FORCE},
    {PLACE(hydraulics.bulk_modulus_pa), STATED(bulk_modulus), PART_PRESSURE},
    {PLACE(hydraulics.leakage_m3_per_s_pa), STATED(leakage), PART_PRESSURE},
    {PLACE(hydraulics.valve_flow_m3_per_s), STATED(valve_gain), PART_PRESSURE},
    {PLACE(hydraulics.supply_pa), UNSTATED(0.02), PART_PRESSURE},
    {PLACE(hydraulics.valve_damping), UNSTATED(0.20), PART_PRESSURE},
    {PLACE(hydraulics.dead_volume_m3), UNSTATED(0.30), PART_PRESSURE},
};

/* Where the joints are, as far as a drawing and a fitter can be off. */
static const double JOINT_TOLERANCE_M = 0.5e-3;

static int joint_variables(const struct params *model, struct variable *v) {
    int n = 0, effect = effect_find("geometry_error");
    const struct effect_values *values = &model->effects[effect];
    for (int key = 0; key < EFFECT_KEYS && effect_table[effect]->keys[key].name; key++)
        for (int leg = 0; leg < LEGS; leg++) {
            const double *place = values->value[key];
            v[n++] = (struct variable){.name = effect_table[effect]->keys[key].name, .offset = (size_t)((const char *)place - (const char *)model),
                                       .leg = leg, .legs = LEGS, .effect = effect, .key = key, .base = true,
                                       .min = place[leg] - JOINT_TOLERANCE_M, .max = place[leg] + JOINT_TOLERANCE_M,
                                       .step = 0.1 * JOINT_TOLERANCE_M, .parts = PART_FORCE};
        }
    return n;
}

static double at(const struct params *p, size_t offset) { return *(const double *)(const void *)((const char *)p + offset); }

int base_variables(const struct params *model, struct variable v[FIT_VARIABLES]) {
    int n = 0;
    for (size_t i = 0; i < sizeof entries / sizeof *entries; i++) {
        const struct base_entry *e = &entries[i];
        double value = at(model, e->offset), width = (e->stated ? at(model, e->stated) : e->tolerance) * fabs(value);
        if (!(width > 0.0)) continue; /* exact by decree */
        v[n++] = (struct variable){.name = e->name, .offset = e->offset, .leg = -1, .legs = 1, .effect = -1, .base = true, .min = value - width,
                                   .max = value + width, .step = 0.1 * width, .parts = e->parts};
    }
    return n + joint_variables(model, v + n);
}
