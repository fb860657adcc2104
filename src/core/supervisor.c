#include "supervisor.h"

#include <limits.h>

/* What is not in the table does nothing. SAFETY: every state has a row for a fault; there is no way from
 * fault to a driven state but reset, good sensors and engage. */
static const struct transition {
    enum state from;
    enum trigger trigger;
    enum state to;
} transitions[] = {
    {STATE_INIT, TRIGGER_SENSORS_GOOD, STATE_SETTLED},
    {STATE_SETTLED, TRIGGER_ENGAGE, STATE_ENGAGING},
    {STATE_ENGAGING, TRIGGER_ARRIVED, STATE_READY},
    {STATE_ENGAGING, TRIGGER_STOP, STATE_PARKING},
    {STATE_ENGAGING, TRIGGER_PARK, STATE_PARKING},
    {STATE_READY, TRIGGER_START, STATE_TESTING},
    {STATE_READY, TRIGGER_PARK, STATE_PARKING},
    {STATE_TESTING, TRIGGER_TESTS_DONE, STATE_READY},
    {STATE_TESTING, TRIGGER_PARK, STATE_PARKING},
    {STATE_PARKING, TRIGGER_ARRIVED, STATE_SETTLED},
    {STATE_INIT, TRIGGER_FAULT, STATE_FAULT},
    {STATE_SETTLED, TRIGGER_FAULT, STATE_FAULT},
    {STATE_ENGAGING, TRIGGER_FAULT, STATE_FAULT},
    {STATE_READY, TRIGGER_FAULT, STATE_FAULT},
    {STATE_TESTING, TRIGGER_FAULT, STATE_FAULT},
    {STATE_PARKING, TRIGGER_FAULT, STATE_FAULT},
    {STATE_FAULT, TRIGGER_RESET, STATE_INIT},
};

enum state supervisor_next(enum state state, enum trigger trigger) {
    for (unsigned i = 0; i < sizeof transitions / sizeof *transitions; i++)
        if (transitions[i].from == state && transitions[i].trigger == trigger) return transitions[i].to;
    return state;
}

const char *supervisor_advice(enum state state, enum command command) {
    static const char *const first[STATES] = {
        [STATE_INIT] = "the sensors are not believed yet: wait for `settled`, or see `hexid monitor` for what they say",
        [STATE_SETTLED] = "the platform is put down: `hexid command engage` first",
        [STATE_ENGAGING] = "the platform is rising: wait for `ready`",
        [STATE_READY] = "the platform is held at neutral: `start` or `park`",
        [STATE_TESTING] = "tests are under way: `stop` or `park` first",
        [STATE_PARKING] = "the platform is being put down: wait for `settled`",
        [STATE_FAULT] = "a fault is latched: mend its cause, then `hexid command reset`",
    };
    if (command == COMMAND_RESET && state != STATE_FAULT) return "there is no fault to reset";
    if (command_stops(command) && !supervisor_drives(state)) return "nothing moves: the valves are centred";
    if (command == COMMAND_ENGAGE && state == STATE_READY) return "the platform is engaged already: `start` or `park`";
    return first[state];
}

bool supervisor_drives(enum state state) {
    return state == STATE_ENGAGING || state == STATE_READY || state == STATE_TESTING || state == STATE_PARKING;
}

void supervisor_clear(struct supervisor *s) {
    s->faults = s->first_fault = 0;
    s->good = s->bad = 0;
}

/* SAFETY: a single bad sample is ridden out with the command held; `limit` bad ones more than good ones latch what was wrong. */
bool supervisor_judge(struct supervisor *s, uint32_t suspect, int limit) {
    if (suspect) s->bad += s->bad < limit;
    else s->bad -= s->bad > 0;
    s->good = suspect ? 0 : s->good + (s->good < INT_MAX);
    if (s->bad < limit) return false;
    /* The lowest bit: legs stand above all faults. What another master does to the machine is not the machine's. */
    if (!s->first_fault) s->first_fault = suspect & FAULT_MASTER ? FAULT_MASTER : suspect & (~suspect + 1u);
    s->faults |= suspect;
    return suspect != 0;
}
