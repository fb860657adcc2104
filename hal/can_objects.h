/* Object dictionaries of the nodes: what every object is and which values it takes. Pure tables and
 * rules, no state. config/hexid_node.eds and config/hexid_io.eds say the same for node makers;
 * tests/test_can_files.c holds them together. */
#ifndef HEXID_CAN_OBJECTS_H
#define HEXID_CAN_OBJECTS_H

#include "can_frames.h"

enum {
    CAN_OBJECTS_MAX = 56,       /* of the largest dictionary */
    CAN_HISTORY = 8,            /* errors that 0x1003 keeps */
    CAN_CONSUMERS = 2,          /* heartbeats that 0x1016 can watch */
    CAN_WATCHDOG_MAX_MS = 1000, /* SAFETY: 0x1400:5 takes 1 ms to this: it cannot be switched off */
};

/* RWW: written by an RPDO, read by SDO */
enum can_access { CAN_CONST, CAN_RO, CAN_RW, CAN_WO, CAN_RWW };

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

/* A kind of node: its objects, sorted by index and sub, and what it is commanded. */
struct can_dictionary {
    const struct can_object *object;
    int count;
    uint32_t command;    /* mapping entry of what an RPDO writes, */
    uint16_t actual;     /* and index of what is in force of it, sub 1 */
};
extern const struct can_dictionary can_axis, can_io;

/* Of node 7 and of all others. */
const struct can_dictionary *can_dictionary_of(int node);

/* Place in the table, -1: no such object. */
int can_object_find(const struct can_dictionary *d, uint16_t index, uint8_t sub);

/* SAFETY: the most negative value of a signed object says that there is no
 * reading, or no command. */
bool can_object_lacks(const struct can_object *o, uint32_t value);

/* Abort code for a download of so many bytes (0: the client does not say), 0 when the object takes
 * the value in some state. */
uint32_t can_object_refuses(const struct can_dictionary *d, const struct can_object *o, int size, uint32_t value);

/* Abort code for an entry of the RPDO's mapping, 0 when it can be mapped: the command, or the
 * dummy for INTEGER16. */
uint32_t can_mapping_refuses(const struct can_dictionary *d, uint32_t entry);

/* Index, sub-index and bytes of a mapping entry. */
static inline uint16_t can_entry_index(uint32_t entry) { return (uint16_t)(entry >> 16); }
static inline uint8_t can_entry_sub(uint32_t entry) { return (uint8_t)(entry >> 8); }
static inline int can_entry_bytes(uint32_t entry) { return (int)(entry & 0xff) / 8; }

/* CiA 301, 7.3.5: identifiers that a configurable object must not use. */
bool can_cob_restricted(uint32_t cob);

#endif
