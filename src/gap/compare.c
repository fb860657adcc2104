#include "compare.h"

#include <math.h>
#include <stdio.h>

#include "gap.h"
#include "memory.h"
#include "parallel.h"
#include "replay.h"
#include "tone.h"

static const double TONE_TOLERANCE = 0.1;   /* a tone in simulation counts as the measured tone if
                                             * their frequencies differ by less than this share; a
                                             * loop that oscillates in both does so at nearly the
                                             * same frequency */
static const double TONE_EXCITED = 0.5;     /* least power of a tone in simulation, as a share of
                                             * the power that a measured tone needs; below 1,
                                             * because another run may excite the same resonance
                                             * less */

int compare_check(const struct params *params, const struct recording *measured, struct error *error) {
    const struct recording_measured *m = &measured->measured;
    const char *refusal = params_mechanism(params)->refuses.replay;
    if (refusal) return error_set(error, STATUS_USAGE, "%s", refusal);
    for (int i = 0; i < measured->tests; i++)
        if (measured->test[i].segment_s > 0.0)
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
    bool can = !params_mechanism(r->params)->refuses.replay;
    for (int i = 0; i < r->tests; i++) {
        const struct recording_test *t = &r->test[i];
        can = can && t->dof != DOF_NONE && recording_find(r, t->run, t->dof) == t &&
              fabs(t->frequency_hz / r->run[t->run].hz[t->dof] - 1.0) < RECORDING_CLOCK_TOLERANCE;
    }
    return can;
}

static const struct params *after_of(const struct gap_result *r) { return r->effects ? &r->fitted : NULL; }

static void keep_sizes(struct gap_result *r, const struct replay_sizes *used, const struct replay_sizes *held) {
    r->before = used->before, r->after = used->after;
    r->noise_floor = held->noise;
    r->held_out_before = held->before, r->held_out_after = held->after;
    double noise = held->noise.overall * held->noise.overall, before = held->before.overall * held->before.overall;
    double after = held->after.overall * held->after.overall;
    r->unexplained_fraction = before > noise ? fmin(fmax((after - noise) / (before - noise), 0.0), 1.0) : 0.0;
    if (isnan(before + after + noise)) r->unexplained_fraction = (double)NAN;
}

/* Comparison of the models with recordings. used: cycles on which effects were searched. held: all
 * cycles of the validation log, which may contain other tests; without such a log, the held-out
 * cycles. */
struct comparison {
    const struct gap_result *r;
    struct side {
        const struct recording *measured;
        enum cycles which;
        const struct residual_data *data;
        const struct replay *both; /* the simulations; NULL: compare under the measured motion, by
                                    * `data` */
        struct replay_sizes sizes;
    } used, held;
};

static void compare_side(void *context, int i) {
    struct comparison *c = context;
    struct side *s = i ? &c->held : &c->used;
    s->sizes = s->both ? replay_compare(s->measured, s->both, s->which) : replay_motion(s->data, &c->r->base_model, after_of(c->r));
}

/* Simulates the models without and with the effects. If only the simulation with effects ends in a
 * fault, the fault is kept in the result, and the status is 0. */
static int run_both(struct gap_result *r, const struct recording *like, struct replay both[2], struct error *error) {
    replay_both(&r->base_model, after_of(r), like, both);
    const struct replay *failed = both[0].status ? &both[0] : &both[1];
    if (failed == &both[1] && failed->status == STATUS_USAGE && r->effects) {
        snprintf(r->replay_fault, sizeof r->replay_fault, "%.300s", failed->error.text);
        return STATUS_OK;
    }
    *error = failed->error;
    return failed->status;
}

static void read_runs(const struct params *params, const struct recording *measured, const struct replay both[2],
                      const struct gap_options *o, struct gap_result *r) {
    const struct recording *before = &both[0].run, *after = replay_after(both);
    r->simulated = true;
    r->tone_simulated = r->tone.hz > 0.0 && fabs(tone_find(after, o->threads, TONE_EXCITED).hz / r->tone.hz - 1.0) < TONE_TOLERANCE;
    r->matrices = replay_identify(params, measured, r->measured_mt) && replay_identify(params, before, r->before_mt) &&
                  replay_identify(params, after, r->after_mt);
}

/* Simulates the tests in closed loop. If the model with the effects ends in a fault, both models
 * are compared under the measured motion instead. */
static int closed_loop(const struct params *params, const struct recording *validate, const struct gap_options *o, struct comparison *c,
                       struct gap_result *r, struct replay runs[2], struct replay other[2], struct error *error) {
    gap_progress(o, "simulating", 0.7);
    int status = run_both(r, c->used.measured, runs, error);
    if (!status && validate && !r->replay_fault[0]) status = run_both(r, validate, other, error);
    if (status || r->replay_fault[0]) return status;
    c->used.both = runs, c->held.both = validate ? other : runs;
    read_runs(params, c->used.measured, runs, o, r);
    return STATUS_OK;
}

/* Prepares the validation log. If it cannot be evaluated, `data` stays empty. */
static void prepare_other(struct residual_data *data, const struct recording *validate) {
    struct error error;
    int status = residual_prepare(data, validate, CYCLES_ALL, &error);
    if (status == STATUS_IO) memory_end();
    if (status) residual_free(data);
}

int compare_models(const struct diagnosis *d, const struct recording *measured, const struct recording *validate,
                   const struct gap_options *o, struct gap_result *r, struct replay runs[2], struct error *error) {
    struct comparison c = {.r = r,
                           .used = {.measured = measured, .which = CYCLES_EVEN, .data = &d->even},
                           .held = {.measured = measured, .which = CYCLES_ODD, .data = &d->odd}};
    struct replay runs_other[2] = {{0}};
    struct residual_data data_other = {0};
    int status = STATUS_OK;
    bool drive = o->simulate && compare_can_be_driven(measured) && (!validate || compare_can_be_driven(validate));
    if (validate) c.held = (struct side){.measured = validate, .which = CYCLES_ALL, .data = &data_other};
    if (drive && r->replay == GAP_CLOSED_LOOP && !r->controller_differs)
        status = closed_loop(d->given, validate, o, &c, r, runs, runs_other, error);
    if (!status) {
        if (validate && !c.held.both) prepare_other(&data_other, validate);
        parallel_run(o->threads, 2, compare_side, &c);
        keep_sizes(r, &c.used.sizes, &c.held.sizes);
    }
    replay_free(runs_other);
    residual_free(&data_other);
    return status;
}
