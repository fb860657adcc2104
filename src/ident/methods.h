/* Inertia and damping matrices from the fundamental coefficients of six tests (Tian 2015 Eqs. 5-12,
 * 16, B1-B3; docs/method.md section 4).
 *
 * x = a sin wt + b cos wt is kept as [a, b]; its derivative is w [-b, a] = w [a b] Q, Q = [0 1; -1
 * 0]. Poses are Euler angles, whose rates equal the body rates only near neutral; therefore tests
 * are about neutral. At 0.006 rad the two rates differ by 0.006 of the other angles' rates, and
 * these are unwanted motion, below a tenth of the tested angle's rate. The difference is a product
 * of an angle and a rate, and has a fundamental only if one of them has a mean or a higher
 * harmonic.
 *
 * Condition numbers are those of the motion matrix with each row divided by the ideal value of its
 * own test (w^2 amplitude, w amplitude): free of units, 1 if every test moves its axis by the
 * commanded amplitude and nothing else.
 *
 * Standard deviations are propagated to first order from those of the fundamental coefficients,
 * channels taken as independent. An entry depends only on the wrench of its own row and on the
 * pose, whose contribution is small. Pure, no heap. */
#ifndef HEXID_METHODS_H
#define HEXID_METHODS_H

#include "refusal.h"
#include "types.h"
#include "witness.h"

struct test_result {
    int test;                    /* number in the list of tests */
    enum dof dof;
    double asked_amplitude;      /* amplitude of the recorded reference on the tested axis; NaN: no
                                  * reference is recorded */
    double frequency_hz, amplitude; /* commanded frequency and amplitude, the latter in m or rad */
    double achieved_amplitude;   /* amplitude of the tested axis */
    double phase_deg;            /* phase of the tested axis against sin(w t), t the test time */
    /* Amplitude of each axis, per cent of the amplitude that its own test commands; 0 for the
     * tested axis. */
    double unwanted_pct[DOFS];
    int64_t samples, excluded;   /* numbers of samples used, and of samples excluded (refusal.h) */
    double step_s;               /* mean time from one sample to the next */
    double pose[DOFS][2];        /* coefficients [sin, cos] of each axis' fundamental: A_d */
    double wrench[DOFS][2];      /* coefficients [sin, cos] of the wrench's fundamental: H_d */
    double pose_rms[DOFS], wrench_rms[DOFS]; /* rms residuals of the fit */
    double pose_std[DOFS], wrench_std[DOFS]; /* standard deviations of the fundamental's
                                              * coefficients, if the residual is white */
    /* off_leg: leg (0..5) whose mean length is farthest from the mean of its lengths in the
     * reference poses. off_m: this difference, m, positive if the leg is too long; 0 without a
     * reference. */
    double off_m;
    int off_leg;
    struct testimony witness;    /* result of the consistency check of the readings */
    enum refusal refused;        /* why methods A, modified A and B do not use the test:
                                  * REFUSED_INCOMPLETE or REFUSED_UNDETERMINED; REFUSED_NOT: they
                                  * use it */
};

struct method_result {
    bool evaluated;
    /* mt: inertia matrix. bt: damping matrix, by method A only. */
    double mt[DOFS][DOFS], bt[DOFS][DOFS];
    double mt_std[DOFS][DOFS], bt_std[DOFS][DOFS];
    double condition_number;
};

/* For the methods below: test[d] is the test of axis d, and frequencies may differ between tests.
 * If the motions are singular, `evaluated` stays false and every entry is NaN. */

/* Method A: solves [Mt, Bt] U = H, 72 equations, with U_d = [-w^2 A_d; w A_d Q]. */
struct method_result method_a(const struct test_result *const test[DOFS]);

/* Modified method A: as method A, but the coupling entries (1,5), (5,1), (2,4) and (4,2) have the
 * magnitude m_qz = (|Mt(1,5)| + |Mt(4,2)|) / 2 and their nominal signs. */
struct method_result method_modified_a(const struct method_result *a, double nominal_mt[DOFS][DOFS]);

/* Method B (Koekebakker 2001): uses only the parts of wrench and acceleration that are in phase
 * with the tested axis, Mt = F_t Xddot_t^-1. */
struct method_result method_b(const struct test_result *const test[DOFS]);

#endif
