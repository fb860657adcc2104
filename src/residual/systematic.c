#include "systematic.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "params.h"
#include "series.h"

/* Coordinates of a leg's two joints, which are the keys of geometry_error. */
enum { COORDINATES = JOINT_COORDINATES / LEGS };
/* Standard deviation by which a leg's lag or pipe differs from the value common to all legs, as a
 * share of the common value's standard deviation. */
static const double REST = 0.5;

/* struct sensor_errors has the layout of the error vector up to the joints, because
 * systematic_undo() copies one to the other. */
_Static_assert(sizeof(struct sensor_errors) == SYSTEMATIC_JOINT * sizeof(double), "the errors have one order");
_Static_assert(offsetof(struct sensor_errors, skew_s) == SYSTEMATIC_SKEW * sizeof(double), "the errors have one order");
_Static_assert(offsetof(struct sensor_errors, pipe_m) == SYSTEMATIC_PIPE * sizeof(double), "the errors have one order");

static const double NO_ERROR = 1e-12; /* a smaller tolerance counts as 0 */

extern const struct effect geometry_error;

const struct systematic_words systematic_families[FAMILIES] = {
    [FAMILY_PRESSURE_GAINS] = {"gains of the pressures", "pressure_gain", "%", 100.0},
    [FAMILY_LENGTH_GAINS] = {"gains of the lengths", "length_gain", "%", 100.0},
    [FAMILY_LENGTH_ZEROS] = {"zeros of the lengths", "length_zero_m", "mm", 1e3},
    [FAMILY_SKEW] = {"skew of the lengths", "skew_s", "ms", 1e3},
    [FAMILY_LAGS] = {"lags of the pressures", "pressure_lag_s", "ms", 1e3},
    [FAMILY_PIPES] = {"pipes", "pipe_m", "m", 1.0},
    [FAMILY_JOINTS] = {"joints", "joints_m", "mm", 1e3},
    [FAMILY_COMPLIANCE] = {"compliance of the legs", "compliance_m_per_n", "um/kN", 1e9},
};

enum systematic_family systematic_family(int error) {
    if (error >= SYSTEMATIC_COMPLIANCE) return FAMILY_COMPLIANCE;
    if (error >= SYSTEMATIC_JOINT) return FAMILY_JOINTS;
    if (error >= SYSTEMATIC_PIPE) return FAMILY_PIPES;
    if (error >= SYSTEMATIC_LAG) return FAMILY_LAGS;
    if (error >= SYSTEMATIC_SKEW) return FAMILY_SKEW;
    if (error >= SYSTEMATIC_LENGTH_ZERO) return FAMILY_LENGTH_ZEROS;
    return error >= SYSTEMATIC_LENGTH_GAIN ? FAMILY_LENGTH_GAINS : FAMILY_PRESSURE_GAINS;
}

void systematic_priors(const struct params *params, bool pressures, double std[SYSTEMATICS]) {
    const struct tolerance_params *t = &params->model.tolerance;
    const double of_family[FAMILIES] = {[FAMILY_PRESSURE_GAINS] = t->pressure_gain, [FAMILY_LENGTH_GAINS] = t->length_gain,
                                        [FAMILY_LENGTH_ZEROS] = t->length_zero_m,   [FAMILY_SKEW] = t->skew_s,
                                        [FAMILY_LAGS] = t->pressure_lag_s,          [FAMILY_PIPES] = pressures ? t->pipe_m : 0.0,
                                        [FAMILY_JOINTS] = t->joints_m / sqrt(3.0),  [FAMILY_COMPLIANCE] = t->compliance_m_per_n};
    for (int i = 0; i < SYSTEMATICS; i++) {
        enum systematic_family family = systematic_family(i);
        bool rest = (family == FAMILY_LAGS && i != SYSTEMATIC_LAG) || (family == FAMILY_PIPES && i != SYSTEMATIC_PIPE);
        bool exact = i < SYSTEMATIC_JOINT && !params->sensors.enabled;
        bool none = !pressures && i >= SYSTEMATIC_P2_GAIN && i < SYSTEMATIC_LENGTH_GAIN;
        std[i] = exact || none || of_family[family] < NO_ERROR ? 0.0 : of_family[family] * (rest ? REST : 1.0);
    }
}

double systematic_test_skew(const struct params *params) {
    const struct tolerance_params *t = &params->model.tolerance;
    return !params->sensors.enabled || t->skew_s < NO_ERROR || t->skew_test_s < NO_ERROR ? 0.0 : t->skew_test_s;
}

void systematic_exclude(struct tolerance_params *t) {
    t->pressure_gain = t->length_gain = t->length_zero_m = t->skew_s = t->skew_test_s = t->pressure_lag_s = t->pipe_m = t->joints_m =
        t->compliance_m_per_n = 0.0;
}

