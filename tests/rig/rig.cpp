#include "rig.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <sstream>
#include <stdexcept>

constexpr double kPi = 3.14159265358979323846;
constexpr double kNullBias = 0.005;    /* share of full opening: largest null bias drawn */
constexpr double kJointError = 0.5e-3; /* m */
constexpr double kJitterShare =
    1.0 / 500; /* share of samples that arrive one period late, in the series beyond tolerance */
constexpr double kBaseDamping = 0.03; /* damping ratio of the base plate on its spring */
constexpr double kModeDamping = 0.03; /* damping ratio of the payload's part on springs */
constexpr double kLeakageDrop = 1e6; /* Pa, at which turbulent leakage is stated */
constexpr double kSloshDamping = 0.03; /* damping ratio of a liquid's surface */
constexpr double kFloorHz = 60, kFloorDamping = 0.3; /* a liquid is nearly rigid downwards */

const char *const kAxes[6] = {"x", "y", "z", "phi", "theta", "psi"};

/* position_sensor_scale.zero_m is counted from the neutral length. */
// clang-format off
const std::map<std::string, double> kEffects = {
    {"cylinder_coulomb_friction.force_extend_n", 0},
    {"cylinder_coulomb_friction.force_retract_n", 0},
    {"cylinder_dahl_friction.force_extend_n", 0}, {"cylinder_dahl_friction.force_retract_n", 0},
    {"cylinder_dahl_friction.distance_m", 2e-4}, {"cylinder_stribeck_friction.excess_n", 0},
    {"cylinder_stribeck_friction.velocity_mps", 0.01},
    {"cylinder_viscous_friction.extend_n_s_per_m", 0},
    {"cylinder_viscous_friction.retract_n_s_per_m", 0}, {"load_dependent_friction.mu", 0},
    {"passive_joint_friction.coulomb_nm", 0}, {"passive_joint_friction.viscous_nm_s", 0},
    {"payload_mass.mass_kg", 0}, {"payload_center_of_mass.x_m", 0},
    {"payload_center_of_mass.y_m", 0}, {"payload_center_of_mass.z_m", 0},
    {"payload_rotational_inertia.xx", 0}, {"payload_rotational_inertia.yy", 0},
    {"payload_rotational_inertia.zz", 0}, {"actuator_inertia.upper_mass_kg", 0},
    {"actuator_inertia.lower_mass_kg", 0}, {"actuator_inertia.transverse_kg_m2", 0},
    {"external_stiffness.x", 0}, {"external_stiffness.y", 0}, {"external_stiffness.z", 0},
    {"external_stiffness.phi", 0}, {"external_stiffness.theta", 0}, {"external_stiffness.psi", 0},
    {"joint_backlash.clearance_m", 0}, {"geometry_error.a_x_m", 0}, {"geometry_error.a_y_m", 0},
    {"geometry_error.a_z_m", 0}, {"geometry_error.b_x_m", 0}, {"geometry_error.b_y_m", 0},
    {"geometry_error.b_z_m", 0}, {"base_tilt.phi_rad", 0}, {"base_tilt.theta_rad", 0},
    {"valve_dead_band.overlap", 0}, {"valve_hysteresis.width", 0}, {"valve_lag.frequency_hz", 0},
    {"valve_rate_limit.per_s", 0}, {"valve_flow_gain.scale", 1}, {"valve_null_bias.offset", 0},
    {"port_area_ratio.ratio", 1}, {"internal_leakage.scale", 1},
    {"entrained_air.bulk_modulus_pa", 0}, {"supply_pressure_sag.resistance_pa_s_per_m3", 0},
    {"tank_back_pressure.resistance_pa_s_per_m3", 0}, {"pipeline_dynamics.length_m", 0},
    {"pipeline_dynamics.diameter_m", 0.012}, {"pressure_sensor_scale.p1", 1},
    {"pressure_sensor_scale.p2", 1}, {"pressure_sensor_offset.p1", 0},
    {"pressure_sensor_offset.p2", 0}, {"position_sensor_scale.scale", 1},
    {"position_sensor_scale.zero_m", 0}, {"position_sensor_offset.offset_m", 0},
    {"pressure_sensor_lag.cutoff_hz", 0}, {"position_sensor_delay.delay_s", 0},
    {"command_delay.delay_s", 0}, {"clock_skew.ratio", 1}, {"base_spring.frequency_hz", 0},
    {"base_spring.mass_kg", 1000}, {"payload_mode.frequency_hz", 0}, {"payload_mode.mass_kg", 20},
    {"leg_compliance.m_per_n", 0}, {"pressure_sensor_delay.delay_s", 0}, {"pump_ripple.pressure_pa", 0},
    {"pump_ripple.frequency_hz", 216}, {"bristle_friction.force_n", 0},
    {"bristle_friction.excess_n", 0}, {"bristle_friction.velocity_mps", 0.01},
    {"bristle_friction.give_m", 1e-4}, {"bristle_friction.damping_n_s_per_m", 0},
    {"cylinder_stribeck_friction.exponent", 2}, {"uneven_friction.force_n", 0},
    {"uneven_friction.share", 0.1}, {"uneven_friction.wavelength_m", 0.04},
    {"uneven_friction.phase_rad", 0}, {"rounded_hysteresis.width", 0},
    {"turbulent_leakage.flow_m3_per_s", 0}, {"valve_kink.opening", 0.05}, {"valve_kink.gain", 1},
    {"loose_piston.clearance_m", 0}, {"loose_piston.mass_kg", 3},
    {"pressure_sensor_drift.p1_pa_per_s", 0}, {"pressure_sensor_drift.p2_pa_per_s", 0},
    {"sloshing.mass_kg", 0}, {"sloshing.frequency_hz", 1}, {"warming_friction.force_n", 0},
    {"warming_friction.time_s", 20}, {"warming_friction.left", 0.5},
}; // clang-format on

