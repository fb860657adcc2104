#include "series.h"

#include <math.h>
#include <string.h>

#include "params.h"

void series_row(const struct residual_test *t, const double *series, double row[RESIDUAL_SIZE]) {
    memset(row, 0, RESIDUAL_SIZE * sizeof *row);
    for (int a = 0; a < t->size; a++)
        for (int b = 0; b < residual_motion_size(t); b++) row[a] += t->coupling[a][b] * series[b];
}

void series_push(const struct cylinder_model *m, const struct residual_test *t, const struct series *rows, int leg,
                 double force_n[SPECTRUM_SIZE]) {
    double a1 = m->leg[leg].a1_m2, a2 = m->leg[leg].a2_m2;
    for (int a = 0; a < 1 + 2 * t->spectrum.harmonics; a++)
        force_n[a] = t->pressures ? a1 * rows->p1[leg][a] - a2 * rows->p2[leg][a] : rows->force[leg][a];
    if (params_mechanism(m->machine.params)->force_sensor) force_n[0] -= m->machine.params->axis.force_offset_n;
}

/* Undoes one sensor's offset, scale, lag and delay. */
static void undo(const struct sensor_path *path, const struct residual_test *t, const double *reading, double *value) {
    memset(value, 0, SPECTRUM_SIZE * sizeof *value);
    value[0] = (reading[0] - path->offset) / path->scale;
    for (int h = 1; h <= t->spectrum.harmonics; h++) {
        double w = h * t->spectrum.omega, lag = w * path->lag_s, s1 = sin(w * path->delay_s), c1 = cos(w * path->delay_s);
        double s = (reading[2 * h - 1] - lag * reading[2 * h]) / path->scale, c = (reading[2 * h] + lag * reading[2 * h - 1]) / path->scale;
        value[2 * h - 1] = s * c1 - c * s1;
        value[2 * h] = s * s1 + c * c1;
    }
}

void series_undo(const struct machine *m, const struct residual_test *t, struct series *rows) {
    const struct spectrum *s = &t->spectrum;
    for (int k = 0; k < t->legs; k++) {
        undo(&m->sensors.length[k], t, s->mean[CHANNEL_LENGTH][k], rows->length[k]);
        undo(&m->sensors.p1[k], t, s->mean[CHANNEL_P1][k], rows->p1[k]);
        undo(&m->sensors.p2[k], t, s->mean[CHANNEL_P2][k], rows->p2[k]);
        undo(&m->sensors.force[k], t, s->mean[CHANNEL_FORCE][k], rows->force[k]);
        memset(rows->ahead[k], 0, sizeof rows->ahead[k]);
        rows->drift_mps[k] = s->drift[CHANNEL_LENGTH][k] / m->sensors.length[k].scale;
        rows->drift_pa_per_s[PORT_A][k] = s->drift[CHANNEL_P1][k] / m->sensors.p1[k].scale;
        rows->drift_pa_per_s[PORT_B][k] = s->drift[CHANNEL_P2][k] / m->sensors.p2[k].scale;
    }
}

void series_rate(const struct residual_test *t, const double *row, double *rate) {
    rate[0] = 0.0;
    for (int h = 1; h <= t->harmonics; h++) {
        rate[2 * h - 1] = -h * t->spectrum.omega * row[2 * h];
        rate[2 * h] = h * t->spectrum.omega * row[2 * h - 1];
    }
}
