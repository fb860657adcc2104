/* Position of the rods in joints with backlash. Lengths are measured up to the rods' ends, and the
 * platform is somewhere between the flanks.
 *
 * A rod's own balance of forces gives the contact force, and so the flank. If that force is too
 * small to tell, or changes sign so near that the series cannot resolve it, the joint may be loose.
 * Along the legs u that may be loose, the platform without rods has the inertia M and moves in the
 * joints by the balance of forces (hydraulic force less friction, less the force that the bodies
 * need for the motion of the rods):
 *
 *   ahead'' = -M_uu^-1 imbalance_u
 *
 * This is integrated twice from flank to flank where the backlash exceeds the path that noise of
 * the forces makes. So the forces show when a joint knocks; a prediction would hang on a few
 * newtons. Pure. */
#ifndef HEXID_PLAY_H
#define HEXID_PLAY_H

#include "inverse_dynamics.h"
#include "types.h"

/* Mean squares that noise gives a path over so many steps whose ends are held: from each leg's
 * force, integrated twice, and from its length. */
struct play_noise {
    double push_n2s4[PHASES + 1][LEGS], length_m2[PHASES + 1][LEGS];
};

/* A motion at instants step_s apart. cycle: the last instant is followed by the first. at: the legs
 * as they would be without backlash. */
struct play_motion {
    const struct inverse_dynamics_input *at;
    int phases;             /* number of instants, at most PHASES */
    bool cycle;
    double step_s;
    double resolution_s;    /* series smear a change of the forces over this time before and after
                             * it */
    const struct play_noise *noise;
};

/* Finds where backlash puts the rods. d: of a platform, with force_std_n set. ahead_m: distance
 * that each rod is ahead of its place in a joint without backlash. False: no pose has these
 * lengths. */
bool play_find(struct inverse_dynamics *d, const struct play_motion *motion, double ahead_m[PHASES][LEGS]);

#endif