double Random::uniform(double low, double high)
{
    uint64_t z = (state += 0x9E3779B97F4A7C15ull); /* splitmix64 */
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return low + (high - low) * static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static std::vector<std::string> split(const std::string &text, char at)
{
    std::vector<std::string> parts;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, at);)
        parts.push_back(part);
    return parts;
}

double effect(const Setup &setup, const std::string &key, int leg)
{
    const auto found = setup.effects.find(key);
    return found != setup.effects.end() ? found->second[leg] : kEffects.at(key);
}

void set_effect(Effects &effects, const std::string &assignment)
{
    const size_t at = assignment.find('=');
    const std::string key = assignment.substr(0, at);
    if (at == std::string::npos || !kEffects.count(key))
        throw std::runtime_error("no such effect: '" + key + "'");
    const auto parts = split(assignment.substr(at + 1), ',');
    if (parts.size() != 1 && parts.size() != kLegs)
        throw std::runtime_error(key + ": one number, or six");
    Vec6 &values = effects[key];
    for (int i = 0; i < kLegs; i++)
        values[i] = number(parts[parts.size() == 1 ? 0 : i]);
}

Vec6 leg_lengths(const Points &a, const Points &b, const Vec6 &pose)
{
    const Eigen::Matrix3d T =
        (Eigen::AngleAxisd(pose[5], Vec3::UnitZ()) * Eigen::AngleAxisd(pose[4], Vec3::UnitY()) *
         Eigen::AngleAxisd(pose[3], Vec3::UnitX()))
            .toRotationMatrix();
    return ((T * a - b).colwise() + Vec3(pose.head<3>())).colwise().norm().transpose();
}

/* Draws uniformly within the stated tolerance, each leg separately; the series beyond it follows
 * docs/gap.md (How it is proved). */
Base draw_base(const Setup &setup)
{
    Base base;
    for (Vec6 *v : {&base.viscous, &base.bulk, &base.leakage, &base.gain, &base.dead1, &base.dead2,
                    &base.damping})
        v->setOnes();
    base.null_bias.setZero();
    base.a.setZero();
    base.b.setZero();
    const bool beyond = setup.beyond_seed >= 0;
    if (!beyond && setup.tolerance_seed < 0)
        return base;

    Random random(static_cast<uint64_t>(beyond ? setup.beyond_seed : setup.tolerance_seed));
    const Settings &s = setup.settings;
    auto about = [&](double one, double share) { return one + random.uniform(-share, share); };
    const double mass = s.at("model.tolerance.mass");
    base.payload = about(1, mass);
    base.upper = about(1, mass);
    base.lower = about(1, mass);
    for (int i = 0; i < kLegs; i++) {
        base.viscous[i] = about(1, s.at("model.tolerance.viscous"));
        base.bulk[i] = about(1, s.at("model.tolerance.bulk_modulus"));
        base.leakage[i] = about(1, s.at("model.tolerance.leakage"));
        base.gain[i] = about(1, s.at("model.tolerance.valve_gain"));
        base.dead1[i] = about(1, beyond ? 0.30 : 0.05);
        base.dead2[i] = about(1, beyond ? 0.30 : 0.05);
        base.null_bias[i] = about(0, kNullBias);
    }
    if (!beyond)
        return base;
    base.supply = about(1, 0.02);
    for (int i = 0; i < kLegs; i++) {
        base.damping[i] = about(1, 0.20);
        for (int k = 0; k < 3; k++) {
            base.a(k, i) = about(0, kJointError);
            base.b(k, i) = about(0, kJointError);
        }
    }
    base.jitter = true;
    return base;
}

