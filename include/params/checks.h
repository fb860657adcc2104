/* Section `checks` of the configuration (params.h). */
#ifndef HEXID_PARAMS_CHECKS_H
#define HEXID_PARAMS_CHECKS_H

struct check_params { /* limits in percent unless a unit is named; a run beyond any of them fails */
    double amplitude_pct; /* difference between achieved and commanded amplitude, as a share of the
                           * commanded one */
    double unwanted_pct;         /* motion of another axis in a test, as a share of that axis's own
                                  * test amplitude */
    double overruns_pct;          /* share of the cycles in which the loop was late */
    double excluded_pct;          /* share of the evaluated samples that are excluded */
    double length_wander_m;       /* change of a leg length's fundamental between test periods */
    double reference_off_m;       /* mean distance of a leg's length from its reference in a test */
    double force_wander_n;        /* largest less smallest mean of a leg's force over the periods of
                                   * a test, and the same of its fundamental; of the mean also over
                                   * the tests */
    double period_s;             /* longest loop.period_s; with a longer one the steps of the
                                  * command distort the matrix */
    double symmetry_pct;       /* |Mt - Mt'| divided by the root of the product of the diagonal
                                * entries, and |Mt - method C's| where method C passes */
};

#endif
