#include "gap.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base.h"
#include "controller.h"
#include "diagnose.h"
#include "inverse_dynamics.h"
#include "judge.h"
#include "machine.h"
#include "places.h"
#include "replay.h"
#include "spectrum.h"

/* Set by machines with nothing hidden: of some forty effects tried the luckiest gains 5 to 10 on held-out cycles (make bench-gap). */
static const double GAIN_MIN = 36.0;       /* of white squares, on fitted and held-out cycles together: z = 6; */
static const double GAIN_EACH = 4.0;       /* and of either alone: chance repeats in neither */
static const double UNCLEAR_SHARE = 0.05;  /* of the first one's gain: a later effect that others come close to, with less, is none to be named */
static const double REMAINDER_SHARE = 0.2; /* of what is left above the noise: an effect that takes less is not what is there */
static const double RIVAL_GAIN = 16.0;     /* odds of 3000 to one, z = 4; or what its law may be off, */
static const double RIVAL_MOST = 0.1;      /* or what it leaves above the noise, but no more than that of its gain */
static const double CONTROLLER_DIFFERS = 0.02;
static const double LINE_TOLERANCE = 0.1;   /* a loop that oscillates in the model, too, does so near the same frequency */
static const double LINE_EXCITED = 0.5;     /* of the power: a resonance that other noise excites has some of it */
static const double LINE_POWER = 12.0;      /* of white noise, mean of six legs: 1 +- 0.4; */
static const double LINE_POWER_ONE = 30.0;  /* of one leg the strongest of 20 000 bins has 10 */
static const double CLOCK_TOLERANCE = 1e-4; /* two crystals */

enum { ROUNDS_MAX = 2 * GAP_EFFECTS }; /* effects that a later one makes leave may come again: not for ever */

const char *const gap_verdict_names[GAP_VERDICTS] = {"effect_named", "no_gap", "ambiguous", "unknown_effect"};
const char *const gap_channel_names[GAP_CHANNELS] = {"length", "force", "p1", "p2", "valve"};
const char *const gap_channel_units[GAP_CHANNELS] = {"m", "N", "Pa", "Pa", "-"};

static void progress(const struct gap_options *o, const char *step, double share) {
    if (o->progress) o->progress(o->context, step, share);
}

static double excess(double square, int values) { return fmax(square - values, 0.0); }

/* Square root of the likelihood's gain, on all cycles. */
static double likelihood(const struct diagnosis *d, const struct trial *t) { return sqrt(fmax(d->square - t->square + t->held_gain, 0.0)); }

/* Every effect once, in its best shape; trials are sorted. */
static void list_candidates(const struct diagnosis *d, const struct trial *trial, int trials, struct gap_result *r) {
    double least = d->held_out.evaluated; /* noise alone is not explained */
    for (int i = 0; i < trials; i++)
        if (trial[i].ok && trial[i].polished) least = fmin(least, trial[i].held_square);
    double before = d->held_square - least;
    bool gap = before > 0.5 * GAIN_MIN;
    for (int i = 0; i < trials; i++) {
        bool seen = !trial[i].ok;
        for (int j = 0; j < r->candidates && !seen; j++) seen = r->candidate[j].effect == trial[i].hypothesis->effect;
        if (seen || r->candidates == EFFECTS_MAX) continue;
        double share = gap ? 1.0 - (trial[i].held_square - least) / before : 0.0;
        r->candidate[r->candidates++] = (struct gap_candidate){.effect = trial[i].hypothesis->effect, .shape = trial[i].hypothesis->shape,
                                                               .gain = trial[i].gain, .z = likelihood(d, &trial[i]),
                                                               .share_explained = share};
    }
}

/* Sum of white squares, all cycles, by which a trial's law may be off. */
static double law_error(const struct trial *t) { return pow(effect_table[t->hypothesis->effect]->law_error, 2.0) * trial_evidence(t); }

