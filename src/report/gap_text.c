#include "gap_text.h"

#include <math.h>
#include <string.h>

#include "gap_pictures.h"
#include "gap_sections.h"
#include "hypothesis.h"
#include "numeric.h"
#include "words.h"

enum { RUNNERS_UP = 3, PLACES_SHOWN = 5, LEGS_A_LINE = 2 };

static void print_parameter(FILE *out, const struct gap_effect *e, int key) {
    const struct effect_key *k = &effect_table[e->effect]->keys[key];
    int first = e->pattern >= 0 ? e->pattern : 0, end = e->pattern == PATTERN_EACH ? LEGS : first + 1;
    fprintf(out, "    %-24s", k->name);
    for (int leg = first; leg < end; leg++) {
        if (leg > first && leg % LEGS_A_LINE == 0) fprintf(out, "\n%28s", "");
        fprintf(out, " %.4g", e->values.value[key][leg]);
        if (e->bound[key][leg]) fputs(" (at bound)", out);
        else fprintf(out, " +- %.2g", NUMERIC_95 * gap_deviation(e, key, leg));
        if (e->given.on && (e->pattern != PATTERN_ALL || gap_given_alike(e, key))) fprintf(out, " (given %.4g)", e->given.value[key][leg]);
        else if (e->given.on) fputs(" (given leg by leg)", out);
    }
    fprintf(out, " %s\n", k->unit);
}

static void print_effect(FILE *out, const struct gap_effect *e, bool alone) {
    const struct effect *effect = effect_table[e->effect];
    fprintf(out, "  %s", effect->name);
    if (e->pattern >= 0) fprintf(out, " of leg %d", e->pattern + 1);
    if (alone) fprintf(out, " explains %.1f %% of it", 100.0 * e->share_explained);
    fprintf(out, " (z %.0f)\n", e->z);
    for (int key = 0; key < e->keys; key++) print_parameter(out, e, key);
}

static void print_findings(FILE *out, const struct gap_result *r) {
    char words[GAP_WORDS];
    if (isfinite(r->certainty.probability))
        fprintf(out, "  probability %s, among the sets of effects that were compared\n",
                gap_probability_words(r->certainty.probability, words));
    for (int i = 0; i < r->effects; i++) {
        print_effect(out, &r->effect[i], i == 0);
        for (int j = 0; j < r->ambiguous && i == r->in_doubt; j++)
            fprintf(out, "  %s %s\n", j && r->ambiguous_together ? "together with" : "cannot be told from",
                    effect_table[r->ambiguous_with[j]]->name);
    }
    for (int i = 0, shown = 0; i < r->candidates && shown < RUNNERS_UP && r->verdict != GAP_NO_GAP && !r->statements; i++) {
        if (section_named(r, r->candidate[i].effect)) continue;
        const char *name = effect_table[r->candidate[i].effect]->name;
        double percent = 100.0 * r->candidate[i].share_explained;
        /* Candidates were tried alone, so their z is not compared with that of several effects
         * together. */
        if (r->effects > 1) fprintf(out, "  %s alone would explain %.1f %%\n", name, percent);
        else fprintf(out, "  runner-up %s: %.1f %%, short by z = %.0f\n", name, percent, gap_short(r, &r->candidate[i]));
        shown++;
    }
    if (r->effects || r->statements) fprintf(out, "  +- is a 95 %% interval\n");
    if (r->offset_rival) fprintf(out, "  cannot be told from constant_force_offset\n");
    if (r->next_experiment[0]) words_print(out, "  next experiment:", r->next_experiment);
}

/* Lists the statements beyond those that the verdict makes. Each has the values of the likeliest
 * set of effects that contains its effect. */
static void print_statements(FILE *out, const struct gap_result *r) {
    int first = r->effects < r->statements ? r->effects : r->statements;
    if (r->statements == first) return;
    fputs(first ? "  less sure, each as in the likeliest set that has it:\n" : "  likeliest, each as in the likeliest set that has it:\n",
          out);
    for (int i = first; i < r->statements; i++) {
        const struct gap_statement *s = &r->statement[i];
        fprintf(out, "  %s, probability %.2f, alone %.1f %%\n", gap_statement_name(s), s->probability, 100.0 * s->share_explained);
        for (int key = 0; key < s->effect.keys; key++) print_parameter(out, &s->effect, key);
    }
}

/* Prints the base's values that are at their bounds. The true value may lie beyond the bound; an
 * effect may then be named in place of the base's error. */
static void print_bounds(FILE *out, const struct gap_result *r) {
    char text[GAP_TEXT] = "";
    for (int i = 0; i < r->base_values; i++) {
        const struct gap_base_value *b = &r->base[i];
        size_t used = strlen(text);
        if (!b->bound) continue;
        snprintf(text + used, sizeof text - used, "%s%s", used ? "; " : "at their limit, ", b->name);
        used = strlen(text);
        if (b->leg >= 0) snprintf(text + used, sizeof text - used, " of leg %d", b->leg + 1);
        used = strlen(text);
        snprintf(text + used, sizeof text - used, " %.4g (given %.4g)", b->value, b->given);
    }
    if (*text) words_print(out, "  base:", text);
}

static void print_sizes(FILE *out, const struct gap_result *r) {
    const struct gap_size *before = &r->held_out_before, *after = &r->held_out_after, *noise = &r->noise_floor;
    fprintf(out, "\n  held out   %10s %10s %10s\n", "before", "after", "noise");
    for (int ch = 0; ch < GAP_CHANNELS; ch++) {
        const struct picture_unit *u = &picture_units[ch];
        if (isfinite(noise->channel[ch]))
            fprintf(out, "  %-10s %10.4g %10.4g %10.4g %s\n", gap_channel_names[ch], u->scale * before->channel[ch],
                    u->scale * after->channel[ch], u->scale * noise->channel[ch], u->unit);
    }
    if (!isfinite(r->unexplained_fraction)) return;
    fprintf(out, "  %-10s %10.4g %10.4g %10.4g of variation", "overall", before->overall, after->overall, noise->overall);
    if (r->verdict != GAP_NO_GAP) fprintf(out, "; unexplained %.1f %%", 100.0 * r->unexplained_fraction);
    fputc('\n', out);
    if (!r->simulated) fputs("  of the equations under the measured motion: no closed loop is simulated\n", out);
}

void gap_text_print(FILE *out, const struct gap_result *r) {
    char label[32];
    snprintf(label, sizeof label, "\n%s:", gap_verdict_names[r->verdict]);
    words_print(out, label, r->reason);
    print_findings(out, r);
    print_statements(out, r);
    print_bounds(out, r);
    print_sizes(out, r);
    for (int i = 0; i < r->places && i < PLACES_SHOWN && r->verdict != GAP_NO_GAP; i++) {
        const struct gap_place *w = &r->where[i];
        char words[GAP_WORDS];
        fprintf(out, "  where: %s, %s: %.1f %%\n", gap_place_words(w, params_legs(&r->model), words), w->feature, 100.0 * w->share);
    }
    fprintf(out, "  %.1f s\n", r->seconds);
}
