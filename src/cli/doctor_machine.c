#include <math.h>
#include <string.h>

#include "areas.h"
#include "blind_time.h"
#include "cli.h"
#include "config.h"
#include "doctor.h"
#include "gains_check.h"
#include "hal.h"
#include "interlock.h"
#include "kinematics.h"
#include "loop_tune.h"
#include "model_law.h"
#include "motion_check.h"
#include "params.h"
#include "trajectory_file.h"
#include "reference.h"
#include "report_json.h"
#include "units.h"
#include "workspace.h"

static const double SINGULAR_NEAR = 0.25; /* a singular pose within this share of a path from
                                           * neutral to the ends of the strokes causes a warning */
static const double GYRATION_LEAST = 0.05, GYRATION_MOST = 3.0; /* smallest and largest plausible
                                                                 * radius of gyration, as multiples
                                                                 * of the upper joints' distance
                                                                 * from their centre */
static const double USELESS = 0.2; /* distance of a length limit beyond the stroke's end, as a share
                                    * of the stroke, from which on the limit counts as out of
                                    * reach */

struct finding check_configuration(const struct doctor *d) { return finding(LEVEL_OK, "", "%s", d->config ? d->config : "built in"); }

struct finding check_machine(const struct doctor *d) {
    if (!doctor_drives(d)) return finding(LEVEL_OK, "", "a single axis, which hexid does not drive: it reads what it did");
    if (d->machine) return finding(LEVEL_OK, "", "%s, a real machine: real time is required", d->url);
    return finding(LEVEL_OK, "", "%s, simulated; --hal can:can0 or --hal modbus:tcp://HOST:PORT looks at a real one", d->url);
}

struct finding check_kinematics(const struct doctor *d) {
    struct error error;
    struct kinematics k;
    if (!doctor_drives(d)) return finding_none();
    if (kinematics_init(&k, d->params, &error)) return finding(LEVEL_FAIL, "correct the key that is named", "%s", error.text);
    struct finding f = finding(LEVEL_OK, "", "neutral lengths");
    f.data = json_array();
    for (int i = 0; i < params_legs(d->params); i++) {
        size_t used = strlen(f.found);
        snprintf(f.found + used, sizeof f.found - used, " %.4f", k.neutral_length_m[i]);
        json_array_append_new(f.data, json_real(k.neutral_length_m[i]));
    }
    strcat(f.found, " m");
    f.data = json_pack("{so}", "neutral_length_m", f.data);
    return f;
}

/* Reports the nearest singular pose or, if there is none, the worst-conditioned pose. Singular
 * poses within the strokes are no mistake: most such machines have some, far from the poses in
 * use. */
struct finding check_workspace(const struct doctor *d) {
    struct error error;
    struct kinematics k;
    if (!doctor_drives(d) || kinematics_init(&k, d->params, &error)) return finding_none();
    struct workspace w = workspace_find(&k, d->params);
    bool all = w.reached == w.corners;
    const double *p = all ? w.worst_pose : w.nearest_pose;
    char singular[160] = "no singular pose within the strokes; worst";
    if (!all)
        snprintf(singular, sizeof singular,
                 "%d of %d corners of the strokes lie beyond a singular pose, the nearest after %.0f %% of the way,", w.corners - w.reached,
                 w.corners, 100.0 * w.nearest);
    static const char remedy[] = "compare the order of geometry.upper_joints_m and lower_joints_m, and the signs of their z, with the "
                                 "machine; if they are right, hold lengths and tests far from that pose";
    enum level level = all || w.nearest > SINGULAR_NEAR ? LEVEL_OK : LEVEL_WARN;
    struct finding f = finding(level, remedy, "condition %.3g at neutral, at worst %.3g; %s at %.3f %.3f %.3f m %.3f %.3f %.3f rad",
                               w.neutral_condition, w.worst_condition, singular, p[0], p[1], p[2], p[3], p[4], p[5]);
    f.data = json_pack("{sf sf si si}", "neutral_condition", w.neutral_condition, "worst_condition", w.worst_condition, "corners",
                       w.corners, "corners_reached", w.reached);
    return f;
}

