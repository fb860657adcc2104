/* What can fail, how it is seen, and what becomes of it: one table, for the names of faults in
 * messages and results, for what the terminal and HEXID_EVENT tell the operator to do, and for the
 * documentation (`hexid doctor --failures` prints it). */
#ifndef HEXID_FAILURE_H
#define HEXID_FAILURE_H

#include <stdio.h>

#include "types.h"

/* What the platform does on its own. SAFETY: what control can do without parks the platform slowly;
 * what it cannot do without, and what says that somebody may be in danger, centres the valves and
 * takes the supply off at once. */
enum reaction { REACTION_NONE, REACTION_PARK, REACTION_STOP };

struct failure {
    uint32_t fault;       /* FAULT_..., 0: a failure that is no fault of the supervisor's */
    const char *name;     /* what the operator sees: the fault's name, or in words */
    const char *what;
    const char *detected; /* by what */
    const char *within;
    enum reaction reaction;
    const char *platform; /* what it does then */
    const char *cause;    /* the likely ones */
    const char *remedy;   /* what to do, before the platform may move again */
    const char *least_key, *most_key; /* of its limits; NULL: it has no such limit */
    const char *unit;     /* that people read its value in; NULL: nothing is measured */
    double per_si;        /* units in one of SI */
};

/* Ended by a row without a name; first the faults: what else is seen in the same cycle as one
 * follows from it, and stands below. */
extern const struct failure failure_table[];

/* The first row of these faults; NULL where there is none. */
const struct failure *failure_of(uint32_t faults);

/* Its name, "none" for 0. */
const char *fault_name(uint32_t faults);

/* The faults with this reaction. */
uint32_t failure_mask(enum reaction reaction);

/* What an operator is told: name of the first fault, and the legs it was seen at: "following_error,
 * leg 3", "kinematics". */
enum { FAULT_TEXT_SIZE = 64 };
void fault_describe(uint32_t first_fault, uint32_t faults, char text[FAULT_TEXT_SIZE]);

/* Writes the measured value and its limit, as "12.4 mm, limit 10 mm (limits.following_m)", or ""
 * if nothing was measured. Returns text. */
enum { FAULT_MEASURE_SIZE = 104 };
const char *fault_measured(uint32_t first_fault, const struct fault_measure *measure, char text[FAULT_MEASURE_SIZE]);

/* Writes the fault and its measure: "following_error, leg 3: 12.4 mm, limit 10 mm
 * (limits.following_m)". */
enum { FAULT_LINE_SIZE = FAULT_TEXT_SIZE + 2 + FAULT_MEASURE_SIZE };
void fault_line(uint32_t first_fault, uint32_t faults, const struct fault_measure *measure, char text[FAULT_LINE_SIZE]);

/* The same at length: what was seen and the likely cause; then what to do, up to moving again,
 * which an automatic run cannot. missed, longest_s: deadlines missed in a row and the longest
 * delay, told of an overrun. */
enum { FAILURE_TEXT_SIZE = 400 };
void failure_explain(uint32_t first_fault, int64_t missed, double longest_s, bool automatic, char cause[FAILURE_TEXT_SIZE],
                     char remedy[FAILURE_TEXT_SIZE]);

/* The table in Markdown. */
void failure_print(FILE *out);

#endif
