#include "csv_mcap.h"

#include <jansson.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zstd.h>

#include "csv_own.h"
#include "input.h"

enum {
    MAGIC_SIZE = 8,
    CHANNELS_MAX = UINT16_MAX + 1,
    COLUMNS_MAX = CSV_CELLS_MAX - 1,
    ARRAY_MOST = 64,
    DEPTH_MOST = 8,
    NAME_SIZE = CSV_CELL_NAME
};
enum { FOOTER = 2, CHANNEL = 4, MESSAGE = 5, CHUNK = 6, DATA_END = 15 }; /* opcodes */
static const char time_name[] = "log_time_s";
static const uint64_t RECORD_MOST = 256u << 20; /* largest size of a record, and of an unpacked
                                                 * chunk, bytes */

/* Place of a message's row in the text. */
struct place {
    uint64_t time_ns;
    long at;
};

/* Bytes that are being read; `bad` is set once more bytes are requested than are left. */
struct bytes {
    const unsigned char *at, *end;
    bool bad;
};

struct channel {
    bool known, json, own;
    char topic[NAME_SIZE];
};

struct mcap {
    const char *path;
    const struct csv_map *map;
    struct error *error;
    struct csv_texts *texts;
    struct channel channel[CHANNELS_MAX];
    char other[120];  /* encodings that are not JSON */
    bool any_json, any_own;
    bool write;       /* last pass: rows are written */
    bool wanted_only; /* only columns with a name in the map or one of hexid's own are taken */
    bool wide;        /* there are more columns than a text can have */
    struct csv_width width;
    int columns;
    char name[COLUMNS_MAX][NAME_SIZE];
    double value[COLUMNS_MAX]; /* value in the message being read */
    struct place *row;
    size_t rows, capacity;
    bool unsorted; /* a row has an earlier log time than the row before it */
    struct csv_own own;
};

static uint64_t number(struct bytes *b, int size) {
    uint64_t value = 0;
    if (b->end - b->at < size) b->bad = true;
    for (int i = 0; i < size && !b->bad; i++) value |= (uint64_t)b->at[i] << 8 * i;
    if (!b->bad) b->at += size;
    return value;
}

/* Takes the next `size` bytes; `bad` if there are fewer. */
static struct bytes piece(struct bytes *b, uint64_t size) {
    if (b->bad || (uint64_t)(b->end - b->at) < size) {
        b->bad = true;
        return (struct bytes){.bad = true};
    }
    b->at += size;
    return (struct bytes){.at = b->at - size, .end = b->at};
}

static void text(struct bytes *b, char *to, size_t size) {
    struct bytes t = piece(b, number(b, 4));
    snprintf(to, size, "%.*s", t.bad ? 0 : (int)(t.end - t.at < (ptrdiff_t)size ? t.end - t.at : (ptrdiff_t)size - 1), (const char *)t.at);
}

static void take_channel(struct mcap *m, struct bytes b) {
    char topic[NAME_SIZE], encoding[16];
    uint64_t id = number(&b, 2);
    number(&b, 2);
    text(&b, topic, sizeof topic);
    text(&b, encoding, sizeof encoding);
    if (b.bad || id >= CHANNELS_MAX) return;
    struct channel *c = &m->channel[id];
    *c = (struct channel){.known = true, .json = !strcmp(encoding, "json"), .own = !strcmp(topic, "/hexid/state")};
    snprintf(c->topic, sizeof c->topic, "%s", topic);
    m->any_json = m->any_json || c->json;
    m->any_own = m->any_own || (c->own && c->json);
    size_t used = strlen(m->other);
    if (!c->json && !strstr(m->other, encoding)) snprintf(m->other + used, sizeof m->other - used, "%s%s", used ? ", " : "", encoding);
}

/* Returns the column of a name, and adds it in the passes before rows are written; -1: it is not
 * wanted, or there are too many columns. */
