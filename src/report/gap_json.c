#include "gap_json.h"

#include <math.h>

#include "ident.h"
#include "report_json.h"

/* Returns one number if all legs have the same value, otherwise a list. */
static json_t *legs(const double x[LEGS]) {
    bool alike = true;
    for (int k = 1; k < LEGS; k++) alike = alike && x[k] == x[0];
    return alike ? report_number(x[0]) : report_vector(x, LEGS);
}

static json_t *deviations(const struct gap_effect *e, int key) {
    double std[LEGS];
    for (int leg = 0; leg < LEGS; leg++) std[leg] = gap_deviation(e, key, leg);
    return legs(std);
}

static json_t *effect(const struct gap_effect *e) {
    const struct effect *effect = effect_table[e->effect];
    json_t *parameters = json_object(), *std = json_object(), *given = e->given.on ? json_object() : json_null();
    for (int key = 0; key < e->keys; key++) {
        json_object_set_new(parameters, effect->keys[key].name, legs(e->values.value[key]));
        json_object_set_new(std, effect->keys[key].name, deviations(e, key));
        if (e->given.on) json_object_set_new(given, effect->keys[key].name, legs(e->given.value[key]));
    }
    return json_pack("{ss so so so so so ss}", "name", effect->name, "parameters", parameters, "std", std, "given", given,
                     "share_explained", report_number(e->share_explained), "z", report_number(e->z), "evidence", e->evidence);
}

/* Returns a statement, with the values of its effect or of the likeliest effect of its family. */
static json_t *statement(const struct gap_statement *s) {
    const struct effect *of = effect_table[s->effect.effect];
    json_t *values = json_object(), *std = json_object();
    for (int key = 0; key < s->effect.keys; key++) {
        json_object_set_new(values, of->keys[key].name, legs(s->effect.values.value[key]));
        json_object_set_new(std, of->keys[key].name, deviations(&s->effect, key));
    }
    return json_pack("{ss ss so so ss so so}", "level", gap_statement_level(s), "name", gap_statement_name(s), "probability",
                     report_number(s->probability), "share_explained", report_number(s->share_explained), "effect", of->name, "values",
                     values, "std", std);
}

static json_t *statements(const struct gap_result *r) {
    json_t *array = json_array();
    for (int i = 0; i < r->statements; i++) json_array_append_new(array, statement(&r->statement[i]));
    return array;
}

/* Returns for each channel the rms difference beyond the noise floor on held-out data: the root of
 * the squared difference less the squared noise floor. */
static json_t *remaining(const struct gap_result *r) {
    json_t *object = json_object();
    for (int ch = 0; ch < GAP_CHANNELS; ch++) {
        double after = r->held_out_after.channel[ch], noise = r->noise_floor.channel[ch];
        double left = sqrt(fmax(after * after - noise * noise, 0.0));
        json_object_set_new(object, gap_channel_names[ch],
                            json_pack("{so ss}", "rms", report_number(isnan(after) ? after : left), "unit", gap_channel_units[ch]));
    }
    return object;
}

static json_t *place(const struct gap_place *p) {
    json_t *at_s = p->segment_s > 0.0 ? json_real(p->at_s) : json_null();
    return json_pack("{ss? so sf ss si si ss so}", "test", p->dof == DOF_NONE ? NULL : dof_names[p->dof], "at_s", at_s, "frequency_hz",
                     p->frequency_hz, "channel", gap_channel_names[p->channel], "leg", p->leg + 1, "harmonic", p->harmonic, "feature",
                     p->feature, "share", report_number(p->share));
}

static json_t *size(const struct gap_size *s) {
    json_t *object = json_pack("{so so}", "overall", report_number(s->overall), "varying", report_number(s->varying));
    for (int ch = 0; ch < GAP_CHANNELS; ch++)
        json_object_set_new(object, gap_channel_names[ch],
                            json_pack("{so so ss}", "rms", report_number(s->channel[ch]), "normalised", report_number(s->normalised[ch]),
                                      "unit", gap_channel_units[ch]));
    return object;
}

static json_t *sizes(const struct gap_result *r) {
    return json_pack("{so so so so so}", "before", size(&r->before), "after", size(&r->after), "noise_floor", size(&r->noise_floor),
                     "held_out_before", size(&r->held_out_before), "held_out_after", size(&r->held_out_after));
}

static json_t *rejected(const struct gap_result *r) {
    json_t *array = json_array();
    for (int i = 0; i < r->candidates; i++) {
        bool named = false;
        for (int j = 0; j < r->effects; j++) named = named || r->effect[j].effect == r->candidate[i].effect;
        if (named) continue;
        json_array_append_new(array, json_pack("{ss so so}", "name", effect_table[r->candidate[i].effect]->name, "share_explained",
                                               report_number(r->candidate[i].share_explained), "z", report_number(r->candidate[i].z)));
    }
    return array;
}

