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

/* Names the axes. x NULL: the x axis has no name. */
void plot_axes(FILE *script, const char *x, const char *y);

/* Divides the picture into panels, one above the other, with one range of x. left: place of the y
 * axis, as a share of the width. */
void plot_panels(FILE *script, double left, double x_from, double x_to);

/* Begins the panel between these shares of the height, counted from the bottom. x NULL: the x axis
 * has neither name nor numbers, because it shares those of the panel below. */
void plot_panel(FILE *script, double top, double bottom, const char *x, const char *y);

/* Runs a script that draws to standard output. The caller frees *svg, which is NULL on an error.
 * Returns 0, or -3 with the reason: gnuplot is missing, failed (in its own words), or drew nothing,
 * or memory is short. */
int plot_draw(const char *script, size_t script_size, char **svg, size_t *size, struct error *error);

#endif
