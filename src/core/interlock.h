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

/* An input travels twice, as antivalent contacts send it (the idea of CiA 304): INPUT_... is set
 * while it is closed, the same bit shifted by INPUT_INVERSE while it is open. SAFETY: so a wire
 * that breaks, an input that is stuck and a device that sends zeros or ones contradict
 * themselves. */
enum { INPUT_INVERSE = 4 };

struct interlock_reading {
    uint32_t closed;       /* INPUT_...: both contacts say so, or the only one */
    uint32_t contradicted; /* INPUT_...: both contacts say the same */
};

/* Returns the byte that a device sends for these closed inputs: bits 0..3 plain, 4..7 inverse. */
uint32_t interlock_bits(uint32_t closed);

/* Reads the inputs from bits 0..7; without p->antivalent bits 4..7 are ignored. */
struct interlock_reading interlock_read(const struct interlock_params *p, uint32_t bits);

/* How long each input has contradicted itself, in cycles. */
struct interlock_watch {
    int64_t cycles[INPUTS];
};

/* Counts a cycle with these contradictions (INPUT_...). Returns those of wired inputs that have
 * lasted longer than p->discrepancy_s: contacts do not switch at the same instant. */
uint32_t interlock_contradicts(struct interlock_watch *w, const struct interlock_params *p, uint32_t contradicted, double period_s);

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
