#include "machine.hpp"

#include <algorithm>
#include <cmath>

using Eigen::Dynamic;
using Row = Eigen::Matrix<double, 1, kMax>;

constexpr double kPi = 3.14159265358979323846;
constexpr double kOilDensity = 870, kOilViscosity = 4e-5; /* kg/m^3 and m^2/s, from docs/gap.md, The
                                                           * catalogue */
constexpr double kSupplyLag = 0.010; /* s, from docs/gap.md, The catalogue */
constexpr double kLaminarDrop =
    2e4; /* Pa: at smaller drops an orifice's flow changes smoothly from a root to a line */
constexpr double kVapour = -1.0e5; /* Pa gauge, lowest pressure, because oil bears no tension */
constexpr double kPlayStiffness = 1e8,
                 kPlayDamping = 2e4; /* steel on steel, where the backlash of a joint ends */
constexpr double kGiveDamping = 2e3; /* N s/m, of a leg that gives */
constexpr double kBendShare = 0.5; /* largest step, as a share of the distance in which a seal
                                    * deflects */
constexpr double kShortest = 1e-6; /* s: lower bound of the step that seals require, so that a
                                    * diverging run ends */
constexpr double kHeldSpeed = 1e-6; /* m/s, rad/s: a held element slower than this is at rest */
constexpr double kCrossing = 1e-11; /* m/s, rad/s: below this no reversal is counted */
constexpr double kLocated = 1e-4; /* share of a step's change of speed to which a reversal is
                                   * located */
constexpr double kForceShare =
    1e-6; /* relative accuracy of a holding force; projection removes the remaining motion */

static double orifice(double drop)
{
    const double size = std::abs(drop), z = size / kLaminarDrop;
    const double root =
        z >= 1 ? std::sqrt(size) : std::sqrt(kLaminarDrop) * z * (1.25 - 0.25 * z * z);
    return drop < 0 ? -root : root;
}

static double dead_band(double spool, double overlap)
{
    return spool > overlap ? spool - overlap : spool < -overlap ? spool + overlap : 0;
}

/* The valve's gain changes at an opening. Returns the opening with the first gain that lets as much
 * through. */
static double kinked(const LegParameters &leg, double opening)
{
    const double over = std::max(std::abs(opening) - leg.kink, 0.0);
    return opening + (leg.kink_gain - 1) * (opening > 0 ? over : -over);
}

/* Returns the spool position, without dead band, that lets as much through as this opening of the
 * first gain. */
static double unkinked(const LegParameters &leg, double opening)
{
    const double over = std::max(std::abs(opening) - leg.kink, 0.0);
    return opening + (1 / leg.kink_gain - 1) * (opening > 0 ? over : -over);
}

/* Returns the flow through the piston at a pressure difference: a gap's and an orifice's. */
static double leak_flow(const LegParameters &leg, double drop)
{
    return leg.leakage * drop + leg.turbulent * orifice(drop);
}

/* Returns the rate at which bristles or a seal bend, m/s: the rod's speed while they are straight,
 * zero once they bear the sliding force. Dahl 1968; LuGre contains this law. */
static double bend_rate(double rate, double stiffness, double sliding, double bend)
{
    return rate - stiffness * std::abs(rate) / sliding * bend;
}

/* Returns the force of a play's stops on what drives into them, towards positive gaps. */
static double contact_force(double gap, double gap_rate, double clearance)
{
    const double side = gap > 0 ? 1 : -1, deep = std::abs(gap) - clearance / 2;
    return deep > 0 ? side * std::max(kPlayStiffness * deep + kPlayDamping * side * gap_rate, 0.0)
                    : 0;
}

struct Flow {
    double a, b, from_supply, to_tank; /* flow into port A and into port B */
};

