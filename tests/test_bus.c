/* The bus: messages arrive as they were sent, commands only when they are commands, and what cannot be opened is named with its remedy. */
#include <fcntl.h>
#include <netinet/in.h>
#include <sched.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

#include "bus.h"
#include "hexid_command_t.h"
#include "messages.h"
#include "support.h"

struct received {
    int messages, size;
    char channel[64];
    unsigned char data[1000];
    int commands;
    enum command command;
};

static void take(void *context, const char *channel, const void *data, int size) {
    struct received *r = context;
    r->messages++;
    snprintf(r->channel, sizeof r->channel, "%s", channel);
    r->size = size;
    memcpy(r->data, data, (size_t)size);
}

static void take_command(void *context, enum command command) {
    struct received *r = context;
    r->commands++;
    r->command = command;
}

static struct bus *open_memory_bus(void) {
    struct bus *b;
    struct error error;
    assert_int_equal(bus_open(&b, "memq://", &error), 0);
    return b;
}

static int handle_all(struct bus *b) {
    int handled = 0;
    while (bus_handle(b, 0) == 1) handled++;
    return handled;
}

static void a_message_arrives_as_it_was_sent(void **unused) {
    (void)unused;
    struct received r = {0};
    struct bus *b = open_memory_bus();
    unsigned char state[STATE_MESSAGE_MAX];
    int size = state_encode(&(struct cycle){.seq = 77, .dof = DOF_NONE, .test = -1}, state);
    assert_int_equal(bus_subscribe_raw(b, "HEXID_.*", take, &r), 0);
    assert_int_equal(bus_publish(b, CHANNEL_STATE, state, size), 0);
    assert_int_equal(bus_publish(b, "OTHER", state, size), 0);
    assert_int_equal(handle_all(b), 1);
    assert_int_equal(r.messages, 1);
    assert_string_equal(r.channel, CHANNEL_STATE);
    assert_int_equal(r.size, size);
    assert_memory_equal(r.data, state, (size_t)size);
    bus_close(b);
}

static void nothing_to_handle_is_no_error(void **unused) {
    (void)unused;
    struct received r = {0};
    struct bus *b = open_memory_bus();
    assert_int_equal(bus_subscribe_raw(b, ".*", take, &r), 0);
    assert_int_equal(bus_handle(b, 0), 0);
    assert_int_equal(bus_handle(b, 1), 0);
    bus_close(b);
}

static void every_command_arrives(void **unused) {
    (void)unused;
    struct bus *b = open_memory_bus();
    struct received r = {0};
    assert_int_equal(bus_subscribe_commands(b, take_command, &r), 0);
    for (int i = COMMAND_ENGAGE; i < COMMANDS; i++) {
        unsigned char buffer[COMMAND_MESSAGE_MAX];
        assert_int_equal(bus_publish(b, CHANNEL_COMMAND, buffer, command_encode(1, (enum command)i, buffer)), 0);
        assert_int_equal(handle_all(b), 1);
        assert_int_equal(r.commands, i);
        assert_int_equal(r.command, i);
    }
    bus_close(b);
}

static void what_is_no_command_is_dropped(void **unused) {
    (void)unused;
    struct bus *b = open_memory_bus();
    struct received r = {0};
    unsigned char buffer[200];
    hexid_command_t none = {.command = (char[]){"none"}}, shout = {.command = (char[]){"START"}};
    assert_int_equal(bus_subscribe_commands(b, take_command, &r), 0);
    bus_publish(b, CHANNEL_COMMAND, "start", 5);
    bus_publish(b, CHANNEL_COMMAND, "", 0);
    bus_publish(b, CHANNEL_COMMAND, buffer, hexid_command_t_encode(buffer, 0, sizeof buffer, &none));
    bus_publish(b, CHANNEL_COMMAND, buffer, hexid_command_t_encode(buffer, 0, sizeof buffer, &shout));
    bus_publish(b, CHANNEL_COMMAND, buffer, command_encode(0, COMMAND_START, buffer) - 1);
    bus_publish(b, CHANNEL_COMMAND, buffer, event_encode(0, 0, "start", "start", buffer, sizeof buffer));
    assert_int_equal(handle_all(b), 6);
    assert_int_equal(r.commands, 0);
    bus_close(b);
}

/* liblcm writes its own lines for people to standard error: not into a test's result. */
static int open_quietly(struct bus **b, const char *url, struct error *error) {
    int kept = dup(STDERR_FILENO), null = open("/dev/null", O_WRONLY);
    dup2(null, STDERR_FILENO);
    int status = bus_open(b, url, error);
    fflush(stderr);
    dup2(kept, STDERR_FILENO);
    close(kept);
    close(null);
    return status;
}

