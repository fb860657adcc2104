#include "rigid.h"

#include <math.h>
#include <string.h>

#include "params.h"
#include "vec.h"

static void inertia_of(const struct machine *m, double inertia[3][3]) {
    const double *square = m->bodies.payload_inertia_kg_m2, *product = m->bodies.payload_products_kg_m2;
    for (int i = 0; i < 3; i++)        /* the products of inertia come as xy, xz, yz */
        for (int j = 0; j < 3; j++) inertia[i][j] = i == j ? square[i] : product[i + j - 1];
}

void rigid_model_init(struct rigid_model *m, const struct params *params) {
    const struct actuator_params *a = &params->actuator;
    memset(m, 0, sizeof *m);
    machine_init(&m->machine, params);
    sim_geometry_init(&m->geometry, params);
    m->mass = m->machine.bodies.payload_kg;
    m->gravity = m->machine.bodies.gravity_mps2 * m->machine.bodies.down[2];
    inertia_of(&m->machine, m->inertia);
    for (int i = 0; i < 3; i++) m->offset = m->offset || m->machine.bodies.payload_center_m[i] != 0.0;

    for (int leg = 0; leg < LEGS; leg++) {
        for (int i = 0; i < 3; i++) {
            m->upper[i][leg] = m->machine.bodies.upper_joint_m[leg][i];
            m->lower[i][leg] = m->machine.bodies.lower_joint_m[leg][i];
        }
        m->upper_mass[leg] = m->machine.bodies.upper_kg[leg];
        m->upper_center[leg] = a->upper_center_m[leg];
        m->upper_moment[leg] = m->upper_mass[leg] * a->upper_center_m[leg];
        m->lower_moment[leg] = m->machine.bodies.lower_kg[leg] * a->lower_center_m[leg];
        m->fixed_inertia[leg] = m->lower_moment[leg] * a->lower_center_m[leg] + a->upper_inertia_kg_m2[leg] + a->lower_inertia_kg_m2[leg] +
                                m->machine.bodies.transverse_kg_m2[leg];
    }

    struct rigid_state neutral;
    double kinetic;
    rigid_rest(&neutral, (const double[DOFS]){0});
    rigid_energy(m, &neutral, &kinetic, &m->neutral_potential);
}

/* Sets a state at rest in this pose. Its attitude, Rz(psi) Ry(theta) Rx(phi), is a product of
 * half-angle rotations. */
void rigid_rest(struct rigid_state *s, const double pose[DOFS]) {
    double cx = cos(0.5 * pose[3]), sx = sin(0.5 * pose[3]), cy = cos(0.5 * pose[4]), sy = sin(0.5 * pose[4]);
    double cz = cos(0.5 * pose[5]), sz = sin(0.5 * pose[5]);
    *s = (struct rigid_state){
        .position = {pose[0], pose[1], pose[2]},
        .attitude = {cz * cy * cx + sz * sy * sx, cz * cy * sx - sz * sy * cx, cz * sy * cx + sz * cy * sx, sz * cy * cx - cz * sy * sx},
    };
}

static void rotation(const double q[4], double t[3][3]) {
    double w = q[0], x = q[1], y = q[2], z = q[3];
    t[0][0] = w * w + x * x - y * y - z * z, t[0][1] = 2.0 * (x * y - w * z), t[0][2] = 2.0 * (x * z + w * y);
    t[1][0] = 2.0 * (x * y + w * z), t[1][1] = w * w - x * x + y * y - z * z, t[1][2] = 2.0 * (y * z - w * x);
    t[2][0] = 2.0 * (x * z - w * y), t[2][1] = 2.0 * (y * z + w * x), t[2][2] = w * w - x * x - y * y + z * z;
}

void rigid_pose(const struct rigid_state *s, double pose[DOFS]) {
    double t[3][3];
    rotation(s->attitude, t);
    memcpy(pose, s->position, sizeof s->position);
    pose[3] = atan2(t[2][1], t[2][2]);
    pose[4] = atan2(-t[2][0], hypot(t[0][0], t[1][0]));
    pose[5] = atan2(t[1][0], t[0][0]);
}

