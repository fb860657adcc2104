/* fault: injects faults into another back-end. Address: FAULT[,FAULT...];URL with
 * FAULT = KIND@FROM+LENGTH[/LEG][=VALUE], FROM in seconds since the loop's start, LENGTH in
 * seconds, LEG 1..6 for faults of legs (default: all; for swap, pressure_swap and mix the first):
 *
 *     --hal 'fault:freeze@12+0.5/3,drop@20+0.02;sim:'
 *
 * samples   stale (the last sample before the fault, marked stale); late=s (older time stamp);
 *           delay=s (an older sample); lag=s (an older sample with fresh time stamps and device
 *           count; delay and lag are at most 63 cycles); loss=% of the samples; repeat, reorder
 *           (every other sample is the previous one, or the one before that, with fresh time
 *           stamps); hang (like stale, but with fresh time stamps and not marked); drop (reading
 *           fails); twin (two devices answer as one, if a leg is given, for that leg)
 * lengths   freeze; length=m (offset); drift=m/s; noise=m (uniform, either sign); flip=% of the
 *           samples (inverts one of the 22 lower bits of the length in um); swap (with the next
 *           leg's)
 * pressures pressure=Pa (offset of P1); pressure_drift=Pa/s (drift of P1); pressure_freeze;
 *           pressure_swap (P1 with P2); mix (exchanges both with the next leg's); pressure_nan
 * both      nan
 * inputs    emergency_stop, enable, door (opens); supply (its life sign is lost, so the machine
 *           loses its pressure); inputs_on=, inputs_off= (bits of the device's byte of inputs that
 *           are stuck at 1 or 0; values 1 to 8: plain contacts, 16 to 128: inverse contacts)
 * valves    deaf (no command can be written, except centring); stuck (does not move, not even to
 *           centre); valve=-1..1 (stuck at this opening)
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "backends.h"
#include "interlock.h"
#include "params.h"
#include "units.h"

enum { FAULTS_MAX = 16, ALL_LEGS = -1, HISTORY = 64, LENGTH_BITS = 22 };

struct fault;

struct wrapper {
    struct hal hal;
    struct hal_ops ops; /* calls of hal_fault; `simulated` and `reopens` are those of the inner
                         * back-end */
    struct hal *inner;
    const struct params *params;
    int64_t period_ns, now_ns;
    struct hal_sample history[HISTORY]; /* samples of the inner back-end; the newest is at index
                                         * (reads - 1) % HISTORY */
    int64_t reads;
    struct hal_command written; /* last command of the loop, as it was before faults of valves */
    int count;
    struct fault {
        const struct kind *kind;
        int64_t from_ns, to_ns;
        int leg;
        double value;
        uint64_t random;
        struct hal_sample before; /* last sample of the inner back-end before the fault */
        struct hal_sample passed; /* last sample that was passed on */
        double stuck[LEGS];       /* valve commands at the start of the fault */
    } fault[FAULTS_MAX];
};

static bool hits(const struct fault *f, int leg) { return f->leg == ALL_LEGS || f->leg == leg; }
static bool active(const struct wrapper *w, const struct fault *f) { return w->now_ns >= f->from_ns && w->now_ns < f->to_ns; }

/* Returns a random number of the generator splitmix64, uniform in -1..1. */
static double uniform(struct fault *f) {
    uint64_t z = f->random += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)(int64_t)(z ^ z >> 31) * 0x1p-63;
}
static bool chance(struct fault *f, double percent) { return 0.5 + 0.5 * uniform(f) < percent / 100.0; }

/* Returns the inner back-end's sample of this number of reads ago, or the oldest in the history. */
static const struct hal_sample *ago(const struct wrapper *w, int64_t reads) {
    int64_t kept = w->reads < HISTORY ? w->reads : HISTORY, back = reads < kept ? reads : kept - 1;
    return &w->history[(w->reads - 1 - back) % HISTORY];
}

/* Replaces the sample by an older one. */
static void instead(struct hal_sample *s, const struct hal_sample *older, uint32_t flags) {
    int64_t now_ns = s->time_ns + s->age_ns;
    *s = *older;
    s->age_ns = now_ns - s->time_ns;
    s->flags |= flags;
}

/* Replaces the sample by an older one with fresh time stamps. */
static void passed_off(struct hal_sample *s, const struct hal_sample *older) {
    int64_t time_ns = s->time_ns, age_ns = s->age_ns;
    *s = *older;
    s->time_ns = time_ns;
    s->age_ns = age_ns;
}

static void stale(struct wrapper *w, struct fault *f, struct hal_sample *s) { (void)w, instead(s, &f->before, SAMPLE_STALE); }
static void hang(struct wrapper *w, struct fault *f, struct hal_sample *s) { (void)w, passed_off(s, &f->before); }