MachineParameters make_parameters(const Setup &setup, const Base &base)
{
    const Settings &s = setup.settings;
    auto fx = [&](const char *key, int leg = 0) { return effect(setup, key, leg); };
    MachineParameters p{};

    BodyParameters &b = p.bodies;
    b.payload_kg = s.at("payload.mass_kg") * base.payload + fx("payload_mass.mass_kg");
    b.payload_center << fx("payload_center_of_mass.x_m"), fx("payload_center_of_mass.y_m"),
        fx("payload_center_of_mass.z_m");
    auto inertia = [&](const char *axes) {
        return s.at(std::string("payload.inertia_") + axes + "_kg_m2") * base.payload;
    };
    b.payload_inertia << inertia("xx"), inertia("xy"), inertia("xz"), inertia("xy"), inertia("yy"),
        inertia("yz"), inertia("xz"), inertia("yz"), inertia("zz");
    b.payload_inertia.diagonal() +=
        Vec3(fx("payload_rotational_inertia.xx"), fx("payload_rotational_inertia.yy"),
             fx("payload_rotational_inertia.zz"));
    b.upper_kg = s.legs("actuator.upper_mass_kg") * base.upper;
    b.lower_kg = s.legs("actuator.lower_mass_kg") * base.lower;
    b.upper_inertia = s.legs("actuator.upper_inertia_kg_m2") * base.upper;
    b.lower_inertia = s.legs("actuator.lower_inertia_kg_m2") * base.lower;
    b.upper_center = s.legs("actuator.upper_center_m");
    b.lower_center = s.legs("actuator.lower_center_m");
    b.a = upper_joints(s) + base.a;
    b.b = lower_joints(s) + base.b;
    const double phi = fx("base_tilt.phi_rad"), theta = fx("base_tilt.theta_rad");
    b.gravity =
        s.at("payload.gravity_mps2") *
        Vec3(-std::sin(theta), std::sin(phi) * std::cos(theta), std::cos(phi) * std::cos(theta));

    const double hz = fx("base_spring.frequency_hz"), plate = fx("base_spring.mass_kg");
    b.base_moves = hz > 0;
    b.base_kg = plate;
    p.base_stiffness = plate * std::pow(2 * kPi * hz, 2);
    p.base_damping = 2 * kBaseDamping * plate * 2 * kPi * hz;

    const double mode_hz = fx("payload_mode.frequency_hz"), liquid = fx("sloshing.mass_kg");
    const bool mode = mode_hz > 0, sloshes = liquid > 0;
    if (mode && sloshes)
        throw std::runtime_error("payload_mode or sloshing, not both");
    p.mode_kg = mode ? fx("payload_mode.mass_kg") : liquid;
    const double slosh_hz = fx("sloshing.frequency_hz");
    const Vec3 omega =
        2 * kPi * (sloshes ? Vec3(slosh_hz, slosh_hz, kFloorHz) : Vec3::Constant(mode_hz));
    const Vec3 ratio =
        sloshes ? Vec3(kSloshDamping, kSloshDamping, kFloorDamping) : Vec3::Constant(kModeDamping);
    p.mode_stiffness = p.mode_kg * omega.cwiseAbs2();
    p.mode_damping = 2 * p.mode_kg * ratio.cwiseProduct(omega);
    b.payload_kg -= p.mode_kg;
    if (!(b.payload_kg > 0))
        throw std::runtime_error("payload_mode, sloshing: less mass than the payload has");

    p.supply = s.at("hydraulics.supply_pa") * base.supply;
    p.tank = s.at("hydraulics.tank_pa");
    p.supply_resistance = fx("supply_pressure_sag.resistance_pa_s_per_m3");
    p.tank_resistance = fx("tank_back_pressure.resistance_pa_s_per_m3");
    p.ripple = fx("pump_ripple.pressure_pa");
    p.ripple_hz = fx("pump_ripple.frequency_hz");
    p.stop_stiffness = s.at("hydraulics.stop_stiffness_n_per_m");
    p.stop_damping = s.at("hydraulics.stop_damping_n_s_per_m");
    p.step = setup.step_s;
    for (int k = 0; k < 6; k++)
        p.stiffness[k] = effect(setup, std::string("external_stiffness.") + kAxes[k]);

    const Vec6 neutral = leg_lengths(upper_joints(s), lower_joints(s), Vec6::Zero());
    const Vec6 piston = s.legs("actuator.piston_diameter_m");
    const Vec6 rod = s.legs("actuator.rod_diameter_m");
    const Vec6 stroke = s.legs("actuator.stroke_m"), mid_stroke = s.legs("actuator.mid_stroke_m");
    for (int i = 0; i < kLegs; i++) {
        b.a.col(i) += Vec3(fx("geometry_error.a_x_m", i), fx("geometry_error.a_y_m", i),
                           fx("geometry_error.a_z_m", i));
        b.b.col(i) += Vec3(fx("geometry_error.b_x_m", i), fx("geometry_error.b_y_m", i),
                           fx("geometry_error.b_z_m", i));
        b.upper_kg[i] += fx("actuator_inertia.upper_mass_kg", i);
        b.lower_kg[i] += fx("actuator_inertia.lower_mass_kg", i);
        b.lower_inertia[i] += fx("actuator_inertia.transverse_kg_m2", i);

        LegParameters &l = p.leg[i];
        l.area1 = kPi / 4 * piston[i] * piston[i];
        l.area2 = kPi / 4 * (piston[i] * piston[i] - rod[i] * rod[i]);
        l.middle = neutral[i] + mid_stroke[i];
        l.half_stroke = stroke[i] / 2;
        l.dead1 = s.at("hydraulics.dead_volume_m3", i) * base.dead1[i];
        l.dead2 = s.at("hydraulics.dead_volume_m3", i) * base.dead2[i];
        const double air = fx("entrained_air.bulk_modulus_pa", i);
        l.bulk = air > 0 ? air : s.at("hydraulics.bulk_modulus_pa", i) * base.bulk[i];
        l.leakage = s.at("hydraulics.leakage_m3_per_s_pa", i) * base.leakage[i] *
                    fx("internal_leakage.scale", i);
        l.gain_a = s.at("hydraulics.valve_flow_m3_per_s", i) /
                   std::sqrt(s.at("hydraulics.valve_drop_pa")) * base.gain[i] *
                   fx("valve_flow_gain.scale", i);
        l.gain_b = l.gain_a * fx("port_area_ratio.ratio", i);
        const double lag = fx("valve_lag.frequency_hz", i);
        l.valve_omega = 2 * kPi * (lag > 0 ? lag : s.at("hydraulics.valve_frequency_hz"));
        l.valve_damping = s.at("hydraulics.valve_damping") * base.damping[i];
        l.rate_limit = fx("valve_rate_limit.per_s", i);
        l.null_bias = base.null_bias[i] + fx("valve_null_bias.offset", i);
        l.overlap = fx("valve_dead_band.overlap", i);
        l.hysteresis = fx("valve_hysteresis.width", i);
        const double viscous = s.at("hydraulics.viscous_n_s_per_m", i) * base.viscous[i];
        l.viscous_extend = viscous + fx("cylinder_viscous_friction.extend_n_s_per_m", i);
        l.viscous_retract = viscous + fx("cylinder_viscous_friction.retract_n_s_per_m", i);
        l.coulomb_extend = fx("cylinder_coulomb_friction.force_extend_n", i);
        l.coulomb_retract = fx("cylinder_coulomb_friction.force_retract_n", i);
        l.stribeck = fx("cylinder_stribeck_friction.excess_n", i);
        l.stribeck_velocity = std::max(fx("cylinder_stribeck_friction.velocity_mps", i), 1e-6);
        l.stribeck_exponent = fx("cylinder_stribeck_friction.exponent", i);
        l.uneven = fx("uneven_friction.force_n", i);
        l.uneven_share = fx("uneven_friction.share", i);
        l.uneven_wavelength = std::max(fx("uneven_friction.wavelength_m", i), 1e-6);
        l.uneven_phase = fx("uneven_friction.phase_rad", i);
        l.warming = fx("warming_friction.force_n", i);
        l.warming_time = std::max(fx("warming_friction.time_s", i), 1e-6);
        l.warming_left = fx("warming_friction.left", i);
        l.load_mu = fx("load_dependent_friction.mu", i);
        l.bristle = fx("bristle_friction.force_n", i);
        l.bristle_excess = fx("bristle_friction.excess_n", i);
        l.bristle_velocity = std::max(fx("bristle_friction.velocity_mps", i), 1e-6);
        l.bristle_give = std::max(fx("bristle_friction.give_m", i), 1e-6);
        l.bristle_damping = fx("bristle_friction.damping_n_s_per_m", i);
        l.dahl_extend = fx("cylinder_dahl_friction.force_extend_n", i);
        l.dahl_retract = fx("cylinder_dahl_friction.force_retract_n", i);
        l.dahl_distance = std::max(fx("cylinder_dahl_friction.distance_m", i), 1e-6);
        l.joint_coulomb = fx("passive_joint_friction.coulomb_nm", i);
        l.joint_viscous = fx("passive_joint_friction.viscous_nm_s", i);
        l.play = fx("joint_backlash.clearance_m", i);
        l.compliance = fx("leg_compliance.m_per_n", i);
        b.has_play[i] = l.loose();
        b.play = b.play || l.loose();
        l.pipe_length = fx("pipeline_dynamics.length_m", i);
        l.pipe_diameter = fx("pipeline_dynamics.diameter_m", i);
        l.command_delay = fx("command_delay.delay_s", i);
        l.rounded = fx("rounded_hysteresis.width", i);
        l.turbulent = fx("turbulent_leakage.flow_m3_per_s", i) / std::sqrt(kLeakageDrop);
        l.kink = fx("valve_kink.opening", i);
        l.kink_gain = fx("valve_kink.gain", i);
        l.piston_clearance = fx("loose_piston.clearance_m", i);
        l.piston_kg = fx("loose_piston.mass_kg", i);
        if (!(l.kink_gain > 0) ||
            (l.loose_piston() && !(l.piston_kg > 0 && l.piston_kg < b.upper_kg[i])))
            throw std::runtime_error("valve_kink.gain, loose_piston.mass_kg: out of range");
    }
    return p;
}

