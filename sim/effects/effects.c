#include "effects.h"

#include <stddef.h>
#include <string.h>

#define EFFECT_POINTER(name) &name,
const struct effect *const effect_table[] = {EFFECT_LIST(EFFECT_POINTER) NULL};

_Static_assert(sizeof effect_table / sizeof *effect_table <= EFFECTS_MAX + 1, "params.effects has no room for the whole catalogue");

int effect_find(const char *name) {
    for (int i = 0; effect_table[i]; i++)
        if (strcmp(effect_table[i]->name, name) == 0) return i;
    return -1;
}
