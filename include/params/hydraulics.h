/* Section `hydraulics` of the configuration (params.h). */
#ifndef HEXID_PARAMS_HYDRAULICS_H
#define HEXID_PARAMS_HYDRAULICS_H

#include "types.h"

struct hydraulics_params {
    double supply_pa, tank_pa;        /* gauge pressures */
    double valve_flow_m3_per_s[LEGS]; /* flow through each port at full opening and a pressure drop
                                       * of valve_drop_pa */
    double valve_drop_pa;
    double valve_frequency_hz, valve_damping[LEGS];
    double bulk_modulus_pa[LEGS];
    double dead_volume_m3[LEGS];      /* volume of the rodless chamber with the rod fully
                                       * retracted */
    double dead_volume_difference_m3[LEGS]; /* dead volume of the rod side less dead_volume_m3 */
    double leakage_m3_per_s_pa[LEGS]; /* leakage across the piston */
    double pipe_length_m, pipe_bore_m; /* length and bore of the pipe from each port of a valve,
                                        * where the pressure is measured, to its chamber */
    double viscous_n_s_per_m[LEGS];   /* viscous friction of the base model; the effect
                                       * cylinder_viscous_friction adds to it */
    double stop_stiffness_n_per_m, stop_damping_n_s_per_m; /* stiffness and damping of the end stops
                                                            * of the stroke */
};

#endif