static Flow valve_flow(const LegParameters &leg, double spool, double pa, double pb, double supply,
                       double tank)
{
    const double x = kinked(leg, dead_band(spool, leg.overlap));
    Flow f;
    if (x > 0) {
        f.a = leg.gain_a * x * orifice(supply - pa);
        f.b = -leg.gain_b * x * orifice(pb - tank);
        f.from_supply = f.a;
        f.to_tank = -f.b;
    } else {
        f.a = leg.gain_a * x * orifice(pa - tank);
        f.b = -leg.gain_b * x * orifice(supply - pb);
        f.from_supply = f.b;
        f.to_tank = -f.a;
    }
    return f;
}

/* Starts at rest in the pose: leg forces follow from statics, and pressures and spools are such
 * that no net flow remains. */
Machine::Machine(const MachineParameters &given, const Vec6 &pose)
    : p(given), bodies(given.bodies), n(bodies.size())
{
    y.setZero();
    y.segment<6>(kQ) << pose[0], pose[1], pose[2], pose[5], pose[4], pose[3];
    base_load.setZero();

    const Coords still = Coords::Zero();
    Coords q = y.segment<kMax>(kQ);
    bodies.evaluate(q, still, now);
    for (int i = 0; i < kLegs; i++)
        q[kRod + i] = y[kQ + kRod + i] =
            now.length[i] + (p.leg[i].play > 0 ? p.leg[i].play / 2 : 0);
    bodies.evaluate(q, still, now);

    Coords load = now.bias;
    if (p.mode_kg > 0) {
        const Vec3 weight = p.mode_kg * p.bodies.gravity;
        y.segment<3>(kMode) = pose.head<3>() + weight.cwiseQuotient(p.mode_stiffness);
        load.head<3>() -= weight;
        load.segment<3>(kBase) -= weight;
    }
    load.head<6>() += p.stiffness.cwiseProduct(pose)({0, 1, 2, 5, 4, 3});
    base_load = load.segment<3>(kBase);
    const Vec6 force = now.length_row.leftCols<6>().transpose().fullPivLu().solve(load.head<6>());
    mass.compute(now.M.topLeftCorner(n, n));
    double seals = 0; /* bound of the squared frequencies of seals that act as springs, 1/s^2 */

    for (int i = 0; i < kLegs; i++) {
        const LegParameters &l = p.leg[i];
        const double f = force[i] + (l.loose() ? now.bias[kRod + i] : 0);
        double *s = &y[kLeg + kPerLeg * i];
        const double ratio2 =
            std::pow(l.gain_b / l.gain_a, 2); /* by continuity, equal oil flows out of A and into
                                               * B */
        double p2 = (l.area1 * (p.tank + ratio2 * p.supply) - f) / (l.area1 * ratio2 + l.area2);
        double p1 = p.tank + ratio2 * (p.supply - p2), sign = -1;
        if (p1 > p2) {
            p2 = (l.area1 * (p.supply + ratio2 * p.tank) - f) / (l.area1 * ratio2 + l.area2);
            p1 = p.supply - ratio2 * (p2 - p.tank);
            sign = 1;
        }
        const double flow = leak_flow(l, std::abs(p2 - p1));
        const double drop = sign < 0 ? p1 - p.tank : p.supply - p1;
        const double opening = unkinked(l, flow / (l.gain_a * orifice(drop)));
        const double spool = sign * (opening + l.overlap);
        s[kP1] = s[kLine1] = p1;
        s[kP2] = s[kLine2] = p2;
        s[kSpool] = spool;
        s[kFlow1] = sign * flow;
        s[kFlow2] = -sign * flow;
        y[kSupplyFlow] += flow;
        rest_valve[i] = spool - l.null_bias;
        held_command[i] = rest_valve[i];
        play_output[i].fill(rest_valve[i]);
        spool_target[i] = spool;
        if (l.loose_piston())
            s[kPiston] = std::copysign(l.piston_clearance / 2, f) + f / kPlayStiffness;

        if (l.coulomb_extend > 0 || l.coulomb_retract > 0 || l.stribeck > 0 || l.load_mu > 0 ||
            l.uneven > 0 || l.warming > 0)
            friction.push_back({true, i});
        if (l.joint_coulomb > 0)
            for (int k : {2 * i, 2 * i + 1, 12 + 2 * i, 12 + 2 * i + 1})
                friction.push_back({false, k});

        /* The step is limited by a hose's own frequency, with oil at both of its ends, and by the
         * contact in a joint's backlash. */
        if (l.pipe_length > 0) {
            const double section = kPi / 4 * l.pipe_diameter * l.pipe_diameter;
            const double inertance = kOilDensity * l.pipe_length / section;
            const double volume2 = l.dead2 + l.area2 * (l.half_stroke - now.rod[i] + l.middle);
            const double omega =
                std::sqrt(l.bulk / inertance * (1 / (section * l.pipe_length) + 1 / volume2));
            p.step = std::min(p.step, 0.5 / omega);
        }
        if (l.compliance > 0)
            p.step = std::min(p.step, 0.5 * std::sqrt(l.compliance * p.bodies.upper_kg[i]));
        if (l.play > 0)
            p.step = std::min(p.step, 0.5 / std::sqrt(kPlayStiffness / p.bodies.upper_kg[i]));
        if (l.loose_piston())
            p.step = std::min(p.step, 0.5 / std::sqrt(kPlayStiffness / l.piston_kg));
        const Row r = now.rod_row.row(i);
        seals += !l.dahl() ? 0
                           : std::max(l.dahl_extend, l.dahl_retract) / l.dahl_distance *
                                 r.head(n).dot(mass.solve(r.head(n).transpose()));
    }
    if (seals > 0)
        p.step = std::min(p.step, 0.5 / std::sqrt(seals));
}

