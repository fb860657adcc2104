#include "motion_check.h"

#include <math.h>
#include <string.h>

#include "config.h"
#include "inverse_dynamics.h"
#include "kinematics.h"
#include "params.h"
#include "reference.h"
#include "trajectory_file.h"
#include "valve_flow.h"

static const double stop_every = 0.1;   /* interval between the stops that are tried, as a share of
                                         * the ramp-out's duration; a tenth finds the largest effect
                                         * of the ramp-out's steepest part to within a hundredth */
/* number of cycles from which on a period has a cycle near every phase, so that stops in one period
 * stand for stops in all periods */
enum { PERIOD_TICKS = 64 };
/* number of halvings of the interval 0 to 1 that find the scale to a hundredth */
enum { SCALES = 7 };
enum { HALVINGS = 40 };
static const double LEAST_OPENING = 1e-6; /* opening that is assumed if dead band and null leave a
                                           * valve no opening */

struct instant {
    enum dof dof;                       /* axis of the test */
    double time_s;                      /* time in the test, as cycle.test_time_s */
    bool stopped;                       /* the test was stopped at stop_s */
    double stop_s;
};

/* A limit that is exceeded. */
struct excess {
    const char *what, *unit;            /* quantity and unit: "length", "m" */
    double value, least, rest, most;    /* the value, its limits, and `rest`, the value at neutral,
                                         * from which the allowed deviations count */
    const char *below, *above;          /* configuration keys of the two limits */
    int leg;
    double share;            /* deviation from `rest`, as a share of the allowed deviation; above
                              * 1 */
    struct instant at;
};

struct walk {
    const struct params *params;
    const struct trajectory *trajectory;
    struct kinematics kinematics;
    struct valve_flow flow[LEGS];
    double push_n[2][LEGS];             /* largest forces at rest: [0] that extends the leg, [1]
                                         * that retracts it, both positive */
    struct inverse_dynamics dynamics;
    double scale;                       /* factor by which all poses are multiplied */
    double length_m[3][LEGS];           /* leg lengths in the last three cycles */
    struct instant at;
    bool to_the_end;                    /* continue after an excess, to find the largest excess */
    struct excess worst;
};

/* Compares a value with its limits and notes the worst excess. Returns false, which ends the walk
 * through the motion, after an excess or NaN, unless w->to_the_end is set. */
static bool within(struct walk *w, int leg, struct excess e) {
    if (e.value >= e.least && e.value <= e.most) return true;
    e.share = (e.value - e.rest) / ((e.value < e.rest ? e.least : e.most) - e.rest);
    if (!(e.share > 0.0)) e.share = (double)INFINITY;
    e.leg = leg, e.at = w->at;
    if (e.share > w->worst.share) w->worst = e;
    return w->to_the_end;
}

static bool check_length(struct walk *w, int leg) {
    const struct limit_params *l = &w->params->limits;
    struct stroke stroke = kinematics_stroke(&w->kinematics, &w->params->actuator, leg);
    double neutral_m = w->kinematics.neutral_length_m[leg], in_m = stroke.least_m, out_m = stroke.most_m;
    return within(w, leg,
                  (struct excess){.what = "length",
                                  .unit = "m",
                                  .value = w->length_m[1][leg],
                                  .least = fmax(l->length_min_m[leg], in_m),
                                  .rest = neutral_m,
                                  .most = fmin(l->length_max_m[leg], out_m),
                                  .below = l->length_min_m[leg] > in_m ? "limits.length_min_m" : "actuator.stroke_m",
                                  .above = l->length_max_m[leg] < out_m ? "limits.length_max_m" : "actuator.stroke_m"});
}

static bool check_rate(struct walk *w, int leg, double rate_mps) {
    double most = w->params->limits.leg_rate_mps;
    return within(w, leg,
                  (struct excess){.what = "rate",
                                  .unit = "m/s",
                                  .value = rate_mps,
                                  .least = -most,
                                  .most = most,
                                  .below = "limits.leg_rate_mps",
                                  .above = "limits.leg_rate_mps"});
}

