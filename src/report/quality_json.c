#include <complex.h>
#include <math.h>
#include <stddef.h>
#include <string.h>
#include <unistd.h>

#include "input.h"
#include "printable.h"
#include "quality_report.h"
#include "report_json.h"
#include "units.h"

static const char schema[] = "hexid.qualify/1";

static json_t *tone_json(const struct quality *q, int dof, int i) {
    const struct quality_tone *t = &q->tone[dof][i];
    double gain[DOFS], phase_deg[DOFS], cross[DOFS];
    for (int k = 0; k < DOFS; k++) {
        gain[k] = cabs(t->gain[k]), cross[k] = quality_cross(q, dof, i, k);
        phase_deg[k] = k == dof ? quality_phase_deg(q, dof, i) : deg_from_rad(carg(t->gain[k]));
    }
    return json_pack("{so so so so so so so so so so so}", "frequency_hz", report_number(t->hz), "amplitude", report_number(t->amplitude),
                     "gain", report_vector(gain, DOFS), "phase_deg", report_vector(phase_deg, DOFS), "cross_talk",
                     report_vector(cross, DOFS), "std", report_number(t->std), "coherence", report_number(t->coherence), "harmonics",
                     report_number(t->low), "high_harmonics", report_number(t->high), "noise", report_number(t->noise), "peak",
                     report_number(t->peak));
}

/* Members of struct quality_axis that are one number each, in the order of the struct. */
static const struct {
    const char *key;
    size_t at;
} numbers[] = {
#define NUMBER(member) {#member, offsetof(struct quality_axis, member)}
    NUMBER(threshold), NUMBER(hysteresis), NUMBER(slope_rate), NUMBER(lag_s), NUMBER(dead_s),
    NUMBER(half_s),    NUMBER(excursion),  NUMBER(rate),       NUMBER(accel), NUMBER(turn_around),
};
enum { NUMBERS = sizeof numbers / sizeof *numbers };

static double *number_of(struct quality_axis *a, int i) { return (double *)(void *)((char *)a + numbers[i].at); }

static json_t *axis_json(const struct quality *q, int dof) {
    struct quality_axis a = q->axis[dof];
    json_t *axis = json_pack("{ss}", "axis", dof_names[dof]), *tones = json_array();
    for (int i = 0; i < NUMBERS; i++) axis = report_set(axis, numbers[i].key, report_number(*number_of(&a, i)));
    for (int i = 0; i < q->plan.tones; i++) tones = report_append(tones, tone_json(q, dof, i));
    axis = report_set(axis, "rest", report_vector(a.rest, QUALITY_BANDS));
    return report_set(axis, "tones", tones);
}

static json_t *check_json(const struct quality_check *c) {
    return json_pack("{ss so ss so so ss ss*}", "name", c->key, "value", report_number(c->value), "unit", c->unit, "limit",
                     c->limit > 0.0 ? report_number(c->limit) : json_null(), "frequency_hz", report_number(c->hz), "status",
                     verdict_names[c->status], "axis", c->dof == DOF_NONE ? NULL : dof_names[c->dof]);
}

static json_t *change_json(const struct quality_report *r) {
    json_t *tones = json_array();
    char file[1024];
    for (int dof = 0; dof < DOFS; dof++)
        for (int i = 0; i < r->quality.plan.tones; i++) {
            struct quality_change c = quality_change(&r->quality, &r->before, dof, i);
            tones = report_append(tones, json_pack("{ss so so so so so}", "axis", dof_names[dof], "frequency_hz",
                                                   report_number(r->quality.tone[dof][i].hz), "gain_pct", report_number(c.gain_pct),
                                                   "phase_deg", report_number(c.phase_deg), "mps2", report_number(c.mps2), "of_noise",
                                                   report_number(c.of_noise)));
        }
    text_printable(r->baseline, file, sizeof file);
    return json_pack("{ss so so}", "file", file, "of_noise", report_number(quality_change_of_noise(&r->quality, &r->before)), "tones",
                     tones);
}

