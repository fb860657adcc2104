#include "report_json.h"

#include <math.h>

json_t *report_number(double x) { return isfinite(x) ? json_real(x) : json_null(); }

json_t *report_append(json_t *array, json_t *value) {
    if (json_array_append_new(array, value) == 0) return array;
    json_decref(array);
    return NULL;
}

json_t *report_set(json_t *object, const char *key, json_t *value) {
    if (json_object_set_new(object, key, value) == 0) return object;
    json_decref(object);
    return NULL;
}

json_t *report_vector(const double *x, int count) {
    json_t *array = json_array();
    for (int i = 0; i < count; i++) array = report_append(array, report_number(x[i]));
    return array;
}

json_t *report_matrix(const double *m) {
    json_t *array = json_array();
    for (int i = 0; i < DOFS; i++) array = report_append(array, report_vector(m + DOFS * i, DOFS));
    return array;
}

/* Returns the fundamental of a pose or wrench: a sine and a cosine coefficient for each axis. */
static json_t *fundamental(const double c[DOFS][2]) {
    double sine[DOFS], cosine[DOFS];
    for (int i = 0; i < DOFS; i++) sine[i] = c[i][0], cosine[i] = c[i][1];
    return json_pack("{so so}", "sin", report_vector(sine, DOFS), "cos", report_vector(cosine, DOFS));
}

static json_t *test(const struct test_result *t) {
    double rms[2 * DOFS];
    for (int i = 0; i < DOFS; i++) rms[i] = t->pose_rms[i], rms[DOFS + i] = t->wrench_rms[i];
    return json_pack("{ss so so so so so sI sI sb so so so so}", "dof", dof_names[t->dof], "frequency_hz", report_number(t->frequency_hz),
                     "amplitude", report_number(t->amplitude), "achieved_amplitude", report_number(t->achieved_amplitude), "phase_deg",
                     report_number(t->phase_deg), "unwanted_pct", report_vector(t->unwanted_pct, DOFS), "samples", (json_int_t)t->samples,
                     "excluded", (json_int_t)t->excluded, "complete", !t->refused, "residual_rms", report_vector(rms, 2 * DOFS), "pose",
                     fundamental(t->pose), "wrench", fundamental(t->wrench), "wrench_std", report_vector(t->wrench_std, DOFS));
}

static json_t *method(const struct method_result *m, bool damping, const struct verdict *verdict) {
    if (!m->evaluated) return json_null();
    json_t *object = json_pack("{so so so so}", "Mt", report_matrix(m->mt[0]), "std", report_matrix(m->mt_std[0]), "condition_number",
                               report_number(m->condition_number), "verdict", report_verdict(verdict));
    return damping ? report_set(report_set(object, "Bt", report_matrix(m->bt[0])), "Bt_std", report_matrix(m->bt_std[0])) : object;
}

/* Returns every second value from x on; in dry[LEGS][2] these are the values of one direction. */
static json_t *strided(const double *x) {
    double value[LEGS];
    for (int k = 0; k < LEGS; k++) value[k] = x[2 * k];
    return report_vector(value, LEGS);
}

static json_t *payload_values(const double value[PAYLOAD_VALUES]) {
    json_t *object = json_object();
    for (int i = 0; i < PAYLOAD_VALUES; i++) object = report_set(object, payload_names[i], report_number(value[i]));
    return object;
}

static json_t *payload_json(const struct payload *p) {
    if (!p->evaluated) return json_null();
    return json_pack("{so so so so so}", "value", payload_values(p->value), "std", payload_values(p->std), "possible",
                     p->whole ? json_boolean(p->possible) : json_null(), "nearest", payload_values(p->nearest), "misfit",
                     report_number(p->misfit));
}

/* Returns the systematic errors that the tolerances allow, each with its value, standard deviation
 * and prior standard deviation. */
