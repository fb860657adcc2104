#include "device.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "plant.h"
#include "units.h"

struct device {
    const struct params *params;
    struct plant *plant;
    double valve[LEGS];
    double watchdog_s;
    int64_t commanded_ns; /* last device_live(), 0: none yet */
    int64_t lived_ns;     /* up to when the machine has lived */
    struct hal_sample latched;
};

int64_t device_now_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * NS_PER_S + t.tv_nsec;
}

static int64_t period_ns(const struct device *d) { return ns_from_seconds(d->params->loop.period_s); }

struct device *device_create(const struct params *params, uint64_t seed, struct error *error) {
    struct device *d = calloc(1, sizeof *d);
    if (!d) {
        error_set(error, STATUS_IO, "plant: out of memory");
        return NULL;
    }
    d->params = params;
    d->watchdog_s = params->device.watchdog_s;
    d->plant = plant_create(params, seed, error);
    if (d->plant) return d;
    free(d);
    return NULL;
}

void device_destroy(struct device *d) {
    if (!d) return;
    plant_destroy(d->plant);
    free(d);
}

void device_set_watchdog(struct device *d, double watchdog_s) { d->watchdog_s = watchdog_s; }

static void live_period(struct device *d) {
    /* SAFETY: nobody commands, the valves are centred. */
    if (d->lived_ns - d->commanded_ns > ns_from_seconds(d->watchdog_s)) memset(d->valve, 0, sizeof d->valve);
    plant_step(d->plant, d->valve);
    d->lived_ns += period_ns(d);
}

/* Up to the period nearest to this time. */
static void live_on(struct device *d, int64_t until_ns) {
    /* This process was stopped or has just started, or the clock was set: nothing is caught up. */
    if (llabs(until_ns - d->lived_ns) > NS_PER_S) d->lived_ns = until_ns - period_ns(d);
    while (2 * (until_ns - d->lived_ns) >= period_ns(d)) live_period(d);
}

/* The period that begins now has been lived already: the same request once more. */
static bool ahead(const struct device *d, int64_t now_ns) { return 2 * (d->lived_ns - now_ns) > period_ns(d); }

void device_latch(struct device *d, int64_t now_ns, struct hal_sample *sample) {
    live_on(d, now_ns);
    if (!ahead(d, now_ns)) plant_measure(d->plant, &d->latched);
    *sample = d->latched;
}

void device_live(struct device *d, const double valve[LEGS], int64_t now_ns) {
    static const int64_t share = 16; /* of what is early or late by which the grid follows */
    live_on(d, now_ns);
    memcpy(d->valve, valve, sizeof d->valve);
    d->commanded_ns = now_ns;
    if (ahead(d, now_ns)) return;
    d->lived_ns += (now_ns - d->lived_ns) / share;
    live_period(d);
}

bool device_tick(struct device *d, int64_t now_ns) {
    live_on(d, now_ns - period_ns(d)); /* a period later than it could: a request may have come and not been read yet */
    return now_ns - d->commanded_ns > ns_from_seconds(d->watchdog_s);
}

int device_serve(const char *url, const struct params *params, struct device *d, const _Atomic bool *stop, struct error *error) {
    for (int i = 0; device_buses[i]; i++) {
        size_t length = strlen(device_buses[i]->scheme);
        if (!strncmp(url, device_buses[i]->scheme, length) && url[length] == ':')
            return device_buses[i]->serve(url + length + 1, params, d, stop, error);
    }
    return error_set(error, STATUS_USAGE, "--bus %s: no such bus; `hexid plant --help` lists them", url);
}
