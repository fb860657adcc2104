/* The closed-form engine: the RK4 step of closed_form.h and its events. At the instant at which a
 * coordinate with dry friction stops, the right-hand side jumps. No step crosses such an instant:
 * the engine finds it, steps to it, and decides there whether the coordinate stays at rest
 * (stick.h). */
#include <stdlib.h>
#include <string.h>

#include "closed_form.h"

enum { EVENTS_MAX = 4 * COORDINATES }; /* most events handled in a substep */

static const double STOPPED = 1e-9; /* speed below which a coordinate counts as stopped, m/s or
                                     * rad/s */

/* Removes the remaining motion of held coordinates from the twist. */
static void stop_held(struct closed_form *e, const struct instant *now) {
    struct stick_basis basis;
    double *twist = e->state.body.twist, x[DOFS];
    closed_form_basis(e, now, &basis);
    for (int i = 0; i < DOFS; i++) { /* x = C' twist */
        x[i] = twist[i] / now->mass.c[i][i];
        for (int j = i + 1; j < DOFS; j++) x[i] += now->mass.c[j][i] * twist[j];
    }
    stick_hold(&basis, 0.0, x);
    unwhiten6(&now->mass, x);
    memcpy(twist, x, sizeof x);
}

/* Finds the range of the friction force on the rod of a leg at rest. */
static void leg_limits(const struct closed_form *e, int k, double *least_n, double *most_n) {
    const struct cylinder_state *s = &e->state.hydraulics.cylinder[k];
    *least_n = -cylinder_friction(&e->cylinder, k, s, 1, 0.0).dry;
    *most_n = cylinder_friction(&e->cylinder, k, s, -1, 0.0).dry;
}

/* If the limits exclude zero, adds the limit that is nearer to zero to the free acceleration, as a
 * force that acts in any case. Returns this force, or 0. */
static double centre_limits(double least, double most, struct stick_coordinate *c, struct instant *now) {
    double must = least > 0.0 ? least : most < 0.0 ? most : 0.0;
    if (must != 0.0) add6(must, c->row, now->free);
    c->extend_limit = fmax(must - least, 0.0);
    c->retract_limit = fmax(most - must, 0.0);
    return must;
}

static struct stick_coordinate at_rest(const struct closed_form *e, struct instant *now, int k, double *must) {
    struct stick_coordinate c;
    double least, most;
    closed_form_row(now, k, c.row, &c.bias);
    whiten6(&now->mass, c.row);
    if (k < LEGS) {
        leg_limits(e, k, &least, &most);
    } else {
        most = machine_joint_friction(&e->cylinder.machine, (k - LEGS) / JOINT_AXES_PER_LEG, 0.0).dry;
        least = -most;
    }
    *must = centre_limits(least, most, &c, now);
    return c;
}

/* Holds the coordinates that have stopped. Returns how many of them were not held before. */
static int arrest(struct closed_form *e) {
    int more = 0;
    for (int i = 0; i < e->sticks; i++) {
        int k = e->stick[i];
        if (e->direction[k] == 0 || e->direction[k] * e->rate[k] > STOPPED) continue;
        e->direction[k] = 0;
        more++;
    }
    return more;
}

static int held_places(const struct closed_form *e, int place[COORDINATES]) {
    int count = 0;
    for (int i = 0; i < e->sticks; i++)
        if (closed_form_held(e, e->stick[i])) place[count++] = e->stick[i];
    return count;
}

/* Starts a step: holds the stopped coordinates, brings them to rest exactly, and releases those
 * whose friction is too weak. Bringing a coordinate to rest may stop other coordinates that move
 * with it, so all stopped ones are found before any is released. Caught coordinates (slide()) are
 * not released. */
