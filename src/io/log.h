/* The native log: an LCM event log, lossless, what lcm-logger writes and lcm-logplayer replays.
 * First event: HEXID_EVENT kind "config" with the effective configuration as YAML. Then
 * HEXID_STATE for every cycle, and results, events and statistics in the order in which they
 * arose. Ordinary threads.
 *
 * liblcm neither reads nor writes: liblcm 1.3.1 allocates whatever size a damaged log claims
 * without looking whether it got it, skips garbage silently, takes three allocations and a system
 * call an event (0.46 us an event, against 0.07 us here); and a writer has to know which events
 * are in the file when a disk is full. Format, big-endian: int32 0xEDA1DA01, int64 event number,
 * int64 utime in us, int32 channel length, int32 data length, channel, data. */
#ifndef HEXID_LOG_H
#define HEXID_LOG_H

#include "status.h"
#include "types.h"

struct log_writer;
struct log_reader;

/* Opens it as output_log() does: a file that is there is set aside. -3 with path and reason when it
 * cannot be. */
int log_create(struct log_writer **writer, const char *path, struct error *error);

/* The same on a file that output_log() has opened; it is the writer's then, also where this
 * fails. */
int log_on_file(struct log_writer **writer, int file, const char *path, struct error *error);

/* utime_us: time of the event on the log's clock. -3 with path and reason when the disk is full
 * or gone; every later call then says the same. The first event is handed to the system at once,
 * so a run whose log cannot be written is refused before anything moves; later ones through a
 * buffer of a few kB. */
int log_write(struct log_writer *writer, int64_t utime_us, const char *channel, const void *data, int size, struct error *error);

/* What comes from now on goes into this file, which is the writer's then; what is before it is
 * flushed and closed. -3 where that fails, which is the log's error then as of log_write(), and
 * without memory: the file is closed, and the log goes on where it was. */
int log_continue(struct log_writer *writer, int file, const char *path, struct error *error);

/* Returns the bytes that were taken since the log, or its last file, was begun. */
int64_t log_bytes(const struct log_writer *writer);

/* Counts the events of this channel from now on. log_lost(): how many of them log_write() was given
 * and no file has, once log_write(), log_flush() or log_check() has failed. channel outlives the
 * writer. */
void log_count(struct log_writer *writer, const char *channel);
int64_t log_lost(const struct log_writer *writer);

/* Hands the buffered events to the system. */
int log_flush(struct log_writer *writer, struct error *error);

/* Flushes, and looks whether the file is still what was written: not deleted, renamed, cut, nor
 * written by somebody else. -3, which is the log's error then as of log_write(). Where the file is
 * no regular one, or cannot be seen any more, only the flush counts. */
int log_check(struct log_writer *writer, struct error *error);

/* Calls log_check() and frees the writer, also after a failure. */
int log_close(struct log_writer *writer, struct error *error);

/* Bytes that an event takes in the file. */
size_t log_event_size(const char *channel, int size);

struct log_event {
    int64_t utime_us;
    const char *channel;  /* valid until the next read */
    const void *data;
    int size;
};

/* -3 with path and reason when it cannot be read or does not begin like an event log. An empty file
 * is a log without events. */
int log_open(struct log_reader **reader, const char *path, struct error *error);

/* 1 an event, of any channel; 0 the end. Reading stops for good at the first byte that cannot be
 * part of an event: what follows damage is not guessed. Memory: a buffer, enlarged only for events
 * larger than it, up to 64 MiB, and only as their bytes arrive. */
int log_next(struct log_reader *reader, struct log_event *event);

/* Returns the offset of the byte behind the event that was read last. */
int64_t log_offset(const struct log_reader *reader);

/* Reads the events that begin within these bytes of the file alone; begin is where one begins.
 * Before the first is read. */
void log_range(struct log_reader *reader, int64_t begin, int64_t end);

/* True when reading ended before the file did, or inside an event; *offset is the byte after the
 * last whole event. */
bool log_cut(const struct log_reader *reader, int64_t *offset);

void log_release(struct log_reader *reader);

#endif
