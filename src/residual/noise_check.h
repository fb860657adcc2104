/* Finds what is mostly noise. No real time; heap. */
#ifndef HEXID_NOISE_CHECK_H
#define HEXID_NOISE_CHECK_H

#include "recording.h"
#include "residual.h"

/* Marks those segments of the last run that are mostly noise (REFUSED_NOISE). -2: most tests or
 * segments of the last run are mostly noise; -3: no memory. */
int noise_check(struct recording *r, const struct residual_data *data, struct error *error);

#endif
