#include "mcap.h"

#include <assert.h>
#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>
#include <zstd.h>

#include "output.h"

enum { CHUNK_SIZE = 1 << 20, COMPRESSION_LEVEL = 3 };
enum opcode {
    HEADER = 1,
    FOOTER = 2,
    SCHEMA = 3,
    CHANNEL = 4,
    MESSAGE = 5,
    CHUNK = 6,
    MESSAGE_INDEX = 7,
    CHUNK_INDEX = 8,
    STATISTICS = 11,
    SUMMARY_OFFSET = 14,
    DATA_END = 15,
};
static const char magic[] = "\x89MCAP0\r\n", compression[] = "zstd";
enum { MAGIC_SIZE = sizeof magic - 1 };

struct bytes {
    unsigned char *data;
    size_t size, capacity;
    bool failed; /* memory ran out, so that nothing more is added */
};

struct channel {
    uint64_t messages;
    struct bytes index; /* time and offset of each message in the current chunk */
};

struct chunk {
    struct bytes records;
    uint64_t messages, begin_ns, end_ns;
};

struct mcap_writer {
    struct output output;
    FILE *file;
    int failure;
    uint64_t offset;
    uint32_t crc;           /* checksum of everything written since it was last reset to 0 */
    struct chunk chunk;
    struct bytes out;       /* output buffer */
    struct bytes schemas, channels, chunks; /* records that the summary repeats */
    uint32_t chunk_count;
    uint64_t messages, begin_ns, end_ns;
    struct channel channel[MCAP_CHANNELS_MAX];
    int channel_count;
};

static void *room(struct bytes *b, size_t size) {
    if (b->capacity - b->size < size && !b->failed) {
        size_t capacity = 2 * (b->size + size);
        unsigned char *data = realloc(b->data, capacity);
        b->failed = !data;
        if (data) b->data = data, b->capacity = capacity;
    }
    return b->failed ? NULL : b->data + b->size;
}

static void put(struct bytes *b, const void *data, size_t size) {
    void *place = room(b, size);
    if (!place || !size) return;
    memcpy(place, data, size);
    b->size += size;
}

static void patch(unsigned char *place, uint64_t value, int bytes) {
    for (int i = 0; i < bytes; i++) place[i] = (unsigned char)(value >> 8 * i);
}

static void put_number(struct bytes *b, uint64_t value, int bytes) {
    unsigned char little[8];
    patch(little, value, bytes);
    put(b, little, (size_t)bytes);
}
static void put_u16(struct bytes *b, int value) { put_number(b, (uint64_t)value, 2); }
static void put_u32(struct bytes *b, size_t value) { put_number(b, value, 4); }
static void put_u64(struct bytes *b, uint64_t value) { put_number(b, value, 8); }

static void put_text(struct bytes *b, const char *text) {
    put_u32(b, strlen(text));
    put(b, text, strlen(text));
}

/* Starts a record and returns its position for record_end(), which fills in the length. */
static size_t record_begin(struct bytes *b, enum opcode opcode) {
    put_number(b, opcode, 1);
    put_u64(b, 0);
    return b->size;
}

static void record_end(struct bytes *b, size_t begin) {
    if (!b->failed) patch(b->data + begin - 8, b->size - begin, 8);
}

static void fail(struct mcap_writer *w, int reason) {
    if (!w->failure) w->failure = reason;
}

static void flush(struct mcap_writer *w, struct bytes *b) {
    if (b->failed) fail(w, ENOMEM);
    if (!w->failure && b->size) {
        if (fwrite(b->data, 1, b->size, w->file) != b->size) fail(w, errno);
        w->offset += b->size;
        w->crc = (uint32_t)crc32_z(w->crc, b->data, b->size);
    }
    b->size = 0;
}

int mcap_create(struct mcap_writer **writer, const char *path, struct error *error) {
    struct mcap_writer *w = calloc(1, sizeof *w);
    *writer = NULL;
    if (!w) return error_set(error, STATUS_IO, "%.250s: out of memory", path);
    if (output_prepare(&w->output, path, OUTPUT_NEW, error) || !(w->file = output_open(&w->output, error))) {
        free(w);
        return error->status;
    }
    put(&w->out, magic, MAGIC_SIZE);
    size_t header = record_begin(&w->out, HEADER);
    put_text(&w->out, "");      /* profile; hexid's files have none */
    put_text(&w->out, "hexid");
    record_end(&w->out, header);
    flush(w, &w->out);
    *writer = w;
    return STATUS_OK;
}

