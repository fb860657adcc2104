#include "log.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "input.h"
#include "output.h"

/* CHANNEL_MAX: limit of liblcm's reader. BUFFER_SIZE: first size of the reader's buffer. ROOM:
 * first size of the writer's buffer, which grows to the largest event and stays so; its contents
 * are all that a crash of the process loses. */
enum { HEADER_SIZE = 28, CHANNEL_MAX = 999, BUFFER_SIZE = 1 << 18, EVENT_MAX = 64 << 20, ROOM = 4096 };
static const uint32_t sync_word = 0xEDA1DA01;

struct log_writer {
    int file;
    char *path;
    struct stat begun;       /* state of the file when writing began, with which log_check()
                              * compares its size, links and place; a pipe is not checked */
    bool flushed;            /* the first event has been flushed */
    int64_t number, bytes;   /* number of events, and of bytes, that this file has accepted */
    unsigned char *buffer;   /* whole events that are still to be written */
    size_t used, capacity;
    int64_t kept, lost;      /* numbers of the counted channel's events that are in this file, and
                              * that are in no file */
    const char *counted; /* channel whose events are counted, given by log_count() */
    struct error error;      /* error of the first failure */
};

static void write_u32(unsigned char *p, uint32_t x) {
    for (int i = 0; i < 4; i++) p[i] = (unsigned char)(x >> (24 - 8 * i));
}
static void write_u64(unsigned char *p, uint64_t x) { write_u32(p, (uint32_t)(x >> 32)), write_u32(p + 4, (uint32_t)x); }
static uint32_t read_u32(const unsigned char *p) { return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3]; }
static uint64_t read_u64(const unsigned char *p) { return (uint64_t)read_u32(p) << 32 | read_u32(p + 4); }

static bool counts(const struct log_writer *w, const void *channel, size_t length) {
    return w->counted && strlen(w->counted) == length && !memcmp(channel, w->counted, length);
}

/* Counts the events of the counted channel in the buffer: kept if they end within the first
 * `written` bytes, else lost. */
static void count(struct log_writer *w, size_t written) {
    for (size_t at = 0; at < w->used;) {
        const unsigned char *event = w->buffer + at;
        uint32_t channel = read_u32(event + 20);
        at += HEADER_SIZE + channel + read_u32(event + 24);
        if (!counts(w, event + HEADER_SIZE, channel)) continue;
        if (at <= written) w->kept++;
        else w->lost++;
    }
    w->used = 0;
}

static int fail(struct log_writer *w, struct error *error) {
    int reason = errno;
    if (w->error.status == STATUS_OK)
        error_set(&w->error, STATUS_IO, "%.250s: cannot write the log: %s; %s", w->path, strerror(reason),
                  reason == ENOSPC || reason == EDQUOT ? "free some space or name another file" : "name a file that can be written");
    *error = w->error;
    return error->status;
}

int log_on_file(struct log_writer **writer, int file, const char *path, struct error *error) {
    struct log_writer *w = calloc(1, sizeof *w);
    *writer = NULL;
    if (!w || !(w->path = strdup(path)) || !(w->buffer = malloc(ROOM))) {
        if (w) free(w->path);
        free(w);
        close(file);
        return error_set(error, STATUS_IO, "%.250s: out of memory", path);
    }
    w->file = file, w->capacity = ROOM;
    if (fstat(file, &w->begun)) w->begun = (struct stat){0};
    *writer = w;
    return STATUS_OK;
}

int log_create(struct log_writer **writer, const char *path, struct error *error) {
    char aside[PATH_MAX];
    int file = output_log(path, aside, error);
    *writer = NULL;
    return file < 0 ? file : log_on_file(writer, file, path, error);
}

void log_count(struct log_writer *w, const char *channel) { w->counted = channel; }
int64_t log_lost(const struct log_writer *w) { return w->lost; }

int log_continue(struct log_writer *w, int file, const char *path, struct error *error) {
    int status = log_check(w, error);
    char *name = status ? NULL : strdup(path);
    if (!name) {
        close(file);
        return status ? status : error_set(error, STATUS_IO, "%.250s: out of memory", path);
    }
    close(w->file);
    free(w->path);
    w->file = file, w->path = name;
    if (fstat(file, &w->begun)) w->begun = (struct stat){0};
    w->flushed = false, w->number = w->bytes = w->kept = 0;
    return STATUS_OK;
}

