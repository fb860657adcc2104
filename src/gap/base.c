#include "base.h"

#include <math.h>
#include <stddef.h>

struct base_entry {
    const char *name;
    size_t offset;
    double tolerance; /* relative */
    enum residual_part parts;
};

#define PLACE(member) #member, offsetof(struct params, member)

static const struct base_entry entries[] = {
    {PLACE(payload.mass_kg), 0.01, PART_FORCE},
    {PLACE(payload.inertia_xx_kg_m2), 0.01, PART_FORCE},
    {PLACE(payload.inertia_yy_kg_m2), 0.01, PART_FORCE},
    {PLACE(payload.inertia_zz_kg_m2), 0.01, PART_FORCE},
    {PLACE(actuator.upper_mass_kg), 0.01, PART_FORCE},
    {PLACE(actuator.lower_mass_kg), 0.01, PART_FORCE},
    {PLACE(hydraulics.viscous_n_s_per_m), 0.05, PART_FORCE},
    {PLACE(hydraulics.bulk_modulus_pa), 0.05, PART_PRESSURE},
    {PLACE(hydraulics.leakage_m3_per_s_pa), 0.05, PART_PRESSURE},
    {PLACE(hydraulics.valve_flow_m3_per_s), 0.05, PART_PRESSURE},
    {PLACE(hydraulics.supply_pa), 0.02, PART_PRESSURE},
    {PLACE(hydraulics.valve_damping), 0.20, PART_PRESSURE},
    {PLACE(hydraulics.dead_volume_m3), 0.30, PART_PRESSURE},
};

int base_variables(const struct params *model, struct variable v[FIT_VARIABLES]) {
    int n = sizeof entries / sizeof *entries;
    for (int i = 0; i < n; i++) {
        double value = *(const double *)(const void *)((const char *)model + entries[i].offset), width = entries[i].tolerance * fabs(value);
        v[i] = (struct variable){.name = entries[i].name, .offset = entries[i].offset, .leg = -1, .legs = 1, .effect = -1,
                                 .min = value - width, .max = value + width, .step = 0.1 * width, .parts = entries[i].parts};
    }
    return n;
}
