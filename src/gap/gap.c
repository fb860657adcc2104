#include "gap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "compare.h"
#include "controller.h"
#include "course.h"
#include "goodness.h"
#include "judge.h"
#include "memory.h"
#include "monotonic.h"
#include "places.h"
#include "replay.h"
#include "search.h"
#include "statements.h"
#include "tone.h"
#include "waves.h"

static const double CONTROLLER_DIFFERS = 0.02; /* a larger controller_difference() means that
                                                * another controller drove */
static const double Z_NAMED = 6.0; /* least z of each effect for which sets of effects may change
                                    * the verdict to effect_named */

/* Fills r->model with the given configuration and the found effects, and r->fitted with the base as
 * fitted. */
static void extend(const struct params *given, const struct diagnosis *d, struct gap_result *r) {
    r->model = *given;
    r->fitted = r->effects ? d->model : r->base_model;
    for (int i = 0; i < r->effects; i++) {
        const struct effect *e = effect_table[r->effect[i].effect];
        struct effect_values *values = &r->model.effects[r->effect[i].effect];
        *values = r->effect[i].values;
        /* if the strength is zero, the parameters of the law's form get their neutral values,
         * too */
        if (!effect_acts(e, values)) effect_at(e, 0.0, values);
    }
}

/* Removes the effects from the result, because no effect of the catalogue explains the gap. The
 * result's models and sizes become those without effects. */
static void give_up(const struct params *given, struct gap_result *r) {
    r->effects = r->ambiguous = r->in_doubt = 0;
    r->ambiguous_together = false;
    r->course = (struct gap_course){0};
    r->certainty = (struct gap_certainty){.probability = (double)NAN};
    r->model = *given;
    r->fitted = r->base_model;
    r->after = r->before;
    r->held_out_after = r->held_out_before;
    r->unexplained_fraction = 1.0;
    r->white_after = r->white_before;
    memcpy(r->after_mt, r->before_mt, sizeof r->after_mt);
}

void gap_progress(const struct gap_options *o, const char *step, double share) {
    if (o->progress) o->progress(o->context, step, share);
}

/* Fills `white_after` of the result, and the remainder, from the residuals that the diagnosis
 * leaves on the held-out cycles. */
static void read_remainder(const struct diagnosis *d, struct gap_result *r, struct remainder *m) {
    r->white_after = d->held_square / d->held_out.evaluated;
    m->after = d->held_square, m->beyond_laws = goodness_beyond_laws(d), m->noise = goodness_noise(d);
}

/* True if all effects of the second result are among those of the first. */
static bool includes(const struct gap_result *a, const struct gap_result *b) {
    int common = 0;
    for (int i = 0; i < a->effects; i++)
        for (int j = 0; j < b->effects; j++) common += a->effect[i].effect == b->effect[j].effect;
    return common == b->effects;
}

/* True if a single effect leaves more than noise and more than the error of its law. */
static bool leaves_more(const struct gap_result *r) {
    double law = effect_table[r->effect[0].effect]->law_error;
    return r->white_after > LEFT_WHITE && r->unexplained_fraction > law * law;
}

/* True if the search may have gone astray, because it adds one effect at a time. This is so if its
 * verdict is unknown_effect. With one leg it is also so if the search found several effects, a
 * value at its bound, or a single effect that leaves a remainder: one leg has too few equations to
 * show the mistake otherwise. */
static bool doubtful(const struct gap_result *r) {
    bool doubt = r->effects > 1 || (r->effects == 1 && leaves_more(r));
    for (int i = 0; i < r->effects; i++)
        for (int key = 0; key < r->effect[i].keys; key++) doubt = doubt || r->effect[i].bound[key][0];
    return r->verdict == GAP_UNKNOWN_EFFECT || (doubt && params_legs(&r->model) == 1);
}

static double least_z(const struct gap_result *r) {
    double least = HUGE_VAL;
    for (int i = 0; i < r->effects; i++) least = fmin(least, r->effect[i].z);
    return least;
}

/* True if the result of the sets replaces that of the search. If the sets only add effects, they
 * must leave a smaller residual, and each effect needs a z of at least Z_NAMED. If they add no
 * effect, their result must be ambiguous, and both results must leave no more than noise. If each
 * result has effects that the other lacks, both must leave no more than noise, so that evidence
 * decides. */
static bool differs(const struct gap_result *search, const struct gap_result *sets) {
    bool noise = search->white_after < LEFT_WHITE && sets->white_after < LEFT_WHITE;
    if (includes(search, sets)) return sets->ambiguous && noise;
    if (includes(sets, search)) return sets->white_after < search->white_after && least_z(sets) >= Z_NAMED;
    return noise;
}

