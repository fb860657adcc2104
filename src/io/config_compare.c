#include "config.h"

#include <string.h>

#include "config_keys.h"
#include "gains.h"
#include "params.h"

bool config_key_within(const char *path, const char *const *sections) {
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
        if (!config_key_within(key.path, sections)) continue;
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

static bool is_gain(const char *path) {
    for (int i = 0; i < LOOP_GAINS; i++)
        if (!strcmp(path, gain_keys[i])) return true;
    return false;
}

/* Continues an FNV-1a hash with a text and its final zero, which separates it from the next one. */
static uint64_t add_text(uint64_t hash, const char *text) {
    for (const char *c = text;; c++) {
        hash = (hash ^ (unsigned char)*c) * 0x100000001b3u;
        if (!*c) return hash;
    }
}

uint64_t config_digest(const struct params *params) {
    static const char *const sections[] = {"mechanism",
                                           "geometry",
                                           "payload",
                                           "actuator",
                                           "hydraulics",
                                           "sensors",
                                           "control",
                                           "loop.period_s",
                                           "motion.park_z_m",
                                           "motion.engage_s",
                                           "motion.park_s",
                                           "motion.rate_mps",
                                           "tests.frequency_hz",
                                           "tests.amplitude_m",
                                           "tests.amplitude_rad",
                                           "limits.following_m",
                                           "limits.length_min_m",
                                           "limits.length_max_m",
                                           "limits.oscillation_mps2",
                                           "effects",
                                           NULL};
    uint64_t hash = 0xcbf29ce484222325u;
    struct config_key key;
    char value[CONFIG_TEXT_SIZE];
    for (int i = 0; config_key_at(i, &key); i++) {
        if (!config_key_within(key.path, sections) || is_gain(key.path) || (key.effect >= 0 && !params->effects[key.effect].on)) continue;
        config_value_format(&key, params, value);
        hash = add_text(add_text(hash, key.path), value);
    }
    return hash;
}

/* Compares the keys that matter for pressures and commands. */
void config_defaults(const struct params *params, char text[CONFIG_DEFAULTS_SIZE]) {
    static const char *const geometry[] = {"geometry", NULL};
    static const char *const diameters[] = {"actuator.piston_diameter_m", "actuator.rod_diameter_m", NULL};
    static const char *const oil[] = {"hydraulics.supply_pa",          "hydraulics.valve_flow_m3_per_s", "hydraulics.valve_drop_pa",
                                      "hydraulics.valve_frequency_hz", "hydraulics.valve_damping",       "hydraulics.bulk_modulus_pa",
                                      "hydraulics.dead_volume_m3",     "hydraulics.leakage_m3_per_s_pa", NULL};
    struct params built_in;
    struct config_key key;
    struct config_difference difference;
    char own[CONFIG_TEXT_SIZE], theirs[CONFIG_TEXT_SIZE];
    bool default_machine = params_mechanism(params)->default_machine;
    size_t used = 0;
    text[0] = '\0';
    config_default(&built_in);
    /* other directions of the joints' axes make no other machine, since pressures do not depend on
     * them */
    built_in.geometry.upper_axis = params->geometry.upper_axis, built_in.geometry.lower_axis = params->geometry.lower_axis;
    if (default_machine && !config_difference(params, &built_in, geometry, &difference)) return;
    for (int i = 0; config_key_at(i, &key); i++) {
        /* another mechanism has no default diameters (areas.h) */
        if (!config_key_within(key.path, oil) && (!default_machine || !config_key_within(key.path, diameters))) continue;
        config_value_format(&key, params, own);
        config_value_format(&key, &built_in, theirs);
        if (!strcmp(own, theirs))
            used += (size_t)snprintf(text + used, CONFIG_DEFAULTS_SIZE - used, "%s%s %s", used ? ", " : "", key.path, key.value);
    }
}