/* As close to the best as the model can be wrong. */
static bool comes_close(const struct diagnosis *d, const struct trial *best, const struct trial *t) {
    double left = excess(best->square, d->fit.evaluated) + excess(best->held_square, d->held_out.evaluated), evidence = trial_evidence(best);
    double margin = fmax(fmax(RIVAL_GAIN, law_error(best)), fmin(left, RIVAL_MOST * evidence));
    return t->ok && t->polished && trial_evidence(t) >= evidence - margin;
}

/* Each leg its own value fits a little better always: a rival only where it judges better, too. */
static bool overfits(const struct trial *t, const struct trial *best) {
    return t->hypothesis->shape == SHAPE_EACH && best->hypothesis->shape != SHAPE_EACH && t->held_gain < best->held_gain;
}

/* A play of the command that its noise shakes through is none: what looks like it is that noise where the spool passes zero. */
static bool dithered(const struct diagnosis *d, const struct trial *t) {
    int effect = t->hypothesis->effect;
    double most = 0.0, square = 0.0;
    int legs = params_legs(d->given);
    if (!effect_table[effect]->command) return false;
    for (int k = 0; k < legs; k++) most = fmax(most, t->model.effects[effect].value[0][k]);
    for (int i = 0; i < d->even.tests; i++)
        for (int k = 0; k < legs; k++) square += pow(d->even.test[i].spectrum.noise[CHANNEL_VALVE][k], 2.0);
    return most < sqrt(square / (legs * d->even.tests));
}

static double dry_friction(const struct params *model, double speed_mps) {
    struct cylinder_model m;
    struct cylinder_state s = {.p1_pa = 0.5 * model->hydraulics.supply_pa, .p2_pa = 0.5 * model->hydraulics.supply_pa};
    double sum = 0.0;
    cylinder_model_init(&m, model);
    for (int k = 0; k < params_legs(model); k++) sum += cylinder_friction(&m, k, &s, 1, speed_mps).dry;
    return sum;
}

/* A friction most of which is gone where a leg surely slides is none that can be seen: a leg that may be held takes up what noise there is. */
static bool held_only(const struct diagnosis *d, const struct trial *t) {
    double sliding_mps = 2.0 * INVERSE_DYNAMICS_SLOW_MPS;
    if (!effect_table[t->hypothesis->effect]->leg_friction) return false;
    double held = dry_friction(&t->model, 0.0) - dry_friction(&d->model, 0.0);
    double slides = dry_friction(&t->model, sliding_mps) - dry_friction(&d->model, sliding_mps);
    return fabs(slides) < 0.5 * fabs(held);
}

/* What looks like it may be noise, however much of that it takes away. */
static bool noise_alone(const struct diagnosis *d, const struct trial *t) { return dithered(d, t) || held_only(d, t); }

static bool unseen(const struct diagnosis *d, const struct trial *t) { return t->bound || noise_alone(d, t); }

static int list_rivals(const struct diagnosis *d, const struct trial *trial, int trials, int rival[GAP_RIVALS]) {
    int rivals = 0, best = trial[0].hypothesis->effect;
    for (int i = 1; i < trials; i++) {
        if (!comes_close(d, &trial[0], &trial[i]) || noise_alone(d, &trial[i])) continue;
        int effect = trial[i].hypothesis->effect;
        bool seen = effect == best || hypothesis_contains(effect, best) || overfits(&trial[i], &trial[0]);
        for (int j = 0; j < rivals; j++) seen = seen || rival[j] == effect;
        if (!seen && rivals < GAP_RIVALS) rival[rivals++] = effect;
    }
    return rivals;
}

static void put_first(struct trial *trial, int place) {
    struct trial first = trial[place];
    memmove(trial + 1, trial, (size_t)place * sizeof *trial);
    trial[0] = first;
}

/* Is it a limit of the best one that explains as much: another effect, or all legs alike where each had its own value? A value for each leg
 * has to pay as an effect has to. */
