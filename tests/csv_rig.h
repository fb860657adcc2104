/* A directory for CSV files and logs, a log with every kind of damage, and helpers that read it
 * back. */
#ifndef HEXID_TESTS_CSV_RIG_H
#define HEXID_TESTS_CSV_RIG_H

#include "params.h"
#include "support.h"

#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "csv.h"
#include "log.h"
#include "messages.h"
#include "reference.h"

enum { PATHS = 300, CYCLES_MAX = 20000, BUFFER = 1 << 17 };

static char root[] = "/tmp/hexid_csv_XXXXXX";
static char in[PATHS], out[PATHS], log_a[PATHS], log_b[PATHS]; /* directories below root */

static inline int set_up(void **unused) {
    (void)unused;
    if (!mkdtemp(root)) return -1;
    snprintf(in, sizeof in, "%s/in", root), snprintf(out, sizeof out, "%s/out", root);
    snprintf(log_a, sizeof log_a, "%s/1.lcm", root), snprintf(log_b, sizeof log_b, "%s/2.lcm", root);
    return 0;
}

static inline int tear_down(void **unused) {
    char command[PATHS];
    (void)unused;
    snprintf(command, sizeof command, "rm -rf %s", root);
    return system(command);
}

static inline int empty(void **unused) {
    char command[PATHS];
    (void)unused;
    snprintf(command, sizeof command, "rm -rf %s/* && mkdir %s/in", root, root);
    return system(command);
}

static inline void put_bytes(const char *name, const char *bytes, size_t size) {
    char path[2 * PATHS];
    snprintf(path, sizeof path, "%s/%s", in, name);
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    fwrite(bytes, 1, size, f);
    fclose(f);
}

static inline void put(const char *name, const char *text) { put_bytes(name, text, strlen(text)); }

static struct csv_report report;
static struct error error;

/* Imports from `directory`. */
static inline int import_of(const char *directory, const char *log_path, const char *base) {
    return csv_import(&(struct csv_source){.path = directory, .base = base}, log_path, &report, &error);
}

static inline int import(void) { return import_of(in, log_a, NULL); }

static inline void assert_imports(void) {
    if (import()) fail_msg("%s", error.text);
}

static inline void assert_says(const char *words) {
    char copy[400], *rest = copy;
    snprintf(copy, sizeof copy, "%s", words);
    for (char *word; (word = strsep(&rest, "|"));)
        if (!strstr(error.text, word)) fail_msg("\"%s\" does not say \"%s\"", error.text, word);
    assert_null(strchr(error.text, '\n'));
}

struct recording {
    struct params params;
    int count;
    struct cycle cycle[CYCLES_MAX];
};

/* Loads the cycles of the log's tests and its configuration. */
static inline struct recording *load(const char *path) {
    static struct recording both[2];
    struct recording *r = &both[strcmp(path, log_a) != 0];
    struct log_reader *reader;
    struct log_event event;
    const char *text;
    size_t length;
    assert_int_equal(log_open(&reader, path, &error), 0);
    assert_int_equal(log_next(reader, &event), 1);
    /* the configuration is always the first event */
    assert_true(event_decode_config(event.data, event.size, &text, &length));
    assert_int_equal(config_parse(&r->params, text, length, path, &error), 0);
    for (r->count = 0; log_next(reader, &event);) {
        if (strcmp(event.channel, CHANNEL_STATE) != 0) continue;
        assert_true(r->count < CYCLES_MAX);
        assert_true(state_decode(event.data, event.size, &r->cycle[r->count]));
        if (r->cycle[r->count].test >= 0) r->count++;
    }
    log_release(reader);
    return r;
}

static inline uint64_t random_bits(uint64_t *state) {
    *state ^= *state << 13, *state ^= *state >> 7, *state ^= *state << 17;
    return *state;
}

/* Returns a finite number of any magnitude, mostly with 16 or 17 digits, sometimes short. */
static inline double random_number(uint64_t *state) {
    uint64_t bits = random_bits(state);
    double number;
    memcpy(&number, &bits, sizeof number);
    if (bits % 3 == 0) return (double)(int64_t)(bits >> 40) / 1000.0;
    return isfinite(number) ? number : -0.0;
}

static inline void fill(double *numbers, int count, uint64_t *state) {
    for (int i = 0; i < count; i++) numbers[i] = random_number(state);
}

static inline void fill_cycle(struct cycle *c, uint64_t *state) {
    fill(c->in.length_m, LEGS, state), fill(c->in.p1_pa, LEGS, state), fill(c->in.p2_pa, LEGS, state);
    fill(c->out.valve, LEGS, state), fill(c->ref, DOFS, state);
}

/* Writes a log of hexid with every kind of damage: flagged and lost samples, NaN, a test stopped
 * early, an axis tested twice. */
static inline void write_log(const char *path, const struct params *params) {
    static unsigned char buffer[BUFFER];
    static const enum dof order[] = {DOF_X, DOF_Y, DOF_Z, DOF_PHI, DOF_THETA, DOF_PSI, DOF_X};
    struct log_writer *w;
    char *config = config_text(params);
    uint64_t state = 9, seq = 100;
    assert_int_equal(log_create(&w, path, &error), 0);
    log_write(w, 0, CHANNEL_EVENT, buffer, event_encode(0, 0, "config", config, buffer, BUFFER), &error);
    for (int test = 0; test < 7; test++) {
        struct reference r;
        struct reference_sample s;
        struct cycle c = {.test = -1, .dof = DOF_NONE, .state = STATE_READY};
        log_write(w, 0, CHANNEL_STATE, buffer, state_encode(&c, buffer), &error);
        reference_test(&r, order[test], NULL, &params->tests, params->loop.period_s);
        for (int i = 0; (s = reference_step(&r, &params->tests, params->loop.period_s), !s.done); i++, seq++) {
            if (test == 2 && i == 400) reference_stop(&r);
            if (i > 10 && i % 97 == 0) continue; /* these cycles are lost */
            c = (struct cycle){.seq = seq,
                               .test = test % 6,
                               .dof = order[test],
                               .state = STATE_TESTING,
                               .phase = s.phase,
                               .test_time_s = s.test_time_s,
                               .in.flags = i % 53 ? 0 : (uint32_t)random_bits(&state)};
            fill_cycle(&c, &state);
            if (i % 71 == 0) c.in.p1_pa[i % LEGS] = (double)NAN, c.in.length_m[0] = (double)INFINITY, c.out.valve[1] = -(double)INFINITY;
            log_write(w, 0, CHANNEL_STATE, buffer, state_encode(&c, buffer), &error);
        }
    }
    assert_int_equal(log_close(w, &error), 0);
    free(config);
}

static inline struct params short_tests(double period_s) {
    struct params p;
    config_default(&p);
    p.tests.settle_s = 0.2, p.tests.ramp_s = 0.3, p.tests.duration_s = 1.0, p.tests.ramp_out_s = 0.2;
    p.loop.period_s = period_s;
    p.sim.substeps = (int)ceil(period_s / 0.25e-3 - 1e-9);
    return p;
}

/* Returns a file with this header: one column, and rows every 2 ms from from_s on. */
static inline const char *file_of(const char *head, double from_s, int rows) {
    static char text[BUFFER];
    int used = sprintf(text, "%st_s,u1\n", head);
    for (int i = 0; i < rows; i++) used += sprintf(text + used, "%.12g,%d\n", from_s + 0.002 * i, i);
    return text;
}

#endif
