/* A raw SocketCAN socket: frames and receive timestamps, nothing blocks. The only file with
 * SocketCAN's API. */
#ifndef HEXID_CAN_SOCKET_H
#define HEXID_CAN_SOCKET_H

#include <linux/can.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "status.h"

struct can_socket {
    int fd;
    int index;      /* of the interface; 0: none, a socket pair. A socket does not follow an
                     * interface that was deleted and made again: that one has another index */
    bool confirms;  /* a frame's own echo is marked (SocketCAN); false on a socket
                     * pair, where the peer echoes */
};

/* Which frames are received: id and mask as in the kernel's filter. */
struct can_accept {
    unsigned id, mask;
};

/* Names the interface and the remedy when it is missing, down, no CAN interface or not allowed:
 * STATUS_IO. With `own`, frames sent come back when the bus has carried them, where the filter lets
 * them; with `errors`, error frames come too. */
int can_socket_open(struct can_socket *s, const char *interface, const struct can_accept *accept, int count, bool own, bool errors,
                    struct error *error);
void can_socket_close(struct can_socket *s);

enum { CAN_INTERFACE_SIZE = 16 }; /* bytes of an interface's name, the kernel's IFNAMSIZ */

enum can_link { CAN_LINK_UP, CAN_LINK_DOWN, CAN_LINK_GONE };

/* Says whether the interface with this name is up and still has that index. GONE: there is none
 * of this name, or it has another index. */
enum can_link can_socket_link(const char *interface, int index);

/* Writes the state of the link in words, with the remedy; "" for UP. */
void can_link_describe(enum can_link link, const char *interface, char *text, size_t size);

enum { CAN_BATCH = 64 };

/* What has come, and when. */
struct can_arrival {
    struct can_frame frame;
    int64_t realtime_ns;    /* CLOCK_REALTIME */
    bool own;               /* the echo of a frame sent here */
};

/* RT. How many of them are on their way, all or those before the first that is refused: queue full,
 * bus-off, interface gone. */
int can_socket_send(const struct can_socket *s, const struct can_frame *frame, int count);

/* RT. How many have come, in their order, fewer than CAN_BATCH when none are left (or one of them
 * was no classic frame, which CAN_RAW never gives); -1: interface down or gone. */
int can_socket_receive(const struct can_socket *s, struct can_arrival arrival[CAN_BATCH]);

int64_t can_realtime_ns(void);

#endif