/* Computes the legs' motion. Each quantity has its own short loop over the legs, because the
 * compiler vectorises such loops in pairs. */
void rigid_legs(const struct rigid_model *m, const struct rigid_state *s, struct rigid_legs *legs) {
    const double *v = s->twist, *w = s->twist + 3;
    double (*t)[3] = legs->rotation, spin[3][3], square[LEGS];
    rotation(s->attitude, t);
    double ww = dot3(w, w);
    for (int i = 0; i < 3; i++)        /* omega~ omega~ */
        for (int j = 0; j < 3; j++) spin[i][j] = w[i] * w[j] - (i == j ? ww : 0.0);

    for (int i = 0; i < 3; i++)
        for (int k = 0; k < LEGS; k++) {
            legs->rho[i][k] = t[i][0] * m->upper[0][k] + t[i][1] * m->upper[1][k] + t[i][2] * m->upper[2][k];
            legs->n[i][k] = s->position[i] + legs->rho[i][k] - m->lower[i][k];
        }
    for (int k = 0; k < LEGS; k++)
        square[k] = legs->n[0][k] * legs->n[0][k] + legs->n[1][k] * legs->n[1][k] + legs->n[2][k] * legs->n[2][k];
    for (int k = 0; k < LEGS; k++) legs->length[k] = sqrt(square[k]);

    for (int k = 0; k < LEGS; k++) {
        double inverse = 1.0 / legs->length[k];
        double nx = legs->n[0][k] * inverse, ny = legs->n[1][k] * inverse, nz = legs->n[2][k] * inverse;
        double rx = legs->rho[0][k], ry = legs->rho[1][k], rz = legs->rho[2][k];
        double vx = v[0] + w[1] * rz - w[2] * ry, vy = v[1] + w[2] * rx - w[0] * rz, vz = v[2] + w[0] * ry - w[1] * rx;
        double rate = nx * vx + ny * vy + nz * vz;
        legs->n[0][k] = nx, legs->n[1][k] = ny, legs->n[2][k] = nz;
        legs->arm[0][k] = ry * nz - rz * ny, legs->arm[1][k] = rz * nx - rx * nz, legs->arm[2][k] = rx * ny - ry * nx;
        legs->rate[k] = rate;
        legs->across[0][k] = vx - rate * nx, legs->across[1][k] = vy - rate * ny, legs->across[2][k] = vz - rate * nz;
        for (int i = 0; i < 3; i++) legs->centripetal[i][k] = spin[i][0] * rx + spin[i][1] * ry + spin[i][2] * rz;
    }
}

/* Computes mass and load of the payload alone: m I and T Ic T', weight and gyroscopic moment. */
static void payload_dynamics(const struct rigid_model *m, const struct rigid_state *s, const struct rigid_legs *legs,
                             double mass[DOFS][DOFS], double load[DOFS]) {
    const double *w = s->twist + 3;
    double momentum[3], moment[3];
    memset(mass, 0, DOFS * sizeof mass[0]);
    for (int i = 0; i < 3; i++) {
        double row[3] = {0}; /* row of T Ic */
        for (int k = 0; k < 3; k++)
            for (int n = 0; n < 3; n++) row[k] += legs->rotation[i][n] * m->inertia[n][k];
        mass[i][i] = m->mass;
        for (int j = 0; j <= i; j++) mass[3 + i][3 + j] = dot3(row, legs->rotation[j]);
    }
    momentum[0] = mass[3][3] * w[0] + mass[4][3] * w[1] + mass[5][3] * w[2];
    momentum[1] = mass[4][3] * w[0] + mass[4][4] * w[1] + mass[5][4] * w[2];
    momentum[2] = mass[5][3] * w[0] + mass[5][4] * w[1] + mass[5][5] * w[2];
    cross3(momentum, w, moment);
    load[0] = load[1] = 0.0;
    load[2] = m->mass * m->gravity;
    memcpy(load + 3, moment, sizeof moment);
}

