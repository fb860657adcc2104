#include <string.h>

#include "blind_time.h"
#include "doctor.h"
#include "hal.h"
#include "interlock.h"
#include "kinematics.h"
#include "motion_check.h"
#include "trajectory_file.h"
#include "workspace.h"

/* Of one axis it is read what it did: nothing is driven. */
static bool drives(const struct doctor *d) { return d->params->mechanism == MECHANISM_STEWART; }

struct finding check_configuration(const struct doctor *d) { return finding(LEVEL_OK, "", "%s", d->config ? d->config : "built in"); }

struct finding check_machine(const struct doctor *d) {
    if (!drives(d)) return finding(LEVEL_OK, "", "a single axis, which hexid does not drive: it reads what it did");
    if (d->machine) return finding(LEVEL_OK, "", "%s, a real machine: real time is required", d->url);
    return finding(LEVEL_OK, "", "%s, simulated; --hal can:can0 or --hal modbus:tcp://HOST:PORT looks at a real one", d->url);
}

struct finding check_kinematics(const struct doctor *d) {
    struct error error;
    struct kinematics k;
    if (!drives(d)) return finding_none();
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

/* A singular pose within the strokes is no mistake: most such machines have some, far from where
 * they are driven. */
struct finding check_workspace(const struct doctor *d) {
    struct error error;
    struct kinematics k;
    if (!drives(d) || kinematics_init(&k, d->params, &error)) return finding_none();
    struct workspace w = workspace_find(&k, d->params);
    bool all = w.reached == w.corners;
    const double *p = all ? w.worst_pose : w.nearest_pose;
    char singular[160] = "no singular pose within the strokes; worst";
    if (!all)
        snprintf(singular, sizeof singular,
                 "%d of %d corners of the strokes lie beyond a singular pose, the nearest after %.0f %% of the way,", w.corners - w.reached,
                 w.corners, 100.0 * w.nearest);
    struct finding f = finding(LEVEL_OK, "", "condition %.3g at neutral, at worst %.3g; %s at %.3f %.3f %.3f m %.3f %.3f %.3f rad",
                               w.neutral_condition, w.worst_condition, singular, p[0], p[1], p[2], p[3], p[4], p[5]);
    f.data = json_pack("{sf sf si si}", "neutral_condition", w.neutral_condition, "worst_condition", w.worst_condition, "corners",
                       w.corners, "corners_reached", w.reached);
    return f;
}

/* The simulated machine is made, and put down, as for a run. */
static int make_machine(const struct doctor *d, struct error *error) {
    struct hal *hal;
    if (d->machine) return STATUS_OK;
    int status = hal_open(&hal, d->url, d->params, 1, error);
    if (!status) hal->ops->close(hal);
    return status;
}

struct finding check_tests(const struct doctor *d) {
    static const char remedy[] = "`hexid run` refuses this motion: make it smaller or slower, or correct the limit that is named";
    struct params params = *d->params;
    struct trajectory trajectory = {0};
    struct error error;
    if (!drives(d)) return finding_none();
    int status = motion_check_tests(&params, &trajectory, &error);
    trajectory_free(&trajectory);
    if (status) return finding(LEVEL_FAIL, remedy, "%s", error.text);
    if (make_machine(d, &error)) return finding(LEVEL_FAIL, "`hexid run` refuses it: correct what is named", "%s", error.text);
    return finding(LEVEL_OK, "", "%d, within the limits of every leg, with every stop", tests_count(&params.tests));
}

struct finding check_blind_time(const struct doctor *d) {
    if (!drives(d)) return finding_none();
    struct blind_time blind = blind_time(d->params);
    struct finding f = finding(blind.allowed ? LEVEL_OK : LEVEL_FAIL, "make the keys of this sum smaller", "%.3f s of %g, with %s: %s",
                               blind.s, d->params->limits.blind_time_s, blind.when, blind.sum);
    f.data = json_pack("{sf sf}", "blind_time_s", blind.s, "limit_s", d->params->limits.blind_time_s);
    return f;
}

/* SAFETY: on a machine that can hurt somebody an input that is not wired is somebody's
 * decision, and is said. */
struct finding check_interlocks(const struct doctor *d) {
    char wiring[200];
    if (!drives(d)) return finding_none();
    bool all = interlock_describe(&d->params->interlocks, wiring, sizeof wiring);
    return finding(all || !d->machine ? LEVEL_OK : LEVEL_WARN, "wire it and set its key of `interlocks`, or answer for doing without", "%s",
                   wiring);
}
