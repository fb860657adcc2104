#include "admit.h"

#include <string.h>

#include "channel_check.h"
#include "force_check.h"
#include "kinematics.h"
#include "leg_order.h"
#include "length_check.h"
#include "motion.h"
#include "noise_check.h"
#include "params.h"
#include "reference_check.h"
#include "residual.h"

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
static int check_samples(const struct recording_test *t, const struct measured_record *record, struct error *error) {
    const char *name = recording_test_name(t);
    if (!record->lasts) return error_set(error, STATUS_USAGE, "test %s: nothing in it is to be evaluated", name);
    if (!record->lengths)
        return error_set(error, STATUS_USAGE,
                         "test %s: no sample has the lengths of all legs: there is no motion to hold the forces against", name);
    if (2 * record->good < t->end - t->first)
        return error_set(error, STATUS_USAGE, "test %s: more than half of its samples are flagged, or have a value that is no number",
                         name);
    return STATUS_OK;
}

static int check_cycles(const struct recording_test *t, const struct measured_record *record, struct error *error) {
    double span_s = t->sample[t->end - 1].test_time_s - t->sample[t->first].test_time_s;
    if (!record->sinusoid || !(span_s * record->frequency_hz < RECORDING_CYCLES - 0.1)) return STATUS_OK;
    return error_set(error, STATUS_USAGE,
                     "test %s: %.3g s evaluated, too short: at least %d cycles of %g Hz are needed; in a run, raise tests.duration_s",
                     recording_test_name(t), span_s, RECORDING_CYCLES, record->frequency_hz);
}

static int too_short(double span_s, double segment_s, int kept, struct error *error) {
    return error_set(error, STATUS_USAGE,
                     "%.3g s of motion that is no steady sinusoid, too short: it takes %d pieces of %.3g s without "
                     "gaps in which something moves, and there are %d",
                     span_s, SEGMENTS_NEEDED, segment_s, kept);
}

/* Refuses a record that is no steady sinusoid and has no segments. */
static int check_segments(const struct motion_cut *cut, struct error *error) {
    switch (cut->lacks) {
    case CUT_NOTHING: return STATUS_OK;
    case CUT_TIME:
        return error_set(error, STATUS_USAGE, "%.3g s of motion that is no steady sinusoid, too short to see how it moves", cut->span_s);
    case CUT_MOTION: return error_set(error, STATUS_USAGE, "%.3g s in which nothing is seen to move", cut->span_s);
    case CUT_ROOM:
        return error_set(error, STATUS_USAGE, "too many recordings at once: there is room for %d tests and pieces of any motion",
                         RECORDING_TESTS);
    case CUT_TURNS:
        return error_set(error, STATUS_USAGE,
                         "samples are missing where the motion turns sharply, in %d of %d pieces of %.3g s, and what they would show is "
                         "not known: keep every row, the reversals', too",
                         cut->turns, cut->all, cut->segment_s);
    case CUT_SEGMENTS: break;
    }
    return too_short(cut->span_s, cut->segment_s, 0, error);
}

/* Checks one test of the raw recording by itself. k: NULL for a single axis. A record that has no
 * segments is left out, and not refused, if the run has other records. */
static int check_test(const struct recording *raw, const struct measured_recording *m, int test, const struct kinematics *k,
                      struct admission *a, struct error *error) {
    const struct recording_test *t = &raw->test[test];
    const struct measured_record *record = &m->record[test];
    int status = check_samples(t, record, error);
    if (!status) status = channel_check(raw, t, error);
    if (!status) status = check_cycles(t, record, error);
    if (status) return status;
    status = length_check(raw->params, t, k, !record->sinusoid, error);
    if (status) a->refuted = true;
    if (!status) status = check_segments(&record->cut, error);
    /* A test of one axis is not left out, because a matrix without it would be a different
     * result. */
    bool spare = !k || t->dof == DOF_NONE, others = test + 1 < raw->tests || m->recording.tests > m->first;
    if (!status || a->refuted || !spare || !others) return status;
    a->exclusion = *error;
    a->excluded++;
    return STATUS_OK;
}

/* Refuses a recording that has no steady sinusoid and, in all its records together, too few
 * segments to fit and judge a model. */
static int check_enough(const struct recording *r, struct error *error) {
    double span_s = 0.0, segment_s = 0.0;
    int pieces = 0, steady = 0;
    for (int i = 0; i < r->tests; i++) {
        const struct recording_test *t = &r->test[i];
        if (!(t->segment_s > 0.0)) steady++;
        else pieces++, segment_s = t->segment_s;
        if (t->segment_s > 0.0 && recording_begins(r, i)) span_s += t->sample[t->count - 1].test_time_s - t->sample[0].test_time_s;
    }
    return steady || pieces >= SEGMENTS_NEEDED ? STATUS_OK : too_short(span_s, segment_s, pieces, error);
}

/* Refuses a recording whose lengths, forces or reference contradict the configured machine. */
static int check_contradictions(const struct recording *r, const struct kinematics *k, struct admission *a, struct error *error) {
    struct residual_data data;
    int status = residual_prepare(&data, r, CYCLES_ALL, error);
    if (!status) {
        status = k ? check_order(r, &data, error) : STATUS_OK;
        if (!status) status = k ? reference_check(r, k, error) : force_check_axis(r, &data, error);
        if (status == STATUS_USAGE) a->refuted = true;
        if (!status && r->measured.pressures) status = force_check_pressures(r, error);
        if (!status) status = force_check_drives(r, &data, error);
    }
    residual_free(&data);
    return status;
}

int admit(const struct recording *raw, const struct measured_recording *m, struct admission *a, struct error *error) {
    struct kinematics kinematics, *k = params_mechanism(raw->params)->pose ? &kinematics : NULL;
    int status = k ? kinematics_init(k, raw->params, error) : STATUS_OK;
    if (status) return status;
    if (!raw->tests) return error_set(error, STATUS_USAGE, "no sinusoidal test in the log");
    if (!raw->measured.force)
        return error_set(error, STATUS_USAGE, "neither pressures nor forces in the log: there is nothing to hold against the motion");
    if (raw->runs > 1 && memcmp(&raw->measured, &raw->measured_before, sizeof raw->measured))
        return error_set(error, STATUS_USAGE, "it has not the same channels as the log before: pressures, valve commands or reference");
    a->refuted = false;
    for (int i = recording_first_of_run(raw); i < raw->tests && !status; i++) status = check_test(raw, m, i, k, a, error);
    if (!status) status = check_enough(&m->recording, error);
    return status ? status : check_contradictions(&m->recording, k, a, error);
}

int admit_noise(const struct measured_recording *m, struct error *error) {
    if (!(m->noise > NOISE_MOST)) return STATUS_OK;
    return error_set(
        error, STATUS_USAGE,
        "noise is %.0f %% of what varies in the %s that are evaluated, and above %.0f %% nothing can be said of them: larger or "
        "faster motion, or finer sensors",
        100.0 * m->noise, m->recording.measured.pressures ? "pressures and forces" : "forces", 100.0 * NOISE_MOST);
}
