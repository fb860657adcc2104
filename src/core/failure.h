/* Failures, how each is detected, and how the platform reacts. The names of faults in messages and
 * results, the operator's instructions on the terminal and in HEXID_EVENT, and the table of the
 * documentation (printed by `hexid doctor --failures`) all come from here. */
#ifndef HEXID_FAILURE_H
#define HEXID_FAILURE_H

#include <stdio.h>

#include "types.h"

/* The platform's automatic reaction. SAFETY: the platform is parked slowly after failures that
 * control can tolerate. After all others, and after failures that may mean danger to people, the
 * valves are centred and the supply is switched off at once. */
enum reaction { REACTION_NONE, REACTION_PARK, REACTION_STOP };

struct failure {
    uint32_t fault;       /* one of FAULT_...; 0: this failure is no fault of the supervisor */
    const char *name;     /* name of the fault; for other failures the words that the operator
                           * sees */
    const char *what;     /* description of the failure */
    const char *detected; /* check that detects the failure */
    const char *within;   /* time or motion until it is detected, in words */
    enum reaction reaction;
    const char *platform; /* the platform's reaction in words */
    const char *cause;    /* likely causes of the failure */
    const char *remedy;   /* steps before the platform may move again */
    const char *least_key, *most_key; /* configuration keys of the fault's lower and upper limit;
                                       * NULL: there is no such limit */
    const char *unit;     /* unit of the fault's measured value in messages; NULL: nothing is
                           * measured */
    double per_si;        /* factor from SI to `unit` */
};

/* Table of failures, ended by a row without a name. Rows with a fault come first, and a cause comes
 * before its consequences, because several faults of one cycle get the name of the first row among
 * them. */
extern const struct failure failure_table[];

/* Returns the first row with one of these faults; NULL if there is none. */
const struct failure *failure_of(uint32_t faults);

/* Returns the name of the first of these faults; "none" for 0. */
const char *fault_name(uint32_t faults);

/* Returns those of the given faults that have this reaction. */
uint32_t failures_with(enum reaction reaction, uint32_t faults);

/* Writes the name of first_fault, and the legs in `faults` (fault_leg() bits): "following_error,
 * leg 3", "kinematics". */
enum { FAULT_TEXT_SIZE = 64 };
void fault_describe(uint32_t first_fault, uint32_t faults, char text[FAULT_TEXT_SIZE]);

/* Writes the measured value and its limit: "12.4 mm, limit 10 mm (limits.following_m)". For
 * contacts that contradict each other, writes the names of the inputs; if nothing was measured, "".
 * Returns text. */
enum { FAULT_MEASURE_SIZE = 144 };
const char *fault_measured(uint32_t first_fault, const struct fault_measure *measure, char text[FAULT_MEASURE_SIZE]);

/* Writes the fault and its measure: "following_error, leg 3: 12.4 mm, limit 10 mm
 * (limits.following_m)". */
enum { FAULT_LINE_SIZE = FAULT_TEXT_SIZE + 2 + FAULT_MEASURE_SIZE };
void fault_line(uint32_t first_fault, uint32_t faults, const struct fault_measure *measure, char text[FAULT_LINE_SIZE]);

/* Explains a fault at length; first_fault must not be 0. cause: set to the failure and its likely
 * cause. remedy: set to the steps until the platform moves again; the last step is a new run if
 * `automatic`, otherwise reset and engage. missed, longest_s: deadlines missed in a row and longest
 * delay, used only for an overrun. */
enum { FAILURE_TEXT_SIZE = 640 };
void failure_explain(uint32_t first_fault, int64_t missed, double longest_s, bool automatic, char cause[FAILURE_TEXT_SIZE],
                     char remedy[FAILURE_TEXT_SIZE]);

/* Prints failure_table in Markdown. */
void failure_print(FILE *out);

#endif