/* Controller of one leg (docs/method.md, section 5). */
struct Controller {
    double integral = 0, derivative = 0, error = 0, force_slow = 0, reference = 0;

    void start(double reference_m, double force_n, double resting_valve)
    {
        integral = resting_valve;
        reference = reference_m;
        force_slow = force_n;
    }

    double step(const Settings &s, double reference_m, double length_m, double force_n)
    {
        const double dt = kPeriod, tf = s.at("control.tf"), tp = s.at("control.tp");
        const double limit = s.at("control.integral_limit"), full = s.at("control.output_limit");
        const double e = reference_m - length_m;
        integral = std::clamp(integral + s.at("control.ki") * e * dt, -limit, limit);
        derivative += dt / (tf + dt) * ((e - error) / dt - derivative);
        force_slow += dt / (tp + dt) * (force_n - force_slow);
        const double u = s.at("control.kp") * e + integral + s.at("control.kd") * derivative +
                         s.at("control.kff") * (reference_m - reference) / dt -
                         s.at("control.kpf") * (force_n - force_slow);
        error = e;
        reference = reference_m;
        return std::clamp(u, -full, full);
    }
};

/* Converts the machine's state into the acquisition card's readings, including the sensors' own
 * effects. */
class Rig::Sensors
{
public:
    Sensors(const Setup &setup_given, const Machine &machine, bool jitter_given)
        : setup(setup_given), random(setup_given.noise_seed), jitter(jitter_given),
          enabled(setup_given.settings.at("sensors.enabled") != 0),
          neutral(
              leg_lengths(upper_joints(setup.settings), lower_joints(setup.settings), Vec6::Zero()))
    {
        const Settings &s = setup.settings;
        resolution = s.at("sensors.position_resolution_m");
        noise_v = s.at("sensors.pressure_noise_v") / 2;
        range_v = s.at("sensors.adc_range_v");
        volt = s.at("sensors.pressure_full_scale_pa") / range_v;
        steps = std::pow(2, s.at("sensors.adc_bits") - 1);
        machine.read(last.rod, lag1, lag2);
        machine.read(last.rod, last.p1, last.p2);
        last.t = machine.time();
        history.push_back(last);
        for (int i = 0; i < kLegs; i++) {
            delay[i] = effect(setup, "position_sensor_delay.delay_s", i);
            pressure_delay[i] = effect(setup, "pressure_sensor_delay.delay_s", i);
            cutoff[i] = 2 * kPi * effect(setup, "pressure_sensor_lag.cutoff_hz", i);
        }
        longest_delay = std::max(delay.maxCoeff(), pressure_delay.maxCoeff());
    }

