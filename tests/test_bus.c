/* The bus: messages arrive as sent, invalid ones are dropped on receipt, and errors of opening name
 * the remedy. Runs in its own network namespace. */
#include "support.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

#include "bus.h"
#include "messages.h"

static const char multicast[] = "udpm://239.255.76.67:7667?ttl=0";
static bool isolated; /* this process has its own network namespace */

static void connect_loopback(void) {
    static bool done;
    if (!isolated) skip_because("this system allows no network namespace");
    if (!done) /* the commands that the documentation gives as the remedy */
        assert_int_equal(system("ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo"), 0);
    done = true;
}

static struct bus *open_bus(const char *prefix, enum bus_source source) {
    struct bus *b;
    struct error error;
    connect_loopback();
    assert_int_equal(bus_open(&b, multicast, &error), STATUS_OK);
    if (prefix) assert_int_equal(bus_listen(b, prefix, source, &error), STATUS_OK);
    return b;
}

/* Returns the size of the next message, -1 if no message comes. */
static int next(struct bus *b, struct bus_message *m) {
    for (int got; (got = bus_receive(b, m)) || bus_wait(b, 200) == 1;)
        if (got == 1) return m->size;
    return -1;
}

/* Sends raw bytes to the group or another address. */
static void throw(const char *to, const void *data, size_t size) {
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons(7667)};
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    inet_pton(AF_INET, to, &address.sin_addr);
    sendto(fd, data, size, 0, (struct sockaddr *)&address, sizeof address);
    close(fd);
}

static void a_message_arrives_as_it_was_sent(void **unused) {
    (void)unused;
    struct bus *b = open_bus("HEXID_", BUS_THIS_HOST);
    struct bus_message m;
    unsigned char state[STATE_MESSAGE_MAX];
    int size = state_encode(&(struct cycle){.seq = 77, .dof = DOF_NONE, .test = -1}, state);
    assert_int_equal(bus_publish(b, "OTHER", state, size), 0);
    assert_int_equal(bus_publish(b, CHANNEL_STATE, state, size), 0);
    assert_int_equal(next(b, &m), size);
    assert_string_equal(m.channel, CHANNEL_STATE);
    assert_memory_equal(m.data, state, (size_t)size);
    assert_int_equal(next(b, &m), -1);
    bus_close(b);
}

static void only_the_channels_asked_for_arrive(void **unused) {
    (void)unused;
    struct bus *b = open_bus(CHANNEL_COMMAND, BUS_ANYONE);
    struct bus_message m;
    static const char *const others[] = {CHANNEL_STATE, "HEXID_COMMAN", "hexid_command", "XHEXID_COMMAND", ""};
    for (int i = 0; i < 5; i++) bus_publish(b, others[i], "x", 1);
    bus_publish(b, CHANNEL_COMMAND, "", 0);
    assert_int_equal(next(b, &m), 0);
    assert_string_equal(m.channel, CHANNEL_COMMAND);
    assert_int_equal(next(b, &m), -1);
    bus_close(b);
}

/* Includes the 66-byte datagram that crashes a process with liblcm. */
static void what_is_no_short_message_is_dropped(void **unused) {
    (void)unused;
    static unsigned char datagram[65507];
    struct bus *b = open_bus("HEXID_", BUS_ANYONE);
    struct bus_message m;
    uint64_t state = 5;
    unsigned char fragment[66] = {'L', 'C', '0', '3', 0, 0, 0, 1, 0, 0, 0x10, 0, 0xff, 0xff, 0xff, 0xf0, 0, 1, 0, 2};
    memcpy(fragment + 20, CHANNEL_COMMAND, sizeof CHANNEL_COMMAND);
    throw("239.255.76.67", fragment, sizeof fragment);
    throw("239.255.76.67", "", 0);
    throw("239.255.76.67", "LC02", 4);
    throw("239.255.76.67", "LC02\0\0\0\0HEXID_COMMAND", 21); /* unterminated name */
    for (int i = 0; i < 1000; i++) {
        size_t size = (size_t)random_below(&state, 200);
        for (size_t k = 0; k < size; k++) datagram[k] = (unsigned char)random_below(&state, 256);
        if (i % 2 && size > 4) memcpy(datagram, i % 4 == 1 ? "LC02" : "LC03", 4);
        throw("239.255.76.67", datagram, size);
    }
    memcpy(datagram, "LC02\0\0\0\0HEXID_EVENT", 20);
    throw("239.255.76.67", datagram, sizeof datagram); /* maximum length */
    for (int size; (size = next(b, &m)) >= 0;) assert_int_equal(size, (int)sizeof datagram - 20);
    bus_publish(b, CHANNEL_EVENT, "still here", 10);
    assert_int_equal(next(b, &m), 10);
    bus_close(b);
}

