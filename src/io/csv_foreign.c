#include "csv_foreign.h"

#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "csv_mat.h"
#include "csv_mcap.h"
#include "input.h"
#include "number_text.h"

FILE *csv_texts_next(struct csv_texts *t) {
    if (t->file && (fflush(t->file) || ferror(t->file))) return NULL;
    if (t->count == CSV_TEXTS_MAX) return t->full = true, NULL;
    int memory = memfd_create("csv", MFD_CLOEXEC), kept = memory < 0 ? -1 : dup(memory);
    FILE *file = kept < 0 ? NULL : fdopen(memory, "w");
    if (!file) {
        if (memory >= 0) close(memory);
        if (kept >= 0) close(kept);
        return NULL;
    }
    if (t->file) fclose(t->file);
    snprintf(t->opened[t->count++], CSV_OPENED_SIZE, "/proc/self/fd/%d", kept);
    return t->file = file;
}

void csv_texts_number(struct csv_texts *t, char separator, double number) {
    char text[NUMBER_SIZE] = "";
    if (separator) fputc(separator, t->file);
    if (!isnan(number)) fputs(number_shortest(number, text), t->file);
    t->bytes += (int64_t)strlen(text) + 1;
}

bool csv_texts_good(const struct csv_texts *t) { return t->bytes <= CSV_TEXTS_BYTES && !ferror(t->file); }

int csv_texts_refuse(const struct csv_texts *t, const char *path, struct error *error) {
    if (t->full)
        return error_set(error, STATUS_USAGE, "%.250s: more than %d tests: split it, or write it as CSV (hexid export -o DIR)", path,
                         CSV_TEXTS_MAX);
    if (t->bytes > CSV_TEXTS_BYTES)
        return error_set(error, STATUS_USAGE, "%.250s: more than %lld MiB as text: import a shorter piece, or fewer columns", path,
                         (long long)CSV_TEXTS_BYTES >> 20);
    return error_set(error, STATUS_IO, "%.250s: no memory for its numbers as text", path);
}

bool csv_width_add(struct csv_width *w, const char *name) {
    w->columns++, w->bytes += strlen(name) + 1;
    return w->columns <= CSV_CELLS_MAX && w->bytes <= CSV_LINE_SIZE - 2;
}

int csv_width_refuse(const struct csv_width *w, const char *path, struct error *error) {
    return error_set(error, STATUS_USAGE,
                     "%.250s: at least %d columns, more than are read (%d, with %d bytes of names): say by name which are wanted: "
                     "--map t=NAME:s,position=NAME:mm,force=NAME:N",
                     path, w->columns, CSV_CELLS_MAX, CSV_LINE_SIZE - 2);
}

bool csv_map_names(const struct csv_map *map) {
    bool names = map && map->count;
    for (int i = 0; names && i < map->count; i++) names = map->alias[i].cell <= 0;
    return names;
}

bool csv_is_wanted(const struct csv_map *map, const char *name) {
    struct csv_unit unit;
    for (int i = 0; map && i < map->count; i++)
        if (!strcmp(map->alias[i].name, name)) return true;
    return csv_column_find(name, &unit) >= 0;
}

void csv_texts_name(FILE *file, const char *name) {
    for (; *name; name++) fputc((unsigned char)*name < ' ' || strchr(",;\"#", *name) ? '_' : *name, file);
}

/* Reads the first bytes of a file; returns how many. */
static size_t read_begin(const char *path, char *bytes, size_t size) {
    const char *unsaid;
    int file = input_open(path, &unsaid);
    ssize_t got = file < 0 ? 0 : read(file, bytes, size);
    if (file >= 0) close(file);
    return got > 0 ? (size_t)got : 0;
}

int csv_foreign_open(const char *path, const struct csv_map *map, struct csv_texts *texts, struct error *error) {
    static const char mcap[] = "\x89MCAP", mat[] = "MATLAB ", hdf[] = "\x89HDF";
    char begin[sizeof mat] = "";
    size_t size = read_begin(path, begin, sizeof begin);
    bool is_mcap = size >= 5 && !memcmp(begin, mcap, 5), is_mat = size >= 7 && (!memcmp(begin, mat, 7) || !memcmp(begin, hdf, 4));
    *texts = (struct csv_texts){0};
    if (!is_mcap && !is_mat) {
        texts->count = 1;
        return STATUS_OK;
    }
    int status = is_mcap ? csv_mcap_read(path, map, texts, error) : csv_mat_read(path, map, texts, error);
    bool failed = texts->file && ferror(texts->file);
    if (texts->file && (fclose(texts->file) || failed) && !status)
        status = error_set(error, STATUS_IO, "%.250s: no memory for its numbers as text", path);
    texts->file = NULL;
    for (int i = 0; i < texts->count && status; i++) csv_foreign_close(texts->opened[i]);
    return status;
}

void csv_foreign_close(const char *opened) {
    int descriptor;
    if (sscanf(opened, "/proc/self/fd/%d", &descriptor) == 1) close(descriptor);
}