Vec6 Machine::resting_valve() const
{
    return rest_valve;
}

void Machine::command(int leg, double valve)
{
    pending[leg].emplace_back(t + p.leg[leg].command_delay, std::clamp(valve, -1.0, 1.0));
}

void Machine::read(Vec6 &rod, Vec6 &p1, Vec6 &p2) const
{
    for (int i = 0; i < kLegs; i++) {
        const double *s = &y[kLeg + kPerLeg * i];
        const bool pipe = p.leg[i].pipe_length > 0;
        rod[i] = now.rod[i];
        p1[i] = s[pipe ? kLine1 : kP1];
        p2[i] = s[pipe ? kLine2 : kP2];
    }
}

double Machine::potential(const State &s) const
{
    const Vec6 e = s.segment<6>(kQ), k = p.stiffness({0, 1, 2, 5, 4, 3});
    const Vec3 base = s.segment<3>(kQ + kBase);
    return 0.5 * e.dot(k.cwiseProduct(e)) + 0.5 * p.base_stiffness * base.squaredNorm() -
           base_load.dot(base);
}

/* Solves Pt + R Q, with Q the return flow at that same pressure: a decreasing function, so Newton's
 * method is safe. */
double Machine::tank_pressure(const State &s, double supply) const
{
    double tank = p.tank;
    if (p.tank_resistance <= 0)
        return tank;
    auto miss = [&](double at) {
        double flow = 0;
        for (int i = 0; i < kLegs; i++) {
            const double *l = &s[kLeg + kPerLeg * i];
            const bool pipe = p.leg[i].pipe_length > 0;
            flow += valve_flow(p.leg[i], l[kSpool], l[pipe ? kLine1 : kP1], l[pipe ? kLine2 : kP2],
                               supply, at)
                        .to_tank;
        }
        return at - p.tank - p.tank_resistance * flow;
    };
    for (int k = 0; k < 12; k++) {
        const double f = miss(tank), slope = (miss(tank + 100) - f) / 100;
        tank -= f / slope;
        if (std::abs(f / slope) < 0.1)
            break;
    }
    return tank;
}

/* Kinetic energy of loose pistons, less the part that their rods have with them on. */
double Machine::piston_energy() const
{
    double sum = 0;
    for (int i = 0; i < kLegs; i++)
        if (p.leg[i].loose_piston())
            sum +=
                p.leg[i].piston_kg / 2 *
                (std::pow(y[kLeg + kPerLeg * i + kPistonRate], 2) - std::pow(now.rod_rate[i], 2));
    return sum;
}

