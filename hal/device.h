/* The device side that `hexid plant` serves on either bus: the simulated machine behind sensors, valves and a watchdog.
 *
 * Time: the simulated machine lives one period of the loop with every latch, so that the figures do not carry the host's jitter; when no
 * latch has come for two periods it lives on by the clock. A command acts from the latch at which it is applied to the next one. */
#ifndef HEXID_DEVICE_H
#define HEXID_DEVICE_H

#include <stdatomic.h>

#include "params.h"
#include "status.h"

struct device;

/* params must outlive the device. */
struct device *device_create(const struct params *params, uint64_t seed, struct error *error);
void device_destroy(struct device *d);

/* Lengths and pressures of this instant, all at once; fills the arrays of the sample. */
void device_latch(struct device *d, struct hal_sample *sample);

/* Lives `periods` periods of the loop with these commands, which stay in force. */
void device_live(struct device *d, int periods, const double valve[LEGS], int64_t now_ns);

/* SAFETY: call at least every millisecond. Without a device_live() for two periods it lives on by the clock, with the valves of the last;
 * without one for params->device.watchdog_s with the valves at their centre, and returns true as long as that is so. */
bool device_tick(struct device *d, int64_t now_ns);

/* In place of params->device.watchdog_s, where the daemon sets it over the bus. */
void device_set_watchdog(struct device *d, double watchdog_s);

/* CLOCK_MONOTONIC. */
int64_t device_now_ns(void);

/* One bus: serves the device there until *stop. Prints the line "ready" when commands are answered. The address is the URL after
 * "scheme:". */
struct device_bus {
    const char *scheme, *usage;
    int (*serve)(const char *address, const struct params *params, struct device *d, const _Atomic bool *stop, struct error *error);
};

/* All buses, ended by NULL. */
extern const struct device_bus *const device_buses[];

/* Finds the bus of the URL and serves. */
int device_serve(const char *url, const struct params *params, struct device *d, const _Atomic bool *stop, struct error *error);

#endif