struct finding check_strokes(const struct doctor *d) {
    struct error error;
    struct kinematics k;
    if (!doctor_drives(d) || kinematics_init(&k, d->params, &error)) return finding_none();
    const struct limit_params *l = &d->params->limits;
    for (int i = 0; i < LEGS; i++) {
        struct stroke stroke = kinematics_stroke(&k, &d->params->actuator, i);
        double beyond_m = USELESS * (stroke.most_m - stroke.least_m);
        if (l->length_max_m[i] - stroke.most_m < beyond_m && stroke.least_m - l->length_min_m[i] < beyond_m) continue;
        return finding(LEVEL_WARN,
                       "set limits.length_min_m and length_max_m a few millimetres beyond the ends of the strokes, or within them",
                       "leg %d goes from %.4f to %.4f m, limits.length_min_m and length_max_m are %g and %g: nothing reaches them", i + 1,
                       stroke.least_m, stroke.most_m, l->length_min_m[i], l->length_max_m[i]);
    }
    struct stroke first = kinematics_stroke(&k, &d->params->actuator, 0);
    return finding(LEVEL_OK, "", "leg 1 from %.4f to %.4f m, limits %g to %g", first.least_m, first.most_m, l->length_min_m[0],
                   l->length_max_m[0]);
}

/* Shows the pistons' areas for a visual check, because every force computed from pressures depends
 * on them. */
struct finding check_cylinders(const struct doctor *d) {
    char areas[AREAS_TEXT_SIZE], defaults[CONFIG_DEFAULTS_SIZE];
    const struct actuator_params *a = &d->params->actuator;
    if (!a->stated.piston && !a->stated.rod)
        return finding(LEVEL_OK, "", "no diameters, as of an electric axis: hexid gap takes no pressures");
    areas_text(d->params, areas);
    config_defaults(d->params, defaults);
    return finding(areas_stated(d->params) ? LEVEL_OK : LEVEL_WARN, "state both diameters, or none of an electric axis", "%s%s%s", areas,
                   defaults[0] ? "; as in the default configuration: " : "", defaults);
}

/* Checks the radius of gyration, which is implausible if tonnes were entered for kilograms, or a
 * mass without its inertia. */
struct finding check_payload(const struct doctor *d) {
    const struct payload_params *p = &d->params->payload;
    struct kinematics k;
    if (!doctor_drives(d)) return finding_none();
    kinematics_place(&k, d->params);
    double least = fmin(fmin(p->inertia_xx_kg_m2, p->inertia_yy_kg_m2), p->inertia_zz_kg_m2);
    double most = fmax(fmax(p->inertia_xx_kg_m2, p->inertia_yy_kg_m2), p->inertia_zz_kg_m2);
    double least_m = sqrt(least / p->mass_kg), most_m = sqrt(most / p->mass_kg);
    bool body = least_m > GYRATION_LEAST * k.arm_m && most_m < GYRATION_MOST * k.arm_m;
    return finding(
        body ? LEVEL_OK : LEVEL_WARN, "compare payload.mass_kg and inertia_xx_kg_m2 to inertia_zz_kg_m2 with the drawing: kg and kg m2",
        "%g kg, radii of gyration %.3g to %.3g m; the upper joints lie %.3g m from their middle", p->mass_kg, least_m, most_m, k.arm_m);
}

static int make_machine(const struct doctor *d, struct error *error) {
    struct hal *hal;
    struct params machine;
    if (d->machine) return STATUS_OK;
    int status = options_machine(d->url, d->params, &machine, error);
    if (!status) status = hal_open(&hal, d->url, &machine, 1, error);
    if (!status) hal->ops->close(hal);
    return status;
}

struct finding check_tests(const struct doctor *d) {
    static const char remedy[] = "`hexid run` refuses this motion: make it smaller or slower, or correct the limit that is named";
    struct params params = *d->params;
    struct trajectory trajectory = {0};
    struct error error;
    if (!doctor_drives(d)) return finding_none();
    int status = motion_check_tests(&params, &trajectory, &error);
    trajectory_free(&trajectory);
    if (status) return finding(LEVEL_FAIL, remedy, "%s", error.text);
    if (make_machine(d, &error)) return finding(LEVEL_FAIL, "`hexid run` refuses it: correct what is named", "%s", error.text);
    return finding(LEVEL_OK, "", "%d, within the limits of every leg, with every stop", tests_count(&params.tests));
}