int64_t log_bytes(const struct log_writer *w) { return w->bytes; }

int log_flush(struct log_writer *w, struct error *error) {
    size_t written = 0;
    while (!w->error.status && written < w->used) {
        ssize_t size = write(w->file, w->buffer + written, w->used - written);
        if (size < 0 && errno == EINTR) continue;
        if (size < 0) fail(w, error);
        else written += (size_t)size;
    }
    count(w, written);
    if (w->error.status) *error = w->error;
    return w->error.status;
}

/* Makes the buffer at least this large. Returns false without memory. */
static bool make_room(struct log_writer *w, size_t size) {
    if (size <= w->capacity) return true;
    unsigned char *larger = realloc(w->buffer, size);
    if (!larger) return false;
    w->buffer = larger, w->capacity = size;
    return true;
}

static void append(struct log_writer *w, int64_t utime_us, const char *channel, size_t length, const void *data, int size) {
    unsigned char *p = w->buffer + w->used;
    write_u32(p, sync_word);
    write_u64(p + 4, (uint64_t)w->number++);
    write_u64(p + 12, (uint64_t)utime_us);
    write_u32(p + 20, (uint32_t)length);
    write_u32(p + 24, (uint32_t)size);
    memcpy(p + HEADER_SIZE, channel, length);
    memcpy(p + HEADER_SIZE + length, data, (size_t)size);
    w->used += HEADER_SIZE + length + (size_t)size;
    w->bytes += (int64_t)(HEADER_SIZE + length + (size_t)size);
}

int log_write(struct log_writer *w, int64_t utime_us, const char *channel, const void *data, int size, struct error *error) {
    size_t whole = log_event_size(channel, size);
    if (!w->error.status && w->used + whole > w->capacity) log_flush(w, error);
    if (!w->error.status && !make_room(w, whole)) errno = ENOMEM, fail(w, error);
    if (w->error.status) {
        w->lost += counts(w, channel, strlen(channel));
        *error = w->error;
        return error->status;
    }
    append(w, utime_us, channel, strlen(channel), data, size);
    if (w->flushed) return STATUS_OK;
    w->flushed = true;
    return log_flush(w, error);
}

/* Returns the reason why the file is not in its place or not as written; NULL: it is intact. */
static const char *what_happened(const struct log_writer *w) {
    struct stat now, there;
    if (!S_ISREG(w->begun.st_mode) || fstat(w->file, &now)) return NULL;
    if (!now.st_nlink && w->begun.st_nlink) return "was deleted while it was written";
    int64_t expected = w->begun.st_size + w->bytes;
    if (now.st_size != expected) return now.st_size < expected ? "was cut while it was written" : "is written by another process, too";
    bool gone = stat(w->path, &there) ? errno == ENOENT || errno == ENOTDIR : there.st_ino != now.st_ino || there.st_dev != now.st_dev;
    return gone && w->begun.st_nlink ? "was renamed or replaced while it was written" : NULL;
}

int log_check(struct log_writer *w, struct error *error) {
    const char *what = log_flush(w, error) ? NULL : what_happened(w);
    if (!what) return w->error.status;
    bool renamed = strstr(what, "renamed") != NULL;
    if (!renamed) w->lost += w->kept;
    error_set(&w->error, STATUS_IO, "%.250s: %s; leave a log alone until its run has ended", w->path, what);
    *error = w->error;
    return error->status;
}

int log_close(struct log_writer *w, struct error *error) {
    int status = log_check(w, error);
    if (close(w->file) && !status) status = fail(w, error);
    free(w->buffer);
    free(w->path);
    free(w);
    return status;
}

size_t log_event_size(const char *channel, int size) { return HEADER_SIZE + strlen(channel) + (size_t)size; }

struct log_reader {
    int file;
    unsigned char *buffer;
    size_t capacity, begin, end; /* unread bytes: buffer[begin .. end) */
    int64_t offset;              /* file offset of buffer[begin] */
    int64_t limit;               /* events that begin here or later are not read */
    bool ended, damaged;
    char channel[CHANNEL_MAX + 1];
};

