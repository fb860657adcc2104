/* Replay: the model is driven as the machine was. In closed loop the same reference and controller
 * act on the simulated plant with its sensors (closed-form engine); the law `model` takes its
 * numbers from the configuration as recorded, not from the model that is tried. Under the measured
 * motion and commands there is no controller (residual.h). */
#ifndef HEXID_REPLAY_H
#define HEXID_REPLAY_H

#include "gap_result.h"
#include "residual.h"

/* Simulates the tests of `like`, run by run. out: what a log of these runs would hold; the caller
 * frees it, even after an error. Returns 0, -2 if a run ends in a fault, or -3 without memory. */
int replay_closed_loop(const struct params *model, const struct recording *like, struct recording *out, struct error *error);

/* One of two simulations of the same tests: with the model before the effects, or with the model
 * after them. */
struct replay {
    const struct params *model; /* simulated model; NULL: no simulation, the other one stands for
                                 * it */
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

/* Inertia matrix by method A from a recording's first run. False: that has not six complete
 * tests. */
bool replay_identify(const struct params *params, const struct recording *recording, double mt[DOFS][DOFS]);

/* Inertia matrix by method A from a recording's first run, less the change that the model's
 * friction makes in simulation. False: there are not six complete tests, or a simulation does not
 * end regularly. */
bool replay_repair(const struct params *params, const struct params *model, const struct recording *measured, double mt[DOFS][DOFS]);

/* Distances of two models from a recording, and the noise that the second distance contains.
 * Without a second model, after is equal to before. */
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
