/* Section `payload` of the configuration (params.h). */
#ifndef HEXID_PARAMS_PAYLOAD_H
#define HEXID_PARAMS_PAYLOAD_H

struct payload_params {           /* the platform with its load, Tian 2015 Table 2 */
    double mass_kg;
    /* entries of the payload's inertia matrix about its mass centre */
    double inertia_xx_kg_m2, inertia_yy_kg_m2, inertia_zz_kg_m2;
    double inertia_xy_kg_m2, inertia_xz_kg_m2, inertia_yz_kg_m2;
    double center_height_m;       /* h: height of the mass centre above the upper joint plane */
    double center_x_m, center_y_m;/* x and y of the mass centre in the platform's drawing */
    double gravity_mps2;
};

#endif
