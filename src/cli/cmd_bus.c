/* What talks to a running hexid over LCM: command and monitor. */
#include <errno.h>
#include <math.h>
#include <signal.h>
#include <string.h>
#include <time.h>

#include "bus.h"
#include "cli.h"
#include "messages.h"
#include "supervisor.h"
#include "units.h"

static int open_bus(const struct options *o, struct bus **bus, struct error *error) {
    struct params params;
    int status = options_params(o, &params, error);
    if (status) return status;
    if (!params.lcm.url[0]) return error_set(error, STATUS_USAGE, "lcm.url is empty: this configuration has no LCM");
    return bus_open(bus, params.lcm.url, error);
}

int cmd_command(int argc, char **argv) {
    struct options o;
    struct error error;
    struct bus *bus;
    unsigned char buffer[COMMAND_MESSAGE_MAX];
    struct timespec now;
    enum command command = COMMANDS;
    int status = options_parse(&o, argc, argv, "cS", 1, &error);
    for (int i = COMMAND_ENGAGE; !status && o.operands && i < COMMANDS; i++)
        if (!strcmp(o.operand[0], command_names[i])) command = (enum command)i;
    if (!status && command == COMMANDS) status = error_set(&error, STATUS_USAGE, "command: one of engage, start, stop, park, reset");
    if (!status) status = open_bus(&o, &bus, &error);
    if (status) return cli_fail(&error);
    clock_gettime(CLOCK_REALTIME, &now);
    int size = command_encode(now.tv_sec * NS_PER_S + now.tv_nsec, command, buffer);
    bool sent = bus_publish(bus, CHANNEL_COMMAND, buffer, size) == 0;
    bus_close(bus);
    if (sent) return EXIT_PASSED;
    error_set(&error, STATUS_IO, "command %s: not sent: %s", o.operand[0], strerror(errno));
    return cli_fail(&error);
}

static void show(void *context, const char *channel, const void *data, int size) {
    struct cycle c;
    struct event e;
    (void)context;
    if (!strcmp(channel, CHANNEL_STATE) && state_decode(data, size, &c)) {
        printf("%9.3f s  %-9s %-5s fault %-14s", seconds_from_ns(c.in.time_ns), state_names[c.state], c.dof < 0 ? "" : "test",
               fault_name(c.first_fault));
        for (int i = 0; i < 3; i++) printf(" %8.2f mm", c.pose[i] * 1e3);
        for (int i = 3; i < DOFS; i++) printf(" %7.2f mrad", c.pose[i] * 1e3);
        printf("\n");
    } else if (!strcmp(channel, CHANNEL_EVENT) && event_decode(data, size, &e)) {
        printf("%9.3f s  %s: %s\n", seconds_from_ns(e.time_ns), e.kind, e.text);
    } else {
        printf("             %s, %d bytes\n", channel, size);
    }
    fflush(stdout);
}

int cmd_monitor(int argc, char **argv) {
    struct options o;
    struct error error;
    struct bus *bus;
    int status = options_parse(&o, argc, argv, "cS", 0, &error);
    if (!status) status = open_bus(&o, &bus, &error);
    if (!status && (status = bus_subscribe_raw(bus, "HEXID_.*", show, NULL)))
        error_set(&error, STATUS_IO, "monitor: cannot subscribe");
    while (!status && (status = bus_handle(bus, 1000)) >= 0) status = 0;
    return cli_fail(&error);
}
