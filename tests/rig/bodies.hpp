/*
 * Rigid bodies of the six-leg platform, by Pinocchio. 13 bodies: the platform and, per leg, a lower
 * part on a universal joint and an upper part that slides in it. Pinocchio gives mass matrix and
 * bias of this open tree; here each leg is closed analytically, by writing its joint rates as a
 * linear function of the platform's rates.
 *
 * Generalised coordinates, kMax = 15:
 *   0..2    c, position of {M} in {B}, m, z down
 *   3..5    psi, theta, phi, rad, T = Rz(psi) Ry(theta) Rx(phi)
 *   6..8    displacement of the base plate, m
 *   9..14   extension of a rod with backlash at its end, m
 * Only the first six are used unless the base plate moves or a joint has backlash.
 */
#pragma once
#include <Eigen/Dense>
#include <array>
#include <memory>

constexpr int kLegs = 6, kMax = 15, kBase = 6, kRod = 9;
using Vec3 = Eigen::Vector3d;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Coords = Eigen::Matrix<double, kMax, 1>;
using Points = Eigen::Matrix<double, 3, kLegs>;

struct BodyParameters {
    double payload_kg;
    Vec3 payload_center;                /* centre of mass in {M}, m */
    Eigen::Matrix3d payload_inertia;    /* about the centre of mass, kg m^2 */
    Vec6 upper_kg, lower_kg;            /* rod and cylinder */
    Vec6 upper_inertia, lower_inertia;  /* transverse, about the part's own centre, kg m^2 */
    Vec6 upper_center, lower_center;    /* distance from the upper and from the lower joint, m */
    Points a, b;                        /* joints in {M} and in {B}, m */
    Vec3 gravity;                       /* in {B}, m/s^2 */
    double base_kg = 0;                /* mass of the base plate, used only if it moves */
    bool base_moves = false, play = false;
    std::array<bool, kLegs> has_play{};
};

/* Dynamics at one state: M dv/dt + bias = generalised forces, and the dependence of lengths and
 * joint angles on v. */
struct BodyState {
    Eigen::Matrix<double, kMax, kMax> M;
    Coords bias;
    Vec6 length, length_rate; /* joint to joint, m, m/s */
    Vec6 rod, rod_rate,
        rod_bias; /* piston against cylinder; d2(rod)/dt2 = rod_row dv/dt + rod_bias */
    Eigen::Matrix<double, 6, kMax> length_row, rod_row;
    Eigen::Matrix<double, 24, kMax>
        joint_row; /* rates about the two axes of 6 lower, then 6 upper joints, rad/s */
    Eigen::Matrix<double, 24, 1> joint_bias;
    Vec3 base_bias;
};

class Bodies
{
public:
    explicit Bodies(const BodyParameters &p);
    ~Bodies();
    int size() const; /* 6, or kMax */
    void evaluate(const Coords &q, const Coords &v, BodyState &out);
    double energy(const Coords &q, const Coords &v); /* kinetic and potential, J */

private:
    template <int N> void assemble(const Coords &q, const Coords &v, BodyState &out);
    struct Engine;
    std::unique_ptr<Engine> engine;
};
