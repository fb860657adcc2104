#include "gap_result.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const gap_verdict_names[GAP_VERDICTS] = {"effect_named", "no_gap", "ambiguous", "unknown_effect", "partly_named"};
const char *const gap_channel_names[GAP_CHANNELS] = {"length", "force", "p1", "p2", "valve"};
const char *const gap_channel_units[GAP_CHANNELS] = {"m", "N", "Pa", "Pa", "-"};

bool gap_given_alike(const struct gap_effect *effect, int key) {
    bool alike = true;
    for (int leg = 1; leg < LEGS; leg++) alike = alike && effect->given.value[key][leg] == effect->given.value[key][0];
    return alike;
}

double gap_deviation(const struct gap_effect *e, int key, int leg) {
    const struct effect_key *k = &effect_table[e->effect]->keys[key];
    /* parameters of a law's form and reciprocals are not proportional to the effect's strength */
    bool shapes = k->reciprocal || k->shapes_law;
    double law = effect_table[e->effect]->law_error * (e->values.value[key][leg] - (shapes ? 0.0 : k->neutral));
    return e->std[key][leg] > 0.0 ? hypot(e->std[key][leg], law) : 0.0;
}

const char *gap_probability_words(double probability, char words[GAP_WORDS]) {
    static const double LEAST = 1e-3;
    bool low = probability < LEAST, high = probability > 1.0 - LEAST;
    if (low || high) snprintf(words, GAP_WORDS, "%s %g", low ? "below" : "above", low ? LEAST : 1.0 - LEAST);
    else snprintf(words, GAP_WORDS, "%.2g", probability);
    return words;
}

const char *gap_statement_name(const struct gap_statement *s) {
    return s->family ? effect_families[s->which].name : effect_table[s->which]->name;
}

const char *gap_statement_level(const struct gap_statement *s) { return s->family ? "family" : "effect"; }

const char *gap_family_name(const struct gap_result *r) {
    for (int i = 0; i < r->effects && i < r->statements; i++)
        if (r->statement[i].family) return effect_families[r->statement[i].which].name;
    return "";
}

double gap_short(const struct gap_result *r, const struct gap_candidate *candidate) {
    double most = 0.0;
    for (int i = 0; i < r->candidates; i++) most = fmax(most, r->candidate[i].z);
    if (r->effects == 1) most = fmax(most, r->effect[0].z);
    return sqrt(fmax(most * most - candidate->z * candidate->z, 0.0));
}

/* Order of effects for qsort: the most certain first. */
static int by_z(const void *a, const void *b) {
    const struct gap_effect *x = a, *y = b;
    return x->z < y->z ? 1 : x->z > y->z ? -1 : 0;
}

void gap_sort_effects(struct gap_result *r) { qsort(r->effect, (size_t)r->effects, sizeof *r->effect, by_z); }

const char *gap_signature(int effect, int legs) {
    static const char leg[] = "leg ";
    const char *signature = effect_table[effect]->signature;
    return legs == 1 && !strncmp(signature, leg, sizeof leg - 1) ? signature + sizeof leg - 1 : signature;
}

const char *gap_place_words(const struct gap_place *p, int legs, char words[GAP_WORDS]) {
    char of_leg[32] = "";
    if (legs > 1) snprintf(of_leg, sizeof of_leg, " of leg %d", p->leg + 1);
    if (!(p->segment_s > 0.0))
        snprintf(words, GAP_WORDS, "test %s at %.3g Hz, %s%s, harmonic %d", dof_names[p->dof], p->frequency_hz,
                 gap_channel_names[p->channel], of_leg, p->harmonic);
    else snprintf(words, GAP_WORDS, "at %.4g s near %.2g Hz, %s%s", p->at_s, p->frequency_hz, gap_channel_names[p->channel], of_leg);
    return words;
}
