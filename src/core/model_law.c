#include "model_law.h"

#include <math.h>
#include <string.h>

#include "params.h"

static const double RETURN_S = 0.5; /* time over which the law takes over from the PID */
static const double GOOD_S = 1.0;   /* time without doubts after which the law takes over again */
static const double FADE_S = 0.05;  /* time constant with which the jump of the feed-forward at a
                                     * hand-over decays. If the integral absorbed the jump instead,
                                     * it would persist after the motion has reversed */
static const double REVERSAL_CYCLES = 1.0; /* tau in cycles. The reference's dry friction then
                                            * reverses in about four cycles, which the valve can
                                            * follow */
static const double SLOW_MPS = 2e-4; /* v0. Below this speed a leg may stick, and the direction of
                                      * its friction does not follow from its reference */

/* Refuses a delay that is longer than the law can look ahead. */
static int check_delay(const struct model_law *law, struct error *error) {
    double period_s = law->params->loop.period_s;
    if (law->params->control.law != CONTROL_MODEL || law->delay_s <= MODEL_DELAY_CYCLES * period_s) return STATUS_OK;
    return error_set(
        error, STATUS_USAGE,
        "control.law model: %.1f ms from sample to spool (control.delay_s, the effects command_delay and valve_lag, and the spool's lag "
        "by hydraulics.valve_frequency_hz and valve_damping) are more than %d cycles of loop.period_s: correct them, or take "
        "control.law pid",
        1e3 * law->delay_s, MODEL_DELAY_CYCLES);
}

int model_law_init(struct model_law *law, const struct params *params, const struct kinematics *k, struct error *error) {
    struct cylinder_areas areas = cylinder_areas(&params->actuator);
    *law = (struct model_law){.params = params};
    dynamics_init(&law->dynamics, params, k);
    for (int leg = 0; leg < LEGS; leg++) {
        valve_flow_init(&law->valve[leg], leg, params, k);
        law->delay_s += law->valve[leg].delay_s / LEGS;
        law->area_m2[0][leg] = areas.a1_m2[leg], law->area_m2[1][leg] = areas.a2_m2[leg];
    }
    law->delay_s += params->control.delay_s;
    law->delay_cycles = (int)fmin(ceil(law->delay_s / params->loop.period_s - 1e-9), MODEL_DELAY_CYCLES);
    for (int i = 0; effect_table[i]; i++) {
        if (!params->effects[i].on || !effect_table[i]->leg_friction) continue;
        law->friction.of[law->friction.count].effect = effect_table[i];
        law->friction.of[law->friction.count++].values = &params->effects[i];
    }
    model_law_reset(law);
    return check_delay(law, error);
}

void model_law_reset(struct model_law *law) {
    law->share = law->good_s = 0.0;
    law->doubts = 0;
    memset(law->settled, 0, sizeof law->settled);
    memset(law->bump, 0, sizeof law->bump);
    memset(law->opening, 0, sizeof law->opening);
    memset(law->sent, 0, sizeof law->sent);
}

/* Returns the friction of a leg in this motion, N; positive values act against extension. */
static double friction_n(const struct model_law *law, int leg, const struct leg_course *c) {
    double rate = c->rate_mps[leg], speed = fabs(rate), tau_s = REVERSAL_CYCLES * law->params->loop.period_s;
    double sense = tanh(rate / (SLOW_MPS + tau_s * fabs(c->accel_mps2[leg])));
    struct leg_motion motion = {.direction = rate > 0.0 ? 1 : -1,
                                .speed_mps = speed,
                                .deflection = sense,
                                .p1_pa = law->p1_pa[leg],
                                .p2_pa = law->p2_pa[leg],
                                .a1_m2 = law->area_m2[0][leg],
                                .a2_m2 = law->area_m2[1][leg]};
    struct friction sum = {.viscous = law->params->hydraulics.viscous_n_s_per_m[leg] * speed};
    for (int i = 0; i < law->friction.count; i++) law->friction.of[i].effect->leg_friction(law->friction.of[i].values, leg, &motion, &sum);
    return copysign(fmax(sum.viscous, 0.0), rate) + sum.dry * sense + sum.elastic;
}

