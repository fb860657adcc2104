#include "judge.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base.h"
#include "experiment.h"
#include "numeric.h"

static const double OFFSET_SIGMAS = 6.0, /* least size of a constant force, or of a difference of
                                          * friction between directions, that counts, in standard
                                          * deviations */
    OFFSET_SHARE = 0.05;                 /* least difference of friction between directions that
                                          * counts, as a share of the sum of both */
static const double SHARE_MAX = 0.3;      /* largest share of the squared gap that a simulation with
                                           * the effects may leave; a larger share refutes the
                                           * effects if the remaining gap also exceeds VISIBLE */
static const double FLOORS_MAX = 2.0;      /* a remaining gap, in simulation or under the measured
                                            * motion, refutes the result if it exceeds this
                                            * multiple of the noise floor, LEFT_MAX and
                                            * LEFT_SHARE, all three */
static const double LEFT_MAX = 0.02;   /* a remaining gap refutes only if it exceeds this share of
                                        * the measured variation; this limit decides where there is
                                        * hardly any noise */
static const double LEFT_SHARE = 0.1;      /* a remaining gap refutes only above this share of the
                                            * squared gap; less may be an error of the model */
static const double PARTLY_LEFT = 0.5;     /* largest share of the squared gap that partly_named may
                                            * leave on held-out data */
static const double VISIBLE = 0.2;         /* a squared gap is seen if it exceeds the squared noise
                                            * floor by more than this share of the floor; a
                                            * simulation with another start and other steps leaves
                                            * 0.06 */
static const double TONE_SHARE = 0.5;      /* a tone is negligible if its rms is less than this
                                            * share of the rms gap in its channel: through nonlinear
                                            * laws a tone changes the harmonics by less than its own
                                            * size */
static const double TRACE_SHARE = 5e-3;    /* a remainder below this share of the excess over noise
                                            * is a trace; a single effect that explains all but a
                                            * trace is real */
static const double THIRD_SHARE = 0.05;    /* three effects imitate something else if the third
                                            * one explains more than this share of the excess
                                            * over noise */

extern const struct effect clock_skew, cylinder_coulomb_friction, cylinder_dahl_friction, external_stiffness;

#define SAY(r, ...) snprintf((r)->reason, sizeof (r)->reason, __VA_ARGS__)
#define ADVISE(r, ...) snprintf((r)->next_experiment, sizeof (r)->next_experiment, __VA_ARGS__)

static const char tone_words[] = "mains, a pump, a part on springs that rings, or a loop that oscillates by itself";

static const char *name_of(int effect) { return effect_table[effect]->name; }

static void append(struct gap_result *r, const char *text) {
    size_t used = strlen(r->reason);
    snprintf(r->reason + used, sizeof r->reason - used, "%s", text);
}

static void append_names(struct gap_result *r, int effects, const int effect[]) {
    for (int i = 0; i < effects; i++) {
        append(r, i == 0 ? "" : i + 1 == effects ? " and " : ", ");
        append(r, name_of(effect[i]));
    }
    if (!effects) append(r, "no effect");
}

/* Share of the excess over noise that remains with the effects. */
static double trace(const struct remainder *m) { return m->before > 0.0 ? fmax(m->after - m->noise, 0.0) / m->before : 1.0; }

/* True if more remains than noise and errors of the laws explain. After a single effect a trace of
 * the excess does not count. After two effects it does, because two wrong effects may imitate the
 * true one up to a trace. */
static bool remains(const struct gap_result *r, const struct remainder *m) {
    return m->beyond_laws > 1.0 && !(r->effects == 1 && trace(m) < TRACE_SHARE);
}

/* Squared size that is judged. With simulated effects it is that of the varying part, because
 * constants differ from run to run: a leg in a dead band stays where it stopped, and a chamber
 * whose valve stays shut keeps its oil. Under the measured motion constants count as well, because
 * the motion is the same. */
static double counts(const struct gap_result *r, const struct gap_size *size) {
    return square(r->simulated && r->effects ? size->varying : size->overall);
}

