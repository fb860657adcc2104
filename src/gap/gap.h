/* Finds the gap between a model and a measurement, and the effects that explain it (gap_result.h).
 * Ordinary threads; heap. */
#ifndef HEXID_GAP_H
#define HEXID_GAP_H

#include "gap_result.h"
#include "recording.h"

struct waves;

struct gap_options {
    enum gap_replay replay;
    bool simulate;                        /* check the result by simulation in closed loop */
    int threads;
    void (*progress)(void *context, const char *step, double share); /* called on the thread of
                                                                      * gap_solve(), share 0..1; may
                                                                      * be NULL */
    void *context;
};

/* Reports to options->progress, if there is one, the name of a step and the share of the whole work
 * that is done. */
void gap_progress(const struct gap_options *options, const char *step, double share);

/* Runs the whole diagnosis. validate: another log, which judges the result in place of the held-out
 * cycles; NULL: there is none. Both logs must have been admitted (admit.h). waves: filled if the
 * result is simulated, otherwise left as it was; freed by the caller; may be NULL. Returns 0 or a
 * negative status. */
int gap_solve(const struct params *params, const struct recording *measured, const struct recording *validate,
              const struct gap_options *options, struct gap_result *result, struct waves *waves, struct error *error);

#endif
