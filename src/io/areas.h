/* Which areas make forces of pressures, A1 P1 - A2 P2, said to the user: with other diameters every
 * force is another, and whatever explains them. */
#ifndef HEXID_AREAS_H
#define HEXID_AREAS_H

#include "params.h"

enum { AREAS_TEXT_SIZE = 200 };

/* False: of an axis whose configuration does not state its cylinder's diameters. */
bool areas_stated(const struct params *params);

/* "31.17 cm^2 on the rodless side, 15.27 cm^2 on the rod side (piston 63 mm, rod 45 mm)", or what
 * is not stated. */
void areas_text(const struct params *params, char text[AREAS_TEXT_SIZE]);

#endif
