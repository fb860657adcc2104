#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "edit_distance.h"
#include "effect.h"
#include "output.h"

static void print_effect(const struct effect *e) {
    printf("%s\n    is         %s\n    law        %s\n    signature  %s\n", e->name, e->plain, e->law, e->signature);
    for (int k = 0; k < EFFECT_KEYS && e->keys[k].name; k++) {
        const struct effect_key *key = &e->keys[k];
        printf("    %-10s %s [%s] %g..%g, %s %g%s\n", k ? "" : "keys", key->name, key->unit, key->min, key->max,
               key->shapes_law ? "usually" : "adds nothing at", key->neutral, key->per_leg ? ", one number or one a leg" : "");
    }
    printf("    on by      hexid run --fast");
    for (int k = 0; k < EFFECT_KEYS && e->keys[k].name; k++)
        if (e->keys[k].typical != e->keys[k].neutral) printf(" --set effects.%s.%s=%g", e->name, e->keys[k].name, e->keys[k].typical);
    puts("");
}

static json_t *effect_json(const struct effect *e) {
    json_t *keys = json_array();
    for (int k = 0; k < EFFECT_KEYS && e->keys[k].name; k++) {
        const struct effect_key *key = &e->keys[k];
        json_array_append_new(keys, json_pack("{ss ss sf sf sf sf sb sb}", "name", key->name, "unit", key->unit, "min", key->min, "max",
                                              key->max, "neutral", key->neutral, "typical", key->typical, "per_leg", key->per_leg,
                                              "reciprocal", key->reciprocal));
    }
    return json_pack("{ss ss ss ss ss so}", "name", e->name, "family", effect_families[e->family].name, "plain", e->plain, "law", e->law,
                     "signature", e->signature, "keys", keys);
}

static int write_json(const struct options *o, struct error *error) {
    json_t *effects = json_array();
    for (int i = 0; effect_table[i]; i++)
        if (!o->operands || !strcmp(o->operand[0], effect_table[i]->name)) json_array_append_new(effects, effect_json(effect_table[i]));
    json_t *root = json_pack("{ss so}", "schema", "hexid.effects/1", "effects", effects);
    char *text = root ? json_dumps(root, JSON_INDENT(1)) : NULL;
    int status = output_text(o->json, text, error);
    free(text);
    json_decref(root);
    return status;
}

static const char *effect_name(int i) { return effect_table[i] ? effect_table[i]->name : NULL; }

int cmd_effects(int argc, char **argv) {
    struct options o;
    struct error error;
    if (options_parse(&o, argc, argv, "j", 1, &error)) return cli_fail(&error);
    if (o.operands && effect_find(o.operand[0]) < 0) {
        const char *nearest = edit_nearest(o.operand[0], effect_name);
        error_set(&error, STATUS_USAGE, "effects %.100s: no such effect; %s%s%s`hexid effects` lists them", o.operand[0],
                  nearest ? "did you mean " : "", nearest ? nearest : "", nearest ? "? " : "");
        return cli_fail(&error);
    }
    if (o.json) return write_json(&o, &error) ? cli_fail(&error) : EXIT_PASSED;
    for (int i = 0; effect_table[i]; i++)
        if (!o.operands || !strcmp(o.operand[0], effect_table[i]->name)) print_effect(effect_table[i]);
    return EXIT_PASSED;
}
