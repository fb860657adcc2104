#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "cycle_columns.h"
#include "log_export.h"
#include "number_text.h"
#include "output.h"

struct table {
    struct output output;
    FILE *file;
    int failure;
};

static int table_open(void **to, const char *path, struct error *error) {
    struct table *t = calloc(1, sizeof *t);
    *to = NULL;
    if (!t) return error_set(error, STATUS_IO, "%.250s: out of memory", path);
    if (output_prepare(&t->output, path, OUTPUT_NEW, error) || !(t->file = output_open(&t->output, error))) {
        free(t);
        return error->status;
    }
    fputs("time_s", t->file);
    for (int i = 0; i < CYCLE_COLUMNS; i++) fprintf(t->file, ",%s", cycle_columns[i].name);
    fputc('\n', t->file);
    *to = t;
    return STATUS_OK;
}

static void table_cycle(void *to, int64_t utime_us, double time_s, const struct cycle *c) {
    struct table *t = to;
    char number[NUMBER_SIZE];
    (void)utime_us;
    fputs(number_shortest(time_s, number), t->file);
    for (int i = 0; i < CYCLE_COLUMNS; i++) {
        if (column_is_real(i)) fprintf(t->file, ",%s", number_shortest(column_real(c, i), number));
        else fprintf(t->file, ",%lld", (long long)column_integer(c, i));
    }
    if (fputc('\n', t->file) == EOF || ferror(t->file)) t->failure = errno ? errno : EIO;
}

static void table_message(void *to, int64_t utime_us, const struct message *m) { (void)to, (void)utime_us, (void)m; }

static int table_failed(const void *to) { return ((const struct table *)to)->failure; }

static int table_close(void *to, struct error *error) {
    struct table *t = to;
    int status = output_close(&t->output, t->file, t->failure, error);
    free(t);
    return status;
}

const struct export_format export_table = {
    .name = "csv",
    .open = table_open,
    .cycle = table_cycle,
    .message = table_message,
    .failed = table_failed,
    .close = table_close,
};
