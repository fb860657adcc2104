/* The one experiment that would tell two explanations apart, in the words of the mechanism. For a
 * platform it gives options of `hexid run` in backquotes; the new log goes to `hexid gap` with the
 * same --set. A single axis is driven by other programs, so its advice has no options. The file of
 * each effect says what tells it apart. Pure. */
#ifndef HEXID_EXPERIMENT_H
#define HEXID_EXPERIMENT_H

#include "gap_result.h"
#include "params.h"

/* Writes the experiment that tells two effects, in any order, apart; general advice if the pair has
 * none of its own. */
void experiment_between(enum mechanism_kind mechanism, const struct effect *a, const struct effect *b, char text[GAP_TEXT]);

/* Writes the experiment that tells an effect from a parameter of the base, such as
 * "axis.force_offset_n". */
void experiment_from_parameter(enum mechanism_kind mechanism, const struct effect *effect, const char *parameter, char text[GAP_TEXT]);

/* Advice for a gap that no effect of the catalogue explains (unknown), and for a tone off the
 * harmonics of the motion (line). */
const char *experiment_unknown(void);
const char *experiment_line(enum mechanism_kind mechanism);

#endif
