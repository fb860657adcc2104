#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cycle_columns.h"
#include "log_export.h"
#include "mat_library.h"
#include "messages.h"
#include "output.h"

/* A variable in format 5, such as a struct, has at most 2 GiB, which limits cycles and messages: 2
 * h 13 min of cycles of 2 ms. */
enum { COLUMNS = 1 + CYCLE_COLUMNS, CYCLES_MAX = 4000000, MESSAGES_MAX = 100000, MESSAGE_BYTES_MAX = 64 << 20 };

/* A value of a column; both types are 8 bytes wide. */
union cell {
    double real;
    int64_t integer;
};

struct kept {
    const struct message_type *type;
    void *data;
    int size;
};

struct mat_export {
    struct mat_library library;
    struct output output;
    FILE *file;
    int failure;
    bool too_long;                    /* the log is too long for the format */
    size_t cycles, capacity;
    union cell *column[COLUMNS];      /* values of time_s, then those of cycle_columns */
    struct kept *message;
    size_t messages, message_capacity, message_bytes;
};

static void fail(struct mat_export *e, int reason) {
    if (!e->failure) e->failure = reason;
}

static void too_long(struct mat_export *e) {
    e->too_long = true;
    fail(e, EFBIG);
}

static int mat_open(void **to, const char *path, struct error *error) {
    struct mat_export *e = calloc(1, sizeof *e);
    *to = NULL;
    if (!e) return error_set(error, STATUS_IO, "%.250s: out of memory", path);
    if (!mat_library_load(&e->library, error) && !output_prepare(&e->output, path, OUTPUT_NEW, error) &&
        (e->file = output_open(&e->output, error)) != NULL) {
        *to = e;
        return STATUS_OK;
    }
    free(e);
    return error->status;
}

static bool grow(struct mat_export *e) {
    size_t capacity = e->capacity ? 2 * e->capacity : 4096;
    for (int i = 0; i < COLUMNS; i++) {
        union cell *larger = realloc(e->column[i], capacity * sizeof *larger);
        if (!larger) return false;
        e->column[i] = larger;
    }
    e->capacity = capacity;
    return true;
}

static void mat_cycle(void *to, int64_t utime_us, double time_s, const struct cycle *c) {
    struct mat_export *e = to;
    (void)utime_us;
    if (e->cycles == CYCLES_MAX) too_long(e);
    if (!e->failure && e->cycles == e->capacity && !grow(e)) fail(e, ENOMEM);
    if (e->failure) return;
    e->column[0][e->cycles].real = time_s;
    for (int i = 0; i < CYCLE_COLUMNS; i++) {
        union cell *cell = &e->column[1 + i][e->cycles];
        if (column_is_real(i)) cell->real = column_real(c, i);
        else cell->integer = column_integer(c, i);
    }
    e->cycles++;
}

/* Keeps the message as it came; it is converted when all messages of its type are known. */
static void mat_message(void *to, int64_t utime_us, const struct message *m) {
    struct mat_export *e = to;
    (void)utime_us;
    if (e->messages == MESSAGES_MAX || e->message_bytes + (size_t)m->size > MESSAGE_BYTES_MAX) too_long(e);
    if (!e->failure && e->messages == e->message_capacity) {
        size_t capacity = e->message_capacity ? 2 * e->message_capacity : 64;
        struct kept *larger = realloc(e->message, capacity * sizeof *larger);
        if (larger) e->message = larger, e->message_capacity = capacity;
        else fail(e, ENOMEM);
    }
    void *data = e->failure ? NULL : malloc((size_t)m->size);
    if (!data) {
        fail(e, ENOMEM);
        return;
    }
    memcpy(data, m->data, (size_t)m->size);
    e->message[e->messages++] = (struct kept){.type = m->type, .data = data, .size = m->size};
    e->message_bytes += (size_t)m->size;
}

static int mat_failed(const void *to) { return ((const struct mat_export *)to)->failure; }

/* Makes a numeric variable, column-major. `borrowed` data are not copied and must outlive the
 * variable. */
static matvar_t *numbers(struct mat_export *e, bool real, size_t rows, size_t columns, void *data, bool borrowed) {
    size_t dims[2] = {rows, columns};
    matvar_t *v = e->library.variable(NULL, real ? MAT_C_DOUBLE : MAT_C_INT64, real ? MAT_T_DOUBLE : MAT_T_INT64, 2, dims, data,
                                      borrowed ? MAT_F_DONT_COPY_DATA : 0);
    if (!v) fail(e, ENOMEM);
    return v;
}

