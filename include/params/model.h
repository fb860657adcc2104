/* Section `model` of the configuration (params.h). */
#ifndef HEXID_PARAMS_MODEL_H
#define HEXID_PARAMS_MODEL_H

struct tolerance_params {         /* deviations of the model's parameters up to which `hexid gap`
                                   * reports no finding; relative to the parameter unless the name
                                   * has a unit */
    double mass;                  /* tolerance of every mass and inertia */
    double viscous, bulk_modulus, leakage, valve_gain;
    double rigidity;              /* standard deviation of the inertia matrix from that of a rigid
                                   * payload, as a share of sqrt(M_ii M_jj) */
    double joints_m;              /* tolerance of each coordinate of a joint */
    /* standard deviations of systematic errors (src/residual/systematic.h); gains without unit */
    double pressure_zero; /* standard deviation of a pressure's zero, as a share of
                           * sensors.pressure_full_scale_pa */
    double pressure_drift_pa; /* standard deviation of a pressure's zero between logs */
    double pressure_gain, length_gain, length_zero_m, skew_s, pressure_lag_s, pipe_m;
    double compliance_m_per_n;
    double skew_test_s; /* largest standard deviation of a test's own skew from the skew common to
                         * all tests */
    double springs_n_per_m, springs_nm_per_rad; /* largest stiffness of hoses and cables against x,
                                                 * y, z and against the angles; 0: there are none */
};

struct model_params {
    struct tolerance_params tolerance;
};

#endif