/* Corrects mass and load for a payload whose mass centre is off the origin of {M}. */
static void add_offset(const struct rigid_model *m, const struct rigid_state *s, const struct rigid_legs *legs, double mass[DOFS][DOFS],
                       double load[DOFS]) {
    const double *w = s->twist + 3;
    double r[3], swing[3], pull[3], moment[3];
    for (int i = 0; i < 3; i++) r[i] = dot3(legs->rotation[i], m->machine.bodies.payload_center_m);
    cross3(w, r, swing);
    cross3(w, swing, swing);
    for (int i = 0; i < 3; i++) pull[i] = m->mass * (m->machine.bodies.gravity_mps2 * m->machine.bodies.down[i] - swing[i]);
    cross3(r, pull, moment);
    for (int i = 0; i < 3; i++) {
        load[i] -= m->mass * swing[i];
        load[3 + i] += moment[i];
        for (int j = 0; j <= i; j++) mass[3 + i][3 + j] += m->mass * ((i == j ? dot3(r, r) : 0.0) - r[i] * r[j]);
    }
    mass[3][1] -= m->mass * r[2], mass[3][2] += m->mass * r[1];
    mass[4][0] += m->mass * r[2], mass[4][2] -= m->mass * r[0];
    mass[5][0] -= m->mass * r[1], mass[5][1] += m->mass * r[0];
}

/* Adds the components along x and y of the weights of payload and legs, on a tilted base; moments
 * about the origin of {M}. */
static void add_sideways(const struct rigid_model *m, const struct rigid_legs *legs, double load[DOFS]) {
    const double *down = m->machine.bodies.down, gravity = m->machine.bodies.gravity_mps2;
    const double g[3] = {gravity * down[0], gravity * down[1], 0.0};
    for (int i = 0; i < 3; i++) load[i] += m->mass * g[i];
    for (int k = 0; k < LEGS; k++) {
        const double n[3] = {legs->n[0][k], legs->n[1][k], legs->n[2][k]}, rho[3] = {legs->rho[0][k], legs->rho[1][k], legs->rho[2][k]};
        double sway = (m->lower_moment[k] - m->upper_moment[k]) / legs->length[k], pull[3], moment[3];
        for (int i = 0; i < 3; i++) pull[i] = m->upper_mass[k] * g[i] + sway * (g[i] - n[i] * dot3(n, g));
        cross3(rho, pull, moment);
        for (int i = 0; i < 3; i++) load[i] += pull[i], load[3 + i] += moment[i];
    }
}

/* Load of each leg on the platform at its upper joint. f: effective mass across the leg. axial:
 * additional mass along the leg, ma - f. pull, moment: load at zero acceleration of the
 * platform. */
struct leg_load {
    double f[LEGS], axial[LEGS];
    double pull[3][LEGS], moment[3][LEGS]; /* force and moment on the platform, about the origin of
                                            * {M} */
};

