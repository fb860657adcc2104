#include "reference_check.h"

#include <math.h>
#include <string.h>

#include "measured.h"
#include "params.h"
#include "reference_match.h"
#include "units.h"

/* Guesses a missing reference as a sinusoid of the tested axis alone, with amplitude and phase
 * fitted to all legs. */
static void guess_reference(const struct recording_test *t, const struct kinematics *k, const double mean[LEGS], double wave[2]) {
    static const double small = 1e-4;
    double pose[DOFS] = {0}, moved[LEGS], w = 2.0 * PI * t->frequency_hz, square = 0.0;
    pose[t->dof] = small;
    ik_lengths(k, pose, moved);
    for (int leg = 0; leg < LEGS; leg++) square += pow((moved[leg] - k->neutral_length_m[leg]) / small, 2.0) * 0.5 * (t->end - t->first);
    for (int i = t->first; i < t->end; i++)
        for (int leg = 0; leg < LEGS && !t->sample[i].refused; leg++) {
            double x = (t->sample[i].length_m[leg] - mean[leg]) * (moved[leg] - k->neutral_length_m[leg]) / small / square;
            wave[0] += x * sin(w * t->sample[i].test_time_s), wave[1] += x * cos(w * t->sample[i].test_time_s);
        }
}

/* Adds a test's moments, which reveal wrong signs, exchanged legs and another machine. */
static void add_test(const struct recording *r, const struct recording_test *t, const struct kinematics *k, struct leg_moments *m) {
    double mean[LEGS] = {0}, sum[LEGS] = {0}, asked[LEGS], before[LEGS] = {0}, rate[LEGS], wave[2] = {0}, w = 2.0 * PI * t->frequency_hz,
           n = 0.0;
    double step_s = t->measured->step_s, last_s = -HUGE_VAL;
    for (int i = t->first; i < t->end; i++) n += !t->sample[i].refused;
    for (int i = t->first; i < t->end; i++)
        for (int leg = 0; leg < LEGS && !t->sample[i].refused; leg++) mean[leg] += t->sample[i].length_m[leg] / n;
    if (!r->measured.reference) guess_reference(t, k, mean, wave);
    for (int i = t->first; i < t->end; i++) {
        double pose[DOFS] = {0}, phase = w * t->sample[i].test_time_s;
        if (t->sample[i].refused) continue;
        if (!r->measured.reference) pose[t->dof] = wave[0] * sin(phase) + wave[1] * cos(phase);
        ik_lengths(k, r->measured.reference ? t->sample[i].ref : pose, asked);
        double since_s = t->sample[i].test_time_s - last_s;
        for (int a = 0; a < LEGS; a++) rate[a] = since_s < 1.5 * step_s ? (asked[a] - before[a]) / since_s : 0.0;
        memcpy(before, asked, sizeof before);
        last_s = t->sample[i].test_time_s;
        for (int a = 0; a < LEGS; a++) {
            double x = t->sample[i].length_m[a] - mean[a], y = asked[a] - k->neutral_length_m[a];
            sum[a] += y / n;
            m->measured[a] += x * x;
            for (int b = 0; b < LEGS; b++) {
                double other = asked[b] - k->neutral_length_m[b];
                m->product[a][b] += x * other, m->asked[a][b] += y * other;
                m->late[a][b] += x * rate[b], m->mixed[a][b] += rate[a] * other, m->rates[a][b] += rate[a] * rate[b];
            }
        }
    }
    /* The reference is taken about its mean, as the lengths are, because a segment of a motion may
     * be far from neutral. */
    for (int a = 0; a < LEGS; a++)
        for (int b = 0; b < LEGS; b++) m->asked[a][b] -= n * sum[a] * sum[b];
}

/* Refuses a reference against which all legs move. A wrong sign of a leg's length would make only
 * this leg move against the reference. The segments of a record are judged together, because in a
 * single segment a weak loop may let the legs move against the reference. */
static int check_reference(const struct recording *r, int first, int end, const struct kinematics *k, struct error *error) {
    const struct recording_test *t = &r->test[first];
    struct leg_moments m = {0};
    double product = 0.0, measured = 0.0, asked = 0.0;
    if (!r->measured.reference) return STATUS_OK;
    for (int i = first; i < end; i++) add_test(r, &r->test[i], k, &m);
    for (int a = 0; a < LEGS; a++) product += m.product[a][a], measured += m.measured[a], asked += m.asked[a][a];
    if (!(product < -0.5 * sqrt(measured * asked))) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "test %s: all legs move against the reference: the sign of its %s is wrong",
                     recording_test_name(t), t->dof == DOF_NONE ? "reference" : reference_names[t->dof]);
}

/* Refuses a drawing that is turned or mirrored against the reference, which lengths and forces
 * alone cannot show, and legs that follow the reference in another order. */
static int check_drawing(const struct recording *r, const struct kinematics *k, struct error *error) {
    struct leg_moments m = {0};
    struct reference_match match;
    if (!r->measured.reference) return STATUS_OK;
    for (int i = recording_first_of_run(r); i < r->tests; i++) add_test(r, &r->test[i], k, &m);
    reference_match_find(r->params, &m, &match);
    return match.refuted ? error_set(error, STATUS_USAGE, "%s", match.text) : STATUS_OK;
}

static int check_legs(const struct recording *r, const struct kinematics *k, struct error *error) {
    struct leg_moments m = {0};
    for (int i = recording_first_of_run(r), end; i < r->tests; i = end) {
        for (end = i + 1; end < r->tests && !recording_begins(r, end);) end++;
        int status = check_reference(r, i, end, k, error);
        if (status) return status;
    }
    for (int i = recording_first_of_run(r); i < r->tests; i++) {
        if (r->measured.reference || !(r->test[i].segment_s > 0.0)) add_test(r, &r->test[i], k, &m);
    }
    for (int a = 0; a < LEGS; a++) {
        double own = m.product[a][a] / sqrt(m.measured[a] * m.asked[a][a]), best = own;
        int like = a;
        if (!isfinite(own)) continue; /* the leg or its reference is at rest */
        for (int b = 0; b < LEGS; b++) {
            double other = m.product[a][b] / sqrt(m.measured[a] * m.asked[b][b]);
            if (other > best + 0.2) best = other, like = b;
        }
        if (own < -0.5) return error_set(error, STATUS_USAGE, "the length of leg %d moves against its reference: its sign is wrong", a + 1);
        if (like != a && best > 0.8)
            return error_set(error, STATUS_USAGE, "the length of leg %d moves as leg %d should: two legs are exchanged", a + 1, like + 1);
        double scale = sqrt(m.measured[a] / m.asked[a][a]);
        if (!(scale > 0.2 && scale < 2.0)) /* the lower limit is wide, because a loop that cannot
                                            * follow moves a leg less than asked */
            return error_set(error, STATUS_USAGE,
                             "leg %d moves %.3g times as far as the reference asks for: other units, or another machine", a + 1, scale);
    }
    return STATUS_OK;
}

int reference_check(const struct recording *r, const struct kinematics *k, struct error *error) {
    int status = check_drawing(r, k, error);
    return status ? status : check_legs(r, k, error);
}
