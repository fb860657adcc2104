/* State of a CAN interface as the kernel reports it: bit rate, controller state, error counters, as
 * in `ip -details -statistics link show`. Ordinary threads. Nothing is changed, and nothing is sent
 * on the bus. */
#ifndef HEXID_CAN_CONTROLLER_H
#define HEXID_CAN_CONTROLLER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "status.h"

/* Controller states, numbered as in the kernel (enum can_state of linux/can/netlink.h). In bus-off
 * a controller sends nothing. */
enum { CAN_CONTROLLER_ACTIVE, CAN_CONTROLLER_WARNING, CAN_CONTROLLER_PASSIVE, CAN_CONTROLLER_BUS_OFF };

struct can_controller {
    char kind[16];             /* kind of the interface: "can" has a controller, "vcan" and "vxcan"
                                * do not */
    bool known;                 /* the interface has a controller; false: the members below are 0,
                                 * except rx_dropped and tx_dropped */
    uint32_t bitrate_bps;       /* bit rate; 0: not reported by the driver, or not set */
    double sample_point;        /* sample point as a share of a bit; 0: unknown */
    int state;                  /* state of the controller, CAN_CONTROLLER_..., or 4 (stopped) or 5
                                 * (sleeping) */
    bool counts;          /* the controller reports its error counters (ISO 11898-1: TEC and REC) */
    unsigned tx_errors, rx_errors;
    /* numbers of events since the interface was created */
    uint32_t bus_errors, arbitration_lost, warnings, passives, bus_offs, restarts;
    uint64_t rx_dropped, tx_dropped; /* number of received, and of sent frames that the kernel
                                      * dropped */
};

/* Returns the name of a state, such as "error-active". */
const char *can_controller_state(int state);

/* Reads the state of an interface. STATUS_IO: the state cannot be read; the error has the interface
 * and the reason. */
int can_controller_read(const char *interface, struct can_controller *s, struct error *error);

/* Parses an RTM_NEWLINK message with its netlink header. Returns false if the message is another
 * one or incomplete. Pure. */
bool can_controller_parse(const void *message, size_t size, struct can_controller *s);

#endif
