#include "config.h"

#include <string.h>

#include "config_keys.h"

static bool within(const char *path, const char *const *sections) {
    for (; *sections; sections++) {
        size_t length = strlen(*sections);
        if (!strncmp(path, *sections, length) && (path[length] == '.' || !path[length])) return true;
    }
    return false;
}

bool config_difference(const struct params *a, const struct params *b, const char *const *sections, struct config_difference *difference) {
    struct config_key key;
    char of_a[CONFIG_TEXT_SIZE], of_b[CONFIG_TEXT_SIZE];
    for (int i = 0; config_key_at(i, &key); i++) {
        if (!within(key.path, sections)) continue;
        config_value_format(&key, a, of_a);
        config_value_format(&key, b, of_b);
        if (!strcmp(of_a, of_b)) continue;
        snprintf(difference->key, sizeof difference->key, "%s", key.path);
        snprintf(difference->a, sizeof difference->a, "%.60s", of_a);
        snprintf(difference->b, sizeof difference->b, "%.60s", of_b);
        return true;
    }
    return false;
}