/* Computes the legs' motion and forces, friction included, at ahead_s from now. Returns false if a
 * pose is singular or a force is not finite. */
static bool course_at(const struct model_law *law, const struct reference *r, double ahead_s, struct leg_course *c) {
    double motion[MOTION_ORDERS][DOFS];
    reference_motion(r, &law->params->tests, law->params->loop.period_s, ahead_s, motion);
    if (!dynamics_solve(&law->dynamics, motion, c)) return false;
    double sum = 0.0;
    for (int leg = 0; leg < LEGS; leg++) sum += c->force_n[leg] += friction_n(law, leg, c);
    return isfinite(sum);
}

/* Advances a low-pass with the time constant of the PID's force filter. If not `settled`, the
 * low-pass starts at x. */
static void low_pass(const struct model_law *law, bool settled, double x, double *low) {
    double tp_s = law->params->control.tp, dt_s = law->params->loop.period_s;
    *low = settled ? *low + dt_s / (tp_s + dt_s) * (x - *low) : x;
}

/* Stores the pressures that are valid readings, and advances the low-passes of the forces. Returns
 * DOUBT_PRESSURE if a pressure is no valid reading. */
static uint32_t take_pressures(struct model_law *law, const struct model_law_input *in, const struct leg_course *now) {
    uint32_t doubts = 0;
    for (int leg = 0; leg < LEGS; leg++) {
        double p1_pa = in->p1_pa[leg], p2_pa = in->p2_pa[leg], ref_n = now->force_n[leg];
        bool bad = in->suspect & fault_leg(leg) || !isfinite(p1_pa) || !isfinite(p2_pa);
        if (bad) doubts = DOUBT_PRESSURE;
        if (bad && !law->settled[leg]) continue;
        low_pass(law, law->settled[leg], ref_n, &law->force_ref_lp_n[leg]);
        law->varying_ref_n[leg] = ref_n - law->force_ref_lp_n[leg];
        if (bad) continue;
        law->p1_pa[leg] = p1_pa, law->p2_pa[leg] = p2_pa;
        low_pass(law, law->settled[leg], law->area_m2[0][leg] * p1_pa - law->area_m2[1][leg] * p2_pa - ref_n, &law->excess_lp_n[leg]);
        law->settled[leg] = true;
    }
    return doubts;
}

/* Returns the opening that was sent to a leg this number of cycles ago, at least 1. */
static double sent(const struct model_law *law, int leg, int cycles) {
    return law->sent[leg][(law->newest + MODEL_DELAY_CYCLES - cycles + 1) % MODEL_DELAY_CYCLES];
}

/* Predicts the pressures of a leg for the middle of the time in which this cycle's command acts.
 * The present pressures are advanced with the reference's motion and the openings of earlier
 * commands; the command of k cycles ago acts until delay - (k - 1) dt from now. This cycle's
 * command is not known yet, so the last one takes its place. */
static struct oil_state predict(const struct model_law *law, int leg, const struct leg_course *now, const struct leg_course *from) {
    double dt_s = law->params->loop.period_s, passed_s = 0.0;
    struct oil_state oil = {.p1_pa = law->p1_pa[leg],
                            .p2_pa = law->p2_pa[leg],
                            .length_m = 0.5 * (now->length_m[leg] + from->length_m[leg]),
                            .rate_mps = 0.5 * (now->rate_mps[leg] + from->rate_mps[leg])};
    for (int k = law->delay_cycles; k >= 0; k--) {
        double until_s = k ? law->delay_s - (k - 1) * dt_s : law->delay_s + 0.5 * dt_s;
        valve_flow_advance(&law->valve[leg], &oil, sent(law, leg, k ? k : 1), until_s - passed_s);
        passed_s = until_s;
    }
    return oil;
}

/* Computes the opening of a leg from the motions `from` and `to` at the beginning and at the end of
 * the time in which the command acts. Returns 0 or DOUBT_... */