static void release(struct closed_form *e, const struct drive *drive, const bool caught[COORDINATES]) {
    struct stick_coordinate rest[COORDINATES];
    double must[COORDINATES];
    struct instant now;
    int place[COORDINATES];
    arrest(e);
    if (held_places(e, place) == 0) return;
    do {
        closed_form_look(e, &e->state, drive, &now);
        stop_held(e, &now);
        closed_form_rates(e, &e->state, e->rate);
    } while (arrest(e) > 0);
    int count = held_places(e, place);
    for (int i = 0; i < count; i++) rest[i] = at_rest(e, &now, place[i], &must[i]);
    stick_resolve(rest, count, now.free);
    for (int i = 0; i < count; i++) {
        e->holding[place[i]] = must[i] + rest[i].force;
        if (!caught[place[i]]) e->direction[place[i]] = rest[i].slip;
    }
}

/* Returns the smallest speed, in its sliding direction, among the coordinates in `which`. The
 * result is <= 0 once one of them has stopped. */
static double nearest_to_rest(const struct closed_form *e, const bool which[COORDINATES], const double rate[COORDINATES]) {
    double nearest = (double)INFINITY;
    for (int i = 0; i < e->sticks; i++) {
        int k = e->stick[i];
        if (which[k] && e->direction[k] * rate[k] < nearest) nearest = e->direction[k] * rate[k];
    }
    return nearest;
}

/* Steps to the instant at which the first of the `turning` coordinates stops (Illinois rule), and
 * returns its time. These coordinates would reverse before h. start, end: nearest_to_rest() of them
 * at 0 and at h. */
static double step_to_rest(const struct closed_form *e, double h, const struct drive *drive, const bool turning[COORDINATES], double start,
                           double end, union system *to) {
    double low = 0.0, high = h, at = h, rate[COORDINATES];
    int side = 0;
    for (int i = 0; i < 60 && high - low > 1e-12 * h; i++) {
        at = low + (high - low) * start / (start - end);
        closed_form_rk4(e, &e->state, at, drive, to);
        closed_form_rates(e, to, rate);
        double now = nearest_to_rest(e, turning, rate);
        if (fabs(now) <= STOPPED) break;
        if (now > 0.0) {
            low = at, start = now;
            if (side > 0) end *= 0.5;
            side = 1;
        } else {
            high = at, end = now;
            if (side < 0) start *= 0.5;
            side = -1;
        }
    }
    return at;
}

/* Steps to h, or to the first instant at which a coordinate stops. Returns the elapsed time. A
 * coordinate that reverses as soon as it is released is caught: it is held to the end of the
 * substep. */
static double slide(struct closed_form *e, double h, const struct drive *drive, bool caught[COORDINATES]) {
    double rate[COORDINATES];
    bool turning[COORDINATES] = {false}, any = false, at_once = false;
    union system to;
    closed_form_rk4(e, &e->state, h, drive, &to);
    closed_form_rates(e, &to, rate);
    for (int i = 0; i < e->sticks; i++) {
        int k = e->stick[i];
        turning[k] = e->direction[k] * rate[k] < 0.0;
        any = any || turning[k];
        if (!turning[k] || e->direction[k] * e->rate[k] > STOPPED) continue;
        caught[k] = at_once = true;
        e->direction[k] = 0;
    }
    if (at_once) return 0.0;
    if (any) {
        h = step_to_rest(e, h, drive, turning, nearest_to_rest(e, turning, e->rate), nearest_to_rest(e, turning, rate), &to);
        closed_form_rates(e, &to, rate);
    }
    e->state = to;
    memcpy(e->rate, rate, sizeof rate);
    return h;
}

/* Finishes a step that has too many events, and ignores further ones, so that the engine can never
 * hang. The error is less than the impulse of friction over a substep. */
static void slide_on(struct closed_form *e, double h, const struct drive *drive) {
    closed_form_rk4(e, &e->state, h, drive, &e->state);
    closed_form_rates(e, &e->state, e->rate);
    for (int i = 0; i < e->sticks; i++) {
        int k = e->stick[i];
        if (e->direction[k] * e->rate[k] < 0.0) e->direction[k] = -e->direction[k];
    }
}

