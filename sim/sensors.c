#include "sensors.h"

#include <math.h>
#include <stdlib.h>

#include "params.h"

/* the kinds are lengths, pressures P1, pressures P2 */
enum { KINDS = 3, VALUES = KINDS * LEGS };
_Static_assert(sizeof(struct exact) == VALUES * sizeof(double), "struct exact is walked as an array");

static double *values(struct exact *e) { return (double *)e; }
static const double *const_values(const struct exact *e) { return (const double *)e; }

static const struct sensor_path *path(const struct sensors *s, int i) {
    const struct sensor_path *const kind[KINDS] = {s->machine->sensors.length, s->machine->sensors.p1, s->machine->sensors.p2};
    return &kind[i / LEGS][i % LEGS];
}

int sensors_init(struct sensors *s, const struct machine *machine, uint64_t seed) {
    const struct params *params = machine->params;
    const struct sensor_params *p = &params->sensors;
    double substep_s = params->loop.period_s / params->sim.substeps, longest_s = 0.0;
    *s = (struct sensors){
        .machine = machine,
        .params = p,
        .step_pa = 2.0 * p->pressure_full_scale_pa / exp2(round(p->adc_bits)),
        .noise_pa = p->pressure_noise_v * (p->pressure_full_scale_pa / p->adc_range_v),
        .random = seed,
    };
    for (int i = 0; i < VALUES; i++) {
        s->history = s->history || path(s, i)->lag_s > 0.0 || path(s, i)->delay_s > 0.0;
        longest_s = fmax(longest_s, path(s, i)->delay_s);
    }
    if (!(longest_s > 0.0)) return 0;
    s->kept = (int)ceil(longest_s / substep_s) + 2;
    s->past = calloc((size_t)s->kept, sizeof *s->past);
    return s->past ? 0 : -1;
}

void sensors_free(struct sensors *s) { free(s->past); }

void sensors_rest(struct sensors *s, const struct exact *exact) {
    s->lagged = s->last = *exact;
    for (int i = 0; i < s->kept; i++) s->past[i] = *exact;
}

/* Returns the output of a first-order lag, exact for an input that changes linearly over the
 * step. */
static double lagged(double before, double from, double to, double lag_s, double dt_s) {
    /* trail: steady-state distance of the output behind a ramp, slope times lag_s */
    double left = exp(-dt_s / lag_s), trail = (to - from) * lag_s / dt_s;
    return to - trail + (before - from + trail) * left;
}

void sensors_follow(struct sensors *s, double dt_s, const struct exact *exact) {
    for (int i = 0; i < VALUES; i++) {
        double lag_s = path(s, i)->lag_s, from = const_values(&s->last)[i], to = const_values(exact)[i], *now = &values(&s->lagged)[i];
        *now = lag_s > 0.0 ? lagged(*now, from, to, lag_s, dt_s) : to;
    }
    s->last = *exact;
    if (s->kept == 0) return;
    s->newest = (s->newest + 1) % s->kept;
    s->past[s->newest] = s->lagged;
}

/* Returns the value delay_s earlier, interpolated linearly between substeps. */
static double delayed(const struct sensors *s, int i, double delay_s, double dt_s) {
    double ago = delay_s / dt_s, whole = floor(ago), part = ago - whole;
    int later = (s->newest - (int)whole + 2 * s->kept) % s->kept, earlier = (later - 1 + s->kept) % s->kept;
    return (1.0 - part) * const_values(&s->past[later])[i] + part * const_values(&s->past[earlier])[i];
}

static double in_steps(const struct sensors *s, double length_m) {
    double step_m = s->params->position_resolution_m;
    return s->params->enabled && step_m > 0.0 ? step_m * round(length_m / step_m) : length_m;
}

/* Returns a random number, uniform in -0.5 <= x < 0.5: the top 53 bits of splitmix64 (Steele, Lea,
 * Flood 2014). */
static double uniform(uint64_t *state) {
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53 - 0.5;
}

/* Passes a pressure through the converter. An n-bit converter has the codes -2^(n-1) .. 2^(n-1)-1,
 * and saturates at the first and the last. */
static double through_converter(struct sensors *s, double pressure_pa) {
    if (!s->params->enabled) return pressure_pa;
    double full = s->params->pressure_full_scale_pa;
    double code = round((pressure_pa + s->noise_pa * uniform(&s->random)) / s->step_pa);
    double top = full / s->step_pa - 1.0, bottom = -full / s->step_pa;
    return s->step_pa * fmin(fmax(code, bottom), top);
}

void sensors_read(struct sensors *s, double dt_s, const struct exact *exact, struct exact *reading) {
    for (int k = 0; k < LEGS; k++) { /* leg by leg: the order in which noise is drawn must stay */
        for (int kind = 0; kind < KINDS; kind++) {
            int i = kind * LEGS + k;
            const struct sensor_path *p = path(s, i);
            double x = p->delay_s > 0.0 ? delayed(s, i, p->delay_s, dt_s) : p->lag_s > 0.0 ? values(&s->lagged)[i] : const_values(exact)[i];
            x = p->scale * x + p->offset;
            values(reading)[i] = kind == 0 ? in_steps(s, x) : through_converter(s, x);
        }
    }
}
