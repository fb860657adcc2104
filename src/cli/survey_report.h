/* Results of `hexid run --survey`: the eigenfrequencies, a comparison of the configured tests with
 * them and with the sensors' noise floor, and proposed tests for a wanted standard deviation.
 * Ordinary threads; heap. */
#ifndef HEXID_SURVEY_REPORT_H
#define HEXID_SURVEY_REPORT_H

#include <stdio.h>

#include "loop_tune.h"
#include "params.h"
#include "proposal.h"

/* Judgement of the configured test of one axis; hz and amplitude (m or rad) are those of the
 * test. */
struct test_judgement {
    double hz, amplitude;
    double of_oil, of_loop;    /* the test's frequency divided by the lowest eigenfrequency of the
                                * oil columns, and by that of the loop; NaN: there is no such
                                * eigenfrequency */
    double follow;             /* amplitude that the loop reaches at this frequency according to the
                                * survey, as a share of the reference's */
    double leg_m, leg_n;       /* length amplitude of the leg that moves most, and force amplitude
                                * of the leg that pushes most */
    double noise_m, noise_n;   /* rms noise of one sample of length and of force, for the noisiest
                                * leg; noise_m is at least the rounding error of a length */
    bool below;                /* the test's frequency is below the eigenfrequency of the oil
                                * columns, and below that of the loop if there is one; false if the
                                * oil columns have none */
    bool above_floor;          /* the amplitudes of length and force are above the noise */
};

struct survey_report {
    struct loop_survey survey;
    struct params asked;                      /* configured parameters, with the configured tests */
    struct test_judgement test[DOFS];         /* judgements of the configured tests, by axis */
    struct excitation configured;             /* prediction for the configured tests, if
                                               * no_prediction has status 0 */
    struct error no_prediction;
    struct loop_tune gains;                   /* gains of `hexid tune` for the machine as
                                               * identified, if no_gains has status 0 */
    struct error no_gains;
    double wanted_pct;
    struct proposal proposal[PROPOSALS];
};

/* Receives the progress: step() is called with the name of the current step and the share of the
 * whole work that is done, 0..1. */
struct survey_watch {
    void (*step)(void *context, const char *what, double share);
    void *context;
};

/* Computes all results. `asked`: configured parameters, with the configured tests. Returns -2 with
 * the reason if the recording is not sufficient, -3 without memory. */
int survey_report_make(struct survey_report *r, const struct multisine *multisine, const struct recording *recording,
                       const struct method_c *inertia, const struct params *asked, double wanted_pct, const struct survey_watch *watch,
                       struct error *error);

void survey_report_print(const struct survey_report *r, FILE *out);

/* Adds the member "survey", schema hexid.survey/1 (docs/survey.md), to identification_json's text,
 * which it frees. Returns the new text, to be freed; NULL without memory. */
char *survey_report_json(const struct survey_report *r, char *identification);

#endif
