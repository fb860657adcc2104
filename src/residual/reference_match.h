/* Checks whether the lengths show, by following the reference, that the stated drawing (the
 * configured positions of the joints) is right. If the drawing is turned about z or mirrored in a
 * plane through z, the same six lengths give the same pose, turned or mirrored, so that no length
 * and no force shows the error. A comparison with the reference shows it, and also a wrong order of
 * the legs.
 *
 * Near neutral the lengths about their means are l = J (G r + H r'). J is the Jacobian of a
 * drawing, r the reference about its mean and r' its rate. No loop follows exactly, so each axis
 * has a gain G of 0 or more and a lag H of either sign; an axis that lags by more than 45 degrees
 * may have a gain of either sign. The unexplained share of a drawing is the part of l that its
 * equation leaves, relative to the part that free gains for each leg could explain. It is 0 for the
 * true drawing, whatever the loop's gains and lags.
 *
 * Each order of the legs, each angle of a turn and each plane of a mirror is tried. The stated
 * drawing is refuted if one of them explains decisively more. Motion of other axes, or a reference
 * about another point, looks much like a turn if x and y do not move independently, as on a circle,
 * or phi and theta do not. Then the stated drawing is refuted only if it also leaves most of the
 * motion unexplained. Any thread, no heap. */
#ifndef HEXID_REFERENCE_MATCH_H
#define HEXID_REFERENCE_MATCH_H

#include "kinematics.h"

struct params;

enum { REFERENCE_MATCH_TEXT = 480 };

/* Sums of products over all samples. A reference length is a leg's length in the pose of the
 * reference, by the drawing. Lengths are taken about their means; in `mixed` the reference length
 * is taken about its value at neutral. */
struct leg_moments {
    double product[LEGS][LEGS]; /* measured length of one leg times reference length of another */
    double measured[LEGS];      /* squares of the measured lengths */
    double asked[LEGS][LEGS];   /* products of reference lengths */
    double late[LEGS][LEGS];    /* measured length of one leg times the rate of another's
                                 * reference */
    double mixed[LEGS][LEGS];   /* rate of one reference length times another reference length */
    double rates[LEGS][LEGS];   /* products of the rates of reference lengths */
};

extern const char *const reference_names[DOFS]; /* names of the reference's columns in a CSV file:
                                                 * "ref_x_m", ... */

struct reference_match {
    bool refuted;
    double stated, best; /* shares of the motion that the stated drawing, and the best one, leave
                          * unexplained; both 0 if the lengths do not follow the reference at all */
    char text[REFERENCE_MATCH_TEXT]; /* if refuted: what is wrong, and the remedy */
};

void reference_match_find(const struct params *params, const struct leg_moments *m, struct reference_match *match);

#endif
