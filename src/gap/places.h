/* Where a gap lies: which test, channel, leg and harmonic, and which feature of the motion it
 * goes with. Ordinary threads; heap. */
#ifndef HEXID_PLACES_H
#define HEXID_PLACES_H

#include "diagnose.h"

/* The largest places of a model's white residuals on held-out cycles, by share;
 * returns their number. */
int places_find(const struct diagnosis *d, const struct recording *recording, const struct params *model,
                struct gap_place place[GAP_PLACES]);

#endif