/* Returns the base's values: for a value of the machine one object, for a value of the legs a list
 * of six objects, with null for legs without one. */
static json_t *base(const struct gap_result *r) {
    json_t *object = json_object();
    for (int i = 0; i < r->base_values; i++) {
        const struct gap_base_value *b = &r->base[i];
        json_t *value = json_pack("{so so so sb}", "given", report_number(b->given), "value", report_number(b->value), "std",
                                  report_number(b->std), "at_bound", b->bound);
        if (b->leg < 0) {
            json_object_set_new(object, b->name, value);
            continue;
        }
        json_t *own = json_object_get(object, b->name);
        if (!own) {
            own = json_array();
            for (int leg = 0; leg < LEGS; leg++) json_array_append_new(own, json_null());
            json_object_set_new(object, b->name, own);
        }
        json_array_set_new(own, (size_t)b->leg, value);
    }
    return object;
}

static json_t *matrix(const double m[DOFS][DOFS], bool there) { return there ? report_matrix(m[0]) : json_null(); }

/* Returns four inertia matrices: measured, of the models before and after, and measured less the
 * effect of the friction found. */
static json_t *matrices(const struct gap_result *r) {
    return json_pack("{so so so so}", "measured", matrix(r->measured_mt, r->matrices), "before", matrix(r->before_mt, r->matrices), "after",
                     matrix(r->after_mt, r->matrices), "repaired", matrix(r->repaired_mt, r->repaired));
}

static json_t *tone(const struct gap_tone *l) {
    if (!(l->hz > 0.0)) return json_null();
    return json_pack("{sf sf ss ss ss}", "hz", l->hz, "rms", l->rms, "unit", gap_channel_units[l->channel], "channel",
                     gap_channel_names[l->channel], "test", dof_names[l->dof]);
}

static json_t *course(const struct gap_course *c) {
    if (!(c->ratio > 0.0)) return json_null();
    json_t *effect = c->frictions > 1 ? json_null() : json_string(effect_table[c->effect]->name);
    return json_pack("{so sf sb s{ss si} s{ss si}}", "effect", effect, "ratio", c->ratio, "at_least", c->at_least, "most", "test",
                     dof_names[c->most.dof], "number", c->most.test + 1, "least", "test", dof_names[c->least.dof], "number",
                     c->least.test + 1);
}

char *gap_json(const struct gap_result *r, const char *model) {
    json_t *effects = json_array(), *rivals = json_array(), *where = json_array();
    for (int i = 0; i < r->effects; i++) json_array_append_new(effects, effect(&r->effect[i]));
    for (int i = 0; i < r->ambiguous; i++) json_array_append_new(rivals, json_string(effect_table[r->ambiguous_with[i]]->name));
    if (r->offset_rival) json_array_append_new(rivals, json_string("constant_force_offset"));
    for (int i = 0; i < r->places; i++) json_array_append_new(where, place(&r->where[i]));
    json_t *doubted = r->ambiguous ? json_string(effect_table[r->effect[r->in_doubt].effect]->name) : json_null();
    json_t *path = json_string(model);
    /* json_string() refuses a path that is not UTF-8 */
    if (!path) path = json_string("model.yaml");
    json_t *white = json_pack("{so so}", "before", report_number(r->white_before), "after", report_number(r->white_after));
    json_t *family = gap_family_name(r)[0] ? json_string(gap_family_name(r)) : json_null();
    json_t *root = json_pack(
        "{ss ss ss so so so so so so so sb so so so so so ss so so so so so so ss so}", "schema", "hexid.gap/1", "verdict",
        gap_verdict_names[r->verdict], "reason", r->reason, "statements", statements(r), "family", family, "certainty",
        report_number(r->certainty.probability), "remainder", remaining(r), "effects", effects, "in_doubt", doubted, "ambiguous_with",
        rivals, "ambiguous_together", r->ambiguous_together, "rejected", rejected(r), "where", where, "gap", sizes(r), "mean_white_square",
        white, "unexplained_fraction", report_number(r->unexplained_fraction), "next_experiment", r->next_experiment, "base", base(r), "Mt",
        matrices(r), "line", tone(&r->tone), "course", course(&r->course), "controller_difference", report_number(r->controller_difference),
        "seconds", report_number(r->seconds), "replay", r->simulated ? "closed-loop" : "motion", "model", path);
    return report_text(root);
}
