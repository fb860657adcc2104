/* Tests the rig by identities that do not use the code under test: formulas of docs/method.md,
 * finite differences of lengths and potential energy, energy, smaller steps. Deterministic; takes
 * about a minute. */
#include "rig.hpp"

#include <cmath>
#include <complex>
#include <cstdio>

using Complex = std::complex<double>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kPi = 3.14159265358979323846;
static int failures;

static void claim(bool holds, const char *name, const std::string &figures)
{
    std::printf("%-6s %-52s %s\n", holds ? "ok" : "FAILED", name, figures.c_str());
    failures += !holds;
}

template <class... Numbers> static std::string print(const char *format, Numbers... numbers)
{
    char text[200];
    std::snprintf(text, sizeof text, format, numbers...);
    return text;
}

static Eigen::Matrix3d rotation(const Vec6 &pose)
{
    return (Eigen::AngleAxisd(pose[5], Vec3::UnitZ()) * Eigen::AngleAxisd(pose[4], Vec3::UnitY()) *
            Eigen::AngleAxisd(pose[3], Vec3::UnitX()))
        .toRotationMatrix();
}

static Setup plain(const Settings &settings, const std::vector<std::string> &effects = {})
{
    Setup setup;
    setup.settings = settings;
    setup.settings.set("sensors.enabled=false");
    for (const std::string &effect : effects)
        set_effect(setup.effects, effect);
    return setup;
}

static MachineParameters parameters(const Settings &s, const std::vector<std::string> &effects = {},
                                    double step = 0.25e-3)
{
    Setup setup = plain(s, effects);
    setup.step_s = step;
    return make_parameters(setup, draw_base(setup));
}

/* Returns the settings of a machine with joints as points, six different legs and an off-centre
 * payload. */
static Settings uneven(Settings s)
{
    for (const char *assignment :
         {"geometry.upper_joints_m=[[0.55, -0.13, 0.01], [0.54, 0.14, 0], [-0.16, 0.54, -0.02],"
          " [-0.39, 0.40, 0], [-0.38, -0.41, 0.03], [-0.17, -0.55, 0]]",
          "geometry.lower_joints_m=[[0.78, -0.90, 0], [0.79, 0.92, 0.02], [0.41, 1.13, 0],"
          " [-1.18, 0.23, -0.03], [-1.17, -0.21, 0], [0.40, -1.12, 0.01]]",
          "payload.center_x_m=0.05", "payload.center_y_m=-0.03", "payload.inertia_xy_kg_m2=-1.1",
          "payload.inertia_xz_kg_m2=1.7", "payload.inertia_yz_kg_m2=0.6",
          "actuator.piston_diameter_m=[0.063, 0.060, 0.065, 0.063, 0.070, 0.063]",
          "actuator.rod_diameter_m=[0.045, 0.040, 0.045, 0.050, 0.045, 0.045]",
          "actuator.stroke_m=[0.8, 0.75, 0.8, 0.9, 0.8, 0.8]",
          "actuator.mid_stroke_m=[0.01, 0, -0.02, 0, 0, 0.03]",
          "actuator.upper_mass_kg=[15, 16, 17, 18, 14, 13]",
          "actuator.lower_mass_kg=[52, 53, 50, 49, 55, 58]",
          "actuator.upper_inertia_kg_m2=[2.1, 2.2, 2.3, 2.0, 1.9, 1.8]",
          "actuator.lower_inertia_kg_m2=[3.5, 3.6, 3.7, 3.4, 3.3, 3.2]",
          "actuator.upper_center_m=[0.70, 0.72, 0.68, 0.71, 0.69, 0.66]",
          "actuator.lower_center_m=[0.71, 0.70, 0.73, 0.75, 0.68, 0.69]"})
        s.set(assignment);
    return s;
}

/* Computes the inertia matrix for the platform's twist by docs/method.md, section 3, (A1)-(A6). */
static Matrix6 inertia_by_formula(const MachineParameters &p, const Vec6 &pose)
{
    const Eigen::Matrix3d T = rotation(pose);
    const BodyParameters &b = p.bodies;
    Matrix6 M = Matrix6::Zero();
    M.topLeftCorner<3, 3>().diagonal().setConstant(b.payload_kg);
    M.bottomRightCorner<3, 3>() = T * b.payload_inertia * T.transpose();
    for (int i = 0; i < kLegs; i++) {
        const Vec3 arm = T * b.a.col(i), l = pose.head<3>() + arm - b.b.col(i), n = l.normalized();
        const double L = l.norm(), ma = b.upper_kg[i];
        const double g = ma * std::pow(L - b.upper_center[i], 2) +
                         b.lower_kg[i] * std::pow(b.lower_center[i], 2) + b.upper_inertia[i] +
                         b.lower_inertia[i];
        const Eigen::Matrix3d along = n * n.transpose();
        const Eigen::Matrix3d leg =
            ma * along + g / (L * L) * (Eigen::Matrix3d::Identity() - along);
        Eigen::Matrix<double, 3, 6> Ja;
        Ja << Eigen::Matrix3d::Identity(),
            (Eigen::Matrix3d() << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0)
                .finished();
        M += Ja.transpose() * leg * Ja;
    }
    return M;
}

/* Computes the inertia matrix for the platform's twist from the bodies' generalised coordinates (c,
 * psi, theta, phi). */