static bool as_good(const struct diagnosis *d, const struct trial *best, const struct trial *t) {
    const struct hypothesis *h = t->hypothesis, *than = best->hypothesis;
    if (t->bound || !t->ok || !t->polished) return false;
    if (h->effect != than->effect) return hypothesis_contains(than->effect, h->effect) && comes_close(d, best, t);
    return h->shape == SHAPE_ALL && than->shape == SHAPE_EACH && trial_evidence(t) >= trial_evidence(best) - fmax(GAIN_MIN, law_error(best));
}

/* Where a limit of the best one explains as much, it is that. */
static void prefer_simple(const struct diagnosis *d, struct trial *trial, int trials) {
    for (int i = 1; i < trials; i++)
        if (as_good(d, &trial[0], &trial[i])) {
            put_first(trial, i);
            return;
        }
}

/* What is stuck at the end of its range, or noise, is not what is there: the best that is not comes first, the order of the others stays. */
static void prefer_seen(const struct diagnosis *d, struct trial *trial, int trials) {
    for (int i = 0; i < trials && trial[i].ok && trial[i].polished; i++) {
        if (unseen(d, &trial[i])) continue;
        put_first(trial, i);
        return;
    }
}

static bool worth_adding(const struct diagnosis *d, const struct trial *t, double laws) {
    double left = excess(d->held_square, d->held_out.evaluated);
    bool pays = t->gain > GAIN_EACH && t->held_gain > GAIN_EACH && trial_evidence(t) > GAIN_MIN;
    return t->ok && t->polished && !unseen(d, t) && pays && t->held_gain > laws && t->held_gain > REMAINDER_SHARE * left;
}

/* Takes an addition out where that costs no more than so much. */
static bool drop(struct diagnosis *d, int addition, double most, struct gap_result *r) {
    int effect = d->addition[addition].effect, place = 0;
    if (!diagnosis_drop(d, addition, most)) return false;
    while (r->effect[place].effect != effect) place++;
    memmove(r->effect + place, r->effect + place + 1, (size_t)(--r->effects - place) * sizeof *r->effect);
    return true;
}

/* Effects that a later one has made superfluous leave. */
static void drop_superfluous(struct diagnosis *d, struct gap_result *r) {
    for (int i = 0; i < d->added - 1;)
        if (!drop(d, i, 0.5 * GAIN_MIN, r)) i++;
}

enum doubt { NO_DOUBT, UNCLEAR, RECONSIDERED };

/* An effect that had rivals while a later one was still hidden leaves once, to be judged again beside that. */
static bool reconsider(struct diagnosis *d, enum doubt doubt[EFFECTS_MAX], struct gap_result *r) {
    for (int i = 0; i < d->added - 1; i++) {
        int effect = d->addition[i].effect;
        if (doubt[effect] != UNCLEAR || !drop(d, i, HUGE_VAL, r)) continue;
        doubt[effect] = RECONSIDERED;
        return true;
    }
    return false;
}

static int keys_of(const struct hypothesis *h) {
    int keys = 0;
    for (int i = 0; i < h->variables; i++) keys = h->variable[i].key < keys ? keys : h->variable[i].key + 1;
    return keys;
}

/* Of deviations, which say what noise leaves open: what leaves more than noise is no surer than what it leaves. */
static double left_over(const struct diagnosis *d) { return sqrt(fmax(d->held_square / d->held_out.evaluated, 1.0)); }

