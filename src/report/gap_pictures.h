/* The pictures of a gap report as gnuplot scripts (plot.h), which write SVG to standard output. The
 * measured curve is black, the model before (without the effects found) is grey and dashed, and the
 * model after (with them) has the accent colour, so that the curves differ even in black and white.
 * All pictures show one mean cycle or segment, in display units. */
#ifndef HEXID_GAP_PICTURES_H
#define HEXID_GAP_PICTURES_H

#include <stdio.h>

#include "plot.h"
#include "waves.h"

struct picture {
    const struct wave_test *test;
    int leg;
    enum gap_channel channel;
    bool after;   /* the model with the effects found is shown, too */
};

/* The functions below take a struct picture; they have the type page_script (page.h).
 *
 * picture_wave() plots a channel's waveform, and below it measurement less model, with the noise of
 * a sample as a band. */
void picture_wave(FILE *script, const void *picture);

/* These two plot over the measured velocity: picture_force_loop() the forces, picture_rest_loop()
 * the measured force less the force of each model. picture->test comes from waves_motion(), and
 * `channel` is ignored. */
void picture_force_loop(FILE *script, const void *picture);
void picture_rest_loop(FILE *script, const void *picture);

/* Plots velocity over valve command; picture->test comes from waves_closed_loop(), and `channel` is
 * ignored. A model's curve shows the motion that this model made in its simulation, not the
 * measured motion. */
void picture_valve_loop(FILE *script, const void *picture);

/* Display unit of a channel in pictures, tables and on the terminal: an SI value times `scale` is
 * in `unit`. Differences of two values have difference_scale and difference_unit. */
struct picture_unit {
    double scale, difference_scale;
    const char *unit, *difference_unit;
};
extern const struct picture_unit picture_units[GAP_CHANNELS];

#endif