static Matrix6 inertia_by_bodies(const MachineParameters &p, const Vec6 &pose)
{
    const Machine machine(p, pose);
    /* rates of the coordinates from the twist: E^-1, by differences of the rotation matrix */
    Matrix6 E = Matrix6::Identity();
    const int angle[3] = {5, 4, 3};
    for (int j = 0; j < 3; j++) {
        const double d = 1e-6;
        Vec6 up = pose, down = pose;
        up[angle[j]] += d;
        down[angle[j]] -= d;
        const Eigen::Matrix3d S =
            (rotation(up) - rotation(down)) / (2 * d) * rotation(pose).transpose();
        E.block<3, 1>(3, 3 + j) << S(2, 1), S(0, 2), S(1, 0);
    }
    const Matrix6 inverse = E.inverse();
    return inverse.transpose() * machine.body_state().M.topLeftCorner<6, 6>() * inverse;
}

static void inertia_matrix_is_that_of_method_md(const Settings &s)
{
    Vec6 moved;
    moved << 0.05, -0.03, 0.08, 0.1, -0.07, 0.12;
    double worst = 0;
    for (const Settings &settings : {s, uneven(s)})
        for (const Vec6 &pose : {Vec6(Vec6::Zero()), moved}) {
            const MachineParameters p = parameters(settings);
            const Matrix6 F = inertia_by_formula(p, pose);
            worst = std::max(worst, (inertia_by_bodies(p, pose) - F).norm() / F.norm());
        }
    claim(worst < 1e-9, "inertia matrix is (A1), neutral and off it, legs alike or not",
          print("relative difference %.1e", worst));

    const Matrix6 neutral = inertia_by_bodies(parameters(s), Vec6::Zero());
    const double d[5] = {neutral(0, 0) - 272.009, neutral(2, 2) - 272.392, neutral(3, 3) - 30.688,
                         neutral(5, 5) - 53.221, neutral(0, 4) - 14.915};
    double most = 0;
    for (double x : d)
        most = std::max(most, std::abs(x));
    claim(most < 6e-4 && std::abs(neutral(1, 3) + 14.915) < 6e-4,
          "inertia at neutral has docs/method.md's numbers",
          print("mx %.3f mz %.3f Ixx %.3f Izz %.3f Mt15 %.3f", neutral(0, 0), neutral(2, 2),
                neutral(3, 3), neutral(5, 5), neutral(0, 4)));
}

static void resting_legs_carry_the_weight(const Settings &s, const char *name)
{
    const MachineParameters p = parameters(s);
    const BodyParameters &b = p.bodies;
    Vec6 pose;
    pose << 0.05, -0.03, 0.08, 0.1, -0.07, 0.12;
    auto potential = [&](const Vec6 &at) {
        const Points a = (rotation(at) * b.a).colwise() + Vec3(at.head<3>());
        double sum = b.payload_kg * at[2];
        for (int i = 0; i < kLegs; i++) {
            const Vec3 n = (a.col(i) - b.b.col(i)).normalized();
            sum += b.upper_kg[i] * (a.col(i) - b.upper_center[i] * n).z() +
                   b.lower_kg[i] * (b.b.col(i) + b.lower_center[i] * n).z();
        }
        return -b.gravity.z() * sum;
    };
    Matrix6 J;
    Vec6 weight;
    for (int k = 0; k < 6; k++) {
        Vec6 up = pose, down = pose;
        up[k] += 1e-6;
        down[k] -= 1e-6;
        J.col(k) = (leg_lengths(b.a, b.b, up) - leg_lengths(b.a, b.b, down)) / 2e-6;
        weight[k] = (potential(up) - potential(down)) / 2e-6;
    }
    const Vec6 force = J.transpose().fullPivLu().solve(weight);
    Machine machine(p, pose);
    Vec6 rod, p1, p2;
    machine.read(rod, p1, p2);
    Vec6 oil;
    for (int i = 0; i < kLegs; i++)
        oil[i] = p.leg[i].area1 * p1[i] - p.leg[i].area2 * p2[i];
    const double first = (oil - force).norm() / force.norm();
    for (int i = 0; i < kLegs; i++)
        machine.command(i, machine.resting_valve()[i]);
    machine.advance(1);
    const double moved = (machine.y.segment<3>(0) - pose.head<3>()).norm();
    claim(first < 1e-7 && moved < 1e-9, name,
          print("relative difference %.1e; 1 s later moved %.1e m", first, moved));
}

/* Shakes each valve at its own frequency; returns the lengths at the end. */
static Vec6 shake(Machine &machine, double until, const std::function<void()> &each_piece = nullptr)
{
    const int pieces = each_piece ? 40 : 1;
    for (int k = 0; k * 0.002 < until - 1e-9; k++) {
        for (int i = 0; i < kLegs; i++)
            machine.command(i, machine.resting_valve()[i] +
                                   0.1 * std::sin(2 * kPi * (3 + 0.7 * i) * 0.002 * k));
        for (int j = 1; j <= pieces; j++) {
            machine.advance(0.002 * (k + static_cast<double>(j) / pieces));
            if (each_piece)
                each_piece();
        }
    }
    Vec6 rod, p1, p2;
    machine.read(rod, p1, p2);
    return rod;
}

