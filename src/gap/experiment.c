#include "experiment.h"

#include <string.h>

static const struct {
    const char *a, *b, *experiment;
} pairs[] = {
    {"payload_rotational_inertia", "external_stiffness", "repeat phi, theta, psi at half the frequency: inertia grows with its square, stiffness does not"},
    {"payload_mass", "external_stiffness", "repeat x, y, z at half the frequency: inertia grows with its square, stiffness does not"},
    {"payload_mass", "actuator_inertia", "repeat z with the payload taken off: what stays belongs to the actuators"},
    {"payload_mass", "payload_center_of_mass", "tilt the platform by 0.1 rad and hold: the static forces tell mass from its place"},
    {"actuator_inertia", "payload_rotational_inertia", "repeat phi, theta, psi with the payload taken off: what stays belongs to the actuators"},
    {"command_delay", "valve_lag", "repeat z at 20 Hz and a quarter of the amplitude: a delay's phase grows with frequency, a lag also loses amplitude"},
    {"command_delay", "position_sensor_delay", "repeat z at 12 Hz: the sensor's delay shifts length against pressure, the command's does not"},
    {"cylinder_coulomb_friction", "cylinder_stribeck_friction", "repeat z at 0.2 Hz: below 10 mm/s Stribeck friction rises, Coulomb friction stays"},
    {"cylinder_coulomb_friction", "load_dependent_friction", "repeat z with another payload: load-dependent friction changes with the pressures"},
    {"cylinder_coulomb_friction", "passive_joint_friction", "repeat psi: the joints turn there while the legs hardly move"},
    {"pressure_sensor_scale", "pressure_sensor_offset", "repeat z with another payload: a scale grows with the pressure, an offset does not"},
    {"port_area_ratio", "supply_pressure_sag", "repeat z at half the amplitude: sag falls with the square of the flow"},
    {"internal_leakage", "entrained_air", "repeat z at half the frequency: leakage shows in the mean pressures, air in the phase"},
    {"valve_dead_band", "valve_hysteresis", "repeat z at half the amplitude: a dead band is passed at spool zero, hysteresis at every turn of the command"},
    {"base_tilt", "payload_center_of_mass", "turn the payload by half a turn: the tilt's static forces stay"},
};

const char *experiment_between(const char *a, const char *b) {
    for (unsigned i = 0; i < sizeof pairs / sizeof *pairs; i++)
        if ((!strcmp(pairs[i].a, a) && !strcmp(pairs[i].b, b)) || (!strcmp(pairs[i].a, b) && !strcmp(pairs[i].b, a))) return pairs[i].experiment;
    return "repeat the six tests at half the frequency and at half the amplitude: effects scale differently with speed and stroke";
}

const char *experiment_unknown(void) {
    return "repeat the test where the gap is largest at half the frequency and at half the amplitude, and look how the gap scales";
}
