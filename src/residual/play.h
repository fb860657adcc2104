/* Position of the rods in joints with backlash. Lengths are measured up to the rods' ends, and the
 * platform is somewhere between the flanks of the joints.
 *
 * A rod's own balance of forces gives the contact force; its sign shows the flank on which the rod
 * lies. The joint may be loose if this force is too small to have a sure sign, or changes sign
 * within the time that the series cannot resolve. Let u be the legs whose joints may be loose, M
 * the inertia of the platform along the legs, without rods, and the imbalance the hydraulic force
 * less friction, less the force that the bodies would need to follow the rods. Then the rods of u
 * move ahead of their joints with
 *
 *   ahead'' = -M_uu^-1 imbalance_u
 *
 * This acceleration is integrated twice from flank to flank if the backlash exceeds the path
 * that noise of the forces makes. So the measured forces show when a joint knocks. A simulation
 * could not predict this instant, because it depends on a few newtons. Pure. */
#ifndef HEXID_PLAY_H
#define HEXID_PLAY_H

#include "inverse_dynamics.h"
#include "types.h"

/* Mean square noise of a rod's path of n steps between two fixed ends, [n][leg]. push_n2s4: from
 * the noise of each leg's force, integrated twice. length_m2: from the noise of the rod's own
 * length. */
struct play_noise {
    double push_n2s4[PHASES + 1][LEGS], length_m2[PHASES + 1][LEGS];
};

/* A motion at instants step_s apart. cycle: the last instant is followed by the first. at: state of
 * the legs without backlash. */
struct play_motion {
    const struct inverse_dynamics_input *at;
    int phases;             /* number of instants, at most PHASES */
    bool cycle;
    double step_s;
    double resolution_s;    /* a sudden change of a force appears in the Fourier series spread over
                             * this time before the change and the same time after it */
    const struct play_noise *noise;
};

/* Finds the positions of the rods in their joints with backlash. d: inverse dynamics of a platform,
 * with force_std_n set. ahead_m: distance by which each rod is ahead of its position in a joint
 * without backlash. Returns false if no pose has these lengths. */
bool play_find(struct inverse_dynamics *d, const struct play_motion *motion, double ahead_m[PHASES][LEGS]);

#endif
