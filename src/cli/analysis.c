#include "analysis.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "gains.h"
#include "identification_table.h"
#include "leg_order.h"
#include "numeric.h"
#include "params.h"
#include "supervisor.h"
#include "units.h"

int analysis_init(struct analysis *a, const struct params *params, struct error *error) {
    *a = (struct analysis){.params = params};
    recording_init(&a->recording, params);
    int status = ident_init(&a->ident, params, error);
    return status ? status : parts_init(&a->parts, error);
}

void analysis_free(struct analysis *a) {
    measured_free(&a->measured);
    recording_free(&a->recording);
    parts_free(&a->parts);
}

/* The configured tests do not decide alone, because a log from elsewhere may contain another motion
 * than its configuration states. */
bool analysis_sinusoids(const struct analysis *a) {
    return tests_single(&a->params->tests) && (a->ident.result.tests || !a->motion.cycles);
}

/* Returns REFUSED_SURPLUS for a sample for which the recording has no room: a test of an axis may
 * have a sixth of ANALYSIS_SAMPLES; a motion of no axis may have those that the tests recorded so
 * far leave. */
static enum refusal surplus(const struct recording *r, enum dof dof) {
    int kept = 0;
    if (!r->tests) return REFUSED_NOT;
    const struct recording_test *last = &r->test[r->tests - 1];
    if (dof != DOF_NONE) return last->dof == dof && last->count >= ANALYSIS_SAMPLES / DOFS ? REFUSED_SURPLUS : REFUSED_NOT;
    for (int i = 0; i < r->tests; i++) kept += r->test[i].count;
    return kept < ANALYSIS_SAMPLES ? REFUSED_NOT : REFUSED_SURPLUS;
}

/* Removes what was recorded of an earlier test of this axis, or of this motion, because the machine
 * may have been changed in between. ident.h replaces the result of a test of an axis likewise. */
static void replace(struct analysis *a, const struct cycle *c) {
    struct recording *r = &a->recording;
    for (int i = r->tests - 1; i >= 0; i--)
        if (r->test[i].dof == c->dof && (c->dof != DOF_NONE || r->test[i].test == c->test)) recording_remove(r, i);
    if (c->dof == DOF_NONE && c->test <= a->parts_test) parts_clear(&a->parts);
}

static bool part_is_full(const struct recording *r) {
    const struct recording_test *t = r->tests ? &r->test[r->tests - 1] : NULL;
    if (!t || t->dof != DOF_NONE || !t->count) return false;
    return t->count >= ANALYSIS_SAMPLES || t->sample[t->count - 1].test_time_s - t->sample[0].test_time_s >= ANALYSIS_PART_S;
}

static void close_part(struct analysis *a) {
    struct recording *r = &a->recording, part = *r;
    part.test[0] = r->test[--r->tests];
    part.tests = 1;
    a->parts_test = part.test[0].test;
    parts_close(&a->parts, &part);
}

static void record(struct analysis *a, const struct cycle *c) {
    bool begins = c->test != a->last.test || c->dof != a->last.dof || c->test_time_s <= a->last.test_time_s;
    if (a->unrecorded.status || c->test < 0) return;
    if (!a->cycles || begins) replace(a, c);
    if (part_is_full(&a->recording)) close_part(a);
    if (!surplus(&a->recording, c->dof)) recording_add(&a->recording, c, &a->unrecorded);
}

/* Returns true if the test of this axis was evaluated and not refused; a motion of no axis always
 * counts as complete. */
static bool complete(const struct identification *id, enum dof dof) {
    bool is = dof == DOF_NONE;
    for (int k = 0; k < id->tests; k++) is = is || (id->test[k].dof == dof && !id->test[k].refused);
    return is;
}

/* Removes tests that are not complete, mostly because they were broken off, so that they do not
 * count against the complete ones. */
static void drop_incomplete(struct analysis *a) {
    for (int i = a->recording.tests - 1; i >= 0; i--)
        if (!complete(&a->ident.result, a->recording.test[i].dof)) recording_remove(&a->recording, i);
}

int analysis_copy(const struct analysis *a, struct recording *copy, struct error *error) {
    *copy = a->recording;
    copy->tests = 0;
    for (int i = 0; i < a->recording.tests; i++) {
        const struct recording_test *t = &a->recording.test[i];
        if (!complete(&a->ident.result, t->dof)) continue;
        struct recording_test *to = &copy->test[copy->tests];
        *to = *t;
        to->capacity = t->count, to->measured = NULL;
        to->sample = malloc((size_t)t->count * sizeof *to->sample);
        if (!to->sample) return error_set(error, STATUS_IO, "out of memory");
        memcpy(to->sample, t->sample, (size_t)t->count * sizeof *to->sample);
        copy->tests++;
    }
    return STATUS_OK;
}

