/* libFuzzer: any bytes as a log, read as by `hexid identify` and `hexid export`. The events must
 * not add up to more than the file. */
#include <assert.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "config.h"
#include "ident.h"
#include "log.h"
#include "log_export.h"
#include "message_fields.h"
#include "messages.h"
#include "params.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Calls every query of a message. */
static void look(const struct message *m) {
    for (int f = 0; m->type->field[f].name; f++)
        for (int i = 0; i < m->value[f].count; i++) {
            if (m->type->field[f].kind == FIELD_REAL) message_real(m, f, i);
            else if (m->type->field[f].kind == FIELD_TEXT) assert(strlen(message_text(m, f, i)) < (size_t)m->size);
            else message_integer(m, f, i);
        }
}

static void take(struct ident *ident, const struct log_event *e) {
    struct cycle c;
    struct event event;
    struct message message;
    if (message_read(e->channel, e->data, e->size, &message)) look(&message);
    if (!strcmp(e->channel, CHANNEL_STATE) && state_decode(e->data, e->size, &c)) ident_feed(ident, &c);
    if (!strcmp(e->channel, CHANNEL_EVENT)) event_decode(e->data, e->size, &event);
}

static int format_open(void **to, const char *path, struct error *error) {
    (void)path, (void)error;
    *to = NULL;
    return STATUS_OK;
}
static void format_cycle(void *to, int64_t utime_us, double time_s, const struct cycle *c) {
    (void)to, (void)utime_us, (void)time_s, (void)c;
}
static void format_message(void *to, int64_t utime_us, const struct message *m) { (void)to, (void)utime_us, (void)m; }
static int format_failed(const void *to) { return to != NULL; }
static int format_close(void *to, struct error *error) { return (void)to, (void)error, STATUS_OK; }

/* Reads the log as hexid export does: its runs and their lost cycles. */
static void read_whole(const char *path) {
    static const struct export_format none = {
        .open = format_open, .cycle = format_cycle, .message = format_message, .failed = format_failed, .close = format_close};
    struct log_export_report report;
    struct error error;
    for (int run = 0; run <= 2; run++)
        if (!log_export(path, run, "", &none, &report, &error)) assert(report.cycles > 0 && report.lost >= 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static struct params params;
    static struct ident fresh;
    static int file = -1;
    static char path[40];
    struct error error;
    struct log_reader *reader;
    struct log_event event;
    if (file < 0) {
        file = memfd_create("log", 0);
        snprintf(path, sizeof path, "/proc/self/fd/%d", file);
        config_default(&params);
        ident_init(&fresh, &params, &error);
    }
    if (ftruncate(file, 0) || pwrite(file, data, size, 0) != (ssize_t)size) return 0;
    if (log_open(&reader, path, &error)) return 0;
    struct ident ident = fresh;
    int64_t used = 0, offset;
    while (log_next(reader, &event)) {
        used += 28 + (int64_t)strlen(event.channel) + event.size;
        take(&ident, &event);
    }
    bool cut = log_cut(reader, &offset);
    assert(offset == used && used <= (int64_t)size && cut == (used < (int64_t)size));
    log_release(reader);
    read_whole(path);
    ident_end(&ident);
    ident_solve(&ident);
    return 0;
}