    bool continuous() const { return longest_delay > 0 || cutoff.maxCoeff() > 0; }

    /* Updates the sensors' lags between samples; exact for an input that is linear in time. */
    void follow(const Machine &machine)
    {
        Moment now;
        machine.read(now.rod, now.p1, now.p2);
        now.t = machine.time();
        const double dt = now.t - last.t;
        for (int i = 0; i < kLegs; i++) {
            lag1[i] = lagged(lag1[i], last.p1[i], now.p1[i], cutoff[i] * dt);
            lag2[i] = lagged(lag2[i], last.p2[i], now.p2[i], cutoff[i] * dt);
        }
        last = now;
        history.push_back({now.t, now.rod, lag1, lag2});
        while (history.size() > 2 && history[1].t <= now.t - longest_delay)
            history.pop_front();
    }

    void sample(const Machine &machine, Sample &out)
    {
        Vec6 rod, p1, p2;
        machine.read(rod, p1, p2);
        for (int i = 0; i < kLegs; i++) {
            if (delay[i] > 0)
                rod[i] = past(&Moment::rod, i, machine.time() - delay[i]);
            if (cutoff[i] > 0) {
                p1[i] = lag1[i];
                p2[i] = lag2[i];
            }
            if (pressure_delay[i] > 0) {
                p1[i] = past(&Moment::p1, i, machine.time() - pressure_delay[i]);
                p2[i] = past(&Moment::p2, i, machine.time() - pressure_delay[i]);
            }
            const double zero = neutral[i] + effect(setup, "position_sensor_scale.zero_m", i);
            rod[i] = zero + effect(setup, "position_sensor_scale.scale", i) * (rod[i] - zero) +
                     effect(setup, "position_sensor_offset.offset_m", i);
            out.length[i] =
                enabled && resolution > 0 ? resolution * std::round(rod[i] / resolution) : rod[i];
            const double drift = effect(setup, "pressure_sensor_drift.p1_pa_per_s", i);
            out.p1[i] =
                card(p1[i] * effect(setup, "pressure_sensor_scale.p1", i) +
                     effect(setup, "pressure_sensor_offset.p1", i) + drift * machine.time());
        }
        for (int i = 0; i < kLegs; i++) {
            const double drift = effect(setup, "pressure_sensor_drift.p2_pa_per_s", i);
            out.p2[i] =
                card(p2[i] * effect(setup, "pressure_sensor_scale.p2", i) +
                     effect(setup, "pressure_sensor_offset.p2", i) + drift * machine.time());
        }

        const Sample fresh = out;
        if (jitter && !previous.empty() && random.uniform(0, 1) < kJitterShare) {
            out.length = previous[0].length;
            out.p1 = previous[0].p1;
            out.p2 = previous[0].p2;
        }
        previous.assign(1, fresh);
    }

private:
    struct Moment {
        double t;
        Vec6 rod, p1, p2;
    };