char *quality_json(const struct quality_report *r) {
    const struct quality *q = &r->quality;
    json_t *axes = json_array(), *checks = json_array();
    double leg[LEGS], lead_deg[LEGS];
    char log[1024];
    text_printable(r->log, log, sizeof log);
    for (int k = 0; k < LEGS; k++) leg[k] = cabs(q->leg[k]), lead_deg[k] = deg_from_rad(carg(q->leg[k]));
    for (int dof = 0; dof < DOFS; dof++) axes = report_append(axes, axis_json(q, dof));
    for (int i = 0; i < QUALITY_CHECKS; i++) checks = report_append(checks, check_json(&r->check[i]));
    json_t *root = json_pack(
        "{ss ss ss ss so si so si so so s{so so} so ss}", "schema", schema, "version", r->version, "log", log, "law", r->law, "arm_m",
        report_number(q->plan.arm_m), "samples", q->plan.cycles, "step_s", report_number(q->plan.step_s), "missing", q->missing,
        "rest_bands_hz", report_vector(quality_band_hz, QUALITY_BANDS + 1), "axes", axes, "legs", "gain", report_vector(leg, LEGS),
        "phase_deg", report_vector(lead_deg, LEGS), "checks", checks, "verdict", verdict_names[quality_verdict(r->check)]);
    return report_text(r->baseline ? report_set(root, "baseline", change_json(r)) : root);
}

/* Returns a number of an object; NaN if there is none. */
static double number(const json_t *object, const char *key) {
    const json_t *value = json_object_get(object, key);
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

static double item(const json_t *object, const char *key, size_t i) {
    const json_t *value = json_array_get(json_object_get(object, key), i);
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

/* Returns item i of the lists `gain` and `phase_deg` as a complex number. */
static double complex gain_of(const json_t *object, size_t i) {
    return item(object, "gain", i) * cexp(CMPLX(0.0, rad_from_deg(item(object, "phase_deg", i))));
}

static void read_tone(const json_t *from, struct quality_tone *t) {
    *t = (struct quality_tone){.hz = number(from, "frequency_hz"),
                               .amplitude = number(from, "amplitude"),
                               .std = number(from, "std"),
                               .coherence = number(from, "coherence"),
                               .low = number(from, "harmonics"),
                               .high = number(from, "high_harmonics"),
                               .noise = number(from, "noise"),
                               .peak = number(from, "peak")};
    for (size_t k = 0; k < DOFS; k++) t->gain[k] = gain_of(from, k);
}

static bool read_axis(const json_t *from, int dof, struct quality *q) {
    const json_t *tones = json_object_get(from, "tones");
    size_t count = json_array_size(tones);
    const char *name = json_string_value(json_object_get(from, "axis"));
    if (!name || strcmp(name, dof_names[dof]) || count > QUALITY_TONES || (dof && (int)count != q->plan.tones)) return false;
    q->plan.tones = (int)count;
    for (size_t i = 0; i < count; i++) read_tone(json_array_get(tones, i), &q->tone[dof][i]);
    for (int i = 0; i < NUMBERS; i++) *number_of(&q->axis[dof], i) = number(from, numbers[i].key);
    for (size_t i = 0; i < QUALITY_BANDS; i++) q->axis[dof].rest[i] = item(from, "rest", i);
    return true;
}

static bool read_all(const json_t *root, struct quality *q) {
    const json_t *axes = json_object_get(root, "axes"), *legs = json_object_get(root, "legs");
    const char *name = json_string_value(json_object_get(root, "schema"));
    *q = (struct quality){.plan = {.arm_m = number(root, "arm_m")}};
    bool good = name && !strcmp(name, schema) && json_array_size(axes) == DOFS;
    for (int dof = 0; dof < DOFS && good; dof++) good = read_axis(json_array_get(axes, (size_t)dof), dof, q) && q->plan.tones > 0;
    for (size_t k = 0; k < LEGS; k++) q->leg[k] = gain_of(legs, k);
    return good;
}

int quality_json_read(const char *path, struct quality *q, struct error *error) {
    const char *reason;
    int file = input_open(path, &reason);
    if (file < 0) return error_set(error, STATUS_IO, "%.300s: cannot be read: %s", path, reason);
    json_t *root = json_loadfd(file, 0, NULL);
    bool good = root && read_all(root, q);
    close(file);
    json_decref(root);
    return good ? STATUS_OK : error_set(error, STATUS_USAGE, "%.300s: not a result of `hexid qualify --json` (schema %s)", path, schema);
}
