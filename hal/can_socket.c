#include "can_socket.h"

#include <errno.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "units.h"

int64_t can_realtime_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_REALTIME, &t);
    return t.tv_sec * NS_PER_S + t.tv_nsec;
}

/* SAFETY: the arrival time is neither in the future nor before the previous frame's, even if the
 * clock of the kernel's stamps was set, because watchdogs count from it. */
int64_t can_came_ns(int64_t now_ns, int64_t age_ns, int64_t before_ns) {
    int64_t came_ns = now_ns - age_ns;
    if (came_ns > now_ns) came_ns = now_ns;
    return came_ns > before_ns ? came_ns : before_ns;
}

/* State of an interface. An ordinary socket asks for it, so that a missing interface is reported
 * even if the kernel has no CAN. */
struct interface {
    int index; /* 0: none */
    bool is_can, up;
};

static int ask(const char *name, struct interface *i) {
    struct ifreq r = {0};
    *i = (struct interface){0};
    if (strlen(name) == 0 || strlen(name) >= sizeof r.ifr_name) return 0;
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (fd < 0) return -1;
    strcpy(r.ifr_name, name);
    if (!ioctl(fd, SIOCGIFINDEX, &r)) i->index = r.ifr_ifindex;
    i->is_can = !ioctl(fd, SIOCGIFHWADDR, &r) && r.ifr_hwaddr.sa_family == ARPHRD_CAN;
    i->up = !ioctl(fd, SIOCGIFFLAGS, &r) && r.ifr_flags & IFF_UP;
    close(fd);
    return 0;
}

enum can_link can_socket_link(const char *interface, int index) {
    struct interface i;
    if (ask(interface, &i)) return CAN_LINK_UP; /* a link whose state cannot be read counts as up */
    return i.index != index ? CAN_LINK_GONE : i.up ? CAN_LINK_UP : CAN_LINK_DOWN;
}

void can_link_describe(enum can_link link, const char *interface, char *text, size_t size) {
    *text = '\0';
    if (link == CAN_LINK_DOWN) snprintf(text, size, "the interface %s is down: `ip link set %s up`", interface, interface);
    if (link == CAN_LINK_GONE)
        snprintf(text, size, "the interface %s is gone: plug the adapter in again, `ip link set %s up`; it is opened again by itself",
                 interface, interface);
}

static int check_interface(const char *name, int *index, struct error *error) {
    struct interface i;
    if (ask(name, &i)) return error_set(error, STATUS_IO, "can:%s: cannot be asked: %s", name, strerror(errno));
    *index = i.index;
    if (!i.index)
        return error_set(error, STATUS_IO,
                         "can:%.40s: no such interface; `ip link` lists those there are, "
                         "`ip link add dev vcan0 type vcan` makes a virtual one",
                         name);
    if (!i.is_can)
        return error_set(error, STATUS_IO, "can:%s: not a CAN interface; name one that `ip link show type can` or `type vcan` lists", name);
    if (i.up) return STATUS_OK;
    return error_set(error, STATUS_IO,
                     "can:%s: the interface is down; `ip link set %s up type can bitrate 1000000` "
                     "(a virtual one: `ip link set %s up`)",
                     name, name, name);
}

static int open_raw(const char *name, struct error *error) {
    int fd = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
    if (fd >= 0) return fd;
    if (errno == EPERM || errno == EACCES)
        return error_set(error, STATUS_IO, "can:%s: no permission to open a CAN socket; run as root, or allow address family AF_CAN", name);
    return error_set(error, STATUS_IO, "can:%s: this kernel has no CAN sockets (%s); `modprobe can-raw`", name, strerror(errno));
}

