#include <string.h>

#include "backends.h"

const struct hal_ops *const hal_table[] = {&hal_sim, &hal_can, &hal_modbus, &hal_fault, NULL};

const struct hal_ops *hal_find(const char *url) {
    for (int i = 0; hal_table[i]; i++) {
        size_t length = strlen(hal_table[i]->scheme);
        if (!strncmp(url, hal_table[i]->scheme, length) && url[length] == ':') return hal_table[i];
    }
    return NULL;
}

int hal_open(struct hal **hal, const char *url, const struct params *params, uint64_t seed, struct error *error) {
    const struct hal_ops *ops = hal_find(url);
    if (!ops) return error_set(error, STATUS_USAGE, "--hal %s: no such back-end; `hexid run --help` lists them", url);
    return ops->open(hal, url + strlen(ops->scheme) + 1, params, seed, error);
}
