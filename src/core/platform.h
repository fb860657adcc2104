/* The controller: platform_step(), one pure function from sample and request to command. The loop,
 * replays, tests and `hexid gap` call it. RT, no heap. */
#ifndef HEXID_PLATFORM_H
#define HEXID_PLATFORM_H

#include "force.h"
#include "interlock.h"
#include "kinematics.h"
#include "modal.h"
#include "model_law.h"
#include "oscillation.h"
#include "params/control.h"
#include "pid.h"
#include "reference.h"
#include "status.h"
#include "supervisor.h"

struct platform {
    const struct params *params;
    const struct trajectory *trajectory; /* trajectory that replaces the tests' sinusoids; NULL:
                                          * none; the caller sets it between platform_init() and the
                                          * first step */
    struct kinematics kinematics;
    struct cylinder_areas areas;
    struct oil_column column[LEGS];
    struct oscillation oscillation;
    struct supervisor supervisor;
    struct reference reference;
    struct pid pid[LEGS];
    struct modal modal;
    struct model_law model;      /* used with control.law model */
    struct control_params control; /* present gains, initially the configured ones */
    int64_t set_seq;             /* cycle in which the gains were last changed; -1: never */
    /* the members below, up to anew_seq, come from earlier samples */
    double pose[DOFS];           /* last pose found, the start value of the next forward
                                  * kinematics */
    double length_m[LEGS], force_n[LEGS]; /* leg lengths of the last good sample, and leg forces
                                           * from the last trusted pressures */
    double still_m[LEGS];        /* length of each leg in the previous sample */
    double still_low_m[LEGS], still_high_m[LEGS]; /* range over which each leg's reference has moved
                                                   * since the reading of the leg's length last
                                                   * changed */
    int64_t good_seq, good_ns;   /* cycle and time of the last good sample; cycle -1: none yet */
    uint64_t device_seq;         /* device_seq of the previous sample */
    int64_t anew_seq;            /* last cycle with a new sample, by device_seq */
    struct fault_measure measure; /* value and limit of supervisor.first_fault */
    int overruns;              /* number of deadlines missed in a row, at most loop.overrun_limit */
    /* reference of the last cycle: pose, rate, acceleration, leg lengths */
    double ref[DOFS], ref_rate[DOFS], ref_accel[DOFS], leg_ref_m[LEGS];
    struct hal_command command;  /* last command; it is held while samples are bad */
    uint32_t inputs;             /* inputs as last read: INPUT_... */
    struct interlock_watch watch;
    uint32_t contradicted;     /* inputs whose two contacts have contradicted each other for longer
                                * than interlocks.discrepancy_s */
    /* state of the controller, and progress through the list of tests */
    int test;                    /* index of the current or next test */
    int64_t ticks;               /* number of cycles in this state */
    bool stopping;               /* a stop has ended the latest tests, or is ramping out the present
                                  * one */
    bool request_taken;          /* the last request had an effect */
    uint32_t opened;             /* wrong inputs that ended the automatic run; 0: none */
    bool automatic;              /* the platform engages, tests and parks without requests; becomes
                                  * false when the platform has parked, after a stop, a park or a
                                  * fault, and if an input is wrong while the supply is off */
    int64_t seq;
};

int platform_init(struct platform *p, const struct params *params, struct error *error);

/* Returns the inputs INPUT_... that are wrong in the present state (interlock_wrong()). */
uint32_t platform_wrong(const struct platform *p);

/* Computes one cycle. SAFETY: out->out.enable is false and all valves are 0 in every state in which
 * the valves are not driven, and on every fault that stops (REACTION_STOP); the supply output
 * toggles in every cycle of a state that needs the supply, and in no other. */
void platform_step(struct platform *p, const struct hal_sample *in, struct request request, struct cycle *out);

#endif
