/* Section `axis` of the configuration (params.h). */
#ifndef HEXID_PARAMS_AXIS_H
#define HEXID_PARAMS_AXIS_H

struct axis_params {              /* cylinder or electric axis with a mass; its only leg has index
                                   * 0 */
    double mass_kg;               /* mass of all moving parts */
    double gravity_mps2;          /* gravity along the axis; positive: the weight pushes the rod
                                   * in */
    double middle_m;              /* position reading at mid-stroke */
    double force_offset_n;    /* constant error of the force reading; positive: it reads too much */
    double force_lag_s;     /* time constant of the first-order lag of a force sensor's amplifier */
};

#endif
