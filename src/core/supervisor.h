/* The supervisor: a table of states, triggers and next states, and the bucket that turns bad
 * samples into a latched fault. Pure, RT.
 *
 *   init -> settled -> pressurising -> engaging -> ready -> testing -> ready -> parking -> settled
 *   any -> fault -> (reset) init
 *
 * A stop in testing has a row that keeps the state: the test ramps out, and its end leads to ready.
 *
 * init: valves centred, waiting for plausible sensors. settled: put down, valves centred, supply
 * off. pressurising: the supply is put on, valves centred. ready: held at neutral. */
#ifndef HEXID_SUPERVISOR_H
#define HEXID_SUPERVISOR_H

#include "failure.h"
#include "params.h"

enum trigger {
    TRIGGER_NONE,
    TRIGGER_SENSORS_GOOD, /* plausible samples for long enough */
    TRIGGER_ENGAGE,
    TRIGGER_PRESSURE,     /* the supply is there */
    TRIGGER_ARRIVED,      /* a move's end is reached */
    TRIGGER_START,
    TRIGGER_TESTS_DONE,   /* the last one, or a stop after its ramp-out */
    TRIGGER_STOP,
    TRIGGER_PARK,
    TRIGGER_RESET,
    TRIGGER_FAULT,
};

struct supervisor {
    enum state state;
    uint32_t faults, first_fault; /* latched */
    int bad;                      /* leaky bucket of samples that control cannot do with, */
    int doubtful;                 /* and of those that it can */
    int good;                     /* good samples in a row */
    uint32_t request_id;          /* last one acted upon */
};

/* One row of the table. */
struct transition {
    enum state from;
    enum trigger trigger;
    enum state to;                /* may be `from`: the state goes on */
    bool ramp_out;                /* the test under way ends early, by its ramp-out, before what
                                   * `to` does */
};

/* The row for a trigger in a state; NULL: the trigger does nothing there. */
const struct transition *supervisor_find(enum state state, enum trigger trigger);

/* Why a command does nothing in this state, with this wrong with the inputs (interlock.h), and what
 * to do first; for the operator. */
const char *supervisor_advice(enum state state, uint32_t wrong, enum command command);

/* Valves are driven in this state. */
bool supervisor_drives(enum state state);

/* The supply is on in this state. */
bool supervisor_powers(enum state state);

/* Forgets faults and doubts: a reset. */
void supervisor_clear(struct supervisor *s);

/* Counts a sample with these doubts (FAULT_... and fault_leg() bits, 0 for a good one): what is to
 * be done about what became, or is, a latched fault. */
enum reaction supervisor_judge(struct supervisor *s, uint32_t suspect, int limit);

#endif
