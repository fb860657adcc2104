/* Finds out which effects the six tests can tell apart. For every effect at its typical size, on a
 * machine like the model, it prints z, the normalised signature that the base cannot absorb, and
 * the share of z that no other effect absorbs. With a file's name it writes CSV for
 * tests/gap/score.py: the strength of each effect at which z = 8 (0: z is larger at any strength),
 * and the share of that z that each other effect leaves. Effects named after the file are the only
 * rows.
 *
 *     signatures [FILE [EFFECT ...]]
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config.h"
#include "diagnose.h"
#include "version.h"
#include "../gap_rig.h"

static struct diagnosis d;
static struct hypothesis hypothesis[HYPOTHESES_MAX];

static void fail(const char *text) {
    fprintf(stderr, "signatures: %s\n", text);
    exit(1);
}

static void *room(size_t doubles) {
    void *place = malloc(doubles * sizeof(double));
    if (!place) fail("out of memory");
    return place;
}

/* Changes of the model that may absorb a signature. */
struct span {
    int count;
    const double *column[FIT_VARIABLES];
    double min[FIT_VARIABLES], max[FIT_VARIABLES];
    struct fit_prior prior[FIT_VARIABLES];
};

static void span_add(struct span *s, const double *column, double min, double max, struct fit_prior prior) {
    s->column[s->count] = column;
    s->prior[s->count] = prior;
    s->min[s->count] = min, s->max[s->count++] = max;
}

/* Removes the span's part from the vector in place; returns the length of the remainder, with the
 * penalty of the span's priors. */
static double leave(const struct span *s, double *vector) {
    double x[FIT_VARIABLES];
    int values = d.fit.values;
    if (!fit_box(s->count, values, vector, s->column, s->prior, s->min, s->max, x, NULL)) fail("the columns are singular");
    double penalty = 0.0;
    for (int i = 0; i < s->count; i++) {
        penalty += pow(s->prior[i].inverse_std * (x[i] + s->prior[i].off), 2.0);
        for (int a = 0; a < values; a++) vector[a] += x[i] * s->column[i][a];
    }
    /* the factor 2 adds the held-out cycles, which are as many */
    return sqrt(2.0 * fit_square(values, vector) + penalty);
}

/* Returns the changes of the base within its tolerance, except those parallel to the hypothesis. */
static struct span base_span(const struct hypothesis *h) {
    struct span s = {0};
    for (int i = 0; i < d.variables; i++) {
        const struct variable *v = &d.variable[i];
        double value = variable_get(v, d.given);
        struct fit_prior prior = {v->prior_inverse_std, value - v->neutral};
        if (!hypothesis_parallel(h, v)) span_add(&s, d.column + (size_t)i * (size_t)d.fit.values, v->min - value, v->max - value, prior);
    }
    return s;
}

/* Computes the normalised change of the residual at this strength. Returns false if no machine can
 * have that strength. */
static bool signature(int effect, double strength, double *vector) {
    struct params with = d.model;
    double *here = room((size_t)d.fit.values);
    effect_at(effect_table[effect], strength, &with.effects[effect]);
    bool possible = fit_residual(&d.fit, &d.model, here) && fit_residual(&d.fit, &with, vector);
    for (int a = 0; a < d.fit.values && possible; a++) vector[a] -= here[a];
    free(here);
    return possible;
}

/* Returns z of the part of the signature that the base cannot absorb; HUGE_VAL if no machine can
 * have that strength. */
static double z_at(const struct hypothesis *h, double strength, double *vector) {
    struct span base = base_span(h);
    return signature(h->effect, strength, vector) ? leave(&base, vector) : HUGE_VAL;
}

/* Returns the strength at which z = 8, or 0 if z is at least 8 at any strength: the shortest hose
 * acts as one of 0.2 m, and air replaces the modulus of the base. The base absorbs changes within
 * its tolerance, so z is not proportional to the strength. */
static double detectable(const struct hypothesis *h, double *vector) {
    double low = 1e-5, high = 4.0, z = z_at(h, high, vector);
    if (z < 8.0) return high * 8.0 / z;
    if (z_at(h, low, vector) >= 8.0) return 0.0;
    for (int i = 0; i < 20; i++) {
        double middle = sqrt(low * high);
        if (z_at(h, middle, vector) < 8.0) low = middle;
        else high = middle;
    }
    return high;
}

/* Adds the rival to the span, each key separately at its typical size and without bounds, so that
 * the remainder is a lower bound for any law of its kind. */
