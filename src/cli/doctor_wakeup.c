#include "doctor.h"

#include <inttypes.h>
#include <string.h>

#include "params.h"
#include "units.h"
#include "wakeup.h"

enum { BAR = 50, LINE_MAX_SIZE = 100 };

/* Draws a line for each bin, from the first to the last bin that is not empty. The bars are
 * logarithmic, so that the small counts of long delays are visible. */
static void draw(const struct wakeups *w, char *text, size_t size) {
    int first = 0, last = WAKEUP_EDGES;
    size_t used = strlen(text);
    while (first < WAKEUP_EDGES && !w->count[first]) first++;
    while (last > first && !w->count[last]) last--;
    for (int i = first; i <= last && used + LINE_MAX_SIZE < size; i++) {
        char edge[32];
        int bar = 0;
        if (i < WAKEUP_EDGES) snprintf(edge, sizeof edge, "below %d us", wakeup_edge_us[i]);
        else snprintf(edge, sizeof edge, "more");
        for (int64_t n = w->count[i]; n > 0 && bar < BAR; n /= 2) bar += 2;
        used += (size_t)snprintf(text + used, size - used, "\n%15s %7" PRId64 "%s%.*s", edge, w->count[i], bar ? " " : "", bar,
                                 "##################################################");
    }
}

static json_t *numbers(const struct doctor *d, const struct wakeups *w, const double us[4]) {
    json_t *bins = json_array();
    for (int i = 0; i <= WAKEUP_EDGES; i++)
        json_array_append_new(bins, i < WAKEUP_EDGES ? json_pack("{si sI}", "below_us", wakeup_edge_us[i], "count", (json_int_t)w->count[i])
                                                     : json_pack("{sn sI}", "below_us", "count", (json_int_t)w->count[i]));
    return json_pack("{sI sf sf sf sf sf sI sI sI so}", "count", (json_int_t)w->late.count, "period_us", d->params->loop.period_s * 1e6,
                     "p50_us", us[0], "p99_us", us[1], "p999_us", us[2], "max_us", us[3], "late", (json_int_t)w->half, "missed",
                     (json_int_t)w->missed, "missed_in_row", (json_int_t)w->missed_in_row, "histogram", bins);
}

/* Judges measured wake-ups. On hardware the loop faults after loop.overrun_limit deadlines missed
 * in a row. On a field bus a wake-up half a period late causes a late sample, and if more than
 * checks.excluded_pct of the samples are late, the verdict of the identification is fail. */
struct finding judge_wakeups(const struct doctor *d, const struct wakeups *w) {
    const struct params *p = d->params;
    static const double quantile[] = {0.5, 0.99, 0.999, 1.0};
    double us[4], late_pct = 100.0 * (double)w->half / (double)w->late.count;
    char measured[240];
    for (int i = 0; i < 4; i++) us[i] = us_from_ns(histogram_quantile(&w->late, quantile[i]));
    snprintf(measured, sizeof measured, "p50 %.0f us, p99 %.0f, p99.9 %.0f, max %.0f; %" PRIu64 " wake-ups, every %g ms, %s", us[0], us[1],
             us[2], us[3], w->late.count, p->loop.period_s * 1e3, w->realtime ? "WITHOUT real time" : "real time");
    struct finding f;
    if (w->missed_in_row >= p->loop.overrun_limit)
        f = finding(level_of_machine(d), "follow what stands above, most of all isolation and kernel; end what else runs; measure again",
                    "%" PRId64 " deadlines missed in a row: a machine would be stopped by the fault `overrun` (limit %d)%s; %s",
                    w->missed_in_row, p->loop.overrun_limit, d->machine ? "" : ", the simulation's time stretches", measured);
    else if (late_pct > p->checks.excluded_pct)
        f = finding(LEVEL_WARN, "follow what stands above; measure again beside the load that the computer will have",
                    "%.2g %% of the wake-ups came half a period late: an identification excludes such samples, and fails above %g %%; %s",
                    late_pct, p->checks.excluded_pct, measured);
    else if (w->missed > 0)
        f = finding(LEVEL_WARN, "follow what stands above; measure again beside the load that the computer will have",
                    "%" PRId64 " deadline%s missed, %" PRId64 " at most in a row (limit %d); %s", w->missed, w->missed == 1 ? "" : "s",
                    w->missed_in_row, p->loop.overrun_limit, measured);
    else f = finding(LEVEL_OK, "", "no deadline missed; %s", measured);
    draw(w, f.found, sizeof f.found);
    f.data = numbers(d, w, us);
    return f;
}

struct finding check_wakeups(const struct doctor *d) {
    struct wakeups w;
    struct error error;
    if (!(d->latency_s > 0.0)) return finding_none();
    if (wakeups_measure(&d->params->loop, d->latency_s, &w, &error)) return finding(LEVEL_FAIL, "free this computer", "%s", error.text);
    if (!w.late.count) return finding(LEVEL_UNKNOWN, "measure for longer: --latency 10", "not one wake-up in %g s", d->latency_s);
    return judge_wakeups(d, &w);
}
