/* Replay: the model driven as the machine was. Closed loop: same reference and controller, on
 * the simulated plant with its sensors (closed-form engine). Motion: the measured motion and
 * commands, without a controller (residual.h). */
#ifndef HEXID_REPLAY_H
#define HEXID_REPLAY_H

#include "gap.h"
#include "residual.h"

/* Simulates the tests of `like` run by run; `out` holds what a log of that run would hold, and
 * is the caller's to free, even after an error. Returns 0, -2 if a run ends in a fault, -3
 * without memory. */
int replay_closed_loop(const struct params *model, const struct recording *like, struct recording *out, struct error *error);

/* One of two simulations of the same tests. */
struct replay {
    const struct params *model; /* NULL: no simulation; the other's stands for it */
    const struct recording *like;
    struct recording run;
    int status;                 /* result of replay_closed_loop */
    struct error error;
};

/* Simulates two models at once, a thread each; after may be NULL. Always call replay_free. */
void replay_both(const struct params *before, const struct params *after, const struct recording *like, struct replay both[2]);
void replay_free(struct replay both[2]);

/* The second model's run. */
static inline const struct recording *replay_after(const struct replay both[2]) { return both[1].model ? &both[1].run : &both[0].run; }

/* Inertia matrix by method A, from a recording's first run. False without six complete tests. */
bool replay_identify(const struct params *params, const struct recording *recording, double mt[DOFS][DOFS]);

/* The same, corrected for the model's friction: less the difference between two simulations,
 * with friction and without. Also false if a simulation does not end regularly. */
bool replay_repair(const struct params *params, const struct params *model, const struct recording *measured, double mt[DOFS][DOFS]);

/* Distances of two models from a recording, and the noise that the second distance contains.
 * Without a second model both distances are the first's. */
struct replay_sizes {
    struct gap_size before, after, noise;
};

/* Compares simulations with the given cycles of the measured run. */
struct replay_sizes replay_compare(const struct recording *measured, const struct replay both[2], enum cycles which);

/* The same without a simulation: force and pressures under the measured motion. Length and valve
 * are not evaluated (NaN). after may be NULL. */
struct replay_sizes replay_motion(const struct residual_data *measured, const struct params *before, const struct params *after);

#endif
