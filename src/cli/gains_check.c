#include "gains_check.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "number_text.h"
#include "params.h"

static const double WORTH = 1.1; /* smallest ratio of two values of a gain that is worth a change */

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

static bool differs(double now, double then) { return now > 0.0 && then > 0.0 ? fabs(log(then / now)) > log(WORTH) : now != then; }

static void find_remedy(const struct params *params, bool bus, char text[GAINS_TEXT_SIZE]) {
    struct loop_tune t;
    struct error unheard;
    int used = 0;
    *text = '\0';
    if (loop_tune(params, bus, false, &t, &unheard) || !(t.gains.kp > 0.0)) return;
    const struct {
        const char *name;
        double now, then;
    } gains[] = {{"kpf", t.now.kpf, t.gains.kpf}, {"kp", t.now.kp, t.gains.kp}, {"ki", t.now.ki, t.gains.ki},
                 {"kff", t.now.kff, t.gains.kff}, {"kd", t.now.kd, t.gains.kd}, {"tp", t.now.tp, t.gains.tp}};
    for (size_t i = 0; i < sizeof gains / sizeof *gains; i++) {
        char now[NUMBER_SIZE], then[NUMBER_SIZE];
        if (!differs(gains[i].now, gains[i].then)) continue;
        used += snprintf(text + used, GAINS_TEXT_SIZE - (size_t)used, "%scontrol.%s to %s (now %s)", used ? ", " : "set ", gains[i].name,
                         number_shortest(gains[i].then, then), number_shortest(gains[i].now, now));
        if (used >= GAINS_TEXT_SIZE) return;
    }
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