/* Factorises the mass matrix. A loose piston has its own inertia along the leg, so the rod's is
 * less by it; its weight and its inertia across the leg stay with the rod. */
void Machine::loosen_pistons(Coords &total)
{
    Eigen::Matrix<double, kMax, kMax> M = now.M;
    for (int i = 0; i < kLegs; i++)
        if (p.leg[i].loose_piston()) {
            const auto r = now.rod_row.row(i);
            M -= p.leg[i].piston_kg * r.transpose() * r;
            total += p.leg[i].piston_kg * now.rod_bias[i] * r.transpose();
        }
    mass.compute(M.topLeftCorner(n, n));
}

/* Returns the command that reaches the spool's servo after a valve's hysteresis. */
double Machine::pass_valve(int leg, double command)
{
    const LegParameters &l = p.leg[leg];
    double &held = held_command[leg];
    held = std::clamp(held, command - l.hysteresis / 2, command + l.hysteresis / 2);
    if (l.rounded <= 0)
        return held;
    double sum = 0;
    for (int k = 0; k < kPlays; k++) { /* Prandtl and Ishlinskii: plays in parallel */
        const double half = l.rounded * (k + 0.5) / kPlays;
        double &out = play_output[leg][k];
        sum += out = std::clamp(out, held - half, held + half);
    }
    return sum / kPlays;
}

double Machine::capacity(const Friction &f, const State &s, int direction, double speed) const
{
    if (!f.cylinder)
        return p.leg[(f.index % 12) / 2].joint_coulomb;
    const LegParameters &l = p.leg[f.index];
    const double *leg = &s[kLeg + kPerLeg * f.index];
    const double z = std::pow(std::abs(speed / l.stribeck_velocity), l.stribeck_exponent);
    const double place = 2 * kPi * (now.rod[f.index] - l.middle) / l.uneven_wavelength;
    const double uneven = l.uneven * (1 + l.uneven_share * std::sin(place + l.uneven_phase));
    const double cold = (1 - l.warming_left) * std::exp(-now_s / l.warming_time);
    const double load = l.load_mu * (l.area1 - l.area2) * 0.5 * (leg[kP1] + leg[kP2]);
    return (direction > 0 ? l.coulomb_extend : l.coulomb_retract) + l.stribeck * std::exp(-z) +
           std::max(load, 0.0) + uneven + l.warming * (l.warming_left + cold);
}

Row Machine::row(const Friction &f) const
{
    if (f.cylinder)
        return now.rod_row.row(f.index);
    return now.joint_row.row(f.index);
}

double Machine::speed(const Friction &f) const
{
    return f.cylinder ? now.rod_rate[f.index] : row(f).head(n).dot(y.segment(kV, n));
}

/* Returns the force on the platform of the payload's part on springs, and writes that part's motion
 * into ds. */
Vec3 Machine::mode_force(const State &s, State &ds) const
{
    if (p.mode_kg <= 0)
        return Vec3::Zero();
    const Vec3 at = s.segment<3>(kQ) + s.segment<3>(kQ + kBase);
    const Vec3 rate = s.segment<3>(kV) + s.segment<3>(kV + kBase);
    const Vec3 force = p.mode_stiffness.cwiseProduct(s.segment<3>(kMode) - at) +
                       p.mode_damping.cwiseProduct(s.segment<3>(kMode + 3) - rate);
    ds.segment<3>(kMode) = s.segment<3>(kMode + 3);
    ds.segment<3>(kMode + 3) = p.bodies.gravity - force / p.mode_kg;
    return force;
}