/* Makes a text variable in ASCII, because programs differ in how they read other encodings. */
static matvar_t *characters(struct mat_export *e, const char *text) {
    size_t length = strlen(text), dims[2] = {length ? 1 : 0, length};
    char *ascii = strdup(text);
    for (char *p = ascii; p && *p; p++)
        if ((unsigned char)*p >= 0x80) *p = '?';
    matvar_t *v = ascii ? e->library.variable(NULL, MAT_C_CHAR, MAT_T_UTF8, 2, dims, ascii, 0) : NULL;
    free(ascii);
    if (!v) fail(e, ENOMEM);
    return v;
}

static matvar_t *structure(struct mat_export *e, const char *name, size_t count, const char **fields, unsigned field_count) {
    size_t dims[2] = {1, count};
    matvar_t *v = e->library.structure(name, 2, dims, fields, field_count);
    if (!v) fail(e, ENOMEM);
    return v;
}

static void set(struct mat_export *e, matvar_t *structure, const char *field, size_t index, matvar_t *value) {
    if (structure && value) e->library.set(structure, field, index, value);
    else if (value) e->library.free(value);
}

static matvar_t *units(struct mat_export *e) {
    const char *names[COLUMNS] = {"time_s"};
    for (int i = 0; i < CYCLE_COLUMNS; i++) names[1 + i] = cycle_columns[i].name;
    matvar_t *v = structure(e, NULL, 1, names, COLUMNS);
    set(e, v, "time_s", 0, characters(e, "s"));
    for (int i = 0; i < CYCLE_COLUMNS; i++) set(e, v, cycle_columns[i].name, 0, characters(e, cycle_columns[i].unit));
    return v;
}

static matvar_t *texts(struct mat_export *e, const struct message *m, int field) {
    size_t dims[2] = {(size_t)m->value[field].count, 1};
    matvar_t **cells = calloc(dims[0] + 1, sizeof *cells);
    for (size_t i = 0; cells && i < dims[0]; i++) cells[i] = characters(e, message_text(m, field, (int)i));
    matvar_t *v = cells ? e->library.variable(NULL, MAT_C_CELL, MAT_T_CELL, 2, dims, cells, 0) : NULL;
    free(cells);
    if (!v) fail(e, ENOMEM);
    return v;
}

static matvar_t *value_of(struct mat_export *e, const struct message *m, int field) {
    const struct field *f = &m->type->field[field];
    int count = m->value[field].count;
    bool real = f->kind == FIELD_REAL, matrix = f->count == DOFS * DOFS;
    if (f->kind == FIELD_TEXT) return f->count == 1 ? characters(e, message_text(m, field, 0)) : texts(e, m, field);
    union cell *cells = calloc((size_t)count + 1, sizeof *cells);
    for (int i = 0; cells && i < count; i++) {
        int from = matrix ? i % DOFS * DOFS + i / DOFS : i; /* a matrix is row-major in the message
                                                             * and column-major in the file */
        if (real) cells[i].real = message_real(m, field, from);
        else cells[i].integer = message_integer(m, field, from);
    }
    if (!cells) fail(e, ENOMEM);
    matvar_t *v = !cells ? NULL : numbers(e, real, matrix ? DOFS : (size_t)count, matrix ? DOFS : 1, cells, false);
    free(cells);
    return v;
}

/* Returns all messages of a type as an array of structs; NULL if there are none. */
static matvar_t *messages_of(struct mat_export *e, const struct message_type *type) {
    const char *names[FIELDS_MAX];
    unsigned fields = 0;
    size_t count = 0, place = 0;
    for (int i = 0; type->field[i].name; i++)
        if (type->field[i].kind != FIELD_COUNT) names[fields++] = type->field[i].name;
    for (size_t i = 0; i < e->messages; i++) count += e->message[i].type == type;
    matvar_t *v = count ? structure(e, NULL, count, names, fields) : NULL;
    for (size_t i = 0; v && i < e->messages; i++) {
        struct message m;
        if (e->message[i].type != type || !message_read(type->channel, e->message[i].data, e->message[i].size, &m)) continue;
        for (int f = 0; type->field[f].name; f++)
            if (type->field[f].kind != FIELD_COUNT) set(e, v, type->field[f].name, place, value_of(e, &m, f));
        place++;
    }
    return v;
}

static matvar_t *configuration(struct mat_export *e) {
    const char *text = "";
    size_t length;
    for (size_t i = 0; i < e->messages; i++)
        if (event_decode_config(e->message[i].data, e->message[i].size, &text, &length)) break;
    return characters(e, text);
}

