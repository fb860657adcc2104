/* A base on springs and a pump with pressure ripple; the model assumes a rigid base and a steady
 * supply. Neither is an effect of the catalogue, so they test the diagnosis with causes that it
 * does not know. ODE engine only. Pure, RT.
 *
 * Base: a rigid body of mass mb = sim.base_mass_kg, which translates without rotation. In the
 * base's frame every other body feels the acceleration -a_b, where a_b is that of the base. With M
 * the mass and P the momentum of the other bodies in that frame, (mb + M) a_b = -dP/dt - k x_b - c
 * v_b, k = (mb + M) w^2, c = 0.1 (mb + M) w, w = 2 pi sim.base_hz. Pump: supply = Ps + ripple
 * sin(2 pi f t). */
#ifndef HEXID_SURROUNDINGS_H
#define HEXID_SURROUNDINGS_H

#include <stdbool.h>

struct params;

struct surroundings {
    const struct params *params;
    double time_s;
    double position_m[3], rate_mps[3], acceleration_mps2[3]; /* motion of the base */
    double momentum[3];                                   /* momentum of the bodies one substep
                                                           * ago */
    bool moved;                                              /* `momentum` has been set */
};

/* Returns true if the base is on springs or the pump has ripple. */
bool surroundings_yield(const struct params *params);

/* Makes one substep. mass_kg, momentum: sum of the masses and of the momenta of all bodies on the
 * base, in the base's frame. */
void surroundings_step(struct surroundings *s, double dt_s, double mass_kg, const double momentum[3]);

/* Returns the supply pressure with its ripple, Pa. */
double surroundings_supply(const struct surroundings *s);

#endif
