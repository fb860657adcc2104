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
    bool determined; /* all six modes are determined; otherwise their frequencies are NaN */
    struct oil_mode mode[DOFS];               /* modes of the oil columns, by ascending frequency */
    struct loop_mode loop[DOFS];              /* closed loop in each mode; NaN: no poles of the mode
                                               * oscillate */
    /* Amplitude of every axis at each tone, relative to the reference of the tone's own axis. */
    double complex follow[MULTISINE_TONES][DOFS];
    double noise_m[LEGS], noise_pa[2][LEGS];  /* rms noise of a sample, from differences between the
                                               * passes */
    double mean_pa[2][LEGS];
};

/* Evaluates the first test of a recording, the survey's run, with method C's result for it.
 * Returns -2 without pressures or commands, or if some sample is missing in every pass, -3
 * without memory. */
int loop_survey(struct loop_survey *s, const struct multisine *multisine, const struct recording *recording, const struct method_c *inertia,
                struct error *error);

/* Lowest eigenfrequency of the oil columns, and of the closed loop, Hz; NaN: none is determined. */
double loop_survey_oil_hz(const struct loop_survey *s);
double loop_survey_loop_hz(const struct loop_survey *s);

/* Amplitude of axis `dof`, relative to the reference of axis `driven`, at a frequency. It is
 * interpolated between the neighbouring tones of the driven axis; outside the range of these tones
 * it is the amplitude at the nearest tone. */
double complex loop_survey_response(const struct loop_survey *s, enum dof driven, enum dof dof, double hz);

/* Amplitude of an axis, relative to its own reference, at a frequency. */
double complex loop_survey_follow(const struct loop_survey *s, enum dof dof, double hz);

#endif