/* Reads more bytes into the buffer. Returns false at the end of the file, or on an error. */
static bool fill(struct log_reader *r) {
    ssize_t got;
    if (r->begin > 0) {
        memmove(r->buffer, r->buffer + r->begin, r->end - r->begin);
        r->end -= r->begin;
        r->begin = 0;
    }
    if (r->end == r->capacity) {
        unsigned char *larger = realloc(r->buffer, 2 * r->capacity);
        if (!larger) return false;
        r->buffer = larger;
        r->capacity *= 2;
    }
    do got = read(r->file, r->buffer + r->end, r->capacity - r->end);
    while (got < 0 && errno == EINTR);
    if (got > 0) r->end += (size_t)got;
    r->damaged = got < 0;
    return got > 0;
}

/* Returns the next `size` bytes; NULL if fewer are left. */
static const unsigned char *need(struct log_reader *r, size_t size) {
    while (r->end - r->begin < size)
        if (!fill(r)) return NULL;
    return r->buffer + r->begin;
}

int log_open(struct log_reader **reader, const char *path, struct error *error) {
    struct log_reader *r = calloc(1, sizeof *r);
    *reader = NULL;
    if (!r || !(r->buffer = malloc(BUFFER_SIZE))) {
        free(r);
        return error_set(error, STATUS_IO, "%.250s: out of memory", path);
    }
    r->capacity = BUFFER_SIZE, r->limit = INT64_MAX;
    const char *reason;
    r->file = input_open(path, &reason);
    errno = 0;
    const unsigned char *first = r->file < 0 ? NULL : need(r, sizeof sync_word);
    if (r->file < 0) error_set(error, STATUS_IO, "%.250s: cannot read the log: %s", path, reason);
    else if (errno) error_set(error, STATUS_IO, "%.250s: cannot read the log: %s", path, strerror(errno));
    else if (first && read_u32(first) != sync_word)
        error_set(error, STATUS_IO, "%.250s: not an LCM event log; hexid run --log writes one, hexid import makes one of CSV files", path);
    else {
        *reader = r;
        return STATUS_OK;
    }
    log_release(r);
    return error->status;
}

/* Returns the size of an event according to its header; 0 if the header is invalid. */
static size_t event_size(const unsigned char *header) {
    uint32_t channel = read_u32(header + 20), data = read_u32(header + 24);
    bool sound = read_u32(header) == sync_word && channel >= 1 && channel <= CHANNEL_MAX && data <= EVENT_MAX;
    return sound ? HEADER_SIZE + channel + data : 0;
}

int64_t log_offset(const struct log_reader *r) { return r->offset; }

void log_range(struct log_reader *r, int64_t begin, int64_t end) {
    r->damaged = lseek(r->file, begin, SEEK_SET) < 0;
    r->begin = r->end = 0;
    r->offset = begin, r->limit = end;
}

int log_next(struct log_reader *r, struct log_event *event) {
    if (r->offset >= r->limit) return 0;
    const unsigned char *header = r->ended ? NULL : need(r, HEADER_SIZE);
    size_t size = header ? event_size(header) : 0;
    if (size) header = need(r, size);
    if (!size || !header || memchr(header + HEADER_SIZE, '\0', read_u32(header + 20))) {
        r->damaged = r->damaged || r->end > r->begin;
        r->ended = true;
        return 0;
    }
    uint32_t length = read_u32(header + 20);
    memcpy(r->channel, header + HEADER_SIZE, length);
    r->channel[length] = '\0';
    *event = (struct log_event){.utime_us = (int64_t)read_u64(header + 12),
                                .channel = r->channel,
                                .data = header + HEADER_SIZE + length,
                                .size = (int)read_u32(header + 24)};
    r->begin += size;
    r->offset += (int64_t)size;
    return 1;
}

bool log_cut(const struct log_reader *r, int64_t *offset) {
    *offset = r->offset;
    return r->damaged;
}

void log_release(struct log_reader *r) {
    if (r->file >= 0) close(r->file);
    free(r->buffer);
    free(r);
}
