#include "csv_mat.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "csv_own.h"
#include "input.h"
#include "mat_library.h"

enum { VECTORS_MAX = CSV_CELLS_MAX, LENGTH_LEAST = 2, CELL_BYTES = 8, DEPTH_MOST = 6, STRUCTS_MOST = 64, NAME_SIZE = CSV_CELL_NAME };

struct vector {
    char name[NAME_SIZE];
    size_t length;
    double *value;
    bool time;
};

struct mat {
    const char *path;
    const struct csv_map *map;
    struct csv_texts *texts;
    struct error *error;
    struct mat_library library;
    bool wanted_only; /* only times, and vectors with a name in the map or one of hexid's own, are
                       * taken */
    bool wide;        /* there are more vectors than a text can have columns */
    struct csv_width width;
    int vectors;
    struct vector vector[VECTORS_MAX];
    bool no_memory;
};

static bool is_integer(const matvar_t *v) {
    return v->data_type == MAT_T_INT8 || v->data_type == MAT_T_INT16 || v->data_type == MAT_T_INT32 || v->data_type == MAT_T_INT64;
}

/* Returns the number of bytes of an element; 0: it is no number. */
static int size_of(enum matio_types type) {
    if (type == MAT_T_DOUBLE || type == MAT_T_INT64 || type == MAT_T_UINT64) return 8;
    if (type == MAT_T_SINGLE || type == MAT_T_INT32 || type == MAT_T_UINT32) return 4;
    if (type == MAT_T_INT16 || type == MAT_T_UINT16) return 2;
    return type == MAT_T_INT8 || type == MAT_T_UINT8 ? 1 : 0;
}

/* Returns an element of a numeric array, whatever its type. */
static double element(const matvar_t *v, size_t i) {
    const char *at = (const char *)v->data + i * (size_t)v->data_size;
    int64_t integer = 0;
    uint64_t natural = 0;
    double real;
    float single;
    if (v->data_type == MAT_T_DOUBLE) return memcpy(&real, at, sizeof real), real;
    if (v->data_type == MAT_T_SINGLE) return memcpy(&single, at, sizeof single), (double)single;
    memcpy(&natural, at, (size_t)v->data_size); /* little-endian, as all of hexid's hosts are */
    if (!is_integer(v)) return (double)natural;
    memcpy(&integer, &natural, sizeof integer);
    int shift = 64 - 8 * v->data_size;
    return (double)((int64_t)((uint64_t)integer << shift) >> shift);
}

/* Returns true for a real array of two dimensions whose data are all there. */
static bool is_numeric(const matvar_t *v) {
    bool number = v->class_type >= MAT_C_DOUBLE && v->class_type <= MAT_C_UINT64;
    int size = size_of(v->data_type);
    size_t count;
    if (!size || v->data_size != size || !number || v->isComplex || v->rank != 2 || !v->data) return false;
    return !__builtin_mul_overflow(v->dims[0], v->dims[1], &count) && v->nbytes / (size_t)size >= count;
}

/* Returns true if a word of the name is time, as in simTime and log_time, but not in timeout. */
static bool has_time(const char *name) {
    static const char word[] = "time", longer[] = "stamp";
    for (const char *at = name; (at = strcasestr(at, word)); at++) {
        const char *end = at + strlen(word);
        if (!strncasecmp(end, longer, strlen(longer))) end += strlen(longer);
        bool begins = at == name || !isalpha((unsigned char)at[-1]) || (islower((unsigned char)at[-1]) && isupper((unsigned char)*at));
        bool ends = !isalpha((unsigned char)*end) || (islower((unsigned char)end[-1]) && isupper((unsigned char)*end));
        if (begins && ends) return true;
    }
    return false;
}

/* Returns true if most numbers are greater than the one before, as those of a clock are. */
static bool rises(const struct vector *v) {
    size_t greater = 0;
    for (size_t i = 1; i < v->length; i++) greater += v->value[i] > v->value[i - 1];
    return 2 * greater >= v->length;
}

/* Returns true if the name is that of a clock: the map says so, or, without a clock in the map, the
 * name itself. */
static bool is_time(const struct mat *m, const char *name) {
    const char *dot = strrchr(name, '.'), *own = dot ? dot + 1 : name;
    struct csv_unit unit;
    bool mapped = false;
    for (int i = 0; m->map && i < m->map->count; i++) {
        if (m->map->alias[i].column != CSV_T) continue;
        mapped = true;
        if (!strcmp(m->map->alias[i].name, name)) return true;
    }
    return !mapped && (!strcasecmp(own, "t") || csv_column_find(own, &unit) == CSV_T || has_time(own) || !strcasecmp(own, "tout"));
}