/* Share of the squared gap above the noise floor that remains on held-out data. */
static double left_share(const struct gap_result *r) {
    double floor = counts(r, &r->noise_floor), gap = counts(r, &r->held_out_before) - floor, left = counts(r, &r->held_out_after) - floor;
    return left > 0.0 ? left < gap ? left / gap : 1.0 : 0.0;
}

/* True if, in simulation or under the measured motion, the model with the effects differs from the
 * machine, or from the validation log, by clearly more than noise. A remainder near the noise
 * contradicts nothing, however large its share of a small gap is. */
static bool refuted(const struct gap_result *r) {
    double floor = counts(r, &r->noise_floor), after = counts(r, &r->held_out_after);
    bool much = after > fmax(square(FLOORS_MAX) * floor, square(LEFT_MAX)) && left_share(r) > LEFT_SHARE;
    bool visible = r->effects && r->simulated && after - floor > VISIBLE * floor && left_share(r) > SHARE_MAX;
    return much || visible;
}

/* True if most of the remainder in simulation is constant. */
static bool leaves_constants(const struct gap_result *r) {
    double left = square(r->held_out_after.overall) - square(r->noise_floor.overall);
    double varies = square(r->held_out_after.varying) - square(r->noise_floor.varying);
    return r->simulated && left > VISIBLE * square(r->noise_floor.overall) && varies < 0.5 * left;
}

/* True if the model with the effects lacks the tone, and the tone is not negligible beside the gap
 * that the effects explain. */
static bool line_remains(const struct gap_result *r) {
    double gap = r->held_out_before.channel[r->tone.channel], floor = r->noise_floor.channel[r->tone.channel];
    bool negligible = r->effects && r->tone.rms < TONE_SHARE * sqrt(fmax(gap * gap - floor * floor, 0.0));
    return r->tone.hz > 0.0 && !r->tone_simulated && !negligible;
}

/* True if the effects imitate an effect that is not in the catalogue. Either they are as many as
 * the search allows, so that the search did not end because everything was explained, or the third
 * one explains too much. An effect in doubt counts as the third one, because it was found last.
 * Clock skew, and effects that the configuration has with another size, are not counted. many:
 * receives the number of counted effects. */
static bool imitated(const struct gap_result *r, const struct remainder *m, int *many) {
    int sought = 0, third = 0;
    for (int i = 0; i < r->effects; i++)
        if (!r->effect[i].given.on && effect_table[r->effect[i].effect] != &clock_skew && ++sought == 3) third = i;
    *many = sought;
    if (sought == GAP_EFFECTS) return true;
    if (sought < 3) return false;
    double z = r->effect[r->ambiguous ? r->in_doubt : third].z;
    return 0.5 * z * z > THIRD_SHARE * m->before;
}

static bool is_spring(int effect) { return effect_table[effect] == &external_stiffness; }

/* True if the effect is a mass or an inertia that looks like a spring at one frequency. */
static bool is_inertia(int effect) {
    return effect_table[effect]->family == EFFECT_BODIES && experiment_is_known(effect_table[effect], &external_stiffness);
}

/* True if masses and springs together explain tests at one frequency. At one frequency the force of
 * any part that moves by itself equals the force of a mass or of a spring. Which of the two it
 * equals, and how large it is, differs from axis to axis. */
static bool moves_by_itself(const struct gap_result *r) {
    bool spring = false, inertia = false;
    for (int i = 0; i < r->effects; i++) {
        bool doubted = r->ambiguous && i == r->in_doubt;
        spring = spring || (!doubted && is_spring(r->effect[i].effect));
        inertia = inertia || (!doubted && is_inertia(r->effect[i].effect));
    }
    return r->one_hz > 0.0 && spring && inertia;
}

