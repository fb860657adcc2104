/* What `hexid run --survey` reports: eigenfrequencies, the configured tests against them and
 * against the sensors' noise floor, and tests for a wanted standard deviation. Ordinary threads;
 * heap. */
#ifndef HEXID_SURVEY_REPORT_H
#define HEXID_SURVEY_REPORT_H

#include <stdio.h>

#include "proposal.h"

/* One axis of a test: frequency in Hz, amplitude in m or rad. */
struct test_judgement {
    double hz, amplitude;
    double of_oil, of_loop;    /* its frequency over the lowest eigenfrequency of the oil columns,
                                * of the loop; NaN: none */
    double follow;             /* amplitude reached over that of the reference, in the survey */
    double leg_m, leg_n;       /* amplitude of the leg that moves most, and of the one that pushes
                                * most */
    double noise_m, noise_n;   /* rms noise of one sample of the worst leg; of the length at least
                                * its rounding */
    bool below;                /* below both eigenfrequencies, the loop's only if there is one;
                                * false without the oil columns' */
    bool above_floor;          /* both amplitudes are above the noise */
};

struct survey_report {
    struct loop_survey survey;
    struct params asked;                      /* as configured, without the survey */
    struct test_judgement test[DOFS];         /* by axis */
    struct excitation configured;             /* what the configured tests would give; status
                                               * of no_prediction 0 */
    struct error no_prediction;
    double wanted_pct;
    struct proposal proposal[PROPOSALS];
};

/* `asked`: as configured, without the survey. -2 with the reason: the recording cannot tell; -3:
 * memory. */
int survey_report_make(struct survey_report *r, const struct multisine *multisine, const struct recording *recording,
                       const struct method_c *inertia, const struct params *asked, double wanted_pct, struct error *error);

void survey_report_print(const struct survey_report *r, FILE *out);

/* identification_json's text with the member "survey", schema hexid.survey/1 (docs/survey.md);
 * takes the text. NULL without memory. */
char *survey_report_json(const struct survey_report *r, char *identification);

#endif
