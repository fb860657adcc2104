#include "config.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

#include "config_keys.h"
#include "input.h"
#include "params.h"

enum { FILE_MAX = 1 << 20, NAMES_MAX = 512 };

/* Reads YAML event by event, not as a document: aliases, tags and excess levels are refused at
 * once, before they can use memory. */
struct reader {
    yaml_parser_t parser;
    const char *name, *text;
    struct params *params;
    struct error *error;
    int count;
    struct {
        char path[CONFIG_PATH_SIZE];
        size_t line;
    } names[NAMES_MAX]; /* keys and sections met so far; the table is large enough, because each
                         * known key and section is accepted only once, and no other is */
};

/* Formats "name:line: reason", without the line if it is 0. The reason may quote any byte of the
 * file, so control characters are replaced for the terminal. */
__attribute__((format(printf, 4, 5))) static int fail(struct error *error, const char *name, size_t line, const char *format, ...) {
    char place[24] = "", reason[320];
    va_list args;
    va_start(args, format);
    vsnprintf(reason, sizeof reason, format, args);
    va_end(args);
    if (line > 0) snprintf(place, sizeof place, ":%zu", line);
    error_set(error, STATUS_USAGE, "%.160s%s: %s", name, place, reason);
    for (char *c = error->text; *c; c++)
        if (iscntrl((unsigned char)*c)) *c = '?';
    return STATUS_USAGE;
}

static int fail_yaml(struct reader *r) {
    const yaml_parser_t *p = &r->parser;
    size_t line = p->problem_mark.line + 1;
    if (p->error == YAML_MEMORY_ERROR) return fail(r->error, r->name, line, "out of memory");
    if (p->error == YAML_READER_ERROR) { /* libyaml states only the byte where it found the error */
        line = 1;
        for (size_t i = 0; i < p->problem_offset; i++) line += r->text[i] == '\n';
        return fail(r->error, r->name, line, "%s; save the file as UTF-8 text", p->problem);
    }
    return fail(r->error, r->name, line, "not YAML: %s; write \"key: value\" lines, indented with spaces", p->problem);
}

static bool decorated(const yaml_event_t *e) {
    switch (e->type) {
    case YAML_ALIAS_EVENT: return true;
    case YAML_SCALAR_EVENT: return e->data.scalar.anchor || e->data.scalar.tag;
    case YAML_SEQUENCE_START_EVENT: return e->data.sequence_start.anchor || e->data.sequence_start.tag;
    case YAML_MAPPING_START_EVENT: return e->data.mapping_start.anchor || e->data.mapping_start.tag;
    default: return false;
    }
}

/* Reads the next event, which the caller deletes. */
static int next_event(struct reader *r, yaml_event_t *e) {
    if (!yaml_parser_parse(&r->parser, e)) return fail_yaml(r);
    if (!decorated(e)) return STATUS_OK;
    size_t line = e->start_mark.line + 1;
    yaml_event_delete(e);
    return fail(r->error, r->name, line, "anchors, aliases and tags (& * !) are not used here; write the value itself");
}

static int fail_unknown(struct error *error, const char *name, size_t line, const char *path) {
    char nearest[CONFIG_PATH_SIZE];
    config_key_nearest(path, nearest);
    if (nearest[0]) return fail(error, name, line, "unknown key %.80s; did you mean %s?", path, nearest);
    return fail(error, name, line, "unknown key %.80s; `hexid run --print-config` prints all keys", path);
}

static int read_mapping(struct reader *r, const char *prefix);

/* Reads the value of a section: keys, or nothing (all keys commented out). */
static int read_section(struct reader *r, const char *path, size_t line) {
    yaml_event_t e;
    int status = next_event(r, &e);
    if (status != STATUS_OK) return status;
    bool keys = e.type == YAML_MAPPING_START_EVENT, nothing = e.type == YAML_SCALAR_EVENT && e.data.scalar.length == 0;
    yaml_event_delete(&e);
    if (!keys && !nothing) return fail(r->error, r->name, line, "%s holds keys; write them indented below it", path);
    if (keys && (status = read_mapping(r, path)) != STATUS_OK) return status;
    const char *dot = strchr(path, '.');
    bool effect = !strncmp(path, "effects.", strlen("effects."));
    /* an effect named without a key is probably an oversight */
    if (effect && !r->params->effects[effect_find(dot + 1)].on)
        return fail(r->error, r->name, line, "%s has no key, so it stays off; set one (`hexid effects %s`) or delete the line", path,
                    dot + 1);
    return STATUS_OK;
}

