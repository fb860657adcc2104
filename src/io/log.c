#include "log.h"

#include <errno.h>
#include <fcntl.h>
#include <lcm/eventlog.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include "input.h"

/* CHANNEL_MAX: as liblcm reads */
enum { HEADER_SIZE = 28, CHANNEL_MAX = 999, BUFFER_SIZE = 1 << 18, EVENT_MAX = 64 << 20 };
static const uint32_t sync_word = 0xEDA1DA01;

struct log_writer {
    lcm_eventlog_t *file;
    char *path;
    bool begun;
    int64_t bytes;
    struct error error; /* the first failure */
};

static int fail(struct log_writer *w, struct error *error) {
    int reason = errno;
    if (w->error.status == STATUS_OK)
        error_set(&w->error, STATUS_IO, "%.250s: cannot write the log: %s; %s", w->path, strerror(reason),
                  reason == ENOSPC || reason == EDQUOT ? "free some space or name another file" : "name a file that can be written");
    *error = w->error;
    return error->status;
}

int log_create(struct log_writer **writer, const char *path, struct error *error) {
    struct log_writer *w = calloc(1, sizeof *w);
    *writer = NULL;
    if (!w || !(w->path = strdup(path))) {
        free(w);
        return error_set(error, STATUS_IO, "%.250s: out of memory", path);
    }
    w->file = lcm_eventlog_create(path, "w");
    if (!w->file) {
        int status = fail(w, error);
        free(w->path);
        free(w);
        return status;
    }
    /* says that it is being written (log_directory.h); a pipe need not take it */
    flock(fileno(w->file->f), LOCK_SH | LOCK_NB);
    *writer = w;
    return STATUS_OK;
}

/* As lcm_eventlog_create() makes it of a path, which the confined daemon may not open. */
static lcm_eventlog_t *on_file(int file) {
    lcm_eventlog_t *log = calloc(1, sizeof *log);
    if (log && (log->f = fdopen(file, "w"))) return log;
    free(log);
    return NULL;
}

int log_continue(struct log_writer *w, int file, const char *path, struct error *error) {
    int status = log_flush(w, error);
    char *name = status ? NULL : strdup(path);
    lcm_eventlog_t *next = name ? on_file(file) : NULL;
    if (!next) {
        free(name);
        close(file);
        return status ? status : error_set(error, STATUS_IO, "%.250s: out of memory", path);
    }
    lcm_eventlog_destroy(w->file);
    free(w->path);
    w->file = next, w->path = name;
    w->begun = false, w->bytes = 0;
    return STATUS_OK;
}

int64_t log_bytes(const struct log_writer *w) { return w->bytes; }

int log_flush(struct log_writer *w, struct error *error) { return w->error.status || fflush(w->file->f) ? fail(w, error) : STATUS_OK; }

int log_write(struct log_writer *w, int64_t utime_us, const char *channel, const void *data, int size, struct error *error) {
    lcm_eventlog_event_t event = {.timestamp = utime_us,
                                  .channellen = (int32_t)strlen(channel),
                                  .datalen = size,
                                  /* liblcm only reads them */
                                  .channel = (char *)(uintptr_t)channel,
                                  .data = (void *)(uintptr_t)data};
    if (w->error.status || lcm_eventlog_write_event(w->file, &event)) return fail(w, error);
    w->bytes += (int64_t)log_event_size(channel, size);
    if (w->begun) return STATUS_OK;
    w->begun = true;
    return log_flush(w, error);
}

int log_close(struct log_writer *w, struct error *error) {
    int status = log_flush(w, error);
    lcm_eventlog_destroy(w->file);
    free(w->path);
    free(w);
    return status;
}

size_t log_event_size(const char *channel, int size) { return HEADER_SIZE + strlen(channel) + (size_t)size; }

struct log_reader {
    int file;
    unsigned char *buffer;
    size_t capacity, begin, end; /* unread bytes: buffer[begin .. end) */
    int64_t offset;              /* of buffer[begin] in the file */
    bool ended, damaged;
    char channel[CHANNEL_MAX + 1];
};

/* More bytes behind those that are there. False at the end of the file, and when it
 * cannot be read on. */
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

/* The next `size` bytes, NULL when there are not so many. */
static const unsigned char *need(struct log_reader *r, size_t size) {
    while (r->end - r->begin < size)
        if (!fill(r)) return NULL;
    return r->buffer + r->begin;
}

static uint32_t read_u32(const unsigned char *p) { return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3]; }
static uint64_t read_u64(const unsigned char *p) { return (uint64_t)read_u32(p) << 32 | read_u32(p + 4); }

int log_open(struct log_reader **reader, const char *path, struct error *error) {
    struct log_reader *r = calloc(1, sizeof *r);
    *reader = NULL;
    if (!r || !(r->buffer = malloc(BUFFER_SIZE))) {
        free(r);
        return error_set(error, STATUS_IO, "%.250s: out of memory", path);
    }
    r->capacity = BUFFER_SIZE;
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

/* Size of the event that begins here by its header, 0 when that cannot be one. */
static size_t event_size(const unsigned char *header) {
    uint32_t channel = read_u32(header + 20), data = read_u32(header + 24);
    bool sound = read_u32(header) == sync_word && channel >= 1 && channel <= CHANNEL_MAX && data <= EVENT_MAX;
    return sound ? HEADER_SIZE + channel + data : 0;
}

int log_next(struct log_reader *r, struct log_event *event) {
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