static bool unknown(struct gap_result *r, const struct remainder *m) {
    int many;
    ADVISE(r, "%s", experiment_unknown());
    if (line_remains(r)) {
        SAY(r, "a tone at %.4g Hz, no harmonic of the motion: %s", r->tone.hz, tone_words);
        ADVISE(r, "%s", params_mechanism(&r->model)->words.tone);
    } else if (remains(r, m)) {
        SAY(r, "a deterministic remainder that no effect of the catalogue explains (mean white square %.1f)", m->after / m->values);
    } else if (imitated(r, m, &many)) {
        SAY(r, "no one or two effects of the catalogue explain the gap; it takes %d to imitate it", many);
    } else if (moves_by_itself(r)) {
        int alike[GAP_EFFECTS], count = 0;
        for (int i = 0; i < r->effects; i++)
            if (is_spring(r->effect[i].effect) || is_inertia(r->effect[i].effect)) alike[count++] = r->effect[i].effect;
        r->reason[0] = '\0';
        append_names(r, count, alike);
        append(r, " explain the gap, but at one frequency so does any part that moves by itself, such as a liquid or a base on springs");
        experiment_other_frequency(params_mechanism(&r->model), r->one_hz, r->next_experiment);
    } else if (refuted(r)) {
        const char *where = r->simulated ? "simulation" : "the measured motion";
        double floors = sqrt(counts(r, &r->held_out_after) / counts(r, &r->noise_floor));
        if (r->effects)
            SAY(r, "%s comes nearest, but the model with it leaves %.0f %% of the gap in %s, %.1f times the noise",
                name_of(r->effect[0].effect), 100.0 * left_share(r), where, floors);
        else
            SAY(r, "the equations find nothing missing, but the gap in %s%s is %.1f times the noise", where,
                r->validated ? " against the log of --validate" : "", floors);
    } else {
        return false;
    }
    return true;
}

/* Possible error of the weight on a single axis, N: twice the tolerance of its mass. */
static double weight_tolerance_n(const struct params *p) {
    return 2.0 * p->model.tolerance.mass * fabs(p->axis.mass_kg * p->axis.gravity_mps2);
}

/* Finds a dry friction (Coulomb or Dahl) that clearly differs between the directions, on a machine
 * whose leg may have an unknown constant force. Such a friction looks like a symmetric friction
 * beside a constant force. Returns NULL if there is none. */
static const struct gap_effect *one_sided(const struct gap_result *r) {
    const struct params *p = &r->model;
    double weight_n = weight_tolerance_n(p);
    const struct gap_effect *found = NULL;
    for (int i = 0; i < r->effects && params_mechanism(p)->force_sensor; i++) {
        const struct gap_effect *e = &r->effect[i];
        double extend = e->values.value[0][0], retract = e->values.value[1][0], std = hypot(e->std[0][0], e->std[1][0]);
        double noticed_n = fmax(OFFSET_SIGMAS * std, OFFSET_SHARE * (extend + retract)) + weight_n;
        bool dry = effect_table[e->effect] == &cylinder_coulomb_friction || effect_table[e->effect] == &cylinder_dahl_friction;
        if (dry && fabs(extend - retract) > noticed_n) found = e;
    }
    return found;
}

/* True if effect i is not in doubt, and the configuration has it (given true) or lacks it (given
 * false). */
static bool sure(const struct gap_result *r, int i, bool given) {
    return r->effect[i].given.on == given && !(r->ambiguous && i == r->in_doubt);
}

/* Appends the names of the effects for which sure() is true, with the words `before` and `after`
 * around them. Returns false if there are none. */
static bool list(struct gap_result *r, bool given, const char *before, const char *after) {
    int left = 0;
    for (int i = 0; i < r->effects; i++) left += sure(r, i, given);
    if (!left) return false;
    for (int i = 0; i < r->effects; i++) {
        if (!sure(r, i, given)) continue;
        append(r, before);
        append(r, name_of(r->effect[i].effect));
        before = --left == 1 ? " and " : ", ";
    }
    append(r, after);
    return true;
}

static void list_all(struct gap_result *r) {
    SAY(r, "the model");
    bool lacks = list(r, false, " lacks ", "");
    list(r, true, lacks ? " and has " : " has ", " of another size");
}

