/* Section `sensors` of the configuration (params.h). */
#ifndef HEXID_PARAMS_SENSORS_H
#define HEXID_PARAMS_SENSORS_H

#include <stdbool.h>

struct sensor_params {            /* sensors, real or simulated */
    bool enabled;                 /* false: the readings are exact, without rounding and noise */
    double position_resolution_m;
    double adc_bits, adc_range_v; /* bits of the converter over its range, -adc_range_v to
                                   * adc_range_v */
    double pressure_full_scale_pa;/* pressure at which the sensor gives adc_range_v */
    double pressure_noise_v;      /* noise of the pressure reading, uniform, peak to peak */
};

#endif
