/* Systematic errors are corrected: readings that a machine with such errors makes of known
 * pressures and lengths, computed with phasors, become the known values again. */
#include "support.h"

#include <complex.h>

#include "series.h"
#include "systematic.h"

enum { HARMONICS = 4 };
#define IMAGINARY CMPLX(0.0, 1.0)
static const double OMEGA = 2.0 * PI * 4.0;

static double complex phasor(const double *row, int h) { return row[2 * h] - IMAGINARY * row[2 * h - 1]; }

static void set(double *row, int h, double complex value) { row[2 * h] = creal(value), row[2 * h - 1] = -cimag(value); }

struct world {
    struct params params;
    struct cylinder_model machine;
    struct residual_test test;
    double error[SYSTEMATICS], length[LEGS][SPECTRUM_SIZE], p[PORTS][LEGS][SPECTRUM_SIZE];
};

/* Draws the motion of the legs and the pressures in their chambers. */
static struct world *begin(uint64_t seed) {
    static struct world world;
    struct world *w = &world;
    memset(w, 0, sizeof *w);
    config_default(&w->params);
    cylinder_model_init(&w->machine, &w->params);
    w->test = (struct residual_test){.legs = LEGS, .pressures = true, .harmonics = HARMONICS};
    w->test.spectrum.harmonics = HARMONICS, w->test.spectrum.omega = OMEGA;
    for (int k = 0; k < LEGS; k++) {
        w->length[k][0] = w->machine.machine.bodies.neutral_length_m[k] + 0.05 * random_unit(&seed);
        w->p[PORT_A][k][0] = 5e6, w->p[PORT_B][k][0] = 6e6;
        for (int a = 1; a < 1 + 2 * HARMONICS; a++) {
            w->length[k][a] = 0.01 * random_unit(&seed);
            for (int port = 0; port < PORTS; port++) w->p[port][k][a] = 1e6 * random_unit(&seed);
        }
    }
    return w;
}

/* Makes the readings. Pressures are read earlier than the lengths of the same sample, by the
 * skew. */
static void read_all(struct world *w) {
    double neutral_m, inertance, resistance, piston[SPECTRUM_SIZE];
    for (int k = 0; k < LEGS; k++) {
        const struct cylinder_leg *c = &w->machine.leg[k];
        /* The piston is farther out than the joint by what the force compresses between them. */
        for (int a = 0; a < 1 + 2 * HARMONICS; a++) {
            double push_n = c->a1_m2 * w->p[PORT_A][k][a] - c->a2_m2 * w->p[PORT_B][k][a];
            piston[a] = w->length[k][a] + w->error[SYSTEMATIC_COMPLIANCE] * push_n;
        }
        double gain = w->error[SYSTEMATIC_LENGTH_GAIN + k], *length = w->test.spectrum.mean[CHANNEL_LENGTH][k];
        double lag_s = w->error[SYSTEMATIC_LAG] + w->error[SYSTEMATIC_LAG_REST + k];
        neutral_m = w->machine.machine.bodies.neutral_length_m[k];
        length[0] = piston[0] + w->error[SYSTEMATIC_LENGTH_ZERO + k] + gain * (piston[0] - neutral_m);
        for (int a = 1; a < 1 + 2 * HARMONICS; a++) length[a] = (1.0 + gain) * piston[a];
        cylinder_pipe(w->error[SYSTEMATIC_PIPE] + w->error[SYSTEMATIC_PIPE_REST + k], w->params.hydraulics.pipe_bore_m, &inertance,
                      &resistance);
        for (int port = 0; port < PORTS; port++) {
            double area = port ? -c->a2_m2 : c->a1_m2, stroke_m = port ? c->length_max_m - piston[0] : piston[0] - c->length_min_m;
            double volume = c->dead_volume_m3[port] + fabs(area) * stroke_m;
            double scale = 1.0 + w->error[(port ? SYSTEMATIC_P2_GAIN : SYSTEMATIC_P1_GAIN) + k];
            double *reading = w->test.spectrum.mean[port ? CHANNEL_P2 : CHANNEL_P1][k];
            reading[0] = scale * w->p[port][k][0];
            for (int h = 1; h <= HARMONICS; h++) {
                double complex s = IMAGINARY * (h * OMEGA), pressure = phasor(w->p[port][k], h);
                double complex flow = s * (area * phasor(piston, h) + volume / c->bulk_modulus_pa * pressure);
                double complex gauge = pressure + (resistance + s * inertance) * flow;
                set(reading, h, scale * gauge / (1.0 + s * lag_s) * cexp(s * w->error[SYSTEMATIC_SKEW]));
            }
        }
    }
}

