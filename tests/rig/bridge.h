/* The rig as a machine that another program's controller drives, in plain C. SI units and the legs'
 * order are those of config/tian2015.yaml; the pose is that of {M}, whose origin is the configured
 * mass centre: x y z phi theta psi. */
#ifndef HEXID_TESTS_RIG_BRIDGE_H
#define HEXID_TESTS_RIG_BRIDGE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { BRIDGE_LEGS = 6 };

/* The parameters of the rig that are not the configured ones, as factors of these. */
struct bridge_base {
    double payload, upper, lower; /* mass and inertia of payload, rods and cylinders */
    double viscous[BRIDGE_LEGS], bulk[BRIDGE_LEGS], leakage[BRIDGE_LEGS], gain[BRIDGE_LEGS];
    double dead1[BRIDGE_LEGS], dead2[BRIDGE_LEGS]; /* dead volumes, rodless side and rod side */
    double null_bias[BRIDGE_LEGS]; /* no factor: share of full opening */
};

struct bridge_setup {
    int64_t tolerance_seed; /* as of `rig --tolerance`; negative: the configured parameters */
    const char *only; /* name of the one member of bridge_base that is drawn; NULL: all are */
    double dry_n; /* dry friction of each cylinder */
    double step_s; /* longest step of the integrator */
    uint64_t noise_seed; /* of the sensors */
};

struct bridge;

/* Makes a rig at rest in the parked pose, and tells its base. Prints the reason and returns NULL if
 * there is no such rig. */
struct bridge *bridge_create(const struct bridge_setup *setup, struct bridge_base *base);
void bridge_destroy(struct bridge *bridge);

/* Reads the sensors at the present instant: lengths joint to joint, pressures of the rodless and of
 * the rod side. */
void bridge_measure(struct bridge *bridge, double length_m[BRIDGE_LEGS], double p1_pa[BRIDGE_LEGS],
                    double p2_pa[BRIDGE_LEGS]);

/* Returns the true pose. */
void bridge_pose(const struct bridge *bridge, double pose[6]);

/* Makes one period of 2 ms with these commands, each -1..1; positive extends the leg. Prints the
 * reason and ends the program if the simulation diverges. */
void bridge_step(struct bridge *bridge, const double valve[BRIDGE_LEGS]);

#ifdef __cplusplus
}
#endif

#endif
