#include "closed_form.h"

#include <string.h>

void closed_form_row(const struct instant *now, int k, double row[DOFS], double *bias) {
    if (k >= LEGS) {
        memcpy(row, now->axes.row[k - LEGS], DOFS * sizeof *row);
        *bias = now->axes.bias[k - LEGS];
        return;
    }
    double across[3] = {now->legs.across[0][k], now->legs.across[1][k], now->legs.across[2][k]};
    rigid_row(&now->legs, k, row);
    *bias = dot3(across, across) / now->legs.length[k];
    for (int i = 0; i < 3; i++) *bias += now->legs.n[i][k] * now->legs.centripetal[i][k];
}

static double coordinate_rate(const struct instant *now, const union system *s, int k) {
    return k < LEGS ? now->legs.rate[k] : dot6(now->axes.row[k - LEGS], s->body.twist);
}

/* Returns a coordinate's direction of sliding: the direction fixed for the step if dry friction can
 * hold the coordinate, otherwise that of its motion. */
static int direction_of(const struct closed_form *e, int k, double rate) {
    if (e->kind[k] == SLIDES) return rate < 0.0 ? -1 : 1;
    return e->direction[k];
}

/* Returns the friction of a leg on its rod, positive away from the base: only the dry part if given
 * forces replace the hydraulics; 0 if the leg is held. */
static double leg_friction(const struct closed_form *e, const union system *s, const struct drive *drive, int leg, double rate) {
    int direction = direction_of(e, leg, rate);
    double speed = direction * rate;
    if (direction == 0) return 0.0;
    struct friction f = cylinder_friction(&e->cylinder, leg, &s->hydraulics.cylinder[leg], direction, speed > 0.0 ? speed : 0.0);
    return -direction * (f.dry + (drive->valve ? f.viscous : 0.0));
}

static void push_joints(const struct closed_form *e, const union system *s, struct instant *now) {
    for (int k = LEGS; k < COORDINATES; k++) {
        double rate = coordinate_rate(now, s, k);
        int direction = direction_of(e, k, rate);
        struct friction f = machine_joint_friction(&e->cylinder.machine, (k - LEGS) / JOINT_AXES_PER_LEG, fabs(rate));
        double moment = -direction * f.dry - (rate < 0.0 ? -f.viscous : f.viscous);
        if (direction != 0) add6(moment, now->axes.row[k - LEGS], now->free);
    }
}

/* For a leg with backlash: moves the rod's mass from the joint, where rigid_dynamics() puts it, to
 * the piston. The joint gets the force of the flanks instead. */
static void take_off_rod(const struct closed_form *e, const union system *s, int k, struct instant *now, double *axial) {
    const struct rigid_legs *legs = &now->legs;
    double row[DOFS], bias, rod_m = s->rods.length_m[k];
    closed_form_row(now, k, row, &bias);
    for (int i = 0; i < DOFS; i++) add6(-e->rigid.upper_mass[k] * row[i], row, now->mass.c[i]);
    add6(rigid_rod_force(&e->rigid, legs, k, legs->length[k], bias), row, now->free);
    double contact = machine_contact(&e->cylinder.machine, k, rod_m - legs->length[k], s->rods.rate_mps[k] - legs->rate[k]);
    now->rod_n[k] = *axial - now->friction_n[k] - rigid_rod_force(&e->rigid, legs, k, rod_m, 0.0) - contact;
    *axial = contact;
}

void closed_form_look(const struct closed_form *e, const union system *s, const struct drive *drive, struct instant *now) {
    double axial[LEGS];
    rigid_legs(&e->rigid, &s->body, &now->legs);
    rigid_dynamics(&e->rigid, &s->body, &now->legs, now->mass.c, now->free);
    for (int k = 0; k < LEGS; k++) {
        bool play = machine_has_play(&e->cylinder.machine, k);
        double drive_n = drive->valve ? cylinder_hydraulic_force(&e->cylinder, k, &s->hydraulics.cylinder[k]) : drive->force_n[k];
        now->length_m[k] = play ? s->rods.length_m[k] : now->legs.length[k];
        now->rate_mps[k] = play ? s->rods.rate_mps[k] : now->legs.rate[k];
        now->friction_n[k] = leg_friction(e, s, drive, k, now->rate_mps[k]);
        now->passive_n[k] = cylinder_stop_force(&e->cylinder, k, now->length_m[k], now->rate_mps[k]);
        now->passive_n[k] += cylinder_seal_force(&e->cylinder, k, &s->hydraulics.cylinder[k]);
        axial[k] = drive_n + now->friction_n[k] + now->passive_n[k];
        if (play) take_off_rod(e, s, k, now, &axial[k]);
    }
    rigid_push(&now->legs, axial, now->free);
    if (e->joints) {
        joint_axes(&e->rigid, &s->body, &now->legs, &now->axes);
        push_joints(e, s, now);
    }
    factor6(&now->mass);
    whiten6(&now->mass, now->free);
}

