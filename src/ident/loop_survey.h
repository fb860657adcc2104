/* What a survey's run finds: oil columns, closed loop, how the axes follow, and the sensors' noise.
 * Ordinary threads; heap. */
#ifndef HEXID_LOOP_SURVEY_H
#define HEXID_LOOP_SURVEY_H

#include "loop_poles.h"
#include "method_c.h"

struct loop_survey {
    struct multisine multisine;
    struct method_c inertia;
    struct oil_leg leg[LEGS];
    bool determined;                          /* the six modes; else their frequencies are NaN */
    struct oil_mode mode[DOFS];               /* ascending */
    struct loop_mode loop[DOFS];              /* of each mode; NaN: none that
                                               * oscillates, or not determined */
    double complex follow[MULTISINE_LINES][DOFS]; /* pose over the reference of the line's axis: of
                                                   * that axis, and what moves besides */
    double noise_m[LEGS], noise_pa[2][LEGS];  /* rms of a sample, from pass to pass */
    double mean_pa[2][LEGS];
};

/* From the recording of a survey's run, whose first test is evaluated, and method C of it. -2: no
 * pressures or no commands, or samples missing in every pass; -3: memory. */
int loop_survey(struct loop_survey *s, const struct multisine *multisine, const struct recording *recording, const struct method_c *inertia,
                struct error *error);

/* The lowest determined eigenfrequencies; NaN: none. */
double loop_survey_oil_hz(const struct loop_survey *s);
double loop_survey_loop_hz(const struct loop_survey *s);

/* Pose of an axis over the reference of the driven one, at a frequency: interpolated between the
 * neighbouring lines of the driven axis, beyond them that of the nearest line. */
double complex loop_survey_response(const struct loop_survey *s, enum dof driven, enum dof dof, double hz);

/* The same of the driven axis itself. */
double complex loop_survey_follow(const struct loop_survey *s, enum dof dof, double hz);

#endif
