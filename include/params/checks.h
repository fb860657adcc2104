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
    double force_wander_n;        /* change of a leg force's mean and fundamental from period to
                                   * period; of the mean also from test to test */
    double period_s;             /* longest loop.period_s; a longer one puts the command's staircase
                                  * into the matrix */
    double symmetry_pct;       /* |Mt - Mt'| divided by the root of the product of the diagonal
                                * entries */
};

#endif
