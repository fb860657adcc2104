/* Tells the user which piston areas convert pressures into forces (A1 P1 - A2 P2), because wrong
 * diameters make every force wrong, and every result that follows from forces. */
#ifndef HEXID_AREAS_H
#define HEXID_AREAS_H

#include <stdbool.h>

struct params;

enum { AREAS_TEXT_SIZE = 200 };

/* Returns false for a single axis whose configuration does not state its cylinder's diameters. */
bool areas_stated(const struct params *params);

/* Writes the areas: "31.17 cm^2 on the rodless side, 15.27 cm^2 on the rod side (piston 63 mm, rod
 * 45 mm)". If the legs differ, writes that each has its own areas; if a diameter is not stated,
 * writes which. */
void areas_text(const struct params *params, char text[AREAS_TEXT_SIZE]);

#endif