static void count_missed(struct analysis *a, const struct cycle *c) {
    bool overran = c->in.flags & SAMPLE_OVERRUN;
    a->missed = overran ? add_saturated(a->missed, c->wake_late_ns / ns_from_seconds(a->params->loop.period_s)) : 0;
    a->longest_ns = !overran ? 0 : c->wake_late_ns > a->longest_ns ? c->wake_late_ns : a->longest_ns;
}

/* Counts an evaluated sample by every flag that it has; without a flag, by the reason for which
 * methods A and B exclude it. */
static void count_refused(struct analysis *a, const struct cycle *c) {
    if (c->test < 0 || c->phase != PHASE_EVALUATE) return;
    for (int i = 0; i < SAMPLE_FLAGS; i++) a->refused[REFUSED_STALE + i] += c->in.flags >> i & 1u;
    if (!c->in.flags) a->refused[a->ident.refused]++;
}

bool analysis_take(struct analysis *a, const struct cycle *c) {
    record(a, c);
    rest_take(&a->rest, c);
    weighing_take(&a->weighing, c);
    if (c->test >= 0 && c->dof != DOF_NONE) a->seen[c->dof] = true, a->driven[c->dof] = c->gains;
    if (a->cycles && c->seq > a->last.seq) a->lost = add_saturated(a->lost, cycles_between(a->last.seq, c->seq));
    a->last = *c;
    a->cycles++;
    count_missed(a, c);
    a->overruns += (c->in.flags & SAMPLE_OVERRUN) != 0;
    int64_t period_ns = ns_from_seconds(a->params->loop.period_s), missed = c->wake_late_ns / period_ns;
    a->stalls += missed > 0;
    a->behind_ns = add_saturated(a->behind_ns, missed * period_ns);
    histogram_add(&a->wake, c->wake_late_ns);
    histogram_add(&a->exec, c->exec_ns);
    motion_take(&a->motion, a->params, c);
    bool ended = ident_feed(&a->ident, c);
    count_refused(a, c);
    return ended;
}

bool analysis_end(struct analysis *a) { return ident_end(&a->ident); }

static void solve_method_c(struct analysis *a) {
    struct identification *r = &a->ident.result;
    method_c_solve(&a->equations, &a->calibrated, &a->estimate, &r->method_c, &r->no_method_c);
    r->common_gain = calibration_common_gain(&a->calibrated, a->equations.systematic);
}

void analysis_weigh(struct analysis *a, const struct weighing_found *found) {
    a->ident.result.weighed = *found;
    weighing_note(found, &a->calibrated);
    solve_method_c(a);
}

void analysis_identify(struct analysis *a) {
    struct identification *r = &a->ident.result;
    struct error *e = &r->no_method_c;
    struct error rest = a->unrecorded;
    r->rest = rest_find(&a->rest, a->params);
    a->calibrated = *a->params;
    rest_note_stops(&r->rest, &a->calibrated);
    drop_incomplete(a);
    parts_take(&a->parts, true);
    if (!rest.status && !a->recording.tests) error_set(&rest, STATUS_USAGE, "no complete test");
    if (!rest.status) estimator_equations(&a->recording, &a->measured, &a->admission, &a->equations, &rest);
    r->refuted = rest.status && a->admission.refuted && !a->parts.all;
    /* if the last part of a long motion is too short for equations, its samples are dropped, so
     * that no report takes them for the whole test */
    if (rest.status && a->parts.all) measured_free(&a->measured), recording_free(&a->recording);
    parts_add(&a->parts, &a->equations, &rest);
    r->parts = a->parts.all > 1 ? a->parts.all : 0, r->parts_left_out = a->parts.left_out;
    if (!parts_sum(&a->parts, &a->calibrated, &a->equations, &r->over_time, e)) solve_method_c(a);
}

struct loop_statistics analysis_statistics(const struct analysis *a) {
    static const double quantile[] = {0.5, 0.99, 0.999};
    struct loop_statistics s = {.cycles = a->cycles,
                                .overruns = a->overruns,
                                .lost = a->lost + a->unlogged,
                                .period_s = a->params->loop.period_s,
                                .timed = a->exec.max_ns > 0, /* on a virtual clock no time passes
                                                              * within a cycle */
                                .stalls = a->stalls};
    double own_s = (double)a->cycles * s.period_s;
    s.pace = own_s > 0.0 ? own_s / (own_s + seconds_from_ns(a->behind_ns)) : 1.0;
    s.longest_stall_s = a->stalls ? seconds_from_ns(a->wake.max_ns) : 0.0;
    for (int i = 0; i < 3; i++) {
        s.wake_us[i] = us_from_ns(histogram_quantile(&a->wake, quantile[i]));
        s.exec_us[i] = us_from_ns(histogram_quantile(&a->exec, quantile[i]));
    }
    s.wake_us[3] = us_from_ns(a->wake.max_ns);
    s.exec_us[3] = us_from_ns(a->exec.max_ns);
    return s;
}

