#include "mechanism.h"

#include <string.h>

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
