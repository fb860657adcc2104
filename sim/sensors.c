#include "sensors.h"

#include <math.h>

void sensors_init(struct sensors *s, const struct sensor_params *params, uint64_t seed) {
    double pa_per_volt = params->pressure_full_scale_pa / params->adc_range_v;
    *s = (struct sensors){
        .params = params,
        .step_pa = 2.0 * params->pressure_full_scale_pa / exp2(round(params->adc_bits)),
        .noise_pa = params->pressure_noise_v * pa_per_volt,
        .random = seed,
    };
}

double sensors_length(const struct sensors *s, double length_m) {
    double step_m = s->params->position_resolution_m;
    return s->params->enabled && step_m > 0.0 ? step_m * round(length_m / step_m) : length_m;
}

/* splitmix64 (Steele, Lea, Flood 2014), top 53 bits: uniform in -0.5 <= x < 0.5. */
static double uniform(uint64_t *state) {
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53 - 0.5;
}

/* Codes of an n-bit converter: -2^(n-1) .. 2^(n-1)-1; beyond them it saturates. */
double sensors_pressure(struct sensors *s, double pressure_pa) {
    if (!s->params->enabled) return pressure_pa;
    double full = s->params->pressure_full_scale_pa;
    double code = round((pressure_pa + s->noise_pa * uniform(&s->random)) / s->step_pa);
    double top = full / s->step_pa - 1.0, bottom = -full / s->step_pa;
    return s->step_pa * fmin(fmax(code, bottom), top);
}
