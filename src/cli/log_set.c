#include "log_set.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "config.h"

enum { BLOCK = 1 << 16 };

/* Returns true if two regular files have the same content. */
static bool same_bytes(const char *a, const char *b) {
    char *block = malloc(2 * BLOCK);
    FILE *file[2] = {fopen(a, "rb"), fopen(b, "rb")};
    bool same = block && file[0] && file[1];
    for (size_t n = BLOCK; same && n == BLOCK;) {
        n = fread(block, 1, BLOCK, file[0]);
        same = fread(block + BLOCK, 1, BLOCK, file[1]) == n && !memcmp(block, block + BLOCK, n);
    }
    for (int i = 0; i < 2; i++)
        if (file[i]) fclose(file[i]);
    free(block);
    return same;
}

int log_set_new(int log, const char *const *path, struct error *error) {
    struct stat now, before;
    if (stat(path[log], &now) || !S_ISREG(now.st_mode)) return STATUS_OK;
    for (int i = 0; i < log; i++) {
        if (stat(path[i], &before) || !S_ISREG(before.st_mode)) continue;
        if (before.st_dev == now.st_dev && before.st_ino == now.st_ino)
            return error_set(error, STATUS_USAGE, "%.250s: given twice; name each log once", path[log]);
        if (before.st_size == now.st_size && same_bytes(path[i], path[log]))
            return error_set(error, STATUS_USAGE, "%.150s: given twice, it is a copy of %.150s; name each log once", path[log], path[i]);
    }
    return STATUS_OK;
}

int log_set_same_machine(const char *path, const struct params *params, const char *before, const struct params *params_before,
                         struct error *error) {
    static const char *const model[] = {"mechanism", "geometry", "payload", "axis", "actuator", "hydraulics", "model", NULL};
    struct config_difference d;
    if (!config_difference(params, params_before, model, &d)) return STATUS_OK;
    return error_set(error, STATUS_USAGE,
                     "%.60s: is of another machine than %.60s: %s is %.40s, and %.40s there; identify each by itself or, where it is "
                     "one machine, say which configuration is right with -c FILE",
                     path, before, d.key, d.a, d.b);
}
