#include <errno.h>
#include <stdlib.h>

#include "cycle_columns.h"
#include "json_text.h"
#include "log_export.h"
#include "mcap.h"

enum { NONE = -1 };

struct mcap_export {
    struct mcap_writer *file;
    int state, type[MESSAGE_TYPES]; /* channels of cycles and of each type of message; NONE before
                                     * its first message */
    struct json_text json;          /* buffer for the JSON of a message */
};

static void send(struct mcap_export *e, int channel, int64_t utime_us) {
    /* a damaged log may have times before 1970 or 300,000 years ahead */
    uint64_t time_us = utime_us > 0 ? (uint64_t)utime_us : 0;
    if (!e->json.failed)
        mcap_message(e->file, channel, time_us < UINT64_MAX / 1000 ? time_us * 1000 : UINT64_MAX, e->json.text, e->json.size);
}

static void schema_begin(struct mcap_export *e, const char *title) {
    json_text_restart(&e->json);
    json_text_say(&e->json, "{\"type\":\"object\",\"title\":\"hexid.%s\",\"properties\":{", title);
}

static int schema_end(struct mcap_export *e, const char *title) {
    char topic[64], name[64];
    snprintf(topic, sizeof topic, "/hexid/%s", title);
    snprintf(name, sizeof name, "hexid.%s", title);
    json_text_add(&e->json, "}}", 3); /* includes the text's closing zero */
    return e->json.failed ? 0 : mcap_channel(e->file, topic, name, e->json.text);
}

static int state_channel(struct mcap_export *e) {
    schema_begin(e, "state");
    for (int i = 0; i < CYCLE_COLUMNS; i++) {
        json_text_say(&e->json, "%s\"%s\":{\"type\":\"%s\"", i ? "," : "", cycle_columns[i].name, column_is_real(i) ? "number" : "integer");
        if (*cycle_columns[i].unit) json_text_say(&e->json, ",\"description\":\"%s\"", cycle_columns[i].unit);
        json_text_add(&e->json, "}", 1);
    }
    return schema_end(e, "state");
}

static int type_channel(struct mcap_export *e, const struct message_type *type) {
    static const char *const json[] = {
        [FIELD_INTEGER] = "integer", [FIELD_BOOLEAN] = "boolean", [FIELD_REAL] = "number", [FIELD_TEXT] = "string"};
    schema_begin(e, type->name);
    for (const struct field *f = type->field; f->name; f++) {
        if (f->kind == FIELD_COUNT)
            continue; /* the array's length states a count; no type begins with a count, so the
                       * commas are right */
        json_text_say(&e->json, "%s\"%s\":{\"type\":", f == type->field ? "" : ",", f->name);
        json_text_say(&e->json, f->count == 1 ? "\"%s\"}" : "\"array\",\"items\":{\"type\":\"%s\"}}", json[f->kind]);
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
    json_text_restart(&e->json);
    json_text_cycle(&e->json, c);
    send(e, e->state, utime_us);
}

static void mcap_message_of(void *to, int64_t utime_us, const struct message *m) {
    struct mcap_export *e = to;
    int *channel = &e->type[m->type - message_types];
    if (*channel == NONE) *channel = type_channel(e, m->type);
    json_text_restart(&e->json);
    json_text_message(&e->json, m);
    send(e, *channel, utime_us);
}

static int mcap_failed(const void *to) {
    const struct mcap_export *e = to;
    return e->json.failed ? ENOMEM : mcap_failure(e->file);
}

static int mcap_end(void *to, struct error *error) {
    struct mcap_export *e = to;
    int status = mcap_close(e->file, mcap_failed(e), error);
    json_text_free(&e->json);
    free(e);
    return status;
}

const struct export_format export_mcap = {
    .name = "mcap",
    .open = mcap_open,
    .cycle = mcap_cycle,
    .message = mcap_message_of,
    .failed = mcap_failed,
    .close = mcap_end,
};
