/* What a test would give, before it is run: the deviations that method C itself would state of a
 * recording of the test, made by the machine that a survey found. That machine moves as the loop
 * follows (the survey's response at each axis's frequency), needs the forces of the configured
 * bodies with the friction found, and is measured with the noise found, lengths rounded as
 * configured. Ordinary threads; heap. */
#ifndef HEXID_EXCITATION_H
#define HEXID_EXCITATION_H

#include "loop_survey.h"

struct excitation {
    double worst_pct;      /* the largest standard deviation of an entry, in per cent of sqrt(M_ii
                            * M_jj); infinite: some entry is not determined */
    enum dof row, column;  /* of that entry, row <= column */
    double axis_pct[DOFS]; /* the largest of each row */
};

/* tests: six sinusoids one after another, or a multisine. draws: of the noise; the result is the
 * mean of their largest deviations, which one draw gives no better than to a tenth, because the
 * noise, and the dry friction that method C finds, differ. -2: method C refuses; -3: memory. */
int excitation_predict(const struct loop_survey *survey, const struct params *params, const struct test_params *tests, int draws,
                       struct excitation *result, struct error *error);

/* The same measure of a matrix that was identified. */
struct excitation excitation_of(const struct method_result *matrix);

#endif
