/* Where the rods of legs with play are in their joints. Lengths are measured up to the rods' ends,
 * and the platform is somewhere between the flanks.
 *
 * A rod's own balance gives what it pushes the platform with, and so the flank. Where that is too
 * small to tell, or changes its sign so near that the series cannot tell when, the joint may be
 * loose. Of these legs together, u, the platform has along them the inertia M, the rods taken off,
 * and moves in the joints by the balance of forces (hydraulic force less friction, less what the
 * bodies need for the motion of the rods):
 *
 *   ahead'' = -M_uu^-1 imbalance_u
 *
 * integrated twice from flank to flank, where the play is larger than the way that noise of the
 * forces makes. When a joint knocks is so read from the forces, and not predicted: a few newtons
 * decide it. Pure. */
#ifndef HEXID_PLAY_H
#define HEXID_PLAY_H

#include "inverse_dynamics.h"

/* Mean squares, by noise, of a way of so many steps whose ends are held: of each leg's push,
 * integrated twice, and of its length. */
struct play_noise {
    double push_n2s4[PHASES + 1][LEGS], length_m2[PHASES + 1][LEGS];
};

/* Instants of a motion, every step_s; a cycle's follow each other round. at: the legs as if no
 * joint had play. */
struct play_motion {
    const struct inverse_dynamics_input *at;
    int phases;             /* at most PHASES */
    bool cycle;
    double step_s;
    double resolution_s;    /* a change of the forces is spread over this time, before and after */
    const struct play_noise *noise;
};

/* ahead_m: how far each rod is ahead of where it would be in a joint without play. d: of a
 * platform, with the standard deviations of the balance of forces. False: no pose has these
 * lengths. */
bool play_find(struct inverse_dynamics *d, const struct play_motion *motion, double ahead_m[PHASES][LEGS]);

#endif
