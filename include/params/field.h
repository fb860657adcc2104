/* Sections of the configuration (params.h) about the field bus: the channels, `device`, `can` and
 * `modbus`. */
#ifndef HEXID_PARAMS_FIELD_H
#define HEXID_PARAMS_FIELD_H

#include "types.h"

/* Scales of one quantity on the field bus, for each leg: si = si_min + (raw - raw_min) / (raw_max -
 * raw_min) (si_max - si_min) + offset. Readings outside low..high (SI, offset included) are
 * implausible. A 4-20 mA or 0-10 V sensor behind a node only needs other numbers. */
struct channel_params {
    double raw_min[LEGS], raw_max[LEGS]; /* raw values on the bus at si_min and at si_max */
    double si_min[LEGS], si_max[LEGS];
    double offset[LEGS];
    double low[LEGS], high[LEGS];
};

struct device_params {            /* settings of the devices on the bus; the daemon writes them to
                                   * the devices if the bus allows */
    double watchdog_s;           /* time without a command after which a device centres its valve */
};

struct can_params {
    double bitrate_bps;
    double heartbeat_s;           /* period of the heartbeats of every node and of the daemon; three
                                   * missing in a row mean that the sender is lost */
    /* Identity that a node must report (objects 0x1000, 0x1018:1, 0x1018:2). Values are rounded to
     * integers; -1: any identity is accepted. */
    double device_type, vendor_id, product_code;          /* identity of axis nodes */
    double io_device_type, io_vendor_id, io_product_code; /* identity of node 7, inputs and
                                                           * outputs */
};

struct modbus_params {
    int unit;                     /* slave address of the device */
};

#endif
