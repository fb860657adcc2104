/* The native log: an LCM event log, lossless, what lcm-logger writes and lcm-logplayer replays.
 * First event: HEXID_EVENT kind "config" with the effective configuration as YAML. Then HEXID_STATE for every cycle, and results,
 * events and statistics in the order in which they arose. Ordinary threads. */
#ifndef HEXID_LOG_H
#define HEXID_LOG_H

#include "status.h"
#include "types.h"

struct log_writer;
struct log_reader;

/* -3 with path and reason when it cannot be written. */
int log_create(struct log_writer **writer, const char *path, struct error *error);
/* utime_us: time of the event on the log's clock. -3 when the disk is full or gone: said once, nothing lost silently. */
int log_write(struct log_writer *writer, int64_t utime_us, const char *channel, const void *data, int size, struct error *error);
int log_flush(struct log_writer *writer, struct error *error);
int log_close(struct log_writer *writer, struct error *error);

struct log_event {
    int64_t utime_us;
    const char *channel;  /* valid until the next read */
    const void *data;
    int size;
};

int log_open(struct log_reader **reader, const char *path, struct error *error);
/* 1 an event, 0 the end. A log cut off or damaged anywhere is read up to there: log_cut() then says so. */
int log_next(struct log_reader *reader, struct log_event *event);
/* True when the file did not end with a whole event; *offset is where reading stopped. */
bool log_cut(const struct log_reader *reader, int64_t *offset);
void log_release(struct log_reader *reader);

#endif