/* True if the result of the sets replaces an unknown effect. With one leg this is always so. With
 * six legs it is so in two cases. Either the sets leave more than noise and errors of the laws
 * explain, so that judge() cannot name their effects but judge_partly() may. Or they have fewer
 * effects than the search found, all with empirical laws. */
static bool instead_of_unknown(const struct gap_result *search, const struct gap_result *sets, const struct remainder *m) {
    bool fewer = sets->effects < search->effects && statements_empirical(sets);
    return params_legs(&search->model) == 1 || m->beyond_laws > 1.0 || fewer;
}

/* A recording that is judged: its diagnosis, the remainder that the result's effects leave, and the
 * simulations with these effects. */
struct inquiry {
    struct diagnosis *d;
    struct remainder remainder;
    const struct recording *measured, *validate;
    const struct gap_options *options;
    struct replay runs[2];
    struct tried *tried;
};

/* Copies a result, to be filled with other effects. Fields that are set anew only if a simulation
 * succeeds or a verdict needs them are cleared. */
static struct gap_result *copy_for_others(const struct gap_result *r) {
    struct gap_result *other = memory_get(1, sizeof *other);
    *other = *r;
    other->simulated = other->tone_simulated = other->matrices = other->offset_rival = false;
    other->replay_fault[0] = '\0';
    return other;
}

/* Compares the models and judges again, with the effects of `other`, which the diagnosis already
 * has. If these effects are named, at least partly, *other replaces *r, and *named becomes true. */
static int judge_again(struct inquiry *q, struct gap_result *other, struct gap_result *r, bool *named, struct error *error) {
    struct replay runs[2] = {{0}};
    struct remainder remainder = q->remainder;
    read_remainder(q->d, other, &remainder);
    other->course = course_find(q->d, q->measured);
    search_read_base(q->d, other);
    extend(q->d->given, q->d, other);
    int status = compare_models(q->d, q->measured, q->validate, q->options, other, runs, error);
    if (!status) judge(other, &remainder);
    bool strict = other->verdict != GAP_UNKNOWN_EFFECT && (other->ambiguous || least_z(other) >= Z_NAMED);
    *named = !status && (strict || judge_partly(other));
    replay_free(*named ? q->runs : runs);
    if (!*named) return status;
    memcpy(q->runs, runs, sizeof runs);
    q->remainder = remainder;
    *r = *other;
    return STATUS_OK;
}

/* Compares sets of effects under a remainder, and judges again if their result differs from that of
 * the search. */
static int review(struct inquiry *q, struct gap_result *r, struct error *error) {
    struct gap_result *other = copy_for_others(r);
    int status = STATUS_OK;
    gap_progress(q->options, "comparing sets of effects", 0.9);
    bool sure = statements_find(q->d, other), unknown = r->verdict == GAP_UNKNOWN_EFFECT, changes = false;
    if (sure) {
        struct remainder remainder = q->remainder;
        read_remainder(q->d, other, &remainder);
        changes = unknown ? instead_of_unknown(r, other, &remainder) : differs(r, other);
    }
    if (unknown) {
        r->statements = other->statements;
        memcpy(r->statement, other->statement, sizeof r->statement);
    }
    if (changes) status = judge_again(q, other, r, &changes, error);
    free(other);
    return status;
}

/* Changes the certainty from that of the simpler effects, which were not named, to that of the
 * search's result, which the simpler effects contradict. */
static void contradict(const struct gap_result *simpler, struct gap_certainty *c) {
    c->other_probability = c->probability, c->probability = 1.0 - c->probability;
    c->others = simpler->effects < GAP_EFFECTS ? simpler->effects : GAP_EFFECTS;
    for (int i = 0; i < c->others; i++) c->other[i] = simpler->effect[i].effect;
}

/* Finds the certainty of the search's result. If limiting cases of its effects explain about as
 * much, or fewer of the effects are likelier, these become the result. */
static int weigh(struct inquiry *q, struct gap_result *r, struct error *error) {
    struct gap_result *other = copy_for_others(r);
    struct gap_certainty certainty;
    int status = STATUS_OK;
    bool simpler = statements_weigh(q->d, other, &q->tried->found, q->tried->sets, q->tried->set, &certainty), named = true;
    if (simpler) status = judge_again(q, other, r, &named, error);
    if (!named) contradict(other, &certainty);
    if (!status) judge_certainty(r, &q->remainder, &certainty);
    free(other);
    return status;
}

