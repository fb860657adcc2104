/* Predicts, before a test is run, how well the test would determine the matrix. The prediction is
 * the standard deviations that method C states for a recording of the test, simulated on the
 * machine that a survey found. This machine follows its references with the survey's response at
 * each axis's frequency, needs the forces of the configured bodies and of the friction found,
 * and is measured with the noise found and the configured rounding of lengths. Ordinary threads;
 * heap. */
#ifndef HEXID_EXCITATION_H
#define HEXID_EXCITATION_H

#include "loop_survey.h"

/* Means over several draws of the noise: the result of a single draw errs by 10 %, because the
 * noise, and the dry friction found from it, vary. */
struct excitation {
    /* Largest standard deviation of an entry, in per cent of sqrt(M_ii M_jj); infinite if some
     * entry is not determined. */
    double worst_pct;
    enum dof row, column;  /* the entry whose mean standard deviation is largest, row <= column */
    double axis_pct[DOFS]; /* largest standard deviation of an entry in the row of each axis, as in
                            * worst_pct */
};

/* Simulates the tests, six sinusoids one after another or a multisine, with `draws` draws of the
 * noise, at least one. Returns 0; -2 if the machine cannot make the motion, or method C refuses the
 * recording; -3 without memory. */
int excitation_predict(const struct loop_survey *survey, const struct params *params, const struct test_params *tests, int draws,
                       struct excitation *result, struct error *error);

/* Computes struct excitation for matrices that were identified from `draws` recordings of one
 * test. */
struct excitation excitation_of(int draws, const struct method_result *matrix);

#endif
