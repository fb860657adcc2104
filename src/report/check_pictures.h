/* The pictures of a check as gnuplot scripts (plot.h): a recording over time, as measured. */
#ifndef HEXID_CHECK_PICTURES_H
#define HEXID_CHECK_PICTURES_H

#include <stdio.h>

/* Draws a struct survey (page_script of page.h): all channels with data over the
 * test's time, in one panel for each kind. If there are more samples than pixels, a curve is the
 * band from minimum to maximum. The background is grey at rest, and blue with the frequency in
 * steady motion. Writes nothing for a test without a sample. */
void check_picture(FILE *script, const void *survey);

#endif