static bool evaluated(const struct identification *id, enum dof dof) {
    for (int i = 0; i < id->tests; i++)
        if (id->test[i].dof == dof) return true;
    return false;
}

/* Returns the name and the measured value of the last cycle's fault, or NULL if that cycle has
 * none. The text is valid until the next call. */
static const char *last_fault(struct analysis *a) {
    if (!a->last.first_fault) return NULL;
    const char *name = fault_name(a->last.first_fault);
    /* the text of a log's fault event has the measured value, which the log's cycles lack; so the
     * text is kept if it names the same fault */
    if (strncmp(a->fault, name, strlen(name)) != 0) fault_line(a->last.first_fault, a->last.faults, &a->last.measure, a->fault);
    return a->fault;
}

static struct verdict judge_method_c(const struct analysis *a) {
    const struct identification *id = &a->ident.result;
    if (!id->method_c.matrix.evaluated) return method_c_no_verdict(id->no_method_c.status ? id->no_method_c.text : NULL);
    return method_c_verdict(&(struct method_c_findings){
        .result = &id->method_c, .equations = &a->equations, .estimate = &a->estimate, .nominal = (const double (*)[DOFS])id->nominal_mt});
}

/* Notes two errors of the configuration that a recording without reference cannot show, since they
 * change no length and no force: x and y are turned or mirrored, or the legs of a symmetric machine
 * are numbered in another way. */
static void note_symmetries(const struct analysis *a, struct verdict *v) {
    char orders[LEG_ORDER_TEXT];
    if (a->recording.measured.reference || !a->ident.result.method_c.matrix.evaluated || !params_mechanism(a->params)->pose) return;
    leg_order_symmetries(a->params, orders);
    verdict_note(v, "undecided without a recorded reference, as it changes no length and no force: whether both lists of joints are turned "
                    "by any angle about z, or mirrored, against the machine's x and y");
    if (*orders) verdict_note(v, "undecided without a recorded reference, as it changes no length and no force: %s", orders);
}

/* Returns true if two axes were tested with different gains; the result would then mix two
 * controllers. */
static bool gains_differ(const struct analysis *a) {
    const struct gains *first = NULL;
    for (int dof = 0; dof < DOFS; dof++) {
        if (!a->seen[dof]) continue;
        if (first && !gains_equal(first, &a->driven[dof])) return true;
        first = &a->driven[dof];
    }
    return false;
}

/* Withdraws the matrices of methods A and B, because the recording contradicts the configured
 * machine. */
static void withhold(struct identification *id) { id->method_a.evaluated = id->modified_a.evaluated = id->method_b.evaluated = false; }

/* Notes that only the last of several tests of an axis counts: they may be of several runs, between
 * which the machine was changed. */
static void note_replaced(const struct identification *id, struct verdict *v) {
    char axes[64] = "";
    int tests = 0;
    for (int dof = 0; dof < DOFS; dof++) {
        if (!id->replaced[dof]) continue;
        size_t used = strlen(axes);
        snprintf(axes + used, sizeof axes - used, "%s%s", used ? ", " : "", dof_names[dof]);
        tests += id->replaced[dof];
    }
    if (tests)
        verdict_note(
            v,
            "%d earlier test(s) of %s left out: the last test of an axis counts, as after a second `start`; if they are of several "
            "runs, identify each run by itself",
            tests, axes);
}

/* Notes that the legs move at a frequency other than the stated one: then one of the two is wrong,
 * the statement or the recording's clock, and forces alone do not tell which. */
static void note_frequency(const struct recording *r, struct verdict *v) {
    const struct recording_test *first = NULL;
    int tests = 0;
    for (int i = r->tests - 1; i >= 0; i--) {
        const struct recording_test *t = &r->test[i];
        if (!(t->segment_s > 0.0) && fabs(t->frequency_hz - t->stated_hz) > 0.0) first = t, tests++;
    }
    if (!first) return;
    char others[32] = "";
    if (tests > 1) snprintf(others, sizeof others, " and %d more", tests - 1);
    verdict_note(v,
                 "in test %s%s the legs move at %.6g Hz where %.6g was stated: to methods A and B they seem to wander; state the right "
                 "frequency (tests.frequency_hz), or, if it is right, mend the recording's clock: masses and inertias are off by %+.2g %%",
                 dof_names[first->dof], others, first->frequency_hz, first->stated_hz,
                 100.0 * (square(first->stated_hz / first->frequency_hz) - 1.0));
}

