/* The pictures of a check as gnuplot scripts (plot.h): a recording over time, as measured. */
#ifndef HEXID_CHECK_PICTURES_H
#define HEXID_CHECK_PICTURES_H

#include <stdio.h>

/* Plots a struct survey (page_script of page.h) over the test's time: one panel for each kind of
 * channel with data; without a pose, lengths and reference share a panel. With more than 1000
 * samples, a curve is the band from minimum to maximum. The background is grey at rest and blue in
 * steady motion; longer segments are labelled, steady ones with their frequency. Writes nothing for
 * a test without a sample. */
void check_picture(FILE *script, const void *survey);

#endif
