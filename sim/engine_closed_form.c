/* The closed-form engine: rigid.h's bodies and the hydraulics in one RK4. Dry friction makes the right-hand side jump where a coordinate
 * stops, so no step crosses such an instant: it is found, stepped to, and there decided whether the coordinate stays (stick.h). */
#include <stdlib.h>
#include <string.h>

#include "engine.h"
#include "joint_axes.h"
#include "rigid.h"
#include "stick.h"
#include "vec3.h"

/* Coordinates with friction: the legs, then the axes of the universal joints. */
enum { COORDINATES = LEGS + JOINT_AXES, EVENTS_MAX = 4 * COORDINATES };

static const double STOPPED = 1e-9; /* m/s or rad/s: at rest, when an event is sought */

union machine {
    struct {
        struct rigid_state body;
        struct cylinder_state cylinder[LEGS];
    };
    double value[(sizeof(struct rigid_state) + LEGS * sizeof(struct cylinder_state)) / sizeof(double)];
};

/* What moves the legs over a step: valve commands, or these forces instead of hydraulics. */
struct drive {
    const double *valve, *force_n;
};

struct closed_form {
    struct engine base;
    const struct params *params;
    struct cylinder_model cylinder;
    struct rigid_model rigid;
    bool joints;                     /* there is joint friction */
    int first, last;                 /* the coordinates that dry friction can hold: first <= k < last */
    union machine state;
    int direction[COORDINATES];      /* of those: +1, -1 sliding, over a whole step; 0 held */
    double holding[COORDINATES];     /* force that holds them */
    double rate[COORDINATES];        /* in this state */
};

/* The machine at one instant. */
struct instant {
    struct rigid_legs legs;
    struct joint_axes axes;          /* only with joint friction */
    double friction_n[LEGS], stop_n[LEGS];
    struct factor6 mass;             /* its Cholesky factor */
    double free[DOFS];               /* whitened acceleration, but for the friction at rest */
};

