/*
 * The rig round the machine: hidden effects, drawn base parameters, sensors, controller,
 * motions.
 */
#pragma once
#include "machine.hpp"
#include "settings.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

constexpr double kPeriod = 0.002; /* s: the paper's sampling period */
extern const char *const kAxes[6];

/* The catalogue of docs/gap.md and further effects (README.md): each key with the value that
 * switches it off. */
extern const std::map<std::string, double> kEffects;

using Effects = std::map<std::string, Vec6>; /* hidden effects by "name.key", one value per leg */

/* Uniform random numbers, the same on every computer. */
struct Random {
    explicit Random(uint64_t seed) : state(seed * 0x9E3779B97F4A7C15ull + 0x632BE59BD9B4E019ull) {}
    double uniform(double low, double high);
    uint64_t state;
};

struct Setup {
    Settings settings;
    Effects effects;
    int64_t tolerance_seed = -1,
            beyond_seed = -1; /* a negative seed keeps the configuration's exact parameters */
    uint64_t noise_seed = 1;
    double step_s = 0.25e-3, settle_s = -1; /* settle_s below 0: the configuration's value */
    bool engage = false; /* start parked and rise; otherwise start at neutral */
};

/* Drawn base parameters, relative to the configuration's unless a unit is given. */
struct Base {
    double payload = 1, upper = 1, lower = 1, supply = 1;
    Vec6 viscous, bulk, leakage, gain, dead1, dead2, null_bias, damping;
    Points a, b; /* errors of the joints, m */
    bool jitter = false;
};

struct Motion {
    std::string dof = "none";
    double frequency = 0, amplitude = 0; /* values for the file's header, of sines only */
    double ramp_s = 0, duration_s = 0, ramp_out_s = 0, length_s = 0;
    std::function<Vec6(double)> reference; /* pose x y z phi theta psi at a time from 0 to
                                            * length_s */
};

struct Sample {
    double t;
    Vec6 reference, length, p1, p2, valve;
};
using Recording = std::vector<Sample>;

/* The machine with its sensors, driven one sampling period at a time. */
class Rig
{
public:
    Rig(const Setup &setup, const Base &base, const Vec6 &pose); /* at rest in this pose */
    ~Rig();
    void measure(Sample &out);     /* lengths and pressures at the present instant */
    void step(const Vec6 &valve);  /* one period with these commands; throws if it diverges */
    const Machine &machine() const { return plant; }

private:
    class Sensors;
    const Setup setup;
    Machine plant;
    std::unique_ptr<Sensors> sensors;
    long cycle = 0;
};

double effect(const Setup &setup, const std::string &key, int leg = 0);
void set_effect(Effects &effects,
                const std::string &assignment); /* "name.key=v" or "name.key=v1,...,v6" */

Base draw_base(const Setup &setup);
MachineParameters make_parameters(const Setup &setup, const Base &base);
Vec6 leg_lengths(const Points &a, const Points &b, const Vec6 &pose);

Motion sine(const Settings &s, const std::string &axis, double frequency, double amplitude);
std::vector<Motion> make_motions(const Settings &s, const std::vector<std::string> &specs,
                                 uint64_t seed);
std::vector<Recording> simulate(const Setup &setup, const std::vector<Motion> &motions);
int self_test(const Settings &settings);