/* Marks the sample as if the back-end had found two devices that answer as one. */
static void twin(struct wrapper *w, struct fault *f, struct hal_sample *s) {
    (void)w;
    s->flags |= SAMPLE_TWIN;
    if (f->leg != ALL_LEGS) s->twins |= 1u << f->leg;
}

static void late(struct wrapper *w, struct fault *f, struct hal_sample *s) {
    (void)w;
    s->time_ns -= ns_from_seconds(f->value);
    s->age_ns += ns_from_seconds(f->value);
    s->flags |= SAMPLE_LATE;
}

static int64_t cycles_of(const struct wrapper *w, double seconds) { return ns_from_seconds(fmax(seconds, 0.0)) / w->period_ns; }
static void delay(struct wrapper *w, struct fault *f, struct hal_sample *s) { instead(s, ago(w, cycles_of(w, f->value)), SAMPLE_LATE); }

static void lag(struct wrapper *w, struct fault *f, struct hal_sample *s) {
    uint64_t seq = s->device_seq;
    passed_off(s, ago(w, cycles_of(w, f->value)));
    s->device_seq = seq;
}

static void loss(struct wrapper *w, struct fault *f, struct hal_sample *s) {
    (void)w;
    bool gap = s->device_seq != f->passed.device_seq + 1;
    if (chance(f, f->value)) {
        instead(s, &f->passed, SAMPLE_STALE);
        return;
    }
    f->passed = *s;
    if (gap) s->flags |= SAMPLE_DROPPED;
}

static void repeat(struct wrapper *w, struct fault *f, struct hal_sample *s) { (void)f, passed_off(s, ago(w, w->reads % 2)); }
static void reorder(struct wrapper *w, struct fault *f, struct hal_sample *s) { (void)f, passed_off(s, ago(w, w->reads % 2 * 2)); }

static void freeze(struct wrapper *w, struct fault *f, struct hal_sample *s) {
    (void)w;
    for (int i = 0; i < LEGS; i++)
        if (hits(f, i)) s->length_m[i] = f->before.length_m[i];
}

static void pressure_freeze(struct wrapper *w, struct fault *f, struct hal_sample *s) {
    (void)w;
    for (int i = 0; i < LEGS; i++)
        if (hits(f, i)) s->p1_pa[i] = f->before.p1_pa[i], s->p2_pa[i] = f->before.p2_pa[i];
}

static void pressure_not_a_number(struct wrapper *w, struct fault *f, struct hal_sample *s) {
    (void)w;
    for (int i = 0; i < LEGS; i++)
        if (hits(f, i)) s->p1_pa[i] = s->p2_pa[i] = (double)NAN;
}

static void not_a_number(struct wrapper *w, struct fault *f, struct hal_sample *s) {
    pressure_not_a_number(w, f, s);
    for (int i = 0; i < LEGS; i++)
        if (hits(f, i)) s->length_m[i] = (double)NAN;
}

static void add(const struct fault *f, double reading[LEGS], double offset) {
    for (int i = 0; i < LEGS; i++)
        if (hits(f, i)) reading[i] += offset;
}
static double since(const struct wrapper *w, const struct fault *f) { return seconds_from_ns(w->now_ns - f->from_ns); }
static void length_jump(struct wrapper *w, struct fault *f, struct hal_sample *s) { (void)w, add(f, s->length_m, f->value); }
static void pressure_jump(struct wrapper *w, struct fault *f, struct hal_sample *s) { (void)w, add(f, s->p1_pa, f->value); }
static void length_drift(struct wrapper *w, struct fault *f, struct hal_sample *s) { add(f, s->length_m, f->value * since(w, f)); }
static void pressure_drift(struct wrapper *w, struct fault *f, struct hal_sample *s) { add(f, s->p1_pa, f->value * since(w, f)); }

static void noise(struct wrapper *w, struct fault *f, struct hal_sample *s) {
    (void)w;
    for (int i = 0; i < LEGS; i++)
        if (hits(f, i)) s->length_m[i] += f->value * uniform(f);
}

static void flip(struct wrapper *w, struct fault *f, struct hal_sample *s) {
    (void)w;
    for (int i = 0; i < LEGS; i++) {
        if (!hits(f, i) || !chance(f, f->value)) continue;
        long long bit = 1LL << (int)((0.5 + 0.499999 * uniform(f)) * LENGTH_BITS);
        s->length_m[i] = (double)(llround(s->length_m[i] * 1e6) ^ bit) * 1e-6;
    }
}

static void exchange(double *a, double *b) {
    double keep = *a;
    *a = *b;
    *b = keep;
}