static const std::vector<std::string> kCoulomb = {"cylinder_coulomb_friction.force_extend_n=100",
                                                  "cylinder_coulomb_friction.force_retract_n=80"};
static const std::vector<std::string> kDahl = {
    "cylinder_dahl_friction.force_extend_n=600,100,0,300,200,500",
    "cylinder_dahl_friction.force_retract_n=600,50,80,600,200,400",
    "cylinder_dahl_friction.distance_m=2e-5,1e-4,2e-4,5e-5,2e-3,2e-5"};

static void energy_is_balanced(const Settings &s)
{
    const struct {
        const char *name;
        std::vector<std::string> effects;
        double limit; /* J */
        bool legs_differ = false;
        double step = 0.25e-3;
    } cases[] = {{"energy is balanced: clean", {}, 1e-6},
                 {"energy is balanced: no two legs alike", {}, 1e-6, true},
                 {"energy is balanced: friction of cylinders and joints",
                  {kCoulomb[0], kCoulomb[1], "passive_joint_friction.coulomb_nm=3",
                   "passive_joint_friction.viscous_nm_s=5"},
                  1e-4},
                 {"energy is balanced: seals that bend, fast rods",
                  {kDahl[0], kDahl[1], kDahl[2], "valve_flow_gain.scale=4"},
                  1e-4},
                 {"energy is balanced: moving base, springs, pipes",
                  {"base_spring.frequency_hz=12", "external_stiffness.z=20000",
                   "pipeline_dynamics.length_m=1"},
                  1e-5},
                 {"energy is balanced: pistons loose on their rods",
                  {"loose_piston.clearance_m=5e-4", "valve_flow_gain.scale=4"},
                  1e-3,
                  false,
                  0.01e-3}, /* the stops are stiff: at 0.09 ms, the rig's step, 1.3e-2 J are off */
                 {"energy is balanced: part of the payload on springs",
                  {"payload_mode.frequency_hz=8", "base_spring.frequency_hz=15"},
                  1e-5},
                 {"energy is balanced: centre of mass off, tilted base",
                  {"payload_center_of_mass.x_m=0.03", "base_tilt.phi_rad=0.05",
                   "geometry_error.b_x_m=0.01,0,0,0,0,0"},
                  1e-6}};
    for (const auto &c : cases) {
        const Settings &of = c.legs_differ ? uneven(s) : s;
        Machine machine(parameters(of, c.effects, c.step), Vec6::Zero());
        const double before = machine.energy();
        shake(machine, 1);
        const double change = machine.energy() - before, miss = std::abs(change - machine.work());
        claim(miss < c.limit, c.name, print("gained %.3f J, off by %.1e J", change, miss));
    }
}

static void steps_are_short_enough(const Settings &s)
{
    const struct {
        const char *name;
        std::vector<std::string> effects;
    } cases[] = {{"0.25 ms is short enough: clean", {}},
                 {"0.25 ms is short enough: Coulomb friction", kCoulomb},
                 {"0.25 ms is short enough: seals that bend", kDahl}};
    for (const auto &c : cases) {
        auto end = [&](double step) {
            Machine machine(parameters(s, c.effects, step), Vec6::Zero());
            return shake(machine, 1);
        };
        const Vec6 exact = end(0.03125e-3);
        const double coarse = (end(0.5e-3) - exact).norm(), used = (end(0.25e-3) - exact).norm();
        claim(used < 2e-8, c.name,
              print("length after 1 s off by %.1e m; at 0.5 ms %.1e m", used, coarse));
    }
    Machine rigid(parameters(s), Vec6::Zero());
    Machine heavy(parameters(s, {"base_spring.frequency_hz=100", "base_spring.mass_kg=1e8"}),
                  Vec6::Zero());
    const double apart = (shake(rigid, 1) - shake(heavy, 1)).norm();
    claim(apart < 1e-7, "a base plate of 1e8 kg is a rigid base",
          print("lengths %.1e m apart", apart));
    Machine tight(parameters(s, {"joint_backlash.clearance_m=1e-9"}), Vec6::Zero());
    Machine again(parameters(s), Vec6::Zero());
    const double play = (shake(again, 1) - shake(tight, 1)).norm();
    claim(play < 5e-5, "a play of 1 nm is none, but for its contact's 5 um",
          print("lengths %.1e m apart", play));
    Machine fixed(parameters(s), Vec6::Zero());
    Machine piston(parameters(s, {"loose_piston.clearance_m=1e-9"}), Vec6::Zero());
    const double loose = (shake(fixed, 1) - shake(piston, 1)).norm();
    claim(loose < 5e-5, "neither is one of the piston", print("lengths %.1e m apart", loose));
}

/* A loose piston goes from stop to stop of its play where the force changes its sign, and no
 * farther than the stops give. */
static void loose_pistons_cross_their_play(const Settings &s)
{
    const double clearance = 5e-4;
    Machine machine(parameters(s, {"loose_piston.clearance_m=5e-4", "valve_flow_gain.scale=4"}),
                    Vec6::Zero());
    double least = 1, most = -1;
    shake(machine, 1, [&] {
        for (int i = 0; i < kLegs; i++) {
            const double at = machine.y[Machine::kLeg + Machine::kPerLeg * i + Machine::kPiston];
            least = std::min(least, at);
            most = std::max(most, at);
        }
    });
    claim(most > clearance / 2 && least < -clearance / 2 && most - least < clearance + 4e-4,
          "loose pistons cross their play and end at its stops",
          print("%.1f to %.1f um in a play of 500 um", 1e6 * least, 1e6 * most));
}