/* Values and deviations of the effects added, from the fitted variables. */
static void read_effects(const struct diagnosis *d, struct gap_result *r) {
    for (int i = 0; i < r->effects; i++)
        r->effect[i].values = d->model.effects[r->effect[i].effect];
    for (int j = 0; j < d->variables; j++)
        for (int i = 0; i < r->effects; i++) {
            const struct variable *v = &d->variable[j];
            if (v->effect != r->effect[i].effect) continue;
            double value = variable_get(v, &d->model);
            for (int leg = 0; leg < LEGS; leg++) {
                if (v->leg >= 0 && v->leg != leg) continue;
                if (v->base) { /* within its tolerance, and no finding */
                    r->effect[i].values.value[v->key][leg] = d->given->effects[v->effect].value[v->key][leg];
                    continue;
                }
                r->effect[i].std[v->key][leg] = left_over(d) * d->std[j];
                r->effect[i].bound[v->key][leg] = value == v->min || value == v->max;
            }
        }
}

static void describe(struct gap_effect *e, double z, double before, double after) {
    snprintf(e->evidence, sizeof e->evidence, "%s; sum of white squares on held-out data %.0f before, %.0f after",
             effect_table[e->effect]->signature, before, after);
    e->z = z;
}

/* The strongest line of all tests and channels, of so large a share of the power that makes a line. */
static struct gap_line find_line(const struct recording *recording, double share) {
    struct gap_line found = {0};
    static const struct {
        enum channel channel;
        enum gap_channel name;
    } channels[] = {{CHANNEL_P1, GAP_P1}, {CHANNEL_P2, GAP_P2}, {CHANNEL_LENGTH, GAP_LENGTH}};
    double most = share * (params_legs(recording->params) > 1 ? LINE_POWER : LINE_POWER_ONE);
    for (int i = 0; i < recording->tests; i++) {
        struct spectrum s;
        if (!spectrum_measure(&s, &recording->test[i], CYCLES_ALL)) continue;
        for (size_t j = 0; j < sizeof channels / sizeof *channels; j++) {
            struct spectrum_line line = spectrum_find_line(&s, &recording->test[i], channels[j].channel);
            if (!(line.power > most)) continue;
            most = line.power;
            found = (struct gap_line){line.hz, line.rms, channels[j].name, recording->test[i].dof, recording->test[i].test};
        }
    }
    return found;
}

/* Two clocks need no search: their ratio is seen. Crystals agree to CLOCK_TOLERANCE. */
static void find_skew(struct diagnosis *d, const struct recording *recording, struct gap_result *r) {
    int effect = effect_find("clock_skew");
    struct machine given;
    machine_init(&given, d->given);
    double std, ratio = recording_clock(recording, &std), off = fabs(ratio - given.timing.clock_ratio);
    if (!(off > CLOCK_TOLERANCE + 6.0 * std)) return;
    struct gap_effect *e = &r->effect[r->effects++];
    *e = (struct gap_effect){.effect = effect, .shape = SHAPE_ALL, .keys = 1, .given = d->given->effects[effect], .share_explained = 1.0,
                             .z = off / fmax(std, 1e-9)};
    effect_at(effect_table[effect], 0.0, &e->values);
    for (int leg = 0; leg < LEGS; leg++) e->values.value[0][leg] = ratio, e->std[0][leg] = std;
    d->model.effects[effect] = e->values;
    d->found[effect] = true;
    snprintf(e->evidence, sizeof e->evidence, "%s; stamps and test time drift apart by %.3g ms/s", effect_table[effect]->signature,
             1e3 * (ratio - 1.0));
}

/* The surest first. */
static int by_z(const void *a, const void *b) {
    const struct gap_effect *x = a, *y = b;
    return x->z < y->z ? 1 : x->z > y->z ? -1 : 0;
}

/* The one in doubt is the one added last. */
static void sort_effects(struct gap_result *r) {
    int doubted = r->effects ? r->effect[r->effects - 1].effect : 0;
    qsort(r->effect, (size_t)r->effects, sizeof *r->effect, by_z);
    for (int i = 0; i < r->effects; i++)
        if (r->effect[i].effect == doubted) r->in_doubt = i;
}