static json_t *systematic(const struct method_c *c) {
    json_t *array = json_array();
    for (int i = 0; i < SYSTEMATICS; i++) {
        const struct systematic_found *found = &c->systematic[i];
        char name[SYSTEMATIC_NAME];
        if (!(found->prior > 0.0)) continue;
        systematic_name(i, name);
        array = report_append(array, json_pack("{ss ss so so so}", "error", name, "tolerance",
                                               systematic_families[systematic_family(i)].key, "value", report_number(found->value), "std",
                                               report_number(found->std), "prior_std", report_number(found->prior)));
    }
    return array;
}

/* Returns the share of each cause in the variance of each entry. */
static json_t *shares(const struct method_c *c) {
    json_t *object = json_object();
    for (int i = 0; i < CAUSES; i++) object = report_set(object, method_c_cause(i), report_matrix(c->share[i][0]));
    return object;
}

json_t *report_method_c(const struct method_c *c, const struct common_gain *gain, const struct verdict *verdict) {
    if (!c->matrix.evaluated) return json_null();
    json_t *found = json_pack(
        "{so so so so s{so so so so} so so so so}", "Mt", report_matrix(c->matrix.mt[0]), "std", report_matrix(c->matrix.mt_std[0]),
        "viscous_n_s_per_m", report_vector(c->viscous, LEGS), "viscous_std_n_s_per_m", report_vector(c->viscous_std, LEGS),
        "dry_friction_n", "extend", strided(c->dry[0]), "extend_std", strided(c->dry_std[0]), "retract", strided(c->dry[0] + 1),
        "retract_std", strided(c->dry_std[0] + 1), "scatter", report_number(c->scatter), "condition_number",
        report_number(c->matrix.condition_number), "payload", payload_json(&c->payload), "verdict", report_verdict(verdict));
    if (c->springs)
        found = report_set(found, "springs",
                           json_pack("{so so}", "value", report_vector(c->spring, DOFS), "std", report_vector(c->spring_std, DOFS)));
    found = report_set(found, "systematic", systematic(c));
    found = report_set(found, "skew_test_s", report_number(c->skew_test_s));
    if (gain->sensors)
        found = report_set(found, "common_gain",
                           json_pack("{ss so si so}", "rests_on", "model.tolerance.pressure_gain", "tolerance",
                                     report_number(gain->tolerance), "sensors", gain->sensors, "prior_std", report_number(gain->std)));
    found = report_set(found, "variance_shares", shares(c));
    if (!c->at_pose.asked) return found;
    return report_set(found, "at_pose",
                      json_pack("{so so}", "pose", report_vector(c->at_pose.pose, DOFS), "Mt",
                                c->at_pose.determined ? report_matrix(c->at_pose.mt[0]) : json_null()));
}

static json_t *errors(const struct identification *id, const struct method_result *m) {
    if (!m->evaluated) return json_null();
    json_t *object = json_object();
    for (int i = 0; i < IDENT_ENTRIES; i++)
        object = report_set(object, ident_entries[i].name, report_number(ident_error_pct(id, m, &ident_entries[i])));
    return object;
}

static json_t *quantiles(const double us[4], bool timed) {
    if (!timed) return json_null();
    return json_pack("{so so so so}", "p50", report_number(us[0]), "p99", report_number(us[1]), "p999", report_number(us[2]), "max",
                     report_number(us[3]));
}

static json_t *texts(int count, const char text[][VERDICT_TEXT]) {
    json_t *array = json_array();
    for (int i = 0; i < count; i++) array = report_append(array, json_string(text[i]));
    return array;
}

json_t *report_verdict(const struct verdict *v) {
    return json_pack("{ss ss so so}", "scope", v->scope, "status", verdict_names[v->status], "reasons", texts(v->reasons, v->reason),
                     "notes", texts(v->notes, v->note));
}

json_t *report_agreement(const struct agreement *a) {
    return json_pack("{so so si so}", "agree", a->evaluated ? json_boolean(a->agree) : json_null(), "chi_square",
                     report_number(a->chi_square), "degrees", a->degrees, "probability", report_number(a->probability));
}