    static double lagged(double y, double u0, double u1, double x)
    {
        if (x <= 0)
            return u1;
        const double e = std::exp(-x), ramp = (u1 - u0) / x;
        return u1 - ramp + (y - u0 + ramp) * e;
    }

    double past(Vec6 Moment::*of, int leg, double t) const
    {
        size_t k = 1;
        while (k + 1 < history.size() && history[k].t < t)
            k++;
        if (history.size() < 2)
            return (history[0].*of)[leg];
        const Moment &a = history[k - 1], &b = history[k];
        const double part = std::clamp((t - a.t) / (b.t - a.t), 0.0, 1.0);
        return (a.*of)[leg] + part * ((b.*of)[leg] - (a.*of)[leg]);
    }

    double card(double pressure)
    {
        if (!enabled)
            return pressure;
        const double level =
            (pressure / volt + random.uniform(-noise_v, noise_v)) / range_v * steps;
        return std::clamp(std::round(level), -steps, steps - 1) / steps * range_v * volt;
    }

    const Setup &setup;
    Random random;
    bool jitter, enabled;
    Vec6 neutral, delay, pressure_delay, cutoff, lag1, lag2;
    double longest_delay, resolution, noise_v, range_v, volt, steps;
    Moment last;
    std::deque<Moment> history;
    std::vector<Sample> previous;
};