void Machine::derivative(double at, const State &s, State &ds)
{
    const Coords q = s.segment<kMax>(kQ), v = s.segment<kMax>(kV);
    bodies.evaluate(q, v, now);
    now_s = at;
    ds.setZero();
    ds.segment(kQ, n) = v.head(n);

    const double supply = p.supply - p.supply_resistance * s[kSupplyFlow] +
                          p.ripple * std::sin(2 * kPi * p.ripple_hz * at);
    const double tank = tank_pressure(s, supply);
    double drawn = 0, piston_power = 0;
    Coords Q = Coords::Zero(); /* all forces except weight, inertia and springs */
    for (int i = 0; i < kLegs; i++) {
        const LegParameters &l = p.leg[i];
        const double *o = &s[kLeg + kPerLeg * i];
        double *d = &ds[kLeg + kPerLeg * i];
        const bool pipe = l.pipe_length > 0;
        const double stroke = now.rod[i] - l.middle, rate = now.rod_rate[i];

        /* Spool: second order, with limited speed and travel. */
        const double w = l.valve_omega;
        d[kSpool] = o[kSpoolRate];
        d[kSpoolRate] =
            w * w * (spool_target[i] - o[kSpool]) - 2 * l.valve_damping * w * o[kSpoolRate];
        if (l.rate_limit > 0) {
            d[kSpool] = std::clamp(d[kSpool], -l.rate_limit, l.rate_limit);
            if (std::abs(o[kSpoolRate]) >= l.rate_limit && o[kSpoolRate] * d[kSpoolRate] > 0)
                d[kSpoolRate] = 0;
        }

        /* Orifices, hose, chambers. */
        const Flow flow =
            valve_flow(l, o[kSpool], o[pipe ? kLine1 : kP1], o[pipe ? kLine2 : kP2], supply, tank);
        drawn += flow.from_supply;
        double q1 = flow.a, q2 = flow.b;
        if (pipe) {
            const double section = kPi / 4 * l.pipe_diameter * l.pipe_diameter,
                         volume = section * l.pipe_length;
            const double inertance = kOilDensity * l.pipe_length / section;
            const double resistance = 128 * kOilDensity * kOilViscosity * l.pipe_length /
                                      (kPi * std::pow(l.pipe_diameter, 4));
            q1 = o[kFlow1];
            q2 = o[kFlow2];
            d[kLine1] = l.bulk / volume * (flow.a - q1);
            d[kLine2] = l.bulk / volume * (flow.b - q2);
            d[kFlow1] = (o[kLine1] - o[kP1] - resistance * q1) / inertance;
            d[kFlow2] = (o[kLine2] - o[kP2] - resistance * q2) / inertance;
        }
        const double leak = leak_flow(l, o[kP2] - o[kP1]);
        const double at_oil = stroke + o[kPiston]; /* of the piston, which may be loose */
        const double sweep = l.loose_piston() ? o[kPistonRate] : rate;
        d[kP1] =
            l.bulk / (l.dead1 + l.area1 * (l.half_stroke + at_oil)) * (q1 - l.area1 * sweep + leak);
        d[kP2] =
            l.bulk / (l.dead2 + l.area2 * (l.half_stroke - at_oil)) * (q2 + l.area2 * sweep - leak);
        for (int k : {kP1, kP2, kLine1, kLine2})
            if (o[k] < kVapour && d[k] < 0)
                d[k] = 0;

        /* Forces on the rod: oil, viscous friction, end stops. */
        const double oil = l.area1 * o[kP1] - l.area2 * o[kP2];
        double force = oil - (rate > 0 ? l.viscous_extend : l.viscous_retract) * rate;
        if (l.loose_piston()) { /* half of the viscous friction is the piston's */
            const double drag = (sweep > 0 ? l.viscous_extend : l.viscous_retract) / 2 * sweep;
            const double push =
                contact_force(o[kPiston], sweep - rate, l.piston_clearance); /* on the rod */
            force = push - (rate > 0 ? l.viscous_extend : l.viscous_retract) / 2 * rate;
            d[kPiston] = sweep - rate;
            d[kPistonRate] = (oil - drag - push) / l.piston_kg;
            piston_power += (oil - drag - push) * sweep;
        }
        if (l.bristle > 0) { /* Canudas de Wit, Olsson, Astrom, Lischinsky 1995 */
            const double ratio = rate / l.bristle_velocity, stiffness = l.bristle / l.bristle_give;
            const double sliding = l.bristle + l.bristle_excess * std::exp(-ratio * ratio);
            d[kBristle] = bend_rate(rate, stiffness, sliding, o[kBristle]);
            force -= stiffness * o[kBristle] + l.bristle_damping * d[kBristle];
        }
        if (l.dahl()) {
            const double stiffness = 1 / l.dahl_distance; /* relative to a sliding force of 1 */
            const double z = stiffness * o[kSeal];
            d[kSeal] = bend_rate(rate, stiffness, 1, o[kSeal]);
            force -= (z > 0 ? l.dahl_extend : l.dahl_retract) * z;
        }
        const double over = std::abs(stroke) - l.half_stroke;
        if (over > 0) {
            const double side = stroke > 0 ? 1 : -1;
            force -= side * std::max(p.stop_stiffness * over + p.stop_damping * side * rate, 0.0);
        }
        Q.head(n) += now.rod_row.row(i).head(n).transpose() * force;

        if (l.compliance > 0) {
            const double push = (now.length[i] - now.rod[i]) / l.compliance +
                                kGiveDamping * (now.length_rate[i] - rate);
            Q.head(n) += (now.rod_row.row(i) - now.length_row.row(i)).head(n).transpose() * push;
        } else if (l.play > 0) {
            const double push =
                contact_force(now.length[i] - now.rod[i], now.length_rate[i] - rate, l.play);
            Q.head(n) += (now.rod_row.row(i) - now.length_row.row(i)).head(n).transpose() * push;
        }
        if (l.joint_viscous > 0)
            for (int k : {2 * i, 2 * i + 1, 12 + 2 * i, 12 + 2 * i + 1}) {
                const auto r = now.joint_row.row(k).head(n);
                Q.head(n) -= r.transpose() * (l.joint_viscous * r.dot(v.head(n)));
            }
    }
    ds[kSupplyFlow] = (drawn - s[kSupplyFlow]) / kSupplyLag;
    const Vec3 mode = mode_force(s, ds);
    Q.head<3>() += mode;
    if (n > 6)
        Q.segment<3>(kBase) += mode - p.base_damping * v.segment<3>(kBase);

    state_of_forces = &s;
    Coords accel = Coords::Zero(), spring = Coords::Zero();
    spring.head<6>() = -p.stiffness({0, 1, 2, 5, 4, 3}).cwiseProduct(q.head<6>());
    if (n > 6)
        spring.segment<3>(kBase) = base_load - p.base_stiffness * q.segment<3>(kBase);
    Coords total = Q + spring;
    total.head(n) -= now.bias.head(n);
    loosen_pistons(total);
    for (Friction &f : friction)
        if (f.mode != Friction::held) {
            const Row r = row(f);
            f.force = -f.mode * capacity(f, s, f.mode, f.cylinder ? now.rod_rate[f.index] : 0);
            total.head(n) += r.head(n).transpose() * f.force;
        }
    solve_friction(total, accel);
    ds.segment(kV, n) = accel.head(n);

    double power = Q.head(n).dot(v.head(n)) + piston_power;
    for (const Friction &f : friction)
        power += f.force * row(f).head(n).dot(v.head(n));
    ds[kWork] = power;
}