static void leg_loads(const struct rigid_model *m, const struct rigid_legs *legs, struct leg_load *load) {
    for (int k = 0; k < LEGS; k++) {
        double inverse = 1.0 / legs->length[k], inner = legs->length[k] - m->upper_center[k];
        double nx = legs->n[0][k], ny = legs->n[1][k], nz = legs->n[2][k];
        double ax = legs->across[0][k], ay = legs->across[1][k], az = legs->across[2][k];
        double cx = legs->centripetal[0][k], cy = legs->centripetal[1][k], cz = legs->centripetal[2][k];
        double f = (m->upper_mass[k] * inner * inner + m->fixed_inertia[k]) * inverse * inverse;
        double slope = 2.0 * inverse * (m->upper_mass[k] * inner * inverse - f); /* f' */
        double turn = slope * legs->rate[k];
        double sway = (m->lower_moment[k] - m->upper_moment[k]) * inverse * m->gravity;
        double along = (m->upper_mass[k] - f) * (nx * cx + ny * cy + nz * cz) +
                       m->upper_moment[k] * inverse * inverse * (ax * ax + ay * ay + az * az) + sway * nz;
        double px = -f * cx - turn * ax - along * nx;
        double py = -f * cy - turn * ay - along * ny;
        double pz = -f * cz - turn * az - along * nz + m->upper_mass[k] * m->gravity + sway;
        double rx = legs->rho[0][k], ry = legs->rho[1][k], rz = legs->rho[2][k];
        load->f[k] = f;
        load->axial[k] = m->upper_mass[k] - f;
        load->pull[0][k] = px, load->pull[1][k] = py, load->pull[2][k] = pz;
        load->moment[0][k] = ry * pz - rz * py, load->moment[1][k] = rz * px - rx * pz, load->moment[2][k] = rx * py - ry * px;
    }
}

/* Adds the sum of axial J' J over the legs to the mass matrix (axial: as in struct leg_load).
 * Adding whole rows is faster than adding a triangle. */
static void add_axial_mass(const struct rigid_legs *legs, const double axial[LEGS], double mass[DOFS][DOFS]) {
    for (int k = 0; k < LEGS; k++) {
        double row[DOFS];
        rigid_row(legs, k, row);
        for (int i = 0; i < DOFS; i++) add6(axial[k] * row[i], row, mass[i]);
    }
}

/* Adds sum f [I, -rho~; rho~, -rho~ rho~] to the lower triangle of the mass matrix. Its elements
 * are moments of f, zeroth to second, about the origin of {M}. */
static void add_transverse_mass(const struct rigid_legs *legs, const double f[LEGS], double mass[DOFS][DOFS]) {
    const double *x = legs->rho[0], *y = legs->rho[1], *z = legs->rho[2];
    double s = 0.0, sx = 0.0, sy = 0.0, sz = 0.0, xx = 0.0, yy = 0.0, zz = 0.0, xy = 0.0, yz = 0.0, zx = 0.0;
    for (int k = 0; k < LEGS; k++) {
        double fx = f[k] * x[k], fy = f[k] * y[k], fz = f[k] * z[k];
        s += f[k], sx += fx, sy += fy, sz += fz;
        xx += fx * x[k], yy += fy * y[k], zz += fz * z[k];
        xy += fx * y[k], yz += fy * z[k], zx += fz * x[k];
    }
    for (int i = 0; i < 3; i++) mass[i][i] += s;
    mass[3][1] -= sz, mass[3][2] += sy;
    mass[4][0] += sz, mass[4][2] -= sx;
    mass[5][0] -= sy, mass[5][1] += sx;
    mass[3][3] += yy + zz, mass[4][4] += zz + xx, mass[5][5] += xx + yy;
    mass[4][3] -= xy, mass[5][3] -= zx, mass[5][4] -= yz;
}

void rigid_dynamics(const struct rigid_model *m, const struct rigid_state *s, const struct rigid_legs *legs, double mass[DOFS][DOFS],
                    double load[DOFS]) {
    struct leg_load leg;
    payload_dynamics(m, s, legs, mass, load);
    if (m->offset) add_offset(m, s, legs, mass, load);
    if (m->machine.bodies.down[2] != 1.0) add_sideways(m, legs, load);
    if (m->machine.wrench.count) {
        double pose[DOFS];
        rigid_pose(s, pose);
        machine_wrench(&m->machine, pose, load);
    }
    leg_loads(m, legs, &leg);
    add_axial_mass(legs, leg.axial, mass);
    add_transverse_mass(legs, leg.f, mass);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < LEGS; k++) {
            load[i] += leg.pull[i][k];
            load[3 + i] += leg.moment[i][k];
        }
}

