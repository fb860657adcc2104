/* The device side that `hexid plant` serves on either bus: the simulated machine behind sensors, valves and a watchdog.
 *
 * Time: the simulated machine lives by the clock, in whole periods of the loop, on a grid that follows the latches: what comes up to half a
 * period early or late meets the same instant, so that the figures do not carry the host's jitter; a latch that is left out does not hold
 * the machine up, and one that comes twice reads the same. Between two latches the command of the first is in force. All times are
 * CLOCK_MONOTONIC, of when a request came. */
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
void device_latch(struct device *d, int64_t now_ns, struct hal_sample *sample);

/* These commands are in force from now on; lives the period that begins, so that the next latch finds its readings ready. */
void device_live(struct device *d, const double valve[LEGS], int64_t now_ns);

/* SAFETY: call at least every millisecond. Without a device_live() the machine lives on with the valves of the last, and with the valves at
 * their centre when there was none for params->device.watchdog_s; true as long as that is so. */
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
