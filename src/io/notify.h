/* What a service manager is told, by systemd's protocol sd_notify(3): datagrams to the socket that
 * $NOTIFY_SOCKET names. Without that variable nothing is sent, and nothing is wrong. Nothing here
 * blocks: what the manager does not take at once is lost, and the next sign of life comes.
 *
 * SAFETY: the sign of life says that cycles came, not that some thread still runs. */
#ifndef HEXID_NOTIFY_H
#define HEXID_NOTIFY_H

#include <stdbool.h>
#include <stdint.h>

#include "status.h"

struct notify {
    int socket;            /* -1: nobody is told */
    int64_t every_ns;      /* between two signs of life, half of what the manager
                            * allows; 0: it wants none */
    int64_t alive_ns;      /* the last one, CLOCK_MONOTONIC */
    bool ready, stopping;  /* these have been sent */
};

/* From the environment: NOTIFY_SOCKET, WATCHDOG_USEC, WATCHDOG_PID. Before confine(). STATUS_IO:
 * the socket cannot be used; n then tells nobody. */
int notify_open(struct notify *n, struct error *error);

/* One or more lines, as sd_notify(3) has them: "READY=1". Any thread. */
void notify_send(const struct notify *n, const char *lines);

/* A cycle came: a sign of life, where one is due. One thread. */
void notify_alive(struct notify *n);

void notify_close(struct notify *n);

#endif
