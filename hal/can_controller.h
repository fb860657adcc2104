/* What the kernel says of a CAN interface: bit rate, state of the controller, error counters;
 * `ip -details -statistics link show` has the same. The only file with rtnetlink. Ordinary threads;
 * changes nothing, sends nothing on the bus. */
#ifndef HEXID_CAN_CONTROLLER_H
#define HEXID_CAN_CONTROLLER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "status.h"

/* The kernel's (enum can_state of linux/can/netlink.h); from bus-off on nothing is sent. */
enum { CAN_CONTROLLER_ACTIVE, CAN_CONTROLLER_WARNING, CAN_CONTROLLER_PASSIVE, CAN_CONTROLLER_BUS_OFF };

struct can_controller {
    char kind[16];              /* "can": a controller; "vcan", "vxcan": none behind it */
    bool known;                 /* it is a controller, and what follows is known */
    uint32_t bitrate_bps;       /* 0: the driver does not tell, or none is set */
    double sample_point;        /* share of a bit, 0: unknown */
    int state;                  /* CAN_CONTROLLER_... */
    bool counts;                /* the controller shows its error counters (CiA, ISO
                                 * 11898-1: TEC and REC), */
    unsigned tx_errors, rx_errors;
    /* and since the interface was made: */
    uint32_t bus_errors, arbitration_lost, warnings, passives, bus_offs, restarts;
    uint64_t rx_dropped, tx_dropped; /* frames, by the kernel */
};

/* "error-active" and so on. */
const char *can_controller_state(int state);

/* -3 with the interface and the reason. */
int can_controller_read(const char *interface, struct can_controller *s, struct error *error);

/* An RTM_NEWLINK message, its netlink header included; false where it is none, or
 * not whole. Pure. */
bool can_controller_parse(const void *message, size_t size, struct can_controller *s);

#endif
