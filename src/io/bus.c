#include "bus.h"

#include "poll_any.h"

#include <arpa/inet.h>
#include <errno.h>
#include <ifaddrs.h>
#include <linux/filter.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#define MAGIC 0x4c433032u /* "LC02": a short message ("LC03" marks a fragment of a long one) */

enum { HEADER = 8, DATAGRAM_MAX = 65507, HOST_ADDRESSES_MAX = 32, UDP_HEADER = 8 };

struct bus {
    struct sockaddr_in group;
    int out, in;                /* sockets for sending and receiving; in: -1 until bus_listen() */
    _Atomic uint32_t number;    /* sequence number of the next message */
    enum bus_source source;
    struct in_addr host[HOST_ADDRESSES_MAX];
    int hosts;
    struct in_addr other[BUS_OTHERS_MAX]; /* other hosts whose messages are accepted */
    int others;
    unsigned char datagram[DATAGRAM_MAX];
};

/* ---- the URL ---- */

static int refuse_url(const char *url, struct error *error) {
    return error_set(error, STATUS_USAGE, "lcm.url \"%.128s\": give one like udpm://239.255.76.67:7667?ttl=0", url);
}

bool bus_network(char name[BUS_INTERFACE_SIZE]) {
    struct ifaddrs *all;
    bool found = false;
    if (getifaddrs(&all)) return false;
    for (struct ifaddrs *a = all; a && !found; a = a->ifa_next) {
        found = a->ifa_addr && a->ifa_addr->sa_family == AF_INET && (a->ifa_flags & IFF_UP) && !(a->ifa_flags & IFF_LOOPBACK);
        if (found) snprintf(name, BUS_INTERFACE_SIZE, "%s", a->ifa_name);
    }
    freeifaddrs(all);
    return found;
}

void bus_remedy(char *text, size_t size) {
    char name[BUS_INTERFACE_SIZE];
    if (bus_network(name)) snprintf(text, size, "ip route add 224.0.0.0/4 dev %s", name);
    else snprintf(text, size, "ip link set lo up; ip link set lo multicast on; ip route add 224.0.0.0/4 dev lo");
}

static int refuse_network(const char *url, struct error *error) {
    int why = errno;
    char remedy[160];
    bus_remedy(remedy, sizeof remedy);
    return error_set(
        error, STATUS_IO,
        "LCM cannot use %.128s: %s; most likely there is no route for multicast: `%s` makes one on this host; commands of this "
        "host do not need it",
        url, strerror(why), remedy);
}

static bool number(const char **text, int least, int most, int *value) {
    char *end;
    long x = strtol(*text, &end, 10);
    bool good = end != *text && **text >= '0' && **text <= '9' && x >= least && x <= most;
    *text = end;
    *value = (int)x;
    return good;
}

