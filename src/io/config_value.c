#include "config_keys.h"

#include <assert.h>
#include <locale.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "params.h"

static bool takes_list(enum config_kind kind) { return kind == CONFIG_AXES || kind == CONFIG_REALS || kind == CONFIG_POINTS; }

int config_key_depth(const struct config_key *key) { return key->kind == CONFIG_POINTS ? 2 : 1; }

bool config_value_add(const struct config_key *key, struct config_value *value, const char *text, size_t length) {
    int most = key->kind == CONFIG_POINTS ? CONFIG_ITEMS : LEGS;
    if (value->count == most || length >= CONFIG_ITEM_SIZE || memchr(text, '\0', length)) return false;
    memcpy(value->item[value->count++], text, length);
    return true;
}

static bool add_trimmed(const struct config_key *key, struct config_value *value, const char *text, size_t length) {
    while (length > 0 && *text == ' ') text++, length--;
    while (length > 0 && text[length - 1] == ' ') length--;
    return config_value_add(key, value, text, length);
}

/* Splits "[[x, y, z], [x, y, z], ...]" or "[]". */
static bool split_points(const struct config_key *key, const char *text, struct config_value *value) {
    size_t length = strlen(text);
    value->list = true;
    if (length < 2 || text[0] != '[' || text[length - 1] != ']') return false;
    const char *end = text + length - 1;
    for (text += 1 + strspn(text + 1, " "); text < end; text += strspn(text, " ")) {
        const char *close = memchr(text, ']', (size_t)(end - text));
        if (*text != '[' || !close) return false;
        for (int i = 0; i < 3; i++) {
            length = i < 2 ? strcspn(text + 1, ",") : (size_t)(close - text - 1);
            if (text + 1 + length > close || !add_trimmed(key, value, text + 1, length)) return false;
            text += 1 + length;
        }
        text += 1 + strspn(text + 1, " ");
        if (text < end && *text++ != ',') return false;
    }
    return true;
}

bool config_value_split(const struct config_key *key, const char *text, struct config_value *value) {
    size_t length = strlen(text);
    *value = (struct config_value){0};
    if (key->kind == CONFIG_POINTS) return split_points(key, text, value);
    if (!takes_list(key->kind)) return config_value_add(key, value, text, length);
    if (length >= 2 && text[0] == '[' && text[length - 1] == ']') text++, length -= 2;
    for (const char *end = text + length, *comma;; text = comma + 1) {
        comma = memchr(text, ',', (size_t)(end - text));
        if (!add_trimmed(key, value, text, (size_t)((comma ? comma : end) - text))) return false;
        if (!comma) return true;
        value->list = true;
    }
}

__attribute__((format(printf, 2, 3))) static bool refuse(char reason[CONFIG_REASON_SIZE], const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(reason, CONFIG_REASON_SIZE, format, args);
    va_end(args);
    return false;
}

/* Returns glibc's "C" locale, which is static, so there is nothing to free. */
static locale_t c_locale(void) { return newlocale(LC_ALL_MASK, "C", (locale_t)0); }

/* Accepts decimal notation only; strtod alone also accepts hexadecimal, "inf" and "nan". */
static bool parse_number(const char *text, double *number) {
    char *end;
    if (text[strspn(text, "0123456789+-.eE")] != '\0') return false;
    *number = strtod_l(text, &end, c_locale());
    return end != text && *end == '\0';
}

static bool parse_in_range(const struct config_key *key, const char *text, double *number, char reason[CONFIG_REASON_SIZE]) {
    char range[CONFIG_TEXT_SIZE];
    bool is_number = parse_number(text, number);
    if (is_number && *number >= key->min && *number <= key->max) return true;
    config_range_format(key, range);
    /* the meaning of an effect's key is the effect's law, too long for a message */
    if (is_number && key->effect >= 0) return refuse(reason, "%.40s is outside %.60s", text, range);
    return is_number ? refuse(reason, "%.40s is outside %.60s (%.80s)", text, range, key->meaning)
                     : refuse(reason, "\"%.40s\" is not a number; it takes one in %.60s", text, range);
}

static bool set_real(const struct config_key *key, const char *text, double *place, char reason[CONFIG_REASON_SIZE]) {
    double number;
    if (!parse_in_range(key, text, &number, reason)) return false;
    *place = number;
    return true;
}

static bool set_integer(const struct config_key *key, const char *text, int *place, char reason[CONFIG_REASON_SIZE]) {
    double number;
    if (!parse_in_range(key, text, &number, reason)) return false;
    if (number != (double)(int)number) return refuse(reason, "%.40s is not a whole number", text);
    *place = (int)number;
    return true;
}

static bool set_boolean(const char *text, bool *place, char reason[CONFIG_REASON_SIZE]) {
    bool yes = strcmp(text, "true") == 0;
    if (!yes && strcmp(text, "false") != 0) return refuse(reason, "\"%.40s\" is neither true nor false", text);
    *place = yes;
    return true;
}