/* SAFETY: unicast reaches a port from any network, whatever route multicast has. */
static void what_was_not_sent_to_the_group_is_dropped(void **unused) {
    (void)unused;
    struct bus *b = open_bus("HEXID_", BUS_ANYONE);
    struct bus_message m;
    throw("127.0.0.1", "LC02\0\0\0\0HEXID_COMMAND\0park", 26);
    assert_int_equal(next(b, &m), -1);
    throw("239.255.76.67", "LC02\0\0\0\0HEXID_COMMAND\0park", 26);
    assert_int_equal(next(b, &m), 4);
    bus_close(b);
}

/* Two hosts: this network namespace and another, joined by a pair of interfaces. */
static void another_hosts_messages_are_for_who_wants_them(void **unused) {
    (void)unused;
    struct bus *anyone = open_bus("HEXID_", BUS_ANYONE), *host;
    struct bus_message m;
    bus_close(anyone);
    if (system("ip netns add hexid_other 2>/dev/null && ip link add h0 type veth peer name h1 && ip link set h1 netns hexid_other && "
               "ip address add 10.77.0.1/24 dev h0 && ip link set h0 up && ip route del 224.0.0.0/4 && ip route add 224.0.0.0/4 dev h0 && "
               "ip netns exec hexid_other sh -c 'ip address add 10.77.0.2/24 dev h1 && ip link set h1 up && "
               "ip route add 224.0.0.0/4 dev h1'"))
        skip_because("this system allows no second network namespace");
    anyone = open_bus("HEXID_", BUS_ANYONE), host = open_bus("HEXID_", BUS_THIS_HOST);
    int sent = system("ip netns exec hexid_other bash -c 'printf \"LC02\\0\\0\\0\\0HEXID_COMMAND\\0park\" >/dev/udp/239.255.76.67/7667'");
    int from_there = next(anyone, &m), refused = next(host, &m), taken[2];
    struct error error;
    static const char *const lists[] = {"10.77.0.3", " 10.0.0.1,10.77.0.2"};
    for (int i = 0; i < 2; i++) { /* first without the sender's address, then with it among
                                   * others */
        assert_int_equal(bus_allow(host, lists[i], &error), STATUS_OK);
        sent |= system("ip netns exec hexid_other bash -c 'printf \"LC02\\0\\0\\0\\0HEXID_COMMAND\\0park\" >/dev/udp/239.255.76.67/7667'");
        taken[i] = next(host, &m);
    }
    bus_publish(anyone, CHANNEL_EVENT, "own", 3);
    int own = next(host, &m);
    assert_int_equal(system("ip netns del hexid_other; ip link del h0 2>/dev/null; ip route replace 224.0.0.0/4 dev lo"), 0);
    assert_int_equal(sent, 0);
    assert_int_equal(from_there, 4);
    assert_int_equal(refused, -1);
    assert_int_equal(taken[0], -1);
    assert_int_equal(taken[1], 4);
    assert_int_equal(own, 3);
    bus_close(anyone), bus_close(host);
}

/* An interface with an address of its own exists beside the documented multicast route. Senders
 * with a connected socket, such as LCM's own, send by that interface; others by the route. */
static void beside_a_networks_address_both_ways_are_heard(void **unused) {
    (void)unused;
    static const char *const routes[] = {"lo", "g0"};
    connect_loopback();
    if (system("ip link add g0 type veth peer name g1 && ip address add 10.78.0.1/24 dev g0 && ip link set g0 up && ip link set g1 up"))
        skip_because("this system allows no pair of interfaces");
    int heard[2][2], own[2];
    char interface[2][BUS_INTERFACE_SIZE];
    for (int i = 0; i < 2; i++) {
        char command[80];
        snprintf(command, sizeof command, "ip route replace 224.0.0.0/4 dev %s", routes[i]);
        assert_int_equal(system(command), 0);
        struct bus *b = open_bus("HEXID_", BUS_THIS_HOST);
        struct bus_message m;
        struct sockaddr_in group = {.sin_family = AF_INET, .sin_port = htons(7667)};
        inet_pton(AF_INET, "239.255.76.67", &group.sin_addr);
        for (int connected = 0; connected < 2; connected++) {
            int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
            if (connected) connect(fd, (struct sockaddr *)&group, sizeof group);
            sendto(fd, "LC02\0\0\0\0HEXID_COMMAND\0park", 26, 0, (struct sockaddr *)&group, sizeof group);
            close(fd);
            heard[i][connected] = next(b, &m);
        }
        bus_publish(b, CHANNEL_EVENT, "own", 3);
        own[i] = next(b, &m);
        strcpy(interface[i], bus_route(b).interface);
        bus_close(b);
    }
    assert_int_equal(system("ip link del g0; ip route replace 224.0.0.0/4 dev lo"), 0);
    for (int i = 0; i < 2; i++) {
        assert_true(heard[i][0] == 4 && heard[i][1] == 4 && own[i] == 3);
        assert_string_equal(interface[i], routes[i]);
    }
}