/* Elements at rest: each takes the force within its capacity that keeps it at rest, and accelerates
 * only if that is not enough. This is a box-constrained complementarity problem, solved by
 * projected Gauss-Seidel from the last solution. The accelerations are unique even if more elements
 * hold than there are degrees of freedom. */
void Machine::solve_friction(const Coords &total, Coords &accel)
{
    accel.head(n) = mass.solve(total.head(n));
    int count = 0;
    Friction *held[30];
    for (Friction &f : friction)
        if (f.mode == Friction::held)
            held[count++] = &f;
    if (count == 0)
        return;

    Eigen::Matrix<double, Dynamic, Dynamic, 0, kMax, 30> R(n, count), X(n, count);
    double low[30], high[30], bias[30], inverse_mass[30];
    for (int k = 0; k < count; k++) {
        R.col(k) = row(*held[k]).head(n).transpose();
        low[k] = -capacity(*held[k], *state_of_forces, 1, 0);
        high[k] = capacity(*held[k], *state_of_forces, -1, 0);
        bias[k] = held[k]->cylinder ? now.rod_bias[held[k]->index] : now.joint_bias[held[k]->index];
    }
    X = mass.solve(R);
    for (int k = 0; k < count; k++) {
        held[k]->force = std::clamp(held[k]->force, low[k], high[k]);
        accel.head(n) += X.col(k) * held[k]->force;
        inverse_mass[k] = R.col(k).dot(X.col(k));
    }
    for (int sweep = 0; sweep < 500; sweep++) {
        double change = 0;
        for (int k = 0; k < count; k++) {
            const double *r = &R(0, k), *x = &X(0, k);
            double miss = bias[k];
            for (int j = 0; j < n; j++)
                miss += r[j] * accel[j];
            const double force =
                std::clamp(held[k]->force - miss / inverse_mass[k], low[k], high[k]);
            const double by = force - held[k]->force;
            for (int j = 0; j < n; j++)
                accel[j] += x[j] * by;
            held[k]->force = force;
            change = std::max(change, std::abs(by) / (high[k] - low[k]));
        }
        if (change < kForceShare)
            break;
    }
}

