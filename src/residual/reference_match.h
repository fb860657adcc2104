/* Do the lengths follow the reference through the drawing as it is? On a drawing that is turned or
 * mirrored about z six lengths have the same poses, turned or mirrored, so that no length and no
 * force shows it. Against a reference it shows, and so does another order of the legs.
 *
 * Near neutral the lengths are l = J G r: reference r about its mean, G a gain of 0 or more for
 * each axis, because no loop follows exactly, and J the Jacobian of a drawing. The share of l that
 * this leaves unexplained, of what any six rows could explain, is 0 for the true drawing, whatever
 * the loop's gains and lag. Each order of the legs, each angle of a turn and each plane of a mirror
 * is tried. The drawing is refuted if one of them explains decisively more than the drawing as it
 * is. Any thread, no heap. */
#ifndef HEXID_REFERENCE_MATCH_H
#define HEXID_REFERENCE_MATCH_H

#include "kinematics.h"

struct params;

enum { REFERENCE_MATCH_TEXT = 480 };

/* Sums of products over all samples, about the means. A reference length is that of the reference's
 * pose, by the drawing. */
struct leg_moments {
    double product[LEGS][LEGS]; /* measured length of one leg times reference length of another */
    double measured[LEGS];      /* squares of the measured lengths */
    double asked[LEGS][LEGS];   /* products of reference lengths */
};

extern const char *const reference_names[DOFS]; /* "ref_x_m", as columns are called */

struct reference_match {
    bool refuted;
    double stated, best; /* shares that the drawing as it is, and the best one, leave unexplained */
    char text[REFERENCE_MATCH_TEXT]; /* if refuted: what is wrong, and the remedy */
};

void reference_match_find(const struct params *params, const struct leg_moments *m, struct reference_match *match);

#endif