/* Returns the direction of a rod; 0: it is held. A rod at rest stays at rest while friction within
 * its limits can balance the sum of the other axial forces. */
static int rod_direction(const struct closed_form *e, const struct instant *now, int k) {
    double rate = e->state.rods.rate_mps[k], least, most;
    leg_limits(e, k, &least, &most);
    if (rate != 0.0) return rate < 0.0 ? -1 : 1;
    return now->rod_n[k] > -least ? 1 : now->rod_n[k] < -most ? -1 : 0;
}

static void release_rods(struct closed_form *e, const struct drive *drive) {
    struct instant now;
    closed_form_look(e, &e->state, drive, &now);
    for (int k = 0; k < LEGS; k++) {
        if (e->kind[k] != ROD_STICKS) continue;
        e->direction[k] = rod_direction(e, &now, k);
        e->holding[k] = -now.rod_n[k];
    }
}

/* Stops the rods that have reversed within the step, if their friction can hold them. */
static void arrest_rods(struct closed_form *e, const struct drive *drive) {
    struct instant now;
    closed_form_look(e, &e->state, drive, &now);
    for (int k = 0; k < LEGS; k++) {
        double rate = e->state.rods.rate_mps[k], least, most;
        if (e->kind[k] != ROD_STICKS || e->direction[k] * rate >= 0.0) continue;
        leg_limits(e, k, &least, &most);
        if (now.rod_n[k] <= -least && now.rod_n[k] >= -most) e->state.rods.rate_mps[k] = 0.0;
    }
}

static void step_on(struct closed_form *e, double dt, const struct drive *drive) {
    bool caught[COORDINATES] = {false};
    double left = dt;
    if (!e->sticks) {
        closed_form_rk4(e, &e->state, dt, drive, &e->state);
        return;
    }
    for (int event = 0; left > 0.0 && event < EVENTS_MAX; event++) {
        release(e, drive, caught);
        left -= slide(e, left, drive, caught);
    }
    if (left > 0.0) slide_on(e, left, drive);
}

static void step(struct closed_form *e, double dt, const struct drive *drive) {
    if (e->rods_stick) release_rods(e, drive);
    step_on(e, dt, drive);
    if (e->rods_stick) arrest_rods(e, drive);
}

static bool joints_can_stick(const struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++)
        if (machine_joint_friction(m, leg, 0.0).dry > 0.0) return true;
    return false;
}

static void closed_form_place(struct engine *base, const double pose[DOFS], const double ahead_m[LEGS]) {
    struct closed_form *e = (struct closed_form *)base;
    struct rigid_legs legs;
    rigid_rest(&e->state.body, pose);
    rigid_legs(&e->rigid, &e->state.body, &legs);
    for (int k = 0; k < LEGS; k++) e->state.rods.length_m[k] = legs.length[k] + ahead_m[k];
    memset(e->state.rods.rate_mps, 0, sizeof e->state.rods.rate_mps);
    memset(e->direction, 0, sizeof e->direction);
    memset(e->holding, 0, sizeof e->holding);
    memset(e->rate, 0, sizeof e->rate);
    e->forced = false;
}

static void list_sticks(struct closed_form *e) {
    bool legs = cylinder_can_stick(&e->cylinder), joints = joints_can_stick(&e->cylinder.machine);
    for (int k = 0; k < COORDINATES; k++) {
        bool play = k < LEGS && machine_has_play(&e->cylinder.machine, k);
        if (k < LEGS ? legs : joints) e->kind[k] = play ? ROD_STICKS : STICKS;
        if (e->kind[k] == STICKS) e->stick[e->sticks++] = k;
        e->play = e->play || play;
        e->rods_stick = e->rods_stick || e->kind[k] == ROD_STICKS;
    }
}