static void name(struct gap_result *r) {
    const struct mechanism *mechanism = params_mechanism(&r->model);
    int doubted = r->effect[r->in_doubt].effect, rival = r->ambiguous_with[0];
    if (r->ambiguous) {
        r->verdict = GAP_AMBIGUOUS;
        char pair[GAP_TEXT];
        snprintf(pair, sizeof pair, "these data cannot tell %s from ", name_of(doubted));
        r->reason[0] = '\0';
        if (r->effects > 1) list_all(r), append(r, "; ");
        append(r, pair);
        append_names(r, r->ambiguous_together ? r->ambiguous : 1, r->ambiguous_with);
        experiment_between(mechanism, effect_table[doubted], effect_table[rival], r->next_experiment);
        return;
    }
    const struct gap_effect *friction = one_sided(r);
    r->offset_rival = friction != NULL;
    if (friction) {
        double extend = friction->values.value[0][0], retract = friction->values.value[1][0];
        r->verdict = GAP_AMBIGUOUS;
        SAY(r,
            "these data cannot tell %s stronger in one direction from symmetric friction of %.3g N beside a constant force of %.3g N, a "
            "force sensor's zero, say",
            name_of(friction->effect), 0.5 * (extend + retract), 0.5 * fabs(extend - retract));
        experiment_from_parameter(mechanism, effect_table[friction->effect], "axis.force_offset_n", r->next_experiment);
        return;
    }
    r->verdict = GAP_EFFECT_NAMED;
    list_all(r);
}

/* Mentions stated values of the base to check first, because a wrong one looks like the effect that
 * is parallel to it. */
static void say_constants(struct gap_result *r) {
    struct variable base[FIT_VARIABLES];
    const char *before = "; first check ";
    int count = base_variables(&r->model, EQUATIONS_ALL | EQUATIONS_FORCE_SENSOR, base);
    for (int i = 0; i < r->effects; i++) {
        const char *const *parallel = effect_table[r->effect[i].effect]->parallel_to;
        for (int k = 0; k < EFFECT_TIES && parallel[k] && !r->effect[i].given.on; k++) {
            int v = 0;
            while (v < count && strcmp(base[v].name, parallel[k])) v++;
            /* a constant force and the error of a sensor have no stated value to check */
            if (v == count || base[v].penalised || !strcmp(parallel[k], "axis.force_offset_n")) continue;
            append(r, before);
            append(r, base[v].name);
            before = ", ";
        }
    }
    if (*before == ',') append(r, " in the configuration");
}

/* Mentions a constant force, which is no effect, but may be a weight that the configuration does
 * not state. */
static void say_offset(struct gap_result *r) {
    int i = 0;
    while (i < r->base_values && strcmp(r->base[i].name, "axis.force_offset_n")) i++;
    if (i == r->base_values || r->offset_rival || r->verdict == GAP_UNKNOWN_EFFECT) return;
    const struct gap_base_value *v = &r->base[i];
    double found_n = v->value - v->given, std_n = isnan(v->std) ? 0.0 : v->std;
    if (fabs(found_n) <= OFFSET_SIGMAS * std_n + weight_tolerance_n(&r->model)) return;
    char text[GAP_TEXT];
    snprintf(text, sizeof text,
             "; the measured force is %.3g N too %s throughout: zeros of the force or pressure sensors, or another weight than "
             "axis.mass_kg times axis.gravity_mps2",
             fabs(found_n), found_n > 0.0 ? "high" : "low");
    append(r, text);
}

/* Mentions parts that move by themselves. At one frequency the force of such a part is that of a
 * mass or a spring, whatever its own frequency is. */
