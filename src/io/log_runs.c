#include "log_runs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "messages.h"
#include "units.h"

/* A log counts as a mixture of two machines' cycles if many cycles are strays (decide()): more than
 * STRAYS_MOST, or more than STRAYS_LEAST that make up more than 1 / STRAYS_SHARE of all. Fewer are
 * damage. It also counts as a mixture if more than JUMPS_MOST runs begin without a configuration,
 * or if a previous run continues at least CROSSINGS_LEAST times (crosses()). */
enum { STRAYS_MOST = 64, STRAYS_LEAST = 3, STRAYS_SHARE = 20, CROSSINGS_LEAST = 2, JUMPS_MOST = 32 };
static const double CLOCKS_APART_S = 2.0; /* difference between two clocks that is longer than any
                                           * delay of a message */

struct place {
    uint64_t seq;
    int64_t time_ns; /* time of the loop, which never goes back within a run; that of the samples
                      * goes back after a failed read */
    int64_t utime_us;
    int64_t offset; /* byte at which the run begins, if this cycle begins one */
};

struct finder {
    struct log_runs *runs;
    struct place last, before;   /* latest two cycles of the current run */
    struct place end;            /* last cycle of the previous run */
    struct place candidate;      /* cycle that went back; the next cycle shows whether it began a
                                  * run */
    int known;                   /* how many of `last` and `before` are valid */
    bool has_candidate, has_end;
    bool candidate_told;         /* a configuration precedes the candidate */
    int64_t config_at;     /* offset of a configuration after the latest cycle; -1: there is none */
    uint64_t config, candidate_config;
    int part, candidate_part;
    int64_t strays, cycles;
    int crossings, jumps;
};

static uint64_t hash(const char *text, size_t size) {
    uint64_t h = 14695981039346656037ull; /* start value of the hash FNV-1a */
    for (size_t i = 0; i < size; i++) h = (h ^ (unsigned char)text[i]) * 1099511628211ull;
    return h ? h : 1;
}

static struct log_run *at_hand(struct finder *f) { return &f->runs->run[f->runs->count - 1]; }

static bool follows(const struct place *c, const struct place *p) { return c->seq > p->seq && c->time_ns >= p->time_ns; }
static bool repeats(const struct place *c, const struct place *p) { return c->seq == p->seq && c->time_ns == p->time_ns; }

static void begin(struct finder *f, const struct place *c, uint64_t config, int part) {
    if (f->runs->count) at_hand(f)->end = c->offset;
    if (f->runs->count == LOG_RUNS_MAX) {
        f->runs->more = true;
        return;
    }
    f->has_end = f->known > 0, f->end = f->last;
    f->known = 0;
    f->runs->run[f->runs->count++] = (struct log_run){.begin = f->runs->count ? c->offset : 0,
                                                      .end = INT64_MAX,
                                                      .began_us = c->utime_us,
                                                      .first_seq = c->seq,
                                                      .first_ns = c->time_ns,
                                                      .config = config,
                                                      .part = part};
}

/* Returns true if the previous run continues with c: the cycles jump from before that run's end to
 * after it, by far more than the usual step. */
static bool crosses(const struct finder *f, const struct place *c) {
    if (!f->has_end || f->known < 2 || !follows(&f->end, &f->last) || !follows(c, &f->end)) return false;
    return c->seq - f->last.seq > 10 * (f->last.seq - f->before.seq);
}

static void add(struct finder *f, const struct place *c) {
    if (f->runs->more) return;
    if (crosses(f, c)) f->crossings++;
    f->before = f->last, f->last = *c;
    f->known += f->known < 2;
    struct log_run *run = at_hand(f);
    run->cycles++, run->last_seq = c->seq, run->last_ns = c->time_ns;
    f->config_at = -1, f->part = 0;
}

/* Returns true if the loop's time and the log's clock have advanced by the same amount. */
static bool same_clock(const struct place *c, const struct place *p) {
    double loop_s = ((double)c->time_ns - (double)p->time_ns) * 1e-9, log_s = ((double)c->utime_us - (double)p->utime_us) * 1e-6;
    return fabs(loop_s - log_s) < CLOCKS_APART_S;
}

/* Returns true if an unrecorded run lies between the last cycle and c: cycles are missing, and the
 * clock has changed. */
static bool elsewhere(const struct finder *f, const struct place *c) {
    return f->known == 2 && c->seq - f->last.seq > 10 * (f->last.seq - f->before.seq) && !same_clock(c, &f->last);
}

/* Decides whether the candidate began a run or is a stray. It began a run if the next cycle, c,
 * follows it and does not belong to the run before: after a jump ahead, c must have the candidate's
 * clock; after a jump back, c must not follow that run's last cycle. */
static void decide(struct finder *f, const struct place *c) {
    bool ahead = follows(&f->candidate, &f->last);
    f->has_candidate = false;
    if (!follows(c, &f->candidate) || (ahead ? !same_clock(c, &f->candidate) : follows(c, &f->last))) {
        f->strays++;
        return;
    }
    f->jumps += !f->candidate_told;
    begin(f, &f->candidate, f->candidate_config, f->candidate_part);
    add(f, &f->candidate);
}

static void take_cycle(struct finder *f, const struct place *c) {
    f->cycles++;
    if (f->has_candidate) decide(f, c);
    if (!f->runs->count) begin(f, c, f->config, f->part);
    uint64_t config = at_hand(f)->config;
    bool other = f->config_at >= 0 && f->config && config && f->config != config;
    if (f->known && repeats(c, &f->last) && !other) return;
    if (other) begin(f, c, f->config, f->part);
    else if (f->known && (!follows(c, &f->last) || elsewhere(f, c))) {
        /* the last cycle was a stray: c does not follow it, but follows the cycle before it */
        if (f->known == 2 && !follows(c, &f->last) && follows(c, &f->before)) f->strays++, f->last = *c;
        else {
            f->has_candidate = true, f->candidate = *c, f->candidate_told = f->config_at >= 0;
            f->candidate_config = f->candidate_told ? f->config : config, f->candidate_part = f->part;
            f->config_at = -1, f->part = 0;
        }
        return;
    }
    add(f, c);
}

