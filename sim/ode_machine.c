#include "ode_machine.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

#include "params.h"

static const double AXIAL_SHARE = 4e-6;         /* axial inertia of a leg's part, as a share of its
                                                 * transverse inertia; the closed-form engine
                                                 * neglects it */
static const double JOINT_ERP = 0.2;
static const double JOINT_CFM = 1e-10;
static const double PISTON_MOTOR_CFM = 1e-13;   /* m/s per N: a stuck leg under 10 kN
                                                 * creeps 10 nm in 10 s */

/* Protects ODE's count of its users, which ODE itself does not lock. */
static pthread_mutex_t ode_users = PTHREAD_MUTEX_INITIALIZER;

/* Drops ODE's messages. Its solver prints one when it gives up a step, but the loop's thread must
 * not print. Such a step is noticed anyway, because lengths and pose then disagree. */
static void no_message(int number, const char *format, va_list args) {
    (void)number;
    (void)format;
    (void)args;
}

static int ode_open(void) {
    pthread_mutex_lock(&ode_users);
    int opened = dInitODE2(0);
    dSetMessageHandler(no_message);
    pthread_mutex_unlock(&ode_users);
    return opened ? 0 : -1;
}

static void ode_close(void) {
    pthread_mutex_lock(&ode_users);
    dCloseODE();
    pthread_mutex_unlock(&ode_users);
}

/* ---- placing ---- */

static void rotate_platform(dBodyID platform, const double pose[DOFS]) {
    double cf = cos(pose[DOF_PHI]), sf = sin(pose[DOF_PHI]), ct = cos(pose[DOF_THETA]), st = sin(pose[DOF_THETA]);
    double cp = cos(pose[DOF_PSI]), sp = sin(pose[DOF_PSI]);
    /* clang-format off */
    const dMatrix3 rotation = {cp * ct, cp * st * sf - sp * cf, cp * st * cf + sp * sf, 0,
                               sp * ct, sp * st * sf + cp * cf, sp * st * cf - cp * sf, 0,
                               -st,     ct * sf,                ct * cf,                0};
    /* clang-format on */
    dBodySetRotation(platform, rotation);
}

/* Computes the vector from the origin of {M} to the payload's mass centre, in {B}. */
static void payload_center(const struct ode_machine *m, dVector3 center) {
    const double *c = m->machine.bodies.payload_center_m;
    dBodyVectorToWorld(m->body[PLATFORM], c[0], c[1], c[2], center);
}

void ode_machine_joint(const struct ode_machine *m, int leg, dVector3 point) {
    const double *a = m->machine.bodies.upper_joint_m[leg], *center = m->machine.bodies.payload_center_m;
    dBodyGetRelPointPos(m->body[PLATFORM], a[0] - center[0], a[1] - center[1], a[2] - center[2], point);
}

static void upper_joint(const struct ode_machine *m, int leg, dVector3 point, dVector3 first) {
    const double *inside = m->geometry.upper_axis[leg];
    ode_machine_joint(m, leg, point);
    dBodyVectorToWorld(m->body[PLATFORM], inside[0], inside[1], inside[2], first);
}

static void place_part(dBodyID body, const dVector3 joint, double distance, const dVector3 along, const dVector3 first) {
    dVector3 x, y;
    dCalcVectorCross3(x, first, along);
    dNormalize3(x);
    dCalcVectorCross3(y, along, x);
    const dMatrix3 rotation = {x[0], y[0], along[0], 0, x[1], y[1], along[1], 0, x[2], y[2], along[2], 0};
    dBodySetRotation(body, rotation);
    dBodySetPosition(body, joint[0] + distance * along[0], joint[1] + distance * along[1], joint[2] + distance * along[2]);
}

