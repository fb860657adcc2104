/* What the machine's sensors report (docs/method.md section 5): what effects make of the exact
 * value (machine.h's sensor_path: lag, delay, scale, offset), then lengths in steps of the encoder,
 * pressures with noise through the converter. Own seeded generator: the same seed gives the same
 * noise, bit for bit, on every machine. RT after sensors_init. */
#ifndef HEXID_SENSORS_H
#define HEXID_SENSORS_H

#include "machine.h"

/* The exact values at an instant. */
struct exact {
    double length_m[LEGS], p1_pa[LEGS], p2_pa[LEGS];
};

struct sensors {
    const struct machine *machine;
    const struct sensor_params *params;
    double step_pa;    /* of the converter */
    double noise_pa;   /* peak to peak */
    uint64_t random;   /* splitmix64 */
    bool history;      /* some path has lag or delay: sensors_follow is needed */
    struct exact lagged, last;
    int kept, newest;  /* instants of a substep each, for delays */
    struct exact *past;
};

/* machine must outlive the sensors. Returns 0, or -1 without memory. */
int sensors_init(struct sensors *s, const struct machine *machine, uint64_t seed);
void sensors_free(struct sensors *s);

/* The machine has been at these values for ever. */
void sensors_rest(struct sensors *s, const struct exact *exact);

/* A substep later. */
void sensors_follow(struct sensors *s, double dt_s, const struct exact *exact);

/* The readings at the instant of the exact values, the last ones followed where
 * there is a history. */
void sensors_read(struct sensors *s, double dt_s, const struct exact *exact, struct exact *reading);

#endif