bool systematic_common(int error) {
    return error == SYSTEMATIC_SKEW || error == SYSTEMATIC_LAG || error == SYSTEMATIC_PIPE || error == SYSTEMATIC_COMPLIANCE;
}

bool systematic_moves(int error) {
    enum systematic_family family = systematic_family(error);
    return family != FAMILY_PRESSURE_GAINS && family != FAMILY_SKEW && family != FAMILY_LAGS && family != FAMILY_PIPES;
}

/* Kinds of errors of sensors, in the order of the errors. */
static const struct kind {
    int first;
    const char *name;
} kinds[] = {{SYSTEMATIC_P1_GAIN, "gain of P1"},
             {SYSTEMATIC_P2_GAIN, "gain of P2"},
             {SYSTEMATIC_LENGTH_GAIN, "gain of the length"},
             {SYSTEMATIC_LENGTH_ZERO, "zero of the length"},
             {SYSTEMATIC_SKEW, "skew of the lengths"},
             {SYSTEMATIC_LAG, "lag of the pressures"},
             {SYSTEMATIC_LAG_REST, "lag of the pressures beside the others'"},
             {SYSTEMATIC_PIPE, "length of the pipes"},
             {SYSTEMATIC_PIPE_REST, "length of the pipes beside the others'"},
             {SYSTEMATIC_COMPLIANCE, "compliance of the legs"}};

static const struct kind *kind_of(int error) {
    int i = 0;
    while (i + 1 < (int)(sizeof kinds / sizeof *kinds) && error >= kinds[i + 1].first) i++;
    return &kinds[i];
}

const char *systematic_kind(int error, int *first) {
    *first = kind_of(error)->first;
    return kind_of(error)->name;
}

void systematic_name(int error, char name[SYSTEMATIC_NAME]) {
    static const char *const joint[] = {"upper joint, x", "upper joint, y", "upper joint, z",
                                        "lower joint, x", "lower joint, y", "lower joint, z"};
    if (error >= SYSTEMATIC_JOINT && error < SYSTEMATIC_COMPLIANCE) {
        int of = error - SYSTEMATIC_JOINT;
        snprintf(name, SYSTEMATIC_NAME, "%s, leg %d", joint[of % COORDINATES], of / COORDINATES + 1);
        return;
    }
    const struct kind *kind = kind_of(error);
    if (systematic_common(error)) snprintf(name, SYSTEMATIC_NAME, "%s", kind->name);
    else snprintf(name, SYSTEMATIC_NAME, "%s, leg %d", kind->name, error - kind->first + 1);
}

void systematic_joints(const double error[SYSTEMATICS], struct params *machine) {
    struct effect_values *joints = &machine->effects[effect_find(geometry_error.name)];
    joints->on = true;
    for (int i = 0; i < JOINT_COORDINATES; i++) joints->value[i % COORDINATES][i / COORDINATES] = error[SYSTEMATIC_JOINT + i];
}

/* Finds the pressure in a chamber from the pressure at the other end of its pipe. With the flow q =
 * A v + C dP/dt into the chamber, the gauge reads P + R q + I dq/dt. flow: part A v of the flow, by
 * the piston's motion, as a series. */
static void through_pipe(const struct residual_test *t, double inertance, double resistance, double capacitance, const double *flow,
                         double *pressure) {
    for (int h = 1; h <= t->spectrum.harmonics; h++) {
        double w = h * t->spectrum.omega, *s = &pressure[2 * h - 1], *c = &pressure[2 * h];
        double qs = flow[2 * h - 1], qc = flow[2 * h];
        double left_s = *s - resistance * qs + w * inertance * qc, left_c = *c - resistance * qc - w * inertance * qs;
        double real = 1.0 - w * w * inertance * capacitance, imaginary = w * resistance * capacitance,
               square = real * real + imaginary * imaginary;
        *s = (real * left_s + imaginary * left_c) / square;
        *c = (real * left_c - imaginary * left_s) / square;
    }
}

/* Finds the capacitances, m^3/Pa, of a leg's chambers at this length. */
static void chambers(const struct cylinder_leg *c, double length_m, double capacitance[PORTS]) {
    double in_m = length_m - c->length_min_m, out_m = c->length_max_m - length_m;
    capacitance[PORT_A] = (c->dead_volume_m3[PORT_A] + c->a1_m2 * in_m) / c->bulk_modulus_pa;
    capacitance[PORT_B] = (c->dead_volume_m3[PORT_B] + c->a2_m2 * out_m) / c->bulk_modulus_pa;
}

double systematic_pipe_gain(const struct cylinder_model *m, int leg, int port, double length_m) {
    double inertance, resistance, capacitance[PORTS];
    cylinder_pipe(1.0, m->machine.params->hydraulics.pipe_bore_m, &inertance, &resistance);
    chambers(&m->leg[leg], length_m, capacitance);
    return inertance * capacitance[port];
}

