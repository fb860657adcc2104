#include "config_keys.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "config.h"
#include "edit_distance.h"
#include "number_text.h"
#include "params.h"

/* Derives the kind from the member's type, so that a row cannot contradict the struct. */
#define KIND(place) _Generic(((struct params *)0)->place, double: CONFIG_REAL, int: CONFIG_INTEGER, bool: CONFIG_BOOLEAN)
#define KEY(section, member, value, min, max, unit, meaning) \
    {#section "." #member, KIND(section.member), offsetof(struct params, section.member), min, max, value, unit, meaning, NULL, -1, 1, \
     false}
#define TOLERANCE(member, value, meaning) KEY(model.tolerance, member, value, 0.0, 0.5, "-", meaning)
#define WORD(section, member, kind, value, meaning, names) \
    {#section "." #member, kind, offsetof(struct params, section.member), 0, 0, value, "-", meaning, names, -1, 1, false}
#define LEG_KEY(section, member, value, min, max, unit, meaning) \
    {#section "." #member, CONFIG_REALS, offsetof(struct params, section.member), min, max, value, unit, meaning, NULL, -1, LEGS, false}
#define JOINTS_KEY(member, meaning) \
    {"geometry." #member "_joints_m", CONFIG_POINTS, offsetof(struct params, geometry.member), -30.0, 30.0, "[]", "m", meaning, NULL, -1, \
     LEGS, false}
#define JOINT_AXES_KEY(member, meaning) \
    {"geometry." #member "_joint_axes", CONFIG_POINTS, offsetof(struct params, geometry.member##_axis), -1e4, 1e4, "[]", "-", meaning, \
     NULL, -1, LEGS, false}
#define AXES_KEY(name, member, count, value, min, max, unit, meaning) \
    {"tests." name, CONFIG_REALS, offsetof(struct params, tests.member), min, max, value, unit, meaning, NULL, -1, count, false}
#define RAW_LIMIT 2147483647.0
#define SI_LIMIT 1e9
#define CHANNEL(section, unit, raw_min_, raw_max_, si_min_, si_max_, low_, high_)                                              \
    LEG_KEY(section, raw_min, raw_min_, -RAW_LIMIT, RAW_LIMIT, "raw", "on the bus at si_min"),                                  \
    LEG_KEY(section, raw_max, raw_max_, -RAW_LIMIT, RAW_LIMIT, "raw", "on the bus at si_max; below raw_min turns the sense"),   \
    LEG_KEY(section, si_min, si_min_, -SI_LIMIT, SI_LIMIT, unit, "at raw_min"),                                                 \
    LEG_KEY(section, si_max, si_max_, -SI_LIMIT, SI_LIMIT, unit, "at raw_max"),                                                 \
    LEG_KEY(section, offset, "0", -SI_LIMIT, SI_LIMIT, unit, "added to it"),                                                    \
    LEG_KEY(section, low, low_, -SI_LIMIT, SI_LIMIT, unit, "lowest plausible value"),                                           \
    LEG_KEY(section, high, high_, -SI_LIMIT, SI_LIMIT, unit, "highest plausible value")

static const char *const law_names[] = {[CONTROL_PID] = "pid", [CONTROL_MODEL] = "model", NULL};
static const char *const engine_names[] = {[ENGINE_ODE] = "ode", [ENGINE_CLOSED_FORM] = "closed_form", NULL};

/* Ranges are wide: they include every value that a machine can have, from a desktop hexapod to a
 * flight simulator, not only advisable ones. */
static const struct config_key keys[] = {
    {"mechanism", CONFIG_CHOICE, offsetof(struct params, mechanism), 0, 0, "stewart", "-",
     "six-leg platform, or one cylinder or electric axis (import and gap only)", mechanism_names, -1, 1, false},

    KEY(geometry, upper_radius_m, "0.56", 0.02, 20.0, "m", "Ra: radius of the upper joints"),
    KEY(geometry, lower_radius_m, "1.20", 0.02, 20.0, "m", "Rb: radius of the lower joints"),
    KEY(geometry, height_m, "1.64", -20.0, 20.0, "m",
        "H: upper joint plane (z = 0 of upper_joints_m) above the lower one at neutral; negative: below it, a platform that hangs"),
    KEY(geometry, upper_half_angle_rad, "0.2343", 0.001, 1.04, "rad", "alpha: half the angle of an upper joint pair"),
    KEY(geometry, lower_half_angle_rad, "0.1886", 0.001, 1.04, "rad", "beta: half the angle of a lower joint pair"),
    JOINTS_KEY(upper, "[x, y, z] of each leg's upper joint, in the platform's drawing (x forward, y right, z down); []: Ra and alpha"),
    JOINTS_KEY(lower, "the same of the lower joints, in the base's drawing; []: Rb and beta"),
    JOINT_AXES_KEY(upper,
                   "direction [x, y, z] of the axis of each upper joint that is fixed in the platform, in its drawing, of any length "
                   "and sense: joint friction acts about it and about the one across it and the leg; []: level, tangential to the "
                   "joint circle"),
    JOINT_AXES_KEY(lower, "the same of the lower joints, in the base's drawing"),

    KEY(payload, mass_kg, "178.6", 0.1, 1e5, "kg", "m: platform and load"),
    KEY(payload, inertia_xx_kg_m2, "13.60", 1e-4, 1e6, "kg m^2", "about the mass centre"),
    KEY(payload, inertia_yy_kg_m2, "13.60", 1e-4, 1e6, "kg m^2", "about the mass centre"),
    KEY(payload, inertia_zz_kg_m2, "23.92", 1e-4, 1e6, "kg m^2", "about the mass centre"),
    KEY(payload, inertia_xy_kg_m2, "0", -1e6, 1e6, "kg m^2", "entry of the inertia matrix: minus the integral of x y dm"),
    KEY(payload, inertia_xz_kg_m2, "0", -1e6, 1e6, "kg m^2", "the same"),
    KEY(payload, inertia_yz_kg_m2, "0", -1e6, 1e6, "kg m^2", "the same"),
    KEY(payload, center_height_m, "0.16", -5.0, 5.0, "m", "h: mass centre above the upper joint plane"),
    KEY(payload, center_x_m, "0", -5.0, 5.0, "m", "mass centre forward of the origin of the platform's drawing"),
    KEY(payload, center_y_m, "0", -5.0, 5.0, "m", "mass centre to the right of it"),
    KEY(payload, gravity_mps2, "9.80665", 0.0, 20.0, "m/s^2", "along +z, down"),

    KEY(axis, mass_kg, "100", 0.001, 1e6, "kg", "all that moves"),
    KEY(axis, gravity_mps2, "0", -20.0, 20.0, "m/s^2", "component along the axis; positive: the weight pushes the rod in; 0: horizontal"),
    KEY(axis, middle_m, "0", -100.0, 100.0, "m", "reading of the position at mid-stroke"),
    KEY(axis, force_offset_n, "0", -1e7, 1e7, "N", "constant force that the reading has too much"),
    KEY(axis, force_lag_s, "0", 0.0, 0.1, "s",
        "first-order lag of a force sensor's reading: 1 / (2 pi cut-off frequency); hexid gap lets it be 1 ms off"),

    LEG_KEY(actuator, piston_diameter_m, "0.063", 0.005, 1.0, "m", "D: piston; no default for an axis"),
    LEG_KEY(actuator, rod_diameter_m, "0.045", 0.001, 1.0, "m", "d: rod; no default for an axis"),
    LEG_KEY(actuator, stroke_m, "0.8", 0.01, 10.0, "m", "end stop to end stop"),
    LEG_KEY(actuator, mid_stroke_m, "0", -5.0, 5.0, "m", "length in the middle of the stroke less that at neutral"),
    LEG_KEY(actuator, retracted_m, "0", 0.0, 30.0, "m",
            "length, joint to joint, on the lower end stop, on which the platform rests without supply: as measured on the cylinder"),
    KEY(actuator, retracted_std_m, "0", 0.0, 0.05, "m", "standard deviation of retracted_m; 0: it was not measured"),
    LEG_KEY(actuator, upper_mass_kg, "15.65", 0.0, 1e4, "kg", "ma: rod, the upper part"),
    LEG_KEY(actuator, lower_mass_kg, "52.48", 0.0, 1e4, "kg", "mb: cylinder, the lower part"),
    LEG_KEY(actuator, upper_inertia_kg_m2, "2.11", 0.0, 1e4, "kg m^2", "ia: transverse, about the upper part's own mass centre"),
    LEG_KEY(actuator, lower_inertia_kg_m2, "3.58", 0.0, 1e4, "kg m^2", "ib: transverse, about the lower part's own mass centre"),
    LEG_KEY(actuator, upper_center_m, "0.70", 0.0, 10.0, "m", "ra: upper part's mass centre from the upper joint"),
    LEG_KEY(actuator, lower_center_m, "0.71", 0.0, 10.0, "m", "rb: lower part's mass centre from the lower joint"),

    KEY(hydraulics, supply_pa, "10e6", 1e5, 1e8, "Pa", "supply pressure, gauge"),
    KEY(hydraulics, tank_pa, "0", 0.0, 1e7, "Pa", "tank pressure, gauge"),
    LEG_KEY(hydraulics, valve_flow_m3_per_s, "1.57e-3", 1e-7, 1.0, "m^3/s", "per port, full opening, at valve_drop_pa"),
    KEY(hydraulics, valve_drop_pa, "5e6", 1e4, 1e8, "Pa", "pressure drop at which valve_flow_m3_per_s holds"),
    KEY(hydraulics, valve_frequency_hz, "100", 1.0, 500.0, "Hz", "natural frequency of the spool"),
    LEG_KEY(hydraulics, valve_damping, "0.8", 0.05, 5.0, "-", "damping ratio of the spool"),
    LEG_KEY(hydraulics, bulk_modulus_pa, "1.0e9", 1e7, 3e9, "Pa", "of the fluid"),
    LEG_KEY(hydraulics, dead_volume_m3, "1e-4", 1e-7, 0.1, "m^3", "of each side at its end of the stroke"),
    LEG_KEY(hydraulics, dead_volume_difference_m3, "0", -0.1, 0.1, "m^3", "dead volume of the rod side less dead_volume_m3"),
    KEY(hydraulics, pipe_length_m, "0", 0.0, 50.0, "m",
        "of the pipes between the valve, where the pressures are measured, and the chambers"),
    KEY(hydraulics, pipe_bore_m, "0.02", 0.003, 0.1, "m", "of these pipes"),
    LEG_KEY(hydraulics, leakage_m3_per_s_pa, "3e-11", 0.0, 1e-7, "m^3/(s Pa)", "across the piston; stands for valve lap too"),
    LEG_KEY(hydraulics, viscous_n_s_per_m, "2000", 0.0, 1e6, "N s/m", "viscous friction of a cylinder"),
    KEY(hydraulics, stop_stiffness_n_per_m, "2e7", 1e4, 1e9, "N/m", "end stops"),
    KEY(hydraulics, stop_damping_n_s_per_m, "2e4", 0.0, 1e6, "N s/m", "end stops"),

    KEY(sensors, enabled, "true", 0.0, 1.0, "-", "readings with resolution and noise, or exact"),
    KEY(sensors, position_resolution_m, "50e-6", 0.0, 0.01, "m", "of a leg length; 0: none"),
    KEY(sensors, adc_bits, "12", 4.0, 32.0, "-", "resolution of the pressure converter"),
    KEY(sensors, adc_range_v, "10", 0.1, 100.0, "V", "range of the pressure converter, either sign"),
    KEY(sensors, pressure_full_scale_pa, "16e6", 1e5, 1e9, "Pa", "at adc_range_v"),
    KEY(sensors, pressure_noise_v, "25e-3", 0.0, 1.0, "V", "peak to peak, uniform"),

    WORD(sim, engine, CONFIG_CHOICE, "ode", "rigid bodies of the simulation", engine_names),
    KEY(sim, substeps, "8", 1.0, 1000.0, "-", "per cycle; a substep is at most 0.25 ms"),
    KEY(sim, base_hz, "0", 0.0, 200.0, "Hz", "0: rigid base; else on springs, natural frequency of it with all that moves; ode only"),
    KEY(sim, base_mass_kg, "1000", 100.0, 1e6, "kg", "of the base on springs"),
    KEY(sim, ripple_pa, "0", 0.0, 1e7, "Pa", "amplitude of the pump's ripple on the supply; ode only"),
    KEY(sim, ripple_hz, "216", 0.1, 1000.0, "Hz", "of the ripple"),
    KEY(sim, smooth_friction_mps, "0", 0.0, 0.01, "m/s", "0: true stick; else cylinders' dry friction F tanh(v / this); closed_form only"),

    WORD(control, law, CONFIG_CHOICE, "pid",
         "pid: of each leg; model: feed-forward through the machine's dynamics besides (docs/control.md)", law_names),
    KEY(control, delay_s, "0", 0.0, 0.1, "s",
        "from the latching of a sample until its command reaches the valve, for the law model: one period on a field bus with SYNC"),
    KEY(control, kp, "40", 0.0, 1e4, "1/m", "proportional gain: valve command per length error"),
    KEY(control, ki, "20", 0.0, 1e5, "1/(m s)", "integral gain: valve command per length error and time"),
    KEY(control, kd, "0", 0.0, 1e3, "s/m", "derivative gain: valve command per rate of the length error"),
    KEY(control, modal, "0", 0.0, 1.0, "-",
        "kp, ki, kd of each mode of the oil: those of the slowest one, times (frequency / the slowest one's)^modal"),
    KEY(control, kff, "2", 0.0, 1e3, "s/m", "feed-forward gain: valve command per reference leg rate"),
    KEY(control, kpf, "2e-5", 0.0, 0.1, "1/N", "force feedback gain: valve command per high-passed leg force"),
    KEY(control, tf, "5e-3", 0.0, 10.0, "s", "time constant of the derivative's low-pass"),
    KEY(control, tp, "50e-3", 0.0, 100.0, "s", "time constant of the force's high-pass, which takes the static force off"),
    KEY(control, integral_limit, "0.3", 0.0, 1.0, "-", "limit of the integral part, of full opening"),
    KEY(control, output_limit, "1", 0.01, 1.0, "-", "limit of the valve command, of full opening"),

    KEY(motion, engage_s, "6", 0.1, 600.0, "s",
        "move from the parked to the neutral pose; longer where rate_mps or accel_mps2 asks for it"),
    KEY(motion, park_s, "6", 0.1, 600.0, "s", "move from the neutral to the parked pose; the same"),
    KEY(motion, rate_mps, "0.42", 0.001, 5.0, "m/s", "fastest of a move, whatever distance and duration are asked for"),
    KEY(motion, accel_mps2, "1.1", 0.01, 50.0, "m/s^2", "greatest acceleration of a move"),
    KEY(motion, park_z_m, "0.45", 0.0, 10.0, "m", "z, down, at which the platform is put down"),
    KEY(motion, rest_s, "0", 0.0, 600.0, "s", "at rest before the supply is asked for without a command: the pressures read their zeros"),
    KEY(motion, hold_s, "2", 0.0, 600.0, "s", "at neutral before the first test and after the last"),
    KEY(motion, automatic, "true", 0.0, 1.0, "-", "engage, test and park without commands"),

    LEG_KEY(limits, length_min_m, "1.425", 0.01, 30.0, "m", "shortest length of a leg"),
    LEG_KEY(limits, length_max_m, "2.240", 0.01, 30.0, "m", "longest length of a leg"),
    KEY(limits, leg_rate_mps, "0.6", 0.001, 10.0, "m/s", "fastest leg"),
    KEY(limits, following_m, "0.01", 1e-4, 1.0, "m", "leg reference against leg length while engaged"),
    KEY(limits, standstill_m, "0.002", 1e-4, 1.0, "m", "range of the leg's reference since the length last changed"),
    KEY(limits, force_n, "15000", 1.0, 1e7, "N", "of a leg, either sign"),
    KEY(limits, sensor_age_s, "0.01", 1e-4, 1.0, "s", "oldest sample to act upon"),
    KEY(limits, pressure_min_pa, "-2e5", -1e7, 1e8, "Pa", "lowest plausible reading"),
    KEY(limits, pressure_max_pa, "16.5e6", 1e4, 1e9, "Pa", "highest plausible reading"),
    KEY(limits, bad_cycles, "5", 1.0, 1000.0, "-", "a fault: so many bad cycles more than good ones"),
    KEY(limits, blind_time_s, "0.1", 0.01, 10.0, "s",
        "longest time that the machine may move without a living controller; more than 0.1 is for tests without a machine"),
    KEY(limits, oscillation_mps2, "1", 0.1, 1000.0, "m/s^2",
        "acceleration of the platform beyond 1.8 times what is asked for, rms over a quarter of a second"),

    KEY(interlocks, emergency_stop, "true", 0.0, 1.0, "-", "an input says that the emergency stop's chain is closed"),
    KEY(interlocks, enable, "true", 0.0, 1.0, "-", "an input says that the enable switch is held"),
    KEY(interlocks, door, "true", 0.0, 1.0, "-", "an input says that the door is closed"),
    KEY(interlocks, pressure, "true", 0.0, 1.0, "-", "an input says that the supply has pressure"),
    KEY(interlocks, supply, "true", 0.0, 1.0, "-", "an output, changing every cycle, keeps the supply on through a relay of the machine"),
    KEY(interlocks, pressure_s, "5", 0.1, 60.0, "s", "pressure comes within this; without that input: the wait for it"),
    KEY(interlocks, antivalent, "true", 0.0, 1.0, "-", "each input has two contacts, the second one inverse in bits 4 to 7; false: one"),
    KEY(interlocks, discrepancy_s, "0.1", 0.002, 1.0, "s", "the two contacts of an input may contradict each other for so long"),

    WORD(tests, order, CONFIG_AXES, "[x, y, z, phi, theta, psi]", "axes to test, in turn", dof_names),
    AXES_KEY("frequency_hz", hz[DOF_X], DOFS, "4", TESTS_LEAST_HZ, TESTS_MOST_HZ, "Hz",
             "below the lowest open-loop rigid eigenfrequency; one for all, or of x, y, z, phi, theta, psi"),
    AXES_KEY("amplitude_m", amplitude[DOF_X], 3, "0.004", TESTS_LEAST_AMPLITUDE, TESTS_MOST_M, "m", "one for all, or of x, y, z"),
    AXES_KEY("amplitude_rad", amplitude[DOF_PHI], 3, "0.006", TESTS_LEAST_AMPLITUDE, TESTS_MOST_RAD, "rad",
             "one for all, or of phi, theta, psi"),
    KEY(tests, settle_s, "3", 0.0, 600.0, "s", "at rest before the ramp-in"),
    KEY(tests, ramp_s, "1", 0.0, 600.0, "s", "ramp-in"),
    KEY(tests, duration_s, "5", 0.01, 3600.0, "s", "evaluated part"),
    KEY(tests, ramp_out_s, "0.5", 0.0, 600.0, "s", "ramp-out"),
    KEY(tests, multisine, "false", 0.0, 1.0, "-", "all axes of tests.order at once, in one test: for method C"),
    WORD(tests, trajectory, CONFIG_TEXT, "", "CSV file of poses over time, driven instead of sinusoids; empty: none", NULL),
    KEY(tests, repeat, "1", 1.0, 100000.0, "-", "passes of the trajectory"),
    KEY(tests, harmonics, "5", 1.0, 6.0, "-", "regressed, the fundamental included"),

    KEY(checks, amplitude_pct, "10", 0.01, 100.0, "%", "achieved against commanded amplitude"),
    KEY(checks, unwanted_pct, "10", 0.01, 1000.0, "%", "motion of the other axes"),
    KEY(checks, overruns_pct, "1", 0.0, 100.0, "%", "of the cycles"),
    KEY(checks, excluded_pct, "1", 0.0, 100.0, "%", "of the evaluated samples"),
    KEY(checks, length_wander_m, "1e-4", 1e-7, 1.0, "m", "range of the fundamental of a leg's length over the periods of a test"),
    KEY(checks, reference_off_m, "0.003", 1e-6, 1.0, "m", "of a leg from its reference on average over a test"),
    KEY(checks, force_wander_n, "60", 0.1, 1e6, "N", "range of a leg's mean force, and of its fundamental, over the periods of a test"),
    KEY(checks, period_s, "0.003", 1e-4, 1.0, "s", "of the loop: a longer cycle puts the command's staircase into the matrix"),
    KEY(checks, symmetry_pct, "10", 0.01, 1000.0, "%",
        "|Mt - Mt'|, and methods A and B against C where that passes, by the root of the diagonal's product"),

    KEY(qualify, up_to_hz, "2", 0.1, 20.0, "Hz", "amplitude, phase, cross-talk, harmonics and noise are judged up to here"),
    KEY(qualify, amplitude_pct, "0", 0.0, 100.0, "%", "amplitude of an axis off its reference"),
    KEY(qualify, phase_deg, "0", 0.0, 360.0, "deg", "phase of an axis"),
    KEY(qualify, cross_talk_pct, "0", 0.0, 100.0, "%", "motion of another axis, angles at the upper joints"),
    KEY(qualify, harmonics_pct, "0", 0.0, 1000.0, "%", "acceleration at harmonics 2 and 3 against the tone's"),
    KEY(qualify, noise_pct, "0", 0.0, 1000.0, "%", "acceleration up to 20 Hz that is no harmonic, against the tone's"),
    KEY(qualify, rest_mps2, "0", 0.0, 100.0, "m/s^2", "rms acceleration at rest, 0.2 to 20 Hz"),
    KEY(qualify, turn_around_mps2, "0", 0.0, 100.0, "m/s^2", "peak acceleration beside the tone where a 0.5 Hz sine turns"),
    KEY(qualify, threshold_m, "0", 0.0, 1.0, "m", "way from rest until half of it is followed"),
    KEY(qualify, hysteresis_m, "0", 0.0, 1.0, "m", "width of the loop of a slow triangle"),
    KEY(qualify, dead_s, "0", 0.0, 10.0, "s", "delay at a tenth of a step"),
    KEY(qualify, balance_pct, "0", 0.0, 100.0, "%", "a leg against the mean of all, in z at 0.5 Hz"),
    KEY(qualify, excursion_m, "0", 0.0, 10.0, "m", "reached at least on every axis"),
    KEY(qualify, rate_mps, "0", 0.0, 10.0, "m/s", "reached at least on every axis"),
    KEY(qualify, accel_mps2, "0", 0.0, 100.0, "m/s^2", "reached at least on every axis"),
    KEY(qualify, repeat_mps2, "0", 0.0, 100.0, "m/s^2", "change of a tone from --baseline, as an acceleration"),

    TOLERANCE(mass, "0.01", "of masses and inertias, relative"),
    TOLERANCE(viscous, "0.05", "of viscous friction"),
    TOLERANCE(bulk_modulus, "0.05", "of the oil's bulk modulus"),
    TOLERANCE(leakage, "0.05", "of internal leakage"),
    TOLERANCE(valve_gain, "0.05", "of the valves' flow"),
    KEY(model.tolerance, rigidity, "0.001", 1e-6, 1.0, "-",
        "how far the payload is from one rigid body, standard deviation as a share of sqrt(M_ii M_jj); 1: method C's matrix is free"),
    KEY(model.tolerance, joints_m, "0.0005", 0.0, 0.05, "m", "of each coordinate of each joint: drawing and assembly"),
    KEY(model.tolerance, pressure_gain, "0.005", 0.0, 0.1, "-",
        "of each pressure sensor's gain: the standard deviation, about half of a data sheet's greatest error"),
    KEY(model.tolerance, pressure_zero, "0.005", 0.0, 0.1, "-",
        "of each pressure sensor's zero, standard deviation as a share of sensors.pressure_full_scale_pa: for `hexid gap`"),
    KEY(model.tolerance, pressure_drift_pa, "1000", 0.0, 1e6, "Pa",
        "of a pressure sensor's zero from one log to the next, standard deviation: for `hexid identify --weight`"),
    KEY(model.tolerance, length_gain, "0.001", 0.0, 0.1, "-", "of each position sensor's gain, standard deviation"),
    KEY(model.tolerance, length_zero_m, "0.001", 0.0, 0.1, "m", "of each position sensor's zero, standard deviation"),
    KEY(model.tolerance, skew_s, "0.0005", 0.0, 0.1, "s", "of the time between lengths and pressures of one sample, standard deviation"),
    KEY(model.tolerance, skew_test_s, "0.001", 0.0, 0.1, "s",
        "how far a test's skew is from that of all tests, the largest standard deviation; method C finds the real one; needs skew_s"),
    KEY(model.tolerance, pressure_lag_s, "0.001", 0.0, 0.1, "s",
        "of the pressure sensors' lag, standard deviation; each leg's own is half of that about the common one"),
    KEY(model.tolerance, pipe_m, "0.3", 0.0, 50.0, "m",
        "of hydraulics.pipe_length_m, standard deviation; each leg's own is half of that about the common one"),
    KEY(model.tolerance, compliance_m_per_n, "2e-8", 0.0, 1e-5, "m/N",
        "how far a leg gives under force between its position sensor and its joints, the largest standard deviation; 2e-8 is 50 N/um"),
    KEY(model.tolerance, springs_n_per_m, "0", 0.0, 1e7, "N/m",
        "of hoses and cables on x, y, z, so stiff at most; 0: there are none. Method C estimates them"),
    KEY(model.tolerance, springs_nm_per_rad, "0", 0.0, 1e7, "N m/rad", "the same on phi, theta, psi"),

    LEG_KEY(found, weight_p1, "0", -100.0, 100.0, "-", "change of a known weight's reading by a gain of P1, both relative"),
    LEG_KEY(found, weight_p2, "0", -100.0, 100.0, "-", "the same of P2"),
    KEY(found, weight_error, "0", -0.5, 0.5, "-", "by how much the weight read too much, relative"),
    KEY(found, weight_std, "0", 0.0, 0.5, "-", "standard deviation of weight_error; 0: nothing was weighed"),
    LEG_KEY(found, retracted_m, "0", -1.0, 1.0, "m", "reading of a leg on its lower end stop less its length there"),
    KEY(found, retracted_std_m, "0", 0.0, 0.05, "m", "standard deviation of found.retracted_m; 0: not found"),

    KEY(loop, period_s, "0.002", 1e-4, 0.1, "s", "of the control loop"),
    KEY(loop, priority, "80", 1.0, 99.0, "-", "SCHED_FIFO"),
    KEY(loop, cpu, "-1", -1.0, 1023.0, "-", "to pin the loop to; -1: none"),
    KEY(loop, overrun_limit, "10", 1.0, 100000.0, "-", "so many deadlines missed in a row are a fault"),

    KEY(security, confine, "true", 0.0, 1.0, "-", "once all is open: no programs, no files, no rights but what the loop needs"),

    WORD(machine, name, CONFIG_TEXT, "",
         "by which commands find this hexid, 1 to 32 of A-Z a-z 0-9 - _; empty: hexid, or the first free one of hexid-2, hexid-3, ...",
         NULL),

    WORD(lcm, url, CONFIG_TEXT, "udpm://239.255.76.67:7667?ttl=0", "provider; empty: none; ttl=0 stays on the host", NULL),
    KEY(lcm, state_every, "10", 1.0, 1e6, "-", "one HEXID_STATE on the wire for so many cycles"),
    KEY(lcm, commands, "false", 0.0, 1.0, "-", "accept commands that move; stop and park are always accepted"),
    KEY(lcm, lease_s, "5", 0.0, 60.0, "s",
        "an operator who engaged by command is heard so often, or the platform is parked; 0: not watched"),
    WORD(lcm, remote_stop, CONFIG_TEXT, "",
         "addresses of other hosts, as 10.0.0.7 10.0.0.8, whose stop and park (hexid_command_t) are taken; empty: none", NULL),

    CHANNEL(length_channel, "m", "0", "1e6", "0", "1", "0.01", "30"),
    CHANNEL(p1_channel, "Pa", "0", "1000", "0", "1e6", "-2e5", "32e6"),
    CHANNEL(p2_channel, "Pa", "0", "1000", "0", "1e6", "-2e5", "32e6"),
    CHANNEL(valve_channel, "-", "-32767", "32767", "-1", "1", "-1", "1"),

    KEY(device, watchdog_s, "0.02", 0.002, 10.0, "s", "without a command for so long a device centres its valve"),

    KEY(can, bitrate_bps, "1e6", 1e4, 1e6, "bit/s", "of the bus: what the load is computed with"),
    KEY(can, heartbeat_s, "0.05", 0.005, 5.0, "s", "sent by every node and the daemon; three missing: lost"),
    KEY(can, device_type, "408", -1.0, 4294967295.0, "-", "of every axis node (object 0x1000); -1: not checked"),
    KEY(can, vendor_id, "0", -1.0, 4294967295.0, "-", "of every axis node (0x1018:1); -1: not checked"),
    KEY(can, product_code, "1213745476", -1.0, 4294967295.0, "-", "of every axis node (0x1018:2), hexid's is \"HXID\"; -1: not checked"),
    KEY(can, io_device_type, "197009", -1.0, 4294967295.0, "-", "of the I/O module, node 7 (object 0x1000); -1: not checked"),
    KEY(can, io_vendor_id, "0", -1.0, 4294967295.0, "-", "of the I/O module (0x1018:1); -1: not checked"),
    KEY(can, io_product_code, "1213745487", -1.0, 4294967295.0, "-", "of the I/O module (0x1018:2), hexid's is \"HXIO\"; -1: not checked"),

    KEY(modbus, unit, "1", 1.0, 247.0, "-", "unit (slave) address of the device"),
};
enum { KEYS = sizeof keys / sizeof keys[0] };

static const char *const sections[][2] = {
    {"geometry", "Joints: Tian 2015 Table 1"},
    {"payload", "Platform and load: Tian 2015 Table 2"},
    {"axis", "One axis with a mass, for mechanism axis: position, and force or pressures, no pose"},
    {"actuator", "The legs, Tian 2015 Tables 1 and 2; of a leg: one number for all, or a list of six"},
    {"hydraulics", "Valve, fluid and cylinder of the simulated machine; of a leg: one number for all, or a list of six"},
    {"sensors", "Sensors, real or simulated"},
    {"sim", "Simulation"},
    {"control", "Leg controller; valve from -1 to 1"},
    {"motion", "Engaging and parking"},
    {"limits", "SAFETY: beyond any of these the platform is stopped (docs/safety.md, What can fail)"},
    {"interlocks", "SAFETY: which inputs and outputs the machine has; what is not wired is not watched"},
    {"tests", "Six sinusoidal tests, or another motion"},
    {"checks",
     "Beyond any of these a verdict is fail: amplitude, unwanted motion, period and symmetry judge methods A and B, the others the run"},
    {"qualify", "Limits for what `hexid qualify` measures; 0: none, not evaluated; angles count as lengths at the upper joints"},
    {"model", "The model against which hexid gap measures"},
    {"model.tolerance",
     "How far the model's parameters may be off, relative (joints: m), each leg for itself, without that being a finding"},
    {"found", "What `hexid identify -o` found about the sensors of this machine; the loop reads past it"},
    {"loop", "Real-time loop"},
    {"security", "What the running daemon may ask of the system"},
    {"machine", "This machine among those of this host"},
    {"lcm", "Messages"},
    {"length_channel", "Leg length on the field bus: raw value <-> SI"},
    {"p1_channel", "Rodless-side pressure on the field bus: raw value <-> SI"},
    {"p2_channel", "Rod-side pressure on the field bus: raw value <-> SI"},
    {"valve_channel", "Valve command on the field bus: raw value <-> SI"},
    {"device", "Devices at the field end"},
    {"can", "CAN bus"},
    {"modbus", "Modbus"},
    {"effects", "Effects of the plant: one number for all legs, or a list of six"},
};

static void effect_key_make(int effect, int k, struct config_key *key) {
    const struct effect_key *e = &effect_table[effect]->keys[k];
    *key = (struct config_key){.kind = e->per_leg ? CONFIG_REALS : CONFIG_REALS_ALIKE,
                               .count = LEGS,
                               .offset = offsetof(struct params, effects) + (size_t)effect * sizeof(struct effect_values) +
                                         offsetof(struct effect_values, value) + (size_t)k * sizeof(double[LEGS]),
                               .min = e->min,
                               .max = e->max,
                               .unit = e->unit,
                               .meaning = effect_table[effect]->law,
                               .shapes_law = e->shapes_law,
                               .effect = effect};
    snprintf(key->path, sizeof key->path, "effects.%.40s.%.28s", effect_table[effect]->name, e->name);
    char neutral[NUMBER_SIZE];
    snprintf(key->value, sizeof key->value, "%s", number_shortest(e->neutral, neutral));
}

bool config_key_at(int index, struct config_key *key) {
    if (index < KEYS) {
        *key = keys[index];
        return true;
    }
    index -= KEYS;
    for (int e = 0; e < EFFECTS_MAX && effect_table[e]; e++)
        for (int k = 0; k < EFFECT_KEYS && effect_table[e]->keys[k].name; k++)
            if (index-- == 0) {
                effect_key_make(e, k, key);
                return true;
            }
    return false;
}

bool config_key_find(const char *path, struct config_key *key) {
    int i = 0;
    while (i < KEYS && strcmp(keys[i].path, path) != 0) i++;
    for (; config_key_at(i, key); i++)
        if (strcmp(key->path, path) == 0) return true;
    return false;
}

const char *config_section_title(const char *path) {
    static const char effects[] = "effects.";
    for (size_t i = 0; i < sizeof sections / sizeof sections[0]; i++)
        if (strcmp(sections[i][0], path) == 0) return sections[i][1];
    int effect = strncmp(path, effects, strlen(effects)) == 0 ? effect_find(path + strlen(effects)) : -1;
    return effect >= 0 ? effect_table[effect]->law : NULL;
}

static const char *last_part(const char *path) {
    const char *dot = strrchr(path, '.');
    return dot ? dot + 1 : path;
}

/* Takes the candidate if it is nearer to `path` than the nearest so far. A path without a section
 * is compared with the last part of the candidate. */
static void consider(const char *path, const char *candidate, int *best, char nearest[CONFIG_PATH_SIZE]) {
    const char *compared = strchr(path, '.') ? candidate : last_part(candidate);
    /* the difference of the lengths is a lower bound of the distance */
    if (abs((int)strlen(path) - (int)strlen(compared)) >= *best) return;
    int distance = edit_distance(path, compared);
    if (distance >= *best) return;
    *best = distance;
    snprintf(nearest, CONFIG_PATH_SIZE, "%s", candidate);
}

void config_key_nearest(const char *path, char nearest[CONFIG_PATH_SIZE]) {
    struct config_key key;
    char section[CONFIG_PATH_SIZE];
    int best = edit_distance_too_far(path);
    nearest[0] = '\0';
    for (size_t i = 0; i < sizeof sections / sizeof sections[0]; i++) consider(path, sections[i][0], &best, nearest);
    for (int i = 0; config_key_at(i, &key); i++) {
        if (key.effect >= 0) {
            snprintf(section, sizeof section, "effects.%.60s", effect_table[key.effect]->name);
            consider(path, section, &best, nearest);
        }
        consider(path, key.path, &best, nearest);
    }
}

void config_default(struct params *params) {
    struct config_key key;
    struct config_value value;
    char reason[CONFIG_REASON_SIZE];
    memset(params, 0, sizeof *params);
    for (int i = 0; config_key_at(i, &key); i++) {
        bool good = config_value_split(&key, key.value, &value) && config_value_set(&key, &value, params, reason);
        assert(good); /* a default must be in its own range */
        (void)good;
    }
    for (int e = 0; e < EFFECTS_MAX; e++) params->effects[e].on = false;
}