Machine::State Machine::runge_kutta(double h)
{
    State k2, k3, k4;
    derivative(t + h / 2, y + h / 2 * k1, k2);
    derivative(t + h / 2, y + h / 2 * k2, k3);
    derivative(t + h, y + h * k3, k4);
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
}

void Machine::accept(const State &s, double h)
{
    y = s;
    t += h;
    steps++;
    for (int i = 0; i < kLegs; i++) {
        double *l = &y[kLeg + kPerLeg * i];
        if (std::abs(l[kSpool]) >= 1) { /* the spool is at its mechanical end */
            l[kSpool] = std::clamp(l[kSpool], -1.0, 1.0);
            if (l[kSpool] * l[kSpoolRate] > 0)
                l[kSpoolRate] = 0;
        }
    }
    derivative(t, y, k1);
    k1_known = true;
}

/* After a step, elements at rest that are loaded beyond their capacity start to slip; the others
 * stay at rest. */
void Machine::release_or_hold()
{
    Eigen::Matrix<double, Dynamic, Dynamic, 0, kMax, 30> R(n, 30), X;
    int count = 0;
    for (Friction &f : friction) {
        if (f.mode != Friction::held)
            continue;
        const double v = speed(f);
        const double low = -capacity(f, y, 1, 0), high = capacity(f, y, -1, 0),
                     tiny = 1e-9 * (high - low);
        const bool slips = (f.force <= low + tiny && v > 0) || (f.force >= high - tiny && v < 0);
        if (std::abs(v) > kHeldSpeed) {
            f.mode = v > 0 ? Friction::extending : Friction::retracting;
            k1_known = false;
        } else if (!slips)
            R.col(count++) = row(f).head(n).transpose();
    }
    if (count == 0)
        return;

    R.conservativeResize(n, count);
    X = mass.solve(R);
    Coords v = y.segment<kMax>(kV);
    for (int sweep = 0; sweep < 50; sweep++) {
        double most = 0;
        for (int k = 0; k < count; k++) {
            const double miss = R.col(k).dot(v.head(n));
            v.head(n) -= X.col(k) * (miss / R.col(k).dot(X.col(k)));
            most = std::max(most, std::abs(miss));
        }
        if (most < 1e-15)
            break;
    }
    y.segment<kMax>(kV) = v;
    if (k1_known)
        k1.segment(kQ, n) = v.head(n);
}

