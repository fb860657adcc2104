/* The pictures of a check as gnuplot scripts (plot.h): a recording over time, as measured. */
#ifndef HEXID_CHECK_PICTURES_H
#define HEXID_CHECK_PICTURES_H

#include <stdio.h>

#include "survey.h"

/* All channels that are there, one kind below the other, over the test's time; a curve of more
 * samples than pixels is the band from the least to the greatest of each pixel. Rests have a grey
 * background, steady pieces a blue one with their frequency. */
void check_picture(FILE *script, const struct survey *survey);

#endif