static int add_scalar(struct reader *r, const struct config_key *key, const yaml_event_t *e, struct config_value *value) {
    size_t line = e->start_mark.line + 1;
    if (e->type != YAML_SCALAR_EVENT) return fail(r->error, r->name, line, "%s takes a value, not keys or a list of lists", key->path);
    if (config_value_add(key, value, (const char *)e->data.scalar.value, e->data.scalar.length)) return STATUS_OK;
    return fail(r->error, r->name, line, "%s: at most %d %s, each number shorter than %d characters", key->path, LEGS,
                config_key_depth(key) == 2 ? "points of three coordinates" : "values", CONFIG_ITEM_SIZE);
}

/* Reads a value: a scalar, a list of scalars, or a list of points. */
static int read_items(struct reader *r, const struct config_key *key, struct config_value *value) {
    int depth = 0, begun = 0; /* begun: number of values before the current point */
    do {
        yaml_event_t e;
        int status = next_event(r, &e);
        if (status != STATUS_OK) return status;
        size_t line = e.start_mark.line + 1;
        bool begin = e.type == YAML_SEQUENCE_START_EVENT && depth < config_key_depth(key), end = e.type == YAML_SEQUENCE_END_EVENT;
        /* in a list of points, coordinates stand only inside points */
        bool point = depth == 2 || (begin && depth == 1) || (end && depth == 1);
        if (depth > 0 && config_key_depth(key) == 2 && (!point || (end && depth == 2 && value->count != begun + 3)))
            status = fail(r->error, r->name, line, "%s takes points, [[x, y, z], ...], or [] for none", key->path);
        else if (!begin && !end) status = add_scalar(r, key, &e, value);
        if (begin) begun = value->count;
        value->list = value->list || begin;
        depth += begin - end;
        yaml_event_delete(&e);
        if (status != STATUS_OK) return status;
    } while (depth > 0);
    return STATUS_OK;
}

static int read_value(struct reader *r, const struct config_key *key, size_t line) {
    struct config_value value = {0};
    char reason[CONFIG_REASON_SIZE];
    int status = read_items(r, key, &value);
    if (status != STATUS_OK) return status;
    if (config_value_set(key, &value, r->params, reason)) return STATUS_OK;
    return fail(r->error, r->name, line, "%s: %s", key->path, reason);
}

/* Refuses a key that was given before, because the later value would silently win. */
static int remember(struct reader *r, const char *path, size_t line) {
    for (int i = 0; i < r->count; i++)
        if (strcmp(r->names[i].path, path) == 0)
            return fail(r->error, r->name, line, "%s stands already in line %zu; delete one of them", path, r->names[i].line);
    if (r->count == NAMES_MAX) return fail(r->error, r->name, line, "more keys than there can be");
    snprintf(r->names[r->count].path, CONFIG_PATH_SIZE, "%s", path);
    r->names[r->count++].line = line;
    return STATUS_OK;
}

static int read_entry(struct reader *r, const char *path, size_t line) {
    struct config_key key;
    bool is_key = config_key_find(path, &key);
    if (!is_key && !config_section_title(path)) return fail_unknown(r->error, r->name, line, path);
    int status = remember(r, path, line);
    if (status != STATUS_OK) return status;
    return is_key ? read_value(r, &key, line) : read_section(r, path, line);
}

/* Reads entries up to the end of the mapping; their paths are prefix.name. Only known sections
 * open a level, so the depth is limited to effects.<name>.<key>. */
static int read_mapping(struct reader *r, const char *prefix) {
    for (;;) {
        yaml_event_t e;
        int status = next_event(r, &e);
        if (status != STATUS_OK) return status;
        const char *word = e.type == YAML_SCALAR_EVENT ? (const char *)e.data.scalar.value : "";
        bool name = *word && strlen(word) == e.data.scalar.length, end = e.type == YAML_MAPPING_END_EVENT;
        size_t line = e.start_mark.line + 1;
        char path[CONFIG_PATH_SIZE]; /* if truncated, the path is still longer than any key */
        snprintf(path, sizeof path, "%s%s%s", prefix, *prefix ? "." : "", word);
        yaml_event_delete(&e);
        if (end) return STATUS_OK;
        status = name ? read_entry(r, path, line) : fail(r->error, r->name, line, "a key is a plain word before a colon");
        if (status != STATUS_OK) return status;
    }
}

/* Fails with the message `otherwise` unless the next event is of this type. */
static int expect(struct reader *r, yaml_event_type_t type, const char *otherwise) {
    yaml_event_t e;
    int status = next_event(r, &e);
    if (status != STATUS_OK) return status;
    bool good = e.type == type;
    size_t line = e.start_mark.line + 1;
    yaml_event_delete(&e);
    return good ? STATUS_OK : fail(r->error, r->name, line, "%s", otherwise);
}

