#include "tune_report.h"

#include <math.h>
#include <string.h>

#include "number_text.h"
#include "params.h"
#include "report_json.h"
#include "units.h"

static const double WORTH = 1.1; /* ratio of new and old value of a gain above which the change is
                                  * worth mentioning */

static const char *const parts[] = {
    [LOOP_PART_NONE] = "none", [LOOP_PART_VALVE] = "valve_lag", [LOOP_PART_CYCLE] = "cycle", [LOOP_PART_OIL] = "oil"};

static const char *const words[] = {[LOOP_PART_NONE] = "no part alone",
                                    [LOOP_PART_VALVE] = "the valves' lag",
                                    [LOOP_PART_CYCLE] = "the cycle",
                                    [LOOP_PART_OIL] = "the oil"};

enum { GAINS = 7, CELL = 24 };

/* The gains that `hexid tune` sets, with their units. The gain that most often decides comes
 * first. */
static const struct gain {
    const char *name, *unit;
    size_t offset;
} gains[GAINS] = {
    {"kpf", "1/N", offsetof(struct control_params, kpf)},   {"kp", "1/m", offsetof(struct control_params, kp)},
    {"ki", "1/(m s)", offsetof(struct control_params, ki)}, {"kff", "s/m", offsetof(struct control_params, kff)},
    {"kd", "s/m", offsetof(struct control_params, kd)},     {"tp", "s", offsetof(struct control_params, tp)},
    {"modal", "-", offsetof(struct control_params, modal)},
};

static double gain_value(const struct control_params *g, int i) { return *(const double *)((const char *)g + gains[i].offset); }

/* ---- for people ---- */

static const char *cell(char text[CELL], const char *format, double value) {
    if (isfinite(value)) snprintf(text, CELL, format, value);
    else snprintf(text, CELL, "%s", value > 0.0 ? "any" : "-");
    return text;
}

static void print_modes(FILE *out, const struct loop_tune *t) {
    fprintf(out, "  oil mode      no controller   configured                             tuned\n"
                 "                Hz  damping     damping bandwidth   gain   phase       damping bandwidth   gain   phase\n");
    for (int i = 0; i < DOFS; i++) {
        const struct loop_mode_standing *before = &t->before.mode[i], *after = &t->after.mode[i];
        fprintf(out, "  %d %-5s  %8.3g %8.2f", i + 1, dof_names[before->dof], before->oil_hz, before->oil_damping);
        for (int k = 0; k < 2; k++) {
            const struct loop_mode_standing *m = k ? after : before;
            char gain[CELL], phase[CELL];
            fprintf(out, "    %8.2f %6.3g Hz %6s %7s", m->damping, m->bandwidth_hz, cell(gain, "%.1f dB", m->gain_db.value),
                    cell(phase, "%.0f deg", m->phase_deg.value));
        }
        fprintf(out, "\n");
    }
}

static void print_least(FILE *out, const char *name, const char *format, const struct loop_least *before, const struct loop_least *after,
                        double per_si, const char *wanted) {
    char was[CELL], is[CELL], pose[LOOP_POSE_SIZE];
    loop_pose_text(after->pose, pose);
    fprintf(out, "  %-28s %8s -> %-8s %-14s", name, cell(was, format, before->value * per_si), cell(is, format, after->value * per_si),
            wanted);
    if (isfinite(after->value)) fprintf(out, " least in %s at %s, %.3g Hz", dof_names[after->dof], pose, after->hz);
    fprintf(out, "\n");
}

static void print_pair(FILE *out, const char *name, double before, double after, double most, const char *unit) {
    fprintf(out, "  %-28s %8.3g -> %-8.3g at most %.3g %s\n", name, before, after, most, unit);
}

void tune_report_print(FILE *out, const struct loop_tune *t, const struct params *p) {
    const struct loop_standing *b = &t->before, *a = &t->after;
    fprintf(out, "  a leg at full opening        %8.3g m/s out, %.3g m/s in\n", t->out_mps, t->in_mps);
    print_modes(out, t);
    print_least(out, "gain margin, dB", "%.1f", &b->gain_db, &a->gain_db, 1.0, "wanted 6");
    print_least(out, "phase margin, degrees", "%.0f", &b->phase_deg, &a->phase_deg, 1.0, "wanted 45");
    print_least(out, "delay until it shakes, ms", "%.1f", &b->delay_s, &a->delay_s, MS_PER_S, "");
    print_least(out, "damping of the slowest mode", "%.2f", &b->damping, &a->damping, 1.0, "wanted 0.3");
    fprintf(out, "  %-28s %+8.1f -> %+-8.1f %-14s most in %s, %.3g Hz\n", "amplitude of the tests, %", 100.0 * b->amplitude.value,
            100.0 * a->amplitude.value, "", dof_names[a->amplitude.dof], a->amplitude.hz);
    print_pair(out, "shaking by noise, rms", b->noise_mps2, a->noise_mps2, b->noise_most_mps2, "m/s^2");
    print_pair(out, "off at the fastest motion", b->following_m * 1e3, a->following_m * 1e3, p->limits.following_m * 1e3, "mm");
    if (!b->stable) fprintf(out, "  with the configured gains the loop is unstable, and `hexid run` refuses it\n");
}

void tune_report_section(FILE *out, const struct loop_tune *t) {
    fprintf(out, "control:\n");
    for (int i = 0; i < GAINS; i++) {
        char now[NUMBER_SIZE], then[NUMBER_SIZE];
        number_shortest(gain_value(&t->gains, i), then), number_shortest(gain_value(&t->now, i), now);
        fprintf(out, "  %s: %-*s # %s%s%s\n", gains[i].name, 12 - (int)strlen(gains[i].name), then, gains[i].unit,
                strcmp(now, then) ? "; was " : "", strcmp(now, then) ? now : "");
    }
}

