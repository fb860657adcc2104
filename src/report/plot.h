/* Pictures by gnuplot, which runs as a child process: a script in, an SVG out. Ordinary threads. */
#ifndef HEXID_PLOT_H
#define HEXID_PLOT_H

#include <stddef.h>
#include <stdio.h>

#include "status.h"

#define PICTURE_ACCENT "#0072b2"

/* Colours that colour-blind readers can tell apart, too (Okabe and Ito 2008). */
enum { PLOT_COLOURS = 6 };
extern const char *const plot_colours[PLOT_COLOURS];

/* Writes the first lines of a script: an SVG of this many pixels, in the style of all pictures.
 * Line style 1 is for measured curves, 2 for the model before effects are added, 3 for the model
 * after. */
void plot_begin(FILE *script, int width, int height);

/* Runs a script that draws to standard output. The caller frees *svg. Returns 0, or -3 with the
 * reason: gnuplot is missing, failed (in its own words), or drew nothing. */
int plot_draw(const char *script, size_t script_size, char **svg, size_t *size, struct error *error);

#endif
