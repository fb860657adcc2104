/* Identification of the inertia matrix from six single-axis sinusoidal tests (Tian 2015; method.md section 4).
 *
 * Cycles go in one at a time, from the daemon or from a log: same code, same order, same bits. Memory is constant: each test is a
 * running least-squares fit, whose forward kinematics starts at the neutral pose with the test's first evaluated sample.
 * Ordinary threads; no heap. Units: SI, rows and columns in the order x y z phi theta psi. */
#ifndef HEXID_IDENT_H
#define HEXID_IDENT_H

#include "kinematics.h"
#include "force.h"
#include "harmonics.h"
#include "params.h"

struct test_result {
    int test;                    /* place in the list of tests */
    enum dof dof;
    double frequency_hz, amplitude;  /* commanded: m or rad */
    double achieved_amplitude;   /* of the tested axis */
    double phase_deg;            /* of the tested axis against sin(w t), test time */
    double unwanted_pct[DOFS];   /* amplitude of each axis against the commanded one, 4 mm against 0.006 rad; 0 for the tested axis */
    int64_t samples, excluded;   /* evaluated; kept out because flagged */
    double pose[DOFS][2];        /* fundamental [sin, cos]: A_d */
    double wrench[DOFS][2];      /* H_d */
    double pose_rms[DOFS], wrench_rms[DOFS]; /* residual */
    double pose_std[DOFS], wrench_std[DOFS]; /* of each fundamental coefficient */
    bool complete;               /* the whole evaluated part was seen */
};

struct method_result {
    bool evaluated;
    double mt[DOFS][DOFS], bt[DOFS][DOFS]; /* bt: method A only */
    double mt_std[DOFS][DOFS], bt_std[DOFS][DOFS];
    double condition_number;
};

enum verdict_status { VERDICT_PASS, VERDICT_FAIL, VERDICT_NOT_EVALUATED };

struct identification {
    int tests;                   /* results present */
    struct test_result test[DOFS];
    double nominal_mt[DOFS][DOFS];
    struct method_result method_a, modified_a, method_b;
};

struct ident {
    const struct params *params;
    struct kinematics kinematics;
    struct cylinder_areas areas;
    struct harmonics fit;        /* the running test: 12 channels, pose and wrench */
    double pose[DOFS];
    int running;                 /* test under way, -1: none */
    enum dof dof;
    int64_t excluded;
    struct identification result;
};

/* -2 with the key when params make no machine. */
int ident_init(struct ident *id, const struct params *params, struct error *error);

/* True when this cycle ended a test: its result is the last of id->result.test[0 .. tests-1]. */
bool ident_feed(struct ident *id, const struct cycle *cycle);

/* The log ended: closes a test under way (its result has complete = false). True as above. */
bool ident_end(struct ident *id);

/* With all six axes tested: methods A, modified A and B. False otherwise, and the methods' `evaluated` stays false. */
bool ident_solve(struct ident *id);

/* Nominal matrix at a pose by (A1)-(A6). */
void nominal_matrix(const struct params *params, const struct kinematics *k, const double pose[DOFS], double mt[DOFS][DOFS]);

#endif