/* Takes one step of at most h. The step ends where a slipping element comes to rest, which is then
 * tried as held. */
void Machine::step(double h)
{
    const double end = t + h;
    for (int pass = 0; pass < 60 && end - t > 1e-12; pass++) {
        if (!k1_known)
            derivative(t, y, k1);
        k1_known = true;
        const State before = y, slope = k1;
        const double start = t;
        double take = end - t;
        std::vector<double> v0;
        for (const Friction &f : friction)
            v0.push_back(speed(f));

        /* Reversals: finds the earliest by regula falsi (Illinois) on the length of the step. */
        double lo = 0, hi = take, at_lo = 0, at_hi = 0, tolerance = 0;
        int crossing = -1;
        for (int k = 0; k < 60; k++) {
            accept(runge_kutta(take), take);
            int first = -1;
            double earliest = 2;
            for (size_t j = 0; j < friction.size(); j++) {
                const double v1 = speed(friction[j]);
                if (friction[j].mode == Friction::held || v1 * friction[j].mode >= -kCrossing)
                    continue;
                const double part = v0[j] * friction[j].mode <= 0 ? 0 : v0[j] / (v0[j] - v1);
                if (part < earliest) {
                    earliest = part;
                    first = static_cast<int>(j);
                }
            }
            if (first < 0 && crossing < 0)
                break;
            if (first >= 0 && first != crossing) { /* an element that reverses earlier than the ones
                                                    * found before */
                crossing = first;
                lo = 0;
                at_lo = v0[first] * friction[first].mode;
                hi = take;
                at_hi = speed(friction[first]) * friction[first].mode;
                tolerance = kLocated * std::abs(at_lo - at_hi) + kCrossing;
            } else {
                const double v = speed(friction[crossing]) * friction[crossing].mode;
                if (std::abs(v) <= tolerance || hi - lo < 1e-10)
                    break;
                if (v < 0) {
                    hi = take;
                    at_hi = v;
                    at_lo /= 2;
                } else {
                    lo = take;
                    at_lo = v;
                    at_hi /= 2;
                }
            }
            take = at_lo <= 0 ? 0 : std::clamp(lo + (hi - lo) * at_lo / (at_lo - at_hi), lo, hi);
            y = before;
            t = start;
            k1 = slope;
            if (take < 1e-10) { /* the element rests already at the start of the step */
                k1_known = false;
                break;
            }
        }
        if (crossing >= 0) {
            Friction &f = friction[crossing];
            f.force = -f.mode * capacity(f, y, f.mode, 0);
            f.mode = Friction::held;
            k1_known = false;
            events++;
        }
        if (!k1_known)
            derivative(t, y, k1);
        release_or_hold();
    }
}

/* Returns the longest step. Seals and bristles bend along the path, so a faster rod needs shorter
 * steps. */
double Machine::longest_step() const
{
    double h = p.step;
    for (int i = 0; i < kLegs; i++) {
        const LegParameters &l = p.leg[i];
        const double bends = std::min(l.dahl() ? l.dahl_distance : INFINITY,
                                      l.bristle > 0 ? l.bristle_give : INFINITY);
        h = std::min(h, std::max(kBendShare * bends / std::abs(now.rod_rate[i]), kShortest));
    }
    return h;
}

void Machine::advance(double until)
{
    while (until - t > 1e-12) {
        double next = until;
        for (int i = 0; i < kLegs; i++) {
            auto &queue = pending[i];
            const LegParameters &l = p.leg[i];
            while (!queue.empty() && queue.front().first <= t + 1e-12) {
                spool_target[i] =
                    std::clamp(pass_valve(i, queue.front().second) + l.null_bias, -1.0, 1.0);
                queue.pop_front();
                k1_known = false;
            }
            if (!queue.empty())
                next = std::min(next, queue.front().first);
        }
        const double left = next - t;
        step(left / std::ceil(left / longest_step() - 1e-9));
    }
}