/* Adds the readings at rest and of a known weight, if the log has them. */
static json_t *with_calibration(json_t *root, const struct identification *id) {
    const struct rest_found *r = &id->rest;
    const struct weighing_found *w = &id->weighed;
    if (r->samples >= REST_LEAST)
        root = report_set(root, "rest",
                          json_pack("{sI so so so so so}", "samples", (json_int_t)r->samples, "length_m", report_vector(r->length_m, LEGS),
                                    "p1_zero_pa", report_vector(r->zero_pa[0], LEGS), "p1_zero_std_pa",
                                    report_vector(r->zero_std_pa[0], LEGS), "p2_zero_pa", report_vector(r->zero_pa[1], LEGS),
                                    "p2_zero_std_pa", report_vector(r->zero_std_pa[1], LEGS)));
    if (!(w->stated_kg > 0.0)) return root;
    return report_set(root, "weight",
                      json_pack("{so so so so so so si so so}", "stated_kg", report_number(w->stated_kg), "reading_kg",
                                report_number(w->reading_kg), "std_kg", report_number(w->std_kg), "friction_kg",
                                report_number(w->friction_kg), "drift_kg", report_number(w->drift_kg), "drift_std_kg",
                                report_number(w->drift_std_kg), "tests", w->tests, "p1_shares", report_vector(w->share[0], LEGS),
                                "p2_shares", report_vector(w->share[1], LEGS)));
}

/* Adds the parts of a long motion; other motions have no parts. */
static json_t *with_parts(json_t *root, const struct identification *id) {
    if (!id->parts) return root;
    return report_set(root, "parts",
                      json_pack("{si si si so}", "count", id->parts, "left_out", id->parts_left_out, "groups", id->over_time.logs,
                                "agreement", id->over_time.logs > 1 ? report_agreement(&id->over_time) : json_null()));
}

json_t *report_identification(const struct identification *id, const struct verdicts *verdicts, const struct loop_statistics *loop) {
    json_t *tests = json_array();
    for (int i = 0; i < id->tests; i++) tests = report_append(tests, test(&id->test[i]));
    json_t *root = json_pack(
        "{ss so s{so} so so so so so s{so so so so} s{sI sI sI so so so so so so} so}", "schema", "hexid.identification/1", "tests", tests,
        "nominal", "Mt", report_matrix(id->nominal_mt[0]), "method_a", method(&id->method_a, true, &verdicts->method_a), "modified_a",
        method(&id->modified_a, false, &verdicts->modified_a), "method_b", method(&id->method_b, false, &verdicts->method_b), "method_c",
        report_method_c(&id->method_c, &id->common_gain, &verdicts->method_c), "method_c_reason",
        id->no_method_c.status ? json_string(id->no_method_c.text) : json_null(), "errors_pct", "method_a", errors(id, &id->method_a),
        "modified_a", errors(id, &id->modified_a), "method_b", errors(id, &id->method_b), "method_c", errors(id, &id->method_c.matrix),
        "loop", "cycles", (json_int_t)loop->cycles, "overruns", (json_int_t)loop->overruns, "lost_records", (json_int_t)loop->lost,
        "period_s", report_number(loop->period_s), "wake_us", quantiles(loop->wake_us, loop->timed), "exec_us",
        quantiles(loop->exec_us, loop->timed), "pace", loop->timed ? report_number(loop->pace) : json_null(), "stalls",
        loop->timed ? json_integer(loop->stalls) : json_null(), "longest_stall_s",
        loop->timed ? report_number(loop->longest_stall_s) : json_null(), "verdict", report_verdict(&verdicts->run));
    return with_calibration(with_parts(root, id), id);
}

char *report_text(json_t *root) {
    char *text = root ? json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(root);
    return text;
}

char *identification_json(const struct identification *id, const struct verdicts *verdicts, const struct loop_statistics *loop) {
    /* A fixed seed keeps jansson from opening /dev/urandom; no key here is hostile. */
    json_object_seed(1);
    return report_text(report_identification(id, verdicts, loop));
}
