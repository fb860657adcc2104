/* Identification of the inertia matrix from six single-axis sinusoidal tests (Tian 2015;
 * docs/method.md section 4).
 *
 * Cycles go in one at a time, from the daemon or from a log: same code, same order, same bits.
 * Memory is constant: each test is a running least-squares fit, whose forward kinematics starts
 * at the neutral pose with the test's first evaluated sample, so a log that lacks what came
 * before gives the same bits too. Only cycles of the phase `evaluate` are used; flagged ones are
 * counted and left out. Ordinary threads; no heap. Units: SI, rows and columns in the order x y
 * z phi theta psi. */
#ifndef HEXID_IDENT_H
#define HEXID_IDENT_H

#include "agreement.h"
#include "force.h"
#include "harmonics.h"
#include "kinematics.h"
#include "method_c.h"
#include "methods.h"
#include "nominal.h"
#include "params.h"

struct identification {
    int tests;                    /* results present */
    struct test_result test[DOFS];/* one an axis, in the order in which they ended: a test of an
                                   * axis replaces that axis' earlier one */
    double nominal_mt[DOFS][DOFS];/* at neutral */
    struct method_result method_a, modified_a, method_b;
    struct method_c method_c;     /* of a whole recording, by those who have one (method_c.h) */
    struct error no_method_c;     /* why it is not evaluated */
    int parts, parts_left_out;    /* parts of a long motion, and those without a result; 0: it was
                                   * in one piece */
    struct agreement over_time;   /* agreement of the parts; of many, neighbours are joined: `logs`
                                   * of them */
};

struct ident {
    const struct params *params;
    struct kinematics kinematics;
    struct cylinder_areas areas;
    struct harmonics fit;         /* the running test: 12 channels, pose and wrench */
    struct witness witness;       /* do the same readings look sound? */
    double pose[DOFS];            /* forward kinematics starts here */
    int running;                  /* test under way, -1: none */
    enum dof dof;
    int64_t seen, excluded;       /* cycles of the test's evaluated part */
    double first_s, last_s;       /* their span of test time */
    struct identification result;
};

/* -2 with the key when params make no machine. */
int ident_init(struct ident *id, const struct params *params, struct error *error);

/* True when this cycle ended a test: its result is the last of id->result.test[0 .. tests-1]. */
bool ident_feed(struct ident *id, const struct cycle *cycle);

/* The stream ended: closes a test under way (`complete` is false unless its evaluated part was
 * over). True as above. */
bool ident_end(struct ident *id);

/* With complete tests of all six axes: methods A, modified A and B. False otherwise, and the
 * methods' `evaluated` is false. */
bool ident_solve(struct ident *id);

/* The entries that people look at: Tian 2015 Tables 3 to 5. */
enum { IDENT_ENTRIES = 10 };
struct ident_entry {
    const char *name;
    int row, col;
    const char *unit;
};
extern const struct ident_entry ident_entries[IDENT_ENTRIES];

/* Error of an entry against the nominal one, in per cent; negative is too small in magnitude. It
 * says nothing where the nominal entry is near zero. */
double ident_error_pct(const struct identification *id, const struct method_result *method, const struct ident_entry *entry);

/* Scale of an entry's differences: sqrt(Mii Mjj) of this matrix, on the diagonal the entry
 * itself. */
double ident_scale(const double mt[DOFS][DOFS], const struct ident_entry *entry);

#endif