/* What each effect explains: the larger of what it did alone, in the first round, and of what was gone when it joined the others. */
static void share_out(const struct diagnosis *d, double first_held, struct gap_result *r) {
    double whole = first_held - d->held_square;
    for (int i = 0; i < r->effects; i++) {
        struct gap_effect *e = &r->effect[i];
        if (e->effect == effect_find("clock_skew")) continue; /* its share is known */
        double share = whole > 0.0 ? fmax(e->share_explained / whole, 0.0) : 0.0;
        for (int j = 0; j < r->candidates; j++)
            if (r->candidate[j].effect == e->effect && r->candidate[j].gain > 0.0) share = fmax(share, r->candidate[j].share_explained);
        e->share_explained = fmin(share, 1.0);
    }
}

static int search(struct diagnosis *d, const struct gap_options *o, struct gap_result *r, struct error *error) {
    struct trial *trial = calloc(HYPOTHESES_MAX, sizeof *trial);
    if (!trial) return error_set(error, STATUS_IO, "out of memory");
    enum doubt doubt[EFFECTS_MAX] = {NO_DOUBT};
    double first = 0.0, first_held = d->held_square;
    bool again = false; /* one is out, to be judged again */
    for (int round = 0; r->effects < GAP_EFFECTS && round < ROUNDS_MAX; round++) {
        progress(o, round ? "another effect" : "screening", 0.7 * round / ROUNDS_MAX);
        int trials = diagnosis_try(d, trial, o->threads);
        if (!trials) break;
        if (round == 0) list_candidates(d, trial, trials, r);
        prefer_seen(d, trial, trials);
        prefer_simple(d, trial, trials);
        int rival[GAP_RIVALS] = {0}, rivals = list_rivals(d, trial, trials, rival);
        int effect = trial[0].hypothesis->effect;
        /* What is a trace, and may be this or that, is not named. */
        bool trace = round && !again && rivals && trial[0].held_gain < UNCLEAR_SHARE * first;
        if (trace || !worth_adding(d, &trial[0], diagnosis_law_error(d))) {
            again = !r->ambiguous && round + 1 < ROUNDS_MAX && reconsider(d, doubt, r);
            if (again) continue;
            break;
        }
        again = false;
        if (round == 0) first = trial[0].held_gain;
        double before = d->held_square, z = likelihood(d, &trial[0]);
        struct gap_effect *e = &r->effect[r->effects];
        *e = (struct gap_effect){.effect = effect, .shape = trial[0].hypothesis->shape, .given = d->given->effects[effect],
                                 .keys = keys_of(trial[0].hypothesis)};
        if (!diagnosis_add(d, &trial[0])) break;
        r->effects++;
        memcpy(r->ambiguous_with, rival, sizeof rival);
        r->ambiguous = rivals;
        if (doubt[effect] != RECONSIDERED) doubt[effect] = rivals ? UNCLEAR : NO_DOUBT;
        e->share_explained = before - d->held_square;
        describe(e, z, before, d->held_square);
        drop_superfluous(d, r);
    }
    free(trial);
    if (r->effects) diagnosis_estimate(d);
    read_effects(d, r);
    share_out(d, first_held, r);
    sort_effects(r);
    return STATUS_OK;
}

static void read_base(const struct diagnosis *d, const struct params *given, struct gap_result *r) {
    for (int i = 0; i < d->variables && r->base_values < GAP_BASE; i++) {
        const struct variable *v = &d->variable[i];
        if (!v->base || v->effect >= 0) continue; /* joint positions and nulls: too many to read, none of them found */
        double value = variable_get(v, &d->model);
        r->base[r->base_values++] = (struct gap_base_value){.name = v->name, .leg = v->leg, .given = variable_get(v, given), .value = value,
                                                            .std = left_over(d) * d->std[i], .bound = value <= v->min || value >= v->max};
    }
}

/* The configuration given, with the effects found: the base's values stay as they were stated. */
static void extend(const struct params *given, const struct diagnosis *d, struct gap_result *r) {
    r->model = *given;
    r->fitted = r->effects ? d->model : r->base_model;
    for (int i = 0; i < r->effects; i++) r->model.effects[r->effect[i].effect] = r->effect[i].values;
}

