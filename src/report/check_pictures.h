/* The pictures of a check as gnuplot scripts (plot.h): a recording over time, as measured. */
#ifndef HEXID_CHECK_PICTURES_H
#define HEXID_CHECK_PICTURES_H

#include <stdio.h>

#include "survey.h"

/* Draws all channels present over the test's time, one panel for each kind. If there are more
 * samples than pixels, a curve is the band from minimum to maximum. Rests have a grey background,
 * steady pieces a blue one with their frequency. */
void check_picture(FILE *script, const struct survey *survey);

#endif