static void place_leg(struct ode_machine *m, int leg, double ahead_m) {
    dVector3 a, along, first_upper;
    const double *first_lower = m->geometry.lower_axis[leg];
    upper_joint(m, leg, a, first_upper);
    dSubtractVectors3(along, a, m->machine.bodies.lower_joint_m[leg]);
    dNormalize3(along);
    place_part(m->body[CYLINDER + leg], m->machine.bodies.lower_joint_m[leg], m->params->actuator.lower_center_m[leg], along, first_lower);
    place_part(m->body[ROD + leg], a, ahead_m - m->params->actuator.upper_center_m[leg], along, first_upper);
}

void ode_machine_place(struct ode_machine *m, const double pose[DOFS], const double ahead_m[LEGS]) {
    dVector3 center;
    rotate_platform(m->body[PLATFORM], pose);
    payload_center(m, center);
    dBodySetPosition(m->body[PLATFORM], pose[DOF_X] + center[0], pose[DOF_Y] + center[1], pose[DOF_Z] + center[2]);
    for (int leg = 0; leg < LEGS; leg++) place_leg(m, leg, ahead_m[leg]);
}

/* ---- reading ---- */

void ode_machine_pose(const struct ode_machine *m, double pose[DOFS]) {
    const dReal *r = dBodyGetRotation(m->body[PLATFORM]);
    dVector3 center;
    payload_center(m, center);
    for (int i = 0; i < 3; i++) pose[i] = dBodyGetPosition(m->body[PLATFORM])[i] - center[i];
    pose[DOF_PHI] = atan2(r[9], r[10]);
    pose[DOF_THETA] = atan2(-r[8], hypot(r[9], r[10]));
    pose[DOF_PSI] = atan2(r[4], r[0]);
}

void ode_machine_axis(const struct ode_machine *m, int leg, dVector3 axis) {
    const dReal *r = dBodyGetRotation(m->body[CYLINDER + leg]);
    axis[0] = r[2];
    axis[1] = r[6];
    axis[2] = r[10];
}

double ode_machine_length(const struct ode_machine *m, int leg, const dVector3 axis) {
    dVector3 apart;
    dSubtractVectors3(apart, dBodyGetPosition(m->body[ROD + leg]), dBodyGetPosition(m->body[CYLINDER + leg]));
    return m->params->actuator.lower_center_m[leg] + dCalcVectorDot3(apart, axis) + m->params->actuator.upper_center_m[leg];
}

/* Returns the sum of mass times depth over all bodies. */
static double moment_of_mass(const struct ode_machine *m) {
    const double *down = m->machine.bodies.down;
    double sum = m->machine.bodies.payload_kg * dCalcVectorDot3(dBodyGetPosition(m->body[PLATFORM]), down);
    for (int leg = 0; leg < LEGS; leg++) {
        sum += m->machine.bodies.lower_kg[leg] * dCalcVectorDot3(dBodyGetPosition(m->body[CYLINDER + leg]), down) +
               m->machine.bodies.upper_kg[leg] * dCalcVectorDot3(dBodyGetPosition(m->body[ROD + leg]), down);
    }
    return sum;
}

double ode_machine_potential(const struct ode_machine *m) {
    return m->machine.bodies.gravity_mps2 * (m->neutral_moment_kg_m - moment_of_mass(m));
}

void ode_machine_twist(const struct velocity *platform, const struct ode_machine *m, double twist[DOFS]) {
    dVector3 center, swing;
    payload_center(m, center);
    dCalcVectorCross3(swing, platform->angular, center);
    for (int i = 0; i < 3; i++) {
        twist[i] = platform->linear[i] - swing[i];
        twist[3 + i] = platform->angular[i];
    }
}

void ode_machine_pull(struct ode_machine *m, const double pull[3]) {
    double gravity = sqrt(pull[0] * pull[0] + pull[1] * pull[1] + pull[2] * pull[2]);
    m->machine.bodies.gravity_mps2 = gravity;
    for (int i = 0; i < 3; i++) m->machine.bodies.down[i] = gravity > 0.0 ? pull[i] / gravity : 0.0;
    dWorldSetGravity(m->world, pull[0], pull[1], pull[2]);
}

