/* fault: breaks another back-end on purpose. Address: FAULT[,FAULT...];URL with FAULT = KIND@FROM+LENGTH[/LEG][=VALUE], times in seconds
 * of the loop, LEG 1..6 for what befalls a leg's sensors (all without it; swap: with the next leg):
 *
 *     --hal 'fault:freeze@12+0.5/3,drop@20+0.02;sim:'
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "backends.h"
#include "units.h"

enum { FAULTS_MAX = 16, ALL_LEGS = -1 };

struct fault;

struct wrapper {
    struct hal hal;
    struct hal_ops ops; /* hal_fault, but as simulated as the inner one */
    struct hal *inner;
    bool refuse_write;
    int count;
    struct fault {
        const struct kind *kind;
        int64_t from_ns, to_ns;
        int leg;
        double value;
        struct hal_sample before; /* the inner one's last before it began */
    } fault[FAULTS_MAX];
};

static bool hits(const struct fault *f, int leg) { return f->leg == ALL_LEGS || f->leg == leg; }

static void stale(const struct fault *f, struct hal_sample *s) {
    int64_t now_ns = s->time_ns + s->age_ns;
    *s = f->before;
    s->age_ns = now_ns - s->time_ns;
    s->flags |= SAMPLE_STALE;
}

static void late(const struct fault *f, struct hal_sample *s) {
    s->time_ns -= ns_from_seconds(f->value);
    s->age_ns += ns_from_seconds(f->value);
    s->flags |= SAMPLE_LATE;
}

static void freeze(const struct fault *f, struct hal_sample *s) {
    for (int i = 0; i < LEGS; i++)
        if (hits(f, i)) s->length_m[i] = f->before.length_m[i];
}

static void not_a_number(const struct fault *f, struct hal_sample *s) {
    for (int i = 0; i < LEGS; i++)
        if (hits(f, i)) s->length_m[i] = s->p1_pa[i] = s->p2_pa[i] = (double)NAN;
}

static void length_jump(const struct fault *f, struct hal_sample *s) {
    for (int i = 0; i < LEGS; i++)
        if (hits(f, i)) s->length_m[i] += f->value;
}

static void pressure_jump(const struct fault *f, struct hal_sample *s) {
    for (int i = 0; i < LEGS; i++)
        if (hits(f, i)) s->p1_pa[i] += f->value;
}

static void swap(const struct fault *f, struct hal_sample *s) {
    int a = f->leg == ALL_LEGS ? 0 : f->leg, b = (a + 1) % LEGS;
    double keep = s->length_m[a];
    s->length_m[a] = s->length_m[b];
    s->length_m[b] = keep;
}

static const struct kind {
    const char *name;
    bool takes_leg, wants_value, read_fails, write_fails;
    void (*spoil)(const struct fault *f, struct hal_sample *s);
} kinds[] = {
    {.name = "stale", .spoil = stale},
    {.name = "late", .wants_value = true, .spoil = late},
    {.name = "drop", .read_fails = true},
    {.name = "deaf", .write_fails = true},
    {.name = "freeze", .takes_leg = true, .spoil = freeze},
    {.name = "nan", .takes_leg = true, .spoil = not_a_number},
    {.name = "length", .takes_leg = true, .wants_value = true, .spoil = length_jump},
    {.name = "pressure", .takes_leg = true, .wants_value = true, .spoil = pressure_jump},
    {.name = "swap", .takes_leg = true, .spoil = swap},
};