static int column_of(struct mcap *m, const char *name) {
    int i = 0;
    while (i < m->columns && strcmp(m->name[i], name)) i++;
    if (i < m->columns) return i;
    if (m->write || m->wide || (m->wanted_only && !csv_is_wanted(m->map, name))) return -1;
    m->wide = !csv_width_add(&m->width, name);
    if (m->wide || m->columns == COLUMNS_MAX) return -1;
    snprintf(m->name[m->columns++], NAME_SIZE, "%s", name);
    return i;
}

/* Takes every number of a value, under its path. */
static void flatten(struct mcap *m, const char *name, const json_t *value, int depth) {
    char longer[NAME_SIZE];
    const char *key;
    const json_t *member;
    bool is_number = json_is_number(value) || json_is_boolean(value);
    int column = is_number ? column_of(m, name) : -1;
    if (column >= 0) m->value[column] = json_is_number(value) ? json_number_value(value) : (double)json_is_true(value);
    if (is_number || depth == DEPTH_MOST) return;
    json_object_foreach((json_t *)(uintptr_t)value, key, member) {
        if (snprintf(longer, sizeof longer, "%s.%s", name, key) < (int)sizeof longer) flatten(m, longer, member, depth + 1);
    }
    for (size_t i = 0; i < json_array_size(value) && i < ARRAY_MOST; i++)
        if (snprintf(longer, sizeof longer, "%s.%zu", name, i) < (int)sizeof longer)
            flatten(m, longer, json_array_get(value, i), depth + 1);
}

static bool keep_place(struct mcap *m, uint64_t time_ns, long at) {
    if (m->rows == m->capacity) {
        size_t capacity = m->capacity ? 2 * m->capacity : 4096;
        struct place *more = realloc(m->row, capacity * sizeof *more);
        if (!more) return false;
        m->row = more, m->capacity = capacity;
    }
    m->unsorted = m->unsorted || (m->rows && time_ns < m->row[m->rows - 1].time_ns);
    m->row[m->rows++] = (struct place){time_ns, at};
    return true;
}

static bool write_row(struct mcap *m, uint64_t time_ns) {
    FILE *file = m->texts->file;
    bool any = false;
    for (int i = 0; i < m->columns; i++) any = any || !isnan(m->value[i]);
    if (!any) return true;
    if (!keep_place(m, time_ns, ftell(file))) return false;
    fprintf(file, "%llu.%09llu", (unsigned long long)(time_ns / 1000000000), (unsigned long long)(time_ns % 1000000000));
    for (int i = 0; i < m->columns; i++) csv_texts_number(m->texts, ',', m->value[i]);
    return fputc('\n', file) != EOF && csv_texts_good(m->texts);
}

static bool take_own(struct mcap *m, const json_t *message) {
    double value[CYCLE_COLUMNS];
    for (int i = 0; i < CYCLE_COLUMNS; i++) {
        const json_t *member = json_object_get(message, cycle_columns[i].name);
        value[i] = json_is_number(member) ? json_number_value(member) : (double)NAN;
    }
    return !m->write || csv_own_row(&m->own, m->texts, value);
}

static int take_message(struct mcap *m, struct bytes b) {
    uint64_t id = number(&b, 2);
    number(&b, 4);
    uint64_t time_ns = number(&b, 8);
    number(&b, 8);
    const struct channel *c = id < CHANNELS_MAX ? &m->channel[id] : NULL;
    if (b.bad || !c || !c->json || (m->any_own && !c->own)) return STATUS_OK;
    json_t *message = json_loadb((const char *)b.at, (size_t)(b.end - b.at), JSON_DECODE_ANY | JSON_DECODE_INT_AS_REAL, NULL);
    bool done = true;
    for (int i = 0; i < m->columns; i++) m->value[i] = (double)NAN;
    if (message && m->any_own) done = take_own(m, message);
    else if (message) {
        flatten(m, c->topic, message, 0);
        done = !m->write || write_row(m, time_ns);
    }
    json_decref(message);
    return done ? STATUS_OK : csv_texts_refuse(m->texts, m->path, m->error);
}

