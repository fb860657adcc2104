/* Scaling between raw values of a field bus and SI (params/field.h). Pure, RT. */
#ifndef HEXID_CHANNEL_H
#define HEXID_CHANNEL_H

#include <stdint.h>

struct channel_params;

/* Raw value for a missing reading or command: the most negative value of the width; it decodes to
 * NAN. */
#define CHANNEL_NONE_16 INT16_MIN
#define CHANNEL_NONE_32 INT32_MIN

/* Returns the SI value of a raw value for leg 0..5; NAN if raw is NAN or the value is
 * implausible. */
double channel_si(const struct channel_params *c, int leg, double raw);

/* Returns the raw value nearest to si, at most `limit` in magnitude; -limit-1 (none) if si is NAN.
 * Plausibility is checked only by the receiver. */
int32_t channel_raw(const struct channel_params *c, int leg, double si, int32_t limit);

/* Convert raw values of 16 and 32 bit from the bus to numbers; NAN for a missing reading. */
static inline double channel_from_16(int16_t raw) { return raw == CHANNEL_NONE_16 ? (double)__builtin_nan("") : (double)raw; }
static inline double channel_from_32(int32_t raw) { return raw == CHANNEL_NONE_32 ? (double)__builtin_nan("") : (double)raw; }

#endif