/* Parses "[HOST[:PORT]][?ttl=N]". */
static bool parse_address(const char *text, struct sockaddr_in *group, int *ttl) {
    char host[16] = "239.255.76.67";
    size_t length = strcspn(text, ":?");
    int port = 7667;
    *ttl = 0; /* SAFETY: the stream stays on this host unless configured otherwise */
    if (length >= sizeof host) return false;
    if (length) snprintf(host, sizeof host, "%.*s", (int)length, text);
    text += length;
    if (*text == ':' && (text++, !number(&text, 1, 65535, &port))) return false;
    if (!strncmp(text, "?ttl=", 5) && (text += 5, !number(&text, 0, 255, ttl))) return false;
    *group = (struct sockaddr_in){.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    return !*text && inet_pton(AF_INET, host, &group->sin_addr) == 1 && IN_MULTICAST(ntohl(group->sin_addr.s_addr));
}

/* ---- sending ---- */

/* Returns true if there is a route to the group. */
static bool reachable(const struct sockaddr_in *group) {
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    bool is = fd >= 0 && !connect(fd, (const struct sockaddr *)group, sizeof *group);
    int why = errno;
    if (fd >= 0) close(fd);
    errno = why;
    return is;
}

/* Opens the sending socket and leaves it unconnected. A connected socket would have a fixed source
 * address and send by the interface of that address, whatever the route to the group says; a
 * receiver that joined the group by the route would then not get its messages. The socket's receive
 * buffer has the smallest size, because nothing is read from it. */
static bool open_sender(struct bus *b, int ttl) {
    unsigned char hops = (unsigned char)ttl, loop = 1;
    int least = 1;
    b->out = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    return b->out >= 0 && !setsockopt(b->out, SOL_SOCKET, SO_RCVBUF, &least, sizeof least) &&
           !setsockopt(b->out, IPPROTO_IP, IP_MULTICAST_TTL, &hops, sizeof hops) &&
           !setsockopt(b->out, IPPROTO_IP, IP_MULTICAST_LOOP, &loop, sizeof loop) && reachable(&b->group);
}

int bus_open(struct bus **bus, const char *url, struct error *error) {
    static const char scheme[] = "udpm://";
    struct bus *b = calloc(1, sizeof *b);
    int ttl;
    *bus = NULL;
    if (!b) return error_set(error, STATUS_IO, "out of memory");
    b->in = b->out = -1;
    int status = STATUS_OK;
    if (strncmp(url, scheme, sizeof scheme - 1) || !parse_address(url + sizeof scheme - 1, &b->group, &ttl))
        status = refuse_url(url, error);
    else if (!open_sender(b, ttl)) status = refuse_network(url, error);
    if (status) bus_close(b);
    else *bus = b;
    return status;
}

/* Returns the index of the interface on the kernel's route to the group; 0: there is none. */
static unsigned route_interface(struct in_addr group) {
    struct {
        struct nlmsghdr head;
        struct rtmsg route;
        struct rtattr attribute;
        struct in_addr group;
    } question = {.head = {.nlmsg_len = sizeof question, .nlmsg_type = RTM_GETROUTE, .nlmsg_flags = NLM_F_REQUEST},
                  .route = {.rtm_family = AF_INET, .rtm_dst_len = 32},
                  .attribute = {.rta_len = RTA_LENGTH(sizeof group), .rta_type = RTA_DST},
                  .group = group};
    _Alignas(struct nlmsghdr) char answer[4096];
    unsigned found = 0;
    int fd = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    bool asked = fd >= 0 && send(fd, &question, sizeof question, 0) == (ssize_t)sizeof question;
    ssize_t size = asked ? recv(fd, answer, sizeof answer, 0) : -1;
    if (fd >= 0) close(fd);
    struct nlmsghdr *head = (struct nlmsghdr *)answer;
    if (size < (ssize_t)sizeof *head || !NLMSG_OK(head, (unsigned)size) || head->nlmsg_type != RTM_NEWROUTE) return 0;
    const char *end = answer + head->nlmsg_len, *at = (const char *)NLMSG_DATA(head) + NLMSG_ALIGN(sizeof(struct rtmsg));
    for (struct rtattr a; end - at >= (long)sizeof a; at += RTA_ALIGN(a.rta_len)) {
        memcpy(&a, at, sizeof a);
        if (a.rta_len < sizeof a || a.rta_len > end - at) break;
        if (a.rta_type == RTA_OIF && a.rta_len >= RTA_LENGTH(sizeof found)) memcpy(&found, at + RTA_LENGTH(0), sizeof found);
    }
    return found;
}

struct bus_route bus_route(const struct bus *b) {
    struct bus_route r = {.port = ntohs(b->group.sin_port)};
    unsigned char hops = 0;
    socklen_t hops_length = sizeof hops;
    char name[IF_NAMESIZE] = "";
    struct ifreq flags = {0};
    inet_ntop(AF_INET, &b->group.sin_addr, r.group, sizeof r.group);
    if (!getsockopt(b->out, IPPROTO_IP, IP_MULTICAST_TTL, &hops, &hops_length)) r.ttl = hops;
    unsigned index = route_interface(b->group.sin_addr);
    if (!index || !if_indextoname(index, name)) return r;
    snprintf(r.interface, sizeof r.interface, "%s", name);
    snprintf(flags.ifr_name, sizeof flags.ifr_name, "%s", name);
    r.loopback = !ioctl(b->out, SIOCGIFFLAGS, &flags) && (flags.ifr_flags & IFF_LOOPBACK);
    return r;
}

void bus_close(struct bus *b) {
    if (b->out >= 0) close(b->out);
    if (b->in >= 0) close(b->in);
    free(b);
}

int bus_publish(struct bus *b, const char *channel, const void *data, int size) {
    size_t length = strlen(channel) + 1;
    if (size < 0 || size > BUS_DATA_MAX || length > BUS_CHANNEL_SIZE) return -1;
    uint32_t header[] = {htonl(MAGIC), htonl(atomic_fetch_add_explicit(&b->number, 1, memory_order_relaxed))};
    struct iovec part[] = {{header, sizeof header}, {(void *)(uintptr_t)channel, length}, {(void *)(uintptr_t)data, (size_t)size}};
    struct msghdr message = {.msg_name = &b->group, .msg_namelen = sizeof b->group, .msg_iov = part, .msg_iovlen = 3};
    return sendmsg(b->out, &message, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0 ? 0 : -1;
}

/* ---- receiving ---- */

bool bus_parse(const unsigned char *datagram, int size, struct bus_message *m) {
    static const unsigned char magic[] = {'L', 'C', '0', '2'};
    if (size < HEADER || memcmp(datagram, magic, sizeof magic) != 0) return false;
    const unsigned char *channel = datagram + HEADER;
    size_t left = (size_t)(size - HEADER), room = left < BUS_CHANNEL_SIZE ? left : BUS_CHANNEL_SIZE;
    const unsigned char *end = memchr(channel, '\0', room);
    if (!end) return false;
    memcpy(m->channel, channel, (size_t)(end - channel) + 1);
    m->data = end + 1;
    m->size = (int)(datagram + size - m->data);
    return true;
}

/* Makes the kernel drop all datagrams but messages of channels with this prefix, so that a flood of
 * other datagrams does not fill the receive buffer. Offsets count from the UDP header. */
static bool drop_others(int fd, const char *prefix) {
    enum { FIXED = 2, PER_BYTE = 2, END = 2, LETTERS_MAX = 20 };
    struct sock_filter code[FIXED + PER_BYTE * LETTERS_MAX + END];
    int length = (int)strlen(prefix), size = FIXED + PER_BYTE * length + END, n = 0;
    if (length > LETTERS_MAX) return false;
    code[n++] = (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_ABS, UDP_HEADER);
    code[n] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, MAGIC, 0, (uint8_t)(size - n - 2)), n++;
    for (int i = 0; i < length; i++) {
        code[n++] = (struct sock_filter)BPF_STMT(BPF_LD | BPF_B | BPF_ABS, (uint32_t)(UDP_HEADER + HEADER + i));
        code[n] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (uint32_t)prefix[i], 0, (uint8_t)(size - n - 2)), n++;
    }
    code[n++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, UINT32_MAX);
    code[n++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, 0);
    struct sock_fprog program = {.len = (unsigned short)n, .filter = code};
    return !setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program);
}