struct finding check_blind_time(const struct doctor *d) {
    if (!doctor_drives(d)) return finding_none();
    struct blind_time blind = blind_time(d->params);
    struct finding f = finding(blind.allowed ? LEVEL_OK : LEVEL_FAIL, "make the keys of this sum smaller", "%.3f s of %g, with %s: %s",
                               blind.s, d->params->limits.blind_time_s, blind.when, blind.sum);
    f.data = json_pack("{sf sf}", "blind_time_s", blind.s, "limit_s", d->params->limits.blind_time_s);
    return f;
}

/* SAFETY: reports inputs that are not wired, because somebody must decide to run without them. */
struct finding check_interlocks(const struct doctor *d) {
    char wiring[200];
    if (!doctor_drives(d)) return finding_none();
    const struct interlock_params *p = &d->params->interlocks;
    bool all = interlock_describe(p, wiring, sizeof wiring), once = interlock_wired(p) && !p->antivalent;
    enum level level = d->machine && (!all || once) ? LEVEL_WARN : LEVEL_OK;
    if (!once) return finding(level, "wire it and set its key of `interlocks`, or answer for doing without", "%s", wiring);
    return finding(level, "give each input a second, inverse contact (docs/hardware.md) and set interlocks.antivalent: true",
                   "%s; one contact each: an input that is stuck closed is not seen", wiring);
}

/* Checks the margins of the loop in all poses, with a warning at most; check_loop() gives FAIL for
 * a loop that is unstable at neutral. */
struct finding check_gains(const struct doctor *d) {
    char found[GAINS_TEXT_SIZE];
    if (!doctor_drives(d)) return finding_none();
    struct gains_check c = doctor_gains(d);
    if (!c.known) return finding_none();
    gains_check_describe(&c, found);
    struct finding f = finding(c.missed ? LEVEL_WARN : LEVEL_OK,
                               *c.remedy ? c.remedy : "compare payload, actuator and hydraulics with the machine", "%s%s", found,
                               c.missed ? "; wanted are 6 dB and 45 degrees, as `hexid tune` gives" : "");
    f.data = json_pack("{so so sb}", "gain_margin_db", report_number(c.standing.gain_db.value), "phase_margin_deg",
                       report_number(c.standing.phase_deg.value), "stable", c.standing.stable);
    return f;
}

/* SAFETY: checks the stability of the loop. An unstable loop shakes the platform from the first
 * moment; `hexid run` refuses it. */
struct finding check_loop(const struct doctor *d) {
    char found[LOOP_TEXT_SIZE], remedy[LOOP_TEXT_SIZE];
    if (!doctor_drives(d)) return finding_none();
    struct loop_check c = doctor_loop(d);
    loop_check_describe(&c, found, remedy);
    bool refused = loop_check_refuses(&c, d->machine);
    enum level level = c.state == LOOP_DAMPED || c.state == LOOP_UNKNOWN ? LEVEL_OK : refused ? LEVEL_FAIL : LEVEL_WARN;
    struct finding f = finding(level, remedy, "%s", found);
    if (c.neutral.known)
        f.data = json_pack("{sf sf ss}", "damping", loop_pole_damping(&c.neutral.pole), "frequency_hz", loop_pole_hz(&c.neutral.pole),
                           "axis", dof_names[c.neutral.dof]);
    return f;
}

/* Returns true if control.delay_s of the law `model` lacks the cycle by which a command on a field
 * bus acts later. */
static bool looks_short(const struct doctor *d) {
    const struct params *p = d->params;
    return d->machine && p->control.law == CONTROL_MODEL && p->control.delay_s < 0.5 * p->loop.period_s;
}

/* Returns true, with the reason, if the machine's delay is longer than the law `model` can look
 * ahead; `hexid run` then refuses to start. */
static bool looks_too_far(const struct doctor *d, struct error *error) {
    struct kinematics k;
    struct model_law law;
    struct error unheard;
    return d->params->control.law == CONTROL_MODEL && !kinematics_init(&k, d->params, &unheard) &&
           model_law_init(&law, d->params, &k, error);
}