static int read_stream(struct reader *r) {
    static const char empty[] = "holds no configuration; write sections with keys, such as `hexid run --print-config` prints";
    int status;
    if ((status = expect(r, YAML_STREAM_START_EVENT, empty)) != STATUS_OK) return status;
    if ((status = expect(r, YAML_DOCUMENT_START_EVENT, empty)) != STATUS_OK) return status;
    if ((status = expect(r, YAML_MAPPING_START_EVENT, empty)) != STATUS_OK) return status;
    if ((status = read_mapping(r, "")) != STATUS_OK) return status;
    if ((status = expect(r, YAML_DOCUMENT_END_EVENT, empty)) != STATUS_OK) return status;
    return expect(r, YAML_STREAM_END_EVENT, "a second document begins here; a configuration is one");
}

static bool met(const struct reader *r, const char *path) {
    bool is = false;
    for (int i = 0; i < r->count && !is; i++) is = !strcmp(r->names[i].path, path);
    return is;
}

/* Records which diameters the text states. With the mechanism of the built-in configuration all
 * diameters count as stated, and nothing changes. */
static void forget_unstated(struct reader *r) {
    struct config_key key;
    for (int i = 0; !params_mechanism(r->params)->default_machine && config_key_at(i, &key); i++)
        config_keep_stated(&key, r->params, met(r, key.path));
}

/* Reads a configuration. *stated returns whether the text has `key`; it is false if key is NULL.
 * SAFETY: the reader is on the heap, because it is too large for the stack if `command stop` runs
 * under a low stack limit. */
static int read_keys(struct params *params, const char *text, size_t size, const char *name, const char *key, bool *stated,
                     struct error *error) {
    if (size > FILE_MAX) return fail(error, name, 0, "larger than %d bytes: this is no configuration", FILE_MAX);
    struct reader *r = calloc(1, sizeof *r);
    if (!r || !yaml_parser_initialize(&r->parser)) {
        free(r);
        return fail(error, name, 0, "out of memory");
    }
    r->name = name, r->text = text, r->params = params, r->error = error;
    yaml_parser_set_encoding(&r->parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&r->parser, (const unsigned char *)text, size);
    int status = read_stream(r);
    if (!status) forget_unstated(r);
    *stated = !status && key && met(r, key);
    yaml_parser_delete(&r->parser);
    free(r);
    return status;
}

static int read_text(struct params *params, const char *text, size_t size, const char *name, struct error *error) {
    bool unused;
    return read_keys(params, text, size, name, NULL, &unused, error);
}

bool config_states(const char *text, size_t size, const char *key) {
    struct params *params = malloc(sizeof *params);
    struct error unreadable;
    bool stated = false;
    if (params) config_default(params), read_keys(params, text, size, "", key, &stated, &unreadable);
    free(params);
    return stated;
}

static int read_file(struct params *params, const char *path, struct error *error) {
    const char *reason;
    int descriptor = input_open(path, &reason);
    FILE *file = descriptor < 0 ? NULL : fdopen(descriptor, "rb");
    if (!file) return fail(error, path, 0, "cannot be read: %s", descriptor < 0 ? reason : "out of memory");
    char *text = malloc(FILE_MAX + 1);
    size_t size = text ? fread(text, 1, FILE_MAX + 1, file) : 0;
    int status = !text          ? fail(error, path, 0, "out of memory")
                 : ferror(file) ? fail(error, path, 0, "cannot be read: %s", strerror(errno))
                                : read_text(params, text, size, path, error);
    free(text);
    fclose(file);
    return status;
}

static int apply_setting(struct params *params, const char *setting, struct error *error) {
    char name[120], path[CONFIG_PATH_SIZE], reason[CONFIG_REASON_SIZE];
    struct config_key key;
    struct config_value value;
    size_t length = strcspn(setting, "=");
    snprintf(name, sizeof name, "--set %s", setting);
    snprintf(path, sizeof path, "%.*s", (int)(length < sizeof path ? length : sizeof path - 1), setting);
    if (!setting[length]) return fail(error, name, 0, "no value; write --set KEY=VALUE");
    if (config_section_title(path)) return fail(error, name, 0, "%s holds keys; write --set %s.KEY=VALUE", path, path);
    if (!config_key_find(path, &key)) return fail_unknown(error, name, 0, path);
    if (!config_value_split(&key, setting + length + 1, &value))
        return fail(error, name, 0,
                    config_key_depth(&key) == 2
                        ? "points are written [[x, y, z], ...], at most %d of them, each number shorter than %d characters"
                        : "at most %d values, each shorter than %d characters",
                    LEGS, CONFIG_ITEM_SIZE);
    return config_value_set(&key, &value, params, reason) ? STATUS_OK : fail(error, name, 0, "%s", reason);
}

