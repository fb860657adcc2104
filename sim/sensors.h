/* What the machine's sensors report (method.md section 5): lengths in steps of the encoder, pressures with noise through the converter.
 * Own seeded generator: the same seed gives the same noise, bit for bit, on every machine. RT. */
#ifndef HEXID_SENSORS_H
#define HEXID_SENSORS_H

#include "params.h"

struct sensors {
    const struct sensor_params *params;
    double step_pa;    /* of the converter */
    double noise_pa;   /* peak to peak */
    uint64_t random;   /* splitmix64 */
};

/* params must outlive the sensors. */
void sensors_init(struct sensors *s, const struct sensor_params *params, uint64_t seed);

/* Disabled: the exact values. */
double sensors_length(const struct sensors *s, double length_m);
double sensors_pressure(struct sensors *s, double pressure_pa);

#endif
