/* Section `actuator` of the configuration (params.h). */
#ifndef HEXID_PARAMS_ACTUATOR_H
#define HEXID_PARAMS_ACTUATOR_H

#include "types.h"

struct actuator_params {          /* the legs, Tian 2015 Tables 1 and 2; inertias about each part's
                                   * own mass centre (docs/method.md, 3) */
    double piston_diameter_m[LEGS], rod_diameter_m[LEGS];
    struct {
        bool piston, rod;
    } stated;                     /* the configuration states the diameter; false only on a machine
                                   * of one axis, where the built-in value is that of a platform */
    double stroke_m[LEGS];
    double mid_stroke_m[LEGS];    /* leg length at mid-stroke less leg length at neutral */
    /* length of each leg on its lower end stop, as measured on the machine, and the standard
     * deviation of these lengths; retracted_std_m 0: not measured */
    double retracted_m[LEGS], retracted_std_m;
    double upper_mass_kg[LEGS], lower_mass_kg[LEGS];      /* masses of rod (ma) and cylinder (mb) */
    double upper_inertia_kg_m2[LEGS], lower_inertia_kg_m2[LEGS]; /* transverse moments of inertia of
                                                                  * rod (ia) and cylinder (ib) */
    /* distance of the rod's mass centre from the upper joint (ra), and of the cylinder's from the
     * lower joint (rb) */
    double upper_center_m[LEGS], lower_center_m[LEGS];
};

#endif