int config_load(struct params *params, const char *path, const char *const *settings, int count, struct error *error) {
    config_default(params);
    int status = path ? read_file(params, path, error) : STATUS_OK;
    return status == STATUS_OK ? config_override(params, path ? path : "default configuration", settings, count, error) : status;
}

static int apply_settings(struct params *params, const char *const *settings, int count, struct error *error) {
    int status = STATUS_OK;
    for (int i = 0; i < count && status == STATUS_OK; i++) status = apply_setting(params, settings[i], error);
    return status;
}

int config_override(struct params *params, const char *name, const char *const *settings, int count, struct error *error) {
    char source[160];
    bool default_machine = params_mechanism(params)->default_machine;
    int status = apply_settings(params, settings, count, error);
    if (!status && default_machine && !params_mechanism(params)->default_machine) {
        /* diameters of the default machine do not suit another mechanism; the settings are applied
         * again, so that diameters among them count in any order */
        params->actuator.stated.piston = params->actuator.stated.rod = false;
        status = apply_settings(params, settings, count, error);
    }
    snprintf(source, sizeof source, "%.140s%s", name, count > 0 ? " with --set" : "");
    return status == STATUS_OK ? config_check(params, source, error) : status;
}

bool config_sets(const char *const *settings, int count, const char *key) {
    size_t length = strlen(key);
    for (int i = 0; i < count; i++)
        if (!strncmp(settings[i], key, length) && settings[i][length] == '=') return true;
    return false;
}

/* Takes the keys of section `tests` from a text into params; a text that is no configuration
 * changes nothing. */
static int read_tests(struct params *params, const char *text, size_t size, const char *name, struct error *error) {
    struct params *whole = malloc(sizeof *whole);
    if (!whole) return fail(error, name, 0, "out of memory");
    *whole = *params;
    int status = read_text(whole, text, size, name, error);
    if (status == STATUS_OK) params->tests = whole->tests;
    free(whole);
    return status;
}

/* Makes the checks of config_check(), but with the smallest amplitudes that the key allows, so that
 * none is refused as out of the machine's reach: a recorded motion was reached. */
static int check_recorded(const struct params *params, const char *name, struct error *error) {
    struct params *still = malloc(sizeof *still);
    struct config_key key;
    if (!still) return fail(error, name, 0, "out of memory");
    *still = *params;
    config_key_find("tests.amplitude_m", &key);
    for (int i = 0; i < DOFS; i++) still->tests.amplitude[i] = key.min;
    int status = config_check(still, name, error);
    free(still);
    return status;
}

int config_take_tests(struct params *params, const char *text, size_t size, const char *name, const char *const *settings, int count,
                      struct error *unreadable, struct error *error) {
    static const char section[] = "tests.";
    unreadable->text[0] = '\0';
    if (text) read_tests(params, text, size, name, unreadable);
    for (int i = 0; i < count; i++) {
        int status = strncmp(settings[i], section, sizeof section - 1) ? STATUS_OK : apply_setting(params, settings[i], error);
        if (status) return status;
    }
    return check_recorded(params, name, error);
}

int config_parse(struct params *params, const char *text, size_t size, const char *name, struct error *error) {
    config_default(params);
    int status = read_text(params, text, size, name, error);
    return status == STATUS_OK ? config_check(params, name, error) : status;
}

/* Prints headings for the sections that contain the key `path` but not the key printed before it,
 * `before`. */
static void print_sections(FILE *out, const char *path, const char *before) {
    for (const char *dot = strchr(path, '.'); dot; dot = strchr(dot + 1, '.')) {
        size_t length = (size_t)(dot - path);
        if (strncmp(path, before, length + 1) == 0) continue;
        char section[CONFIG_PATH_SIZE];
        snprintf(section, sizeof section, "%.*s", (int)length, path);
        const char *parent = strrchr(section, '.');
        if (parent) fprintf(out, "  %s:  # %s\n", parent + 1, config_section_title(section));
        else fprintf(out, "\n# %s\n%s:\n", config_section_title(section), section);
    }
}

static const char *note_of(const struct config_key *key, const struct config_note *note, int notes) {
    for (int i = 0; i < notes; i++)
        if (!strcmp(note[i].key, key->path)) return note[i].text;
    return NULL;
}