void rigid_push(const struct rigid_legs *legs, const double force_n[LEGS], double load[DOFS]) {
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < LEGS; k++) {
            load[i] += legs->n[i][k] * force_n[k];
            load[3 + i] += legs->arm[i][k] * force_n[k];
        }
}

double rigid_rod_force(const struct rigid_model *m, const struct rigid_legs *legs, int leg, double length_m, double acceleration_mps2) {
    double turn_squared = 0.0, weight_mps2 = 0.0, inner_m = length_m - m->upper_center[leg];
    for (int i = 0; i < 3; i++) {
        turn_squared += legs->across[i][leg] * legs->across[i][leg] / (legs->length[leg] * legs->length[leg]);
        weight_mps2 += m->machine.bodies.gravity_mps2 * m->machine.bodies.down[i] * legs->n[i][leg];
    }
    return m->upper_mass[leg] * (acceleration_mps2 - inner_m * turn_squared - weight_mps2);
}

/* Computes the energies. The kinetic energy is summed body by body, not computed from the mass
 * matrix, so that a test can compare the two. */
void rigid_energy(const struct rigid_model *m, const struct rigid_state *s, double *kinetic_j, double *potential_j) {
    struct rigid_legs legs;
    const double *down = m->machine.bodies.down;
    double center[3], v[3];
    rigid_legs(m, s, &legs);
    for (int i = 0; i < 3; i++) center[i] = dot3(legs.rotation[i], m->machine.bodies.payload_center_m);
    cross3(s->twist + 3, center, v);
    for (int i = 0; i < 3; i++) v[i] += s->twist[i], center[i] += s->position[i];
    double kinetic = m->mass * dot3(v, v), depth = m->mass * dot3(center, down);
    double spin[3]; /* in {M} */
    for (int j = 0; j < 3; j++)
        spin[j] = legs.rotation[0][j] * s->twist[3] + legs.rotation[1][j] * s->twist[4] + legs.rotation[2][j] * s->twist[5];
    for (int j = 0; j < 3; j++) kinetic += spin[j] * dot3(m->inertia[j], spin);
    for (int k = 0; k < LEGS; k++) {
        const double n[3] = {legs.n[0][k], legs.n[1][k], legs.n[2][k]};
        const double across[3] = {legs.across[0][k], legs.across[1][k], legs.across[2][k]};
        double inner = legs.length[k] - m->upper_center[k], turn_squared = dot3(across, across) / (legs.length[k] * legs.length[k]);
        kinetic += m->upper_mass[k] * legs.rate[k] * legs.rate[k] + m->upper_mass[k] * inner * inner * turn_squared +
                   m->fixed_inertia[k] * turn_squared;
        /* depth below the lower joint, which is fixed */
        depth += (m->upper_mass[k] * inner + m->lower_moment[k]) * dot3(n, down);
    }
    *kinetic_j = 0.5 * kinetic;
    *potential_j = -m->machine.bodies.gravity_mps2 * depth - m->neutral_potential;
}

/* Solves J' f = -load as J J' f = -J load. Squaring J does not lose much accuracy, because legs
 * that can hold the platform are far from singular. */
bool rigid_holding_forces(const struct rigid_model *m, const double pose[DOFS], double force_n[LEGS]) {
    struct rigid_state s;
    struct rigid_legs legs;
    double mass[DOFS][DOFS], load[DOFS], row[LEGS][DOFS];
    struct factor6 square;
    rigid_rest(&s, pose);
    rigid_legs(m, &s, &legs);
    rigid_dynamics(m, &s, &legs, mass, load);
    for (int i = 0; i < LEGS; i++) {
        rigid_row(&legs, i, row[i]);
        force_n[i] = -dot6(row[i], load);
        for (int j = 0; j <= i; j++) square.c[i][j] = dot6(row[i], row[j]);
    }
    factor6(&square);
    whiten6(&square, force_n);
    unwhiten6(&square, force_n);
    bool finite = true;
    for (int i = 0; i < LEGS; i++) finite = finite && isfinite(force_n[i]);
    return finite;
}
