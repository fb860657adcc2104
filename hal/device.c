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
    int64_t lived_ns;     /* how far the machine has lived by the clock */
};

int64_t device_now_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * NS_PER_S + t.tv_nsec;
}

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

void device_latch(struct device *d, struct hal_sample *sample) { plant_measure(d->plant, sample); }

void device_live(struct device *d, int periods, const double valve[LEGS], int64_t now_ns) {
    memcpy(d->valve, valve, sizeof d->valve);
    d->commanded_ns = d->lived_ns = now_ns;
    for (int i = 0; i < periods; i++) plant_step(d->plant, d->valve);
}

bool device_tick(struct device *d, int64_t now_ns) {
    int64_t period_ns = ns_from_seconds(d->params->loop.period_s);
    bool silent = !d->commanded_ns || now_ns - d->commanded_ns > ns_from_seconds(d->watchdog_s);
    if (silent) memset(d->valve, 0, sizeof d->valve);
    if (now_ns - d->commanded_ns <= 2 * period_ns) return silent;
    if (now_ns - d->lived_ns > NS_PER_S) d->lived_ns = now_ns - period_ns; /* stopped or just started: nothing is caught up */
    for (; now_ns - d->lived_ns >= period_ns; d->lived_ns += period_ns) plant_step(d->plant, d->valve);
    return silent;
}

int device_serve(const char *url, const struct params *params, struct device *d, const _Atomic bool *stop, struct error *error) {
    for (int i = 0; device_buses[i]; i++) {
        size_t length = strlen(device_buses[i]->scheme);
        if (!strncmp(url, device_buses[i]->scheme, length) && url[length] == ':')
            return device_buses[i]->serve(url + length + 1, params, d, stop, error);
    }
    return error_set(error, STATUS_USAGE, "--bus %s: no such bus; `hexid plant --help` lists them", url);
}