/* Appends a second weakness and its remedy to a finding, which becomes a warning. */
static void add_warning(struct finding *f, const char *remedy, const char *found) {
    size_t said = strlen(f->found), advised = strlen(f->remedy);
    snprintf(f->found + said, sizeof f->found - said, "%s%s", said ? "; " : "", found);
    snprintf(f->remedy + advised, sizeof f->remedy - advised, "%s%s", advised ? "; " : "", remedy);
    f->level = LEVEL_WARN;
}

/* Compares control.kff with the value that suits the valves. */
static struct finding judge_kff(const struct doctor *d) {
    const struct params *p = d->params;
    struct loop_check c = doctor_loop(d);
    if (c.state == LOOP_UNKNOWN) return finding_none();
    double kff = p->control.kff, off_m = loop_check_off_m(&c, p);
    bool ahead = kff > LOOP_FEED_FORWARD_MOST * c.kff_suits, faults = off_m > LOOP_FOLLOWING_SHARE * p->limits.following_m;
    char remedy[120];
    snprintf(remedy, sizeof remedy, "set control.kff to %.3g, 1 / (mean speed of a leg at full opening)", c.kff_suits);
    struct finding f = finding(ahead || faults ? LEVEL_WARN : LEVEL_OK, remedy,
                               "control.kff %.3g; a leg at full opening makes %.3g m/s out and %.3g m/s in: %.3g suits%s", kff, c.out_mps,
                               c.in_mps, c.kff_suits, ahead ? ", and with more the platform moves too far" : "");
    if (faults) {
        size_t used = strlen(f.found);
        snprintf(f.found + used, sizeof f.found - used, "; at the fastest motion a leg is %.2g mm off, limits.following_m is %.3g mm",
                 off_m * 1e3, p->limits.following_m * 1e3);
    }
    f.data = json_pack("{sf sf sf sf}", "kff_s_per_m", kff, "suits_s_per_m", c.kff_suits, "out_mps", c.out_mps, "in_mps", c.in_mps);
    return f;
}

/* Checks control.kff: if the feed-forward does not match the valve, a leg runs ahead of its
 * reference or lags behind it, in proportion to its speed, and kp has to compensate. The law
 * `model` has its own feed-forward and uses kff only while the PID replaces it; on a field bus it
 * also needs control.delay_s, and the whole delay must not be longer than the time that the law can
 * look ahead. */
struct finding check_feed_forward(const struct doctor *d) {
    if (!doctor_drives(d)) return finding_none();
    const struct params *p = d->params;
    struct error refused;
    char found[160], remedy[80];
    if (looks_too_far(d, &refused)) return finding(LEVEL_FAIL, "`hexid run` refuses it: correct what is named", "%s", refused.text);
    struct finding f = judge_kff(d);
    snprintf(remedy, sizeof remedy, "set control.delay_s to %g", p->loop.period_s);
    snprintf(found, sizeof found, "control.law model with control.delay_s %g: on a field bus a command acts %g s later", p->control.delay_s,
             p->loop.period_s);
    if (looks_short(d)) add_warning(&f, remedy, found);
    return f;
}

/* Shows how long the moves between parked and neutral take, which motion.rate_mps and accel_mps2
 * may lengthen. */
struct finding check_moves(const struct doctor *d) {
    if (!doctor_drives(d)) return finding_none();
    const struct motion_params *m = &d->params->motion;
    double engage_s = reference_park_s(m, m->engage_s), park_s = reference_park_s(m, m->park_s);
    bool longer = engage_s > m->engage_s || park_s > m->park_s;
    struct finding f = finding(longer ? LEVEL_WARN : LEVEL_OK,
                               "give motion.engage_s and park_s the time that they take, or raise motion.rate_mps and accel_mps2",
                               "%g m up in %.3g s, down in %.3g s, at most %g m/s and %g m/s^2%s", m->park_z_m, engage_s, park_s,
                               m->rate_mps, m->accel_mps2, longer ? ": longer than motion.engage_s or park_s asks for" : "");
    f.data = json_pack("{sf sf}", "engage_s", engage_s, "park_s", park_s);
    return f;
}