static void print_entry(FILE *out, const struct config_key *key, const struct params *params, const char *note) {
    char value[CONFIG_TEXT_SIZE], range[CONFIG_TEXT_SIZE];
    const char *dot = strrchr(key->path, '.'), *name = dot ? dot + 1 : key->path;
    int indent = !dot ? 0 : strchr(key->path, '.') == dot ? 2 : 4;
    config_value_format(key, params, value);
    config_range_format(key, range);
    if (!config_is_stated(key, params)) {
        fprintf(out, "%*s# %s: not stated; [%s] %s\n", indent, "", name, range, key->meaning);
        return;
    }
    fprintf(out, "%*s%s: %-*s # %s%s[%s] ", indent, "", name, 40 - indent - (int)strlen(name), value, note ? note : "", note ? "; " : "",
            range);
    if (key->effect < 0) fprintf(out, "%s\n", key->meaning);
    /* an effect's law is printed above, beside the effect's name */
    else fprintf(out, "%s %s\n", key->shapes_law ? "usually" : "adds nothing at", key->value);
}

/* Returns the configuration as YAML text, with a comment line `head` (NULL: none) and notes behind
 * values; NULL without memory. left_out: keys and sections to leave out, ended by NULL. */
static char *print_text(const struct params *params, const char *head, const struct config_note *note, int notes,
                        const char *const *left_out) {
    char *text = NULL, before[CONFIG_PATH_SIZE] = "";
    size_t size;
    struct config_key key;
    FILE *out = open_memstream(&text, &size);
    if (!out) return NULL;
    if (head) fprintf(out, "# %s\n", head);
    fprintf(out, "# hexid configuration, SI units. A key that is left out has its default: `hexid run --print-config`.\n");
    for (int i = 0; config_key_at(i, &key); i++) {
        if ((key.effect >= 0 && !params->effects[key.effect].on) || config_key_within(key.path, left_out)) continue;
        print_sections(out, key.path, before);
        print_entry(out, &key, params, note_of(&key, note, notes));
        snprintf(before, sizeof before, "%s", key.path);
    }
    if (fclose(out) == 0) return text;
    free(text);
    return NULL;
}

static const char *const nothing[] = {NULL};

char *config_text(const struct params *params) { return print_text(params, NULL, NULL, 0, nothing); }

char *config_text_noted(const struct params *params, const char *head, const struct config_note *note, int notes) {
    return print_text(params, head, note, notes, nothing);
}

char *config_text_without(const struct params *params, const char *const *left_out) { return print_text(params, NULL, NULL, 0, left_out); }

/* Escapes vertical bars, which would end a cell of a Markdown table. */
static void print_cell(FILE *out, const char *text) {
    for (; *text; text++) fprintf(out, *text == '|' ? "\\%c" : "%c", *text);
}

static void print_table_head(FILE *out, const char *value) {
    fprintf(out, "\n| key | %s | range | meaning |\n| --- | --- | --- | --- |\n", value);
}

static void print_effect_head(FILE *out, const struct effect *effect) {
    fprintf(out, "\n### %s\n\nWhat it is: %s.\n\nLaw: %s.\n\nWhere it shows: %s.\n", effect->name, effect->plain, effect->law,
            effect->signature);
    print_table_head(out, "adds nothing at");
}

static void print_section_head(FILE *out, const char *section) {
    const char *title = config_section_title(section);
    fprintf(out, "\n## %s\n", section);
    if (title) fprintf(out, "\n%s.\n", title);
}

/* Returns the length of the path before its last dot; of the whole path if it has no dot. */
static size_t last_dot(const char *path) {
    const char *dot = strrchr(path, '.');
    return dot ? (size_t)(dot - path) : strlen(path);
}

void config_print_keys(FILE *out) {
    struct config_key key;
    char range[CONFIG_TEXT_SIZE], section[CONFIG_PATH_SIZE], before[CONFIG_PATH_SIZE] = "";
    for (int i = 0, effect = -1; config_key_at(i, &key); i++) {
        size_t length = key.effect >= 0 ? strlen("effects") : last_dot(key.path);
        snprintf(section, sizeof section, "%.*s", (int)length, key.path);
        bool first = strcmp(section, before) != 0;
        if (first) print_section_head(out, section);
        if (first && key.effect < 0) print_table_head(out, "default");
        if (key.effect != effect) print_effect_head(out, effect_table[key.effect]);
        config_range_format(&key, range);
        fprintf(out, "| `%s` | %s | %s | ", key.path, key.value, range);
        print_cell(out, key.effect < 0 ? key.meaning : key.kind == CONFIG_REALS ? "one number, or one a leg" : "one number");
        fprintf(out, " |\n");
        snprintf(before, sizeof before, "%s", section);
        effect = key.effect;
    }
}
