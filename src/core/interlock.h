/* The machine's inputs: which must be closed, what an open one is called, and which fault
 * it is. Pure, RT. */
#ifndef HEXID_INTERLOCK_H
#define HEXID_INTERLOCK_H

#include <stddef.h>

#include "params.h"

struct interlock {
    uint32_t input, fault;
    const char *name;     /* "emergency stop" */
    const char *open;     /* in words, and what to do */
};
extern const struct interlock interlock_table[INPUTS];

/* INPUT_... that are wired. */
uint32_t interlock_wired(const struct interlock_params *p);

/* What is wrong with these inputs: those that are needed and open, the supply's pressure only where
 * the supply is on. SAFETY: where it is off and both its input and its output are wired, pressure
 * is wrong, INPUT_LINGERS: a relay that is welded, a dump valve that is stuck. */
uint32_t interlock_wrong(const struct interlock_params *p, bool powered, uint32_t inputs);

/* Any input or output is: there is something to talk to. */
bool interlock_any(const struct interlock_params *p);

/* FAULT_... of open inputs. */
uint32_t interlock_faults(uint32_t open);

/* The first of what is wrong, in words; NULL for 0. */
const char *interlock_why(uint32_t wrong);

/* What is wired and what is not: "emergency stop, door; NOT WIRED, so not watched: enable switch".
 * True when all is. */
bool interlock_describe(const struct interlock_params *p, char *text, size_t size);

#endif