struct verdicts analysis_verdicts(struct analysis *a) {
    const struct identification *id = &a->ident.result;
    const struct run_facts facts = {.sinusoids = analysis_sinusoids(a), .cycles = a->cycles, .overruns = a->overruns};
    const char *fault = last_fault(a);
    ident_solve(&a->ident);
    if (id->refuted) withhold(&a->ident.result);
    struct verdicts v = {.run = verdict_of_data(a->params, id, &facts),
                         .method_a = verdict_of_matrix(a->params, id, &id->method_a, "method A"),
                         .modified_a = verdict_of_matrix(a->params, id, &id->modified_a, "modified method A"),
                         .method_b = verdict_of_matrix(a->params, id, &id->method_b, "method B"),
                         .method_c = judge_method_c(a)};
    if (!tests_single(&a->params->tests)) motion_judge(&a->motion, a->params, &v.run);
    for (int dof = 0; dof < DOFS; dof++)
        if (a->seen[dof] && !evaluated(id, (enum dof)dof))
            verdict_add(&v.run, VERDICT_NOT_EVALUATED, "test %s excluded: %s", dof_names[dof], refusals[REFUSED_EMPTY].why);
    if (gains_differ(a))
        verdict_add(&v.run, VERDICT_NOT_EVALUATED, "the gains were changed between its tests; repeat all of them with the same gains");
    if (fault) verdict_add(&v.run, VERDICT_FAIL, "fault %s", fault);
    verdict_of_run(&v, a->params, id, &facts);
    note_symmetries(a, &v.run);
    note_replaced(id, &v.run);
    note_frequency(&a->measured.recording, &v.run);
    if (a->admission.excluded) verdict_note(&v.run, "%d record(s) excluded: %.200s", a->admission.excluded, a->admission.exclusion.text);
    if (v.method_c.status == VERDICT_FAIL) verdict_note(&v.run, "`hexid gap` on this log tries which sensor or effect explains it");
    return v;
}

int analysis_identifies(const struct analysis *a, const char *path, struct error *error) {
    const struct identification *r = &a->ident.result;
    if (r->tests || r->method_c.matrix.evaluated || !a->motion.cycles) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "%.250s: nothing to identify: %.500s", path, r->no_method_c.text);
}

static void print_times(const char *what, const double us[4], FILE *out) {
    fprintf(out, "          %-9s  p50 %.0f  p99 %.0f  p99.9 %.0f  max %.0f us\n", what, us[0], us[1], us[2], us[3]);
}

static void print_loop(const struct loop_statistics *s, bool brief, FILE *out) {
    fprintf(out, "loop      %" PRId64 " cycles of %g ms, %" PRId64 " overruns, %" PRId64 " records lost\n", s->cycles, s->period_s * 1e3,
            s->overruns, s->lost);
    if (!s->timed) return;
    fprintf(out, "          %.3f x real time, %" PRId64 " stall%s of this host", s->pace, s->stalls, s->stalls == 1 ? "" : "s");
    if (s->stalls) fprintf(out, ", the longest %.0f ms", s->longest_stall_s * 1e3);
    fprintf(out, "\n");
    if (brief) return;
    print_times("wake-up", s->wake_us, out);
    print_times("execution", s->exec_us, out);
}

/* Prints method A's verdict if method C has a result, too: the run's verdict is then method C's. */
static void print_method_a(const struct analysis *a, const struct verdicts *v, FILE *out) {
    const struct identification *id = &a->ident.result;
    if (!id->method_a.evaluated || !id->method_c.matrix.evaluated) return;
    fprintf(out, "method A  %s\n", verdict_names[v->method_a.status]);
    for (int i = 0; i < v->method_a.reasons; i++) fprintf(out, "          %s\n", v->method_a.reason[i]);
}

void analysis_print(struct analysis *a, const struct verdicts *verdicts, bool brief, FILE *out) {
    struct loop_statistics s = analysis_statistics(a);
    if (brief) identification_brief_print(out, &a->ident.result, analysis_sinusoids(a));
    else identification_table_print(out, &a->ident.result, analysis_sinusoids(a));
    print_loop(&s, brief, out);
    verdict_print(&verdicts->run, out);
    if (!brief) print_method_a(a, verdicts, out);
}

char *analysis_json(const struct analysis *a, const struct verdicts *verdicts) {
    struct loop_statistics s = analysis_statistics(a);
    return identification_json(&a->ident.result, verdicts, &s);
}
