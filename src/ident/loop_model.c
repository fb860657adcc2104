#include "loop_model.h"

#include <math.h>
#include <string.h>

#include "force.h"
#include "inverse_dynamics.h"
#include "kinematics.h"
#include "lin.h"
#include "modal.h"
#include "params.h"
#include "units.h"
#include "vec.h"

static const double FAST_MPS = 1.0; /* speed at which viscous friction is evaluated, so high that
                                     * dry friction no longer depends on speed */
static const double CENTRE_SHARE = 1e-3; /* a valve is near its centre up to this share of its full
                                          * opening */
static const double RESTS_PER_S = 1e-3;

/* A leg at rest: the pressures that give its force, and the opening that makes up for leakage. */
struct rest {
    double p1_pa, p2_pa, opening;
};

/* Finds a leg's pressures at rest. The oil that leaks through the piston enters one chamber and
 * leaves the other, through two control edges of the same opening, so the pressure drops are
 * inversely proportional to the squared gains of the edges. */
static struct rest rest_of(const struct cylinder_leg *c, const struct mains *mains, double force_n) {
    double a = c->valve_gain[PORT_A], b = c->valve_gain[PORT_B], ratio = (b / a) * (b / a);
    struct rest r[2]; /* solutions with supply pressure at port A, and at port B */
    for (int back = 0; back < 2; back++) {
        double from_pa = back ? mains->tank_pa : mains->supply_pa, to_pa = back ? mains->supply_pa : mains->tank_pa;
        double p1 = (from_pa + ratio * (force_n / c->a2_m2 + to_pa)) / (1.0 + ratio * c->a1_m2 / c->a2_m2);
        double p2 = (c->a1_m2 * p1 - force_n) / c->a2_m2;
        double flow = c->leakage_m3_per_s_pa * (p1 - p2), edge = a * sqrt(fabs(from_pa - p1));
        r[back] = (struct rest){p1, p2, edge > 0.0 ? flow / edge : 0.0};
    }
    /* Each solution is valid for one direction: an opening above 0 connects the supply with port A,
     * one below 0 with port B. Leakage decides which: it flows from high to low pressure, and the
     * spool feeds the chamber that loses oil. */
    return r[0].opening > 0.0 || r[1].opening >= 0.0 ? r[0] : r[1];
}

/* Finds for each chamber the flow into it per opening, and the derivative of the flow at rest by
 * the chamber's own pressure. A spool that swings across its centre meets both pairs of edges in
 * turn; each counts with its share in the first harmonic of a sinusoidal swing. */
static void edges(const struct cylinder_leg *c, const struct mains *mains, const struct rest *r, double swing, double open[PORTS],
                  double by_pa[PORTS]) {
    double ps = mains->supply_pa, pt = mains->tank_pa;
    const double fed[PORTS] = {sqrt(fmax(ps - r->p1_pa, 0.0)), sqrt(fmax(r->p2_pa - pt, 0.0))};
    const double drained[PORTS] = {sqrt(fmax(r->p1_pa - pt, 0.0)), sqrt(fmax(ps - r->p2_pa, 0.0))};
    double offset = fmin(fmax(r->opening / fmax(swing, CENTRE_SHARE), -1.0), 1.0);
    double extends = 0.5 + (asin(offset) + offset * sqrt(1.0 - offset * offset)) / PI;
    for (int i = 0; i < PORTS; i++) {
        double drop = extends * fed[i] + (1.0 - extends) * drained[i], gain = c->valve_gain[i];
        open[i] = (i ? -1.0 : 1.0) * gain * drop;
        by_pa[i] = drop > 0.0 ? -0.5 * gain * fabs(r->opening) / drop : 0.0;
    }
}

static double viscous_of(const struct cylinder_model *m, int leg, const struct rest *r) {
    const struct cylinder_state s = {.p1_pa = r->p1_pa, .p2_pa = r->p2_pa};
    return 0.5 * (cylinder_friction(m, leg, &s, 1, FAST_MPS).viscous + cylinder_friction(m, leg, &s, -1, FAST_MPS).viscous) / FAST_MPS;
}

