#include "can_controller.h"

#include <errno.h>
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { ANSWER_SIZE = 1 << 15 };
_Static_assert((int)CAN_CONTROLLER_ACTIVE == CAN_STATE_ERROR_ACTIVE && (int)CAN_CONTROLLER_BUS_OFF == CAN_STATE_BUS_OFF,
               "the kernel's numbers");

const char *can_controller_state(int state) {
    static const char *const names[CAN_STATE_MAX] = {[CAN_STATE_ERROR_ACTIVE] = "error-active",
                                                     [CAN_STATE_ERROR_WARNING] = "error-warning",
                                                     [CAN_STATE_ERROR_PASSIVE] = "error-passive",
                                                     [CAN_STATE_BUS_OFF] = "bus-off",
                                                     [CAN_STATE_STOPPED] = "stopped",
                                                     [CAN_STATE_SLEEPING] = "sleeping"};
    return state >= 0 && state < CAN_STATE_MAX ? names[state] : "unknown";
}

/* ---- netlink attributes: a header with length and type, then the value, padded to 4 bytes ---- */

struct span {
    const unsigned char *at, *end;
};

/* Takes the next complete attribute. Returns its value, and in *type its type. If no attribute is
 * left, `at` of the result is NULL. */
static struct span next(struct span *in, int *type) {
    struct rtattr a;
    if (in->end - in->at < (ptrdiff_t)sizeof a) return (struct span){0};
    memcpy(&a, in->at, sizeof a);
    if (a.rta_len < sizeof a || a.rta_len > in->end - in->at) return (struct span){0};
    struct span value = {in->at + sizeof a, in->at + a.rta_len};
    ptrdiff_t step = RTA_ALIGN(a.rta_len), left = in->end - in->at;
    in->at += step < left ? step : left;
    *type = a.rta_type & NLA_TYPE_MASK;
    return value;
}

/* Copies the members of a structure that this program and the running kernel both have; newer
 * kernels append members. Returns false if the attribute is empty. */
static bool copy(struct span value, void *to, size_t size) {
    size_t length = (size_t)(value.end - value.at);
    memcpy(to, value.at, length < size ? length : size);
    return length > 0;
}

static void take_can(struct span in, struct can_controller *s) {
    struct can_bittiming timing = {0};
    struct can_berr_counter counter = {0};
    uint32_t state = 0;
    int type;
    for (struct span v; (v = next(&in, &type)).at;) {
        if (type == IFLA_CAN_BITTIMING && copy(v, &timing, sizeof timing)) {
            s->bitrate_bps = timing.bitrate;
            s->sample_point = timing.sample_point / 1000.0;
        } else if (type == IFLA_CAN_STATE && copy(v, &state, sizeof state)) {
            s->known = true;
            s->state = (int)state;
        } else if (type == IFLA_CAN_BERR_COUNTER && copy(v, &counter, sizeof counter)) {
            s->counts = true;
            s->tx_errors = counter.txerr, s->rx_errors = counter.rxerr;
        }
    }
}

static void take_device_statistics(struct span v, struct can_controller *s) {
    struct can_device_stats d = {0};
    copy(v, &d, sizeof d);
    s->bus_errors = d.bus_error, s->arbitration_lost = d.arbitration_lost, s->restarts = d.restarts;
    s->warnings = d.error_warning, s->passives = d.error_passive, s->bus_offs = d.bus_off;
}

static void take_link_info(struct span in, struct can_controller *s) {
    struct span data = {0}, statistics = {0};
    int type;
    for (struct span v; (v = next(&in, &type)).at;) {
        if (type == IFLA_INFO_KIND) copy(v, s->kind, sizeof s->kind - 1);
        if (type == IFLA_INFO_DATA) data = v;
        if (type == IFLA_INFO_XSTATS) statistics = v;
    }
    /* in an interface of another kind, data and statistics have other contents */
    if (strcmp(s->kind, "can") != 0) return;
    if (data.at) take_can(data, s);
    if (statistics.at) take_device_statistics(statistics, s);
}

bool can_controller_parse(const void *message, size_t size, struct can_controller *s) {
    struct nlmsghdr header;
    *s = (struct can_controller){0};
    if (size < NLMSG_LENGTH(sizeof(struct ifinfomsg))) return false;
    memcpy(&header, message, sizeof header);
    if (header.nlmsg_type != RTM_NEWLINK || header.nlmsg_len > size || header.nlmsg_len < NLMSG_LENGTH(sizeof(struct ifinfomsg)))
        return false;
    const unsigned char *begin = message;
    struct span in = {begin + NLMSG_SPACE(sizeof(struct ifinfomsg)), begin + header.nlmsg_len};
    struct rtnl_link_stats64 statistics = {0};
    int type;
    for (struct span v; (v = next(&in, &type)).at;) {
        if (type == IFLA_LINKINFO) take_link_info(v, s);
        if (type == IFLA_STATS64) copy(v, &statistics, sizeof statistics);
    }
    s->rx_dropped = statistics.rx_dropped, s->tx_dropped = statistics.tx_dropped;
    return true;
}

static ssize_t ask(int fd, unsigned index, void *answer, size_t size) {
    struct {
        struct nlmsghdr header;
        struct ifinfomsg link;
    } request = {
        .header = {.nlmsg_len = NLMSG_LENGTH(sizeof(struct ifinfomsg)),
                   .nlmsg_type = RTM_GETLINK,
                   .nlmsg_flags = NLM_F_REQUEST,
                   .nlmsg_seq = 1},
        .link = {.ifi_family = AF_UNSPEC, .ifi_index = (int)index},
    };
    struct sockaddr_nl kernel = {.nl_family = AF_NETLINK};
    if (sendto(fd, &request, request.header.nlmsg_len, 0, (struct sockaddr *)&kernel, sizeof kernel) < 0) return -1;
    return recv(fd, answer, size, 0);
}

int can_controller_read(const char *interface, struct can_controller *s, struct error *error) {
    _Alignas(struct nlmsghdr) unsigned char answer[ANSWER_SIZE];
    const struct timeval patience = {.tv_sec = 1};
    unsigned index = if_nametoindex(interface);
    int fd = index ? socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE) : -1;
    if (fd >= 0) setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    ssize_t size = fd >= 0 ? ask(fd, index, answer, sizeof answer) : -1;
    int reason = errno;
    if (fd >= 0) close(fd);
    if (size < 0) return error_set(error, STATUS_IO, "can:%.40s: its state cannot be asked: %s", interface, strerror(reason));
    if (can_controller_parse(answer, (size_t)size, s)) return STATUS_OK;
    return error_set(error, STATUS_IO, "can:%.40s: its state cannot be asked: the kernel's answer is not understood", interface);
}
