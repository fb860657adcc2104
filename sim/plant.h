/* The simulated platform: rigid bodies (two engines), six hydraulic cylinders with servo valves,
 * sensors, effects. It shares no equation with src/core, so that a mistake in one shows as a
 * disagreement of the two.
 *
 * Time: a cycle of params->loop.period_s has params->sim.substeps equal substeps. The valve command
 * of plant_step() acts from the start of the cycle to its end; plant_measure() latches all lengths
 * and pressures at the present instant. Effects (effect.h) that are on in params belong to the
 * machine, with either engine, and also act on commands and readings. plant_step, plant_measure,
 * plant_get_truth: RT, no heap, one thread. */
#ifndef HEXID_PLANT_H
#define HEXID_PLANT_H

#include "status.h"
#include "types.h"

struct params;
struct plant;

/* Exact state, for tests and figures of merit; never for the controller. */
struct plant_truth {
    double time_s;
    double pose[DOFS];      /* pose of the platform: x y z phi theta psi */
    double twist[DOFS];     /* velocity of the origin of {M}, and angular velocity, both in {B} */
    double length_m[LEGS], rate_mps[LEGS]; /* length of each leg up to the rod's end, and its
                                            * rate */
    double p1_pa[LEGS], p2_pa[LEGS];
    double spool[LEGS];     /* position of each spool, -1..1 */
    double hydraulic_n[LEGS]; /* hydraulic force of each leg, A1 P1 - A2 P2 */
    double friction_n[LEGS];  /* sum of friction, seals and end stops on each rod, positive away
                               * from the base */
    bool stuck[LEGS];       /* dry friction holds the leg */
    double kinetic_j, potential_j; /* energies of the rigid bodies; the potential energy is zero at
                                    * neutral */
};

/* Makes a plant at rest on the lower end stops, with both chambers of every leg at tank pressure
 * and spools centred. The pose is the static balance on the stops' springs, so that nothing moves
 * at first. params must outlive the plant. Returns NULL and sets *error if no machine can have
 * these parameters, the substeps are too long for it, or there is no memory. */
struct plant *plant_create(const struct params *params, uint64_t seed, struct error *error);
void plant_destroy(struct plant *plant);

/* Puts the plant at rest in a pose that the legs can hold. Chamber pressures balance it, with half
 * the supply pressure on the rodless side if possible. */
void plant_place(struct plant *plant, const double pose[DOFS]);

/* Supplies the plant from a power unit from now on (power_unit.h), which switches the supply off if
 * the life sign does not change for hold_s. Without this call the supply is always on. */
void plant_add_power_unit(struct plant *plant, double hold_s);

/* Sets the level of the life sign (types.h) for the cycles to come. */
void plant_life_sign(struct plant *plant, bool level);

/* Makes one cycle with these commands, which are limited to -1..1. NaN centres the valve, as a
 * valve amplifier does without a signal. */
void plant_step(struct plant *plant, const double valve[LEGS]);

/* Makes one substep of the rigid bodies alone under these forces along the legs, to test the
 * engines against each other and the energy balance. Hydraulic forces and the cylinders' viscous
 * friction are left out; dry friction, joint friction, gravity and end stops remain. */
void plant_step_forced(struct plant *plant, double dt_s, const double force_n[LEGS]);

/* Reads sensors and inputs into the sample; does not change the sample's time, age, sequence number
 * and flags. */
void plant_measure(struct plant *plant, struct hal_sample *sample);

/* Returns the speed of the recorder's clock divided by that of the controller's: the samples' time
 * stamps advance at this rate on the loop's clock. */
double plant_clock_ratio(const struct plant *plant);

void plant_get_truth(const struct plant *plant, struct plant_truth *truth);

#endif