/* Returns the spool of leg 3, less its rest, after each of the commands has been held for 40 ms. */
static std::vector<double> spools(Machine &machine, const std::vector<double> &commands)
{
    std::vector<double> at;
    for (double command : commands) {
        machine.command(2, machine.resting_valve()[2] + command);
        machine.advance(machine.time() + 0.04);
        at.push_back(machine.y[Machine::kLeg + 2 * Machine::kPerLeg + Machine::kSpool] -
                     machine.resting_valve()[2]);
    }
    return at;
}

/* Plays in parallel, of widths 0 to 2 w, swept from -A to A and back, enclose the mean of
 * w_k (2A - w_k), 2 A w - 4/3 w^2. The largest difference of the ways is w if A exceeds 2 w. */
static void rounded_hysteresis_encloses_its_loop(const Settings &s)
{
    const double width = 0.02, top = 0.06;
    Machine machine(parameters(s, {"rounded_hysteresis.width=0.02"}), Vec6::Zero());
    std::vector<double> commands;
    const int half = 48; /* steps from -A to A */
    for (int k = 0; k <= 2 * half + half / 2; k++) {
        const int phase = (k + half / 2) % (2 * half);
        commands.push_back(top * (phase <= half ? 2.0 * phase / half - 1 : 3 - 2.0 * phase / half));
    }
    const auto at = spools(machine, commands);
    double area = 0, widest = 0, small = 1;
    for (int k = half / 2; k < half / 2 + 2 * half; k++) {
        area += (at[k + 1] + at[k]) / 2 * (commands[k + 1] - commands[k]);
        const int back = 2 * half + half - k; /* the same command on the other way */
        if (k < half / 2 + half)
            widest = std::max(widest, std::abs(at[back] - at[k]));
    }
    for (int k = half / 2 + 1; k < half / 2 + 4; k++) /* rounded: it moves soon after a reversal */
        small = std::min(small, std::abs(at[k + 1] - at[k]) / (commands[1] - commands[0]));
    const double expected = 2 * top * width - 4.0 / 3 * width * width;
    claim(std::abs(std::abs(area) / expected - 1) < 0.02 && std::abs(widest / width - 1) < 0.02 &&
              small > 0.01,
          "a rounded hysteresis encloses the loop of its plays",
          print("area %.3f of the formula, widest %.3f; slope after a reversal %.3f",
                std::abs(area) / expected, widest / width, small));
}

/* Returns the speed of leg 3 at a valve command, from 0.3 to 0.5 s. */
static double steady_speed(const Settings &s, const std::vector<std::string> &effects,
                           double command)
{
    Machine machine(parameters(s, effects), Vec6::Zero());
    Vec6 first, last, p1, p2;
    for (int i = 0; i < kLegs; i++)
        machine.command(i, command);
    machine.advance(0.3);
    machine.read(first, p1, p2);
    machine.advance(0.5);
    machine.read(last, p1, p2);
    return (last - first)[2] / 0.2;
}

/* A valve whose gain falls to 0.6 at 0.05 and is opened by 0.15 runs as one without a kink that is
 * opened by 0.05 + 0.6 * 0.1, either way. */
static void kink_reduces_the_opening(const Settings &s)
{
    const std::vector<std::string> kink = {"valve_kink.opening=0.05", "valve_kink.gain=0.6"};
    double off[4];
    for (int k = 0; k < 4; k++) {
        const double command = (k % 2 ? -1 : 1) * (k < 2 ? 0.15 : 0.04);
        const double same = (k % 2 ? -1 : 1) * (k < 2 ? 0.11 : 0.04);
        off[k] = steady_speed(s, kink, command) / steady_speed(s, {}, same) - 1;
    }
    claim(std::abs(off[0]) < 2e-3 && std::abs(off[1]) < 2e-3 && std::abs(off[2]) < 2e-3 &&
              std::abs(off[3]) < 2e-3,
          "a valve with a kink runs as one that is opened less",
          print("speeds off by %.1e and %.1e beyond it, %.1e and %.1e before", off[0], off[1],
                off[2], off[3]));
}

/* At rest the valve lets through what leaks: the flow of the laminar gap and of the orifice, by
 * the pressures that the machine has. */
static void turbulent_leakage_is_the_valve_flow_at_rest(const Settings &s)
{
    const MachineParameters p = parameters(s, {"turbulent_leakage.flow_m3_per_s=1e-4"});
    Machine machine(p, Vec6::Zero());
    for (int i = 0; i < kLegs; i++)
        machine.command(i, machine.resting_valve()[i]);
    machine.advance(1);
    Vec6 rod, p1, p2;
    machine.read(rod, p1, p2);
    double worst = 0;
    for (int i = 0; i < kLegs; i++) {
        const double leak = s.at("hydraulics.leakage_m3_per_s_pa", i) * (p2[i] - p1[i]) +
                            1e-4 * std::sqrt((p2[i] - p1[i]) / 1e6);
        const double spool = machine.y[Machine::kLeg + Machine::kPerLeg * i + Machine::kSpool];
        const double open = s.at("hydraulics.valve_flow_m3_per_s", i) *
                            std::sqrt((p1[i] - p.tank) / s.at("hydraulics.valve_drop_pa"));
        worst = std::max(worst, std::abs(-spool * open / leak - 1));
    }
    const double moved = machine.y.segment<3>(0).norm();
    claim(worst < 1e-6 && moved < 1e-9, "what leaks as through an orifice comes from the valve",
          print("flow off by %.1e; moved %.1e m in 1 s", worst, moved));
}

