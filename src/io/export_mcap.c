#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "cycle_columns.h"
#include "log_export.h"
#include "mcap.h"
#include "number_text.h"
#include "printable.h"

enum { NONE = -1 };

struct mcap_export {
    struct mcap_writer *file;
    int state, type[MESSAGE_TYPES]; /* channels; NONE until the log has such a message */
    char *text;                     /* JSON under way */
    size_t size, capacity;
    bool failed;
};

static void add(struct mcap_export *e, const char *text, size_t length) {
    if (e->size + length > e->capacity && !e->failed) {
        size_t capacity = 2 * (e->size + length);
        char *larger = realloc(e->text, capacity);
        e->failed = !larger;
        if (larger) e->text = larger, e->capacity = capacity;
    }
    if (e->failed) return;
    memcpy(e->text + e->size, text, length);
    e->size += length;
}

__attribute__((format(printf, 2, 3))) static void say(struct mcap_export *e, const char *format, ...) {
    char text[200]; /* names and numbers of ours: no longer than that */
    va_list args;
    va_start(args, format);
    int length = vsnprintf(text, sizeof text, format, args);
    va_end(args);
    add(e, text, length < (int)sizeof text ? (size_t)length : sizeof text - 1);
}

/* Anything that is no UTF-8 is a question mark. */
static void say_text(struct mcap_export *e, const char *text) {
    add(e, "\"", 1);
    for (const unsigned char *p = (const unsigned char *)text; *p;) {
        uint32_t point;
        size_t bytes = utf8_decode(p, &point);
        if (!bytes) add(e, "?", 1);
        else if (point < 0x20 || point == '"' || point == '\\' || point == 0x7f) say(e, "\\u%04x", (unsigned)point);
        else add(e, (const char *)p, bytes);
        p += bytes ? bytes : 1;
    }
    add(e, "\"", 1);
}

static void say_real(struct mcap_export *e, double value) {
    char number[NUMBER_SIZE];
    const char *text = isfinite(value) ? number_shortest(value, number) : "null";
    add(e, text, strlen(text));
}

/* `"name":`, after a comma where it is not the first. */
static void say_name(struct mcap_export *e, const char *name) { say(e, "%s\"%s\":", e->size > 1 ? "," : "", name); }

static void begin(struct mcap_export *e) {
    e->size = 0;
    add(e, "{", 1);
}

static void send(struct mcap_export *e, int channel, int64_t utime_us) {
    uint64_t time_us = utime_us > 0 ? (uint64_t)utime_us : 0; /* a damaged log's may be before 1970, or in 300 000 years */
    add(e, "}", 1);
    if (!e->failed) mcap_message(e->file, channel, time_us < UINT64_MAX / 1000 ? time_us * 1000 : UINT64_MAX, e->text, e->size);
}

static void schema_begin(struct mcap_export *e, const char *title) {
    e->size = 0;
    say(e, "{\"type\":\"object\",\"title\":\"hexid.%s\",\"properties\":{", title);
}

static int schema_end(struct mcap_export *e, const char *title) {
    char topic[64], name[64];
    snprintf(topic, sizeof topic, "/hexid/%s", title);
    snprintf(name, sizeof name, "hexid.%s", title);
    add(e, "}}", 3); /* with its closing zero */
    return e->failed ? 0 : mcap_channel(e->file, topic, name, e->text);
}

static int state_channel(struct mcap_export *e) {
    schema_begin(e, "state");
    for (int i = 0; i < CYCLE_COLUMNS; i++) {
        say(e, "%s\"%s\":{\"type\":\"%s\"", i ? "," : "", cycle_columns[i].name, column_is_real(i) ? "number" : "integer");
        if (*cycle_columns[i].unit) say(e, ",\"description\":\"%s\"", cycle_columns[i].unit);
        add(e, "}", 1);
    }
    return schema_end(e, "state");
}

static int type_channel(struct mcap_export *e, const struct message_type *type) {
    static const char *const json[] = {[FIELD_INTEGER] = "integer", [FIELD_BOOLEAN] = "boolean", [FIELD_REAL] = "number", [FIELD_TEXT] = "string"};
    schema_begin(e, type->name);
    for (const struct field *f = type->field; f->name; f++) {
        if (f->kind == FIELD_COUNT) continue; /* an array says it itself; never the first field */
        say(e, "%s\"%s\":{\"type\":", f == type->field ? "" : ",", f->name);
        say(e, f->count == 1 ? "\"%s\"}" : "\"array\",\"items\":{\"type\":\"%s\"}}", json[f->kind]);
    }
    return schema_end(e, type->name);
}

static int mcap_open(void **to, const char *path, struct error *error) {
    struct mcap_export *e = calloc(1, sizeof *e);
    *to = NULL;
    if (!e) return error_set(error, STATUS_IO, "%.250s: out of memory", path);
    int status = mcap_create(&e->file, path, error);
    if (status) {
        free(e);
        return status;
    }
    e->state = state_channel(e);
    for (int i = 0; i < MESSAGE_TYPES; i++) e->type[i] = NONE;
    *to = e;
    return STATUS_OK;
}

static void mcap_cycle(void *to, int64_t utime_us, double time_s, const struct cycle *c) {
    struct mcap_export *e = to;
    (void)time_s;
    begin(e);
    for (int i = 0; i < CYCLE_COLUMNS; i++) {
        if (column_is_real(i) && !isfinite(column_real(c, i))) continue;
        say_name(e, cycle_columns[i].name);
        if (column_is_real(i)) say_real(e, column_real(c, i));
        else say(e, "%lld", (long long)column_integer(c, i));
    }
    send(e, e->state, utime_us);
}

static void say_value(struct mcap_export *e, const struct message *m, int field, int i) {
    switch (m->type->field[field].kind) {
    case FIELD_REAL: say_real(e, message_real(m, field, i)); break;
    case FIELD_TEXT: say_text(e, message_text(m, field, i)); break;
    case FIELD_BOOLEAN: say(e, "%s", message_integer(m, field, i) ? "true" : "false"); break;
    default: say(e, "%lld", (long long)message_integer(m, field, i)); break;
    }
}

static void mcap_message_of(void *to, int64_t utime_us, const struct message *m) {
    struct mcap_export *e = to;
    int *channel = &e->type[m->type - message_types];
    if (*channel == NONE) *channel = type_channel(e, m->type);
    begin(e);
    for (int f = 0; m->type->field[f].name; f++) {
        const struct field *field = &m->type->field[f];
        bool array = field->count != 1, real = field->kind == FIELD_REAL;
        if (field->kind == FIELD_COUNT || (!array && real && !isfinite(message_real(m, f, 0)))) continue;
        say_name(e, field->name);
        if (array) add(e, "[", 1);
        for (int i = 0; i < m->value[f].count; i++) {
            if (i) add(e, ",", 1);
            say_value(e, m, f, i);
        }
        if (array) add(e, "]", 1);
    }
    send(e, *channel, utime_us);
}

static int mcap_failed(const void *to) {
    const struct mcap_export *e = to;
    return e->failed ? ENOMEM : mcap_failure(e->file);
}

static int mcap_end(void *to, struct error *error) {
    struct mcap_export *e = to;
    int status = mcap_close(e->file, mcap_failed(e), error);
    free(e->text);
    free(e);
    return status;
}

const struct export_format export_mcap = {
    .name = "mcap", .open = mcap_open, .cycle = mcap_cycle, .message = mcap_message_of, .failed = mcap_failed, .close = mcap_end,
};