static bool linearise(const struct cylinder_model *m, int leg, double length_m, double force_n, double more_delay_s, double swing,
                      struct loop_leg *to) {
    const struct cylinder_leg *c = &m->leg[leg];
    struct mains mains = cylinder_mains(m);
    struct rest r = rest_of(c, &mains, force_n);
    double stroke_m = length_m - c->length_min_m, left_m = c->length_max_m - length_m, open[PORTS], by_pa[PORTS];
    const double area[PORTS] = {c->a1_m2, c->a2_m2}, way_m[PORTS] = {fmax(stroke_m, 0.0), fmax(left_m, 0.0)};
    if (!(r.p1_pa > mains.tank_pa && r.p1_pa < mains.supply_pa && r.p2_pa > mains.tank_pa && r.p2_pa < mains.supply_pa)) return false;
    edges(c, &mains, &r, swing, open, by_pa);
    *to = (struct loop_leg){
        .viscous = viscous_of(m, leg, &r),
        .spool_radps = sqrt(c->valve_omega_squared),
        .spool_damping = 0.5 * c->valve_damping_rate / sqrt(c->valve_omega_squared),
        .command_delay_s = m->machine.timing.command_delay_s[leg] + more_delay_s,
        .length_delay_s = m->machine.sensors.length[leg].delay_s,
    };
    for (int i = 0; i < PORTS; i++) {
        double stiffness = c->bulk_modulus_pa / (c->dead_volume_m3[i] + area[i] * way_m[i]);
        to->chamber[i] = (struct oil_chamber){.push = stiffness * area[i],
                                              .open = stiffness * open[i],
                                              .sag = stiffness * (c->leakage_m3_per_s_pa - by_pa[i]),
                                              .other = stiffness * c->leakage_m3_per_s_pa};
    }
    return true;
}

/* Finds a leg's speeds at full opening, from incompressible flow in and out through two edges. */
static void find_speeds(const struct cylinder_model *m, int leg, struct loop_place *p) {
    const struct cylinder_leg *c = &m->leg[leg];
    struct mains mains = cylinder_mains(m);
    double a1 = c->a1_m2, a2 = c->a2_m2, force_n = p->force_n[leg], a = c->valve_gain[PORT_A], b = c->valve_gain[PORT_B];
    double cubes = a1 * a1 * a1 / (a * a) + a2 * a2 * a2 / (b * b);
    double push_n = a1 * mains.supply_pa - a2 * mains.tank_pa - force_n, pull_n = a2 * mains.supply_pa - a1 * mains.tank_pa + force_n;
    p->out_mps[leg] = push_n > 0.0 ? sqrt(push_n / cubes) : 0.0;
    p->in_mps[leg] = pull_n > 0.0 ? sqrt(pull_n / cubes) : 0.0;
}

/* Returns the axis that moves most in a mode, with angles multiplied by arm_m (kinematics.h).
 * reach_m: motion of the platform in the mode. */
static enum dof largest(double j[LEGS][DOFS], const double motion[LEGS], double arm_m, double *reach_m) {
    double inverse[DOFS][LEGS], most = 0.0, square = 0.0;
    enum dof dof = DOF_Z;
    lin_inverse(DOFS, j[0], inverse[0]);
    for (int i = 0; i < DOFS; i++) {
        double size = 0.0;
        for (int k = 0; k < LEGS; k++) size += inverse[i][k] * motion[k];
        size = fabs(size) * (i < DOF_PHI ? 1.0 : arm_m);
        square += size * size;
        if (size > most) most = size, dof = (enum dof)i;
    }
    *reach_m = sqrt(square);
    return dof;
}

/* Solves the eigenvalue problem of inertia and stiffness of the oil, in leg coordinates. */
bool loop_place_modes(struct loop_place *p, const struct params *params, const struct modal *modal) {
    double spring[LEGS][LEGS] = {{0}}, value[LEGS], j[LEGS][DOFS];
    struct cylinder_areas areas = cylinder_areas(&params->actuator);
    struct kinematics k;
    for (int i = 0; i < LEGS; i++)
        spring[i][i] = areas.a1_m2[i] * p->leg[i].chamber[PORT_A].push + areas.a2_m2[i] * p->leg[i].chamber[PORT_B].push;
    if (lin_eigenvectors(LEGS, spring[0], p->inertia[0], value, p->motion[0])) return false;
    kinematics_place(&k, params);
    ik_jacobian(&k, p->pose, j);
    for (int mode = 0; mode < DOFS; mode++) {
        double square = 0.0;
        for (int i = 0; i < LEGS; i++) square += p->motion[mode][i] * p->motion[mode][i];
        p->mass_kg[mode] = 1.0 / square; /* the eigenvectors are scaled to inertia 1 */
        p->dof[mode] = largest(j, p->motion[mode], k.arm_m, &p->reach[mode]);
    }
    loop_place_weigh(p, modal);
    return true;
}

