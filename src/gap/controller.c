#include "controller.h"

#include <math.h>

#include "force.h"
#include "kinematics.h"
#include "params.h"
#include "pid.h"

static const double RATE_TOLERANCE = 0.01;
static const double NEXT_CYCLES = 1.5; /* samples were lost between two that are more than this many
                                        * cycles apart */
static const double FORGOTTEN_S = 0.2; /* time in which the controller's filters forget their
                                        * initial state */

struct moments {
    int n;
    double sum, square;
};

static void take(struct moments *m, double x) { m->n++, m->sum += x, m->square += x * x; }

/* Sum of squares about the mean. Rounding can make that of equal values negative, so it is clamped
 * at zero. */
static double variance_sum(const struct moments *m) {
    double sum = m->n ? m->square - m->sum * m->sum / m->n : 0.0;
    return sum < 0.0 ? 0.0 : sum;
}

/* Moments over a stretch of samples without a gap, in which the integrator's unknown initial
 * value adds one constant for each leg. off: recorded less recomputed commands; all: recorded
 * commands. */
struct stretch {
    struct moments off[LEGS], all[LEGS];
};

static void add_stretch(const struct stretch *s, double *difference, double *whole) {
    for (int leg = 0; leg < LEGS; leg++) *difference += variance_sum(&s->off[leg]), *whole += variance_sum(&s->all[leg]);
}

/* Compares the commands of one test. The filters start at rest in the ramp-in; commands are
 * compared in the evaluated part, when the filters have forgotten their start. A short loss of
 * samples counts as one long step; a long one begins a new stretch with new filters. */
static void compare(const struct params *p, const struct kinematics *k, const struct recording_test *t, double *difference, double *whole) {
    struct cylinder_areas areas = cylinder_areas(&p->actuator);
    struct oil_column column[LEGS];
    struct stretch stretch = {0};
    struct pid pid[LEGS];
    double compared_s = t->first < 0 ? HUGE_VAL : t->sample[t->first].test_time_s;
    oil_columns_init(column, p, k);
    for (int i = 0; i < t->count; i++) {
        const struct recording_sample *s = &t->sample[i];
        double ref_m[LEGS], after_s = i ? s->test_time_s - t->sample[i - 1].test_time_s : HUGE_VAL;
        bool begins = after_s > FORGOTTEN_S, lost = after_s > NEXT_CYCLES * p->loop.period_s;
        if (begins && i) {
            add_stretch(&stretch, difference, whole);
            stretch = (struct stretch){0};
            compared_s = fmax(compared_s, s->test_time_s + FORGOTTEN_S);
        }
        ik_lengths(k, s->ref, ref_m);
        for (int leg = 0; leg < LEGS; leg++) {
            double force_n = leg_force(&areas, leg, s->p1_pa[leg], s->p2_pa[leg]);
            if (begins) {
                pid_reset(&pid[leg], ref_m[leg], force_n);
                pid[leg].integral = s->valve[leg] - p->control.kp * (ref_m[leg] - s->length_m[leg]);
            }
            if (s->refused) {
                pid_hold(&pid[leg], ref_m[leg]);
                continue;
            }
            pid[leg].feedback_cut = oil_feedback_cut(&column[leg], s->length_m[leg]);
            double u = pid_step(&pid[leg], &p->control, lost && !begins ? after_s : p->loop.period_s, ref_m[leg], s->length_m[leg],
                                force_n);
            if (lost || s->test_time_s < compared_s) continue;
            take(&stretch.off[leg], s->valve[leg] - u);
            take(&stretch.all[leg], s->valve[leg]);
        }
    }
    add_stretch(&stretch, difference, whole);
}

double controller_other_rate(const struct params *params, const struct recording *recording) {
    double other_s = 0.0;
    bool controlled = !params_mechanism(params)->refuses.run && recording->measured.valve;
    for (int i = 0; i < recording->tests && controlled; i++) {
        double step_s = recording_step_s(&recording->test[i]);
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
    for (int i = 0; i < recording->tests; i++)
        if (!(recording->test[i].segment_s > 0.0)) compare(params, &k, &recording->test[i], &difference, &whole);
    return sqrt(difference / whole);
}
