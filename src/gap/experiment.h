/* Proposes the experiment that would tell two explanations apart, in the words of the mechanism.
 * For a mechanism that hexid drives, the text gives options of `hexid run` in backquotes; the new
 * log goes to `hexid gap` with the same --set. For a mechanism that other programs drive, the text
 * has no options. Each effect's file names the experiments for it. Pure. */
#ifndef HEXID_EXPERIMENT_H
#define HEXID_EXPERIMENT_H

#include "gap_result.h"
#include "mechanism.h"

/* Writes the experiment that tells two effects apart, given in any order. A pair without an
 * experiment of its own gets general advice. */
void experiment_between(const struct mechanism *mechanism, const struct effect *a, const struct effect *b, char text[GAP_TEXT]);

/* True if one of the two effects' files has an experiment for the pair, because the effects look
 * alike. */
bool experiment_is_known(const struct effect *a, const struct effect *b);

/* Writes the experiment that tells an effect from a parameter of the base, such as
 * "axis.force_offset_n". */
void experiment_from_parameter(const struct mechanism *mechanism, const struct effect *effect, const char *parameter, char text[GAP_TEXT]);

/* Writes the experiment that tells a mass or a spring from a part that moves by itself, after tests
 * with one frequency for each axis. hz: the lowest of these frequencies. */
void experiment_other_frequency(const struct mechanism *mechanism, double hz, char text[GAP_TEXT]);

/* Advice for a friction that is not the same in each test. */
const char *experiment_when_warm(void);

/* Advice for a gap that no effect of the catalogue explains. */
const char *experiment_unknown(void);

#endif
