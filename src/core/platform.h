/* The controller: one pure function from sample and request to command. Replay, tests and the gap workflow call it too. RT, no heap. */
#ifndef HEXID_PLATFORM_H
#define HEXID_PLATFORM_H

#include "force.h"
#include "kinematics.h"
#include "params.h"
#include "pid.h"
#include "reference.h"
#include "supervisor.h"
#include "status.h"

struct platform {
    const struct params *params;
    struct kinematics kinematics;
    struct cylinder_areas areas;
    struct pid pid[LEGS];
    struct reference reference;
    struct supervisor supervisor;
    double pose[DOFS];          /* the last one, forward kinematics starts here */
    double last_length_m[LEGS];
    uint64_t seq;
};

int platform_init(struct platform *p, const struct params *params, struct error *error);

/* SAFETY: returns with out->out.enable false and all valves 0 in every state that does not hold the platform, and on every fault. */
void platform_step(struct platform *p, const struct hal_sample *in, struct request request, struct cycle *out);

#endif
