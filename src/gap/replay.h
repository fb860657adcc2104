/* Replay: the model is driven as the machine was. In closed loop the same reference and controller
 * act on the simulated plant with its sensors (closed-form engine). The control law `model` then
 * computes with the configured machine (recording.params), not with the model under trial. The
 * replay under the measured motion and commands has no controller (residual.h). */
#ifndef HEXID_REPLAY_H
#define HEXID_REPLAY_H

#include "gap_result.h"
#include "residual.h"

/* Simulates the tests of `like`, run by run. out: receives what a log of these runs would contain;
 * the caller frees it, even after an error. Returns 0, -2 if a run ends in a fault or does not come
 * to its end, or -3 without memory. */
int replay_closed_loop(const struct params *model, const struct recording *like, struct recording *out, struct error *error);

/* One of two simulations of the same tests: with the model before the effects, or with the model
 * after them. */
struct replay {
    const struct params *model; /* simulated model; NULL: it is not simulated, and the other
                                 * simulation takes its place */
    const struct recording *like;
    struct recording run;
    int status;                 /* result of replay_closed_loop */
    struct error error;
};

/* Simulates two models at once, each on a thread; after may be NULL. Call replay_free in any
 * case. */
void replay_both(const struct params *before, const struct params *after, const struct recording *like, struct replay both[2]);
void replay_free(struct replay both[2]);

/* Simulated run of the second model, or of the first if there is no second. */
static inline const struct recording *replay_after(const struct replay both[2]) { return both[1].model ? &both[1].run : &both[0].run; }

/* Computes the inertia matrix by method A from a recording's first run. Returns false unless this
 * run has six complete tests. */
bool replay_identify(const struct params *params, const struct recording *recording, double mt[DOFS][DOFS]);

/* Computes the inertia matrix by method A from a recording's first run, less the change that the
 * model's friction makes to the matrix in simulation. Returns false unless the run has six complete
 * tests and both simulations, with and without friction, end without a fault. */
bool replay_repair(const struct params *params, const struct params *model, const struct recording *measured, double mt[DOFS][DOFS]);

/* Distances of two models from a recording, and the noise that the distance `after` contains.
 * Without a second model `after` equals `before`. */
struct replay_sizes {
    struct gap_size before, after, noise;
};

/* Compares simulations in closed loop with the given cycles of the measured run. */
struct replay_sizes replay_compare(const struct recording *measured, const struct replay both[2], enum cycles which);

/* Compares both models with the recording by the residuals under the measured motion, without a
 * simulation in closed loop: force and pressures only; length and valve are NaN. after may be
 * NULL. */
struct replay_sizes replay_motion(const struct residual_data *measured, const struct params *before, const struct params *after);

#endif