static void swap(struct wrapper *w, struct fault *f, struct hal_sample *s) {
    (void)w;
    int a = f->leg == ALL_LEGS ? 0 : f->leg;
    exchange(&s->length_m[a], &s->length_m[(a + 1) % LEGS]);
}

static void pressure_swap(struct wrapper *w, struct fault *f, struct hal_sample *s) {
    (void)w;
    int a = f->leg == ALL_LEGS ? 0 : f->leg;
    exchange(&s->p1_pa[a], &s->p2_pa[a]);
}

static void mix(struct wrapper *w, struct fault *f, struct hal_sample *s) {
    (void)w;
    int a = f->leg == ALL_LEGS ? 0 : f->leg, b = (a + 1) % LEGS;
    exchange(&s->p1_pa[a], &s->p1_pa[b]);
    exchange(&s->p2_pa[a], &s->p2_pa[b]);
}

static void stuck(const struct fault *f, struct hal_command *command) {
    for (int i = 0; i < LEGS; i++)
        if (hits(f, i)) command->valve[i] = f->stuck[i];
}

static void forced(const struct fault *f, struct hal_command *command) {
    for (int i = 0; i < LEGS; i++)
        if (hits(f, i)) command->valve[i] = fmax(-1.0, fmin(1.0, f->value));
}

/* Keeps the supply output at one level, so that the life sign is lost. */
static void unpowered(const struct fault *f, struct hal_command *command) { (void)f, command->supply = false; }

static uint32_t stuck_on(uint32_t bits, uint32_t stuck) { return bits | stuck; }
static uint32_t stuck_off(uint32_t bits, uint32_t stuck) { return bits & ~stuck; }

static const struct kind {
    const char *name;
    bool takes_leg, wants_value, read_fails, write_fails;
    uint32_t opens; /* inputs that the fault opens, INPUT_... */
    uint32_t (*wire)(uint32_t bits, uint32_t stuck);
    void (*spoil)(struct wrapper *w, struct fault *f, struct hal_sample *s);
    void (*drive)(const struct fault *f, struct hal_command *command);
} kinds[] = {
    {.name = "stale", .spoil = stale},
    {.name = "late", .wants_value = true, .spoil = late},
    {.name = "delay", .wants_value = true, .spoil = delay},
    {.name = "lag", .wants_value = true, .spoil = lag},
    {.name = "loss", .wants_value = true, .spoil = loss},
    {.name = "repeat", .spoil = repeat},
    {.name = "reorder", .spoil = reorder},
    {.name = "hang", .spoil = hang},
    {.name = "twin", .takes_leg = true, .spoil = twin},
    {.name = "drop", .read_fails = true},
    {.name = "freeze", .takes_leg = true, .spoil = freeze},
    {.name = "length", .takes_leg = true, .wants_value = true, .spoil = length_jump},
    {.name = "drift", .takes_leg = true, .wants_value = true, .spoil = length_drift},
    {.name = "noise", .takes_leg = true, .wants_value = true, .spoil = noise},
    {.name = "flip", .takes_leg = true, .wants_value = true, .spoil = flip},
    {.name = "swap", .takes_leg = true, .spoil = swap},
    {.name = "pressure", .takes_leg = true, .wants_value = true, .spoil = pressure_jump},
    {.name = "pressure_drift", .takes_leg = true, .wants_value = true, .spoil = pressure_drift},
    {.name = "pressure_freeze", .takes_leg = true, .spoil = pressure_freeze},
    {.name = "pressure_swap", .takes_leg = true, .spoil = pressure_swap},
    {.name = "pressure_nan", .takes_leg = true, .spoil = pressure_not_a_number},
    {.name = "mix", .takes_leg = true, .spoil = mix},
    {.name = "nan", .takes_leg = true, .spoil = not_a_number},
    {.name = "emergency_stop", .opens = INPUT_EMERGENCY_STOP},
    {.name = "enable", .opens = INPUT_ENABLE},
    {.name = "door", .opens = INPUT_DOOR},
    {.name = "supply", .drive = unpowered},
    {.name = "inputs_on", .wants_value = true, .wire = stuck_on},
    {.name = "inputs_off", .wants_value = true, .wire = stuck_off},
    {.name = "deaf", .write_fails = true},
    {.name = "stuck", .takes_leg = true, .drive = stuck},
    {.name = "valve", .takes_leg = true, .wants_value = true, .drive = forced},
};
enum { KINDS = sizeof kinds / sizeof *kinds };

static const struct kind *kind_find(const char *name, size_t length) {
    for (int i = 0; i < KINDS; i++)
        if (strlen(kinds[i].name) == length && !strncmp(kinds[i].name, name, length)) return &kinds[i];
    return NULL;
}