static struct engine *closed_form_create(const struct params *params, struct error *error) {
    struct closed_form *e = calloc(1, sizeof *e);
    if (!e) {
        error_set(error, STATUS_IO, "no memory for the closed-form engine");
        return NULL;
    }
    e->base.ops = &engine_closed_form;
    cylinder_model_init(&e->cylinder, params);
    rigid_model_init(&e->rigid, params);
    e->joints = e->cylinder.machine.joint_friction.count > 0;
    list_sticks(e);
    e->values = e->play ? (int)(sizeof e->state / sizeof *e->state.value) : e->cylinder.extended ? CLOSED_FORM_NO_PLAY : CLOSED_FORM_PLAIN;
    closed_form_place(&e->base, (const double[DOFS]){0}, (const double[LEGS]){0});
    return &e->base;
}

static void closed_form_destroy(struct engine *base) { free(base); }

static void closed_form_substep(struct engine *base, double dt_s, const double valve[LEGS], struct hydraulics_state *hydraulics) {
    struct closed_form *e = (struct closed_form *)base;
    size_t size = e->cylinder.extended ? sizeof *hydraulics : sizeof hydraulics->cylinder;
    e->forced = false;
    memcpy(&e->state.hydraulics, hydraulics, size);
    step(e, dt_s, &(struct drive){.valve = valve});
    memcpy(hydraulics, &e->state.hydraulics, size);
    hydraulics_limit(&e->cylinder, hydraulics);
}

static void closed_form_forced(struct engine *base, double dt_s, const double force_n[LEGS]) {
    struct closed_form *e = (struct closed_form *)base;
    e->forced = true;
    memset(&e->state.hydraulics, 0, sizeof e->state.hydraulics);
    step(e, dt_s, &(struct drive){.force_n = force_n});
}

static void closed_form_supply(struct engine *base, double share) { ((struct closed_form *)base)->cylinder.supply_share = share; }

static void closed_form_truth(const struct engine *base, const struct hydraulics_state *hydraulics, struct plant_truth *truth) {
    static const double nothing[LEGS];
    const struct closed_form *e = (const struct closed_form *)base;
    struct instant now;
    union system s = e->state;
    s.hydraulics = *hydraulics;
    closed_form_look(e, &s, e->forced ? &(struct drive){.force_n = nothing} : &(struct drive){.valve = nothing}, &now);
    rigid_pose(&s.body, truth->pose);
    memcpy(truth->twist, s.body.twist, sizeof truth->twist);
    for (int k = 0; k < LEGS; k++) {
        truth->length_m[k] = now.length_m[k];
        truth->rate_mps[k] = now.rate_mps[k];
        truth->stuck[k] = e->kind[k] != SLIDES && e->direction[k] == 0;
        truth->friction_n[k] = (truth->stuck[k] ? e->holding[k] : now.friction_n[k]) + now.passive_n[k];
    }
    rigid_energy(&e->rigid, &s.body, &truth->kinetic_j, &truth->potential_j);
    for (int k = 0; k < LEGS; k++) {
        double joint_mps = now.legs.rate[k], mass = e->rigid.upper_mass[k];
        truth->kinetic_j += 0.5 * mass * (now.rate_mps[k] * now.rate_mps[k] - joint_mps * joint_mps);
        for (int i = 0; i < 3; i++)
            truth->potential_j -= mass * e->cylinder.machine.bodies.gravity_mps2 * e->cylinder.machine.bodies.down[i] * now.legs.n[i][k] *
                                  (now.length_m[k] - now.legs.length[k]);
    }
}

const struct engine_ops engine_closed_form = {
    .name = "closed_form",
    .create = closed_form_create,
    .destroy = closed_form_destroy,
    .place = closed_form_place,
    .substep = closed_form_substep,
    .forced = closed_form_forced,
    .supply = closed_form_supply,
    .truth = closed_form_truth,
};
