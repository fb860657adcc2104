/* Identification of the inertia matrix from six single-axis sinusoidal tests (Tian 2015;
 * docs/method.md section 4).
 *
 * Cycles go in one at a time, in the same order from the daemon and from a log, so that both give
 * bit-identical results. Memory is constant: each test is a running least-squares fit. Its forward
 * kinematics starts at the neutral pose with the first evaluated sample, so a log that lacks
 * earlier cycles gives the same result. Only cycles of the phase `evaluate` are used; of these,
 * cycles for which refusal.h has a reason are counted and excluded. Ordinary threads; no heap. SI
 * units, rows and columns in the order x y z phi theta psi. */
#ifndef HEXID_IDENT_H
#define HEXID_IDENT_H

#include "agreement.h"
#include "calibration.h"
#include "force.h"
#include "harmonics.h"
#include "kinematics.h"
#include "method_c.h"
#include "methods.h"
#include "nominal.h"
#include "rest.h"
#include "weighing.h"

struct identification {
    int tests;                    /* number of results in `test` */
    /* At most one test for each axis, in the order in which they ended; a new test of an axis
     * replaces the old one. */
    struct test_result test[DOFS];
    int replaced[DOFS];           /* for each axis, number of tests that were replaced so far */
    double nominal_mt[DOFS][DOFS];/* configured inertia matrix at neutral */
    struct method_result method_a, modified_a, method_b;
    struct method_c method_c;     /* filled by callers that have a whole recording (method_c.h) */
    struct common_gain common_gain; /* gain error that all of method C's sensors share
                                     * (calibration.h) */
    struct error no_method_c;     /* why method C was not evaluated */
    bool refuted;                 /* the recording contradicts the configured machine, for the
                                   * reason in no_method_c: no method has a result */
    struct rest_found rest;       /* readings at rest before the supply came on */
    struct weighing_found weighed;/* reading of a known weight, from two logs */
    /* Number of parts of a long motion, and number of parts without a result; both 0 if the motion
     * was evaluated as a whole. */
    int parts, parts_left_out;
    /* Agreement of the parts over time. If there are many parts, neighbours are joined into groups;
     * over_time.logs is the number of groups. */
    struct agreement over_time;
};

struct ident {
    const struct params *params;
    struct kinematics kinematics;
    struct cylinder_areas areas;
    struct harmonics fit;         /* least squares of the running test: 12 channels, pose and
                                   * wrench */
    struct witness witness;       /* check that the running test's readings are consistent */
    double pose[DOFS];            /* last pose, from which the next forward kinematics starts */
    int running;                  /* number of the test under way; -1: no test is under way */
    enum dof dof;
    int64_t seen, excluded;       /* number of cycles in the running test's evaluated part, and
                                   * number of excluded cycles among them */
    double low, high;             /* smallest and largest reference of the tested axis in the
                                   * running test's evaluated part */
    double off_m[LEGS];           /* sum over good samples of the difference of each leg's length
                                   * from its length in the reference pose */
    int64_t off_samples;
    enum refusal refused;         /* why the last cycle, if evaluated, was excluded */
    double first_s, last_s;       /* test time of the running test's first and last evaluated
                                   * cycle */
    struct identification result;
};

/* Starts an identification; params must outlive it. Returns -2, with a message, if the mechanism
 * refuses identification or the configured machine is impossible. */
int ident_init(struct ident *id, const struct params *params, struct error *error);

/* Takes one cycle. Returns true if the cycle ended a test, whose result is then the last of
 * id->result.test[0 .. tests-1]. */
bool ident_feed(struct ident *id, const struct cycle *cycle);

/* Ends the stream and closes a test under way, which is excluded (REFUSED_INCOMPLETE) unless its
 * evaluated part was over. Returns true if a test was under way; its result is then the last of
 * id->result.test[0 .. tests-1]. */
bool ident_end(struct ident *id);

/* Computes methods A, modified A and B if all six axes have tests that are not excluded; otherwise
 * `evaluated` of these methods is false. Returns true if methods A and B were evaluated. */
bool ident_solve(struct ident *id);

/* Entries of the matrix that are shown to users: those of Tian 2015 Tables 3 to 5. */
enum { IDENT_ENTRIES = 10 };
struct ident_entry {
    const char *name;
    int row, col;
    const char *unit;
};
extern const struct ident_entry ident_entries[IDENT_ENTRIES];

/* Relative difference of an entry from the nominal one, per cent; negative: too small in magnitude.
 * It means nothing if the nominal entry is near zero. */
double ident_error_pct(const struct identification *id, const struct method_result *method, const struct ident_entry *entry);

/* Scale for differences of an entry: sqrt(Mii Mjj), which on the diagonal is the entry itself. */
double ident_scale(const double mt[DOFS][DOFS], const struct ident_entry *entry);

#endif
