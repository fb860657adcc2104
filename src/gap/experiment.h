/* The one experiment that would tell two explanations apart, in the words of the mechanism:
 * on a platform options of `hexid run` stand in backquotes, and the new log goes to
 * `hexid gap` with the same --set; one axis is driven by others. What tells effects apart
 * stands in their files. Pure. */
#ifndef HEXID_EXPERIMENT_H
#define HEXID_EXPERIMENT_H

#include "gap.h"

/* Two effects in any order; general advice where the pair has none of its own. */
void experiment_between(enum mechanism_kind mechanism, const struct effect *a, const struct effect *b, char text[GAP_TEXT]);

/* An effect and a parameter of the base, PARAMETER(axis.force_offset_n). */
void experiment_from_parameter(enum mechanism_kind mechanism, const struct effect *effect, size_t parameter, char text[GAP_TEXT]);

/* What to measure when no effect of the catalogue explains the gap, and when it is a line
 * off the harmonics. */
const char *experiment_unknown(void);
const char *experiment_line(enum mechanism_kind mechanism);

#endif
