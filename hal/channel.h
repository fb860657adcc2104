/* Scaling between what a field bus carries and SI (params.h, struct channel_params). Pure, RT. */
#ifndef HEXID_CHANNEL_H
#define HEXID_CHANNEL_H

#include <stdint.h>

#include "params.h"

/* What a device sends for a reading that it does not have: the most negative value of the width.
 * It decodes to NAN. */
#define CHANNEL_NONE_16 INT16_MIN
#define CHANNEL_NONE_32 INT32_MIN

/* SI value of leg 0..5, NAN when raw is NAN or the value is not plausible. */
double channel_si(const struct channel_params *c, int leg, double raw);

/* The nearest raw value of at most `limit` in size, -limit-1 (none) when si is NAN. No
 * plausibility: that is the receiver's to judge. */
int32_t channel_raw(const struct channel_params *c, int leg, double si, int32_t limit);

/* Raw values of 16 and 32 bit as the bus carries them, NAN for none. */
static inline double channel_from_16(int16_t raw) { return raw == CHANNEL_NONE_16 ? (double)__builtin_nan("") : (double)raw; }
static inline double channel_from_32(int32_t raw) { return raw == CHANNEL_NONE_32 ? (double)__builtin_nan("") : (double)raw; }

#endif
