#include "controller.h"

#include <math.h>
#include <stdlib.h>

#include "force.h"
#include "kinematics.h"
#include "measured.h"
#include "memory.h"
#include "modal.h"
#include "model_law.h"
#include "params.h"
#include "pid.h"

static const double RATE_TOLERANCE = 0.01;
static const double NEXT_CYCLES = 1.5; /* samples are missing between two successive samples that
                                        * are more than this many cycles apart */
static const double FORGOTTEN_S = 0.2; /* time in which the controller's filters forget their
                                        * initial state */

struct moments {
    int n;
    double sum, square;
};

static void take(struct moments *m, double x) { m->n++, m->sum += x, m->square += x * x; }

/* Sum of squares about the mean. For equal values rounding can make it negative, so it is clamped
 * at zero. */
static double variance_sum(const struct moments *m) {
    double sum = m->n ? m->square - m->sum * m->sum / m->n : 0.0;
    return sum < 0.0 ? 0.0 : sum;
}

/* Moments over a stretch without a loss of samples longer than FORGOTTEN_S. In a stretch the
 * integrator's unknown initial value adds one constant for each leg. off: recorded less recomputed
 * commands; all: recorded commands. */
struct stretch {
    struct moments off[LEGS], all[LEGS];
};

static void add_stretch(const struct stretch *s, double *difference, double *whole) {
    for (int leg = 0; leg < LEGS; leg++) *difference += variance_sum(&s->off[leg]), *whole += variance_sum(&s->all[leg]);
}

/* Largest difference of a recorded reference from the test's formula, m and rad. */
static const double SAME_POSE = 1e-9;

/* The configured controller, with the control law `pid` or `model`. */
struct driver {
    struct params params;       /* configuration with the tests of the recorded run */
    const struct kinematics *kinematics;
    struct oil_column column[LEGS];
    struct pid pid[LEGS];
    struct modal modal;
    struct model_law model;
    struct reference reference; /* reference of the test, which the law `model` knows ahead of
                                 * time */
};

/* Returns false if modal_init() or model_law_init() refuses the configuration. */
static bool driver_init(struct driver *d, const struct params *p, const struct kinematics *k, const struct recording *r,
                        const struct recording_test *t) {
    struct error error;
    d->params = *p;
    d->params.tests = r->run[t->run];
    d->kinematics = k;
    oil_columns_init(d->column, p, k);
    if (modal_init(&d->modal, &d->params, k, &error) || model_law_init(&d->model, &d->params, k, &error)) return false;
    reference_test(&d->reference, t->dof, NULL, &d->params.tests, p->loop.period_s);
    return true;
}

/* Starts the filters at this sample, as if the controller had sent the sample's valve commands
 * until now. The integrator's true value is unknown; its error adds a constant to all later
 * commands. */
static void driver_begin(struct driver *d, const struct recording_sample *s, const double ref_m[LEGS], const double force_n[LEGS]) {
    double seen_m[LEGS];
    modal_lengths(&d->modal, ref_m, s->length_m, seen_m);
    model_law_reset(&d->model);
    d->model.share = 1.0;
    for (int leg = 0; leg < LEGS; leg++) {
        pid_reset(&d->pid[leg], ref_m[leg], force_n[leg]);
        d->pid[leg].integral = s->valve[leg] - d->params.control.kp * (ref_m[leg] - seen_m[leg]);
        if (d->params.control.law == CONTROL_MODEL) d->pid[leg].integral = 0.0;
        for (int i = 0; i < MODEL_DELAY_CYCLES; i++) d->model.sent[leg][i] = s->valve[leg];
    }
}

/* Advances the reference to the sample's time. Returns true if the recorded reference equals that
 * of the formula; in a test that was stopped it does not. */
static bool driver_follows_formula(struct driver *d, const struct recording_sample *s) {
    double motion[MOTION_ORDERS][DOFS], period_s = d->params.loop.period_s, most = 0.0;
    d->reference.ticks = llround(s->test_time_s / period_s) + 1;
    reference_motion(&d->reference, &d->params.tests, period_s, 0.0, motion);
    for (int i = 0; i < DOFS; i++) most = fmax(most, fabs(motion[MOTION_POSE][i] - s->ref[i]));
    return most < SAME_POSE;
}

/* Computes the commands for a sample. Holds the controller and returns false if the sample is
 * excluded, or if the law `model` looks ahead in a reference that differs from the recorded one. */
