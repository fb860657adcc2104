#include "bodies.hpp"

#include <pinocchio/multibody.hpp>
/* after multibody.hpp */
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/energy.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <string>

namespace pin = pinocchio;
using Eigen::Matrix;
using Eigen::Matrix3d;

struct Bodies::Engine {
    BodyParameters p;
    pin::Model model;
    pin::Data data;
    Eigen::VectorXd q, v;
    std::array<Matrix3d, kLegs>
        frame;        /* axes of a leg's base joint in {B}: z along the neutral leg, x level */
    int platform = 0; /* index of the platform's first velocity */
};

static Matrix3d diagonal(double x, double y, double z)
{
    return Vec3(x, y, z).asDiagonal().toDenseMatrix();
}

Bodies::Bodies(const BodyParameters &p) : engine(new Engine)
{
    Engine &e = *engine;
    e.p = p;
    pin::Model &m = e.model;
    m.gravity.linear() = p.gravity;

    pin::JointIndex ground = 0;
    if (p.base_moves) {
        ground = m.addJoint(0, pin::JointModelTranslation(), pin::SE3::Identity(), "base");
        m.appendBodyToJoint(ground, pin::Inertia(p.base_kg, Vec3::Zero(), Matrix3d::Identity()));
        e.platform = 3;
    }
    pin::JointIndex j =
        m.addJoint(ground, pin::JointModelTranslation(), pin::SE3::Identity(), "position");
    j = m.addJoint(j, pin::JointModelSphericalZYX(), pin::SE3::Identity(), "orientation");
    m.appendBodyToJoint(j, pin::Inertia(p.payload_kg, p.payload_center, p.payload_inertia));

    for (int i = 0; i < kLegs; i++) {
        const std::string n = std::to_string(i + 1);
        const Vec3 z = (p.a.col(i) - p.b.col(i)).normalized();
        const Vec3 x = Vec3::UnitZ().cross(z).normalized();
        e.frame[i] << x, z.cross(x), z;
        j = m.addJoint(ground, pin::JointModelUniversal(Vec3::UnitX(), Vec3::UnitY()),
                       pin::SE3(e.frame[i], p.b.col(i)), "joint" + n);
        m.appendBodyToJoint(j, pin::Inertia(p.lower_kg[i], Vec3(0, 0, p.lower_center[i]),
                                            diagonal(p.lower_inertia[i], p.lower_inertia[i], 0)));
        j = m.addJoint(j, pin::JointModelPZ(), pin::SE3::Identity(), "rod" + n);
        m.appendBodyToJoint(j, pin::Inertia(p.upper_kg[i], Vec3(0, 0, -p.upper_center[i]),
                                            diagonal(p.upper_inertia[i], p.upper_inertia[i], 0)));
    }
    e.data = pin::Data(m);
    e.q = Eigen::VectorXd::Zero(m.nq);
    e.v = Eigen::VectorXd::Zero(m.nv);
}

Bodies::~Bodies() = default;

int Bodies::size() const
{
    return engine->p.base_moves || engine->p.play ? kMax : 6;
}

void Bodies::evaluate(const Coords &q, const Coords &v, BodyState &out)
{
    if (size() == 6)
        assemble<6>(q, v, out);
    else
        assemble<kMax>(q, v, out);
}

/* Assembles the dynamics. q1 and q2 are the angles of the lower joint and r the distance from it. A
 * point on the leg's axis is X = r (s2, -s1 c2, c1 c2) in the leg's frame. Its derivatives e1, e2,
 * n by q1, q2, r are orthogonal, which solves the closure: joint rates = K v, joint accelerations =
 * K dv/dt + kappa. */