static void add(struct mat *m, const char *name, const matvar_t *v, size_t first, size_t length) {
    if (m->wide || length < LENGTH_LEAST || (m->wanted_only && !csv_is_wanted(m->map, name) && !is_time(m, name))) return;
    m->wide = !csv_width_add(&m->width, name);
    if (m->wide || m->vectors == VECTORS_MAX) return;
    struct vector *to = &m->vector[m->vectors];
    *to = (struct vector){.length = length, .value = malloc(length * sizeof *to->value)};
    snprintf(to->name, sizeof to->name, "%s", name);
    m->no_memory = m->no_memory || !to->value;
    for (size_t i = 0; to->value && i < length; i++) to->value[i] = element(v, first + i);
    to->time = to->value && is_time(m, name) && (csv_map_of(m->map, CSV_T) || rises(to));
    m->vectors += to->value != NULL;
}

/* Takes every vector in a variable, under its path. */
static void flatten(struct mat *m, const char *name, matvar_t *v, int depth) {
    char longer[NAME_SIZE];
    if (!v || depth == DEPTH_MOST) return;
    if (is_numeric(v)) {
        bool row = v->dims[0] == 1;
        if (row || v->dims[1] == 1) add(m, name, v, 0, v->dims[0] * v->dims[1]);
        for (size_t i = 0; !row && v->dims[1] > 1 && i < v->dims[1] && !m->wide; i++)
            if (snprintf(longer, sizeof longer, "%.60s.%zu", name, i + 1) < (int)sizeof longer)
                add(m, longer, v, i * v->dims[0], v->dims[0]);
        return;
    }
    if (v->class_type != MAT_C_STRUCT || v->rank != 2 || !v->data) return;
    unsigned fields = m->library.fields(v);
    char *const *names = m->library.names(v);
    size_t count;
    if (__builtin_mul_overflow(v->dims[0], v->dims[1], &count)) return;
    for (size_t i = 0; i < count && i < STRUCTS_MOST; i++) {
        for (unsigned f = 0; f < fields; f++) {
            int size = count > 1 ? snprintf(longer, sizeof longer, "%.40s.%zu.%s", name, i + 1, names[f])
                                 : snprintf(longer, sizeof longer, "%s.%s", name, names[f]);
            if (size < (int)sizeof longer) flatten(m, longer, m->library.field(v, f, i), depth + 1);
        }
    }
}

/* Returns the length of the struct's name in a vector's name, 3 for "run.force"; 0: no struct. */
static size_t stem(const struct vector *v) {
    const char *dot = strrchr(v->name, '.');
    return dot ? (size_t)(dot - v->name) : 0;
}

static bool together(const struct vector *a, const struct vector *b) {
    return a->length == b->length && stem(a) == stem(b) && !strncmp(a->name, b->name, stem(a));
}

/* Returns the index of a vector's clock: one of its length in its struct, else any of its length;
 * -1: none. */
static int clock_of(const struct mat *m, int i) {
    int clock = -1;
    if (m->vector[i].time) return i;
    for (int k = 0; k < m->vectors; k++) {
        if (!m->vector[k].time || m->vector[k].length != m->vector[i].length) continue;
        if (together(&m->vector[k], &m->vector[i])) return k;
        if (clock < 0) clock = k;
    }
    return clock;
}

/* Writes vectors beside each other; order: their indices. Shorter vectors end in empty cells of one
 * byte each. */
static int write_table(struct mat *m, const int *order, int count) {
    FILE *file = csv_texts_next(m->texts);
    size_t longest = 0;
    if (!file) return csv_texts_refuse(m->texts, m->path, m->error);
    for (int i = 0; i < count; i++) {
        if (m->vector[order[i]].length > longest) longest = m->vector[order[i]].length;
        if (i) fputc('\t', file);
        csv_texts_name(file, m->vector[order[i]].name);
    }
    for (size_t row = 0; row < longest && csv_texts_good(m->texts); row++)
        for (int i = 0; i < count; i++) {
            const struct vector *v = &m->vector[order[i]];
            csv_texts_number(m->texts, i ? '\t' : '\n', row < v->length ? v->value[row] : (double)NAN);
        }
    fputc('\n', file);
    return csv_texts_good(m->texts) ? STATUS_OK : csv_texts_refuse(m->texts, m->path, m->error);
}

/* Writes each clock in front of the vectors that it times. Without any clock only the vectors of
 * the greatest length are written; --map can then make the row's number their time (t=#0). */
static int write_vectors(struct mat *m) {
    int order[VECTORS_MAX], count = 0;
    size_t longest = 0;
    bool clocks = false;
    for (int i = 0; i < m->vectors; i++) {
        clocks = clocks || m->vector[i].time;
        if (m->vector[i].length > longest) longest = m->vector[i].length;
    }
    for (int k = 0; k < m->vectors; k++) {
        if (clocks ? !m->vector[k].time : m->vector[k].length != longest) continue;
        order[count++] = k;
        for (int i = 0; i < m->vectors && clocks; i++)
            if (i != k && clock_of(m, i) == k) order[count++] = i;
    }
    return write_table(m, order, count);
}

/* A file of hexid's own has a struct `hexid` with the columns of all cycles. */
static bool is_own(const struct mat *m) {
    for (int i = 0; i < m->vectors; i++)
        if (!strcmp(m->vector[i].name, "hexid.test_time_s")) return true;
    return false;
}

