#include "machine.h"

enum { UPPER, LOWER, TRANSVERSE };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) {
        m->bodies.upper_kg[leg] += v->value[UPPER][leg];
        m->bodies.lower_kg[leg] += v->value[LOWER][leg];
        m->bodies.transverse_kg_m2[leg] += v->value[TRANSVERSE][leg];
    }
}

extern const struct effect external_stiffness, payload_mass, payload_rotational_inertia;

const struct effect actuator_inertia = {
    .name = "actuator_inertia",
    .family = EFFECT_BODIES,
    .plain = "a different mass of the actuators",
    .law = "ma + upper, mb + lower with their weight; g(L) = ma (L - ra)^2 + mb rb^2 + ia + ib + transverse",
    .signature = "leg forces: at rest and in phase with the acceleration on all axes",
    .law_error = 1e-3,
    .keys = {[UPPER] = {.name = "upper_mass_kg", .unit = "kg", .min = -1e3, .max = 1e4, .typical = 4.0, .per_leg = true},
             [LOWER] = {.name = "lower_mass_kg", .unit = "kg", .min = -1e3, .max = 1e4, .typical = 13.0, .per_leg = true},
             [TRANSVERSE] = {.name = "transverse_kg_m2", .unit = "kg m^2", .min = -1e3, .max = 1e4, .typical = 1.0, .per_leg = true}},
    .parallel_to = {"actuator.upper_mass_kg", "actuator.lower_mass_kg"},
    .told_apart = {{.from = &external_stiffness,
                    .record = "`--set tests.frequency_hz=2 --set tests.amplitude_m=0.016 --set tests.amplitude_rad=0.024`",
                    .shows = "the force of an inertia falls with the square of the frequency, a spring's stays"},
                   {.from = &payload_mass, .record = "repeat z with the payload taken off", .shows = "what stays belongs to the actuators"},
                   {.from = &payload_rotational_inertia,
                    .record = "repeat phi, theta, psi with the payload taken off",
                    .shows = "what stays belongs to the actuators"}},
    .machine = machine,
};