static void what_is_no_list_of_addresses_is_refused(void **unused) {
    (void)unused;
    static const char *const wrong[] = {"10.0.0",      "a",         "10.0.0.1;10.0.0.2", "::1",
                                        "10.0.0.1/24", "300.1.1.1", "localhost",         "1234567890123456789"};
    struct bus *b = open_bus(NULL, BUS_ANYONE);
    struct error error;
    char many[17 * 9 + 1] = "";
    for (int i = 0; i < 8; i++) {
        assert_int_equal(bus_allow(b, wrong[i], &error), STATUS_USAGE);
        assert_non_null(strstr(error.text, wrong[i]));
    }
    for (int i = 0; i < 17; i++) strcat(many, "10.0.0.1 ");
    assert_int_equal(bus_allow(b, many, &error), STATUS_USAGE);
    assert_int_equal(bus_allow(b, "", &error), STATUS_OK);
    bus_close(b);
}

static void what_is_no_url_of_a_group_is_refused(void **unused) {
    (void)unused;
    /* clang-format off */
    static const char *const urls[] = {"telepathy://", "udpm://300.1.2.3:99999", "nothing", "", "file:///tmp/hexid_test?mode=w",
                                       "memq://", "udpm://10.0.0.1:7667", "udpm://239.255.76.67:0", "udpm://239.255.76.67:7667?ttl=256",
                                       "udpm://239.255.76.67:7667?ttl=1x", "udpm://239.255.76.67:7667&ttl=0", "udpm://?ttl=",
                                       "udpm://239.255.76.67:-1"};
    /* clang-format on */
    for (size_t i = 0; i < sizeof urls / sizeof *urls; i++) {
        struct bus *b;
        struct error error;
        assert_int_equal(bus_open(&b, urls[i], &error), STATUS_USAGE);
        assert_null(b);
        assert_non_null(strstr(error.text, urls[i]));
        assert_non_null(strstr(error.text, "udpm://239.255.76.67:7667?ttl=0"));
    }
    assert_int_not_equal(access("/tmp/hexid_test", F_OK), 0);
}

static void without_a_route_the_remedy_is_named(void **unused) {
    (void)unused;
    struct bus *b;
    struct error error;
    if (!isolated) skip_because("this system allows no network namespace");
    assert_int_equal(bus_open(&b, multicast, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "`ip link set lo up; ip link set lo multicast on; ip route add 224.0.0.0/4 dev lo`"));
}

static int ttl_of(const char *url) {
    struct bus *b;
    struct error error;
    int ttl = -1;
    assert_int_equal(bus_open(&b, url, &error), STATUS_OK);
    for (int fd = 3; fd < 64; fd++) {
        struct sockaddr_in address;
        socklen_t length = sizeof address, size = 1;
        unsigned char hops;
        if (getsockname(fd, (struct sockaddr *)&address, &length) || address.sin_family != AF_INET) continue;
        if (!getsockopt(fd, IPPROTO_IP, IP_MULTICAST_TTL, &hops, &size)) ttl = hops;
    }
    bus_close(b);
    return ttl;
}

/* SAFETY: without a setting the system's ttl would be 1, and messages would leave this host. */
static void the_stream_stays_on_this_host_unless_the_url_says_otherwise(void **unused) {
    (void)unused;
    connect_loopback();
    assert_int_equal(ttl_of(multicast), 0);
    assert_int_equal(ttl_of("udpm://239.255.76.67:7667"), 0);
    assert_int_equal(ttl_of("udpm://"), 0);
    assert_int_equal(ttl_of("udpm://239.255.76.67:7667?ttl=2"), 2);
}

/* liblcm's default socket buffer kept 30 messages. More than 200 may exceed the largest buffer that
 * the system permits a process. */
static void two_hundred_messages_wait_for_a_slow_reader(void **unused) {
    (void)unused;
    enum { MESSAGES = 200 };
    struct bus *b = open_bus(CHANNEL_EVENT, BUS_THIS_HOST);
    struct bus_message m;
    int got = 0, value = -1;
    for (int i = 0; i < MESSAGES; i++) assert_int_equal(bus_publish(b, CHANNEL_EVENT, &i, sizeof i), 0);
    while (next(b, &m) == (int)sizeof value) {
        memcpy(&value, m.data, sizeof value);
        assert_int_equal(value, got++);
    }
    assert_int_equal(got, MESSAGES);
    bus_close(b);
}

/* Moves this process into a network namespace of its own. Without privileges it also needs a user
 * namespace, because `ip` must run as its root. */
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
        cmocka_unit_test(without_a_route_the_remedy_is_named),
        cmocka_unit_test(a_message_arrives_as_it_was_sent),
        cmocka_unit_test(only_the_channels_asked_for_arrive),
        cmocka_unit_test(what_is_no_short_message_is_dropped),
        cmocka_unit_test(what_was_not_sent_to_the_group_is_dropped),
        cmocka_unit_test(what_is_no_url_of_a_group_is_refused),
        cmocka_unit_test(the_stream_stays_on_this_host_unless_the_url_says_otherwise),
        cmocka_unit_test(two_hundred_messages_wait_for_a_slow_reader),
        cmocka_unit_test(another_hosts_messages_are_for_who_wants_them),
        cmocka_unit_test(beside_a_networks_address_both_ways_are_heard),
        cmocka_unit_test(what_is_no_list_of_addresses_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