static double smooth(double q)
{
    q = std::clamp(q, 0.0, 1.0);
    return q * q * (3 - 2 * q);
}

Rig::Rig(const Setup &given, const Base &base, const Vec6 &pose)
    : setup(given), plant(make_parameters(setup, base), pose),
      sensors(new Sensors(setup, plant, base.jitter))
{
}

Rig::~Rig() = default;

void Rig::measure(Sample &out)
{
    sensors->sample(plant, out);
}

void Rig::step(const Vec6 &valve)
{
    for (int i = 0; i < kLegs; i++)
        plant.command(i, valve[i]);
    const int slices = sensors->continuous() ? 8 : 1;
    for (int j = 1; j <= slices; j++) {
        plant.advance((static_cast<double>(cycle) + static_cast<double>(j) / slices) * kPeriod);
        if (slices > 1)
            sensors->follow(plant);
    }
    if (!plant.y.allFinite())
        throw std::runtime_error("the simulation diverged");
    cycle++;
}

std::vector<Recording> simulate(const Setup &setup, const std::vector<Motion> &motions)
{
    const Settings &s = setup.settings;
    Vec6 parked = Vec6::Zero();
    if (setup.engage)
        parked[2] = s.at("motion.park_z_m");
    Rig rig(setup, draw_base(setup), parked);
    const Points a = upper_joints(s), b = lower_joints(s);
    const Vec6 area1 = kPi / 4 * s.legs("actuator.piston_diameter_m").cwiseAbs2();
    const Vec6 area2 = area1 - kPi / 4 * s.legs("actuator.rod_diameter_m").cwiseAbs2();
    const double skew = effect(setup, "clock_skew.ratio");
    Controller controller[kLegs];
    bool started = false;

    auto run = [&](double length_s, const std::function<Vec6(double)> &reference,
                   Recording *recording) {
        const long cycles = std::lround(length_s / kPeriod);
        for (long k = 0; k < cycles; k++) {
            Sample sample;
            sample.t = skew * static_cast<double>(k) * kPeriod;
            sample.reference = reference(static_cast<double>(k) * kPeriod);
            rig.measure(sample);
            const Vec6 want = leg_lengths(a, b, sample.reference);
            for (int i = 0; i < kLegs; i++) {
                const double force = area1[i] * sample.p1[i] - area2[i] * sample.p2[i];
                if (!started)
                    controller[i].start(want[i], force, rig.machine().resting_valve()[i]);
                sample.valve[i] = controller[i].step(s, want[i], sample.length[i], force);
            }
            started = true;
            if (recording)
                recording->push_back(sample);
            rig.step(sample.valve);
        }
    };

    auto neutral = [](double) -> Vec6 { return Vec6::Zero(); };
    if (setup.engage) {
        run(1, [&](double) { return parked; }, nullptr);
        const double rise = s.at("motion.engage_s");
        run(rise, [&](double t) -> Vec6 { return parked * (1 - smooth(t / rise)); }, nullptr);
        run(s.at("motion.hold_s"), neutral, nullptr);
    }
    std::vector<Recording> recordings(motions.size());
    for (size_t k = 0; k < motions.size(); k++) {
        run(setup.settle_s >= 0 ? setup.settle_s : s.at("tests.settle_s"), neutral, nullptr);
        run(motions[k].length_s, motions[k].reference, &recordings[k]);
    }
    return recordings;
}

static int axis_index(const std::string &name)
{
    for (int i = 0; i < 6; i++)
        if (name == kAxes[i])
            return i;
    throw std::runtime_error("no such axis: '" + name + "'");
}

/* Makes a wave on one axis, ramped in and out as the tests are. */
static Motion wave(const Settings &s, const std::string &axis, double duration,
                   std::function<double(double)> value)
{
    Motion m;
    m.ramp_s = s.at("tests.ramp_s");
    m.duration_s = duration;
    m.ramp_out_s = s.at("tests.ramp_out_s");
    m.length_s = m.ramp_s + m.duration_s + m.ramp_out_s;
    const int index = axis_index(axis);
    const double in = m.ramp_s, out = m.ramp_out_s, out_from = in + duration;
    m.reference = [=](double t) {
        Vec6 r = Vec6::Zero();
        r[index] = value(t) * (in > 0 ? smooth(t / in) : 1) *
                   (out > 0 ? 1 - smooth((t - out_from) / out) : 1);
        return r;
    };
    return m;
}