void ode_machine_load(struct ode_machine *m) {
    if (m->machine.wrench.count == 0) return;
    double pose[DOFS], wrench[DOFS] = {0};
    ode_machine_pose(m, pose);
    machine_wrench(&m->machine, pose, wrench);
    dBodyAddForceAtPos(m->body[PLATFORM], wrench[0], wrench[1], wrench[2], pose[0], pose[1], pose[2]);
    dBodyAddTorque(m->body[PLATFORM], wrench[3], wrench[4], wrench[5]);
}

struct velocity ode_machine_velocity(const struct ode_machine *m, int body) {
    struct velocity v;
    memcpy(v.linear, dBodyGetLinearVel(m->body[body]), sizeof v.linear);
    memcpy(v.angular, dBodyGetAngularVel(m->body[body]), sizeof v.angular);
    return v;
}

void ode_machine_set_velocity(struct ode_machine *m, int body, const struct velocity *v, double scale) {
    dBodySetLinearVel(m->body[body], scale * v->linear[0], scale * v->linear[1], scale * v->linear[2]);
    dBodySetAngularVel(m->body[body], scale * v->angular[0], scale * v->angular[1], scale * v->angular[2]);
}

/* ---- making ---- */

static void make_body(struct ode_machine *m, int body, double mass_kg, const double square[3], const double product[3]) {
    dMass mass;
    dMassSetParameters(&mass, mass_kg, 0, 0, 0, square[0], square[1], square[2], product[0], product[1], product[2]);
    m->body[body] = dBodyCreate(m->world);
    dBodySetMass(m->body[body], &mass);
}

static void make_leg(struct ode_machine *m, int leg) {
    const struct actuator_params *a = &m->params->actuator;
    double lower = a->lower_inertia_kg_m2[leg] + m->machine.bodies.transverse_kg_m2[leg], upper = a->upper_inertia_kg_m2[leg];
    make_body(m, CYLINDER + leg, m->machine.bodies.lower_kg[leg], (double[3]){lower, lower, AXIAL_SHARE * lower}, (double[3]){0});
    make_body(m, ROD + leg, m->machine.bodies.upper_kg[leg], (double[3]){upper, upper, AXIAL_SHARE * upper}, (double[3]){0});
}

static void make_bodies(struct ode_machine *m) {
    make_body(m, PLATFORM, m->machine.bodies.payload_kg, m->machine.bodies.payload_inertia_kg_m2, m->machine.bodies.payload_products_kg_m2);
    for (int leg = 0; leg < LEGS; leg++) make_leg(m, leg);
}

static void make_universal(struct ode_machine *m, dBodyID one, dBodyID two, const dVector3 point, const dVector3 axis1,
                           const dVector3 axis2) {
    dJointID joint = dJointCreateUniversal(m->world, NULL);
    dJointAttach(joint, one, two);
    dJointSetUniversalAnchor(joint, point[0], point[1], point[2]);
    dJointSetUniversalAxis1(joint, axis1[0], axis1[1], axis1[2]);
    dJointSetUniversalAxis2(joint, axis2[0], axis2[1], axis2[2]);
}

/* Makes a universal joint that also slides along the leg, for a leg with backlash. */
static void make_loose(struct ode_machine *m, dBodyID rod, dBodyID platform, const dVector3 point, const dVector3 axis1,
                       const dVector3 axis2, const dVector3 along) {
    dJointID joint = dJointCreatePU(m->world, NULL);
    dJointAttach(joint, rod, platform);
    dJointSetPUAnchor(joint, point[0], point[1], point[2]);
    dJointSetPUAxis1(joint, axis1[0], axis1[1], axis1[2]);
    dJointSetPUAxis2(joint, axis2[0], axis2[1], axis2[2]);
    dJointSetPUAxisP(joint, along[0], along[1], along[2]);
}

/* Makes the motor of a joint's friction. The universal joint has motors, too, but with a separate
 * joint ODE solves for the pistons first, which is twice as fast if all of them stick. */
