#include "bus.h"

#include <arpa/inet.h>
#include <errno.h>
#include <lcm/lcm.h>
#include <stdlib.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "messages.h"

enum { QUEUE_CAPACITY = 1000 }; /* messages; liblcm's 30 lose some whenever the reader stalls */

struct bus {
    lcm_t *lcm;
    bus_callback *callback;
    void *context;
    bus_command_callback *command_callback;
    void *command_context;
};

static int refuse(const char *url, struct error *error) {
    if (strncmp(url, "udpm:", 5) == 0)
        return error_set(error, STATUS_IO, "LCM cannot use %.128s: most likely there is no route for multicast; "
                         "`ip link set lo multicast on; ip route add 224.0.0.0/4 dev lo` makes one on this host", url);
    return error_set(error, STATUS_IO, "LCM cannot use \"%.128s\"; give one like udpm://239.255.76.67:7667?ttl=0 (lcm.url)", url);
}

/* liblcm without a route prints a page of its own: asked first, it need not. URLs that are not of this form are for liblcm to judge. */
static bool no_route(const char *url) {
    char host[16];
    struct sockaddr_in group = {.sin_family = AF_INET};
    unsigned short port;
    if (sscanf(url, "udpm://%15[0-9.]:%hu", host, &port) != 2 || inet_pton(AF_INET, host, &group.sin_addr) != 1) return false;
    group.sin_port = htons(port);
    int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    bool unreachable = probe >= 0 && connect(probe, (const struct sockaddr *)&group, sizeof group) && errno == ENETUNREACH;
    if (probe >= 0) close(probe);
    return unreachable;
}

int bus_open(struct bus **bus, const char *url, struct error *error) {
    struct bus *b = calloc(1, sizeof *b);
    *bus = NULL;
    if (!b) return error_set(error, STATUS_IO, "out of memory");
    b->lcm = url[0] && !no_route(url) ? lcm_create(url) : NULL; /* liblcm would take an empty one for its default */
    if (!b->lcm) {
        free(b);
        return refuse(url, error);
    }
    *bus = b;
    return STATUS_OK;
}

void bus_close(struct bus *b) {
    lcm_destroy(b->lcm);
    free(b);
}

int bus_publish(struct bus *b, const char *channel, const void *data, int size) {
    return size >= 0 && lcm_publish(b->lcm, channel, data, (unsigned)size) == 0 ? 0 : -1;
}

static int subscribe(struct bus *b, const char *channel, lcm_msg_handler_t handler) {
    lcm_subscription_t *s = lcm_subscribe(b->lcm, channel, handler, b);
    return s && lcm_subscription_set_queue_capacity(s, QUEUE_CAPACITY) == 0 ? STATUS_OK : STATUS_IO;
}

static void received(const lcm_recv_buf_t *message, const char *channel, void *user) {
    struct bus *b = user;
    b->callback(b->context, channel, message->data, (int)message->data_size);
}

static void command_received(const lcm_recv_buf_t *message, const char *channel, void *user) {
    struct bus *b = user;
    enum command command;
    (void)channel;
    if (command_decode(message->data, (int)message->data_size, &command)) b->command_callback(b->command_context, command);
}

int bus_subscribe_raw(struct bus *b, const char *channel_regex, bus_callback *callback, void *context) {
    b->callback = callback;
    b->context = context;
    return subscribe(b, channel_regex, received);
}

int bus_subscribe_commands(struct bus *b, bus_command_callback *callback, void *context) {
    b->command_callback = callback;
    b->command_context = context;
    return subscribe(b, CHANNEL_COMMAND, command_received);
}

int bus_handle(struct bus *b, int timeout_ms) {
    if (lcm_get_fileno(b->lcm) < 0) return STATUS_IO; /* liblcm would select on it */
    int handled = lcm_handle_timeout(b->lcm, timeout_ms);
    if (handled >= 0) return handled;
    return errno == EINTR ? 0 : STATUS_IO;
}