Motion sine(const Settings &s, const std::string &axis, double frequency, double amplitude)
{
    const double w = 2 * kPi * frequency;
    Motion m = wave(s, axis, s.at("tests.duration_s"),
                    [=](double t) { return amplitude * std::sin(w * t); });
    m.dof = axis;
    m.frequency = frequency;
    m.amplitude = amplitude;
    return m;
}

/* Makes a motion of 20 s with twelve tones per axis: 72 frequencies from 0.3 to 9 Hz, assigned to
 * the axes in turn, none a multiple of another. */
static Motion multisine(double scale, uint64_t seed)
{
    constexpr int kLines = 12;
    Random random(seed + 7919);
    auto frequency = std::make_shared<std::array<std::array<double, kLines>, 6>>();
    auto phase = std::make_shared<std::array<std::array<double, kLines>, 6>>();
    for (int k = 0; k < 6 * kLines; k++) {
        const double share = (k + random.uniform(0.1, 0.9)) / (6 * kLines);
        (*frequency)[k % 6][k / 6] = 0.3 * std::pow(9 / 0.3, share);
        (*phase)[k % 6][k / 6] = random.uniform(0, 2 * kPi);
    }
    Motion m;
    m.length_s = 20;
    m.reference = [=](double t) {
        Vec6 r = Vec6::Zero();
        for (int axis = 0; axis < 6; axis++)
            for (int k = 0; k < kLines; k++) {
                const double f = (*frequency)[axis][k], size = scale * (axis < 3 ? 0.0035 : 0.0045);
                r[axis] += size / (1 + std::pow(f / 2.5, 2)) *
                           std::sin(2 * kPi * f * t + (*phase)[axis][k]);
            }
        return Vec6(r * smooth(t / 1) * (1 - smooth((t - 19.5) / 0.5)));
    };
    return m;
}

/* Makes motions from texts: sines | sine:AXIS:HZ:AMPLITUDE | multisine[:SCALE] |
 * triangle:AXIS:HZ:AMPLITUDE | chirp:AXIS:HZ:HZ:AMPLITUDE | steps:AXIS:AMPLITUDE:HOLD_S */
std::vector<Motion> make_motions(const Settings &s, const std::vector<std::string> &specs,
                                 uint64_t seed)
{
    std::vector<Motion> motions;
    const double duration = s.at("tests.duration_s");
    for (const std::string &spec : specs) {
        const auto part = split(spec, ':');
        auto value = [&](size_t k) { return number(k < part.size() ? part[k] : ""); };
        const std::string axis = part.size() > 1 ? part[1] : "";
        if (part[0] == "sines") {
            for (int k = 0; k < 6; k++)
                motions.push_back(
                    sine(s, kAxes[k], s.at("tests.frequency_hz", k),
                         s.at(k < 3 ? "tests.amplitude_m" : "tests.amplitude_rad", k % 3)));
        } else if (part[0] == "sine") {
            motions.push_back(sine(s, axis, value(2), value(3)));
        } else if (part[0] == "multisine") {
            motions.push_back(multisine(part.size() > 1 ? value(1) : 1, seed + motions.size()));
        } else if (part[0] == "triangle") {
            const double f = value(2), a = value(3);
            motions.push_back(wave(s, axis, duration, [=](double t) {
                return a * 2 / kPi * std::asin(std::sin(2 * kPi * f * t));
            }));
        } else if (part[0] == "chirp") {
            const double f0 = value(2), f1 = value(3), a = value(4), length = duration + 1.5;
            motions.push_back(wave(s, axis, duration, [=](double t) {
                return a * std::sin(2 * kPi * (f0 * t + (f1 - f0) * t * t / (2 * length)));
            }));
        } else if (part[0] == "steps") {
            const double a = value(2), hold = value(3);
            motions.push_back(wave(
                s, axis, duration,
                [=](double t) { /* goes to 0, +a, 0, -a in turn; each move takes 0.1 s */
                                const double level[4] = {0, a, 0, -a}, at = t / hold;
                                const int k = static_cast<int>(at);
                                const double from = level[(k + 3) % 4] * (k > 0), to = level[k % 4];
                                return from + (to - from) * smooth((at - k) * hold / 0.1);
                }));
        } else
            throw std::runtime_error("no such motion: '" + spec + "'");
    }
    return motions;
}
