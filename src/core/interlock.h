/* The machine's digital inputs: which of them must be closed, their names, and the fault that an
 * open input causes. Pure, RT. */
#ifndef HEXID_INTERLOCK_H
#define HEXID_INTERLOCK_H

#include <stddef.h>

#include "types.h"

struct interlock_params;

struct interlock {
    uint32_t input, fault;
    const char *name;     /* name of the input: "emergency stop" */
    const char *open;     /* message for an open input, with the remedy */
};
extern const struct interlock interlock_table[INPUTS];

/* If interlocks.antivalent is set, each input is sent twice, as by antivalent contacts (the idea of
 * CiA 304): bit INPUT_... is set while the input is closed, and the same bit shifted left by
 * INPUT_INVERSE is set while the input is open. SAFETY: broken wires, stuck inputs and devices that
 * send only zeros or ones thus show as contradictions. */
enum { INPUT_INVERSE = 4 };

struct interlock_reading {
    uint32_t closed;       /* inputs (INPUT_...) that both contacts, or the only contact, show as
                            * closed */
    uint32_t contradicted; /* inputs (INPUT_...) whose two contacts have the same state */
};

/* Returns the byte that a device sends for these closed inputs: bits 0..3 plain, 4..7 inverse, or 0
 * without p->antivalent. */
uint32_t interlock_bits(const struct interlock_params *p, uint32_t closed);

/* Reads the inputs from bits 0..7; without p->antivalent bits 4..7 are ignored. */
struct interlock_reading interlock_read(const struct interlock_params *p, uint32_t bits);

/* Number of cycles in a row in which the two contacts of each input have contradicted each
 * other. */
struct interlock_watch {
    int64_t cycles[INPUTS];
};

/* Counts a cycle in which the two contacts of these inputs (INPUT_...) contradict each other.
 * Returns the wired inputs whose contacts have contradicted each other for longer than
 * p->discrepancy_s. Shorter contradictions are normal, because contacts do not switch at the same
 * instant. */
uint32_t interlock_contradicts(struct interlock_watch *w, const struct interlock_params *p, uint32_t contradicted, double period_s);

/* Returns the bits INPUT_... of the wired inputs. */
uint32_t interlock_wired(const struct interlock_params *p);

/* Returns the wired inputs that are wrong. inputs: the closed ones. While the supply is on
 * (`powered`), every open input is wrong; while it is off, INPUT_SUPPLY may be open. SAFETY:
 * pressure while the supply is off adds INPUT_LINGERS if pressure switch and supply output are
 * wired, because it means a welded relay or a stuck dump valve. */
uint32_t interlock_wrong(const struct interlock_params *p, bool powered, uint32_t inputs);

/* Returns true if any input, or the supply output, is wired, so that an I/O device is needed. */
bool interlock_any(const struct interlock_params *p);

/* Returns the faults FAULT_... that these open inputs cause. */
uint32_t interlock_faults(uint32_t open);

/* Describes the first wrong input in words; NULL for 0. */
const char *interlock_why(uint32_t wrong);

/* Lists inputs by name: "emergency stop, door". */
void interlock_names(uint32_t inputs, char *text, size_t size);

/* Lists the wired inputs and the missing ones, each with the supply output: "emergency stop, door;
 * NOT WIRED, so not watched: enable switch". Returns true if all are wired. */
bool interlock_describe(const struct interlock_params *p, char *text, size_t size);

#endif
