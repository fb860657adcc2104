#include "gap_messages.h"

#include <stdint.h>
#include <stdio.h>

#include "hexid_gap_2_t.h"
#include "hypothesis.h"
#include "messages.h"

enum { PARAMETERS = GAP_EFFECTS * EFFECT_KEYS * LEGS, NAME_SIZE = 80 };

struct lists {
    char *effects[GAP_EFFECTS], *rivals[GAP_RIVALS];
    double share[GAP_EFFECTS], z[GAP_EFFECTS];
    char name[PARAMETERS][NAME_SIZE], *names[PARAMETERS], *units[PARAMETERS];
    int8_t legs[PARAMETERS];
    double value[PARAMETERS], std[PARAMETERS];
    int parameters;
    char *statements[GAP_STATEMENTS], *levels[GAP_STATEMENTS];
    double probability[GAP_STATEMENTS], statement_share[GAP_STATEMENTS];
};

static void add_parameter(struct lists *l, const struct gap_effect *e, int key, int leg) {
    const struct effect *effect = effect_table[e->effect];
    int i = l->parameters++;
    snprintf(l->name[i], NAME_SIZE, "%s.%s", effect->name, effect->keys[key].name);
    l->names[i] = l->name[i];
    l->units[i] = lcm_text(effect->keys[key].unit);
    l->legs[i] = (int8_t)(e->pattern == PATTERN_ALL ? 0 : leg + 1);
    l->value[i] = e->values.value[key][leg];
    l->std[i] = gap_deviation(e, key, leg);
}

static void list_all(struct lists *l, const struct gap_result *r) {
    l->parameters = 0;
    for (int i = 0; i < r->effects; i++) {
        const struct gap_effect *e = &r->effect[i];
        int first = e->pattern >= 0 ? e->pattern : 0, end = e->pattern == PATTERN_EACH ? LEGS : first + 1;
        l->effects[i] = lcm_text(effect_table[e->effect]->name);
        l->share[i] = e->share_explained;
        l->z[i] = e->z;
        for (int key = 0; key < e->keys; key++)
            for (int leg = first; leg < end; leg++) add_parameter(l, e, key, leg);
    }
    for (int i = 0; i < r->statements; i++) {
        const struct gap_statement *s = &r->statement[i];
        l->statements[i] = lcm_text(gap_statement_name(s)), l->levels[i] = lcm_text(gap_statement_level(s));
        l->probability[i] = s->probability, l->statement_share[i] = s->share_explained;
    }
    for (int i = 0; i < r->ambiguous; i++) l->rivals[i] = lcm_text(effect_table[r->ambiguous_with[i]]->name);
}

int gap_encode(const struct gap_result *r, int64_t time_ns, unsigned char *buffer, int capacity) {
    struct lists l;
    list_all(&l, r);
    const double *before = r->held_out_before.channel, *after = r->held_out_after.channel, *floor = r->noise_floor.channel;
    hexid_gap_2_t m = {
        .time_ns = time_ns,
        .verdict = lcm_text(gap_verdict_names[r->verdict]),
        .reason = lcm_text(r->reason),
        .next_experiment = lcm_text(r->next_experiment),
        .effect_count = r->effects,
        .effects = l.effects,
        .share_explained = l.share,
        .z = l.z,
        .parameter_count = l.parameters,
        .parameters = l.names,
        .parameter_legs = l.legs,
        .parameter_units = l.units,
        .values_si = l.value,
        .values_std_si = l.std,
        .ambiguous_count = r->ambiguous,
        .ambiguous_with = l.rivals,
        .simulated = r->simulated,
        .unexplained_fraction = r->unexplained_fraction,
        .before_ratio = r->before.overall,
        .after_ratio = r->after.overall,
        .noise_floor_ratio = r->noise_floor.overall,
        .held_out_before_ratio = r->held_out_before.overall,
        .held_out_after_ratio = r->held_out_after.overall,
        .held_out_before_length_m = before[GAP_LENGTH],
        .held_out_before_force_n = before[GAP_FORCE],
        .held_out_before_p1_pa = before[GAP_P1],
        .held_out_before_p2_pa = before[GAP_P2],
        .held_out_before_valve = before[GAP_VALVE],
        .held_out_after_length_m = after[GAP_LENGTH],
        .held_out_after_force_n = after[GAP_FORCE],
        .held_out_after_p1_pa = after[GAP_P1],
        .held_out_after_p2_pa = after[GAP_P2],
        .held_out_after_valve = after[GAP_VALVE],
        .noise_floor_length_m = floor[GAP_LENGTH],
        .noise_floor_force_n = floor[GAP_FORCE],
        .noise_floor_p1_pa = floor[GAP_P1],
        .noise_floor_p2_pa = floor[GAP_P2],
        .noise_floor_valve = floor[GAP_VALVE],
        .statement_count = r->statements,
        .statements = l.statements,
        .statement_levels = l.levels,
        .statement_probability = l.probability,
        .statement_share = l.statement_share,
        .family = lcm_text(gap_family_name(r)),
        .certainty = r->certainty.probability,
    };
    return hexid_gap_2_t_encode(buffer, 0, capacity, &m);
}