/* Returns the valve's opening at control.output_limit, less dead band and null, as a share of full
 * opening. in: chamber that is connected to the supply, 0 rodless side, 1 rod side. */
static double opening_of(const struct walk *w, int leg, int in) {
    const struct valve_flow *f = &w->flow[leg];
    return fmax(w->params->control.output_limit - f->dead - (in ? -f->null : f->null), LEAST_OPENING);
}

/* Returns the force that is left to a piston at this speed, in the direction in which chamber `in`
 * fills: the left side of the equation of motion_check.h. The leakage depends on the pressures and
 * is therefore the solution of a quadratic equation. */
static double force_left_n(const struct walk *w, int leg, int in, double mps) {
    const struct valve_flow *f = &w->flow[leg];
    double opening = opening_of(w, leg, in), leaks = f->leakage_m3_per_s_pa, ai = f->area_m2[in], ao = f->area_m2[1 - in];
    double root_i = opening * f->gain[in], root_o = opening * f->gain[1 - in], ki = root_i * root_i, ko = root_o * root_o;
    double a = leaks * (1.0 / ki + 1.0 / ko), b = 1.0 + 2.0 * leaks * mps * (ai / ki + ao / ko);
    double c = leaks * (mps * mps * (ai * ai / ki + ao * ao / ko) - (f->supply_pa - f->tank_pa));
    double leak = -2.0 * c / (b + sqrt(fmax(b * b - 4.0 * a * c, 0.0))), in_m3 = ai * mps + leak, out_m3 = ao * mps + leak;
    return ai * (f->supply_pa - in_m3 * in_m3 / ki) - ao * (f->tank_pa + out_m3 * out_m3 / ko);
}

/* Returns the highest speed at which a piston still has this force, by bisection between 0 and
 * most_mps. It must have less force than this at the speed most_mps. */
static double speed_mps(const struct walk *w, int leg, int in, double force_n, double most_mps) {
    double low = 0.0, high = most_mps;
    for (int i = 0; i < HALVINGS; i++) {
        double middle = 0.5 * (low + high);
        *(force_left_n(w, leg, in, middle) >= force_n ? &low : &high) = middle;
    }
    return low;
}

/* Checks a leg's force and its valve's flow; positive forces push the leg out. */
static bool check_drive(struct walk *w, int leg, double rate_mps, double force_n) {
    static const char flow[] = "flow, by hydraulics.valve_flow_m3_per_s, leakage_m3_per_s_pa, supply_pa and the valves' effects",
                      held[] = "hydraulics.supply_pa, leakage_m3_per_s_pa, valve_flow_m3_per_s and the valves' effects";
    double push_n = w->push_n[0][leg], pull_n = w->push_n[1][leg], most_n = w->params->limits.force_n;
    struct excess force = {.what = "force",
                           .unit = "N",
                           .value = force_n,
                           .least = -fmin(pull_n, most_n),
                           .most = fmin(push_n, most_n),
                           .below = most_n < pull_n ? "limits.force_n" : held,
                           .above = most_n < push_n ? "limits.force_n" : held};
    /* if the force itself is beyond a limit, that is the excess, and the flow is not checked */
    if (!(force_n >= force.least && force_n <= force.most)) return within(w, leg, force);
    int in = rate_mps > 0.0 ? 0 : 1;
    double wanted_n = in ? -force_n : force_n;
    if (force_left_n(w, leg, in, fabs(rate_mps)) >= wanted_n) return true;
    double most_mps = speed_mps(w, leg, in, wanted_n, fabs(rate_mps));
    return within(
        w, leg,
        (struct excess){
            .what = "rate", .unit = "m/s", .value = rate_mps, .least = -most_mps, .most = most_mps, .below = flow, .above = flow});
}

/* Checks the last cycle but one, with rates and accelerations from central differences of the
 * lengths. */