/* Handles a configuration, which begins a file, and the part's number, which follows it. */
static void take_event(struct finder *f, const struct log_event *e, int64_t offset) {
    const char *text;
    size_t size;
    struct event event;
    if (event_decode_config(e->data, e->size, &text, &size)) {
        if (f->config_at < 0) f->config_at = offset;
        f->config = hash(text, size);
        if (f->runs->count && !at_hand(f)->config) at_hand(f)->config = f->config;
    } else if (event_decode(e->data, e->size, &event) && !strcmp(event.kind, "part")) f->part = atoi(event.text);
}

static void note_disorder(struct log_runs *runs) {
    for (int j = 1; j < runs->count; j++)
        for (int i = 0; i < j; i++) {
            const struct log_run *a = &runs->run[i], *b = &runs->run[j];
            if (a->config != b->config) runs->configurations = true;
            else if (b->part > 1 || (b->last_seq + 1 == a->first_seq && b->last_ns < a->first_ns)) runs->disordered = true;
        }
}

int log_runs_find(const char *path, struct log_runs *runs, struct error *error) {
    struct log_reader *log;
    struct log_event event;
    struct cycle cycle;
    struct finder f = {.runs = runs, .config_at = -1};
    *runs = (struct log_runs){0};
    int status = log_open(&log, path, error);
    if (status) return status;
    for (int64_t offset = 0; !runs->more && log_next(log, &event); offset = log_offset(log)) {
        if (!strcmp(event.channel, CHANNEL_EVENT)) take_event(&f, &event, offset);
        if (strcmp(event.channel, CHANNEL_STATE) || !state_decode(event.data, event.size, &cycle)) continue;
        take_cycle(&f, &(struct place){.seq = cycle.seq,
                                       .time_ns = add_saturated(cycle.in.time_ns, cycle.in.age_ns),
                                       .utime_us = event.utime_us,
                                       .offset = f.config_at >= 0 ? f.config_at : offset});
    }
    log_release(log);
    runs->mixed = f.jumps > JUMPS_MOST || f.crossings >= CROSSINGS_LEAST || f.strays > STRAYS_MOST ||
                  (f.strays > STRAYS_LEAST && f.strays * STRAYS_SHARE > f.cycles);
    note_disorder(runs);
    return STATUS_OK;
}

/* Writes "1: 12.3 s from 2026-11-27 09:12:00 UTC". A log in virtual time has no date. */
static size_t describe(const struct log_run *run, int number, char *text, size_t size) {
    static const int64_t year_us = 365LL * 86400 * 1000000;
    char when[40] = "";
    time_t at = (time_t)(run->began_us / 1000000);
    struct tm utc;
    if (run->began_us > year_us && run->began_us < 1000 * year_us)
        strftime(when, sizeof when, " from %Y-%m-%d %H:%M:%S UTC", gmtime_r(&at, &utc));
    double duration_s = ((double)run->last_ns - (double)run->first_ns) * 1e-9;
    int length = snprintf(text, size, "%s%d: %.1f s%s", number > 1 ? "; " : "", number, duration_s, when);
    return length < (int)size ? (size_t)length : size - 1;
}

static int refuse(const struct log_runs *runs, const char *path, int run, struct error *error) {
    const char *configurations = runs->configurations ? ", with different configurations" : "";
    char list[400] = "";
    size_t used = 0;
    int listed = 0;
    for (; listed < runs->count && used + 60 < sizeof list; listed++)
        used += describe(&runs->run[listed], listed + 1, list + used, sizeof list - used);
    if (listed < runs->count) snprintf(list + used, sizeof list - used, "; ...");
    if (runs->mixed)
        return error_set(error, STATUS_IO,
                         "%.250s: has cycles of several daemons that ran at the same time, or cycles in disorder; record each by itself, "
                         "with an lcm.url of its own",
                         path);
    if (runs->disordered)
        return error_set(error, STATUS_IO, "%.250s: its parts are not in the order of their numbers; join them in the order of their names",
                         path);
    if (run > runs->count)
        return error_set(error, STATUS_USAGE, "--run %d: %.250s has %d run%s", run, path, runs->count, runs->count == 1 ? "" : "s");
    if (runs->more)
        return error_set(error, STATUS_IO,
                         "%.250s: is of more than %d runs of the daemon%s; take one of the first %d with --run N (%s), and cut the log for "
                         "the others",
                         path, LOG_RUNS_MAX, configurations, LOG_RUNS_MAX, list);
    return error_set(error, STATUS_IO, "%.250s: is of %d runs of the daemon%s; take one with --run N (%s)", path, runs->count,
                     configurations, list);
}

int log_open_run(struct log_reader **reader, const char *path, int run, struct error *error) {
    struct log_runs *runs = malloc(sizeof *runs);
    *reader = NULL;
    int status = runs ? log_runs_find(path, runs, error) : error_set(error, STATUS_IO, "%.250s: out of memory", path);
    bool one = !status && runs->count <= 1 && run <= 1, chosen = !status && run && run <= runs->count;
    if (!status && (runs->mixed || runs->disordered || (!one && !chosen))) status = refuse(runs, path, run, error);
    if (!status) status = log_open(reader, path, error);
    if (!status && chosen) log_range(*reader, runs->run[run - 1].begin, runs->run[run - 1].end);
    free(runs);
    return status;
}
