/* The supervisor: a table of states, triggers and next states, and the leaky buckets that turn bad
 * samples into a latched fault. Pure, RT.
 *
 *   init -> settled -> pressurising -> engaging -> ready -> testing -> ready -> parking -> settled
 *   any -> fault -> (reset) init
 *
 * A stop while testing leaves the state unchanged: the test is ramped out, and its end leads to
 * ready.
 *
 * init: valves centred, waiting for plausible sensors. settled: platform put down, valves centred,
 * supply off. pressurising: supply on without pressure yet, valves centred. ready: platform held at
 * neutral. */
#ifndef HEXID_SUPERVISOR_H
#define HEXID_SUPERVISOR_H

#include "failure.h"

enum trigger {
    TRIGGER_NONE,
    TRIGGER_SENSORS_GOOD, /* samples have been good for long enough */
    TRIGGER_ENGAGE,
    TRIGGER_PRESSURE,     /* the supply has pressure */
    TRIGGER_ARRIVED,      /* a move has ended */
    TRIGGER_START,
    TRIGGER_TESTS_DONE,   /* the last test, or the ramp-out after a stop, has ended */
    TRIGGER_STOP,
    TRIGGER_PARK,
    TRIGGER_RESET,
    TRIGGER_FAULT,
};

struct supervisor {
    enum state state;
    uint32_t faults, first_fault; /* latched faults, and the one that is the headline */
    int bad;                      /* level of a leaky bucket of samples with stopping faults */
    int doubtful;                 /* level of a leaky bucket of samples with parking faults */
    int good;                     /* number of consecutive good samples */
    uint32_t request_id;          /* id of the last request that was processed */
};

/* One row of the supervisor's transition table. */
struct transition {
    enum state from;
    enum trigger trigger;
    enum state to;                /* the next state; the same as `from` if the state does not
                                   * change */
    bool ramp_out;                /* the running test is first ramped out */
};

/* Returns the row for a trigger in a state; NULL: the trigger has no effect there. */
const struct transition *supervisor_find(enum state state, enum trigger trigger);

/* Returns a message for the operator: why a command has no effect in this state and with these
 * wrong inputs (interlock.h), and what must be done first. */
const char *supervisor_advice(enum state state, uint32_t wrong, enum command command);

/* Returns true if the valves are driven in this state. */
bool supervisor_drives(enum state state);

/* Returns true if the supply is on in this state. */
bool supervisor_powers(enum state state);

/* Clears faults and buckets, for a reset. */
void supervisor_clear(struct supervisor *s);

/* Counts a sample with these faults (FAULT_... and fault_leg() bits; 0 for a good sample). If the
 * sample is bad and a bucket reaches `limit`, latches the faults and returns the reaction to them.
 * Otherwise returns REACTION_NONE, even if an earlier fault is latched. */
enum reaction supervisor_judge(struct supervisor *s, uint32_t suspect, int limit);

#endif
