/* A raw SocketCAN socket: frames and receive time stamps; nothing blocks. Only this pair of files
 * opens CAN sockets. */
#ifndef HEXID_CAN_SOCKET_H
#define HEXID_CAN_SOCKET_H

#include <linux/can.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "status.h"

struct can_socket {
    int fd;
    int index;      /* index of the interface; 0: none (a socket pair). An interface that was
                     * deleted and created again has another index, and the socket does not
                     * follow it */
    bool confirms;  /* the kernel marks echoes of own frames; false on a socket pair, where the peer
                     * sends the echoes */
};

/* Frames to accept: id and mask as in the kernel's filter. */
struct can_accept {
    unsigned id, mask;
};

/* Opens a socket. count: number of filters, at most 32; 0: no data frames are received. own: sent
 * frames that the filters accept come back when the bus has carried them. errors: error frames
 * come, too. STATUS_IO: the interface is missing, down, no CAN interface, or not permitted; the
 * error has its name and the remedy. */
int can_socket_open(struct can_socket *s, const char *interface, const struct can_accept *accept, int count, bool own, bool errors,
                    struct error *error);
void can_socket_close(struct can_socket *s);

enum { CAN_INTERFACE_SIZE = 16 }; /* size of an interface's name, the kernel's IFNAMSIZ */

enum can_link { CAN_LINK_UP, CAN_LINK_DOWN, CAN_LINK_GONE };

/* Returns the state of the interface with this name. CAN_LINK_GONE: no interface has this name, or
 * it has another index than `index`. A state that cannot be read counts as CAN_LINK_UP. */
enum can_link can_socket_link(const char *interface, int index);

/* Writes the link's state and the remedy into text; "" for UP. */
void can_link_describe(enum can_link link, const char *interface, char *text, size_t size);

enum { CAN_BATCH = 64 };

/* A received frame. */
struct can_arrival {
    struct can_frame frame;
    int64_t realtime_ns;    /* the kernel's receive time stamp, CLOCK_REALTIME */
    bool own;               /* the frame is the echo of a frame sent on this socket; always true on
                             * a socket pair, which marks no echoes */
};

/* Sends the frames, at most CAN_BATCH, in their order. Returns the number of sent frames, which is
 * smaller if the kernel refuses a frame (queue full, bus-off, interface gone). RT. */
int can_socket_send(const struct can_socket *s, const struct can_frame *frame, int count);

/* Receives frames in their order. Returns their number, which is below CAN_BATCH if no more frames
 * wait; -1: the interface is down or gone. Frames other than classic CAN, which CAN_RAW should not
 * deliver, are skipped. RT. */
int can_socket_receive(const struct can_socket *s, struct can_arrival arrival[CAN_BATCH]);

int64_t can_realtime_ns(void);

/* Returns the arrival time of a frame that the kernel stamped age_ns ago: never after now_ns, and
 * never before before_ns, the arrival time of the previous frame. All times are CLOCK_MONOTONIC. */
int64_t can_came_ns(int64_t now_ns, int64_t age_ns, int64_t before_ns);

#endif
