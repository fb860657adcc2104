/* Readings of the machine's sensors (docs/method.md section 5): first the effects on the exact
 * value (machine.h's sensor_path: lag, delay, scale, offset), then lengths in steps of the encoder,
 * pressures with noise through the converter. The generator is seeded: the same seed gives the same
 * noise, bit for bit, on every machine. RT after sensors_init. */
#ifndef HEXID_SENSORS_H
#define HEXID_SENSORS_H

#include "machine.h"

struct sensor_params;

/* Exact values of the measured quantities at one instant. */
struct exact {
    double length_m[LEGS], p1_pa[LEGS], p2_pa[LEGS];
};

struct sensors {
    const struct machine *machine;
    const struct sensor_params *params;
    double step_pa;    /* pressure that corresponds to one step of the converter */
    double noise_pa;   /* peak-to-peak noise of a pressure */
    uint64_t random;   /* state of the random generator splitmix64 */
    bool history;      /* a sensor has a lag or a delay, so that sensors_follow() is needed */
    struct exact lagged, last;
    int kept, newest;  /* number of instants in `past`, a substep apart (0: no sensor has a delay),
                        * and the index of the newest */
    struct exact *past;
};

/* Prepares the sensors; machine must outlive them. Returns 0, or -1 without memory. */
int sensors_init(struct sensors *s, const struct machine *machine, uint64_t seed);
void sensors_free(struct sensors *s);

/* Starts as if the machine had had these values for all time before. */
void sensors_rest(struct sensors *s, const struct exact *exact);

/* Takes the exact values, which are one substep later than the previous ones. */
void sensors_follow(struct sensors *s, double dt_s, const struct exact *exact);

/* Reads the sensors at the instant of the exact values. With a history, sensors_follow() must have
 * taken these values before. */
void sensors_read(struct sensors *s, double dt_s, const struct exact *exact, struct exact *reading);

#endif
