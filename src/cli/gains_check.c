#include "gains_check.h"

#include <stdio.h>

#include "params.h"
#include "tune_report.h"

void gains_check_describe(const struct gains_check *c, char text[GAINS_TEXT_SIZE]) {
    const struct loop_standing *s = &c->standing;
    char gain[LOOP_POSE_SIZE], phase[LOOP_POSE_SIZE];
    loop_pose_text(s->gain_db.pose, gain), loop_pose_text(s->phase_deg.pose, phase);
    if (!c->known) snprintf(text, GAINS_TEXT_SIZE, "not computed: the supply does not hold the platform up at neutral");
    else if (!s->stable)
        snprintf(text, GAINS_TEXT_SIZE, "no margins: the loop is unstable, at neutral or where its legs come near their ends");
    else
        snprintf(text, GAINS_TEXT_SIZE,
                 "gain margin %.1f dB (%s at %s), phase margin %.0f degrees (%s at %s); damping of the slowest oil mode %.2g",
                 s->gain_db.value, dof_names[s->gain_db.dof], gain, s->phase_deg.value, dof_names[s->phase_deg.dof], phase,
                 s->damping.value);
}

static void find_remedy(const struct params *params, bool bus, char text[GAINS_TEXT_SIZE]) {
    struct loop_tune t;
    struct error unheard;
    if (!loop_tune(params, bus, false, &t, &unheard) && t.gains.kp > 0.0) tune_report_remedy(&t, GAINS_TEXT_SIZE, text);
}

struct gains_check gains_check(const struct params *params, bool bus) {
    struct gains_check c = {0};
    struct error unheard;
    const struct loop_standing *s = &c.standing;
    if (loop_tune_stand(params, bus, &c.standing, &unheard)) return c;
    c.known = true;
    c.missed = !s->stable || s->gain_db.value < GAINS_SHARE * TUNE_GAIN_DB || s->phase_deg.value < GAINS_SHARE * TUNE_PHASE_DEG;
    if (c.missed) find_remedy(params, bus, c.remedy);
    return c;
}
