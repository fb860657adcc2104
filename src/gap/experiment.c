#include "experiment.h"

#include <stdbool.h>
#include <string.h>

#define SLOW "--tests phi,theta,psi --set tests.frequency_hz=2 --set tests.amplitude_rad=0.024"
#define SLOW_X "--tests x,y,z --set tests.frequency_hz=2 --set tests.amplitude_m=0.016"
#define FAST "--tests z --set tests.frequency_hz=20 --set tests.amplitude_m=0.001"
#define CRAWL "--tests z --set tests.frequency_hz=0.5 --set tests.duration_s=20"
#define LARGE "--set tests.amplitude_m=0.012 --set tests.amplitude_rad=0.018 --set tests.frequency_hz=2"
#define HALF "--set tests.amplitude_m=0.002 --set tests.amplitude_rad=0.003"

static const struct {
    const char *a, *b, *experiment;
} pairs[] = {
    {"payload_rotational_inertia", "external_stiffness",
     "`" SLOW "`: the force of an inertia falls with the square of the frequency, a spring's stays"},
    {"actuator_inertia", "external_stiffness",
     "`--set tests.frequency_hz=2 --set tests.amplitude_m=0.016 --set tests.amplitude_rad=0.024`: the force of an inertia falls with the "
     "square of the frequency, a spring's stays"},
    {"payload_mass", "external_stiffness", "`" SLOW_X "`: the force of a mass falls with the square of the frequency, a spring's stays"},
    {"payload_mass", "actuator_inertia", "repeat z with the payload taken off: what stays belongs to the actuators"},
    {"payload_mass", "pressure_sensor_scale",
     "repeat z with the payload taken off: a scale's force shrinks with the load, a missing mass is gone"},
    {"payload_mass", "payload_center_of_mass", "tilt the platform by 0.1 rad and hold: the static forces tell mass from its place"},
    {"actuator_inertia", "payload_rotational_inertia",
     "repeat phi, theta, psi with the payload taken off: what stays belongs to the actuators"},
    {"command_delay", "valve_lag", "`" FAST "`: a delay's phase grows with frequency, a lag also loses amplitude"},
    {"command_delay", "position_sensor_delay", "`" FAST "`: the sensor's delay shifts length against pressure, the command's does not"},
    {"cylinder_coulomb_friction", "cylinder_stribeck_friction",
     "`" CRAWL "`: below 10 mm/s Stribeck friction rises, Coulomb friction stays"},
    {"cylinder_coulomb_friction", "load_dependent_friction",
     "repeat z with another payload: load-dependent friction changes with the pressures"},
    {"cylinder_coulomb_friction", "passive_joint_friction", "`--tests psi`: the joints turn there while the legs hardly move"},
    {"pressure_sensor_scale", "pressure_sensor_offset",
     "repeat z with another payload: a scale grows with the pressure, an offset does not"},
    {"position_sensor_scale", "position_sensor_offset",
     "`" LARGE "`: a scale grows with the motion, an offset does not"},
    {"port_area_ratio", "supply_pressure_sag", "`" HALF "`: sag falls with the square of the flow"},
    {"internal_leakage", "entrained_air", "`--set tests.frequency_hz=2`: leakage shows in the mean pressures, air in the phase"},
    {"valve_dead_band", "valve_hysteresis", "`" HALF "`: a dead band is passed at spool zero, hysteresis at every turn of the command"},
    {"payload_mass", "position_sensor_scale", "hold a rule against the stroke: the position sensor's scale shows at rest"},
    {"cylinder_coulomb_friction", "constant_force_offset",
     "let go of the load and read the force at rest, coming from both sides: an offset stays, friction changes its sign"},
    {"base_tilt", "payload_center_of_mass", "turn the payload by half a turn: the tilt's static forces stay"},
};

static bool is_pair(unsigned i, const char *a, const char *b) { return !strcmp(pairs[i].a, a) && !strcmp(pairs[i].b, b); }

const char *experiment_between(const char *a, const char *b) {
    for (unsigned i = 0; i < sizeof pairs / sizeof *pairs; i++)
        if (is_pair(i, a, b) || is_pair(i, b, a)) return pairs[i].experiment;
    return "`--set tests.frequency_hz=2` and `" HALF "`: effects scale differently with speed and stroke";
}

const char *experiment_unknown(void) {
    return "repeat the test where the gap is largest at half the frequency and at half the amplitude, and look how the gap scales";
}