static int take_record(struct mcap *m, int opcode, struct bytes b);

static int take_records(struct mcap *m, struct bytes b) {
    int status = STATUS_OK;
    while (b.at < b.end && !b.bad && !status) {
        int opcode = (int)number(&b, 1);
        struct bytes record = piece(&b, number(&b, 8));
        if (!record.bad && opcode != CHUNK) status = take_record(m, opcode, record);
    }
    return b.bad && !status ? error_set(m->error, STATUS_USAGE, "%.250s: a chunk of this MCAP file is damaged", m->path) : status;
}

static int take_chunk(struct mcap *m, struct bytes b) {
    char compression[16];
    number(&b, 8), number(&b, 8);
    uint64_t size = number(&b, 8);
    number(&b, 4);
    text(&b, compression, sizeof compression);
    struct bytes packed = piece(&b, number(&b, 8));
    if (b.bad || size > RECORD_MOST) return error_set(m->error, STATUS_USAGE, "%.250s: a chunk of this MCAP file is damaged", m->path);
    if (!*compression) return take_records(m, packed);
    if (strcmp(compression, "zstd"))
        return error_set(m->error, STATUS_USAGE,
                         "%.250s: chunks are compressed with %.10s; `mcap compress --compression zstd` makes a file that hexid reads",
                         m->path, compression);
    unsigned char *plain = malloc(size ? size : 1);
    if (!plain) return error_set(m->error, STATUS_IO, "%.250s: out of memory", m->path);
    size_t got = ZSTD_decompress(plain, size, packed.at, (size_t)(packed.end - packed.at));
    int status = ZSTD_isError(got) || got != size
                     ? error_set(m->error, STATUS_USAGE, "%.250s: a chunk of this MCAP file is damaged", m->path)
                     : take_records(m, (struct bytes){.at = plain, .end = plain + got});
    free(plain);
    return status;
}

static int take_record(struct mcap *m, int opcode, struct bytes b) {
    if (opcode == CHANNEL) take_channel(m, b);
    if (opcode == MESSAGE) return take_message(m, b);
    return opcode == CHUNK ? take_chunk(m, b) : STATUS_OK;
}

static int refuse_large(const struct mcap *m, uint64_t size) {
    return error_set(
        m->error, STATUS_USAGE,
        "%.250s: a record of %llu bytes, and at most %d MiB are read: if the file is damaged, `mcap recover` makes one that is not",
        m->path, (unsigned long long)size, (int)(RECORD_MOST >> 20));
}

/* Reads the file's records one after the other. A file that is cut off is read up to there. */
static int read_file(struct mcap *m, FILE *file) {
    unsigned char head[9], *record = NULL;
    int status = fseek(file, MAGIC_SIZE, SEEK_SET) ? error_set(m->error, STATUS_IO, "%.250s: cannot be read", m->path) : STATUS_OK;
    m->texts->cut = true;
    while (!status && m->texts->cut && fread(head, 1, sizeof head, file) == sizeof head) {
        struct bytes b = {.at = head + 1, .end = head + sizeof head};
        uint64_t size = number(&b, 8);
        bool wanted = head[0] == CHANNEL || head[0] == MESSAGE || head[0] == CHUNK;
        m->texts->cut = head[0] != FOOTER && head[0] != DATA_END;
        if (!wanted && (size > LONG_MAX || fseek(file, (long)size, SEEK_CUR))) break;
        if (!wanted) continue;
        unsigned char *larger = size > RECORD_MOST ? NULL : realloc(record, size ? size : 1);
        if (!larger) status = size > RECORD_MOST ? refuse_large(m, size) : error_set(m->error, STATUS_IO, "%.250s: out of memory", m->path);
        else record = larger;
        if (status || fread(record, 1, size, file) != size) break;
        status = take_record(m, head[0], (struct bytes){.at = record, .end = record + size});
    }
    free(record);
    return status;
}