static int write_own(struct mat *m) {
    const struct vector *from[CYCLE_COLUMNS] = {NULL};
    struct csv_own own = {0};
    size_t rows = 0;
    for (int i = 0; i < m->vectors; i++) {
        const char *name = m->vector[i].name;
        int column = strncmp(name, "hexid.", 6) ? -1 : csv_own_column(name + 6);
        if (column >= 0) from[column] = &m->vector[i], rows = m->vector[i].length;
    }
    for (size_t row = 0; row < rows; row++) {
        double value[CYCLE_COLUMNS];
        for (int i = 0; i < CYCLE_COLUMNS; i++) value[i] = from[i] && row < from[i]->length ? from[i]->value[row] : (double)NAN;
        if (!csv_own_row(&own, m->texts, value)) return csv_texts_refuse(m->texts, m->path, m->error);
    }
    return m->texts->count ? STATUS_OK : error_set(m->error, STATUS_USAGE, "%.250s: none of its cycles is part of a test", m->path);
}

static void free_vectors(struct mat *m) {
    for (int i = 0; i < m->vectors; i++) free(m->vector[i].value);
    m->vectors = 0, m->width = (struct csv_width){0}, m->wide = false;
}

static int read_variables(struct mat *m, int descriptor) {
    char opened[CSV_OPENED_SIZE];
    free_vectors(m);
    snprintf(opened, sizeof opened, "/proc/self/fd/%d", descriptor);
    mat_t *file = m->library.open(opened, MAT_ACC_RDONLY);
    if (!file) return error_set(m->error, STATUS_USAGE, "%.250s: damaged: no MAT file of format 5", m->path);
    for (matvar_t *v; (v = m->library.next(file));) {
        if (v->name) flatten(m, v->name, v, 0);
        m->library.free(v);
    }
    m->library.close(file);
    if (m->no_memory) return error_set(m->error, STATUS_IO, "%.250s: out of memory", m->path);
    if (!m->vectors && m->wanted_only)
        return error_set(m->error, STATUS_USAGE, "%.250s: none of its vectors has a name that --map gives", m->path);
    if (!m->vectors)
        return error_set(
            m->error, STATUS_USAGE,
            "%.250s: no vector of real numbers in it: tables and timeseries are MATLAB's own objects; save their Time and Data as vectors",
            m->path);
    return STATUS_OK;
}

/* Returns true if the table of all vectors, in which short columns end in empty cells, is too
 * large. */
static bool is_large(const struct mat *m) {
    size_t longest = 0, cells;
    for (int i = 0; i < m->vectors; i++) longest = m->vector[i].length > longest ? m->vector[i].length : longest;
    return __builtin_mul_overflow(longest, (size_t)m->vectors, &cells) || cells > (size_t)CSV_TEXTS_BYTES / CELL_BYTES;
}

/* Reads the vectors and writes their text. From a file that is too wide or too large, only times
 * and named columns are taken (wanted_only), if the map gives its columns by names. */
static int read_all(struct mat *m, int descriptor) {
    int status = read_variables(m, descriptor);
    m->wanted_only = (m->wide || is_large(m)) && csv_map_names(m->map) && !is_own(m);
    if (!status && m->wanted_only) status = read_variables(m, descriptor);
    if (status) return status;
    if (m->wide) return csv_width_refuse(&m->width, m->path, m->error);
    return is_own(m) ? write_own(m) : write_vectors(m);
}

/* Refuses formats other than 5; format 7.3 is HDF5. The version follows 124 bytes of text, and is
 * 0x0100 in format 5. */
static int check_version(const char *path, int descriptor, struct error *error) {
    unsigned char head[128] = {0};
    bool whole = pread(descriptor, head, sizeof head, 0) == sizeof head;
    bool little = head[126] == 'I', hdf = !memcmp(head, "\x89HDF", 4) || !memcmp(head, "MATLAB 7.3", 10);
    if (hdf)
        return error_set(error, STATUS_USAGE, "%.250s: MAT format 7.3 (HDF5), which hexid does not read: in MATLAB save(NAME, '-v7')",
                         path);
    if (!whole || head[little ? 125 : 124] != 1) return error_set(error, STATUS_USAGE, "%.250s: damaged: no MAT file of format 5", path);
    return STATUS_OK;
}

int csv_mat_read(const char *path, const struct csv_map *map, struct csv_texts *texts, struct error *error) {
    const char *reason = "out of memory";
    struct mat *m = calloc(1, sizeof *m);
    int descriptor = input_open(path, &reason), status = STATUS_OK;
    if (!m || descriptor < 0) status = error_set(error, STATUS_IO, "%.250s: cannot be read: %s", path, reason);
    if (!status) status = check_version(path, descriptor, error);
    if (!status) status = mat_library_load(&m->library, error);
    if (!status) {
        m->path = path, m->map = map, m->texts = texts, m->error = error;
        status = read_all(m, descriptor);
    }
    if (m) free_vectors(m);
    free(m);
    if (descriptor >= 0) close(descriptor);
    return status;
}
