/* Refuses forces and valve commands that contradict the motion, the supply or the weight: wrong
 * signs, exchanged plugs, wrong units. All functions check the last run, and return 0, or -2 with
 * the reason. Pure; any thread. */
#ifndef HEXID_FORCE_CHECK_H
#define HEXID_FORCE_CHECK_H

#include "recording.h"
#include "residual.h"

/* Checks a single axis: the force must drive the motion, with a mass near the configured one. */
int force_check_axis(const struct recording *r, const struct residual_data *data, struct error *error);

/* Checks the pressures against the supply and, on a platform, their mean forces against the
 * weight. */
int force_check_pressures(const struct recording *r, struct error *error);

/* Checks the forces of each leg against those that the motion needs, and the valve commands against
 * the legs' speeds. */
int force_check_drives(const struct recording *r, const struct residual_data *data, struct error *error);

#endif
