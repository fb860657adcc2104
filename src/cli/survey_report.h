/* What `hexid run --survey` says: eigenfrequencies, the configured tests against them and against
 * the sensors' floor, and tests for a wanted standard deviation. Ordinary threads; heap. */
#ifndef HEXID_SURVEY_REPORT_H
#define HEXID_SURVEY_REPORT_H

#include <stdio.h>

#include "proposal.h"

/* One axis of a test. */
struct test_judgement {
    double hz, amplitude;
    double of_oil, of_loop;    /* its frequency over the lowest eigenfrequency; NaN: none */
    double follow;             /* amplitude reached over the reference's, in the survey */
    double leg_m, leg_n;       /* amplitude of the leg that moves, and of the one that pushes
                                * most */
    double noise_m, noise_n;   /* of one sample of the worst leg, rms; at least what rounding has */
    bool below;                /* both eigenfrequencies, those that there are; false without any */
    bool above_floor;
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

/* `asked`: as configured, without the survey. -2: the recording does not tell, and
 * why; -3: memory. */
int survey_report_make(struct survey_report *r, const struct multisine *multisine, const struct recording *recording,
                       const struct method_c *inertia, const struct params *asked, double wanted_pct, struct error *error);

void survey_report_print(const struct survey_report *r, FILE *out);

/* identification_json's text with the member "survey", schema hexid.survey/1 (docs/survey.md);
 * takes the text. NULL without memory. */
char *survey_report_json(const struct survey_report *r, char *identification);

#endif
