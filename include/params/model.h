/* Section `model` of the configuration (params.h). */
#ifndef HEXID_PARAMS_MODEL_H
#define HEXID_PARAMS_MODEL_H

struct tolerance_params {         /* tolerances of the model's parameters that hexid gap does not
                                   * count as a finding; relative, but for joints and springs */
    double mass;                  /* tolerance of every mass and inertia */
    double viscous, bulk_modulus, leakage, valve_gain;
    double joints_m;              /* tolerance of each coordinate of a joint */
    double springs_n_per_m, springs_nm_per_rad; /* stiffness of hoses and cables, on x, y, z and on
                                                 * the angles */
};

struct model_params {
    struct tolerance_params tolerance;
};

#endif
