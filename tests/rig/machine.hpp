/* The machine: rigid bodies, oil, valves, friction; continuous in time, driven by valve commands.
 * Equations of docs/method.md sections 1-3 and 5 and of the catalogue in docs/gap.md; README.md
 * states the decisions that these leave open. */
#pragma once
#include "bodies.hpp"

#include <array>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

/* Parameters of one leg, for the base and the hidden effects. SI. */
struct LegParameters {
    double area1, area2;         /* rodless side, rod side */
    double middle, half_stroke;  /* mid-stroke length and half the stroke, joint to joint, m */
    double dead1, dead2, bulk, leakage;
    double gain_a, gain_b; /* valve flow at full opening per sqrt(Pa) */
    double valve_omega, valve_damping, rate_limit /* 1/s, 0: none */, null_bias, overlap,
        hysteresis;
    double viscous_extend, viscous_retract;
    double coulomb_extend, coulomb_retract, stribeck, stribeck_velocity, load_mu;
    double stribeck_exponent;
    double uneven, uneven_share, uneven_wavelength, uneven_phase; /* N, share of it, m, rad */
    double warming, warming_time, warming_left; /* N at the start, s, share that is left at last */
    double bristle, bristle_excess, bristle_velocity, bristle_give, bristle_damping; /* LuGre */
    double dahl_extend, dahl_retract, dahl_distance;
    double joint_coulomb, joint_viscous; /* N m, N m s; for each of four axes per leg */
    double play; /* m, from stop to stop */
    double compliance; /* m/N, between rod and platform; 0: stiff */
    double pipe_length, pipe_diameter;
    double command_delay; /* s */
    double turbulent; /* leakage across the piston per sqrt(Pa) */
    double rounded; /* mean width of the plays whose outputs a rounded hysteresis averages */
    double kink, kink_gain; /* opening from which the valve has kink_gain of its gain */
    double piston_clearance, piston_kg; /* play of the piston on its rod, m; 0: tight */

    bool loose() const { return play > 0 || compliance > 0; } /* the rod moves by itself */
    bool dahl() const { return dahl_extend > 0 || dahl_retract > 0; }
    bool loose_piston() const { return piston_clearance > 0; }
};

struct MachineParameters {
    BodyParameters bodies;
    LegParameters leg[kLegs];
    double supply, tank, supply_resistance, tank_resistance; /* Pa, Pa s/m^3 */
    double ripple, ripple_hz;
    double stop_stiffness, stop_damping;
    Vec6 stiffness; /* x y z phi theta psi, N/m and N m/rad */
    double base_stiffness, base_damping; /* N/m, N s/m, each of three directions */
    Vec3 mode_stiffness, mode_damping; /* stiffness and damping of the payload's part on springs,
                                        * in the same units */
    double mode_kg; /* mass of that part, at the origin of {M}; 0: none */
    double step; /* longest step, s */
};

/* One element of dry friction: a cylinder or one axis of a universal joint. */
struct Friction {
    enum Mode { retracting = -1, held = 0, extending = 1 };
    bool cylinder;
    int index; /* leg, or row of joint_row */
    int mode = held;
    double force = 0; /* force while held; it points along the motion, so a negative force resists
                       * extending */
};

constexpr int kPlays = 16; /* of a rounded hysteresis */

class Machine
{
public:
    /* Flat state for the integrator. The legs' part has 12 numbers per leg; a loose piston has its
     * place on the rod and its speed in the cylinder. */
    enum {
        kP1,
        kP2,
        kSpool,
        kSpoolRate,
        kLine1,
        kLine2,
        kFlow1,
        kFlow2,
        kBristle,
        kSeal,
        kPiston,
        kPistonRate,
        kPerLeg
    };
    enum {
        kQ = 0,
        kV = kMax,
        kLeg = 2 * kMax,
        kSupplyFlow = kLeg + kPerLeg * kLegs,
        kMode, /* position and velocity in {B} of the payload's part on springs */
        kWork = kMode + 6,
        kState
    };
    using State = Eigen::Matrix<double, kState, 1>;

    Machine(const MachineParameters &p, const Vec6 &pose);
    void command(int leg, double valve); /* takes effect after the leg's delay */
    void advance(double until_s);

    double time() const { return t; }
    double pose(int i) const { return y[kQ + (i < 3 ? i : 8 - i)]; } /* x y z phi theta psi */
    void read(Vec6 &rod, Vec6 &p1, Vec6 &p2) const; /* ideal sensor readings */
    double rate(int leg) const { return now.rod_rate[leg]; }
    double longest_step() const; /* longest step allowed from this state, s */
    double energy()
    {
        return bodies.energy(y.segment<kMax>(kQ), y.segment<kMax>(kV)) + potential(y) +
               piston_energy();
    }
    double work() const { return y[kWork]; } /* work of all forces that energy() omits */
    const BodyState &body_state() const { return now; }
    Vec6 resting_valve() const; /* commands that held the legs at the start */

    State y;
    BodyState now;
    long events = 0, steps = 0;

private:
    void derivative(double at, const State &s, State &ds);
    void solve_friction(const Coords &free_force, Coords &accel);
    double capacity(const Friction &f, const State &s, int direction, double speed) const;
    double speed(const Friction &f) const;
    Eigen::Matrix<double, 1, kMax> row(const Friction &f) const;
    State runge_kutta(double h);
    void step(double h);
    void accept(const State &s, double h);
    void release_or_hold();
    double potential(const State &s) const;
    double piston_energy() const;
    void loosen_pistons(Coords &total);
    double pass_valve(int leg, double command);
    Vec3 mode_force(const State &s, State &ds) const;
    double tank_pressure(const State &s, double supply) const;

    MachineParameters p;
    Bodies bodies;
    int n;
    double t = 0;
    State k1;
    bool k1_known = false;
    double spool_target[kLegs] = {}, held_command[kLegs] = {};
    std::array<double, kPlays> play_output[kLegs];
    double now_s = 0; /* time at which `now` was evaluated */
    std::deque<std::pair<double, double>> pending[kLegs];
    std::vector<Friction> friction;
    const State *state_of_forces = nullptr;
    Eigen::LLT<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMax, kMax>> mass;
    Vec6 rest_valve;
    Vec3 base_load;
};
