/* Predicts how well a test would determine the matrix before it is run: the standard deviations
 * that method C would state for a recording of it, simulated on the machine that a survey found.
 * That machine follows its references with the survey's response at each axis's frequency, needs
 * the forces of the configured bodies and of the friction found, and is measured with the noise
 * found and the configured rounding of lengths. Ordinary threads; heap. */
#ifndef HEXID_EXCITATION_H
#define HEXID_EXCITATION_H

#include "loop_survey.h"

struct excitation {
    /* Largest standard deviation of an entry, in per cent of sqrt(M_ii M_jj); infinite if some
     * entry is not determined. */
    double worst_pct;
    enum dof row, column;  /* the entry that has it, row <= column */
    double axis_pct[DOFS]; /* largest of each row */
};

/* Simulates the tests, six sinusoids one after another or a multisine, with `draws` draws of the
 * noise. worst_pct is the mean over the draws: a single one is no better than 10 %, because noise
 * and the dry friction found vary. Returns -2 if method C refuses, -3 without memory. */
int excitation_predict(const struct loop_survey *survey, const struct params *params, const struct test_params *tests, int draws,
                       struct excitation *result, struct error *error);

/* The same figures for an identified matrix. */
struct excitation excitation_of(const struct method_result *matrix);

#endif