static void what_cannot_be_opened_is_named(void **unused) {
    (void)unused;
    static const char *const urls[] = {"telepathy://", "udpm://300.1.2.3:99999", "nothing"};
    struct bus *b;
    struct error error;
    for (int i = 0; i < 3; i++) {
        assert_int_equal(open_quietly(&b, urls[i], &error), STATUS_IO);
        assert_null(b);
        assert_non_null(strstr(error.text, urls[i]));
    }
    assert_int_equal(open_quietly(&b, "", &error), STATUS_IO);
}

static const char multicast[] = "udpm://239.255.76.67:7667?ttl=0";
static bool isolated; /* this process has a network of its own: a loopback without a route, yet */

static void without_a_route_the_remedy_is_named(void **unused) {
    (void)unused;
    struct bus *b;
    struct error error;
    if (!isolated) skip_because("this system allows no network namespace");
    assert_int_equal(open_quietly(&b, multicast, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "`ip link set lo multicast on; ip route add 224.0.0.0/4 dev lo`"));
}

/* Largest time to live of the sockets that have a port and are not `older`, -1 without one. */
static int multicast_ttl(const bool older[256]) {
    int largest = -1;
    for (int fd = 0; fd < 256; fd++) {
        struct sockaddr_in address;
        socklen_t length = sizeof address, size = 1;
        unsigned char ttl;
        if (older[fd] || getsockname(fd, (struct sockaddr *)&address, &length)) continue;
        if (address.sin_family != AF_INET || !address.sin_port) continue;
        if (!getsockopt(fd, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, &size) && ttl > largest) largest = ttl;
    }
    return largest;
}

/* SAFETY: the system's own default would be 1. */
static void the_stream_stays_on_this_host_unless_the_url_says_otherwise(void **unused) {
    (void)unused;
    static const struct {
        const char *url;
        int ttl;
    } cases[] = {{multicast, 0}, {"udpm://239.255.76.67:7667", 0}, {"udpm://", 0}, {"udpm://239.255.76.67:7667?ttl=2", 2}};
    if (!isolated) skip_because("this system allows no network namespace");
    for (int i = 0; i < 4; i++) {
        struct bus *b;
        struct error error;
        bool older[256]; /* liblcm leaks a socket with a URL that it refuses */
        for (int fd = 0; fd < 256; fd++) older[fd] = fcntl(fd, F_GETFD) >= 0;
        assert_int_equal(open_quietly(&b, cases[i].url, &error), 0);
        bus_publish(b, CHANNEL_EVENT, "", 1);
        assert_int_equal(multicast_ttl(older), cases[i].ttl);
        bus_close(b);
    }
}

/* Every datagram has been taken from its socket: liblcm's thread has them. */
static bool drained(void) {
    char line[256];
    unsigned long waiting = 0, queue;
    FILE *f = fopen("/proc/net/udp", "r");
    while (f && fgets(line, sizeof line, f))
        if (sscanf(line, "%*s %*s %*s %*s %*x:%lx", &queue) == 1) waiting += queue;
    if (f) fclose(f);
    return f && waiting == 0;
}

/* liblcm's own default keeps 30. More than 200 might not fit into the socket, which is nobody's fault. */
static void two_hundred_messages_wait_for_a_slow_reader(void **unused) {
    (void)unused;
    enum { MESSAGES = 200 };
    struct bus *b;
    struct received r = {0};
    struct error error;
    if (!isolated) skip_because("this system allows no network namespace");
    assert_int_equal(system("ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo"), 0); /* the remedy */
    assert_int_equal(open_quietly(&b, multicast, &error), 0);
    assert_int_equal(bus_subscribe_raw(b, CHANNEL_EVENT, take, &r), 0);
    for (int i = 0; i < MESSAGES; i++) assert_int_equal(bus_publish(b, CHANNEL_EVENT, &i, sizeof i), 0);
    while (!drained()) sched_yield();
    while (r.messages < MESSAGES && bus_handle(b, 5000) == 1) continue;
    assert_int_equal(r.messages, MESSAGES);
    bus_close(b);
}

/* Without being root: as the root of a namespace, for ip. */
static bool isolate(void) {
    unsigned user = geteuid();
    if (unshare(CLONE_NEWNET) == 0) return true;
    FILE *map = unshare(CLONE_NEWUSER | CLONE_NEWNET) == 0 ? fopen("/proc/self/uid_map", "w") : NULL;
    if (!map) return false;
    fprintf(map, "0 %u 1\n", user);
    return fclose(map) == 0;
}

int main(void) {
    isolated = isolate();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_message_arrives_as_it_was_sent),
        cmocka_unit_test(nothing_to_handle_is_no_error),
        cmocka_unit_test(every_command_arrives),
        cmocka_unit_test(what_is_no_command_is_dropped),
        cmocka_unit_test(what_cannot_be_opened_is_named),
        cmocka_unit_test(without_a_route_the_remedy_is_named),
        cmocka_unit_test(two_hundred_messages_wait_for_a_slow_reader),
        cmocka_unit_test(the_stream_stays_on_this_host_unless_the_url_says_otherwise),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
