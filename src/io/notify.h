/* Reports to a service manager by systemd's protocol sd_notify(3): datagrams to the socket that
 * $NOTIFY_SOCKET names. Without that variable nothing is sent, which is no error. Nothing here
 * blocks: a datagram that the manager does not accept at once is lost, and a later "WATCHDOG=1"
 * replaces it.
 *
 * SAFETY: "WATCHDOG=1" is sent only when cycles of the loop arrive, so it proves more than that
 * some thread still runs. */
#ifndef HEXID_NOTIFY_H
#define HEXID_NOTIFY_H

#include <stdbool.h>
#include <stdint.h>

#include "status.h"

struct notify {
    int socket;            /* socket to the service manager; -1: there is none */
    int64_t every_ns;      /* time between two "WATCHDOG=1", half of the time that the manager
                            * allows; 0: it wants none */
    int64_t alive_ns;      /* time of the last "WATCHDOG=1", CLOCK_MONOTONIC */
    bool ready, stopping;  /* "READY=1" and "STOPPING=1" were already sent */
};

/* Opens the socket that $NOTIFY_SOCKET names, and takes the time between two "WATCHDOG=1" from
 * $WATCHDOG_USEC if $WATCHDOG_PID is this process or not set. To be called before confine().
 * STATUS_IO: the socket cannot be used; n then sends nothing. */
int notify_open(struct notify *n, struct error *error);

/* Sends one or more lines as in sd_notify(3), "READY=1". Any thread. */
void notify_send(const struct notify *n, const char *lines);

/* Sends "WATCHDOG=1" if it is due; to be called for each cycle. One thread. */
void notify_alive(struct notify *n);

void notify_close(struct notify *n);

#endif
