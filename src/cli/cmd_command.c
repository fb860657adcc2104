/* `hexid command`: tells a running hexid what to do over LCM, and says what came of it. */
#include <errno.h>
#include <string.h>
#include <time.h>

#include "bus.h"
#include "cli.h"
#include "messages.h"
#include "supervisor.h"
#include "units.h"

enum { ANSWER_MS = 1000 };

/* hexid answers with an event of the kind "command" whose text begins with the command's name. */
struct answer {
    const char *command;
    bool given, refused;
};

static void heard(void *context, const char *channel, const void *data, int size) {
    struct answer *a = context;
    struct event e;
    size_t length = strlen(a->command);
    (void)channel;
    if (!event_decode(data, size, &e) || strcmp(e.kind, "command") || strncmp(e.text, a->command, length)) return;
    a->given = true;
    a->refused = e.text[length] != '\0';
    fprintf(a->refused ? stderr : stdout, "hexid: command %s\n", a->refused ? e.text : "received");
}

static int64_t now_ms(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000LL + t.tv_nsec / 1000000;
}

static int tell(struct bus *bus, enum command command, const char *url, struct error *error) {
    unsigned char buffer[COMMAND_MESSAGE_MAX];
    struct answer answer = {.command = command_names[command]};
    struct timespec now;
    if (bus_subscribe_raw(bus, CHANNEL_EVENT, heard, &answer)) return error_set(error, STATUS_IO, "command: cannot subscribe to answers");
    clock_gettime(CLOCK_REALTIME, &now);
    int size = command_encode(now.tv_sec * NS_PER_S + now.tv_nsec, command, buffer);
    if (bus_publish(bus, CHANNEL_COMMAND, buffer, size))
        return error_set(error, STATUS_IO, "command %s: not sent: %s", answer.command, strerror(errno));
    for (int64_t end_ms = now_ms() + ANSWER_MS, left_ms = ANSWER_MS; !answer.given && left_ms > 0; left_ms = end_ms - now_ms())
        if (bus_handle(bus, (int)left_ms) < 0) return error_set(error, STATUS_IO, "command %s: sent, but LCM is broken", answer.command);
    if (answer.refused) return STATUS_UNSAFE; /* the answer said why */
    return answer.given ? STATUS_OK : error_set(error, STATUS_IO, "command %s: nobody answered within %d ms: no hexid runs on %s",
                                                answer.command, ANSWER_MS, url);
}

int cmd_command(int argc, char **argv) {
    struct options o;
    struct error error = {0};
    struct params params;
    struct bus *bus;
    enum command command = COMMANDS;
    int status = options_parse(&o, argc, argv, "cS", 1, &error);
    for (int i = COMMAND_ENGAGE; !status && o.operands && i < COMMANDS; i++)
        if (!strcmp(o.operand[0], command_names[i])) command = (enum command)i;
    if (!status && command == COMMANDS) status = error_set(&error, STATUS_USAGE, "command: one of engage, start, stop, park, reset");
    if (!status) status = options_bus(&o, &params, &bus, &error);
    if (!status) {
        status = tell(bus, command, params.lcm.url, &error);
        bus_close(bus);
    }
    return status < 0 && error.status ? cli_fail(&error) : -status;
}
