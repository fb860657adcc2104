#include "log_export.h"

#include <string.h>
#include <unistd.h>

#include "log.h"
#include "log_runs.h"
#include "messages.h"
#include "units.h"

struct export {
    const struct export_format *format;
    void *to;
    int64_t first_ns;
    uint64_t last_seq;
    struct log_export_report *report;
};

static void take_cycle(struct export *e, int64_t utime_us, const struct cycle *c) {
    struct log_export_report *r = e->report;
    if (!r->cycles++) e->first_ns = c->in.time_ns;
    else if (c->seq > e->last_seq) r->lost = add_saturated(r->lost, cycles_between(e->last_seq, c->seq));
    e->last_seq = c->seq;
    double time_s = ((double)c->in.time_ns - (double)e->first_ns) * 1e-9;
    e->format->cycle(e->to, utime_us, time_s, c);
}

static void take(struct export *e, const struct log_event *event) {
    struct cycle cycle;
    struct message message;
    bool state = !strcmp(event->channel, CHANNEL_STATE);
    if (state && state_decode(event->data, event->size, &cycle)) take_cycle(e, event->utime_us, &cycle);
    else if (!state && !message_known(event->channel)) return;
    else if (!state && message_read(event->channel, event->data, event->size, &message)) {
        e->report->messages++;
        e->format->message(e->to, event->utime_us, &message);
    } else e->report->unreadable++;
}

int log_export(const char *log_path, int run, const char *path, const struct export_format *format, struct log_export_report *report,
               struct error *error) {
    struct log_reader *log;
    struct log_event event;
    struct export e = {.format = format, .report = report};
    *report = (struct log_export_report){0};
    int status = log_open_run(&log, log_path, run, error);
    if (status) return status;
    status = format->open(&e.to, path, error);
    if (!status) {
        while (!format->failed(e.to) && log_next(log, &event)) take(&e, &event);
        status = format->close(e.to, error);
        report->cut = log_cut(log, &report->cut_offset);
    }
    log_release(log);
    if (status || report->cycles) return status;
    unlink(path);
    return error_set(error, STATUS_IO, "%.250s: has no cycle in it, so there is nothing to export", log_path);
}
