/* Object dictionaries of the nodes: all objects and the values that they accept. Pure tables and
 * rules, no state. config/hexid_node.eds and config/hexid_io.eds describe the same objects for
 * makers of nodes; tests/test_can_files.c compares the two. */
#ifndef HEXID_CAN_OBJECTS_H
#define HEXID_CAN_OBJECTS_H

#include "can_frames.h"

enum {
    CAN_OBJECTS_MAX = 56,       /* number of objects in the largest dictionary */
    CAN_HISTORY = 8,            /* number of errors kept in 0x1003 */
    CAN_CONSUMERS = 2,          /* number of masters whose heartbeats 0x1016 can watch */
    CAN_WATCHDOG_MAX_MS = 1000, /* SAFETY: largest watchdog time in 0x1400:5; the smallest is 1 ms,
                                 * so that the watchdog cannot be switched off */
};

/* Access to an object. CAN_RWW: an RPDO writes the object, and SDO only reads it. */
enum can_access { CAN_CONST, CAN_RO, CAN_RW, CAN_WO, CAN_RWW };

struct can_object {
    uint16_t index;
    uint8_t sub, size;   /* `size` is the number of bytes */
    enum can_access access;
    bool is_signed;
    bool plus_node;      /* the default is value + node id */
    uint32_t value;      /* default value */
    uint32_t low, high;  /* range of written values; high 0: no limits */
    const char *name;
};

/* A kind of node: its objects, sorted by index and sub, and its command. */
struct can_dictionary {
    const struct can_object *object;
    int count;
    uint32_t command;    /* mapping entry of the object that an RPDO writes */
    uint16_t actual;     /* index of the object with the value in force; its sub-index is 1 */
};
extern const struct can_dictionary can_axis, can_io;

/* Returns the dictionary of node 7 (can_io) or of any other node (can_axis). */
const struct can_dictionary *can_dictionary_of(int node);

/* Returns the object's position in the table; -1: no such object. */
int can_object_find(const struct can_dictionary *d, uint16_t index, uint8_t sub);

/* SAFETY: the most negative value of a signed object means that there is no reading, or no command.
 * Returns true for that value. */
bool can_object_lacks(const struct can_object *o, uint32_t value);

/* Checks a download against the object's size and range and against other rules that do not depend
 * on the node's state. Returns the abort code, or 0 if the value is permitted; can_server.c then
 * checks the state, and refuses objects with CAN_RWW. size: number of bytes that the client
 * indicates; 0: not indicated. */
uint32_t can_object_refuses(const struct can_dictionary *d, const struct can_object *o, int size, uint32_t value);

/* Return index, sub-index and size in bytes of a mapping entry. */
static inline uint16_t can_entry_index(uint32_t entry) { return (uint16_t)(entry >> 16); }
static inline uint8_t can_entry_sub(uint32_t entry) { return (uint8_t)(entry >> 8); }
static inline int can_entry_bytes(uint32_t entry) { return (int)(entry & 0xff) / 8; }

#endif