static bool check_cycle(struct walk *w) {
    double dt_s = w->params->loop.period_s, force_n[LEGS];
    struct inverse_dynamics_input in = {0};
    for (int k = 0; k < LEGS; k++) {
        double before_m = w->length_m[0][k], now_m = w->length_m[1][k], next_m = w->length_m[2][k];
        in.leg[k][0] = now_m, in.leg[k][1] = (next_m - before_m) / (2 * dt_s);
        in.leg[k][2] = (next_m - 2 * now_m + before_m) / (dt_s * dt_s);
        /* the seals are assumed to slide, because their deflection is then largest */
        in.deflection[k] = inverse_dynamics_direction(in.leg[k][1], in.leg[k][2], dt_s);
        if (!check_length(w, k) || !check_rate(w, k, in.leg[k][1])) return false;
    }
    if (!inverse_dynamics_step(&w->dynamics, &in, force_n))
        return within(w, 0, (struct excess){.what = "pose", .unit = "", .value = (double)NAN, .above = "no pose has these legs"});
    for (int k = 0; k < LEGS; k++)
        if (!check_drive(w, k, in.leg[k][1], force_n[k])) return false;
    return true;
}

static bool take(struct walk *w, const struct reference_sample *s) {
    double pose[DOFS];
    for (int i = 0; i < DOFS; i++) pose[i] = w->scale * s->pose[i];
    memmove(w->length_m[0], w->length_m[1], 2 * sizeof w->length_m[0]);
    ik_lengths(&w->kinematics, pose, w->length_m[2]);
    w->at.time_s = s->test_time_s;
    return check_cycle(w);
}

static bool walk_on(struct walk *w, struct reference *r) {
    const struct params *p = w->params;
    for (bool done = false; !done;) {
        struct reference_sample s = reference_step(r, &p->tests, p->loop.period_s);
        if (!take(w, &s)) return false;
        done = s.done;
    }
    return true;
}

static bool walk_stopped(struct walk *from, const struct reference *r) {
    struct walk w = *from;
    struct reference stopped = *r;
    w.at.stopped = true, w.at.stop_s = (double)r->ticks * w.params->loop.period_s;
    reference_stop(&stopped);
    bool ok = walk_on(&w, &stopped);
    from->worst = w.worst;
    return ok;
}

/* Returns the period of the motion; infinite if it does not repeat. */
static double period_s(const struct walk *w, enum dof dof) {
    if (dof != DOF_NONE) return 1.0 / w->params->tests.hz[dof];
    return w->trajectory ? trajectory_s(w->trajectory) / w->trajectory->passes : (double)INFINITY;
}

/* Returns true if a stop is tried at this instant. Stops are tried at intervals of a tenth of the
 * ramp-out's duration. If the motion repeats after PERIOD_TICKS or more, they are tried only in the
 * ramp-in and the first period, and for a trajectory also near its end, where the ramp-out extends
 * beyond the last pass. */
static bool stops_here(const struct walk *w, const struct reference *r) {
    const struct test_params *t = &w->params->tests;
    double dt_s = w->params->loop.period_s, period = period_s(w, r->dof) / dt_s, ramp = t->ramp_s / dt_s, ramp_out = t->ramp_out_s / dt_s;
    int64_t every = llround(stop_every * ramp_out);
    if (r->ticks <= 0 || r->ticks >= r->ramp_out_tick || r->ticks % (every > 0 ? every : 1)) return false;
    double since = (double)r->ticks - ramp, left = (double)(r->ramp_out_tick - r->ticks);
    return period < PERIOD_TICKS || since <= period || (w->trajectory && left <= ramp_out + period);
}

/* Walks through one test to its end, and from each instant of stops_here() also through a stopped
 * test. The test begins at rest at neutral. */
