#include "supervisor.h"

#include <limits.h>
#include <stddef.h>

#include "interlock.h"

enum { AT_ONCE = false, RAMP_OUT = true };

/* A trigger without a row has no effect. SAFETY: every state has a row for a fault, except
 * STATE_FAULT itself; the only way from fault to a driven state is reset, good sensors, engage and
 * pressure. */
static const struct transition transitions[] = {
    {STATE_INIT, TRIGGER_SENSORS_GOOD, STATE_SETTLED, AT_ONCE},
    {STATE_SETTLED, TRIGGER_ENGAGE, STATE_PRESSURISING, AT_ONCE},
    {STATE_PRESSURISING, TRIGGER_PRESSURE, STATE_ENGAGING, AT_ONCE},
    {STATE_PRESSURISING, TRIGGER_STOP, STATE_SETTLED, AT_ONCE},
    {STATE_PRESSURISING, TRIGGER_PARK, STATE_SETTLED, AT_ONCE},
    {STATE_ENGAGING, TRIGGER_ARRIVED, STATE_READY, AT_ONCE},
    {STATE_ENGAGING, TRIGGER_STOP, STATE_PARKING, AT_ONCE},
    {STATE_ENGAGING, TRIGGER_PARK, STATE_PARKING, AT_ONCE},
    {STATE_READY, TRIGGER_START, STATE_TESTING, AT_ONCE},
    {STATE_READY, TRIGGER_PARK, STATE_PARKING, AT_ONCE},
    {STATE_TESTING, TRIGGER_TESTS_DONE, STATE_READY, AT_ONCE},
    {STATE_TESTING, TRIGGER_STOP, STATE_TESTING, RAMP_OUT},
    {STATE_TESTING, TRIGGER_PARK, STATE_PARKING, RAMP_OUT},
    {STATE_PARKING, TRIGGER_ARRIVED, STATE_SETTLED, AT_ONCE},
    {STATE_INIT, TRIGGER_FAULT, STATE_FAULT, AT_ONCE},
    {STATE_SETTLED, TRIGGER_FAULT, STATE_FAULT, AT_ONCE},
    {STATE_PRESSURISING, TRIGGER_FAULT, STATE_FAULT, AT_ONCE},
    {STATE_ENGAGING, TRIGGER_FAULT, STATE_FAULT, AT_ONCE},
    {STATE_READY, TRIGGER_FAULT, STATE_FAULT, AT_ONCE},
    {STATE_TESTING, TRIGGER_FAULT, STATE_FAULT, AT_ONCE},
    {STATE_PARKING, TRIGGER_FAULT, STATE_FAULT, AT_ONCE},
    {STATE_FAULT, TRIGGER_RESET, STATE_INIT, AT_ONCE},
};

const struct transition *supervisor_find(enum state state, enum trigger trigger) {
    for (unsigned i = 0; trigger != TRIGGER_NONE && i < sizeof transitions / sizeof *transitions; i++)
        if (transitions[i].from == state && transitions[i].trigger == trigger) return &transitions[i];
    return NULL;
}

const char *supervisor_advice(enum state state, uint32_t wrong, enum command command) {
    static const char *const first[STATES] = {
        [STATE_INIT] = "the sensors are not believed yet: wait for `settled`, or see `hexid monitor` for what they say",
        [STATE_SETTLED] = "the platform is put down: `hexid command engage` first",
        [STATE_PRESSURISING] = "the supply is being put on: wait for `ready`",
        [STATE_ENGAGING] = "the platform is rising: wait for `ready`",
        [STATE_READY] = "the platform is held at neutral: `start` or `park`",
        [STATE_TESTING] = "tests are under way: `stop` or `park` first",
        [STATE_PARKING] = "the platform is being put down: wait until it stands",
        [STATE_FAULT] = "a fault is latched: mend its cause, then `hexid command reset`",
    };
    static const char doubtful[] = "the last sample was doubtful: ask again";
    if (command == COMMAND_RESET && state != STATE_FAULT && state != STATE_PARKING) return "there is no fault to reset";
    if (command_stops(command) && !supervisor_drives(state)) return "nothing moves: the valves are centred";
    if (command == COMMAND_SET && (state == STATE_READY || state == STATE_SETTLED))
        return "not at rest in that cycle, or changed within the last second, or the integral has no room for it: ask again";
    if (command == COMMAND_SET) return "gains are changed where the platform is held or put down: in `ready` or `settled`";
    if (command == COMMAND_ENGAGE && state == STATE_READY) return "the platform is engaged already: `start` or `park`";
    if (command == COMMAND_ENGAGE && state == STATE_SETTLED) return wrong ? interlock_why(wrong) : doubtful;
    if (command == COMMAND_START && state == STATE_READY) return doubtful;
    return first[state];
}

bool supervisor_drives(enum state state) {
    return state == STATE_ENGAGING || state == STATE_READY || state == STATE_TESTING || state == STATE_PARKING;
}

bool supervisor_powers(enum state state) { return supervisor_drives(state) || state == STATE_PRESSURISING; }

void supervisor_clear(struct supervisor *s) {
    s->faults = s->first_fault = 0;
    s->good = s->bad = s->doubtful = 0;
}

/* SAFETY: counts a sample in a leaky bucket; returns true if the faults must be latched. The bucket
 * rises by one with each bad sample and falls by one with each good sample. At `limit` the faults
 * are latched; below it the last command is held. A limit of 1 tolerates no bad sample. */
static bool full(int *bucket, uint32_t suspect, int limit) {
    if (suspect) *bucket += *bucket < limit;
    else *bucket -= *bucket > 0;
    return suspect && *bucket >= limit;
}

enum reaction supervisor_judge(struct supervisor *s, uint32_t suspect, int limit) {
    uint32_t parks = failures_with(REACTION_PARK, suspect), stops = failures_with(REACTION_STOP, suspect);
    bool stop = full(&s->bad, stops, limit), park = full(&s->doubtful, parks, limit);
    s->good = suspect ? 0 : s->good + (s->good < INT_MAX);
    if (!stop && !park) return REACTION_NONE;
    /* The first fault is the headline. If a fault stops the platform while it is being parked
     * because of another fault, the fault that stops becomes the headline. */
    if (!s->first_fault || (stop && failures_with(REACTION_PARK, s->first_fault))) s->first_fault = failure_of(stop ? stops : parks)->fault;
    s->faults |= (stop ? stops : 0) | (park ? parks : 0) | (suspect & FAULT_LEGS);
    return stop ? REACTION_STOP : REACTION_PARK;
}