/* The modes V have V'M V = 1, so the weights in them are V^-1 W V = V'M W V. */
void loop_place_weigh(struct loop_place *p, const struct modal *modal) {
    memset(p->mix, 0, sizeof p->mix);
    for (int i = 0; i < DOFS; i++) {
        double to[LEGS] = {0};
        p->mix[i][i] = 1.0;
        for (int k = 0; k < LEGS; k++)
            for (int m = 0; m < LEGS; m++) to[k] += p->motion[i][m] * p->inertia[m][k];
        for (int j = 0; j < DOFS && modal->on; j++) p->mix[i][j] = modal_between(modal, to, p->motion[j]);
    }
}

struct loop_mode_input loop_place_mode(const struct loop_place *p, int mode) {
    return (struct loop_mode_input){.motion = p->motion[mode], .mass_kg = p->mass_kg[mode], .gain = p->mix[mode][mode]};
}

bool loop_place_find(struct loop_place *p, const struct params *params, const double pose[DOFS], double more_delay_s) {
    return loop_place_find_moving(p, params, pose, more_delay_s, 0.0);
}

bool loop_place_find_moving(struct loop_place *p, const struct params *params, const double pose[DOFS], double more_delay_s, double swing) {
    struct inverse_dynamics d;
    struct inverse_dynamics_input in = {0};
    struct kinematics k;
    struct rigid_legs legs;
    struct modal modal;
    struct oil_column column[LEGS];
    double length_m[LEGS];
    memset(p, 0, sizeof *p);
    memcpy(p->pose, pose, sizeof p->pose);
    kinematics_place(&k, params);
    ik_lengths(&k, pose, length_m);
    inverse_dynamics_init(&d, params, params->loop.period_s, 0.0);
    rigid_rest(&d.state, pose);
    for (int i = 0; i < LEGS; i++) in.leg[i][0] = length_m[i];
    if (!params_mechanism(d.params)->forces(&d, &in, &legs, p->force_n)) return false;
    oil_columns_init(column, params, &k);
    for (int i = 0; i < LEGS; i++) {
        find_speeds(&d.cylinder, i, p);
        if (!linearise(&d.cylinder, i, length_m[i], p->force_n[i], more_delay_s, swing, &p->leg[i])) return false;
        p->leg[i].feedback_cut = oil_feedback_cut(&column[i], length_m[i]);
    }
    inverse_dynamics_inertia(&d, p->inertia);
    if (modal_init(&modal, params, &k, &(struct error){0})) return false;
    return loop_place_modes(p, params, &modal);
}

/* True for a pole at zero. Such a pole comes from an integrator without gain, or from pressures
 * that no leakage equalises. */
static bool rests(const struct loop_pole *pole) { return hypot(pole->decay_per_s, pole->radps) < RESTS_PER_S; }

/* True if a pole is worse than another: it grows faster, or, if both decay, it is less damped. */
static bool worse(const struct loop_pole *pole, const struct loop_pole *than) {
    if (pole->decay_per_s < 0.0 || than->decay_per_s < 0.0) return pole->decay_per_s < than->decay_per_s;
    return loop_pole_damping(pole) < loop_pole_damping(than);
}

struct loop_worst loop_place_worst(const struct loop_place *p, const struct params *params) {
    struct loop_worst worst = {0};
    struct loop_pole pole[LOOP_POLES];
    for (int mode = 0; mode < DOFS; mode++) {
        const struct loop_mode_input shape = loop_place_mode(p, mode);
        int count = loop_poles_all(p->leg, &shape, params, pole);
        if (!count) return (struct loop_worst){0};
        for (int i = 0; i < count; i++)
            if (!rests(&pole[i]) && (!worst.known || worse(&pole[i], &worst.pole)))
                worst = (struct loop_worst){.pole = pole[i], .dof = p->dof[mode], .known = true};
    }
    return worst;
}

double loop_place_noise_mps2(const struct loop_place *p, const struct params *params) {
    double square = 0.0;
    for (int mode = 0; mode < DOFS; mode++) {
        const struct loop_mode_input shape = loop_place_mode(p, mode);
        double mps2 = p->reach[mode] * loop_noise(p->leg, &shape, params);
        square += mps2 * mps2;
    }
    return sqrt(square);
}
