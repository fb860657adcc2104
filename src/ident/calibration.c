#include "calibration.h"

#include <math.h>
#include <string.h>

#include "numeric.h"
#include "params.h"

static const double UNSEEN = 1e-12; /* a reading is ignored if the variance that the systematic
                                     * errors give it is less than this share of the variance of its
                                     * noise */

void calibration_find(const struct params *params, const struct kinematics *k, struct calibration row[CALIBRATIONS]) {
    const struct found_params *f = &params->found;
    memset(row, 0, CALIBRATIONS * sizeof *row);
    row[CALIBRATION_WEIGHT].value = f->weight_error, row[CALIBRATION_WEIGHT].std = f->weight_std;
    for (int leg = 0; leg < LEGS; leg++) {
        struct calibration *stop = &row[CALIBRATION_STOP + leg];
        row[CALIBRATION_WEIGHT].of[SYSTEMATIC_P1_GAIN + leg] = f->weight_p1[leg];
        row[CALIBRATION_WEIGHT].of[SYSTEMATIC_P2_GAIN + leg] = f->weight_p2[leg];
        stop->value = f->retracted_m[leg], stop->std = f->retracted_std_m;
        stop->of[SYSTEMATIC_LENGTH_ZERO + leg] = 1.0;
        stop->of[SYSTEMATIC_LENGTH_GAIN + leg] = kinematics_stroke(k, &params->actuator, leg).least_m - k->neutral_length_m[leg];
    }
}

struct common_gain calibration_common_gain(const struct params *params, const double systematic[SYSTEMATICS]) {
    struct common_gain gain = {.tolerance = params->model.tolerance.pressure_gain};
    double variance = 0.0;
    if (params->found.weight_std > 0.0) return gain;
    for (int i = SYSTEMATIC_P1_GAIN; i < SYSTEMATIC_LENGTH_GAIN; i++) {
        if (!(systematic[i] > 0.0)) continue;
        gain.sensors++;
        gain.pressures = gain.pressures || i >= SYSTEMATIC_P2_GAIN;
        variance += square(systematic[i]);
    }
    if (gain.sensors) gain.std = sqrt(variance) / gain.sensors;
    return gain;
}

/* Returns h' times `value` (calibration.h): the change of a measurement's reading if `value` holds
 * the errors of all unknowns. Only the systematic errors among them count. */
static double seen(const struct calibration *row, const double value[UNKNOWN_BASIS]) {
    double sum = 0.0;
    for (int s = 0; s < SYSTEMATICS; s++) sum += row->of[s] * value[UNKNOWN_SYSTEMATIC + s];
    return sum;
}

/* Subtracts K times `by` from a column. by: h' times the column; for the values x, h' x less the
 * reading. */
static void correct(const double gain[UNKNOWN_BASIS], double by, double column[UNKNOWN_BASIS]) {
    for (int c = 0; c < UNKNOWN_BASIS; c++) column[c] -= gain[c] * by;
}

/* Replaces the covariance N by (1 - K h') N (1 - K h')'. */
static void correct_noise(const struct calibration *row, const double gain[UNKNOWN_BASIS], double noise[UNKNOWN_BASIS][UNKNOWN_BASIS]) {
    double by[UNKNOWN_BASIS], twice = 0.0;
    for (int c = 0; c < UNKNOWN_BASIS; c++) by[c] = seen(row, noise[c]);
    twice = seen(row, by);
    for (int c = 0; c < UNKNOWN_BASIS; c++)
        for (int d = 0; d < UNKNOWN_BASIS; d++) noise[c][d] += gain[c] * twice * gain[d] - gain[c] * by[d] - by[c] * gain[d];
}

void calibration_learn(const struct calibration *row, int which, struct estimate *e) {
    double gain[UNKNOWN_BASIS], variance = square(row->std), missing = row->value - seen(row, e->value);
    for (int c = 0; c < UNKNOWN_BASIS; c++) gain[c] = seen(row, e->noise[c]);
    for (int j = 0; j < COMMON; j++) {
        double by = seen(row, e->common[j]);
        for (int c = 0; c < UNKNOWN_BASIS; c++) gain[c] += by * e->common[j][c];
    }
    double expected = seen(row, gain);
    if (!(expected > UNSEEN * variance)) return;
    e->surprise[which] = missing / sqrt(expected + variance);
    for (int c = 0; c < UNKNOWN_BASIS; c++) gain[c] /= expected + variance;
    correct(gain, -missing, e->value);
    for (int j = 0; j < COMMON; j++) correct(gain, seen(row, e->common[j]), e->common[j]);
    correct_noise(row, gain, e->noise);
    for (int c = 0; c < UNKNOWN_BASIS; c++) e->common[COMMON_CALIBRATION + which][c] = gain[c] * row->std;
}

void calibration_apply(const struct params *params, const struct kinematics *k, struct estimate *e) {
    struct calibration row[CALIBRATIONS];
    calibration_find(params, k, row);
    memset(e->surprise, 0, sizeof e->surprise);
    for (int i = 0; i < CALIBRATIONS; i++)
        if (row[i].std > 0.0) calibration_learn(&row[i], i, e);
}
