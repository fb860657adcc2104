#include "interlock.h"

#include <stdio.h>
#include <string.h>

#include "params/interlocks.h"

const struct interlock interlock_table[INPUTS] = {
    {INPUT_EMERGENCY_STOP, FAULT_EMERGENCY_STOP, "emergency stop",
     "the emergency stop's chain is open: see that nobody is in danger, then release it"},
    {INPUT_ENABLE, FAULT_ENABLE, "enable switch", "the enable switch is not held: hold it"},
    {INPUT_DOOR, FAULT_DOOR, "door", "the door is open: see that nobody is inside, then close it"},
    {INPUT_SUPPLY, FAULT_SUPPLY, "supply pressure", "the supply has no pressure: look at the power unit"},
};

uint32_t interlock_bits(const struct interlock_params *p, uint32_t closed) {
    uint32_t inverse = p->antivalent ? ~closed & INPUTS_ALL : 0;
    return (closed & INPUTS_ALL) | inverse << INPUT_INVERSE;
}

struct interlock_reading interlock_read(const struct interlock_params *p, uint32_t bits) {
    uint32_t plain = bits & INPUTS_ALL, inverse = bits >> INPUT_INVERSE & INPUTS_ALL;
    if (!p->antivalent) return (struct interlock_reading){.closed = plain};
    return (struct interlock_reading){.closed = plain & ~inverse, .contradicted = ~(plain ^ inverse) & INPUTS_ALL};
}

uint32_t interlock_contradicts(struct interlock_watch *w, const struct interlock_params *p, uint32_t contradicted, double period_s) {
    uint32_t lasting = 0;
    contradicted &= interlock_wired(p);
    for (int i = 0; i < INPUTS; i++) {
        w->cycles[i] = contradicted & interlock_table[i].input ? w->cycles[i] + 1 : 0;
        if ((double)w->cycles[i] * period_s > p->discrepancy_s) lasting |= interlock_table[i].input;
    }
    return lasting;
}

uint32_t interlock_wired(const struct interlock_params *p) {
    return (p->emergency_stop ? INPUT_EMERGENCY_STOP : 0u) | (p->enable ? INPUT_ENABLE : 0u) | (p->door ? INPUT_DOOR : 0u) |
           (p->pressure ? INPUT_SUPPLY : 0u);
}

uint32_t interlock_wrong(const struct interlock_params *p, bool powered, uint32_t inputs) {
    uint32_t open = interlock_wired(p) & ~inputs;
    bool lingers = !powered && p->pressure && p->supply && inputs & INPUT_SUPPLY;
    return powered ? open : (open & ~(uint32_t)INPUT_SUPPLY) | (lingers ? INPUT_LINGERS : 0u);
}

bool interlock_any(const struct interlock_params *p) { return interlock_wired(p) || p->supply; }

uint32_t interlock_faults(uint32_t open) {
    uint32_t faults = 0;
    for (int i = 0; i < INPUTS; i++)
        if (open & interlock_table[i].input) faults |= interlock_table[i].fault;
    return faults;
}

const char *interlock_why(uint32_t wrong) {
    for (int i = 0; i < INPUTS; i++)
        if (wrong & interlock_table[i].input) return interlock_table[i].open;
    return wrong & INPUT_LINGERS
               ? "the supply has pressure although it is off: wait until it is gone; if it stays, look at its relay and the dump valve"
               : NULL;
}

/* Writes the names of these inputs, and of the supply output if `supply`. Returns their number. */
static int list(uint32_t inputs, bool supply, char *text, size_t size) {
    int count = 0;
    *text = '\0';
    for (int i = 0; i < INPUTS; i++) {
        size_t used = strlen(text);
        if (inputs & interlock_table[i].input) snprintf(text + used, size - used, "%s%s", count++ ? ", " : "", interlock_table[i].name);
    }
    size_t used = strlen(text);
    if (supply) snprintf(text + used, size - used, "%ssupply output", count++ ? ", " : "");
    return count;
}

void interlock_names(uint32_t inputs, char *text, size_t size) { list(inputs, false, text, size); }

bool interlock_describe(const struct interlock_params *p, char *text, size_t size) {
    uint32_t wired = interlock_wired(p);
    char there[120], missing[120];
    int watched = list(wired, p->supply, there, sizeof there);
    int not = list(INPUTS_ALL & ~wired, !p->supply, missing, sizeof missing);
    snprintf(text, size, "%s%s%s", watched ? there : "none", not ? "; NOT WIRED, so not watched: " : "", missing);
    return !not;
}