static const struct kind *kind_find(const char *name, size_t length) {
    for (unsigned i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (strlen(kinds[i].name) == length && !strncmp(kinds[i].name, name, length)) return &kinds[i];
    return NULL;
}

/* A number after this mark at *text, which is moved behind it; NaN when the mark or the number is missing. */
static double number_after(const char **text, char mark) {
    char *end;
    if (**text != mark) return (double)NAN;
    double number = strtod(*text + 1, &end);
    bool none = end == *text + 1;
    *text = end;
    return none ? (double)NAN : number;
}

/* One FAULT at *text, which is moved behind it. False when it is not understood. */
static bool fault_parse(const char **text, struct fault *f) {
    size_t name_length = strcspn(*text, "@;,");
    f->kind = kind_find(*text, name_length);
    *text += name_length;
    double from_s = number_after(text, '@'), length_s = number_after(text, '+');
    bool has_leg = **text == '/';
    double leg = number_after(text, '/');
    bool has_value = **text == '=';
    f->value = number_after(text, '=');
    if (!f->kind || !(from_s >= 0.0 && from_s < 1e6 && length_s > 0.0 && length_s < 1e6)) return false;
    if (has_leg && (!f->kind->takes_leg || !(leg >= 1.0 && leg <= LEGS && leg == floor(leg)))) return false;
    f->leg = has_leg ? (int)leg - 1 : ALL_LEGS;
    f->from_ns = ns_from_seconds(from_s);
    f->to_ns = f->from_ns + ns_from_seconds(length_s);
    return has_value == f->kind->wants_value && (!has_value || fabs(f->value) <= 1e9);
}

static int schedule_parse(struct wrapper *w, const char **text, struct error *error) {
    for (;; ++*text) {
        const char *start = *text;
        if (w->count == FAULTS_MAX) return error_set(error, STATUS_USAGE, "--hal fault: at most %d faults", FAULTS_MAX);
        if (!fault_parse(text, &w->fault[w->count]) || (**text != ',' && **text != ';'))
            return error_set(error, STATUS_USAGE, "--hal fault: `%s`: write KIND@FROM+LENGTH[/LEG][=VALUE],...;URL with KIND one of stale, "
                             "late=s, drop, deaf, freeze, nan, length=m, pressure=Pa, swap", start);
        w->count++;
        if (**text == ';') return STATUS_OK;
    }
}

static int fault_open(struct hal **hal, const char *address, const struct params *params, uint64_t seed, struct error *error) {
    struct wrapper *w = calloc(1, sizeof *w);
    if (!w) return error_set(error, STATUS_IO, "fault: out of memory");
    int status = schedule_parse(w, &address, error);
    if (!status) status = hal_open(&w->inner, address + 1, params, seed, error);
    if (status) {
        free(w);
        return status;
    }
    w->ops = hal_fault;
    w->ops.simulated = w->inner->ops->simulated;
    w->hal.ops = &w->ops;
    *hal = &w->hal;
    return STATUS_OK;
}

static int fault_read(struct hal *hal, int64_t now_ns, struct hal_sample *sample) {
    struct wrapper *w = (struct wrapper *)hal;
    int status = w->inner->ops->read(w->inner, now_ns, sample);
    w->refuse_write = false;
    const struct hal_sample healthy = *sample;
    for (int i = 0; i < w->count; i++) {
        struct fault *f = &w->fault[i];
        if (now_ns < f->from_ns) f->before = healthy;
        if (now_ns < f->from_ns || now_ns >= f->to_ns) continue;
        if (f->kind->spoil) f->kind->spoil(f, sample);
        if (f->kind->read_fails) status = -1;
        if (f->kind->write_fails) w->refuse_write = true;
    }
    return status;
}

static int fault_write(struct hal *hal, const struct hal_command *command) {
    struct wrapper *w = (struct wrapper *)hal;
    return w->refuse_write ? -1 : w->inner->ops->write(w->inner, command);
}

static void fault_safe(struct hal *hal) {
    struct wrapper *w = (struct wrapper *)hal;
    w->inner->ops->safe(w->inner);
}

static void fault_close(struct hal *hal) {
    struct wrapper *w = (struct wrapper *)hal;
    w->inner->ops->close(w->inner);
    free(w);
}

static void fault_describe(const struct hal *hal, char *text, size_t size) {
    const struct hal *inner = ((const struct wrapper *)hal)->inner;
    if (inner->ops->describe) inner->ops->describe(inner, text, size);
    else *text = '\0';
}

const struct hal_ops hal_fault = {
    .scheme = "fault",
    .usage = "fault:FAULT[,...];URL      another back-end, broken on purpose: KIND@FROM+LENGTH[/LEG][=VALUE]",
    .open = fault_open,
    .read = fault_read,
    .write = fault_write,
    .safe = fault_safe,
    .close = fault_close,
    .describe = fault_describe,
};