/* Reads the number after `mark` at *text and advances *text; NaN if mark or number is missing. */
static double number_after(const char **text, char mark) {
    char *end;
    if (**text != mark) return (double)NAN;
    double number = strtod(*text + 1, &end);
    bool none = end == *text + 1;
    *text = end;
    return none ? (double)NAN : number;
}

/* Parses a FAULT at *text and advances *text. Returns false if it is malformed. */
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

static int refuse(const char *start, struct error *error) {
    char names[400] = "";
    for (int i = 0; i < KINDS; i++) {
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s%s", i ? ", " : "", kinds[i].name, kinds[i].wants_value ? "=" : "");
    }
    return error_set(error, STATUS_USAGE, "--hal fault: `%.40s`: write KIND@FROM+LENGTH[/LEG][=VALUE],...;URL with KIND one of %s", start,
                     names);
}

static int schedule_parse(struct wrapper *w, const char **text, struct error *error) {
    for (;; ++*text) {
        const char *start = *text;
        if (w->count == FAULTS_MAX) return error_set(error, STATUS_USAGE, "--hal fault: at most %d faults", FAULTS_MAX);
        if (!fault_parse(text, &w->fault[w->count]) || (**text != ',' && **text != ';')) return refuse(start, error);
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
    for (int i = 0; i < w->count; i++) w->fault[i].random = seed + (uint64_t)i;
    w->params = params;
    w->period_ns = ns_from_seconds(params->loop.period_s);
    w->ops = hal_fault;
    w->ops.simulated = w->inner->ops->simulated, w->ops.reopens = w->inner->ops->reopens;
    w->hal.ops = &w->ops;
    *hal = &w->hal;
    return STATUS_OK;
}

/* Encodes the inputs as the device's byte, sets or clears its stuck bits, and decodes it again. */
static void rewire(const struct wrapper *w, const struct fault *f, struct hal_sample *s) {
    uint32_t bits = f->kind->wire(interlock_bits(&w->params->interlocks, s->inputs), (uint32_t)fmax(0.0, fmin(f->value, 255.0)));
    struct interlock_reading read = interlock_read(&w->params->interlocks, bits);
    s->inputs = read.closed, s->contradicted |= read.contradicted;
}

static int fault_read(struct hal *hal, int64_t now_ns, struct hal_sample *sample) {
    struct wrapper *w = (struct wrapper *)hal;
    int status = w->inner->ops->read(w->inner, now_ns, sample);
    const struct hal_sample healthy = *sample;
    w->history[w->reads++ % HISTORY] = healthy;
    w->now_ns = now_ns;
    for (int i = 0; i < w->count; i++) {
        struct fault *f = &w->fault[i];
        if (now_ns < f->from_ns) {
            f->before = f->passed = healthy;
            memcpy(f->stuck, w->written.valve, sizeof f->stuck);
        }
        if (!active(w, f)) continue;
        if (f->kind->spoil) f->kind->spoil(w, f, sample);
        sample->inputs &= ~f->kind->opens;
        if (f->kind->wire) rewire(w, f, sample);
        if (f->kind->read_fails) status = -1;
    }
    return status;
}

/* Applies the active faults of valves to a command. Returns true if there are any. */
static bool drive(const struct wrapper *w, struct hal_command *command) {
    bool any = false;
    for (int i = 0; i < w->count; i++) {
        const struct fault *f = &w->fault[i];
        if (!f->kind->drive || !active(w, f)) continue;
        f->kind->drive(f, command);
        any = true;
    }
    return any;
}

static int fault_write(struct hal *hal, const struct hal_command *command) {
    struct wrapper *w = (struct wrapper *)hal;
    struct hal_command real = *command;
    for (int i = 0; i < w->count; i++)
        if (w->fault[i].kind->write_fails && active(w, &w->fault[i])) return -1;
    w->written = *command;
    drive(w, &real);
    return w->inner->ops->write(w->inner, &real);
}

static void fault_safe(struct hal *hal) {
    struct wrapper *w = (struct wrapper *)hal;
    struct hal_command centred = {.enable = true, .supply = w->written.supply};
    w->inner->ops->safe(w->inner);
    w->written = centred;
    if (drive(w, &centred)) w->inner->ops->write(w->inner, &centred);
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
    .usage =
        "fault:FAULT[,...];URL      another back-end, broken on purpose: KIND@FROM+LENGTH[/LEG][=VALUE], KIND one of\n"
        "                       stale late delay lag loss repeat reorder hang drop nan deaf stuck valve emergency_stop enable door supply\n"
        "                       inputs_on inputs_off twin\n"
        "                       freeze length drift noise flip swap pressure pressure_drift pressure_freeze pressure_swap pressure_nan mix",
    .open = fault_open,
    .read = fault_read,
    .write = fault_write,
    .safe = fault_safe,
    .close = fault_close,
    .describe = fault_describe,
};
