/* The supervisor: a table of states, triggers and next states, and the limits that make a fault. Pure, RT.
 *
 *   init -> settled -> engaging -> ready -> testing -> ready ... -> parking -> settled;   any -> fault -> settled (reset)  */
#ifndef HEXID_SUPERVISOR_H
#define HEXID_SUPERVISOR_H

#include "params.h"

enum trigger {
    TRIGGER_NONE,
    TRIGGER_SENSORS_GOOD, /* plausible samples for long enough */
    TRIGGER_ENGAGE,
    TRIGGER_ARRIVED,      /* the move's end is reached */
    TRIGGER_START,
    TRIGGER_TEST_DONE,
    TRIGGER_STOP,
    TRIGGER_PARK,
    TRIGGER_RESET,
    TRIGGER_FAULT,
};

struct supervisor {
    enum state state;
    uint32_t faults, first_fault; /* latched */
    int bad;                      /* leaky bucket of bad samples */
    int good;                     /* consecutive good samples */
    uint32_t request_id;          /* last one acted upon */
};

extern const char *const state_names[STATES];
extern const char *const command_names[COMMANDS];

/* First name of the lowest bit set, "none" for 0. */
const char *fault_name(uint32_t faults);

/* The state after a trigger; the same state when the table has no row for it. */
enum state supervisor_next(enum state state, enum trigger trigger);

/* Valves are driven in this state. */
bool supervisor_drives(enum state state);

#endif