static bool configure(int fd, const struct can_accept *accept, int count, bool own, bool errors) {
    enum { ACCEPT_MAX = 32 };
    struct can_filter filter[ACCEPT_MAX];
    can_err_mask_t mask = errors ? CAN_ERR_BUSOFF | CAN_ERR_CRTL | CAN_ERR_TX_TIMEOUT | CAN_ERR_ACK | CAN_ERR_RESTARTED : 0;
    int yes = 1, echo = own;
    if (count > ACCEPT_MAX) return false;
    for (int i = 0; i < count; i++) /* accepts 11-bit data frames only */
        filter[i] = (struct can_filter){.can_id = accept[i].id, .can_mask = accept[i].mask | CAN_EFF_FLAG | CAN_RTR_FLAG};
    return !setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, filter, (socklen_t)((size_t)count * sizeof *filter)) &&
           !setsockopt(fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &mask, sizeof mask) &&
           !setsockopt(fd, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, &echo, sizeof echo) &&
           !setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPNS, &yes, sizeof yes);
}

int can_socket_open(struct can_socket *s, const char *interface, const struct can_accept *accept, int count, bool own, bool errors,
                    struct error *error) {
    struct sockaddr_can address = {.can_family = AF_CAN};
    *s = (struct can_socket){.fd = -1, .confirms = true};
    int status = check_interface(interface, &s->index, error);
    if (status) return status;
    s->fd = open_raw(interface, error);
    if (s->fd < 0) return error->status;
    address.can_ifindex = s->index;
    if (configure(s->fd, accept, count, own, errors) && !bind(s->fd, (struct sockaddr *)&address, sizeof address)) return STATUS_OK;
    error_set(error, STATUS_IO, "can:%s: %s", interface, strerror(errno));
    can_socket_close(s);
    return error->status;
}

void can_socket_close(struct can_socket *s) {
    if (s->fd >= 0) close(s->fd);
    s->fd = -1;
}

/* Sends all frames of a cycle with one system call. */
int can_socket_send(const struct can_socket *s, const struct can_frame *frame, int count) {
    struct iovec data[CAN_BATCH];
    struct mmsghdr message[CAN_BATCH];
    if (count > CAN_BATCH) count = CAN_BATCH;
    for (int i = 0; i < count; i++) {
        data[i] = (struct iovec){.iov_base = (void *)(uintptr_t)&frame[i], .iov_len = sizeof frame[i]};
        message[i] = (struct mmsghdr){.msg_hdr = {.msg_iov = &data[i], .msg_iovlen = 1}};
    }
    int sent = count > 0 ? sendmmsg(s->fd, message, (unsigned)count, MSG_DONTWAIT) : 0;
    return sent > 0 ? sent : 0;
}

static int64_t timestamp(struct msghdr *message) {
    for (struct cmsghdr *c = CMSG_FIRSTHDR(message); c; c = CMSG_NXTHDR(message, c)) {
        struct timespec t;
        if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SO_TIMESTAMPNS) continue;
        memcpy(&t, CMSG_DATA(c), sizeof t);
        return t.tv_sec * NS_PER_S + t.tv_nsec;
    }
    return can_realtime_ns();
}

int can_socket_receive(const struct can_socket *s, struct can_arrival arrival[CAN_BATCH]) {
    _Alignas(struct cmsghdr) char control[CAN_BATCH][CMSG_SPACE(sizeof(struct timespec)) + CMSG_SPACE(sizeof(int))];
    struct iovec data[CAN_BATCH];
    struct mmsghdr message[CAN_BATCH];
    for (int i = 0; i < CAN_BATCH; i++) {
        data[i] = (struct iovec){.iov_base = &arrival[i].frame, .iov_len = sizeof arrival[i].frame};
        message[i] = (struct mmsghdr){
            .msg_hdr = {.msg_iov = &data[i], .msg_iovlen = 1, .msg_control = control[i], .msg_controllen = sizeof control[i]}};
    }
    int received = recvmmsg(s->fd, message, CAN_BATCH, MSG_DONTWAIT, NULL), good = 0;
    if (received < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR ? 0 : -1;
    for (int i = 0; i < received; i++) {
        if (message[i].msg_len != sizeof(struct can_frame) || arrival[i].frame.len > CAN_MAX_DLEN) continue;
        bool own = !s->confirms || message[i].msg_hdr.msg_flags & MSG_CONFIRM;
        arrival[good++] = (struct can_arrival){.frame = arrival[i].frame, .realtime_ns = timestamp(&message[i].msg_hdr), .own = own};
    }
    return good;
}