static bool differs(double now, double then) { return now > 0.0 && then > 0.0 ? fabs(log(then / now)) > log(WORTH) : now != then; }

void tune_report_remedy(const struct loop_tune *t, size_t size, char text[]) {
    size_t used = 0;
    *text = '\0';
    for (int i = 0; i < GAINS && used < size; i++) {
        char now[NUMBER_SIZE], then[NUMBER_SIZE];
        if (!differs(gain_value(&t->now, i), gain_value(&t->gains, i))) continue;
        used += (size_t)snprintf(text + used, size - used, "%scontrol.%s to %s (now %s)", used ? ", " : "set ", gains[i].name,
                                 number_shortest(gain_value(&t->gains, i), then), number_shortest(gain_value(&t->now, i), now));
    }
}

void tune_report_missed(const struct loop_tune *t, const struct params *p, char text[TUNE_MISS_SIZE]) {
    char pose[LOOP_POSE_SIZE];
    int used = 0;
    *text = '\0';
    if (t->reached) return;
    if (!(t->gains.kp > 0.0)) {
        snprintf(text, TUNE_MISS_SIZE,
                 "no gains keep 6 dB and 45 degrees in every pose: compare payload, actuator and hydraulics with the machine");
        return;
    }
    loop_pose_text(t->after.damping.pose, pose);
    double most_m = TUNE_FOLLOWING * p->limits.following_m;
    if (t->after.damping.value < TUNE_DAMPING)
        used = snprintf(text, TUNE_MISS_SIZE, "damping of the slowest mode, %s at %.3g Hz: %.2g of %.2g, at %s",
                        dof_names[t->after.damping.dof], t->after.damping.hz, t->after.damping.value, TUNE_DAMPING, pose);
    if (t->after.following_m > most_m)
        used += snprintf(text + used, TUNE_MISS_SIZE - (size_t)used,
                         "%skp %.2g is too small for the fastest motion: %.2g mm off, %.2g are borne", used ? "; " : "", t->gains.kp,
                         t->after.following_m * 1e3, most_m * 1e3);
    if (t->limit)
        snprintf(text + used, TUNE_MISS_SIZE - (size_t)used,
                 "; limited by %s: valves four times as fast would give %.2g, a quarter of the cycle and its delay %.2g, oil "
                 "twice as stiff %.2g",
                 words[t->limit], t->part_damping[LOOP_PART_VALVE], t->part_damping[LOOP_PART_CYCLE], t->part_damping[LOOP_PART_OIL]);
}

/* ---- for programs ---- */

static json_t *least_json(const struct loop_least *l) {
    return json_pack("{so so ss so}", "value", report_number(l->value), "frequency_hz", report_number(l->hz), "axis", dof_names[l->dof],
                     "pose", report_vector(l->pose, DOFS));
}

static json_t *gains_json(const struct control_params *g) {
    json_t *object = json_object();
    for (int i = 0; i < GAINS; i++) object = report_set(object, gains[i].name, report_number(gain_value(g, i)));
    return object;
}

static json_t *standing_json(const struct control_params *g, const struct loop_standing *s) {
    json_t *modes = json_array();
    for (int i = 0; i < DOFS; i++) {
        const struct loop_mode_standing *m = &s->mode[i];
        modes = report_append(modes, json_pack("{ss so so so so so so so}", "axis", dof_names[m->dof], "oil_hz", report_number(m->oil_hz),
                                               "oil_damping", report_number(m->oil_damping), "pole_hz", report_number(m->hz), "damping",
                                               report_number(m->damping), "bandwidth_hz", report_number(m->bandwidth_hz), "gain_margin_db",
                                               least_json(&m->gain_db), "phase_margin_deg", least_json(&m->phase_deg)));
    }
    return json_pack("{so sb so so so so so so so so so}", "control", gains_json(g), "stable", s->stable, "gain_margin_db",
                     least_json(&s->gain_db), "phase_margin_deg", least_json(&s->phase_deg), "delay_margin_s", least_json(&s->delay_s),
                     "slowest_damping", least_json(&s->damping), "noise_mps2", report_number(s->noise_mps2), "noise_most_mps2",
                     report_number(s->noise_most_mps2), "following_m", report_number(s->following_m), "test_amplitude",
                     least_json(&s->amplitude), "modes", modes);
}

static json_t *parts_json(const struct loop_tune *t) {
    json_t *object = json_object();
    for (int i = LOOP_PART_NONE + 1; i < LOOP_PARTS; i++)
        object = report_set(object, parts[i], t->part_damping[i] > 0.0 ? report_number(t->part_damping[i]) : json_null());
    return object;
}

json_t *tune_report_object(const struct loop_tune *t) {
    return json_pack("{sb sf sf ss so so so}", "reached", t->reached, "out_mps", t->out_mps, "in_mps", t->in_mps, "limit", parts[t->limit],
                     "damping_without", parts_json(t), "before", standing_json(&t->now, &t->before), "after",
                     standing_json(&t->gains, &t->after));
}

char *tune_report_json(const struct loop_tune *t, const char *version, const char *config, bool bus) {
    json_t *object = tune_report_object(t);
    object = report_set(object, "schema", json_string("hexid.tune/1"));
    object = report_set(object, "version", json_string(version));
    object = report_set(object, "config", config ? json_string(config) : json_null());
    return report_text(report_set(object, "bus", json_boolean(bus)));
}
