#include <string.h>

#include "cli.h"

static void print_effect(const struct effect *e) {
    printf("%s\n    law        %s\n    signature  %s\n", e->name, e->law, e->signature);
    for (int k = 0; k < EFFECT_KEYS && e->keys[k].name; k++) {
        const struct effect_key *key = &e->keys[k];
        printf("    %-10s %s [%s] %g..%g, %s %g%s\n", k ? "" : "keys", key->name, key->unit, key->min, key->max,
               key->typical == key->neutral ? "usually" : "adds nothing at", key->neutral, key->per_leg ? ", one number or one a leg" : "");
    }
    printf("    on by      hexid run --fast");
    for (int k = 0; k < EFFECT_KEYS && e->keys[k].name; k++)
        if (e->keys[k].typical != e->keys[k].neutral) printf(" --set effects.%s.%s=%g", e->name, e->keys[k].name, e->keys[k].typical);
    puts("");
}

int cmd_effects(int argc, char **argv) {
    struct options o;
    struct error error;
    if (options_parse(&o, argc, argv, "", 1, &error)) return cli_fail(&error);
    if (o.operands && effect_find(o.operand[0]) < 0) {
        error_set(&error, STATUS_USAGE, "effects %s: no such effect; `hexid effects` lists them", o.operand[0]);
        return cli_fail(&error);
    }
    for (int i = 0; effect_table[i]; i++)
        if (!o.operands || !strcmp(o.operand[0], effect_table[i]->name)) print_effect(effect_table[i]);
    return EXIT_PASSED;
}