bool closed_form_held(const struct closed_form *e, int k) { return e->kind[k] == STICKS && e->direction[k] == 0; }

void closed_form_basis(const struct closed_form *e, const struct instant *now, struct stick_basis *basis) {
    basis->rank = 0;
    for (int i = 0; i < e->sticks; i++) {
        int k = e->stick[i];
        double row[DOFS], bias;
        if (!closed_form_held(e, k)) continue;
        closed_form_row(now, k, row, &bias);
        whiten6(&now->mass, row);
        stick_basis_add(basis, row, bias);
    }
}

static void move_rods(const struct closed_form *e, const struct instant *now, struct rods *rate) {
    for (int k = 0; k < LEGS; k++) {
        bool moves = machine_has_play(&e->cylinder.machine, k) && !(e->kind[k] == ROD_STICKS && e->direction[k] == 0);
        rate->length_m[k] = moves ? now->rate_mps[k] : 0.0;
        rate->rate_mps[k] = moves ? (now->rod_n[k] + now->friction_n[k]) / e->rigid.upper_mass[k] : 0.0;
    }
}

static void derivative(const struct closed_form *e, const union system *s, const struct drive *drive, union system *rate) {
    struct instant now;
    struct stick_basis basis;
    closed_form_look(e, s, drive, &now);
    if (e->sticks) {
        closed_form_basis(e, &now, &basis);
        stick_hold(&basis, 1.0, now.free);
    }
    unwhiten6(&now.mass, now.free);
    const double *q = s->body.attitude, *w = s->body.twist + 3;
    rate->body = (struct rigid_state){
        .position = {s->body.twist[0], s->body.twist[1], s->body.twist[2]},
        .attitude = {0.5 * (-w[0] * q[1] - w[1] * q[2] - w[2] * q[3]), 0.5 * (w[0] * q[0] + w[1] * q[3] - w[2] * q[2]),
                     0.5 * (w[1] * q[0] + w[2] * q[1] - w[0] * q[3]), 0.5 * (w[2] * q[0] + w[0] * q[2] - w[1] * q[1])},
    };
    memcpy(rate->body.twist, now.free, sizeof now.free);
    const struct hydraulics_input input = {.length_m = now.length_m, .rate_mps = now.rate_mps, .valve = drive->valve};
    if (e->play) {
        memset(&rate->hydraulics, 0, sizeof rate->hydraulics); /* with backlash the values of the
                                                                * extended hydraulics are
                                                                * integrated, too, so their rates
                                                                * must be set */
        move_rods(e, &now, &rate->rods);
    }
    if (drive->valve) hydraulics_derivative(&e->cylinder, &s->hydraulics, &input, &rate->hydraulics);
    else memset(&rate->hydraulics, 0, sizeof rate->hydraulics);
}

static void blend(int values, const union system *from, double h, const union system *rate, union system *to) {
    for (int i = 0; i < CLOSED_FORM_PLAIN; i++) to->value[i] = from->value[i] + h * rate->value[i];
    for (int i = CLOSED_FORM_PLAIN; i < values; i++) to->value[i] = from->value[i] + h * rate->value[i];
}

static double mean(double start, double middle1, double middle2, double end) { return start + 2.0 * (middle1 + middle2) + end; }

void closed_form_rk4(const struct closed_form *e, const union system *from, double h, const struct drive *drive, union system *to) {
    union system k1, k2, k3, k4, at;
    derivative(e, from, drive, &k1);
    blend(e->values, from, 0.5 * h, &k1, &at);
    derivative(e, &at, drive, &k2);
    blend(e->values, from, 0.5 * h, &k2, &at);
    derivative(e, &at, drive, &k3);
    blend(e->values, from, h, &k3, &at);
    derivative(e, &at, drive, &k4);
    for (int i = 0; i < CLOSED_FORM_PLAIN; i++)
        to->value[i] = from->value[i] + h / 6.0 * mean(k1.value[i], k2.value[i], k3.value[i], k4.value[i]);
    for (int i = CLOSED_FORM_PLAIN; i < e->values; i++)
        to->value[i] = from->value[i] + h / 6.0 * mean(k1.value[i], k2.value[i], k3.value[i], k4.value[i]);
    double *q = to->body.attitude, scale = 1.0 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; i++) q[i] *= scale;
}

void closed_form_rates(const struct closed_form *e, const union system *s, double rate[COORDINATES]) {
    struct instant now;
    rigid_legs(&e->rigid, &s->body, &now.legs);
    /* either all axes of joints have kind STICKS, or none */
    if (e->kind[LEGS] == STICKS) joint_axes(&e->rigid, &s->body, &now.legs, &now.axes);
    for (int i = 0; i < e->sticks; i++) rate[e->stick[i]] = coordinate_rate(&now, s, e->stick[i]);
}
