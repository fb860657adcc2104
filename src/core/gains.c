#include "gains.h"

const char *const gain_keys[LOOP_GAINS] = {
    [GAIN_KP] = "control.kp", [GAIN_KI] = "control.ki", [GAIN_KD] = "control.kd", [GAIN_KFF] = "control.kff", [GAIN_KPF] = "control.kpf"};
const double gain_most[LOOP_GAINS] = {[GAIN_KP] = 1e4, [GAIN_KI] = 1e5, [GAIN_KD] = 1e3, [GAIN_KFF] = 1e3, [GAIN_KPF] = 0.1};

struct gains gains_of(const struct control_params *c) {
    return (struct gains){.value = {[GAIN_KP] = c->kp, [GAIN_KI] = c->ki, [GAIN_KD] = c->kd, [GAIN_KFF] = c->kff, [GAIN_KPF] = c->kpf}};
}

void gains_apply(const struct gains *g, struct control_params *c) {
    c->kp = g->value[GAIN_KP], c->ki = g->value[GAIN_KI], c->kd = g->value[GAIN_KD];
    c->kff = g->value[GAIN_KFF], c->kpf = g->value[GAIN_KPF];
}

bool gains_equal(const struct gains *a, const struct gains *b) {
    bool equal = true;
    for (int i = 0; i < LOOP_GAINS; i++) equal = equal && a->value[i] == b->value[i];
    return equal;
}

/* Returns true if a single change may take a gain from `from` to `to`; `most` is the largest
 * permitted value. Returns false for NaN. */
static bool may(double from, double to, double most) {
    return from == to || (from > 0.0 && to >= from / GAINS_FACTOR && to <= from * GAINS_FACTOR && to <= most);
}

int gains_refused(const struct gains *from, const struct gains *to) {
    for (int i = 0; i < LOOP_GAINS; i++)
        if (!may(from->value[i], to->value[i], gain_most[i])) return i;
    return LOOP_GAINS;
}