/* True if all tests of both recordings are steady sinusoids, and if each axis that both recordings
 * move has the same frequency in both, within a tenth. */
static bool one_frequency(const struct recording *a, const struct recording *b) {
    for (int i = 0; i < a->tests; i++)
        for (int j = 0; j < b->tests; j++) {
            const struct recording_test *t = &a->test[i], *u = &b->test[j];
            bool sinusoids = !(t->segment_s > 0.0) && !(u->segment_s > 0.0);
            if (!sinusoids || (t->dof == u->dof && !(fabs(t->frequency_hz - u->frequency_hz) <= 0.1 * u->frequency_hz))) return false;
        }
    return true;
}

/* Returns the lowest frequency of the measured tests if each axis has one frequency, the same in
 * the validation log; otherwise 0. */
static double one_hz(const struct recording *measured, const struct recording *validate) {
    double lowest = HUGE_VAL;
    if (!one_frequency(measured, measured) || (validate && !one_frequency(measured, validate))) return 0.0;
    for (int i = 0; i < measured->tests; i++) lowest = fmin(lowest, measured->test[i].frequency_hz);
    return lowest;
}

int gap_solve(const struct params *params, const struct recording *measured, const struct recording *validate,
              const struct gap_options *options, struct gap_result *r, struct waves *waves, struct error *error) {
    int64_t start_ns = monotonic_ns();
    int open_loop = compare_check(params, measured, error);
    if (open_loop && options->replay == GAP_CLOSED_LOOP) return open_loop;
    struct diagnosis *d = memory_get(1, sizeof *d);
    struct inquiry q = {.d = d, .measured = measured, .validate = validate, .options = options, .tried = memory_get(1, sizeof *q.tried)};

    bool motion = open_loop || options->replay == GAP_MOTION;
    *r = (struct gap_result){
        .replay = motion ? GAP_MOTION : GAP_CLOSED_LOOP, .validated = validate != NULL, .certainty.probability = (double)NAN};
    r->controller_difference = controller_difference(params, measured);
    r->sampled_s = controller_other_rate(params, measured);
    for (int i = measured->tests - 1; i >= 0; i--)
        if (!(measured->test[i].segment_s > 0.0) && measured->test[i].frequency_hz != measured->test[i].stated_hz)
            r->stated_hz = measured->test[i].stated_hz, r->moved_hz = measured->test[i].frequency_hz;
    r->one_hz = one_hz(measured, validate);
    r->controller_known = isfinite(r->controller_difference);
    r->controller_differs = r->controller_difference > CONTROLLER_DIFFERS;

    gap_progress(options, "fitting the base", 0.0);
    int status = diagnosis_init(d, params, measured, options->threads, error);
    if (!status) {
        q.remainder = (struct remainder){.values = d->held_out.evaluated, .before = fmax(d->held_square - d->held_out.evaluated, 0.0)};
        r->base_model = d->model;
        r->white_before = d->held_square / d->held_out.evaluated;
        r->places = places_find(d, measured, &d->model, r->where);
        r->tone = tone_find(measured, options->threads, 1.0);
        search_effects(d, measured, options, r, q.tried);
        r->white_after = d->held_square / d->held_out.evaluated;
        extend(params, d, r);
    }

    if (!status) status = compare_models(d, measured, validate, options, r, q.runs, error);
    if (!status) {
        read_remainder(d, r, &q.remainder);
        r->course = course_find(d, measured);
        judge(r, &q.remainder);
        if (doubtful(r)) status = review(&q, r, error);
        if (r->verdict == GAP_UNKNOWN_EFFECT) give_up(params, r);
        if (!status && r->verdict != GAP_UNKNOWN_EFFECT && isnan(r->certainty.probability)) {
            status = weigh(&q, r, error);
            if (r->verdict == GAP_UNKNOWN_EFFECT) give_up(params, r);
        }
        if (waves && r->simulated) waves_closed_loop(waves, measured, &q.runs[0].run, r->effects ? replay_after(q.runs) : &q.runs[0].run);
    }
    replay_free(q.runs);

    bool friction = false;
    for (int i = 0; i < r->effects && !status; i++) {
        const struct effect *e = effect_table[r->effect[i].effect];
        friction = friction || e->leg_friction || e->joint_friction;
    }
    if (friction && compare_can_be_driven(measured)) r->repaired = replay_repair(params, &r->fitted, measured, r->repaired_mt);

    diagnosis_free(d);
    free(d);
    free(q.tried);
    r->seconds = seconds_from_ns(monotonic_ns() - start_ns);
    if (status) gap_progress(options, "not solved", 1.0);
    return status;
}
