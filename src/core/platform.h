/* The controller: one pure function from sample and request to command. Replay, tests and the gap
 * workflow call it too. RT, no heap. */
#ifndef HEXID_PLATFORM_H
#define HEXID_PLATFORM_H

#include "force.h"
#include "interlock.h"
#include "kinematics.h"
#include "oscillation.h"
#include "params.h"
#include "pid.h"
#include "reference.h"
#include "status.h"
#include "supervisor.h"

struct platform {
    const struct params *params;
    const struct trajectory *trajectory; /* what is driven instead of sinusoids, NULL: none; set
                                          * between platform_init() and the first step */
    struct kinematics kinematics;
    struct cylinder_areas areas;
    struct oil_column column[LEGS];
    struct oscillation oscillation;
    struct supervisor supervisor;
    struct reference reference;
    struct pid pid[LEGS];
    /* the last good sample */
    double pose[DOFS];           /* forward kinematics starts here */
    double length_m[LEGS], force_n[LEGS]; /* force: of the last pressures believed */
    double still_m[LEGS];        /* the reading before, */
    double still_low_m[LEGS], still_high_m[LEGS]; /* and where the leg's reference has been
                                                   * since it last changed */
    int64_t good_seq, good_ns;   /* its cycle, -1: none yet; and its instant */
    uint64_t device_seq;         /* of the sample before, */
    int64_t anew_seq;            /* and the cycle in which it was last a later one */
    int64_t last_ns;             /* when the sample before was read */
    struct fault_measure measure; /* of supervisor.first_fault */
    int overruns;                /* deadlines missed in a row, at most loop.overrun_limit */
    /* the last reference and command */
    double ref[DOFS], ref_rate[DOFS], ref_accel[DOFS], leg_ref_m[LEGS];
    struct hal_command command;  /* held while samples are bad */
    uint32_t inputs;             /* INPUT_..., as they were last read, */
    struct interlock_watch watch;
    uint32_t contradicted;       /* and those whose contacts contradict each other for too long */
    /* the list of tests */
    int test;                    /* under way, or the next */
    int64_t ticks;               /* cycles in this state */
    bool stopping;               /* the test under way, or the last one, was told to end */
    bool request_taken;          /* the last request did something */
    bool automatic;              /* engage, test and park without being told; over when put down,
                                  * and with a stop, a park or a fault */
    int64_t seq;
};

int platform_init(struct platform *p, const struct params *params, struct error *error);

/* What is wrong with the inputs in this state: INPUT_... (interlock_wrong). */
uint32_t platform_wrong(const struct platform *p);

/* SAFETY: returns with out->out.enable false and all valves 0 in every state that does not hold the
 * platform, and on every fault; the level of the supply output changes in every cycle of a state
 * that needs the supply, and in no other. */
void platform_step(struct platform *p, const struct hal_sample *in, struct request request, struct cycle *out);

#endif
