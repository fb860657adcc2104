#include <signal.h>

#include "cli.h"
#include "device.h"
#include "params.h"
#include "process.h"
#include "realtime.h"

static _Atomic bool stop; /* global, because a signal handler has no other access */

static void on_signal(int signal) {
    (void)signal;
    atomic_store(&stop, true);
}

/* Requests real time, because a device must answer within microseconds. A refusal only causes a
 * warning, unless --rt require was given. */
static int become_realtime(const struct options *o, const struct params *params, struct error *error) {
    enum realtime_mode mode = o->rt_given ? o->rt : REALTIME_TRY;
    int status = realtime_enter(&params->loop, mode, error);
    if (!status || mode == REALTIME_REQUIRE) return status;
    cli_say(stderr, "hexid: warning: %s", error->text);
    return STATUS_OK;
}

int cmd_plant(int argc, char **argv) {
    const struct sigaction action = {.sa_handler = on_signal};
    struct options o;
    struct params params;
    struct error error = {0};
    struct device *device = NULL;
    realtime_heap();
    int status = options_parse(&o, argc, argv, "bcsrS", 0, &error);
    if (!status && !o.bus) status = error_set(&error, STATUS_USAGE, "plant: which bus? --bus can:IF; see `hexid plant --help`");
    if (!status) status = options_params(&o, &params, &error);
    if (!status && !(device = device_create(&params, o.seed, &error))) status = error.status;
    if (!status) {
        process_survive_readers();
        sigaction(SIGINT, &action, NULL);
        sigaction(SIGTERM, &action, NULL);
        status = become_realtime(&o, &params, &error);
        if (!status) status = device_serve(o.bus, &params, device, &stop, &error);
    }
    device_destroy(device);
    return status < 0 ? cli_fail(&error) : EXIT_PASSED;
}