static void say_one_frequency(struct gap_result *r) {
    bool alike = false;
    for (int i = 0; i < r->effects; i++) alike = alike || is_spring(r->effect[i].effect) || is_inertia(r->effect[i].effect);
    for (int i = 0; i < r->ambiguous; i++) alike = alike || is_spring(r->ambiguous_with[i]) || is_inertia(r->ambiguous_with[i]);
    if (r->verdict == GAP_UNKNOWN_EFFECT || !(r->one_hz > 0.0) || !alike) return;
    append(
        r,
        "; each axis has one frequency, at which a part that moves by itself (a liquid, a base on springs) looks like a mass or a spring");
    if (!r->next_experiment[0]) experiment_other_frequency(params_mechanism(&r->model), r->one_hz, r->next_experiment);
}

/* Mentions dry friction that changes from test to test. */
static void say_course(struct gap_result *r) {
    const struct gap_course *c = &r->course;
    bool falls = c->most.test < c->least.test;
    if (r->verdict == GAP_UNKNOWN_EFFECT || !(c->ratio > 0.0)) return;
    char text[GAP_TEXT];
    snprintf(text, sizeof text,
             "; %s is %s%.3g times as large in test %d (%s) as in test %d (%s): it changes with time%s, differs from leg to leg, or "
             "follows another law",
             c->frictions > 1 ? "dry friction" : name_of(c->effect), c->at_least ? "at least " : "", c->ratio, c->most.test + 1,
             dof_names[c->most.dof], c->least.test + 1, dof_names[c->least.dof], falls ? ", as that of seals that warm up" : "");
    append(r, text);
    if (!r->next_experiment[0]) ADVISE(r, "%s", experiment_when_warm());
}

/* Adds remarks that do not depend on the named effect: how the recording differs from what was
 * stated, and, unless the effect is unknown, a tone and a constant force. With effects, also adds
 * why no simulation shows them, or that the simulation leaves a constant. */
static void say_rest(struct gap_result *r) {
    char text[GAP_TEXT];
    if (r->verdict != GAP_UNKNOWN_EFFECT && r->tone.hz > 0.0 && !r->tone_simulated) {
        snprintf(text, sizeof text, "; besides, a tone at %.4g Hz, no harmonic of the motion: %s", r->tone.hz, tone_words);
        append(r, text);
    }
    if (r->effects && r->replay_fault[0]) {
        snprintf(text, sizeof text, "; not shown by simulation: %.160s", r->replay_fault);
        append(r, text);
    }
    say_offset(r);
    say_one_frequency(r);
    say_course(r);
    if (r->verdict == GAP_EFFECT_NAMED && leaves_constants(r))
        append(r, "; what simulation leaves is constant: where a run begins decides that, as long as a valve stays shut");

    if (r->moved_hz > 0.0) {
        snprintf(text, sizeof text, "; the legs move at %.5g Hz, where %.5g was stated", r->moved_hz, r->stated_hz);
        append(r, text);
    }
    if (r->sampled_s > 0.0) {
        snprintf(text, sizeof text,
                 "; the log has a sample each %.3g ms, the controller's cycle (loop.period_s) is %.3g ms: what it commanded "
                 "between is not known",
                 1e3 * r->sampled_s, 1e3 * r->model.loop.period_s);
        append(r, text);
    }
    if (r->controller_differs) {
        snprintf(text, sizeof text, "; the recorded commands are not the configured controller's (%.0f %% differ)",
                 100.0 * r->controller_difference);
        append(r, text);
    }
}

void judge(struct gap_result *r, const struct remainder *m) {
    if (unknown(r, m)) {
        r->verdict = GAP_UNKNOWN_EFFECT;
    } else if (r->effects) {
        ADVISE(r, "%s", "");
        name(r);
        say_constants(r);
    } else {
        ADVISE(r, "%s", "");
        r->verdict = GAP_NO_GAP;
        if (m->after > m->noise)
            SAY(r, "what is left is noise, and no more than the effects in the configuration leave by themselves (mean white square %.1f)",
                m->after / m->values);
        else SAY(r, "what is left between model and measurement is noise");
    }

    char text[GAP_TEXT];
    if (r->verdict != GAP_UNKNOWN_EFFECT && m->beyond_laws > 1.0 && trace(m) > 0.0) {
        snprintf(text, sizeof text, "; %.2g %% of the gap's square is left beyond the noise, and is nothing of the catalogue",
                 100.0 * trace(m));
        append(r, text);
    }
    say_rest(r);
}

