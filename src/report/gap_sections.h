/* Sections of a gap report below its first screen: plots of the disagreement. */
#ifndef HEXID_GAP_SECTIONS_H
#define HEXID_GAP_SECTIONS_H

#include "gap_html.h"
#include "page.h"

/* Writes the disagreement by test, channel and leg, and the list of places. */
void section_map(FILE *out, const struct gap_report *report);
void section_waveforms(struct page *p, const struct gap_report *report); /* plots of the largest
                                                                          * disagreements */
void section_loops(struct page *p, const struct gap_report *report);     /* plots of force and valve
                                                                          * over velocity */

/* Writes words such as "dry friction in the cylinders (leg 3 only)". pattern: as in struct
 * gap_effect. */
void section_effect_words(FILE *out, int effect, int pattern, int legs);

/* Returns true for an effect that is named, is a rival of a named one, or contains one as a special
 * case. Such an effect is no runner-up. */
bool section_named(const struct gap_result *r, int effect);

/* Returns the words for a channel, such as "leg length"; "position" for a single axis. */
const char *section_channel_words(int legs, enum gap_channel channel);

/* Returns the words for a feature: "where the velocity reverses" for "velocity_reversal". */
const char *section_feature_words(const char *feature);

#endif
