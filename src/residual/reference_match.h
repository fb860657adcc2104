/* Do the lengths follow the reference through the drawing as it is? On a drawing that is turned or
 * mirrored about z six lengths have the same poses, turned or mirrored, so that no length and no
 * force shows it. Against a reference it shows, and so does another order of the legs.
 *
 * Near neutral the lengths are l = J (G r + H r'): reference r about its mean and its rate, and
 * for each axis a gain G of 0 or more and a lag H of either sign, because no loop follows exactly;
 * J is the Jacobian of a drawing. The share of l that this leaves unexplained, of what any rows
 * could explain, is 0 for the true drawing, whatever the loop's gains and lags; an axis that lags
 * by more than 45 degrees may have a gain of either sign. Each order of the legs, each angle of a
 * turn and each plane of a mirror is tried. The drawing is refuted if one of them explains
 * decisively more than the drawing as it is. If not both planes move in both axes, each on its own
 * (x and y, phi and theta; a circle is one motion), motion of other axes, or a reference about
 * another point, looks much like a turn; then the drawing must leave most of the motion
 * unexplained. Any thread, no heap. */
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
    double late[LEGS][LEGS];    /* measured length of one leg times the rate of another's
                                 * reference */
    double mixed[LEGS][LEGS];   /* rate of one reference length times another reference length */
    double rates[LEGS][LEGS];   /* products of the rates of reference lengths */
};

extern const char *const reference_names[DOFS]; /* "ref_x_m", as columns are called */

struct reference_match {
    bool refuted;
    double stated, best; /* shares of the motion that the drawing as it is, and the best one, leave
                          * unexplained */
    char text[REFERENCE_MATCH_TEXT]; /* if refuted: what is wrong, and the remedy */
};

void reference_match_find(const struct params *params, const struct leg_moments *m, struct reference_match *match);

#endif