/* 30 kPa more in each chamber 1 are 94 N. A leg whose friction is 150 N does not move while the
 * valve reduces that pressure. */
static void friction_holds(const Settings &s)
{
    double moved[2], crept = 0;
    for (int k = 0; k < 2; k++) {
        std::vector<std::string> effects;
        if (k == 0)
            effects = {"cylinder_coulomb_friction.force_extend_n=150",
                       "cylinder_coulomb_friction.force_retract_n=150"};
        Machine machine(parameters(s, effects), Vec6::Zero());
        Vec6 first, last, p1, p2;
        machine.read(first, p1, p2);
        for (int i = 0; i < kLegs; i++)
            machine.y[Machine::kLeg + Machine::kPerLeg * i + Machine::kP1] += 30e3;
        machine.advance(0.2);
        machine.read(last, p1, p2);
        moved[k] = (last - first).cwiseAbs().maxCoeff();
        if (k == 0) {
            machine.advance(10);
            machine.read(last, p1, p2);
            crept = (last - first).cwiseAbs().maxCoeff();
        }
    }
    claim(crept < 1e-9 && moved[1] > 1e-6, "a leg loaded below its friction does not creep",
          print("%.1e m in 10 s; without friction %.1e m in 0.2 s", crept, moved[1]));
}

/* Dahl's law has a closed form along the path between reversals: z = s + (z0 - s) exp(-|x - x0| /
 * distance), s the direction. The seals bear the oil's force less inertia and weight. */
static void seals_bend_along_the_path(const Settings &s)
{
    const MachineParameters p = parameters(s, kDahl, 0.05e-3);
    Machine machine(p, Vec6::Zero());
    Vec6 z = Vec6::Zero(), x, p1, p2, applied = Vec6::Zero();
    machine.read(x, p1, p2);
    Vec6 v[2] = {Vec6::Zero(), Vec6::Zero()}; /* the platform's velocity one and two segments ago */
    BodyState body = machine.body_state();
    double largest = 0, state = 0, force = 0;
    shake(machine, 1, [&] {
        const Vec6 next = machine.y.segment<6>(Machine::kV), dv = (next - v[1]) / 0.1e-3;
        const Vec6 leg = body.rod_row.leftCols<6>().transpose().partialPivLu().solve(
            body.M.topLeftCorner<6, 6>() * dv + body.bias.head<6>());
        for (int i = 0; i < kLegs; i++) {
            const LegParameters &l = p.leg[i];
            const double borne = (z[i] > 0 ? l.dahl_extend : l.dahl_retract) * z[i];
            if (machine.time() > 0.1e-3 + 1e-9)
                force = std::max(force, std::abs(applied[i] - leg[i] - borne));
        }
        v[1] = v[0];
        v[0] = next;
        body = machine.body_state();
        const Vec6 before = x;
        machine.read(x, p1, p2);
        for (int i = 0; i < kLegs; i++) {
            const LegParameters &l = p.leg[i];
            const double by = x[i] - before[i], side = by > 0 ? 1 : -1;
            z[i] = side + (z[i] - side) * std::exp(-std::abs(by) / l.dahl_distance);
            const double is =
                machine.y[Machine::kLeg + Machine::kPerLeg * i + Machine::kSeal] / l.dahl_distance;
            state = std::max(state, std::abs(is - z[i]));
            largest = std::max(largest, std::abs(is));
            applied[i] = l.area1 * p1[i] - l.area2 * p2[i] - l.viscous_extend * body.rod_rate[i];
        }
    });
    claim(state < 1e-3 && largest < 1 + 1e-9 && force < 1,
          "seals bend along the path as Dahl's closed form says",
          print("state off by %.1e, at most %.6f; force off by %.2g N of 600", state, largest,
                force));
}

/* Fundamentals and means of the tests z, theta, x, by which an effect is judged. */
struct Response {
    Complex X[3], G[3], U; /* motion and force on the tested axis; valve of leg 3 in test z */
    double u_mean, G_mean[6], F_mean, t_end;
    Eigen::MatrixXd all; /* the whole recording, columns equally scaled */
};