/* Ends a definition and copies it from the summary into the current chunk, because a reader needs
 * it before the messages. */
static void define(struct mcap_writer *w, struct bytes *summary, size_t begin) {
    record_end(summary, begin);
    if (!summary->failed) put(&w->chunk.records, summary->data + begin - 9, summary->size - begin + 9);
}

int mcap_channel(struct mcap_writer *w, const char *topic, const char *schema_name, const char *schema) {
    int id = w->channel_count++;
    assert(id < MCAP_CHANNELS_MAX);
    size_t record = record_begin(&w->schemas, SCHEMA);
    put_u16(&w->schemas, id + 1); /* ids begin at 1, because 0 means no schema */
    put_text(&w->schemas, schema_name);
    put_text(&w->schemas, "jsonschema");
    put_text(&w->schemas, schema);
    define(w, &w->schemas, record);
    record = record_begin(&w->channels, CHANNEL);
    put_u16(&w->channels, id);
    put_u16(&w->channels, id + 1);
    put_text(&w->channels, topic);
    put_text(&w->channels, "json");
    put_u32(&w->channels, 0); /* metadata */
    define(w, &w->channels, record);
    return id;
}

static void put_message_index(struct bytes *out, int id, const struct bytes *index) {
    size_t record = record_begin(out, MESSAGE_INDEX);
    put_u16(out, id);
    put_u32(out, index->size);
    put(out, index->data, index->size);
    record_end(out, record);
}

static void put_chunk(struct mcap_writer *w, const struct chunk *c, size_t *compressed) {
    struct bytes *out = &w->out;
    size_t record = record_begin(out, CHUNK), bound = ZSTD_compressBound(c->records.size);
    put_u64(out, c->begin_ns);
    put_u64(out, c->end_ns);
    put_u64(out, c->records.size);
    put_u32(out, crc32_z(0, c->records.data, c->records.size));
    put_text(out, compression);
    put_u64(out, 0);
    size_t begin = out->size;
    void *place = room(out, bound);
    *compressed = place ? ZSTD_compress(place, bound, c->records.data, c->records.size, COMPRESSION_LEVEL) : 0;
    if (!place || ZSTD_isError(*compressed)) {
        fail(w, ENOMEM);
        *compressed = 0;
    } else patch(out->data + begin - 8, *compressed, 8);
    out->size += *compressed;
    record_end(out, record);
}

static void end_chunk(struct mcap_writer *w) {
    struct chunk *c = &w->chunk;
    struct bytes *out = &w->out, *summary = &w->chunks, offsets = {0};
    size_t compressed;
    if (c->records.failed) fail(w, ENOMEM);
    if (w->failure || !c->records.size) return;
    put_chunk(w, c, &compressed);
    size_t chunk_size = out->size;
    for (int i = 0; i < w->channel_count; i++) {
        struct bytes *index = &w->channel[i].index;
        if (index->failed) fail(w, ENOMEM);
        if (!index->size) continue;
        put_u16(&offsets, i);
        put_u64(&offsets, w->offset + out->size);
        put_message_index(out, i, index);
        index->size = 0;
    }
    size_t record = record_begin(summary, CHUNK_INDEX);
    put_u64(summary, c->begin_ns);
    put_u64(summary, c->end_ns);
    put_u64(summary, w->offset);
    put_u64(summary, chunk_size);
    put_u32(summary, offsets.size);
    put(summary, offsets.data, offsets.size);
    put_u64(summary, out->size - chunk_size);
    put_text(summary, compression);
    put_u64(summary, compressed);
    put_u64(summary, c->records.size);
    record_end(summary, record);
    if (offsets.failed) fail(w, ENOMEM);
    free(offsets.data);
    flush(w, out);
    w->chunk_count++;
    c->records.size = 0;
    c->messages = 0;
}