/* Returns the index of the name, or -1 with the reason. */
static int find_name(const struct config_key *key, const char *text, char reason[CONFIG_REASON_SIZE]) {
    char range[CONFIG_TEXT_SIZE];
    for (int i = 0; key->names[i]; i++)
        if (strcmp(key->names[i], text) == 0) return i;
    config_range_format(key, range);
    refuse(reason, "\"%.40s\" is none of %.80s", text, range);
    return -1;
}

static bool set_choice(const struct config_key *key, const char *text, enum engine_kind *place, char reason[CONFIG_REASON_SIZE]) {
    int found = find_name(key, text, reason);
    if (found < 0) return false;
    *place = (enum engine_kind)found;
    return true;
}

static bool set_text(const char *text, char place[CONFIG_ITEM_SIZE], char reason[CONFIG_REASON_SIZE]) {
    for (const char *c = text; *c; c++)
        if (*c < ' ' || *c > '~') return refuse(reason, "holds a character that is not printable ASCII");
    /* copies the zeros after the text, too, because equal params must have equal bytes */
    memcpy(place, text, CONFIG_ITEM_SIZE);
    return true;
}

static bool set_axes(const struct config_key *key, const struct config_value *value, struct test_params *tests,
                     char reason[CONFIG_REASON_SIZE]) {
    enum dof order[DOFS] = {DOF_NONE, DOF_NONE, DOF_NONE, DOF_NONE, DOF_NONE, DOF_NONE};
    bool used[DOFS] = {false};
    for (int i = 0; i < value->count; i++) {
        int axis = find_name(key, value->item[i], reason);
        if (axis < 0) return false;
        if (used[axis]) return refuse(reason, "%s is listed twice", key->names[axis]);
        used[axis] = true;
        order[i] = (enum dof)axis;
    }
    memcpy(tests->order, order, sizeof order);
    tests->count = value->count;
    return true;
}

static bool set_reals(const struct config_key *key, const struct config_value *value, double *place, char reason[CONFIG_REASON_SIZE]) {
    double number[LEGS];
    if (value->list && value->count != key->count)
        return refuse(reason, "a list of %d; it takes one value for all, or %d", value->count, key->count);
    for (int i = 0; i < key->count; i++)
        if (!parse_in_range(key, value->item[value->list ? i : 0], &number[i], reason)) return false;
    memcpy(place, number, (size_t)key->count * sizeof *number);
    return true;
}

static bool set_points(const struct config_key *key, const struct config_value *value, struct leg_vectors *place,
                       char reason[CONFIG_REASON_SIZE]) {
    struct leg_vectors points = {.given = value->count > 0};
    if (!value->list || (points.given && value->count != 3 * key->count))
        return refuse(reason, "%d numbers; it takes %d times [x, y, z], [[x, y, z], ...], or [] for none", value->count, key->count);
    for (int i = 0; i < value->count; i++)
        if (!parse_in_range(key, value->item[i], &points.leg[i / 3][i % 3], reason)) return false;
    memcpy(place, &points, sizeof points);
    return true;
}

/* Returns the offset of the flag that is true if the key is stated; 0: the key has no such flag. */
static size_t stated_at(const struct config_key *key) {
    if (key->offset == offsetof(struct params, actuator.piston_diameter_m)) return offsetof(struct params, actuator.stated.piston);
    if (key->offset == offsetof(struct params, actuator.rod_diameter_m)) return offsetof(struct params, actuator.stated.rod);
    return 0;
}

bool config_is_stated(const struct config_key *key, const struct params *params) {
    size_t at = stated_at(key);
    return !at || *(const bool *)((const char *)params + at);
}

void config_keep_stated(const struct config_key *key, struct params *params, bool stated) {
    size_t at = stated_at(key);
    if (at) *(bool *)((char *)params + at) = stated;
}

bool config_value_set(const struct config_key *key, const struct config_value *value, struct params *params,
                      char reason[CONFIG_REASON_SIZE]) {
    void *place = (char *)params + key->offset;
    const char *text = value->item[0];
    if (value->list && !takes_list(key->kind)) return refuse(reason, "a list; it takes a single value");
    if (value->count == 0 && key->kind != CONFIG_POINTS) return refuse(reason, "an empty list; it takes at least one value");
    switch (key->kind) {
    case CONFIG_REAL: return set_real(key, text, place, reason);
    case CONFIG_INTEGER: return set_integer(key, text, place, reason);
    case CONFIG_BOOLEAN: return set_boolean(text, place, reason);
    case CONFIG_CHOICE: return set_choice(key, text, place, reason);
    case CONFIG_TEXT: return set_text(text, place, reason);
    case CONFIG_AXES: return set_axes(key, value, &params->tests, reason);
    case CONFIG_POINTS: return set_points(key, value, place, reason);
    case CONFIG_REALS:
    case CONFIG_REALS_ALIKE: break;
    }
    if (!set_reals(key, value, place, reason)) return false;
    if (key->effect >= 0) params->effects[key->effect].on = true;
    config_keep_stated(key, params, true);
    return true;
}