static Response respond(const Settings &settings, const std::vector<std::string> &effects)
{
    Setup setup = plain(settings, effects);
    setup.settle_s = 1;
    setup.settings.set("tests.duration_s=2");
    const Settings &s = setup.settings;
    const auto recordings = simulate(
        setup, {sine(s, "z", 4, 0.004), sine(s, "theta", 4, 0.006), sine(s, "x", 4, 0.004)});
    const MachineParameters p = parameters(s);
    Matrix6 J;
    for (int i = 0; i < kLegs; i++) {
        const Vec3 n = (p.bodies.a.col(i) - p.bodies.b.col(i)).normalized(),
                   arm = p.bodies.a.col(i);
        J.row(i) << n.transpose(), arm.cross(n).transpose();
    }
    const int axis[3] = {2, 4, 0};
    Response r{};
    r.all.resize(3 * static_cast<long>(recordings[0].size()), 24);
    long row = 0;
    for (int k = 0; k < 3; k++) {
        for (size_t j = 0; j < recordings[k].size(); j++) {
            const Sample &x = recordings[k][j];
            const Vec6 F = p.leg[0].area1 * x.p1 - p.leg[0].area2 * x.p2;
            r.all.row(row++) << x.length.transpose() / 1e-3, x.p1.transpose() / 1e6,
                x.p2.transpose() / 1e6, x.valve.transpose() / 0.1;
            if (j < 500 || j >= 1500)
                continue;
            const Complex turn =
                std::exp(Complex(0, -2 * kPi * 4 * 0.002 * static_cast<double>(j))) * 2.0 / 1000.0;
            const Vec6 X = J.partialPivLu().solve(x.length), G = J.transpose() * F;
            r.X[k] += X[axis[k]] * turn;
            r.G[k] += G[axis[k]] * turn;
            if (k == 0) {
                r.U += x.valve[2] * turn;
                r.u_mean += x.valve[2] / 1000;
                r.F_mean += F[2] / 1000;
                for (int m = 0; m < 6; m++)
                    r.G_mean[m] += G[m] / 1000;
            }
        }
        r.t_end = recordings[k].back().t;
    }
    return r;
}

