/* The pictures of a gap report as gnuplot scripts (plot.h), SVG to standard output. Measured is
 * black, the model before grey and dashed, the model after in the accent colour, so that they
 * differ without colour too. All over one mean cycle, in display units. */
#ifndef HEXID_GAP_PICTURES_H
#define HEXID_GAP_PICTURES_H

#include <stdio.h>

#include "plot.h"
#include "waves.h"

struct picture {
    const struct wave_test *test;
    int leg;
    bool after;   /* false: no model after to show */
};

/* Plots a channel's waveform; below it measurement less model, with a sample's noise as a band. */
void picture_wave(FILE *script, const struct picture *p, enum gap_channel channel);

/* Plot force over velocity: the loop, and what the models leave of it. For waves_motion. */
void picture_force_loop(FILE *script, const struct picture *p);
void picture_rest_loop(FILE *script, const struct picture *p);

/* Plots valve command over velocity, each model with its own motion. For waves_closed_loop. */
void picture_valve_loop(FILE *script, const struct picture *p);

/* Display unit of a channel in pictures, tables and on the terminal: SI value times scale, in unit.
 * Differences of two values may have another unit. */
struct picture_unit {
    double scale, difference_scale;
    const char *unit, *difference_unit;
};
extern const struct picture_unit picture_units[GAP_CHANNELS];

#endif
