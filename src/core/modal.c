#include "modal.h"

#include <math.h>
#include <string.h>

#include "dynamics.h"
#include "lin.h"
#include "params.h"

int modal_init(struct modal *m, const struct params *params, const struct kinematics *k, struct error *error) {
    double inertia[LEGS][LEGS], one[LEGS][LEGS] = {{0}}, mass_kg[LEGS], motion[LEGS][LEGS];
    *m = (struct modal){.on = false};
    if (params->control.modal == 0.0) return STATUS_OK;
    for (int i = 0; i < LEGS; i++) one[i][i] = 1.0;
    if (!dynamics_inertia(params, k, inertia) || lin_eigenvectors(LEGS, inertia[0], one[0], mass_kg, motion[0]) || !(mass_kg[0] > 0.0))
        return error_set(error, STATUS_USAGE,
                         "control.modal %g: the legs do not determine the platform at neutral, or its inertia is not positive; compare "
                         "geometry, payload and the effects with the machine, or set control.modal to 0",
                         params->control.modal);
    for (int mode = 0; mode < LEGS; mode++) {
        double gain = pow(mass_kg[mode] / mass_kg[LEGS - 1], -0.5 * params->control.modal);
        for (int i = 0; i < LEGS; i++)
            for (int j = 0; j < LEGS; j++) m->weight[i][j] += gain * motion[mode][i] * motion[mode][j];
    }
    m->on = true;
    return STATUS_OK;
}

double modal_between(const struct modal *m, const double to[LEGS], const double from[LEGS]) {
    double sum = 0.0;
    for (int i = 0; i < LEGS; i++)
        for (int j = 0; j < LEGS; j++) sum += to[i] * (m->on ? m->weight[i][j] : i == j) * from[j];
    return sum;
}

double modal_gain(const struct modal *m, const double motion[LEGS]) {
    static const struct modal off = {.on = false};
    return modal_between(m, motion, motion) / modal_between(&off, motion, motion);
}

void modal_lengths(const struct modal *m, const double ref_m[LEGS], const double length_m[LEGS], double seen_m[LEGS]) {
    double error_m[LEGS];
    memcpy(seen_m, length_m, LEGS * sizeof *seen_m);
    if (!m->on) return;
    for (int i = 0; i < LEGS; i++) error_m[i] = ref_m[i] - length_m[i], seen_m[i] = ref_m[i];
    for (int i = 0; i < LEGS; i++)
        for (int j = 0; j < LEGS; j++) seen_m[i] -= m->weight[i][j] * error_m[j];
}
