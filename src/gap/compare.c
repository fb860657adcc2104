#include "compare.h"

#include <math.h>
#include <stdio.h>

#include "line.h"
#include "replay.h"

static const double LINE_TOLERANCE = 0.1;   /* a loop that oscillates in the model, too, does so
                                             * near the same frequency */
static const double LINE_EXCITED = 0.5;     /* of the power: a resonance that other noise
                                             * excites has some of it */

/* A closed loop needs what closed it. */
int compare_check(const struct params *params, const struct recording *measured, struct error *error) {
    const struct recording_measured *m = &measured->measured;
    if (params->mechanism == MECHANISM_AXIS)
        return error_set(error, STATUS_USAGE,
                         "mechanism: axis: what drove it is not known, so it cannot be run again in closed loop; "
                         "use --replay motion");
    for (int i = 0; i < measured->tests; i++)
        if (measured->test[i].piece_s > 0.0)
            return error_set(error, STATUS_USAGE,
                             "a test of it is no steady sinusoid, so it cannot be run again in closed loop; use "
                             "--replay motion");
    if (m->reference && m->valve && m->pressures) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "the log has no %s of all legs, so the loop cannot be closed again; use --replay motion",
                     !m->reference ? "reference"
                     : !m->valve   ? "valve commands"
                                   : "pressures");
}

bool compare_can_be_driven(const struct recording *r) {
    bool can = true;
    for (int i = 0; i < r->tests; i++) {
        const struct recording_test *t = &r->test[i];
        can = can && t->dof != DOF_NONE && recording_find(r, t->run, t->dof) == t &&
              fabs(t->frequency_hz / r->run[t->run].hz[t->dof] - 1.0) < RECORDING_CLOCK_TOLERANCE;
    }
    return can;
}

struct sizes {
    struct gap_size before, after, floor;
};

static void motion_sizes(const struct gap_result *r, const struct recording *measured, enum cycles which, struct sizes *s) {
    replay_motion(&r->base_model, measured, which, &s->before, &s->floor);
    replay_motion(&r->fitted, measured, which, &s->after, &s->floor);
}

static void keep_sizes(struct gap_result *r, const struct sizes *used, const struct sizes *held) {
    r->before = used->before, r->after = used->after;
    r->noise_floor = held->floor;
    r->held_out_before = held->before, r->held_out_after = held->after;
    double floor = held->floor.overall * held->floor.overall, before = held->before.overall * held->before.overall;
    double after = held->after.overall * held->after.overall;
    r->unexplained_fraction = before > floor ? fmin(fmax((after - floor) / (before - floor), 0.0), 1.0) : 0.0;
    if (isnan(before + after + floor)) r->unexplained_fraction = (double)NAN;
}

/* Both models run like a recording. The one with the effects found need not get through the tests
 * that the rig got through. */
static int run_both(struct gap_result *r, const struct recording *like, struct replay both[2], struct error *error) {
    replay_both(&r->base_model, r->effects ? &r->fitted : NULL, like, both);
    const struct replay *failed = both[0].status ? &both[0] : &both[1];
    if (failed == &both[1] && failed->status == STATUS_USAGE && r->effects) {
        snprintf(r->replay_fault, sizeof r->replay_fault, "%.300s", failed->error.text);
        return STATUS_OK;
    }
    *error = failed->error;
    return failed->status;
}

/* Judged on another log's own tests, which need not be those of the first; without one on the
 * cycles held out. */
static int held_sizes(const struct recording *measured, const struct recording *validate, const struct replay *both, struct gap_result *r,
                      struct sizes *held, struct error *error) {
    const struct recording *with = validate ? validate : measured;
    enum cycles which = validate ? CYCLES_ALL : CYCLES_ODD;
    struct replay other[2];
    int status = validate ? run_both(r, validate, other, error) : STATUS_OK;
    if (validate) both = other;
    if (!status && !r->replay_fault[0]) {
        replay_compare(with, &both[0].run, which, &held->before, &held->floor);
        replay_compare(with, replay_after(both), which, &held->after, &held->floor);
    }
    if (validate) replay_free(other);
    return status;
}

static int compare_runs(const struct params *params, const struct recording *measured, const struct recording *validate,
                        const struct replay both[2], struct gap_result *r, struct error *error) {
    const struct recording *before = &both[0].run, *after = replay_after(both);
    struct sizes used, held = {0};
    int status = held_sizes(measured, validate, both, r, &held, error);
    if (status || r->replay_fault[0]) return status;
    replay_compare(measured, before, CYCLES_EVEN, &used.before, &used.floor);
    replay_compare(measured, after, CYCLES_EVEN, &used.after, &used.floor);
    keep_sizes(r, &used, &held);
    r->simulated = true;
    r->line_simulated = r->line.hz > 0.0 && fabs(line_find(after, LINE_EXCITED).hz / r->line.hz - 1.0) < LINE_TOLERANCE;
    r->matrices = replay_identify(params, measured, r->measured_mt) && replay_identify(params, before, r->before_mt) &&
                  replay_identify(params, after, r->after_mt);
    return STATUS_OK;
}

static int closed_loop(const struct params *params, const struct recording *measured, const struct recording *validate,
                       const struct gap_options *o, struct gap_result *r, struct replay runs[2], struct error *error) {
    gap_progress(o, "simulating", 0.7);
    int status = run_both(r, measured, runs, error);
    if (!status && !r->replay_fault[0]) status = compare_runs(params, measured, validate, runs, r, error);
    return status;
}

int compare_models(const struct params *params, const struct recording *measured, const struct recording *validate,
                   const struct gap_options *o, struct gap_result *r, struct replay runs[2], struct error *error) {
    struct sizes used, held;
    motion_sizes(r, measured, CYCLES_EVEN, &used);
    motion_sizes(r, validate ? validate : measured, validate ? CYCLES_ALL : CYCLES_ODD, &held);
    keep_sizes(r, &used, &held);
    bool drive = o->simulate && compare_can_be_driven(measured) && (!validate || compare_can_be_driven(validate));
    if (!drive || r->replay != GAP_CLOSED_LOOP || r->controller_differs) return STATUS_OK;
    return closed_loop(params, measured, validate, o, r, runs, error);
}
