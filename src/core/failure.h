/* What can fail, how it is seen, and what becomes of it: one table, for the names of faults in
 * messages and results, for what the terminal and HEXID_EVENT tell the operator to do, and for the
 * documentation (`hexid doctor --failures` prints it). */
#ifndef HEXID_FAILURE_H
#define HEXID_FAILURE_H

#include <stdio.h>

#include "types.h"

struct failure {
    uint32_t fault;       /* FAULT_..., 0: a failure that is no fault of the supervisor's */
    const char *name;     /* what the operator sees: the fault's name, or in words */
    const char *what;
    const char *detected; /* by what */
    const char *within;
    const char *platform; /* what it does then */
    const char *cause;    /* the likely ones */
    const char *remedy;   /* what to do, before the platform may move again */
};

/* Ended by a row without a name; first the faults, in the order of their bits. */
extern const struct failure failure_table[];

/* The row of the lowest fault that is set; NULL where none is. */
const struct failure *failure_of(uint32_t faults);

/* Name of the lowest bit set, "none" for 0. */
const char *fault_name(uint32_t faults);

/* What an operator is told: name of the first fault, and the legs it was seen at: "following_error,
 * leg 3", "kinematics". */
enum { FAULT_TEXT_SIZE = 64 };
void fault_describe(uint32_t first_fault, uint32_t faults, char text[FAULT_TEXT_SIZE]);

/* The same at length: what was seen and the likely cause; then what to do, up to moving again, which
 * an automatic run cannot. missed, longest_s: deadlines missed in a row and the longest delay, told
 * of an overrun. */
enum { FAILURE_TEXT_SIZE = 320 };
void failure_explain(uint32_t first_fault, int64_t missed, double longest_s, bool automatic, char cause[FAILURE_TEXT_SIZE],
                     char remedy[FAILURE_TEXT_SIZE]);

/* The table in Markdown. */
void failure_print(FILE *out);

#endif
