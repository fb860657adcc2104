#include "recording_check.h"

#include <math.h>
#include <string.h>

#include "channel_check.h"
#include "force_check.h"
#include "frequency.h"
#include "kinematics.h"
#include "leg_order.h"
#include "length_check.h"
#include "motion.h"
#include "noise_check.h"
#include "params.h"
#include "reference_check.h"
#include "residual.h"

static const double FREQUENCY_SAME = 5e-5;  /* largest relative difference of two frequencies that
                                             * are the same: two crystals differ by less */

/* Sets a steady sinusoid's frequency to the one at which the legs move. `any`: set to true for any
 * other motion. The stated frequency is a hint. */
static int check_frequency(struct recording_test *t, int legs, bool reference, bool *any, struct error *error) {
    double fitted_hz = t->dof == DOF_NONE ? (double)NAN : frequency_fit(t, legs, reference, t->frequency_hz),
           off = fabs(fitted_hz / t->stated_hz - 1.0);
    *any = !motion_sinusoid(t, legs, fitted_hz);
    if (*any) return STATUS_OK;
    if (off > FREQUENCY_SAME) t->frequency_hz = fitted_hz;
    if ((t->sample[t->end - 1].test_time_s - t->sample[t->first].test_time_s) * t->frequency_hz < RECORDING_CYCLES - 0.1)
        return error_set(error, STATUS_USAGE,
                         "test %s: %.3g s evaluated, too short: at least %d cycles of %g Hz are needed; in a run, raise tests.duration_s",
                         recording_test_name(t), t->sample[t->end - 1].test_time_s - t->sample[t->first].test_time_s, RECORDING_CYCLES,
                         t->frequency_hz);
    return STATUS_OK;
}

/* Stores the frequencies at which the tests moved in the run's parameters, so that the run can be
 * simulated at them. */
static void run_at(struct recording *r, int first) {
    double *hz = r->run[r->runs - 1].hz;
    for (int i = first; i < r->tests; i++) {
        const struct recording_test *t = &r->test[i];
        /* false for NaN, the frequency of a motion that is no sinusoid */
        bool other = t->dof != DOF_NONE && fabs(t->frequency_hz / hz[t->dof] - 1.0) > FREQUENCY_SAME;
        if (other) hz[t->dof] = t->frequency_hz;
    }
}

static bool has_lengths(const struct recording_test *t, int legs) {
    for (int i = t->first; i < t->end; i++) {
        int finite = 0;
        for (int k = 0; k < legs; k++) finite += isfinite(t->sample[i].length_m[k]) != 0;
        if (finite == legs) return true;
    }
    return false;
}

/* Refuses channels whose legs are not in the order of the drawing. */
static int check_order(const struct recording *r, const struct residual_data *data, struct error *error) {
    struct leg_order order;
    int status = leg_order_find(data, r, recording_first_of_run(r), &order, error);
    if (status || !order.refuted) return status;
    return error_set(error, STATUS_USAGE,
                     "lengths, forces and drawing do not belong together; they would with %s (which leaves %.1f %% of the varying force "
                     "unexplained, the stated order %.0f %%)",
                     order.text, 100.0 * order.best, 100.0 * order.stated);
}

/* Refuses a test that has too few good samples to be measured. */
static int check_samples(const struct recording_test *t, int legs, struct error *error) {
    const char *name = recording_test_name(t);
    int good = 0;
    if (t->first < 0 || !(t->sample[t->end - 1].test_time_s > t->sample[t->first].test_time_s))
        return error_set(error, STATUS_USAGE, "test %s: nothing in it is to be evaluated", name);
    for (int i = t->first; i < t->end; i++) good += !t->sample[i].refused;
    if (!has_lengths(t, legs))
        return error_set(error, STATUS_USAGE,
                         "test %s: no sample has the lengths of all legs: there is no motion to hold the forces against", name);
    if (2 * good < t->end - t->first)
        return error_set(error, STATUS_USAGE, "test %s: more than half of its samples are flagged, or have a value that is no number",
                         name);
    return STATUS_OK;
}

/* Checks one test by itself, and sets its frequency or, if it is no steady sinusoid, cuts it into
 * segments. k: NULL for a single axis. Returns the number of tests that take its place, or the
 * negative status. */
static int measure(struct recording *r, int test, const struct kinematics *k, struct error *error) {
    struct recording_test *t = &r->test[test];
    int legs = params_legs(r->params), tests = r->tests;
    bool any = false;
    int status = check_samples(t, legs, error);
    if (!status) status = channel_check(r, t, error);
    if (!status) status = check_frequency(t, legs, r->measured.reference, &any, error);
    if (status) return status;
    status = length_check(r->params, t, k, any, error);
    if (status) r->refuted = true;
    if (status || !any) return status ? status : 1;
    /* A test of one axis is not left out, because a matrix without it would be a different
     * result. */
    bool spare = !k || t->dof == DOF_NONE;
    status = motion_cut(r, test, error);
    int cut = r->tests - tests + 1;
    if (status != STATUS_USAGE || !spare || r->tests == recording_first_of_run(r) + 1) return status ? status : cut;
    r->exclusion = *error;
    r->excluded++;
    recording_remove(r, test);
    return cut - 1;
}

/* Refuses a recording whose lengths, forces and reference are not those of the configured
 * machine. */
static int check_contradictions(struct recording *r, const struct residual_data *data, const struct kinematics *k, struct error *error) {
    int status = k ? check_order(r, data, error) : STATUS_OK;
    if (!status) status = k ? reference_check(r, k, error) : force_check_axis(r, data, error);
    if (status == STATUS_USAGE) r->refuted = true;
    if (!status && r->measured.pressures) status = force_check_pressures(r, error);
    return status ? status : force_check_drives(r, data, error);
}

int recording_check(struct recording *r, struct error *error) {
    struct kinematics kinematics, *k = params_mechanism(r->params)->pose ? &kinematics : NULL;
    struct residual_data data = {0};
    int status = k ? kinematics_init(k, r->params, error) : STATUS_OK;
    if (status) return status;
    if (!r->tests) return error_set(error, STATUS_USAGE, "no sinusoidal test in the log");
    if (!r->measured.force)
        return error_set(error, STATUS_USAGE, "neither pressures nor forces in the log: there is nothing to hold against the motion");
    if (r->runs > 1 && memcmp(&r->measured, &r->measured_before, sizeof r->measured))
        return error_set(error, STATUS_USAGE, "it has not the same channels as the log before: pressures, valve commands or reference");
    r->refuted = false;
    recording_settle(r);
    int first = recording_first_of_run(r);
    for (int i = first, places; i < r->tests; i += places)
        if ((places = measure(r, i, k, error)) < 0) return places;
    status = motion_enough(r, error);
    if (status) return status;
    run_at(r, first);
    status = measured_make(r, first, error);
    if (!status) status = residual_prepare(&data, r, CYCLES_ALL, error);
    if (!status) status = check_contradictions(r, &data, k, error);
    residual_free(&data);
    return status;
}

int recording_check_noise(struct recording *r, struct error *error) {
    struct residual_data data;
    int status = residual_prepare(&data, r, CYCLES_ALL, error);
    if (!status) status = noise_check(r, &data, error);
    residual_free(&data);
    return status;
}
