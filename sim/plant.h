/* The simulated platform: rigid bodies (two engines), six hydraulic cylinders with servo valves,
 * sensors, effects. Shares no equation with src/core: a mistake in one shows as a disagreement
 * between the two.
 *
 * Time: a cycle of params->loop.period_s is params->sim.substeps equal substeps. The valve command
 * given to plant_step() acts from the start of the cycle to its end; plant_measure() latches all
 * lengths and pressures at the present instant. Effects (effect.h) that are on in params are part
 * of the machine, for either engine: what they do to commands and readings, too. plant_step,
 * plant_measure, plant_truth: RT, no heap, one thread. */
#ifndef HEXID_PLANT_H
#define HEXID_PLANT_H

#include "params.h"
#include "status.h"

struct plant;

/* The exact state, for tests and for the figures of merit; never for the controller. */
struct plant_truth {
    double time_s;
    double pose[DOFS];      /* x y z phi theta psi */
    double twist[DOFS];     /* velocity of the origin of {M}, angular velocity, both in {B} */
    double length_m[LEGS], rate_mps[LEGS]; /* up to the rod's end */
    double p1_pa[LEGS], p2_pa[LEGS];
    double spool[LEGS];     /* -1..1 */
    double hydraulic_n[LEGS]; /* A1 P1 - A2 P2 */
    double friction_n[LEGS];  /* along the leg, acting on the rod: all friction and end stops */
    bool stuck[LEGS];       /* held by dry friction */
    double kinetic_j, potential_j; /* rigid bodies; potential zero at neutral */
};

/* At rest on the lower end stops, both chambers at tank pressure, spools centred; the pose is
 * solved from the static balance on the stops' stiffness, so nothing moves at first. params must
 * outlive the plant. NULL and *error when the parameters make no machine. */
struct plant *plant_create(const struct params *params, uint64_t seed, struct error *error);
void plant_destroy(struct plant *plant);

/* At rest in the pose given, with the chamber pressures that balance it (half the supply in the
 * rodless side where possible). */
void plant_place(struct plant *plant, const double pose[DOFS]);

/* From now on the supply is a power unit's (power_unit.h), which loses it when the level of its
 * charge pump does not change for hold_s. Before, and without this, it is always on. */
void plant_add_power_unit(struct plant *plant, double hold_s);

/* The level in the cycles to come. */
void plant_charge_pump(struct plant *plant, bool level);

/* One cycle with the commands given, each -1..1 (clamped). NaN centres the valve, as its amplifier
 * does without a signal. */
void plant_step(struct plant *plant, const double valve[LEGS]);

/* One substep of the rigid bodies alone, driven by the forces given along the legs (hydraulics and
 * its friction left out; joint and dry friction, gravity and end stops stay): for tests of the
 * engines against each other and of the energy balance. */
void plant_step_forced(struct plant *plant, double dt_s, const double force_n[LEGS]);

/* What the sensors say now; fills arrays and inputs of the sample, not its time, age,
 * sequence or flags. */
void plant_measure(struct plant *plant, struct hal_sample *sample);

/* The recorder's time over the controller's: time stamps of samples run at this rate of
 * the loop's clock. */
double plant_clock_ratio(const struct plant *plant);

void plant_get_truth(const struct plant *plant, struct plant_truth *truth);

#endif
