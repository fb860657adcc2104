#include "progress.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>
#include <unistd.h>

#include "monotonic.h"
#include "params.h"
#include "printable.h"
#include "reference.h"
#include "supervisor.h"
#include "units.h"

enum { BAR = 32, SAID_MAX = 1200 };

const char *const progress_phases[] = {"", "settle", "ramp in", "evaluate", "ramp out"};

int progress_open(struct progress *p, const struct params *params, int to, bool virtual_time) {
    double redraw_s = virtual_time ? 2.0 : 0.1;
    *p = (struct progress){.params = params, .terminal = isatty(to) != 0};
    p->redraw_cycles = llround(redraw_s / params->loop.period_s);
    if (outlet_open(&p->steps, to)) return -1;
    if (outlet_open(&p->words, STDERR_FILENO)) {
        outlet_close(&p->steps);
        return -1;
    }
    p->out = p->steps.out;
    return 0;
}

bool progress_close(struct progress *p) {
    bool steps = outlet_close(&p->steps), words = outlet_close(&p->words);
    return steps && words;
}

static void clear_line(struct progress *p) {
    if (p->terminal) fputs("\r\033[K", p->out);
}

void progress_say(struct progress *p, const char *format, ...) {
    char text[SAID_MAX], printable[SAID_MAX], line[SAID_MAX + 8];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    text[strcspn(text, "\n")] = '\0';
    text_printable(text, printable, sizeof printable);
    /* SAFETY: the line does not go through the stream: a thread may be delayed while it holds the
     * stream's lock, and the thread that takes stops must not wait for that lock */
    snprintf(line, sizeof line, "%s%s\n", p->terminal ? "\r\033[K" : "", printable);
    outlet_write(&p->words, line);
}

void progress_end(struct progress *p) { clear_line(p); }

void progress_state(struct progress *p, const struct cycle *c) {
    p->state_cycles = 0;
    /* progress_result(), progress_motion() and progress_fault() report these states */
    if (c->state == STATE_TESTING || c->state == STATE_FAULT) return;
    clear_line(p);
    fprintf(p->out, "  %s\n", state_names[c->state]);
    outlet_flush(&p->steps);
}

void progress_interlock(struct progress *p, const char *why) {
    clear_line(p);
    fprintf(p->out, "  cannot engage: %s\n", why);
    outlet_flush(&p->steps);
}

void progress_fault(struct progress *p, const struct cycle *c, const char *cause, const char *remedy) {
    char text[FAULT_TEXT_SIZE], measured[FAULT_MEASURE_SIZE];
    fault_describe(c->first_fault, c->faults, text);
    fault_measured(c->first_fault, &c->measure, measured);
    clear_line(p);
    fprintf(p->out, "  FAULT %s at %.3f s: %s%s%s\n        %s\n        to do: %s\n", text, (double)c->in.time_ns * 1e-9, measured,
            *measured ? "; " : "", failure_of(c->first_fault)->platform, cause, remedy);
    outlet_flush(&p->steps);
}

void progress_result(struct progress *p, const struct test_result *t) {
    double unwanted = 0.0;
    for (int i = 0; i < DOFS; i++) unwanted = fmax(unwanted, t->unwanted_pct[i]);
    bool angle = t->dof >= DOF_PHI;
    clear_line(p);
    fprintf(p->out, "  test %d/%d %-5s ", t->test + 1, tests_count(&p->params->tests), dof_names[t->dof]);
    if (isfinite(t->achieved_amplitude))
        fprintf(p->out, "%.3f of %.3f %s, %.1f deg, unwanted %.1f %%, ", t->achieved_amplitude * 1e3, t->amplitude * 1e3,
                angle ? "mrad" : "mm", t->phase_deg, unwanted);
    fprintf(p->out, "%lld of %lld excluded%s%s\n", (long long)t->excluded, (long long)(t->samples + t->excluded), t->refused ? "; " : "",
            refusals[t->refused].why);
    outlet_flush(&p->steps);
}

void progress_motion(struct progress *p, const struct motion_result *m) {
    clear_line(p);
    fprintf(p->out, "  test 1/1 %s  ", tests_name(&p->params->tests, DOF_NONE));
    if (m->samples) fprintf(p->out, "off by at most %.3f mm, %.3f mrad, ", m->off_m * 1e3, m->off_rad * 1e3);
    fprintf(p->out, "%lld of %lld excluded%s%s\n", (long long)m->excluded, (long long)(m->samples + m->excluded), m->complete ? "" : "; ",
            refusals[m->complete ? REFUSED_NOT : REFUSED_INCOMPLETE].why);
    outlet_flush(&p->steps);
}

static void draw_bar(FILE *out, double share, const char *after) {
    static const char full[] = "################################", empty[] = "................................";
    int marks = (int)(BAR * fmin(fmax(share, 0.0), 1.0));
    fprintf(out, "[%.*s%.*s] %s", marks, full, BAR - marks, empty, after);
}

void progress_compute(struct progress *p, const char *what, double share) {
    static const double share_known = 0.05; /* share of the work up to which no expected time is
                                             * shown, because it would be a guess */
    char seconds[64];
    if (!p->computing) p->computing_ns = monotonic_ns();
    double spent_s = seconds_from_ns(monotonic_ns() - p->computing_ns);
    int used = snprintf(seconds, sizeof seconds, "%.0f", spent_s);
    if (share > share_known) used += snprintf(seconds + used, sizeof seconds - (size_t)used, " of about %.0f", spent_s / share);
    snprintf(seconds + used, sizeof seconds - (size_t)used, " s");
    if (p->terminal) {
        clear_line(p);
        fprintf(p->out, "  %-36s", what);
        draw_bar(p->out, share, seconds);
    } else if (what != p->computing) fprintf(p->out, "  %s\n", what);
    p->computing = what;
    outlet_flush(&p->steps);
}

static double done(const struct progress *p, const struct cycle *c) {
    const struct test_params *t = &p->params->tests;
    double state_s = (double)p->state_cycles * p->params->loop.period_s;
    switch (c->state) {
    case STATE_ENGAGING: return state_s / reference_park_s(&p->params->motion, p->params->motion.engage_s);
    case STATE_PARKING: return state_s / reference_park_s(&p->params->motion, p->params->motion.park_s);
    case STATE_READY: return state_s / p->params->motion.hold_s;
    case STATE_TESTING: return (c->test_time_s + t->settle_s) / (t->settle_s + t->ramp_s + t->duration_s + t->ramp_out_s);
    default: return 0.0;
    }
}

void progress_tick(struct progress *p, const struct cycle *c) {
    if (p->state_cycles++ % p->redraw_cycles || !p->terminal) return;
    clear_line(p);
    if (c->test >= 0)
        fprintf(p->out, "  test %d/%d  %-5s  ", c->test + 1, tests_count(&p->params->tests), tests_name(&p->params->tests, c->dof));
    else fprintf(p->out, "  %-18s", state_names[c->state]);
    draw_bar(p->out, done(p, c), progress_phases[c->phase]);
    outlet_flush(&p->steps);
}
