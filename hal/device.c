#include "device.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "params.h"
#include "plant.h"
#include "units.h"

/* CATCH_UP_NS: longest time without a call that is simulated afterwards; a longer time is
 * skipped */
enum { CATCH_UP_NS = NS_PER_S / 10 };

struct device {
    const struct params *params;
    struct plant *plant;
    double valve[LEGS];
    double watchdog_s;
    int64_t centre_ns;  /* time at which the watchdog centres the valves */
    int64_t lived_ns;   /* time up to which the machine was simulated */
    struct hal_sample latched;
};

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
    if (d->plant) {
        if (params->interlocks.supply) plant_add_power_unit(d->plant, params->device.watchdog_s);
        return d;
    }
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
    /* SAFETY: without commands, the valves are centred. */
    if (d->lived_ns > d->centre_ns) memset(d->valve, 0, sizeof d->valve);
    plant_step(d->plant, d->valve);
    d->lived_ns += period_ns(d);
}

/* Simulates up to the period nearest to now. */
static void live_on(struct device *d, int64_t now_ns) {
    /* at the start, and after this process was stopped, the time that has passed is skipped */
    if (now_ns - d->lived_ns > CATCH_UP_NS) d->lived_ns = now_ns - period_ns(d);
    while (2 * (now_ns - d->lived_ns) >= period_ns(d)) live_period(d);
}

static bool ahead(const struct device *d, int64_t now_ns) { return 2 * (d->lived_ns - now_ns) > period_ns(d); }

bool device_latch(struct device *d, int64_t now_ns, struct hal_sample *sample) {
    live_on(d, now_ns);
    bool again = ahead(d, now_ns);
    if (!again) plant_measure(d->plant, &d->latched);
    *sample = d->latched;
    return !again;
}

void device_valves(struct device *d, const double valve[LEGS]) { memcpy(d->valve, valve, sizeof d->valve); }

void device_live(struct device *d, const struct hal_command *command, int64_t now_ns) {
    static const int64_t share = 16; /* each command shifts the grid by 1/share of its distance from
                                      * the grid */
    live_on(d, now_ns);
    device_valves(d, command->valve);
    plant_life_sign(d->plant, command->supply);
    d->centre_ns = now_ns + ns_from_seconds(d->watchdog_s);
    if (ahead(d, now_ns)) return;
    d->lived_ns += (now_ns - d->lived_ns) / share;
    live_period(d);
}

bool device_tick(struct device *d, int64_t now_ns) {
    live_on(d, now_ns);
    return now_ns > d->centre_ns;
}

int device_serve(const char *url, const struct params *params, struct device *d, const _Atomic bool *stop, struct error *error) {
    for (int i = 0; device_buses[i]; i++) {
        size_t length = strlen(device_buses[i]->scheme);
        if (!strncmp(url, device_buses[i]->scheme, length) && url[length] == ':')
            return device_buses[i]->serve(url + length + 1, params, d, stop, error);
    }
    return error_set(error, STATUS_USAGE, "--bus %s: no such bus; `hexid plant --help` lists them", url);
}