static void add_rival(const struct hypothesis *h, double *place, struct span *s) {
    struct params at = d.model;
    size_t values = (size_t)d.fit.values;
    effect_at(effect_table[h->effect], 1.0, &at.effects[h->effect]);
    double *raw = room(values);
    if (!fit_raw(&d.fit, &at, raw) || !fit_columns(&d.fit, &at, raw, h->variables, h->variable, NULL, place))
        fail("no motion of this machine");
    free(raw);
    for (int i = 0; i < h->variables; i++)
        if (fit_square(d.fit.values, place + (size_t)i * values) > 0.0)
            span_add(s, place + (size_t)i * values, -1e300, 1e300, (struct fit_prior){0});
}

/* For each hypothesis of another effect, in all legs or in one, sets left[] to the length of the
 * signature that the base and that hypothesis together do not absorb; for the others, to
 * INFINITY. */
static void leave_beside(const struct hypothesis *all, int count, int of, const double *vector, double left[]) {
    size_t values = (size_t)d.fit.values;
    double *rest = room(values), *place = room(HYPOTHESIS_VARIABLES * values);
    struct span base = base_span(&all[of]);
    for (int j = 0; j < count; j++) {
        left[j] = INFINITY;
        if (all[j].pattern == PATTERN_EACH || all[j].effect == all[of].effect) continue;
        struct span both = base;
        add_rival(&all[j], place, &both);
        memcpy(rest, vector, values * sizeof *rest);
        left[j] = leave(&both, rest);
    }
    free(rest);
    free(place);
}

static const char *name_of(int of) { return effect_table[hypothesis[of].effect]->name; }

/* Returns the index of the hypothesis that leaves least of the signature, among the hypotheses of
 * other effects than `but`. */
static int least(const double left[], int count, int but) {
    int found = -1;
    for (int j = 0; j < count; j++)
        if ((but < 0 || hypothesis[j].effect != hypothesis[but].effect) && (found < 0 || left[j] < left[found])) found = j;
    return found;
}

/* Writes for each other effect the smallest share of z that one of its hypotheses leaves. */
static void write_left(FILE *file, const double left[], int count, double z) {
    double share[EFFECTS_MAX];
    for (int e = 0; e < EFFECTS_MAX; e++) share[e] = INFINITY;
    for (int j = 0; j < count; j++) share[hypothesis[j].effect] = fmin(share[hypothesis[j].effect], left[j] / z);
    for (int e = 0; e < EFFECTS_MAX; e++)
        if (isfinite(share[e])) fprintf(file, "%s:%.3f ", effect_table[e]->name, share[e]);
}

/* True if the row of this effect is wanted: it is named, or no effect is. */
static bool asked(const char *effect, int names, char **name) {
    for (int i = 0; i < names; i++)
        if (!strcmp(name[i], effect)) return true;
    return names == 0;
}

int main(int argc, char **argv) {
    static struct params params;
    struct recording recording;
    struct error error;
    config_default(&params);
    if (gap_rig(&params, &params, DOFS, &recording, &error)) fail(error.text);
    if (diagnosis_init(&d, &params, &recording, 1, &error)) fail(error.text);
    FILE *file = argc > 1 ? fopen(argv[1], "w") : NULL;
    if (argc > 1 && !file) fail("the file cannot be written");
    if (file) fprintf(file, "# hexid %s\neffect,strength,left\n", version);
    printf("hexid %s\n", version);
    int names = argc > 2 ? argc - 2 : 0, rows = 0;
    int count = hypotheses_list(&params, &d.model, d.found, d.even.equations, hypothesis);
    double *vector = room((size_t)d.fit.values), left[HYPOTHESES_MAX];
    printf("%-28s %8s  %s\n", "effect, typical", "z", "z that is left beside the nearest others");
    for (int i = 0; i < count; i++) {
        if (hypothesis[i].pattern != PATTERN_ALL || !asked(name_of(i), names, argv + 2)) continue;
        double z = z_at(&hypothesis[i], 1.0, vector);
        if (!signature(hypothesis[i].effect, 1.0, vector)) fail("a typical effect that no machine has");
        leave_beside(hypothesis, count, i, vector, left);
        int first = least(left, count, -1), second = least(left, count, first);
        if (!isfinite(z) || !isfinite(left[first]) || !isfinite(left[second])) fail("an effect whose signature is no number");
        rows++;
        printf("%-28s %8.1f  %.1f %s, %.1f %s\n", name_of(i), z, left[first], name_of(first), left[second], name_of(second));
        if (!file) continue;
        double strength = detectable(&hypothesis[i], vector);
        z = z_at(&hypothesis[i], strength, vector);
        fprintf(file, "%s,%.3g,", name_of(i), strength);
        if (strength > 0.0 && signature(hypothesis[i].effect, strength, vector)) {
            leave_beside(hypothesis, count, i, vector, left);
            write_left(file, left, count, z);
        }
        fputc('\n', file);
    }
    if (file && fclose(file)) fail("the file cannot be written");
    if (rows < (names ? names : 1)) fail("an effect that was asked for has no row");
    diagnosis_free(&d);
    recording_free(&recording);
    free(vector);
}
