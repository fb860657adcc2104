/* The pictures of a gap report as gnuplot scripts (plot.h), SVG to standard output. Measured is
 * black, the model before grey and dashed, after in the accent colour: told apart without colour,
 * too. Everything over one mean cycle, in units for people. */
#ifndef HEXID_GAP_PICTURES_H
#define HEXID_GAP_PICTURES_H

#include <stdio.h>

#include "plot.h"
#include "waves.h"

struct picture {
    const struct wave_test *test;
    int leg;
    bool after;   /* false: there is no model after to show */
};

/* A channel's waveform; below it the measurement less the model, with the noise of single samples
 * as a band. */
void picture_wave(FILE *script, const struct picture *p, enum gap_channel channel);

/* Force against velocity: the loop, and what the models leave unexplained of it. Of
 * waves_motion. */
void picture_force_loop(FILE *script, const struct picture *p);
void picture_rest_loop(FILE *script, const struct picture *p);

/* Valve command against velocity, each model with its own motion. Of waves_closed_loop. */
void picture_valve_loop(FILE *script, const struct picture *p);

/* How people are shown a channel, in pictures, tables and on the terminal: SI value times scale,
 * in unit. The difference of two values may want another unit. */
struct picture_unit {
    double scale, difference_scale;
    const char *unit, *difference_unit;
};
extern const struct picture_unit picture_units[GAP_CHANNELS];

#endif
