/* Section `checks` of the configuration (params.h). */
#ifndef HEXID_PARAMS_CHECKS_H
#define HEXID_PARAMS_CHECKS_H

struct check_params { /* limits of the verdict, in percent unless the name has a unit. A run beyond
                       * any of them has the verdict fail. amplitude_pct, unwanted_pct and
                       * symmetry_pct count only if methods A and B are judged */
    double amplitude_pct; /* difference between achieved and commanded amplitude, as a share of the
                           * commanded one */
    double unwanted_pct;         /* motion of another axis in a test, as a share of that axis's own
                                  * test amplitude */
    double overruns_pct;          /* share of the cycles in which the loop was late */
    double excluded_pct;          /* share of the evaluated samples that are excluded */
    double length_wander_m;       /* largest change of the fundamental of a leg's length between the
                                   * periods of a test */
    double reference_off_m;       /* mean deviation of a leg's length from its reference in a test,
                                   * either sign */
    double force_wander_n;        /* largest change of the mean or the fundamental of a leg's force
                                   * between the periods of a test, and of the mean also between
                                   * tests */
    double period_s;             /* longest loop.period_s; with a longer period the steps of the
                                  * command distort the matrix */
    double symmetry_pct;       /* largest |Mt_ij - Mt_ji| / sqrt(Mt_ii Mt_jj) of methods A and B; if
                                * method C passes, the same limit applies to their difference from
                                * its matrix */
};

#endif
