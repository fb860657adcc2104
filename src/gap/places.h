/* Places of the gap: test, channel, leg and harmonic, and the feature of the motion that the gap
 * follows most. Ordinary threads; heap. */
#ifndef HEXID_PLACES_H
#define HEXID_PLACES_H

#include "diagnose.h"

/* Finds the places with the largest shares of the model's squared white residuals on held-out
 * cycles, largest first. Returns their number. */
int places_find(const struct diagnosis *d, const struct recording *recording, const struct params *model,
                struct gap_place place[GAP_PLACES]);

#endif