template <int N> void Bodies::assemble(const Coords &q, const Coords &v, BodyState &out)
{
    Engine &e = *engine;
    const BodyParameters &p = e.p;
    const int o = e.platform;
    Matrix<double, 3, N> K[kLegs];
    Vec3 kappa[kLegs];

    const double sps = std::sin(q[3]), cps = std::cos(q[3]), sth = std::sin(q[4]),
                 cth = std::cos(q[4]);
    const double sph = std::sin(q[5]), cph = std::cos(q[5]);
    Matrix3d T;
    T << cps * cth, cps * sth * sph - sps * cph, cps * sth * cph + sps * sph, sps * cth,
        sps * sth * sph + cps * cph, sps * sth * cph - cps * sph, -sth, cth * sph, cth * cph;
    Matrix3d W; /* omega = W d(psi, theta, phi)/dt */
    W.col(0) = Vec3::UnitZ();
    W.col(1) = Vec3(-sps, cps, 0);
    W.col(2) = T.col(0);
    const Vec3 omega = W * v.segment<3>(3);
    const Vec3 turning = Vec3::UnitZ() * v[3];
    const Vec3 omega_bias =
        turning.cross(W.col(1)) * v[4] + (turning + W.col(1) * v[4]).cross(W.col(2)) * v[5];

    if (p.base_moves) {
        e.q.head<3>() = q.segment<3>(kBase);
        e.v.head<3>() = v.segment<3>(kBase);
    }
    e.q.segment<6>(o) = q.head<6>();
    e.v.segment<6>(o) = v.head<6>();

    for (int i = 0; i < kLegs; i++) {
        const Matrix3d &R = e.frame[i];
        const Vec3 arm = T * p.a.col(i);
        const Vec3 l = R.transpose() * (q.head<3>() + arm - p.b.col(i));
        Matrix<double, 3, 6> Ja; /* velocity of the upper joint's point in the leg's frame */
        Ja << R.transpose(), R.transpose() * (Matrix3d() << W.col(0).cross(arm),
                                              W.col(1).cross(arm), W.col(2).cross(arm))
                                                 .finished();
        const Vec3 rate = Ja * v.template head<6>();
        const Vec3 accel = R.transpose() * (omega_bias.cross(arm) + omega.cross(omega.cross(arm)));

        const double L = l.norm(), s2 = l.x() / L, c2 = std::sqrt(1 - s2 * s2);
        const double s1 = -l.y() / (L * c2), c1 = l.z() / (L * c2);
        const Vec3 n(s2, -s1 * c2, c1 * c2), x1(0, -c1, -s1),
            x2(c2, s1 * s2, -c1 * s2); /* e1 = L c2 x1, e2 = L x2 */
        const double w1 = x1.dot(rate) / (L * c2), w2 = x2.dot(rate) / L, Ld = n.dot(rate);
        const Vec3 curl = L * (w1 * w1 * Vec3(0, s1 * c2, -c1 * c2) - w2 * w2 * n) +
                          2 * w1 * w2 * L * Vec3(0, c1 * s2, s1 * s2) +
                          2 * Ld * (w1 * c2 * x1 + w2 * x2);
        const Vec3 rest = accel - curl;

        K[i].setZero();
        K[i].row(0).template head<6>() = x1.transpose() * Ja / (L * c2);
        K[i].row(1).template head<6>() = x2.transpose() * Ja / L;
        const Matrix<double, 1, 6> along = n.transpose() * Ja;
        kappa[i] << x1.dot(rest) / (L * c2), x2.dot(rest) / L, n.dot(rest);
        out.length[i] = out.rod[i] = L;
        out.length_rate[i] = out.rod_rate[i] = Ld;
        out.length_row.row(i).setZero();
        out.length_row.row(i).template head<6>() = along;
        if (N > 6 && p.has_play[i]) {
            K[i](2, std::min(kRod + i, N - 1)) = 1;
            kappa[i][2] = 0;
            out.rod[i] = q[kRod + i];
            out.rod_rate[i] = v[kRod + i];
        } else
            K[i].row(2).template head<6>() = along;
        out.rod_row.template block<1, N>(i, 0) = K[i].row(2);
        out.rod_bias[i] = kappa[i][2];

        /* the relative rotation at the upper joint is about two axes, one fixed to the rod and one
         * across it; the rod spins freely */
        const Vec3 t1(c2, s1 * s2, -c1 * s2), t2(0, c1, s1); /* columns x and y of the lower body */
        const Matrix3d Wl = R.transpose() * W;
        for (int k = 0; k < 2; k++) {
            const Vec3 t = k == 0 ? t1 : t2;
            out.joint_row.template block<1, N>(2 * i + k, 0) = K[i].row(k);
            out.joint_bias[2 * i + k] = kappa[i][k];
            out.joint_row.row(12 + 2 * i + k).setZero();
            out.joint_row.row(12 + 2 * i + k).template head<6>() = -t.cross(n).transpose() * Ja / L;
            out.joint_row.row(12 + 2 * i + k).template segment<3>(3) += t.transpose() * Wl;
            out.joint_bias[12 + 2 * i + k] =
                0; /* products of rates are neglected; the projection of held elements removes the
                    * error */
        }
        const int at = o + 6 + 3 * i;
        e.q.segment<3>(at) << std::atan2(s1, c1), std::asin(s2), out.rod[i];
        e.v.segment<3>(at) << w1, w2, out.rod_rate[i];
    }

    pin::crba(e.model, e.data, e.q, pin::Convention::LOCAL); /* upper triangle */
    pin::nonLinearEffects(e.model, e.data, e.q, e.v);
    const auto &H = e.data.M;
    const auto &h = e.data.nle;

    auto M = out.M.template topLeftCorner<N, N>();
    auto bias = out.bias.template head<N>();
    M.setZero();
    bias.setZero();
    M.template topLeftCorner<6, 6>() = H.block<6, 6>(o, o).template selfadjointView<Eigen::Upper>();
    bias.template head<6>() = h.segment<6>(o);
    for (int i = 0; i < kLegs; i++) {
        const int at = o + 6 + 3 * i;
        const Matrix3d leg = H.block<3, 3>(at, at).selfadjointView<Eigen::Upper>();
        const Matrix<double, 3, N> leg_K = leg * K[i];
        M.noalias() += K[i].transpose() * leg_K;
        bias.noalias() += K[i].transpose() * (leg * kappa[i] + h.segment<3>(at));
    }
    if constexpr (N > 6) {
        for (int i = 0; i < kLegs; i++)
            if (!p.has_play[i])
                M(kRod + i, kRod + i) = 1; /* unused */
        if (p.base_moves) {
            Matrix<double, 3, N> cross = Matrix<double, 3, N>::Zero();
            cross.template leftCols<6>() = H.block<3, 6>(0, o);
            bias.template segment<3>(kBase) = h.head<3>();
            for (int i = 0; i < kLegs; i++) {
                const Matrix3d leg = H.block<3, 3>(0, o + 6 + 3 * i);
                cross += leg * K[i];
                bias.template segment<3>(kBase) += leg * kappa[i];
            }
            M.template block<3, N>(kBase, 0) += cross;
            M.template block<N, 3>(0, kBase) += cross.transpose();
            M.template block<3, 3>(kBase, kBase) =
                H.block<3, 3>(0, 0).template selfadjointView<Eigen::Upper>();
        } else
            M.template block<3, 3>(kBase, kBase).setIdentity();
    }
}

double Bodies::energy(const Coords &q, const Coords &v)
{
    BodyState s;
    evaluate(q, v, s);
    return pin::computeKineticEnergy(engine->model, engine->data, engine->q, engine->v) +
           pin::computePotentialEnergy(engine->model, engine->data, engine->q);
}
