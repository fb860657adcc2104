/* Results of a survey's run: oil columns, closed loop, response of the axes, and the sensors'
 * noise. Ordinary threads; heap. */
#ifndef HEXID_LOOP_SURVEY_H
#define HEXID_LOOP_SURVEY_H

#include "loop_poles.h"
#include "method_c.h"

struct loop_survey {
    struct multisine multisine;
    struct method_c inertia;
    struct oil_leg leg[LEGS];
    bool determined; /* the six modes are; else their frequencies are NaN */
    struct oil_mode mode[DOFS];               /* ascending */
    struct loop_mode loop[DOFS];              /* each mode's; NaN: none oscillates */
    /* Pose of every axis over the reference of the tone's axis. */
    double complex follow[MULTISINE_LINES][DOFS];
    double noise_m[LEGS], noise_pa[2][LEGS];  /* rms of a sample, from pass to pass */
    double mean_pa[2][LEGS];
};

/* Evaluates the recording of a survey's run, whose first test is used, with method C's result for
 * it. Returns -2 without pressures or commands, or if a sample is missing in every pass, -3 without
 * memory. */
int loop_survey(struct loop_survey *s, const struct multisine *multisine, const struct recording *recording, const struct method_c *inertia,
                struct error *error);

/* The lowest determined eigenfrequencies; NaN: none. */
double loop_survey_oil_hz(const struct loop_survey *s);
double loop_survey_loop_hz(const struct loop_survey *s);

/* Pose of an axis over the reference of the driven one at a frequency: interpolated between the
 * neighbouring tones of the driven axis; beyond them, that of the nearest tone. */
double complex loop_survey_response(const struct loop_survey *s, enum dof driven, enum dof dof, double hz);

/* Response of the driven axis itself. */
double complex loop_survey_follow(const struct loop_survey *s, enum dof dof, double hz);

#endif
