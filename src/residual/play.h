/* Where the rods of legs with play are in their joints. Lengths are measured up to the rods' ends,
 * and the platform is somewhere between the flanks.
 *
 * A leg's balance gives what its rod pushes the platform with, whichever way that is, and so the
 * flank. Where the push is too small to tell, or changes its sign so near that the measured series
 * cannot tell when, the joint may be loose. There the balance of forces says how it moves: what it
 * is short of is the inertia of the platform, accelerated along the legs that may be loose, less
 * their rods, which do not move with it. Integrated twice from flank to flank. Pure. */
#ifndef HEXID_PLAY_H
#define HEXID_PLAY_H

#include "inverse_dynamics.h"

/* Instants of a motion, every step_s; a cycle's follow each other round. */
struct play_motion {
    const struct inverse_dynamics_input *at;
    int phases;             /* at most PHASES */
    bool cycle;
    double step_s;
    double resolution_s;    /* a change of the forces is spread over this time, before and after */
    double force_std_n[LEGS]; /* of the balance of forces, at an instant */
};

/* ahead_m: how far each rod is ahead of where it would be in a joint without play. False: no pose
 * has these lengths. */
bool play_find(const struct params *model, const struct play_motion *motion, double ahead_m[PHASES][LEGS]);

#endif