static uint32_t open_valve(struct model_law *law, int leg, const struct leg_course *now, const struct leg_course *from,
                           const struct leg_course *to) {
    double dt_s = law->params->loop.period_s;
    struct oil_state oil = predict(law, leg, now, from);
    valve_flow_load(&law->valve[leg], &oil, 0.5 * (from->force_n[leg] + to->force_n[leg]) + law->excess_lp_n[leg]);
    oil.length_m = 0.5 * (from->length_m[leg] + to->length_m[leg]);
    oil.rate_mps = (to->length_m[leg] - from->length_m[leg]) / dt_s;
    double opening = valve_flow_opening(&law->valve[leg], &oil, (to->force_n[leg] - from->force_n[leg]) / dt_s);
    if (!isfinite(opening)) return DOUBT_SINGULAR;
    if (!(fabs(valve_flow_command(&law->valve[leg], opening)) <= law->params->control.output_limit)) return DOUBT_SUPPLY;
    law->opening[leg] = opening;
    return 0;
}

static uint32_t feed_forward(struct model_law *law, const struct model_law_input *in) {
    struct leg_course now, from, to;
    double dt_s = law->params->loop.period_s;
    const struct reference *r = in->reference;
    if (!course_at(law, r, 0.0, &now) || !course_at(law, r, law->delay_s, &from) || !course_at(law, r, law->delay_s + dt_s, &to))
        return DOUBT_SINGULAR;
    uint32_t doubts = take_pressures(law, in, &now);
    for (int leg = 0; leg < LEGS; leg++) doubts |= open_valve(law, leg, &now, &from, &to);
    return doubts;
}

void model_law_step(struct model_law *law, const struct model_law_input *in) {
    double dt_s = law->params->loop.period_s;
    uint32_t doubts = feed_forward(law, in);
    law->newest = (law->newest + 1) % MODEL_DELAY_CYCLES;
    law->handed_over = doubts ? law->share : 0.0;
    law->good_s = doubts ? 0.0 : law->good_s + dt_s;
    law->doubts |= doubts;
    if (doubts) law->share = 0.0;
    else if (law->good_s >= GOOD_S || !law->doubts) law->share = fmin(law->share + dt_s / RETURN_S, 1.0);
    if (law->share >= 1.0) law->doubts = 0;
}

void model_law_hold(struct model_law *law) {
    int before = law->newest;
    law->newest = (before + 1) % MODEL_DELAY_CYCLES;
    for (int leg = 0; leg < LEGS; leg++) law->sent[leg][law->newest] = law->sent[leg][before];
}

double model_law_command(struct model_law *law, const struct control_params *g, int leg, struct pid *pid, double ref_m, double length_m,
                         double force_n) {
    double dt_s = law->params->loop.period_s, pid_forward = g->kff * (ref_m - pid->ref_m) / dt_s;
    double model_forward = law->opening[leg] + (1.0 - pid->feedback_cut) * g->kpf * law->varying_ref_n[leg];
    law->bump[leg] = law->handed_over * (model_forward - pid_forward) + FADE_S / (FADE_S + dt_s) * law->bump[leg];
    double forward = pid_forward + law->share * (model_forward - pid_forward) + law->bump[leg];
    double u = pid_step_forward(pid, g, dt_s, ref_m, length_m, force_n, forward), command = valve_flow_command(&law->valve[leg], u);
    law->sent[leg][law->newest] = u;
    pid->saturated = pid->saturated || fabs(command) > g->output_limit;
    /* SAFETY: a command of NaN passes these limits, and the back-end then centres the valve. */
    return command > g->output_limit ? g->output_limit : command < -g->output_limit ? -g->output_limit : command;
}

const char *model_law_doubt(uint32_t doubts) {
    return doubts & DOUBT_PRESSURE   ? "a pressure is no valid reading"
           : doubts & DOUBT_SUPPLY   ? "a valve would have to open wider than it can"
           : doubts & DOUBT_SINGULAR ? "the legs do not determine the platform there, or a number is not finite"
                                     : "none";
}