/* Makes the struct `hexid`: columns, units, config, and the types of messages in the log. */
static matvar_t *everything(struct mat_export *e) {
    const char *names[COLUMNS + 2 + MESSAGE_TYPES] = {"time_s"};
    matvar_t *of_type[MESSAGE_TYPES];
    unsigned count = 1;
    for (int i = 0; i < CYCLE_COLUMNS; i++) names[count++] = cycle_columns[i].name;
    names[count++] = "units";
    names[count++] = "config";
    for (int i = 0; i < MESSAGE_TYPES; i++) {
        of_type[i] = messages_of(e, &message_types[i]);
        if (of_type[i]) names[count++] = message_types[i].name;
    }
    matvar_t *all = structure(e, "hexid", 1, names, count);
    for (int i = 0; i < COLUMNS; i++)
        set(e, all, names[i], 0, numbers(e, i == 0 || column_is_real(i - 1), e->cycles, 1, e->column[i], true));
    set(e, all, "units", 0, units(e));
    set(e, all, "config", 0, configuration(e));
    for (int i = 0; i < MESSAGE_TYPES; i++)
        if (of_type[i]) set(e, all, message_types[i].name, 0, of_type[i]);
    return all;
}

/* Checks that the file in memory ends where its single variable does. The variable's tag consists
 * of 15 (compressed) and its number of bytes (MAT-File Format, 1-9). */
static bool whole(int memory) {
    enum { TAG_AT = 128 };
    uint32_t tag[2];
    struct stat state;
    return pread(memory, tag, sizeof tag, TAG_AT) == sizeof tag && !fstat(memory, &state) && tag[0] == 15 &&
           state.st_size == (off_t)(TAG_AT + sizeof tag + tag[1]);
}

/* Returns true if the file in memory has reached the largest size of a file that this process may
 * write (RLIMIT_FSIZE). The file is then cut short, and its tag gives the size of what is left. */
static bool at_limit(int memory) {
    struct rlimit limit;
    struct stat state;
    return !getrlimit(RLIMIT_FSIZE, &limit) && !fstat(memory, &state) && limit.rlim_cur != RLIM_INFINITY &&
           state.st_size >= (off_t)limit.rlim_cur;
}

/* Writes the file through memory, because libmatio ignores the results of its writes: libmatio
 * writes to memory, the result is checked for completeness and copied to disk by calls that are
 * checked. */
static void write_through_memory(struct mat_export *e, matvar_t *all) {
    char path[40], piece[1 << 16];
    ssize_t got = 0;
    int memory = memfd_create("mat", MFD_CLOEXEC);
    snprintf(path, sizeof path, "/proc/self/fd/%d", memory);
    mat_t *mat = memory < 0 ? NULL : e->library.create(path, "MATLAB 5.0 MAT-file, written by hexid", MAT_FT_MAT5);
    bool wrong = !mat || e->library.write(mat, all, MAT_COMPRESSION_ZLIB);
    if (mat && e->library.close(mat)) wrong = true;
    if (memory >= 0 && at_limit(memory)) fail(e, EFBIG);
    if (wrong || !whole(memory)) fail(e, ENOMEM);
    while (!e->failure && (got = read(memory, piece, sizeof piece)) > 0)
        if (fwrite(piece, 1, (size_t)got, e->file) != (size_t)got) fail(e, errno);
    if (got < 0) fail(e, errno);
    if (memory >= 0) close(memory);
}

static int mat_close(void *to, struct error *error) {
    struct mat_export *e = to;
    if (!e->failure && e->cycles) {
        matvar_t *all = everything(e);
        if (all && !e->failure) write_through_memory(e, all);
        if (all) e->library.free(all);
    }
    int status = output_close(&e->output, e->file, e->failure, error);
    if (e->too_long)
        error_set(error, STATUS_IO, "%.250s: a .mat takes %d cycles and %d messages, and the log has more; take csv or mcap",
                  e->output.name, CYCLES_MAX, MESSAGES_MAX);
    for (int i = 0; i < COLUMNS; i++) free(e->column[i]);
    for (size_t i = 0; i < e->messages; i++) free(e->message[i].data);
    free(e->message);
    free(e);
    return status;
}

const struct export_format export_mat = {
    .name = "mat",
    .open = mat_open,
    .cycle = mat_cycle,
    .message = mat_message,
    .failed = mat_failed,
    .close = mat_close,
};