static dJointID make_rub(struct ode_machine *m, dBodyID one, dBodyID two, const dVector3 axis1, const dVector3 axis2) {
    dJointID joint = dJointCreateAMotor(m->world, NULL);
    dJointAttach(joint, one, two);
    dJointSetAMotorNumAxes(joint, 2);
    dJointSetAMotorAxis(joint, 0, 1, axis1[0], axis1[1], axis1[2]);
    dJointSetAMotorAxis(joint, 1, two ? 2 : 0, axis2[0], axis2[1], axis2[2]);
    return joint;
}

static dJointID make_piston(struct ode_machine *m, dBodyID cylinder, dBodyID rod, const dVector3 along, dJointFeedback *feedback) {
    const dReal *center = dBodyGetPosition(cylinder);
    dJointID joint = dJointCreatePiston(m->world, NULL);
    dJointAttach(joint, cylinder, rod);
    dJointSetPistonAnchor(joint, center[0], center[1], center[2]);
    dJointSetPistonAxis(joint, along[0], along[1], along[2]);
    dJointSetPistonParam(joint, dParamCFM, PISTON_MOTOR_CFM);
    dJointSetFeedback(joint, feedback);
    return joint;
}

/* Makes a leg's joints. The joint at the base (because ODE wants a moving body first) and a joint
 * with backlash have the leg's part as their first body; ODE's axes 1 and 2 of these joints are
 * then the second and the first axis of engine.h. */
static void make_joints(struct ode_machine *m, int leg, bool rub) {
    dBodyID platform = m->body[PLATFORM], cylinder = m->body[CYLINDER + leg], rod = m->body[ROD + leg];
    dVector3 a, along, first_upper, second_lower, second_upper;
    const double *first_lower = m->geometry.lower_axis[leg];
    upper_joint(m, leg, a, first_upper);
    dBodyVectorToWorld(cylinder, 1, 0, 0, second_lower);
    dBodyVectorToWorld(rod, 1, 0, 0, second_upper);
    ode_machine_axis(m, leg, along);
    make_universal(m, cylinder, NULL, m->machine.bodies.lower_joint_m[leg], second_lower, first_lower);
    if (machine_has_play(&m->machine, leg)) make_loose(m, rod, platform, a, second_upper, first_upper, along);
    else make_universal(m, platform, rod, a, first_upper, second_upper);
    m->piston[leg] = make_piston(m, cylinder, rod, along, &m->feedback[leg]);
    if (!rub) return;
    m->lower_rub[leg] = make_rub(m, cylinder, NULL, second_lower, first_lower);
    m->upper_rub[leg] = make_rub(m, platform, rod, first_upper, second_upper);
}

int ode_machine_init(struct ode_machine *m, const struct params *params) {
    static const double neutral[DOFS] = {0}, level[LEGS] = {0};
    static const struct velocity rest = {0};
    *m = (struct ode_machine){.params = params};
    if (ode_open() < 0) return -1;
    sim_geometry_init(&m->geometry, params);
    machine_init(&m->machine, params);
    const double *down = m->machine.bodies.down, gravity = m->machine.bodies.gravity_mps2;
    m->world = dWorldCreate();
    dWorldSetGravity(m->world, gravity * down[0], gravity * down[1], gravity * down[2]);
    dWorldSetERP(m->world, JOINT_ERP);
    dWorldSetCFM(m->world, JOINT_CFM);
    make_bodies(m);
    ode_machine_place(m, neutral, level);
    for (int leg = 0; leg < LEGS; leg++) make_joints(m, leg, m->machine.joint_friction.count > 0);
    /* the first step allocates ODE's working memory, enough for all rows of these joints */
    if (!dWorldStep(m->world, 1e-6)) return ode_machine_free(m), -1;
    ode_machine_place(m, neutral, level);
    m->neutral_moment_kg_m = moment_of_mass(m);
    for (int body = 0; body < BODIES; body++) ode_machine_set_velocity(m, body, &rest, 0.0);
    return 0;
}

void ode_machine_free(struct ode_machine *m) {
    dWorldDestroy(m->world);
    ode_close();
}
