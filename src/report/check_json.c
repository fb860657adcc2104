#include "check_report.h"
#include "printable.h"
#include "report_json.h"

static json_t *text(const char *words) {
    char printable[1024];
    text_printable(words, printable, sizeof printable);
    return json_string(printable);
}

/* Returns a list of the channels whose bits are set, numbered from 1: legs, or axes of the
 * reference. */
static json_t *legs(unsigned bits) {
    json_t *array = json_array();
    for (int i = 0; i < LEGS; i++)
        if (bits >> i & 1u) json_array_append_new(array, json_integer(i + 1));
    return array;
}

static json_t *channel(const struct survey_channel *c) {
    return json_pack("{si so so so so so so so}", "of", c->of, "there", legs(c->there), "dead", legs(c->dead), "clipped", legs(c->clipped),
                     "least", report_number(c->low), "greatest", report_number(c->high), "noise_rms", report_number(c->noise), "step",
                     c->step > 0.0 ? json_real(c->step) : json_null());
}

static json_t *channels(const struct survey *s) {
    const char *const units[SURVEY_KINDS] = {"m", s->mechanism->pose ? "m, rad" : "m", "Pa", "Pa", "N", "-"};
    json_t *object = json_object();
    for (int kind = 0; kind < SURVEY_KINDS; kind++) {
        json_t *c = channel(&s->channel[kind]);
        if (s->channel[kind].of) json_object_set_new(c, "unit", json_string(units[kind])), json_object_set(object, survey_names[kind], c);
        json_decref(c);
    }
    return object;
}

static json_t *segments(const struct survey *s) {
    json_t *array = json_array();
    for (const struct segment *p = s->segments.segment; p < s->segments.segment + s->segments.count; p++) {
        double from_s = s->test.sample[p->first].test_time_s, until_s = s->test.sample[p->end - 1].test_time_s;
        json_array_append_new(array, json_pack("{ss si si so so so}", "kind", segment_names[p->kind], "first", p->first, "end", p->end,
                                               "from_s", report_number(from_s), "until_s", report_number(until_s), "frequency_hz",
                                               report_number(p->frequency_hz)));
    }
    return array;
}

static json_t *test(const struct survey *s) {
    const struct sampling *a = &s->sampling;
    return json_pack("{so ss ss so so so so ss si so so so sI so si si si so so so}", "name", text(s->name), "axis",
                     s->test.dof == DOF_NONE ? "none" : dof_names[s->test.dof], "mechanism", s->mechanism->name, "stated_hz",
                     report_number(s->stated_hz), "stated_amplitude", report_number(s->stated_amplitude), "measured_hz",
                     report_number(s->measured_hz), "amplitude", report_number(s->amplitude), "amplitude_unit",
                     s->test.dof >= DOF_PHI ? "rad" : "m", "rows", s->test.count, "seconds", report_number(survey_seconds(s)), "rate_hz",
                     report_number(1.0 / a->step_s), "jitter_s", report_number(a->jitter_s), "lost", (json_int_t)a->lost, "longest_gap_s",
                     report_number(a->gap_s), "flagged", s->flagged, "not_a_number", s->not_a_number, "unplaced", s->unplaced, "pieces",
                     segments(s), "ramp_least_s", report_number(s->ramp_least_s), "channels", channels(s));
}

static json_t *answer(const struct error *e) {
    return json_pack("{sb so}", "taken", !e->status, "reason", e->text[0] ? text(e->text) : json_null());
}

char *check_json(const struct check_report *r) {
    json_t *tests = json_array(), *sources = json_array();
    for (int i = 0; i < r->surveys; i++) json_array_append_new(tests, test(&r->survey[i]));
    for (int i = 0; i < r->sources; i++) json_array_append_new(sources, text(r->source[i]));
    json_t *root = json_pack("{ss so so so so so so so so so so so}", "schema", "hexid.check/1", "sources", sources, "tests", tests,
                             "missing", text(r->missing), "doubtful", text(r->doubtful), "ignored", text(r->ignored), "identify",
                             answer(&r->identify), "gap", answer(&r->gap), "areas", r->areas[0] ? text(r->areas) : json_null(), "defaults",
                             r->defaults[0] ? text(r->defaults) : json_null(), "zero", text(r->zero), "left_out", text(r->left_out));
    return report_text(root);
}
