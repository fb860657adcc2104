/* Section `sim` of the configuration (params.h). */
#ifndef HEXID_PARAMS_SIM_H
#define HEXID_PARAMS_SIM_H

enum engine_kind { ENGINE_ODE, ENGINE_CLOSED_FORM };

struct sim_params {
    enum engine_kind engine;
    int substeps;                 /* integration steps per cycle; each must be at most 0.25 ms
                                   * long */
    double base_hz, base_mass_kg; /* base_hz: natural frequency of the base together with all that
                                   * it carries, on the base's springs; base_mass_kg: mass of the
                                   * base alone (sim/surroundings.h). 0 Hz: the base is rigid.
                                   * ENGINE_ODE only */
    double ripple_pa, ripple_hz;  /* amplitude and frequency of the pump's pressure ripple;
                                   * ENGINE_ODE only */
    double smooth_friction_mps;   /* speed v0 of a friction without stick, F tanh(v / v0), in the
                                   * cylinders; 0: dry friction sticks; ENGINE_CLOSED_FORM only */
};

#endif