/* What was tried is not what is there: nothing is added. */
static void give_up(const struct params *given, struct gap_result *r) {
    r->effects = r->ambiguous = 0;
    r->model = *given;
    r->fitted = r->base_model;
    r->after = r->before;
    r->held_out_after = r->held_out_before;
    r->unexplained_fraction = 1.0;
    r->white_after = r->white_before;
    memcpy(r->after_mt, r->before_mt, sizeof r->after_mt);
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

/* Both models run like a recording. The one with the effects found need not get through the tests that the rig got through. */
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

/* Judged on another log's own tests, which need not be those of the first; without one on the cycles held out. */
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
    r->line_simulated = r->line.hz > 0.0 && fabs(find_line(after, LINE_EXCITED).hz / r->line.hz - 1.0) < LINE_TOLERANCE;
    r->matrices = replay_identify(params, measured, r->measured_mt) && replay_identify(params, before, r->before_mt) &&
                  replay_identify(params, after, r->after_mt);
    return STATUS_OK;
}

static int closed_loop(const struct params *params, const struct recording *measured, const struct recording *validate,
                       const struct gap_options *o, struct gap_result *r, struct error *error) {
    struct replay both[2];
    progress(o, "simulating", 0.7);
    int status = run_both(r, measured, both, error);
    if (!status && !r->replay_fault[0]) status = compare_runs(params, measured, validate, both, r, error);
    replay_free(both);
    return status;
}

static double now_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* A closed loop needs what closed it. */
static int check_replay(const struct params *params, const struct recording *measured, const struct gap_options *o, struct error *error) {
    const struct recording_measured *m = &measured->measured;
    if (o->replay == GAP_MOTION) return STATUS_OK;
    if (params->mechanism == MECHANISM_AXIS)
        return error_set(error, STATUS_USAGE, "mechanism: axis: what drove it is not known, so it cannot be run again in closed loop; "
                                              "use --replay motion");
    for (int i = 0; i < measured->tests; i++)
        if (measured->test[i].piece_s > 0.0)
            return error_set(error, STATUS_USAGE, "a test of it is no steady sinusoid, so it cannot be run again in closed loop; use "
                                                  "--replay motion");
    if (m->reference && m->valve && m->pressures) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "the log has no %s of all legs, so the loop cannot be closed again; use --replay motion",
                     !m->reference ? "reference" : !m->valve ? "valve commands" : "pressures");
}

bool gap_given_alike(const struct gap_effect *effect, int key) {
    bool alike = true;
    for (int leg = 1; leg < LEGS; leg++) alike = alike && effect->given.value[key][leg] == effect->given.value[key][0];
    return alike;
}

double gap_deviation(const struct gap_effect *e, int key, int leg) {
    const struct effect_key *k = &effect_table[e->effect]->keys[key];
    bool shapes = k->reciprocal || k->typical == k->neutral; /* it is no strength that is 0 at its neutral value */
    double law = effect_table[e->effect]->law_error * (e->values.value[key][leg] - (shapes ? 0.0 : k->neutral));
    return e->std[key][leg] > 0.0 ? hypot(e->std[key][leg], law) : 0.0;
}

double gap_short(const struct gap_result *r, const struct gap_candidate *candidate) {
    double most = 0.0;
    for (int i = 0; i < r->candidates; i++) most = fmax(most, r->candidate[i].z);
    return sqrt(fmax(most * most - candidate->z * candidate->z, 0.0));
}

