/* Lines off the harmonics of the motion. Pure but for the heap. */
#ifndef HEXID_LINE_H
#define HEXID_LINE_H

#include "gap.h"

/* The strongest line of all tests and channels; 0 Hz where none is so much above the noise. share:
 * of the power that makes a line. */
struct gap_line line_find(const struct recording *recording, double share);

#endif
