/* Readings of the machine's sensors (docs/method.md section 5). First the effects act on the exact
 * value (struct sensor_path: lag, delay, scale, offset); then lengths are rounded to steps of the
 * encoder, and pressures get noise and pass the converter. The same seed gives the same noise, bit
 * for bit, on every computer. RT after sensors_init(). */
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
    int kept, newest;  /* kept: number of instants in `past`, which are a substep apart; 0: no
                        * sensor has a delay. newest: index of the newest instant */
    struct exact *past;
};

/* Prepares the sensors; machine must outlive them. Returns 0, or -1 without memory. */
int sensors_init(struct sensors *s, const struct machine *machine, uint64_t seed);
void sensors_free(struct sensors *s);

/* Starts as if these values had been constant for all time before. */
void sensors_rest(struct sensors *s, const struct exact *exact);

/* Takes the exact values of the next substep. dt_s: duration of a substep. */
void sensors_follow(struct sensors *s, double dt_s, const struct exact *exact);

/* Reads the sensors at the instant of these exact values. If `history` is set, sensors_follow()
 * must have taken the same values before. */
void sensors_read(struct sensors *s, double dt_s, const struct exact *exact, struct exact *reading);

#endif
