/* Finds tests and segments that are mostly noise. No real time; heap. */
#ifndef HEXID_NOISE_CHECK_H
#define HEXID_NOISE_CHECK_H

#include "recording.h"
#include "residual.h"

#define NOISE_MOST 0.5 /* a segment is excluded if its rms noise exceeds this share of its rms
                        * variation, and a recording is refused if the median share does */

/* Marks those segments of the last run that are mostly noise (REFUSED_NOISE). share: median share
 * of noise in the rms variation of the run's tests and segments. If strokes are so slow that the
 * force hardly varies within a segment, the force's variation from one segment to the next counts,
 * too. Returns 0, or -3 without memory. */
int noise_check(struct recording *r, const struct residual_data *data, double *share, struct error *error);

#endif