static bool driver_step(struct driver *d, const struct recording_sample *s, const double ref_m[LEGS], const double force_n[LEGS],
                        double dt_s, double valve[LEGS]) {
    bool model = d->params.control.law == CONTROL_MODEL, held = s->refused || (model && !driver_follows_formula(d, s));
    double seen_m[LEGS];
    modal_lengths(&d->modal, ref_m, s->length_m, seen_m);
    if (held) model_law_hold(&d->model);
    else if (model) model_law_step(&d->model, &(struct model_law_input){&d->reference, s->p1_pa, s->p2_pa, 0});
    for (int leg = 0; leg < LEGS; leg++) {
        struct pid *pid = &d->pid[leg];
        pid->feedback_cut = oil_feedback_cut(&d->column[leg], s->length_m[leg]);
        if (held) pid_hold(pid, ref_m[leg]);
        else if (model) valve[leg] = model_law_command(&d->model, &d->params.control, leg, pid, ref_m[leg], seen_m[leg], force_n[leg]);
        else valve[leg] = pid_step(pid, &d->params.control, dt_s, ref_m[leg], seen_m[leg], force_n[leg]);
    }
    return !held;
}

/* Compares the commands of one test. The filters start in the ramp-in; commands are compared in the
 * evaluated part, when the filters have forgotten their start. A short loss of samples counts as
 * one long step of the controller; after a long loss a new stretch with new filters begins. */
static void compare(struct driver *d, const struct recording_test *t, double *difference, double *whole) {
    struct cylinder_areas areas = cylinder_areas(&d->params.actuator);
    struct stretch stretch = {0};
    double period_s = d->params.loop.period_s, compared_s = t->first < 0 ? HUGE_VAL : t->sample[t->first].test_time_s;
    for (int i = 0; i < t->count; i++) {
        const struct recording_sample *s = &t->sample[i];
        double ref_m[LEGS], force_n[LEGS], valve[LEGS], after_s = i ? s->test_time_s - t->sample[i - 1].test_time_s : HUGE_VAL;
        bool begins = after_s > FORGOTTEN_S, lost = after_s > NEXT_CYCLES * period_s;
        if (begins && i) {
            add_stretch(&stretch, difference, whole);
            stretch = (struct stretch){0};
            compared_s = fmax(compared_s, s->test_time_s + FORGOTTEN_S);
        }
        ik_lengths(d->kinematics, s->ref, ref_m);
        for (int leg = 0; leg < LEGS; leg++) force_n[leg] = leg_force(&areas, leg, s->p1_pa[leg], s->p2_pa[leg]);
        if (begins) driver_begin(d, s, ref_m, force_n);
        if (!driver_step(d, s, ref_m, force_n, lost && !begins ? after_s : period_s, valve)) continue;
        if (lost || s->test_time_s < compared_s) continue;
        for (int leg = 0; leg < LEGS; leg++) {
            take(&stretch.off[leg], s->valve[leg] - valve[leg]);
            take(&stretch.all[leg], s->valve[leg]);
        }
    }
    add_stretch(&stretch, difference, whole);
}

double controller_other_rate(const struct params *params, const struct recording *recording) {
    double other_s = 0.0;
    bool controlled = !params_mechanism(params)->refuses.run && recording->measured.valve;
    for (int i = 0; i < recording->tests && controlled; i++) {
        double step_s = recording->test[i].measured->step_s;
        if (fabs(step_s / params->loop.period_s - 1.0) > RATE_TOLERANCE) other_s = step_s;
    }
    return other_s;
}

double controller_difference(const struct params *params, const struct recording *recording) {
    struct kinematics k;
    struct error error;
    double difference = 0.0, whole = 0.0;
    bool known = !params_mechanism(params)->refuses.run && recording->measured.valve && recording->measured.pressures &&
                 recording->measured.reference && controller_other_rate(params, recording) == 0.0;
    if (!known || kinematics_init(&k, params, &error)) return NAN;
    struct driver *d = memory_get(1, sizeof *d);
    for (int i = 0; i < recording->tests; i++) {
        const struct recording_test *t = &recording->test[i];
        if (t->segment_s > 0.0) continue;
        if (driver_init(d, params, &k, recording, t)) compare(d, t, &difference, &whole);
    }
    free(d);
    return sqrt(difference / whole);
}