const char *gap_place_words(const struct gap_place *p, char words[GAP_WORDS]) {
    if (!(p->piece_s > 0.0))
        snprintf(words, GAP_WORDS, "test %s at %.3g Hz, %s of leg %d, harmonic %d", dof_names[p->dof], p->frequency_hz,
                 gap_channel_names[p->channel], p->leg + 1, p->harmonic);
    else
        snprintf(words, GAP_WORDS, "at %.4g s near %.2g Hz, %s of leg %d", p->at_s, p->frequency_hz, gap_channel_names[p->channel], p->leg + 1);
    return words;
}

/* Every test is one that its run's configuration asks for, and of its axis the only one, since it can state one amplitude: else no run of
 * the model is like it. */
static bool can_be_driven(const struct recording *r) {
    bool can = true;
    for (int i = 0; i < r->tests; i++) {
        const struct recording_test *t = &r->test[i];
        can = can && t->dof != DOF_NONE && recording_find(r, t->run, t->dof) == t &&
              fabs(t->frequency_hz / r->run[t->run].hz[t->dof] - 1.0) < CLOCK_TOLERANCE;
    }
    return can;
}

int gap_solve(const struct params *params, const struct recording *measured, const struct recording *validate,
              const struct gap_options *options, struct gap_result *r, struct error *error) {
    double start_s = now_s();
    struct remainder remainder = {0};
    int possible = check_replay(params, measured, options, error);
    if (possible) return possible;
    struct diagnosis *d = calloc(1, sizeof *d);
    if (!d) return error_set(error, STATUS_IO, "out of memory");
    *r = (struct gap_result){.replay = options->replay, .validated = validate != NULL};
    r->controller_difference = controller_difference(params, measured);
    r->sampled_s = controller_other_rate(params, measured);
    for (int i = measured->tests - 1; i >= 0; i--)
        if (!(measured->test[i].piece_s > 0.0) && measured->test[i].frequency_hz != measured->test[i].stated_hz)
            r->stated_hz = measured->test[i].stated_hz, r->moved_hz = measured->test[i].frequency_hz;
    r->controller_known = isfinite(r->controller_difference);
    r->controller_differs = r->controller_difference > CONTROLLER_DIFFERS;
    progress(options, "fitting the base", 0.0);
    int status = diagnosis_init(d, params, measured, error);
    if (!status) {
        remainder = (struct remainder){.values = d->held_out.evaluated, .before = excess(d->held_square, d->held_out.evaluated)};
        r->base_model = d->model;
        r->white_before = d->held_square / d->held_out.evaluated;
        r->places = places_find(d, measured, &d->model, r->where);
        find_skew(d, measured, r);
        r->line = find_line(measured, 1.0);
        status = search(d, options, r, error);
        r->white_after = d->held_square / d->held_out.evaluated;
        read_base(d, params, r);
        extend(params, d, r);
    }
    if (!status) {
        struct sizes used, held;
        motion_sizes(r, measured, CYCLES_EVEN, &used);
        motion_sizes(r, validate ? validate : measured, validate ? CYCLES_ALL : CYCLES_ODD, &held);
        keep_sizes(r, &used, &held);
        bool simulate = options->simulate && can_be_driven(measured) && (!validate || can_be_driven(validate));
        if (simulate && options->replay == GAP_CLOSED_LOOP && !r->controller_differs)
            status = closed_loop(params, measured, validate, options, r, error);
    }
    if (!status) {
        remainder.after = d->held_square, remainder.law_error = diagnosis_law_error(d);
        judge(r, &remainder);
        if (r->verdict == GAP_UNKNOWN_EFFECT) give_up(params, r);
    }
    bool friction = false;
    for (int i = 0; i < r->effects && !status && params->mechanism == MECHANISM_STEWART; i++) {
        const struct effect *e = effect_table[r->effect[i].effect];
        friction = friction || e->leg_friction || e->joint_friction;
    }
    if (friction && can_be_driven(measured)) r->repaired = replay_repair(params, &r->fitted, measured, r->repaired_mt);
    diagnosis_free(d);
    free(d);
    r->seconds = now_s() - start_s;
    progress(options, "done", 1.0);
    return status;
}