/* Writes a decimal point before any exponent, because other readers of YAML 1.1 take "5e-05" for a
 * word. */
static int format_number(double number, char *text, size_t size) {
    char plain[32];
    locale_t before = uselocale(c_locale());
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(plain, sizeof plain, "%.*g", digits, number);
        if (strtod(plain, NULL) == number) break;
    }
    uselocale(before);
    size_t mantissa = strcspn(plain, "e");
    bool point = plain[mantissa] == '\0' || memchr(plain, '.', mantissa);
    return snprintf(text, size, "%.*s%s%s", (int)mantissa, plain, point ? "" : ".0", plain + mantissa);
}

static void format_reals(int count, const double *number, char text[CONFIG_TEXT_SIZE]) {
    bool alike = true;
    for (int i = 1; i < count; i++) alike = alike && memcmp(&number[i], &number[0], sizeof number[0]) == 0;
    if (alike) {
        format_number(number[0], text, CONFIG_TEXT_SIZE);
        return;
    }
    size_t used = 0;
    for (int i = 0; i < count; i++) {
        used += (size_t)snprintf(text + used, CONFIG_TEXT_SIZE - used, i ? ", " : "[");
        used += (size_t)format_number(number[i], text + used, CONFIG_TEXT_SIZE - used);
    }
    snprintf(text + used, CONFIG_TEXT_SIZE - used, "]");
}

static void format_points(int count, const struct leg_vectors *points, char text[CONFIG_TEXT_SIZE]) {
    size_t used = (size_t)snprintf(text, CONFIG_TEXT_SIZE, "[");
    for (int i = 0; i < (points->given ? 3 * count : 0); i++) {
        used += (size_t)snprintf(text + used, CONFIG_TEXT_SIZE - used, "%s", i % 3 ? ", " : i ? "], [" : "[");
        used += (size_t)format_number(points->leg[i / 3][i % 3], text + used, CONFIG_TEXT_SIZE - used);
    }
    snprintf(text + used, CONFIG_TEXT_SIZE - used, points->given ? "]]" : "]");
}

static void format_quoted(const char *from, char text[CONFIG_TEXT_SIZE]) {
    *text++ = '"';
    for (; *from; from++) {
        if (*from == '"' || *from == '\\') *text++ = '\\';
        *text++ = *from;
    }
    *text++ = '"';
    *text = '\0';
}

static void format_axes(const struct config_key *key, const struct test_params *tests, char text[CONFIG_TEXT_SIZE]) {
    size_t used = (size_t)snprintf(text, CONFIG_TEXT_SIZE, "[");
    for (int i = 0; i < tests->count; i++)
        used += (size_t)snprintf(text + used, CONFIG_TEXT_SIZE - used, "%s%s", i ? ", " : "", key->names[tests->order[i]]);
    snprintf(text + used, CONFIG_TEXT_SIZE - used, "]");
}

void config_value_format(const struct config_key *key, const struct params *params, char text[CONFIG_TEXT_SIZE]) {
    const void *place = (const char *)params + key->offset;
    switch (key->kind) {
    case CONFIG_REAL: format_number(*(const double *)place, text, CONFIG_TEXT_SIZE); break;
    case CONFIG_INTEGER: snprintf(text, CONFIG_TEXT_SIZE, "%d", *(const int *)place); break;
    case CONFIG_BOOLEAN: snprintf(text, CONFIG_TEXT_SIZE, *(const bool *)place ? "true" : "false"); break;
    case CONFIG_CHOICE: snprintf(text, CONFIG_TEXT_SIZE, "%s", key->names[*(const enum engine_kind *)place]); break;
    case CONFIG_TEXT: format_quoted(place, text); break;
    case CONFIG_AXES: format_axes(key, &params->tests, text); break;
    case CONFIG_POINTS: format_points(key->count, place, text); break;
    case CONFIG_REALS:
    case CONFIG_REALS_ALIKE: format_reals(key->count, place, text); break;
    }
}

void config_range_format(const struct config_key *key, char text[CONFIG_TEXT_SIZE]) {
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; key->names && key->names[i]; i++)
        used += (size_t)snprintf(text + used, CONFIG_TEXT_SIZE - used, "%s%s", i ? ", " : "", key->names[i]);
    const char *unit = strcmp(key->unit, "-") == 0 ? "" : key->unit;
    if (key->kind == CONFIG_BOOLEAN) snprintf(text, CONFIG_TEXT_SIZE, "true, false");
    else if (key->kind == CONFIG_TEXT) snprintf(text, CONFIG_TEXT_SIZE, "text");
    else if (!key->names) {
        used = (size_t)format_number(key->min, text, CONFIG_TEXT_SIZE);
        used += (size_t)snprintf(text + used, CONFIG_TEXT_SIZE - used, "..");
        used += (size_t)format_number(key->max, text + used, CONFIG_TEXT_SIZE - used);
        snprintf(text + used, CONFIG_TEXT_SIZE - used, "%s%s", *unit ? " " : "", unit);
    }
}