static void each_effect_does_what_it_says(const Settings &s)
{
    const double w = 2 * kPi * 4, g = 9.80665;
    const Complex j(0, 1);
    const Response clean = respond(s, {});
    auto Z = [](const Response &r, int k) { return r.G[k] / r.X[k]; };
    auto dZ = [&](const Response &r, int k) { return Z(r, k) - Z(clean, k); };
    auto turned = [](Complex after, Complex before) { return std::arg(after / before); };
    const MachineParameters p = parameters(s);
    const double nz = (p.bodies.a - p.bodies.b).col(2).normalized().z(),
                 L = (p.bodies.a - p.bodies.b).col(2).norm();
    const double shape = 6 * nz * nz; /* sum of squares of the legs' z components */
    auto leg_speed = [&](const Response &r) { return w * std::abs(r.X[0]) * std::abs(nz); };

    /* effects as name.key=value; function that returns the ratio of measured to expected value, 1
     * if exact; accuracy of the expectation */
    using Measure = std::function<double(const Response &)>;
    struct Case {
        std::vector<std::string> effects;
        Measure ratio;
        double share;
    };
    auto moves = Measure(); /* checks only that the recording changes */
    const std::vector<Case> cases = {
        {{"cylinder_coulomb_friction.force_extend_n=100",
          "cylinder_coulomb_friction.force_retract_n=100"},
         [&](const Response &r) {
             return std::imag(dZ(r, 0)) / w / (shape * 4 / kPi * 100 / leg_speed(r));
         },
         0.05},
        {{"cylinder_dahl_friction.force_extend_n=100", "cylinder_dahl_friction.force_retract_n=100",
          "cylinder_dahl_friction.distance_m=1e-3"},
         [&](const Response &r) { /* a loop from -X to X and back takes 4 F (X - d tanh(X/d)) */
                                  const double share = leg_speed(r) / w / 1e-3;
                                  return std::imag(dZ(r, 0)) / w /
                                         (shape * 4 / kPi * 100 * (1 - std::tanh(share) / share) /
                                          leg_speed(r));
         },
         0.05},
        {{"cylinder_stribeck_friction.excess_n=100",
          "cylinder_stribeck_friction.velocity_mps=0.02"},
         [&](const Response &r) {
             double sum = 0;
             for (int k = 0; k < 1000; k++) {
                 const double v = std::sin(2 * kPi * (k + 0.5) / 1000);
                 sum +=
                     2 * 100 * std::exp(-std::pow(v * leg_speed(r) / 0.02, 2)) * std::abs(v) / 1000;
             }
             return std::imag(dZ(r, 0)) / w / (shape * sum / leg_speed(r));
         },
         0.1},
        {{"cylinder_stribeck_friction.excess_n=100", "cylinder_stribeck_friction.velocity_mps=0.02",
          "cylinder_stribeck_friction.exponent=0.7"},
         [&](const Response &r) {
             double sum = 0;
             for (int k = 0; k < 1000; k++) {
                 const double v = std::abs(std::sin(2 * kPi * (k + 0.5) / 1000));
                 sum += 2 * 100 * std::exp(-std::pow(v * leg_speed(r) / 0.02, 0.7)) * v / 1000;
             }
             return std::imag(dZ(r, 0)) / w / (shape * sum / leg_speed(r));
         },
         0.05},
        {{"uneven_friction.force_n=100", "uneven_friction.share=0.5",
          "uneven_friction.wavelength_m=0.01", "uneven_friction.phase_rad=1.5707963"},
         [&](const Response &r) { /* a loop from -X to X takes 4 F (X + share sin(k X) / k) */
                                  const double turn = 2 * kPi / 0.01 * leg_speed(r) / w;
                                  return std::imag(dZ(r, 0)) / w /
                                         (shape * 4 / kPi * 100 *
                                          (1 + 0.5 * std::sin(turn) / turn) / leg_speed(r));
         },
         0.05},
        {{"warming_friction.force_n=100", "warming_friction.time_s=2"},
         [&](const Response &r) { /* test z is evaluated from 2 to 4 s */
                                  const double cold = std::exp(-1.0) - std::exp(-2.0);
                                  return std::imag(dZ(r, 0)) / w /
                                         (shape * 4 / kPi * 100 * (0.5 + 0.5 * cold) /
                                          leg_speed(r));
         },
         0.05},
        {{"bristle_friction.force_n=100", "bristle_friction.give_m=1e-3",
          "bristle_friction.damping_n_s_per_m=2000"},
         [&](const Response &
                 r) { /* the force over the path from -X to X, bent by exp(-path/give) */
                      const double X = leg_speed(r) / w;
                      double loss = 0;
                      for (int k = 0; k < 1000; k++) {
                          const double x = X * (2 * (k + 0.5) / 1000 - 1);
                          const double left = (1 + std::tanh(X / 1e-3)) * std::exp(-(x + X) / 1e-3);
                          const double v = w * std::sqrt(X * X - x * x);
                          loss += (100 * (1 - left) + 2000 * v * left) * 2 * X / 1000;
                      }
                      return std::imag(dZ(r, 0)) / w /
                             (shape * 2 * loss / (kPi * X * leg_speed(r)));
         },
         0.05},
        {{"cylinder_viscous_friction.extend_n_s_per_m=500",
          "cylinder_viscous_friction.retract_n_s_per_m=500"},
         [&](const Response &r) { return std::imag(dZ(r, 0)) / w / (shape * 500); },
         0.03},
        {{"load_dependent_friction.mu=0.02"},
         [&](const Response &r) {
             return std::imag(dZ(r, 0)) / w /
                    (shape * 4 / kPi * 0.02 * 1.59e-3 * 4.5e6 / leg_speed(r));
         },
         0.25},
        {{"passive_joint_friction.coulomb_nm=10"}, moves, 0},
        {{"passive_joint_friction.viscous_nm_s=50"}, moves, 0},
        {{"payload_mass.mass_kg=5"},
         [&](const Response &r) { return (r.G_mean[2] - clean.G_mean[2]) / (-5 * g); },
         0.02},
        {{"payload_mass.mass_kg=10"},
         [&](const Response &r) { return std::real(dZ(r, 0)) / (-w * w * 10); },
         0.05},
        {{"payload_center_of_mass.x_m=0.02"},
         [&](const Response &r) {
             return std::abs(r.G_mean[4] - clean.G_mean[4]) / (178.6 * g * 0.02);
         },
         0.02},
        {{"payload_center_of_mass.z_m=0.02"}, moves, 0},
        {{"payload_rotational_inertia.yy=3"},
         [&](const Response &r) { return std::real(dZ(r, 1)) / (-w * w * 3); },
         0.1},
        {{"actuator_inertia.upper_mass_kg=3"},
         [&](const Response &r) {
             const double across = std::pow((L - 0.7) / L, 2) * (1 - nz * nz);
             return std::real(dZ(r, 0)) / (-w * w * 18 * (nz * nz + across));
         },
         0.05},
        {{"actuator_inertia.lower_mass_kg=10"},
         [&](const Response &r) { /* the weight of the lower part is a moment about the lower
                                   * joint */
                                  return (r.G_mean[2] - clean.G_mean[2]) /
                                         (-60 * g * 0.71 / L * (1 - nz * nz));
         },
         0.05},
        {{"actuator_inertia.transverse_kg_m2=2"},
         [&](const Response &r) {
             return std::real(dZ(r, 0)) / (-w * w * 12 / (L * L) * (1 - nz * nz));
         },
         0.1},
        {{"external_stiffness.z=100000"},
         [&](const Response &r) { return std::real(dZ(r, 0)) / 1e5; },
         0.03},
        {{"external_stiffness.theta=10000"},
         [&](const Response &r) { return std::real(dZ(r, 1)) / 1e4; },
         0.1},
        {{"joint_backlash.clearance_m=0.0005"}, moves, 0},
        {{"geometry_error.a_x_m=0.005,0,0,0,0,0"}, moves, 0},
        {{"geometry_error.b_z_m=0.005,0,0,0,0,0"}, moves, 0},
        {{"base_tilt.theta_rad=0.02"},
         [&](const Response &r) {
             return std::abs(r.G_mean[0] - clean.G_mean[0]) / (0.02 * g * 370);
         },
         0.15},
        {{"valve_dead_band.overlap=0.02"},
         [&](const Response &r) { /* the spool's swing about its mean crosses zero at an angle of
                                   * asin(0.075/0.17) */
                                  const double more =
                                      std::abs(r.U / r.X[0] * clean.X[0]) - std::abs(clean.U);
                                  return more / (4 / kPi * 0.02 * 0.9);
         },
         0.15},
        {{"valve_hysteresis.width=0.04"}, moves, 0},
        {{"valve_lag.frequency_hz=30"},
         [&](const Response &r) {
             return turned(r.U / r.X[0], clean.U / clean.X[0]) / (1.6 * 4 * (1.0 / 30 - 1.0 / 100));
         },
         0.1},
        {{"valve_rate_limit.per_s=3"}, moves, 0},
        {{"valve_flow_gain.scale=1.1"},
         [&](const Response &r) {
             return std::abs(clean.U / clean.X[0]) / std::abs(r.U / r.X[0]) / 1.1;
         },
         0.02},
        {{"valve_null_bias.offset=0.02"},
         [&](const Response &r) { return (clean.u_mean - r.u_mean) / 0.02; },
         0.05},
        {{"port_area_ratio.ratio=0.49"}, moves, 0},
        {{"internal_leakage.scale=2"},
         [&](const Response &r) { return r.u_mean / clean.u_mean / 2; },
         0.2},
        {{"entrained_air.bulk_modulus_pa=3e8"}, moves, 0},
        {{"supply_pressure_sag.resistance_pa_s_per_m3=5e8"}, moves, 0},
        {{"tank_back_pressure.resistance_pa_s_per_m3=5e8"}, moves, 0},
        {{"pipeline_dynamics.length_m=3"}, moves, 0},
        {{"pressure_sensor_scale.p1=1.03"}, moves, 0},
        {{"pressure_sensor_offset.p1=100000"},
         [&](const Response &r) { return (r.F_mean - clean.F_mean) / (p.leg[0].area1 * 1e5); },
         0.01},
        {{"position_sensor_scale.scale=1.02"},
         [&](const Response &r) { return std::abs(Z(clean, 1) / Z(r, 1)) / 1.02; },
         0.01},
        {{"position_sensor_offset.offset_m=0.002,0,0,0,0,0"}, moves, 0},
        {{"pressure_sensor_lag.cutoff_hz=40"},
         [&](const Response &r) { return turned(Z(r, 1), Z(clean, 1)) / -std::atan(0.1); },
         0.05},
        {{"position_sensor_delay.delay_s=0.003"},
         [&](const Response &r) { return turned(Z(r, 1), Z(clean, 1)) / (w * 0.003); },
         0.05},
        {{"leg_compliance.m_per_n=1e-7"}, moves, 0},
        {{"pressure_sensor_delay.delay_s=0.003"},
         [&](const Response &r) { return turned(Z(clean, 1), Z(r, 1)) / (w * 0.003); },
         0.05},
        {{"command_delay.delay_s=0.003"},
         [&](const Response &r) {
             return turned(r.U / r.X[0], clean.U / clean.X[0]) / (w * 0.003);
         },
         0.1},
        {{"clock_skew.ratio=1.01"},
         [&](const Response &r) { return r.t_end / clean.t_end / 1.01; },
         1e-9},
        {{"base_spring.frequency_hz=12"}, moves, 0},
        {{"payload_mode.frequency_hz=12", "payload_mode.mass_kg=50"},
         [&](const Response &r) { /* the mass on its spring follows by 1 / (1 - (f / f0)^2) */
                                  const double more = 50 * (1 / (1 - 1.0 / 9) - 1);
                                  return std::real(dZ(r, 0)) / (-w * w * more);
         },
         0.05},
        {{"pump_ripple.pressure_pa=200000"}, moves, 0},
        {{"sloshing.mass_kg=25", "sloshing.frequency_hz=1.5"},
         [&](const Response &r) { /* along x as a mass on a spring; downwards it is carried */
                                  const double more = 25 * (1 / (1 - std::pow(4 / 1.5, 2)) - 1);
                                  const double down = std::real(dZ(r, 0)) / (-w * w * 25);
                                  return std::real(dZ(r, 2)) / (-w * w * more) + down;
         },
         0.1},
        {{"pressure_sensor_drift.p1_pa_per_s=20000"},
         [&](const Response &r) { /* test z is evaluated from 2 to 4 s */
                                  return (r.F_mean - clean.F_mean) / (p.leg[0].area1 * 2e4 * 2.999);
         },
         0.01},
        {{"loose_piston.clearance_m=0.0005"}, moves, 0},
        {{"turbulent_leakage.flow_m3_per_s=1e-4"}, moves, 0},
        {{"rounded_hysteresis.width=0.02"}, moves, 0},
        {{"valve_kink.gain=0.6"}, moves, 0},
    };
    const double variation = (clean.all.rowwise() - clean.all.colwise().mean()).norm();
    for (const Case &c : cases) {
        const Response r = respond(s, c.effects);
        const double change = (r.all - clean.all).norm() / variation;
        const double ratio = c.ratio ? c.ratio(r) : 1;
        const bool changes = change > 3e-4 || c.effects[0].rfind("clock_skew", 0) == 0;
        claim(changes && std::abs(ratio - 1) <= c.share, c.effects[0].c_str(),
              print("changes %.4f of the variation", change) +
                  (c.ratio ? print("; %.3f of what its law says", ratio) : ""));
    }
}

int self_test(const Settings &settings)
{
    inertia_matrix_is_that_of_method_md(settings);
    resting_legs_carry_the_weight(settings, "resting legs push with J^-T w, and stay");
    resting_legs_carry_the_weight(uneven(settings), "so do legs of which none is like another");
    energy_is_balanced(settings);
    steps_are_short_enough(settings);
    friction_holds(settings);
    seals_bend_along_the_path(settings);
    loose_pistons_cross_their_play(settings);
    rounded_hysteresis_encloses_its_loop(settings);
    kink_reduces_the_opening(settings);
    turbulent_leakage_is_the_valve_flow_at_rest(settings);
    each_effect_does_what_it_says(settings);
    std::printf("%d failed\n", failures);
    return failures ? 1 : 0;
}