bool judge_partly(struct gap_result *r) {
    if (line_remains(r) || moves_by_itself(r) || !(r->unexplained_fraction < PARTLY_LEFT)) return false;
    const char *before = " ";
    bool pressures = isfinite(r->held_out_after.channel[GAP_P1]);
    r->verdict = GAP_PARTLY_NAMED;
    ADVISE(r, "%s", "");
    SAY(r, "the model lacks");
    for (int i = 0; i < r->effects; i++) {
        bool family = i < r->statements && r->statement[i].family;
        append(r, before);
        append(r, family ? effect_families[r->statement[i].which].words : name_of(r->effect[i].effect));
        before = i + 2 < r->effects ? ", " : " and ";
        if (family) append(r, ", by none of the known laws for certain");
    }
    double noise_n = r->noise_floor.channel[GAP_FORCE];
    double left_n = sqrt(fmax(square(r->held_out_after.channel[GAP_FORCE]) - square(noise_n), 0.0));
    char text[GAP_TEXT];
    snprintf(text, sizeof text, "; that explains %.0f %% of the gap on held-out data", 100.0 * (1.0 - r->unexplained_fraction));
    append(r, text);
    if (left_n > noise_n)
        snprintf(text, sizeof text, ", and %.3g N of force%s are left that no law makes", left_n,
                 pressures ? " (rms, and what the pressures show)" : " (rms)");
    else snprintf(text, sizeof text, ", and no more force than noise (%.3g N rms) is left", noise_n);
    append(r, text);
    say_constants(r);
    say_rest(r);
    return true;
}

/* True if the contradicting set differs from the result only in having, in place of one effect,
 * another effect, or several effects that each look like it. place: set to the index of the
 * replaced effect in the result. rivals, count: set to the effects in its place, and to their
 * number. */
static bool exchanged(const struct gap_result *r, const struct gap_certainty *c, int *place, int *count, int rivals[GAP_EFFECTS]) {
    int lacks = 0;
    bool alike = true;
    *count = 0;
    for (int i = 0; i < r->effects; i++) {
        bool in = false;
        for (int j = 0; j < c->others; j++) in = in || c->other[j] == r->effect[i].effect;
        if (!in) lacks++, *place = i;
    }
    if (lacks != 1) return false;
    for (int j = 0; j < c->others; j++) {
        bool in = false;
        for (int i = 0; i < r->effects; i++) in = in || c->other[j] == r->effect[i].effect;
        if (in) continue;
        rivals[(*count)++] = c->other[j];
        alike = alike && experiment_is_known(effect_table[r->effect[*place].effect], effect_table[c->other[j]]);
    }
    return *count == 1 || (*count > 1 && alike);
}

void judge_certainty(struct gap_result *r, const struct remainder *m, const struct gap_certainty *c) {
    int place = 0, count, rivals[GAP_EFFECTS];
    r->certainty = *c;
    if (!(c->probability < GAP_SURE)) return;
    if (r->verdict == GAP_EFFECT_NAMED && c->probability + c->other_probability >= GAP_SURE && exchanged(r, c, &place, &count, rivals)) {
        r->ambiguous = count, r->in_doubt = place, r->ambiguous_together = count > 1;
        memcpy(r->ambiguous_with, rivals, (size_t)count * sizeof *rivals);
        r->certainty.probability = fmin(c->probability + c->other_probability, 1.0);
        judge(r, m);
        return;
    }
    if (r->verdict == GAP_EFFECT_NAMED) r->verdict = GAP_PARTLY_NAMED;
    char words[GAP_WORDS];
    append(r, "; the probability of this verdict is ");
    append(r, gap_probability_words(c->probability, words));
    append(r, ", that of ");
    append_names(r, c->others, c->other);
    append(r, c->others ? " alone " : " ");
    append(r, gap_probability_words(c->other_probability, words));
}
