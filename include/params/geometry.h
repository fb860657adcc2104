/* Section `geometry` of the configuration (params.h). */
#ifndef HEXID_PARAMS_GEOMETRY_H
#define HEXID_PARAMS_GEOMETRY_H

#include "types.h"

/* One vector for each leg, in the coordinates of the drawing. */
struct leg_vectors {
    bool given;
    double leg[LEGS][3];
};

struct geometry_params {          /* geometry of the legs' joints, Tian 2015 Table 1 */
    double upper_radius_m;        /* radius of the circle of the upper joints, Ra */
    double lower_radius_m;        /* radius of the circle of the lower joints, Rb */
    double height_m;              /* H: height of the upper joint plane (z = 0 in the platform's
                                   * drawing) over the lower one (z = 0 in the base's), at neutral;
                                   * negative: the platform hangs */
    double upper_half_angle_rad;  /* half the angle between the two upper joints of a pair, alpha */
    double lower_half_angle_rad;  /* half the angle between the two lower joints of a pair, beta */
    /* The coordinates below are those of the drawings of platform and base: x forward, y right, z
     * down. */
    struct leg_vectors upper, lower; /* positions of the joints, m; if not given, they are on a
                                      * circle, by the radii and angles above */
    struct leg_vectors upper_axis, lower_axis; /* direction of each universal joint's axis that is
                                                * fixed in platform or base, as a vector of any
                                                * length; if not given, the axis is level and
                                                * tangential to the joint circle */
};

#endif
