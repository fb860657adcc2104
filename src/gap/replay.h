/* Replay: the model driven as the rig was. Closed loop: same reference and controller, on the plant
 * with its sensors (closed form engine: it need not be the rig's). Motion: the measured motion and
 * commands, which needs no controller (residual.h). */
#ifndef HEXID_REPLAY_H
#define HEXID_REPLAY_H

#include "gap.h"
#include "residual.h"

/* Runs the tests of `like` on the model, run by run; `out` holds what a log of that run would,
 * and is the caller's to free, also after an error. -2 when the model's run ends in a fault,
 * -3 without memory. */
int replay_closed_loop(const struct params *model, const struct recording *like, struct recording *out, struct error *error);

/* One of two runs of the same tests. */
struct replay {
    const struct params *model; /* NULL: the other's, and no run of its own */
    const struct recording *like;
    struct recording run;
    int status;                 /* as of replay_closed_loop */
    struct error error;
};

/* Two models at once, a thread each; after may be NULL. To be freed in any case. */
void replay_both(const struct params *before, const struct params *after, const struct recording *like, struct replay both[2]);
void replay_free(struct replay both[2]);

/* The second model's run. */
static inline const struct recording *replay_after(const struct replay both[2]) { return both[1].model ? &both[1].run : &both[0].run; }

/* The inertia matrix identified from a recording (method A), of its first run alone. False without
 * six complete tests. */
bool replay_identify(const struct params *params, const struct recording *recording, double mt[DOFS][DOFS]);

/* The same, and what the model's friction effects do to it taken off: the difference of two runs of
 * the model, with them and without. False also where a run does not come to its end. */
bool replay_repair(const struct params *params, const struct params *model, const struct recording *measured, double mt[DOFS][DOFS]);

/* How far two models are from a recording, and its noise: what is in the difference of the second
 * one, too. Without a second one the first is both. */
struct replay_sizes {
    struct gap_size before, after, noise;
};

/* Of the models' runs, over the cycles given of the measured one. */
struct replay_sizes replay_compare(const struct recording *measured, const struct replay both[2], enum cycles which);

/* The same without a simulation in closed loop: force and pressures under the measured motion;
 * length and valve are not evaluated (NaN). after may be NULL. */
struct replay_sizes replay_motion(const struct residual_data *measured, const struct params *before, const struct params *after);

#endif