static void widen(uint64_t messages, uint64_t time_ns, uint64_t *begin_ns, uint64_t *end_ns) {
    if (!messages || time_ns < *begin_ns) *begin_ns = time_ns;
    if (!messages || time_ns > *end_ns) *end_ns = time_ns;
}

void mcap_message(struct mcap_writer *w, int channel, uint64_t time_ns, const void *data, size_t size) {
    struct chunk *c = &w->chunk;
    if (w->failure) return;
    widen(w->messages++, time_ns, &w->begin_ns, &w->end_ns);
    widen(c->messages++, time_ns, &c->begin_ns, &c->end_ns);
    put_u64(&w->channel[channel].index, time_ns);
    put_u64(&w->channel[channel].index, c->records.size);
    size_t record = record_begin(&c->records, MESSAGE);
    put_u16(&c->records, channel);
    put_u32(&c->records, (uint32_t)w->channel[channel].messages++);
    put_u64(&c->records, time_ns); /* logged */
    put_u64(&c->records, time_ns); /* published */
    put(&c->records, data, size);
    record_end(&c->records, record);
    if (c->records.size >= CHUNK_SIZE || c->records.failed) end_chunk(w);
}

int mcap_failure(const struct mcap_writer *w) { return w->failure; }

static void put_statistics(struct bytes *out, const struct mcap_writer *w) {
    size_t record = record_begin(out, STATISTICS);
    put_u64(out, w->messages);
    put_u16(out, w->channel_count); /* schemas */
    put_u32(out, (size_t)w->channel_count);
    put_u32(out, 0);                /* attachments */
    put_u32(out, 0);                /* metadata */
    put_u32(out, w->chunk_count);
    put_u64(out, w->begin_ns);
    put_u64(out, w->end_ns);
    put_u32(out, (size_t)w->channel_count * 10);
    for (int i = 0; i < w->channel_count; i++) {
        put_u16(out, i);
        put_u64(out, w->channel[i].messages);
    }
    record_end(out, record);
}

/* Writes a group of records of the summary and adds its position to the summary's offsets. */
static void put_group(struct mcap_writer *w, struct bytes *group, enum opcode opcode, struct bytes *offsets) {
    if (group->failed) fail(w, ENOMEM);
    if (!group->size) return;
    size_t record = record_begin(offsets, SUMMARY_OFFSET);
    put_number(offsets, opcode, 1);
    put_u64(offsets, w->offset);
    put_u64(offsets, group->size);
    record_end(offsets, record);
    flush(w, group);
}

static void put_summary(struct mcap_writer *w) {
    struct bytes statistics = {0}, offsets = {0};
    uint64_t summary = w->offset;
    w->crc = 0;
    put_statistics(&statistics, w);
    put_group(w, &w->schemas, SCHEMA, &offsets);
    put_group(w, &w->channels, CHANNEL, &offsets);
    put_group(w, &statistics, STATISTICS, &offsets);
    put_group(w, &w->chunks, CHUNK_INDEX, &offsets);
    uint64_t summary_offsets = w->offset;
    flush(w, &offsets);
    put_number(&w->out, FOOTER, 1);
    put_u64(&w->out, 20); /* length of the footer; the checksum includes it */
    put_u64(&w->out, summary);
    put_u64(&w->out, summary_offsets);
    flush(w, &w->out);
    put_u32(&w->out, w->crc);
    put(&w->out, magic, MAGIC_SIZE);
    flush(w, &w->out);
    free(statistics.data);
    free(offsets.data);
}

int mcap_close(struct mcap_writer *w, int failure, struct error *error) {
    if (failure) fail(w, failure);
    end_chunk(w);
    size_t record = record_begin(&w->out, DATA_END);
    put_u32(&w->out, w->crc);
    record_end(&w->out, record);
    flush(w, &w->out);
    put_summary(w);
    int status = output_close(&w->output, w->file, w->failure, error);
    struct bytes *all[] = {&w->chunk.records, &w->out, &w->schemas, &w->channels, &w->chunks};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) free(all[i]->data);
    for (int i = 0; i < w->channel_count; i++) free(w->channel[i].index.data);
    free(w);
    return status;
}
