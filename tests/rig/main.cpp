/* The program `rig`: recordings of the machine as CSV files, and what is hidden in them. */
#include "rig.hpp"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

static void write_csv(const std::string &file, const Motion &m, const Recording &recording)
{
    FILE *out = std::fopen(file.c_str(), "w");
    if (!out)
        throw std::runtime_error("cannot write " + file);
    std::fprintf(out, "# dof: %s\n", m.dof.c_str());
    if (m.frequency > 0)
        std::fprintf(out, "# frequency_hz: %g\n# amplitude: %g\n", m.frequency, m.amplitude);
    std::fprintf(out, "# rate_hz: %g\n", 1 / kPeriod);
    if (m.frequency > 0)
        std::fprintf(out, "# ramp_s: %g\n# duration_s: %g\n# ramp_out_s: %g\n", m.ramp_s,
                     m.duration_s, m.ramp_out_s);
    std::fprintf(out, "t_s,ref_x_m,ref_y_m,ref_z_m,ref_phi_rad,ref_theta_rad,ref_psi_rad");
    for (const char *format : {",l%d_m", ",p1_%d_pa", ",p2_%d_pa", ",u%d"})
        for (int i = 1; i <= kLegs; i++)
            std::fprintf(out, format, i);
    for (const Sample &s : recording) {
        std::fprintf(out, "\n%.9g", s.t);
        for (const Vec6 *v : {&s.reference, &s.length, &s.p1, &s.p2, &s.valve})
            for (int i = 0; i < kLegs; i++)
                std::fprintf(out, ",%.9g", (*v)[i]);
    }
    std::fprintf(out, "\n");
    if (std::fclose(out) != 0)
        throw std::runtime_error("cannot write " + file);
}

static std::string list(const Vec6 &v)
{
    std::ostringstream out;
    out.precision(12);
    for (int i = 0; i < kLegs; i++)
        out << (i ? ", " : "[") << v[i];
    return out.str() + "]";
}

/* Returns the drawn masses of a part: one number if the configuration has one for all legs. */
static std::string masses(const Settings &s, const std::string &key, double share)
{
    if (s.all(key).size() != 1)
        return list(s.legs(key) * share);
    std::ostringstream out;
    out.precision(12);
    out << s.at(key) * share;
    return out.str();
}

static void write_truth(const std::string &file, const Setup &setup)
{
    const Base base = draw_base(setup);
    const MachineParameters p = make_parameters(setup, base);
    std::ofstream out(file);
    out.precision(12);
    out << "{\n \"hidden\": [";
    std::string last;
    for (const auto &[key, values] : setup.effects) {
        const std::string name = key.substr(0, key.find('.'));
        if (name != last)
            out << (last.empty() ? "" : ", ") << '"' << name << '"';
        last = name;
    }
    out << "],\n \"parameters\": {";
    const char *comma = "\n";
    for (const auto &[key, values] : setup.effects) {
        out << comma << "  \"" << key << "\": " << list(values);
        comma = ",\n";
    }
    out << "\n },\n \"series\": \""
        << (setup.beyond_seed >= 0      ? "beyond"
            : setup.tolerance_seed >= 0 ? "tolerance"
                                        : "nominal")
        << "\",\n \"base\": {\n";
    const struct {
        const char *name;
        const Vec6 &relative;
    } each[] = {{"viscous", base.viscous},      {"bulk_modulus", base.bulk},
                {"leakage", base.leakage},      {"valve_gain", base.gain},
                {"dead_volume_1", base.dead1},  {"dead_volume_2", base.dead2},
                {"valve_damping", base.damping}};
    for (const auto &e : each)
        out << "  \"" << e.name << " relative to nominal, legs 1..6\": " << list(e.relative)
            << ",\n";
    out << "  \"null_bias of full opening, legs 1..6\": " << list(base.null_bias) << ",\n";
    for (int k = 0; k < 3; k++)
        out << "  \"joint error a_" << kAxes[k] << "_m\": " << list(base.a.row(k).transpose())
            << ",\n"
            << "  \"joint error b_" << kAxes[k] << "_m\": " << list(base.b.row(k).transpose())
            << ",\n";
    const Settings &s = setup.settings;
    out << "  \"supply_pa\": " << p.supply
        << ",\n  \"payload_mass_kg\": " << s.at("payload.mass_kg") * base.payload
        << ",\n  \"upper_mass_kg\": " << masses(s, "actuator.upper_mass_kg", base.upper)
        << ",\n  \"lower_mass_kg\": " << masses(s, "actuator.lower_mass_kg", base.lower)
        << ",\n  \"timing_jitter\": " << (base.jitter ? "true" : "false") << "\n }\n}\n";
    if (!out)
        throw std::runtime_error("cannot write " + file);
}

/* Prints the inertia matrix at neutral, for the platform's twist in {M}: x y z phi theta psi. A
 * part of the payload on springs counts as rigid, and so do legs that give. */
static void print_inertia_matrix(const Setup &setup)
{
    MachineParameters p = make_parameters(setup, draw_base(setup));
    for (LegParameters &leg : p.leg)
        leg.compliance = 0;
    p.bodies.play = false;
    for (int i = 0; i < kLegs; i++) {
        p.bodies.has_play[i] = p.leg[i].loose();
        p.bodies.play = p.bodies.play || p.leg[i].loose();
    }
    const Machine machine(p, Vec6::Zero());
    const int order[6] = {0, 1, 2, 5, 4, 3}; /* at neutral the angles' rates equal the twist */
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 6; k++)
            std::printf("%s%.17g%s",
                        k   ? ", "
                        : i ? " ["
                            : "[[",
                        machine.body_state().M(order[i], order[k]) +
                            (i == k && i < 3 ? p.mode_kg : 0),
                        k < 5   ? ""
                        : i < 5 ? "],\n"
                                : "]]\n");
}

