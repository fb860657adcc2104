#include "mechanism.h"

#include <string.h>

#include "params.h"

const struct mechanism *const mechanism_table[] = {
    [MECHANISM_STEWART] = &mechanism_stewart,
    [MECHANISM_AXIS] = &mechanism_axis,
    NULL,
};

const char *const mechanism_names[] = {
    [MECHANISM_STEWART] = mechanism_stewart.name,
    [MECHANISM_AXIS] = mechanism_axis.name,
    NULL,
};

int mechanism_find(const char *name) {
    for (int i = 0; mechanism_names[i]; i++)
        if (strcmp(mechanism_names[i], name) == 0) return i;
    return -1;
}

const struct mechanism *params_mechanism(const struct params *params) { return mechanism_table[params->mechanism]; }
int params_legs(const struct params *params) { return params_mechanism(params)->legs; }