double systematic_pipe_mass(const struct cylinder_model *m, int leg) {
    double inertance, resistance, a1 = m->leg[leg].a1_m2, a2 = m->leg[leg].a2_m2;
    cylinder_pipe(1.0, m->machine.params->hydraulics.pipe_bore_m, &inertance, &resistance);
    return inertance * (a1 * a1 + a2 * a2);
}

static void undo_pipes(const struct cylinder_model *m, int leg, double length_m, const struct residual_test *t, struct series *rows) {
    const struct cylinder_leg *c = &m->leg[leg];
    double flow[PORTS][SPECTRUM_SIZE] = {{0}}, inertance, resistance, capacitance[PORTS];
    cylinder_pipe(length_m, m->machine.params->hydraulics.pipe_bore_m, &inertance, &resistance);
    chambers(c, rows->length[leg][0], capacitance);
    for (int h = 1; h <= t->spectrum.harmonics; h++) {
        double w = h * t->spectrum.omega, s = -w * rows->length[leg][2 * h], cosine = w * rows->length[leg][2 * h - 1];
        flow[PORT_A][2 * h - 1] = c->a1_m2 * s, flow[PORT_A][2 * h] = c->a1_m2 * cosine;
        flow[PORT_B][2 * h - 1] = -c->a2_m2 * s, flow[PORT_B][2 * h] = -c->a2_m2 * cosine;
    }
    through_pipe(t, inertance, resistance, capacitance[PORT_A], flow[PORT_A], rows->p1[leg]);
    through_pipe(t, inertance, resistance, capacitance[PORT_B], flow[PORT_B], rows->p2[leg]);
}

void systematic_read_back(const struct cylinder_model *m, const struct residual_test *t, int leg, double one, double other, double *row) {
    const struct sensor_errors *e = &m->machine.params->errors;
    double length_m = e->pipe_m + e->pipe_rest_m[leg], inertance, resistance, capacitance[PORTS];
    if (length_m == 0.0) return;
    cylinder_pipe(length_m, m->machine.params->hydraulics.pipe_bore_m, &inertance, &resistance);
    chambers(&m->leg[leg], t->spectrum.mean[CHANNEL_LENGTH][leg][0], capacitance);
    for (int a = 0; a < t->size; a++) {
        double w = t->rate[a], share[PORTS];
        for (int port = 0; port < PORTS; port++)
            share[port] = hypot(1.0 - w * w * inertance * capacitance[port], w * resistance * capacitance[port]);
        row[a] *= hypot(one, other) / hypot(one / share[PORT_A], other / share[PORT_B]);
    }
}

/* Undoes the pipes of all legs. common_m: stated length of the pipes, to which the errors are
 * added. */
static void undo_all_pipes(const struct cylinder_model *m, double common_m, const struct sensor_errors *e, const struct residual_test *t,
                           struct series *rows) {
    for (int k = 0; k < t->legs && t->pressures; k++) {
        double length_m = common_m + e->pipe_m + e->pipe_rest_m[k];
        if (length_m != 0.0) undo_pipes(m, k, length_m, t, rows);
    }
}

/* Subtracts from the lengths the compliance between position sensors and joints times the hydraulic
 * force. */
static void undo_compliance(const struct cylinder_model *m, double compliance_m_per_n, const struct residual_test *t, struct series *rows) {
    for (int k = 0; k < t->legs && compliance_m_per_n != 0.0; k++) {
        double push_n[SPECTRUM_SIZE];
        series_push(m, t, rows, k, push_n);
        for (int a = 0; a < 1 + 2 * t->spectrum.harmonics; a++) rows->length[k][a] -= compliance_m_per_n * push_n[a];
    }
}

void systematic_undo(const struct cylinder_model *m, const double error[SYSTEMATICS], const struct residual_test *t, struct series *rows) {
    struct machine machine = m->machine;
    struct sensor_errors errors;
    memcpy(&errors, error, sizeof errors);
    errors.skew_s = 0.0;
    machine_add_errors(&machine, &errors);
    /* Only the difference between the delays of lengths and pressures matters, because the commands
     * are not used here. The pressures are moved, because dry friction is computed from the lengths
     * as they are read. */
    struct sensor_path *const later[] = {machine.sensors.p1, machine.sensors.p2, machine.sensors.force};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < LEGS; k++) later[i][k].delay_s -= error[SYSTEMATIC_SKEW];
    series_undo(&machine, t, rows);
    undo_all_pipes(m, m->machine.params->hydraulics.pipe_length_m, &errors, t, rows);
    undo_compliance(m, error[SYSTEMATIC_COMPLIANCE], t, rows);
}

void systematic_series(const struct cylinder_model *m, const struct residual_test *t, struct series *rows) {
    series_undo(&m->machine, t, rows);
    undo_all_pipes(m, 0.0, &m->machine.params->errors, t, rows);
}