/* Joins the group on the interface of the route and on every other interface, because the interface
 * by which a local datagram arrives depends on the sender's address and socket, and the route may
 * change. Returns false if no interface can join. */
static bool join(struct bus *b) {
    struct ip_mreqn membership = {.imr_multiaddr = b->group.sin_addr};
    struct if_nameindex *all = if_nameindex();
    bool joined = !setsockopt(b->in, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership);
    int why = errno;
    for (struct if_nameindex *i = all; i && i->if_index; i++) {
        membership.imr_ifindex = (int)i->if_index;
        joined |= !setsockopt(b->in, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership);
    }
    if (all) if_freenameindex(all);
    errno = why;
    return joined;
}

/* Binds to the group, so that datagrams sent to this host's own address do not arrive. */
static bool open_receiver(struct bus *b, const char *prefix) {
    int yes = 1, no = 0, room = BUS_RECEIVE_BUFFER;
    b->in = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (b->in < 0) return false;
    /* the result is ignored, because the system may grant a smaller buffer than requested */
    setsockopt(b->in, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    return !setsockopt(b->in, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) &&
           !setsockopt(b->in, IPPROTO_IP, IP_MULTICAST_ALL, &no, sizeof no) && drop_others(b->in, prefix) &&
           !bind(b->in, (const struct sockaddr *)&b->group, sizeof b->group) && join(b);
}

static void find_host_addresses(struct bus *b) {
    struct ifaddrs *all;
    if (getifaddrs(&all)) return;
    for (struct ifaddrs *a = all; a && b->hosts < HOST_ADDRESSES_MAX; a = a->ifa_next)
        if (a->ifa_addr && a->ifa_addr->sa_family == AF_INET) {
            struct sockaddr_in address;
            memcpy(&address, a->ifa_addr, sizeof address);
            b->host[b->hosts++] = address.sin_addr;
        }
    freeifaddrs(all);
}

int bus_listen(struct bus *b, const char *prefix, enum bus_source source, struct error *error) {
    char group[INET_ADDRSTRLEN];
    b->source = source;
    find_host_addresses(b);
    if (open_receiver(b, prefix)) return STATUS_OK;
    inet_ntop(AF_INET, &b->group.sin_addr, group, sizeof group);
    error_set(error, STATUS_IO, "LCM cannot receive from %s:%d: %s", group, ntohs(b->group.sin_port), strerror(errno));
    if (b->in >= 0) close(b->in);
    b->in = -1;
    return error->status;
}

int bus_allow(struct bus *b, const char *addresses, struct error *error) {
    static const char between[] = " ,\t";
    for (const char *at = addresses + strspn(addresses, between); *at; at += strspn(at, between)) {
        char address[INET_ADDRSTRLEN];
        size_t length = strcspn(at, between);
        bool fits = length < sizeof address && b->others < BUS_OTHERS_MAX;
        snprintf(address, sizeof address, "%.*s", (int)length, at);
        if (!fits || inet_pton(AF_INET, address, &b->other[b->others]) != 1)
            return error_set(error, STATUS_USAGE, "\"%.*s\" is no IPv4 address, or more than %d of them: give them as 10.0.0.7 10.0.0.8",
                             (int)(length < 60 ? length : 60), at, BUS_OTHERS_MAX);
        b->others++;
        at += length;
    }
    return STATUS_OK;
}

int bus_fd(const struct bus *b) { return b->in; }

/* Returns true if the sender's address proves that it is on this host. From a network the kernel
 * accepts neither 127.0.0.0/8 nor this host's own addresses, and it accepts 0.0.0.0, the address of
 * a sender on a loopback route, only for groups of 224.0.0.0/24. */
static bool from_this_host(const struct bus *b, const struct sockaddr_in *sender) {
    uint32_t address = ntohl(sender->sin_addr.s_addr), group = ntohl(b->group.sin_addr.s_addr);
    if (address >> 24 == IN_LOOPBACKNET || (address == INADDR_ANY && group >> 8 != INADDR_UNSPEC_GROUP >> 8)) return true;
    for (int i = 0; i < b->hosts; i++)
        if (b->host[i].s_addr == sender->sin_addr.s_addr) return true;
    return false;
}

static bool allowed(const struct bus *b, const struct sockaddr_in *sender) {
    for (int i = 0; i < b->others; i++)
        if (b->other[i].s_addr == sender->sin_addr.s_addr) return true;
    return false;
}

int bus_receive(struct bus *b, struct bus_message *message) {
    struct sockaddr_in sender;
    socklen_t length = sizeof sender;
    ssize_t size = recvfrom(b->in, b->datagram, sizeof b->datagram, MSG_DONTWAIT, (struct sockaddr *)&sender, &length);
    if (size < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR ? 0 : STATUS_IO;
    if (length != sizeof sender || (b->source == BUS_THIS_HOST && !from_this_host(b, &sender) && !allowed(b, &sender))) return BUS_DROPPED;
    return bus_parse(b->datagram, (int)size, message) ? 1 : BUS_DROPPED;
}

int bus_wait(struct bus *b, int timeout_ms) {
    struct pollfd p = {.fd = b->in, .events = POLLIN};
    int ready = poll_any(&p, 1, timeout_ms, NULL);
    if (ready < 0) return errno == EINTR ? 0 : STATUS_IO;
    return ready;
}
