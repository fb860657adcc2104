/* Object dictionary of an axis node: what every object is and which values it takes. Pure tables and rules, no state.
 * config/hexid_node.eds says the same for node makers; tests/test_can_files.c holds the two together. */
#ifndef HEXID_CAN_OBJECTS_H
#define HEXID_CAN_OBJECTS_H

#include "can_frames.h"

enum {
    CAN_OBJECTS = 56,
    CAN_HISTORY = 8,            /* errors that 0x1003 keeps */
    CAN_CONSUMERS = 2,          /* heartbeats that 0x1016 can watch */
    CAN_WATCHDOG_MAX_MS = 1000, /* SAFETY: 0x1400:5 takes 1 ms to this: it cannot be switched off */
};

enum can_access { CAN_CONST, CAN_RO, CAN_RW, CAN_WO, CAN_RWW }; /* RWW: written by an RPDO, read by SDO */

struct can_object {
    uint16_t index;
    uint8_t sub, size;   /* bytes */
    enum can_access access;
    bool is_signed;
    bool plus_node;      /* the default is value + node id */
    uint32_t value;      /* default */
    uint32_t low, high;  /* what may be written; high 0: no such limit */
    const char *name;
};
extern const struct can_object can_objects[CAN_OBJECTS];

/* Place in the table, -1: no such object. */
int can_object_find(uint16_t index, uint8_t sub);

/* Abort code for a download of so many bytes (0: the client does not say), 0 when the object takes the value in some state. */
uint32_t can_object_refuses(const struct can_object *o, int size, uint32_t value);

/* Abort code for an entry of the RPDO's mapping, 0 when it can be mapped: the valve, or the dummy for INTEGER16. */
uint32_t can_mapping_refuses(uint32_t entry);

/* CiA 301, 7.3.5: identifiers that a configurable object must not use. */
bool can_cob_restricted(uint32_t cob);

#endif