static void expect(const double *found, const double *truth, double scale) {
    for (int a = 0; a < 1 + 2 * HARMONICS; a++) assert_close(found[a], truth[a], 1e-9 * scale);
}

static void readings_come_back_as_lengths_and_pressures(void **unused) {
    (void)unused;
    static struct series found;
    struct world *w = begin(3);
    double prior[SYSTEMATICS];
    uint64_t seed = 4;
    systematic_priors(&w->params, true, prior);
    for (int i = 0; i < SYSTEMATICS; i++) {
        assert_true(prior[i] > 0.0);
        w->error[i] = 3.0 * prior[i] * random_unit(&seed);
    }
    read_all(w);
    systematic_undo(&w->machine, w->error, &w->test, &found);
    for (int k = 0; k < LEGS; k++) {
        expect(found.length[k], w->length[k], 1.0);
        expect(found.p1[k], w->p[PORT_A][k], 1e7);
        expect(found.p2[k], w->p[PORT_B][k], 1e7);
    }
}

/* A metre of pipe increases the noise of a pressure, and the inertia of the oil; both are compared
 * with a difference quotient. */
static void a_pipe_weighs_and_amplifies(void **unused) {
    (void)unused;
    static struct series found;
    struct world *w = begin(5);
    read_all(w);
    double step_m = 1e-4;
    w->error[SYSTEMATIC_PIPE] = step_m;
    systematic_undo(&w->machine, w->error, &w->test, &found);
    for (int k = 0; k < LEGS; k++) {
        const struct cylinder_leg *c = &w->machine.leg[k];
        double complex s = IMAGINARY * OMEGA, acceleration = s * s * phasor(w->length[k], 1), change = 0.0;
        for (int port = 0; port < PORTS; port++) {
            double complex before = phasor(w->p[port][k], 1), after = phasor(port ? found.p2[k] : found.p1[k], 1);
            double area = port ? -c->a2_m2 : c->a1_m2, amplified = systematic_pipe_gain(&w->machine, k, port, w->length[k][0]);
            change += area * ((after - before) / step_m - OMEGA * OMEGA * amplified * before);
        }
        double inertance, resistance;
        cylinder_pipe(1.0, w->params.hydraulics.pipe_bore_m, &inertance, &resistance);
        /* The remainder is the inertia of the oil, in phase with the acceleration, and its
         * resistance. */
        double complex friction = resistance * s * (c->a1_m2 * c->a1_m2 + c->a2_m2 * c->a2_m2) * phasor(w->length[k], 1);
        for (int port = 0; port < PORTS; port++) {
            double area = port ? -c->a2_m2 : c->a1_m2;
            friction += area * resistance * s * systematic_pipe_gain(&w->machine, k, port, w->length[k][0]) / inertance *
                        phasor(w->p[port][k], 1);
        }
        assert_close(cabs(change + systematic_pipe_mass(&w->machine, k) * acceleration + friction), 0.0, 2e-3 * cabs(change));
    }
}

static void sensors_that_are_exact_have_no_errors(void **unused) {
    (void)unused;
    struct params params;
    double prior[SYSTEMATICS];
    config_default(&params);
    params.sensors.enabled = false;
    systematic_priors(&params, true, prior);
    for (int i = 0; i < SYSTEMATICS; i++) assert_true((prior[i] > 0.0) == (i >= SYSTEMATIC_JOINT));
    assert_true(systematic_test_skew(&params) == 0.0);
    params.sensors.enabled = true;
    assert_true(systematic_test_skew(&params) == params.model.tolerance.skew_test_s);
    systematic_priors(&params, false, prior);
    for (int i = SYSTEMATIC_P2_GAIN; i < SYSTEMATIC_LENGTH_GAIN; i++) assert_true(prior[i] == 0.0);
    assert_true(prior[SYSTEMATIC_PIPE] == 0.0 && prior[SYSTEMATIC_P1_GAIN] == 0.005);
    systematic_exclude(&params.model.tolerance);
    systematic_priors(&params, true, prior);
    for (int i = 0; i < SYSTEMATICS; i++) assert_true(prior[i] == 0.0);
    params.model.tolerance.skew_test_s = 1e-3;
    assert_true(systematic_test_skew(&params) == 0.0);
    params.model.tolerance.skew_s = 1e-3, params.model.tolerance.skew_test_s = 1e-13;
    assert_true(systematic_test_skew(&params) == 0.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(readings_come_back_as_lengths_and_pressures),
                                       cmocka_unit_test(a_pipe_weighs_and_amplifies),
                                       cmocka_unit_test(sensors_that_are_exact_have_no_errors)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