static void coordinate_row(const struct instant *now, int k, double row[DOFS], double *bias) {
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

static double coordinate_rate(const struct instant *now, const union machine *s, int k) {
    return k < LEGS ? now->legs.rate[k] : dot6(now->axes.row[k - LEGS], s->body.twist);
}

/* Direction of sliding: fixed over a step where friction may hold, otherwise that of the motion. */
static int direction_of(const struct closed_form *e, int k, double rate) {
    if (k >= e->first && k < e->last) return e->direction[k];
    return rate < 0.0 ? -1 : 1;
}

/* Friction of leg `leg` on the platform; nothing but dry friction when the hydraulics are left out. */
static double leg_friction(const struct closed_form *e, const union machine *s, const struct drive *drive, int leg, double rate) {
    int direction = direction_of(e, leg, rate);
    double speed = direction * rate;
    if (direction == 0) return 0.0;
    struct friction f = cylinder_friction(&e->cylinder, leg, &s->cylinder[leg], direction, speed > 0.0 ? speed : 0.0);
    return -direction * (f.dry + (drive->valve ? f.viscous : 0.0));
}

static void push_joints(const struct closed_form *e, const union machine *s, struct instant *now) {
    for (int k = LEGS; k < COORDINATES; k++) {
        double rate = coordinate_rate(now, s, k);
        int direction = direction_of(e, k, rate);
        struct friction f = joint_friction(e->params, (k - LEGS) / JOINT_AXES_PER_LEG, fabs(rate));
        double moment = -direction * f.dry - (rate < 0.0 ? -f.viscous : f.viscous);
        if (direction != 0) add6(moment, now->axes.row[k - LEGS], now->free);
    }
}

static void look(const struct closed_form *e, const union machine *s, const struct drive *drive, struct instant *now) {
    double axial[LEGS];
    rigid_legs(&e->rigid, &s->body, &now->legs);
    rigid_dynamics(&e->rigid, &s->body, &now->legs, now->mass.c, now->free);
    for (int k = 0; k < LEGS; k++) {
        double drive_n = drive->valve ? cylinder_hydraulic_force(&e->cylinder, &s->cylinder[k]) : drive->force_n[k];
        now->friction_n[k] = leg_friction(e, s, drive, k, now->legs.rate[k]);
        now->stop_n[k] = cylinder_stop_force(&e->cylinder, now->legs.length[k], now->legs.rate[k]);
        axial[k] = drive_n + now->friction_n[k] + now->stop_n[k];
    }
    rigid_push(&now->legs, axial, now->free);
    if (e->joints) {
        joint_axes(&e->rigid, &s->body, &now->legs, &now->axes);
        push_joints(e, s, now);
    }
    factor6(&now->mass);
    whiten6(&now->mass, now->free);
}

static bool held(const struct closed_form *e, int k) { return k >= e->first && k < e->last && e->direction[k] == 0; }

static void held_basis(const struct closed_form *e, const struct instant *now, struct stick_basis *basis) {
    basis->rank = 0;
    for (int k = e->first; k < e->last; k++) {
        double row[DOFS], bias;
        if (!held(e, k)) continue;
        coordinate_row(now, k, row, &bias);
        whiten6(&now->mass, row);
        stick_basis_add(basis, row, bias);
    }
}

static void derivative(const struct closed_form *e, const union machine *s, const struct drive *drive, union machine *rate) {
    struct instant now;
    struct stick_basis basis;
    look(e, s, drive, &now);
    if (e->first < e->last) {
        held_basis(e, &now, &basis);
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
    for (int k = 0; k < LEGS; k++)
        rate->cylinder[k] = drive->valve ? cylinder_derivative(&e->cylinder, &s->cylinder[k], now.legs.length[k], now.legs.rate[k], drive->valve[k])
                                         : (struct cylinder_state){0};
}

enum { VALUES = sizeof(union machine) / sizeof(double) };

static void blend(const union machine *from, double h, const union machine *rate, union machine *to) {
    for (int i = 0; i < VALUES; i++) to->value[i] = from->value[i] + h * rate->value[i];
}

static void rk4(const struct closed_form *e, const union machine *from, double h, const struct drive *drive, union machine *to) {
    union machine k1, k2, k3, k4, at;
    derivative(e, from, drive, &k1);
    blend(from, 0.5 * h, &k1, &at);
    derivative(e, &at, drive, &k2);
    blend(from, 0.5 * h, &k2, &at);
    derivative(e, &at, drive, &k3);
    blend(from, h, &k3, &at);
    derivative(e, &at, drive, &k4);
    for (int i = 0; i < VALUES; i++)
        to->value[i] = from->value[i] + h / 6.0 * (k1.value[i] + 2.0 * (k2.value[i] + k3.value[i]) + k4.value[i]);
    double *q = to->body.attitude, scale = 1.0 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; i++) q[i] *= scale;
}

/* --- stick and slip --- */

static void coordinate_rates(const struct closed_form *e, const union machine *s, double rate[COORDINATES]) {
    struct instant now;
    rigid_legs(&e->rigid, &s->body, &now.legs);
    if (e->last > LEGS) joint_axes(&e->rigid, &s->body, &now.legs, &now.axes);
    for (int k = e->first; k < e->last; k++) rate[k] = coordinate_rate(&now, s, k);
}

/* Takes out of the twist what is left of the held coordinates' motion. */
static void stop_held(struct closed_form *e, const struct instant *now) {
    struct stick_basis basis;
    double *twist = e->state.body.twist, x[DOFS];
    held_basis(e, now, &basis);
    for (int i = 0; i < DOFS; i++) { /* x = C' twist */
        x[i] = twist[i] / now->mass.c[i][i];
        for (int j = i + 1; j < DOFS; j++) x[i] += now->mass.c[j][i] * twist[j];
    }
    stick_hold(&basis, 0.0, x);
    unwhiten6(&now->mass, x);
    memcpy(twist, x, sizeof x);
}

static struct stick_coordinate at_rest(const struct closed_form *e, const struct instant *now, int k) {
    struct stick_coordinate c;
    coordinate_row(now, k, c.row, &c.bias);
    whiten6(&now->mass, c.row);
    if (k < LEGS) {
        c.extend_limit = cylinder_friction(&e->cylinder, k, &e->state.cylinder[k], 1, 0.0).dry;
        c.retract_limit = cylinder_friction(&e->cylinder, k, &e->state.cylinder[k], -1, 0.0).dry;
    } else {
        c.extend_limit = c.retract_limit = joint_friction(e->params, (k - LEGS) / JOINT_AXES_PER_LEG, 0.0).dry;
    }
    return c;
}

/* Holds what has stopped. Returns how many more than before. */
static int arrest(struct closed_form *e) {
    int more = 0;
    for (int k = e->first; k < e->last; k++)
        if (e->direction[k] != 0 && e->direction[k] * e->rate[k] <= STOPPED) {
            e->direction[k] = 0;
            more++;
        }
    return more;
}

static int held_places(const struct closed_form *e, int place[COORDINATES]) {
    int count = 0;
    for (int k = e->first; k < e->last; k++)
        if (held(e, k)) place[count++] = k;
    return count;
}

/* At the start of a step: what has stopped is held, brought to rest exactly, and let go where its friction is too weak. Bringing one
 * coordinate to rest may stop others that move with it; they must all be known before any is let go. */
static void release(struct closed_form *e, const struct drive *drive, const bool caught[COORDINATES]) {
    struct stick_coordinate rest[COORDINATES];
    struct instant now;
    int place[COORDINATES];
    arrest(e);
    if (held_places(e, place) == 0) return;
    do {
        look(e, &e->state, drive, &now);
        stop_held(e, &now);
        coordinate_rates(e, &e->state, e->rate);
    } while (arrest(e) > 0);
    int count = held_places(e, place);
    for (int i = 0; i < count; i++) rest[i] = at_rest(e, &now, place[i]);
    stick_resolve(rest, count, now.free);
    for (int i = 0; i < count; i++) {
        e->holding[place[i]] = rest[i].force;
        if (!caught[place[i]]) e->direction[place[i]] = rest[i].slip;
    }
}

/* How far the coordinates of `which` are from having stopped: <= 0 when the first has. */
static double nearest_to_rest(const struct closed_form *e, const bool which[COORDINATES], const double rate[COORDINATES]) {
    double nearest = INFINITY;
    for (int k = e->first; k < e->last; k++)
        if (which[k] && e->direction[k] * rate[k] < nearest) nearest = e->direction[k] * rate[k];
    return nearest;
}

/* Steps to the instant, before h, when the first of the coordinates that turn round stops (Illinois rule). Returns its time. */
static double step_to_rest(const struct closed_form *e, double h, const struct drive *drive, const bool turning[COORDINATES],
                           double start, double end, union machine *to) {
    double low = 0.0, high = h, at = h, rate[COORDINATES];
    int side = 0;
    for (int i = 0; i < 60 && high - low > 1e-12 * h; i++) {
        at = low + (high - low) * start / (start - end);
        rk4(e, &e->state, at, drive, to);
        coordinate_rates(e, to, rate);
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

/* From here to h, or to the first instant when a coordinate stops. Returns the time gone. A coordinate that turns round as soon as it is
 * let go is caught: held to the end of the substep. */
static double slide(struct closed_form *e, double h, const struct drive *drive, bool caught[COORDINATES]) {
    double rate[COORDINATES];
    bool turning[COORDINATES] = {false}, any = false, at_once = false;
    union machine to;
    rk4(e, &e->state, h, drive, &to);
    coordinate_rates(e, &to, rate);
    for (int k = e->first; k < e->last; k++) {
        turning[k] = e->direction[k] * rate[k] < 0.0;
        any = any || turning[k];
        if (!turning[k] || e->direction[k] * e->rate[k] > STOPPED) continue;
        caught[k] = at_once = true;
        e->direction[k] = 0;
    }
    if (at_once) return 0.0;
    if (any) {
        h = step_to_rest(e, h, drive, turning, nearest_to_rest(e, turning, e->rate), nearest_to_rest(e, turning, rate), &to);
        coordinate_rates(e, &to, rate);
    }
    e->state = to;
    memcpy(e->rate, rate, sizeof rate);
    return h;
}

/* Should events ever pile up, the rest of the step is taken as it comes: wrong by less than a substep's friction, but never endless. */
static void slide_on(struct closed_form *e, double h, const struct drive *drive) {
    rk4(e, &e->state, h, drive, &e->state);
    coordinate_rates(e, &e->state, e->rate);
    for (int k = e->first; k < e->last; k++)
        if (e->direction[k] * e->rate[k] < 0.0) e->direction[k] = -e->direction[k];
}

static void step(struct closed_form *e, double dt, const struct drive *drive) {
    bool caught[COORDINATES] = {false};
    double left = dt;
    if (e->first == e->last) {
        rk4(e, &e->state, dt, drive, &e->state);
        return;
    }
    for (int event = 0; left > 0.0 && event < EVENTS_MAX; event++) {
        release(e, drive, caught);
        left -= slide(e, left, drive, caught);
    }
    if (left > 0.0) slide_on(e, left, drive);
}

/* --- the engine's calls --- */

static bool joints_can_stick(const struct params *params) {
    for (int leg = 0; leg < LEGS; leg++)
        if (joint_friction(params, leg, 0.0).dry > 0.0) return true;
    return false;
}

static struct engine *closed_form_create(const struct params *params, struct error *error) {
    struct closed_form *e = calloc(1, sizeof *e);
    if (!e) {
        error_set(error, STATUS_IO, "no memory for the closed-form engine");
        return NULL;
    }
    e->base.ops = &engine_closed_form;
    e->params = params;
    cylinder_model_init(&e->cylinder, params);
    rigid_model_init(&e->rigid, params);
    e->joints = joint_friction_present(params);
    e->first = cylinder_can_stick(&e->cylinder) ? 0 : LEGS;
    e->last = joints_can_stick(params) ? COORDINATES : LEGS;
    rigid_rest(&e->state.body, (const double[DOFS]){0});
    return &e->base;
}

static void closed_form_destroy(struct engine *base) { free(base); }

static void closed_form_place(struct engine *base, const double pose[DOFS]) {
    struct closed_form *e = (struct closed_form *)base;
    rigid_rest(&e->state.body, pose);
    memset(e->direction, 0, sizeof e->direction);
    memset(e->holding, 0, sizeof e->holding);
    memset(e->rate, 0, sizeof e->rate);
}

static void closed_form_substep(struct engine *base, double dt_s, const double valve[LEGS], struct cylinder_state cylinder[LEGS]) {
    struct closed_form *e = (struct closed_form *)base;
    memcpy(e->state.cylinder, cylinder, sizeof e->state.cylinder);
    step(e, dt_s, &(struct drive){.valve = valve});
    memcpy(cylinder, e->state.cylinder, sizeof e->state.cylinder);
}

static void closed_form_forced(struct engine *base, double dt_s, const double force_n[LEGS]) {
    struct closed_form *e = (struct closed_form *)base;
    memset(e->state.cylinder, 0, sizeof e->state.cylinder);
    step(e, dt_s, &(struct drive){.force_n = force_n});
}

static void closed_form_truth(const struct engine *base, const struct cylinder_state cylinder[LEGS], struct plant_truth *truth) {
    const struct closed_form *e = (const struct closed_form *)base;
    struct instant now;
    union machine s = e->state;
    memcpy(s.cylinder, cylinder, sizeof s.cylinder);
    look(e, &s, &(struct drive){.valve = (const double[LEGS]){0}}, &now);
    rigid_pose(&s.body, truth->pose);
    memcpy(truth->twist, s.body.twist, sizeof truth->twist);
    for (int k = 0; k < LEGS; k++) {
        truth->length_m[k] = now.legs.length[k];
        truth->rate_mps[k] = now.legs.rate[k];
        truth->stuck[k] = held(e, k);
        truth->friction_n[k] = (truth->stuck[k] ? e->holding[k] : now.friction_n[k]) + now.stop_n[k];
    }
    rigid_energy(&e->rigid, &s.body, &truth->kinetic_j, &truth->potential_j);
}

const struct engine_ops engine_closed_form = {
    .name = "closed_form",
    .create = closed_form_create,
    .destroy = closed_form_destroy,
    .place = closed_form_place,
    .substep = closed_form_substep,
    .forced = closed_form_forced,
    .truth = closed_form_truth,
};
