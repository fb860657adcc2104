/* The device side that `hexid plant` serves on either bus: the simulated machine behind sensors,
 * valves and a watchdog.
 *
 * Time: the simulated machine lives by the clock, in whole periods of the loop, on a grid that
 * follows the commands: what comes less than half a period early or late meets the same
 * instant, so that the figures do not carry the host's jitter; one that is left out does not
 * hold the machine up, and one that comes twice takes no time. All times are CLOCK_MONOTONIC
 * and must not decrease. */
#ifndef HEXID_DEVICE_H
#define HEXID_DEVICE_H

#include <stdatomic.h>

#include "params.h"
#include "status.h"

struct device;

/* params must outlive the device. */
struct device *device_create(const struct params *params, uint64_t seed, struct error *error);
void device_destroy(struct device *d);

/* Lengths, pressures and inputs of the period nearest to now, all at once; fills arrays and inputs
 * of the sample. False: that has been read and its commands given, by the same request or by a late
 * one right before this; the same readings again. */
bool device_latch(struct device *d, int64_t now_ns, struct hal_sample *sample);

/* A command, charge pump and valves, in force from the period nearest to now on; lives that
 * period, so that the next latch finds its readings ready. Where device_latch() was false: from
 * the next one on. */
void device_live(struct device *d, const struct hal_command *command, int64_t now_ns);

/* The valves as they stand, where nobody commanded: a node has centred its own. */
void device_valves(struct device *d, const double valve[LEGS]);

/* SAFETY: call at least every millisecond. Without a device_live() the machine lives on with the
 * valves of the last; when there was none for params->device.watchdog_s, with the valves at their
 * centre; true as long as that is so. */
bool device_tick(struct device *d, int64_t now_ns);

/* In place of params->device.watchdog_s, where the daemon sets it over the bus; counts from the
 * next command on. */
void device_set_watchdog(struct device *d, double watchdog_s);

/* One bus: serves the device there until *stop. Prints the line "ready" when commands are answered.
 * The address is the URL after "scheme:". */
struct device_bus {
    const char *scheme, *usage;
    int (*serve)(const char *address, const struct params *params, struct device *d, const _Atomic bool *stop, struct error *error);
};

/* All buses, ended by NULL. */
extern const struct device_bus *const device_buses[];

/* Finds the bus of the URL and serves. */
int device_serve(const char *url, const struct params *params, struct device *d, const _Atomic bool *stop, struct error *error);

#endif