static int write_names(struct mcap *m) {
    FILE *file = m->any_own ? NULL : csv_texts_next(m->texts);
    if (m->any_own) return STATUS_OK;
    if (!file) return csv_texts_refuse(m->texts, m->path, m->error);
    fputs(time_name, file);
    for (int i = 0; i < m->columns; i++) {
        fputc(',', file);
        csv_texts_name(file, m->name[i]);
    }
    fputc('\n', file);
    return STATUS_OK;
}

static int by_time(const void *a, const void *b) {
    const struct place *x = a, *y = b;
    if (x->time_ns != y->time_ns) return x->time_ns < y->time_ns ? -1 : 1;
    return x->at < y->at ? -1 : x->at > y->at;
}

/* Copies the names, then the rows in the order of time. */
static bool copy_sorted(const struct mcap *m, FILE *from, FILE *to) {
    char *line = NULL;
    size_t size = 0;
    bool good = getline(&line, &size, from) > 0 && fputs(line, to) >= 0;
    for (size_t i = 0; i < m->rows && good; i++)
        good = !fseek(from, m->row[i].at, SEEK_SET) && getline(&line, &size, from) > 0 && fputs(line, to) >= 0;
    free(line);
    return good;
}

/* Sorts the rows by log time: a recorder writes messages as they arrive, and a merged file has the
 * messages of its parts one after the other. */
static int sort_rows(struct mcap *m) {
    struct csv_texts *t = m->texts;
    if (!m->unsorted) return STATUS_OK;
    qsort(m->row, m->rows, sizeof *m->row, by_time);
    FILE *to = csv_texts_next(t), *from = to ? fopen(t->opened[0], "r") : NULL;
    bool good = from && copy_sorted(m, from, to);
    if (from) fclose(from);
    if (!good) return csv_texts_refuse(t, m->path, m->error);
    csv_foreign_close(t->opened[0]);
    memcpy(t->opened[0], t->opened[1], sizeof t->opened[0]);
    t->count = 1;
    return STATUS_OK;
}

static int find_columns(struct mcap *m, FILE *file) {
    m->columns = 0, m->width = (struct csv_width){0};
    m->wide = !csv_width_add(&m->width, time_name);
    return read_file(m, file);
}

/* Finds the columns, then writes the rows. If there are too many columns, only named ones are
 * written (wanted_only), provided that the map gives its columns by names. */
static int read_all(struct mcap *m, FILE *file) {
    int status = find_columns(m, file);
    m->wanted_only = m->wide && csv_map_names(m->map);
    if (!status && m->wanted_only) status = find_columns(m, file);
    if (!status && m->wide) return csv_width_refuse(&m->width, m->path, m->error);
    if (status) return status;
    if (!m->any_json)
        return error_set(
            m->error, STATUS_USAGE,
            "%.250s: no topic of JSON messages, but of %.60s: convert it to CSV (PlotJuggler, `ros2 bag` with a script) and import that",
            m->path, *m->other ? m->other : "none");
    m->write = true;
    status = write_names(m);
    if (!status) status = read_file(m, file);
    if (!status) status = sort_rows(m);
    if (!status && m->any_own && !m->texts->count)
        return error_set(m->error, STATUS_USAGE, "%.250s: none of its cycles is part of a test", m->path);
    return status;
}

int csv_mcap_read(const char *path, const struct csv_map *map, struct csv_texts *texts, struct error *error) {
    const char *reason = "out of memory";
    struct mcap *m = calloc(1, sizeof *m);
    int descriptor = input_open(path, &reason), status;
    FILE *file = descriptor < 0 ? NULL : fdopen(descriptor, "rb");
    if (m && file) {
        m->path = path, m->map = map, m->texts = texts, m->error = error;
        status = read_all(m, file);
    } else {
        status = error_set(error, STATUS_IO, "%.250s: cannot be read: %s", path, reason);
    }
    if (file) fclose(file);
    else if (descriptor >= 0) close(descriptor);
    if (m) free(m->row);
    free(m);
    return status;
}
