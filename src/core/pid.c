#include "pid.h"

#include "params/control.h"

static double clamp(double x, double limit) { return x > limit ? limit : x < -limit ? -limit : x; }

void pid_reset(struct pid *c, double length_m, double force_n) { *c = (struct pid){.force_lp_n = force_n, .ref_m = length_m}; }

double pid_step_forward(struct pid *c, const struct control_params *g, double dt_s, double ref_m, double length_m, double force_n,
                        double forward) {
    double e = ref_m - length_m;
    bool windup = c->saturated && e * c->output > 0.0;
    if (!windup) c->integral = clamp(c->integral + g->ki * e * dt_s, g->integral_limit);
    c->derivative_mps += dt_s / (g->tf + dt_s) * ((e - c->error_m) / dt_s - c->derivative_mps);
    c->force_lp_n += dt_s / (g->tp + dt_s) * (force_n - c->force_lp_n);
    double u = g->kp * e + c->integral + g->kd * c->derivative_mps + forward - (1.0 - c->feedback_cut) * g->kpf * (force_n - c->force_lp_n);
    c->error_m = e;
    c->ref_m = ref_m;
    c->output = clamp(u, g->output_limit);
    c->saturated = c->output != u;
    return c->output;
}

double pid_step(struct pid *c, const struct control_params *g, double dt_s, double ref_m, double length_m, double force_n) {
    return pid_step_forward(c, g, dt_s, ref_m, length_m, force_n, g->kff * (ref_m - c->ref_m) / dt_s);
}

bool pid_change(struct pid *c, const struct control_params *from, const struct control_params *to, double dt_s,
                const struct pid_reading *r) {
    double e = c->ref_m - r->length_m, passed = from->tp / (from->tp + dt_s);
    double rate = c->derivative_mps + dt_s / (from->tf + dt_s) * ((e - c->error_m) / dt_s - c->derivative_mps);
    double fed_back_n = (1.0 - c->feedback_cut) * (passed * (r->force_n - c->force_lp_n) - r->ref_force_n);
    double integral = c->integral + (from->kp - to->kp + (from->ki - to->ki) * dt_s) * e + (from->kd - to->kd) * rate -
                      (from->kpf - to->kpf) * fed_back_n;
    if (!(integral >= -to->integral_limit && integral <= to->integral_limit)) return false;
    c->integral = integral;
    return true;
}

void pid_hold(struct pid *c, double ref_m) { c->ref_m = ref_m; }