static bool walk_test(struct walk *w, enum dof dof) {
    const struct params *p = w->params;
    struct reference r;
    reference_test(&r, dof, w->trajectory, &p->tests, p->loop.period_s);
    r.ticks = -2; /* starts two cycles before the ramp-in, because before it the test rests at
                   * neutral */
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < LEGS; k++) w->length_m[i][k] = w->kinematics.neutral_length_m[k];
    w->at = (struct instant){.dof = dof};
    for (bool done = false; !done;) {
        if (stops_here(w, &r) && !walk_stopped(w, &r)) return false;
        struct reference_sample s = reference_step(&r, &p->tests, p->loop.period_s);
        if (!take(w, &s)) return false;
        done = s.done;
    }
    return true;
}

static bool walk_all(struct walk *w, double scale) {
    const struct test_params *t = &w->params->tests;
    bool single = tests_single(t);
    w->scale = scale;
    inverse_dynamics_init(&w->dynamics, w->params, w->params->loop.period_s, 0.0);
    for (int i = 0; i < tests_count(t); i++)
        if (!walk_test(w, single ? t->order[i] : DOF_NONE)) return false;
    return true;
}

/* Returns the largest scale of the motion, in steps of a hundredth, that keeps it within all
 * limits; 0 if there is none. */
static double find_scale(struct walk *w) {
    int low = 0, high = 100;
    for (int i = 0; i < SCALES && high - low > 1; i++) {
        int middle = (low + high) / 2;
        if (walk_all(w, middle / 100.0)) low = middle;
        else high = middle;
    }
    return low / 100.0;
}

static int refuse(struct walk *w, struct error *error) {
    w->to_the_end = true;
    walk_all(w, 1.0);
    w->to_the_end = false;
    struct excess e = w->worst;
    const struct test_params *t = &w->params->tests;
    bool single = tests_single(t);
    char stopped[48] = "", remedy[200];
    /* a trajectory's own time begins after the ramp-in */
    double scale = find_scale(w), from_s = w->trajectory ? t->ramp_s : 0.0;
    bool below = e.value < e.least;
    if (e.at.stopped) snprintf(stopped, sizeof stopped, " (stopped at %.3f s)", e.at.stop_s - from_s);
    if (scale > 0.0)
        snprintf(remedy, sizeof remedy, "scale %s by %.2f, or %s",
                 single          ? "its amplitude"
                 : w->trajectory ? "the poses"
                                 : "all amplitudes",
                 scale, e.at.stopped ? "raise tests.ramp_out_s" : "make it slower");
    else if (walk_all(w, 0.0)) snprintf(remedy, sizeof remedy, "less than a hundredth of it would do: another test, or another limit");
    else
        snprintf(
            remedy, sizeof remedy,
            "it is so at rest, and no smaller motion would do: compare payload.mass_kg, the joints and their order (`hexid doctor` looks "
            "at them), then that limit");
    return error_set(error, STATUS_USAGE, "not run: test %s at %.3f s%s: leg %d has %s %.5g %s, limit %.5g (%s): %s",
                     tests_name(t, e.at.dof), e.at.time_s - from_s, stopped, e.leg + 1, e.what, e.value, e.unit, below ? e.least : e.most,
                     below ? e.below : e.above, remedy);
}

int motion_check(const struct params *params, const struct trajectory *trajectory, struct error *error) {
    struct walk w = {.params = params, .trajectory = trajectory};
    int status = kinematics_init(&w.kinematics, params, error);
    if (status) return status;
    for (int leg = 0; leg < LEGS; leg++) {
        valve_flow_init(&w.flow[leg], leg, params, &w.kinematics);
        for (int in = 0; in < 2; in++) w.push_n[in][leg] = force_left_n(&w, leg, in, 0.0);
    }
    return walk_all(&w, 1.0) ? STATUS_OK : refuse(&w, error);
}

int motion_check_tests(struct params *params, struct trajectory *trajectory, struct error *error) {
    struct test_params *t = &params->tests;
    int status = t->trajectory[0] ? trajectory_load(trajectory, t->trajectory, t->repeat, error) : STATUS_OK;
    if (status) return status;
    if (t->trajectory[0]) t->duration_s = trajectory_s(trajectory);
    status = config_check_motion(params, error);
    return status ? status : motion_check(params, trajectory->knot ? trajectory : NULL, error);
}
