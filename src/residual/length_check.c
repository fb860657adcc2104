#include "length_check.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "leg_order.h"
#include "params.h"

static const double NEUTRAL_TOLERANCE_M = 0.05;
static const double TURNED_RAD = 0.3;   /* no motion has a mean pose that is turned by more than
                                         * this */

static void mean_lengths(const struct recording_test *t, double mean_m[LEGS]) {
    double n = 0.0;
    memset(mean_m, 0, LEGS * sizeof *mean_m);
    for (int i = t->first; i < t->end; i++) n += !t->sample[i].refused;
    for (int i = t->first; i < t->end; i++)
        for (int leg = 0; leg < LEGS && !t->sample[i].refused; leg++) mean_m[leg] += t->sample[i].length_m[leg] / n;
}

static int refuse_length(const struct params *p, const struct recording_test *t, int leg, const char *where, double length_m,
                         double model_m, struct error *error) {
    double mean_m[LEGS];
    char order[LEG_ORDER_TEXT], drawing[LEG_ORDER_TEXT + 80] = "";
    mean_lengths(t, mean_m);
    if (leg_order_of_drawing(p, mean_m, NEUTRAL_TOLERANCE_M, order))
        snprintf(drawing, sizeof drawing, "; or the joints of the platform are listed otherwise than those of the base: %s", order);
    return error_set(error, STATUS_USAGE, "test %s: leg %d is %.4g m long%s, the model's %.4g: other units, or another machine%s",
                     recording_test_name(t), leg + 1, length_m, where, model_m, drawing);
}

static int check_machine(const struct params *p, const struct recording_test *t, const struct kinematics *k, struct error *error) {
    double mean_m[LEGS];
    mean_lengths(t, mean_m);
    for (int leg = 0; leg < LEGS; leg++)
        if (fabs(mean_m[leg] - k->neutral_length_m[leg]) > NEUTRAL_TOLERANCE_M)
            return refuse_length(p, t, leg, " at its middle", mean_m[leg], k->neutral_length_m[leg], error);
    return STATUS_OK;
}

/* Refuses a drawing if no pose near neutral has the mean lengths, but the drawing would have just
 * these lengths at neutral if the joints of the platform were listed in another order than those of
 * the base. */
static int check_lists(const struct params *p, const struct recording_test *t, const struct kinematics *k, struct error *error) {
    double mean_m[LEGS], pose[DOFS] = {0}, turned = 0.0;
    char order[LEG_ORDER_TEXT];
    mean_lengths(t, mean_m);
    bool converged = fk_solve(k, mean_m, pose).converged;
    for (int i = DOF_PHI; i < DOFS; i++) turned = fmax(turned, fabs(pose[i]));
    if ((converged && turned < TURNED_RAD) || !leg_order_of_drawing(p, mean_m, NEUTRAL_TOLERANCE_M, order)) return STATUS_OK;
    return error_set(
        error, STATUS_USAGE,
        "test %s: no pose of this drawing has these lengths: the joints of the platform are listed otherwise than those of the "
        "base: %s",
        recording_test_name(t), order);
}

/* Refuses lengths more than NEUTRAL_TOLERANCE_M beyond the end stops; between the stops any motion
 * is allowed. */
static int check_reach(const struct params *p, const struct recording_test *t, const struct kinematics *k, struct error *error) {
    for (int leg = 0; leg < LEGS; leg++) {
        double stroke_m = p->actuator.stroke_m[leg], middle_m = kinematics_stroke(k, &p->actuator, leg).middle_m;
        for (int i = t->first; i < t->end; i++)
            if (!t->sample[i].refused && fabs(t->sample[i].length_m[leg] - middle_m) > 0.5 * stroke_m + NEUTRAL_TOLERANCE_M)
                return refuse_length(p, t, leg, "", t->sample[i].length_m[leg], middle_m, error);
    }
    return STATUS_OK;
}

/* Refuses measured positions of a single axis that lie outside its stroke. */
static int check_stroke(const struct params *p, const struct recording_test *t, struct error *error) {
    double low = HUGE_VAL, high = -HUGE_VAL, middle = p->axis.middle_m, half = 0.5 * p->actuator.stroke_m[0];
    for (int i = t->first; i < t->end; i++) {
        if (t->sample[i].refused) continue;
        low = fmin(low, t->sample[i].length_m[0]), high = fmax(high, t->sample[i].length_m[0]);
    }
    if (low >= middle - half && high <= middle + half) return STATUS_OK;
    return error_set(error, STATUS_USAGE,
                     "the position runs from %.4g to %.4g m, outside a stroke of %g m about %g m (actuator.stroke_m, "
                     "axis.middle_m): other units, or another zero",
                     low, high, p->actuator.stroke_m[0], middle);
}

int length_check(const struct params *p, const struct recording_test *t, const struct kinematics *k, bool any, struct error *error) {
    int status = k && any ? check_lists(p, t, k, error) : STATUS_OK;
    if (!status && !k) status = check_stroke(p, t, error);
    if (!status && k) status = any ? check_reach(p, t, k, error) : check_machine(p, t, k, error);
    return status;
}
