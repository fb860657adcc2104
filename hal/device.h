/* The device that `hexid plant` serves on either bus: the simulated machine with sensors, valves
 * and a watchdog.
 *
 * Time: the simulated machine follows the clock in whole periods of the loop, on a grid that
 * follows the commands. A command that is less than half a period early or late counts as on time,
 * so that jitter of the host does not show in the results. The machine goes on if a command is
 * missing, and a second command in one period does not advance it. All times are CLOCK_MONOTONIC
 * and must not decrease. */
#ifndef HEXID_DEVICE_H
#define HEXID_DEVICE_H

#include <stdatomic.h>
#include <stdbool.h>

#include "status.h"
#include "types.h"

struct params;
struct device;

/* Creates a device; params must outlive it. */
struct device *device_create(const struct params *params, uint64_t seed, struct error *error);
void device_destroy(struct device *d);

/* Latches lengths, pressures and inputs of the period nearest to now, and fills in the arrays and
 * the inputs of the sample. If device_live() has already simulated this period, returns false, with
 * the previous readings: either this request is a repetition, or the previous one came late. */
bool device_latch(struct device *d, int64_t now_ns, struct hal_sample *sample);

/* Applies a command (supply output and valves; `enable` is ignored) from the period nearest to now
 * on, and simulates that period, so that its readings are ready for the next latch. After a
 * device_latch() that returned false, the command acts from the next period on. */
void device_live(struct device *d, const struct hal_command *command, int64_t now_ns);

/* Sets the valves, -1..1, without restarting the watchdog; for valves that a bus or its nodes have
 * centred. */
void device_valves(struct device *d, const double valve[LEGS]);

/* SAFETY: advances the machine; to be called at least every millisecond. Without a call of
 * device_live() the valves keep their openings until the watchdog's time is over, and are then
 * centred. Returns true while the watchdog keeps them centred. */
bool device_tick(struct device *d, int64_t now_ns);

/* Sets the watchdog's time, which at first is params->device.watchdog_s; the new time applies from
 * the next command on. */
void device_set_watchdog(struct device *d, double watchdog_s);

/* A bus on which a device can be served. serve() runs until *stop, and prints a line "plant: ready
 * on ..." when commands are answered. address: part of the URL after "scheme:". */
struct device_bus {
    const char *scheme, *usage;
    int (*serve)(const char *address, const struct params *params, struct device *d, const _Atomic bool *stop, struct error *error);
};

/* All buses on which a device can be served; ended by NULL. */
extern const struct device_bus *const device_buses[];

/* Serves the device on the URL's bus; STATUS_USAGE if no bus has its scheme. */
int device_serve(const char *url, const struct params *params, struct device *d, const _Atomic bool *stop, struct error *error);

#endif
