/* The native log: a lossless LCM event log, as lcm-logger writes and lcm-logplayer replays it. The
 * first event is HEXID_EVENT kind "config" with the effective configuration as YAML. HEXID_STATE
 * for every cycle, and results, events and statistics follow in the order in which they arose.
 * Ordinary threads.
 *
 * liblcm is not used: liblcm 1.3.1 allocates whatever size a damaged log claims without checking
 * the result, skips garbage silently, and takes three allocations and a system call for each
 * event (0.46 us, against 0.07 us here); and a writer has to know which events are in the file
 * when a disk is full. Format, big-endian: int32 0xEDA1DA01, int64 event number, int64 utime in
 * us, int32 channel length, int32 data length, channel, data. */
#ifndef HEXID_LOG_H
#define HEXID_LOG_H

#include "status.h"
#include "types.h"

struct log_writer;
struct log_reader;

/* Opens the log as output_log() does: an existing file is set aside. Returns -2 or -3 with path and
 * reason as output_log() does, or -3 without memory. */
int log_create(struct log_writer **writer, const char *path, struct error *error);

/* Does what log_create() does on a file that output_log() has opened; the writer owns the file,
 * even if this fails. */
int log_on_file(struct log_writer **writer, int file, const char *path, struct error *error);

/* Appends an event. utime_us: time on the log's clock. Returns -3 with path and reason if the disk
 * is full or gone; every later call then returns the same error. The first event is passed to the
 * system at once, so that a run whose log cannot be written is refused before anything moves; later
 * events go through a buffer of a few kB. */
int log_write(struct log_writer *writer, int64_t utime_us, const char *channel, const void *data, int size, struct error *error);

/* Continues the log in this file, which the writer then owns; the old file is checked as by
 * log_check() and closed. On failure returns -3 and closes the new file: if the check fails, its
 * error becomes the log's error as in log_write(); if memory runs out, the log continues in the old
 * file. */
int log_continue(struct log_writer *writer, int file, const char *path, struct error *error);

/* Returns the number of bytes accepted since the log's current file was begun. */
int64_t log_bytes(const struct log_writer *writer);

/* Counts the events of this channel from now on. Once log_write(), log_flush() or log_check()
 * has failed, log_lost() returns how many of those given to log_write() are in no file. channel
 * must outlive the writer. */
void log_count(struct log_writer *writer, const char *channel);
int64_t log_lost(const struct log_writer *writer);

/* Hands the buffered events to the system. */
int log_flush(struct log_writer *writer, struct error *error);

/* Flushes, and checks that the file is still as written: not deleted, renamed, truncated or written
 * by others. Otherwise returns -3, which becomes the log's error as in log_write(). A file that is
 * not regular is only flushed; a renaming is not noticed if the path may not be looked up. */
int log_check(struct log_writer *writer, struct error *error);

/* Calls log_check() and frees the writer, even after a failure. */
int log_close(struct log_writer *writer, struct error *error);

/* Returns the size of an event in the file, bytes. */
size_t log_event_size(const char *channel, int size);

struct log_event {
    int64_t utime_us;
    const char *channel;  /* the event's channel; valid until the next read */
    const void *data;
    int size;
};

/* Opens a log. An empty file is a log without events. Returns -3 with path and reason if it cannot
 * be read or does not begin like an event log. */
int log_open(struct log_reader **reader, const char *path, struct error *error);

/* Reads the next event, of any channel. Returns 1: an event; 0: the end. Reading stops for good at
 * the first byte that cannot belong to an event; nothing after damage is guessed. Memory: a buffer,
 * enlarged only for larger events, up to 64 MiB, and only as their bytes arrive. */
int log_next(struct log_reader *reader, struct log_event *event);

/* Returns the offset of the byte after the last event read. */
int64_t log_offset(const struct log_reader *reader);

/* Restricts reading to events that begin within these bytes of the file; `begin` must be the
 * start of an event. To be called before the first read. */
void log_range(struct log_reader *reader, int64_t begin, int64_t end);

/* Returns true if reading stopped at damage or inside an event, not at the end of the file or of
 * log_range(); *offset is the byte after the last whole event. */
bool log_cut(const struct log_reader *reader, int64_t *offset);

void log_release(struct log_reader *reader);

#endif