/* Prints hexid's settings for the joint axes of a drawing: level at neutral, and across the leg. */
static void print_joint_axes(const Setup &setup)
{
    const auto parameters = make_parameters(setup, draw_base(setup));
    for (const char *end : {"upper", "lower"}) {
        std::printf("geometry.%s_joint_axes=", end);
        for (int i = 0; i < kLegs; i++) {
            const Vec3 across = Vec3::UnitZ()
                                    .cross(parameters.bodies.a.col(i) - parameters.bodies.b.col(i))
                                    .normalized();
            std::printf("%s[%.9g, %.9g, 0]", i ? ", " : "[", across.x(), across.y());
        }
        std::puts("]");
    }
}

static const char kDefaults[] = "config/tian2015.yaml"; /* hexid's own defaults */
static const char kUsage[] = "usage: rig -o DIR [--config FILE] [--motion SPEC ...] [--effect "
                             "NAME.KEY=V[,V2..V6] ...] [--set KEY=VALUE ...]\n"
                             "           [--tolerance SEED | --beyond SEED] [--noise SEED] "
                             "[--settle S] [--step S] [--engage]\n"
                             "       rig --joint-axes [--config FILE]\n"
                             "       rig --inertia-matrix [--config FILE] [--effect ...] "
                             "[--set ...] [--tolerance SEED | --beyond SEED]\n"
                             "       rig --self-test [--config FILE]     rig --list-effects\n"
                             "FILE: its keys replace those of config/tian2015.yaml, which is read "
                             "first.\n"
                             "SPEC: sines (default), sine:AXIS:HZ:AMPL, multisine[:SCALE], "
                             "triangle:AXIS:HZ:AMPL, chirp:AXIS:HZ:HZ:AMPL,\n"
                             "      steps:AXIS:AMPL:HOLD_S. AXIS: x y z phi theta psi. One file a "
                             "test; truth.json goes beside DIR.\n";

static int main_with(int argc, char **argv)
{
    Setup setup;
    std::string directory, config;
    std::vector<std::string> specs, sets;
    bool test = false, matrix = false, axes = false;
    for (int k = 1; k < argc; k++) {
        const std::string option = argv[k];
        auto value = [&]() -> std::string {
            if (++k >= argc)
                throw std::runtime_error(option + " wants a value");
            return argv[k];
        };
        auto seed = [&] {
            const double n = number(value());
            if (!(n >= 0 && n == std::floor(n) && n < 1e15))
                throw std::runtime_error(option + ": a whole number from 0 up");
            return static_cast<int64_t>(n);
        };
        if (option == "-o")
            directory = value();
        else if (option == "--config" || option == "-c")
            config = value();
        else if (option == "--motion")
            specs.push_back(value());
        else if (option == "--effect")
            set_effect(setup.effects, value());
        else if (option == "--set")
            sets.push_back(value());
        else if (option == "--tolerance")
            setup.tolerance_seed = seed();
        else if (option == "--beyond")
            setup.beyond_seed = seed();
        else if (option == "--noise")
            setup.noise_seed = static_cast<uint64_t>(seed());
        else if (option == "--settle")
            setup.settle_s = number(value());
        else if (option == "--step")
            setup.step_s = number(value());
        else if (option == "--engage")
            setup.engage = true;
        else if (option == "--self-test")
            test = true;
        else if (option == "--inertia-matrix")
            matrix = true;
        else if (option == "--joint-axes")
            axes = true;
        else if (option == "--list-effects") {
            for (const auto &[key, off] : kEffects)
                std::printf("%s (off: %g)\n", key.c_str(), off);
            return 0;
        } else {
            std::fputs(kUsage, stderr);
            return 2;
        }
    }
    setup.settings.load(kDefaults);
    if (!config.empty())
        setup.settings.load(config);
    for (const std::string &set : sets)
        setup.settings.set(set);
    if (test)
        return self_test(setup.settings);
    if (matrix) {
        print_inertia_matrix(setup);
        return 0;
    }
    if (axes) {
        print_joint_axes(setup);
        return 0;
    }
    if (directory.empty()) {
        std::fputs(kUsage, stderr);
        return 2;
    }

    const std::filesystem::path path =
        std::filesystem::absolute(directory + "/").lexically_normal().parent_path();
    std::filesystem::create_directories(path);
    if (specs.empty())
        specs.push_back("sines");
    const auto motions = make_motions(setup.settings, specs, setup.noise_seed);
    const auto recordings = simulate(setup, motions);
    for (size_t k = 0; k < motions.size(); k++)
        write_csv((path / (std::to_string(k) + ".csv")).string(), motions[k], recordings[k]);
    write_truth((path.parent_path() / "truth.json").string(), setup);
    return 0;
}

int main(int argc, char **argv)
{
    try {
        return main_with(argc, argv);
    } catch (const std::exception &error) {
        std::fprintf(stderr, "rig: %s\n", error.what());
        return 2;
    }
}
