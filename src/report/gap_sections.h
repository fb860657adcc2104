/* Sections of a gap report below its first screen: map and plots of the disagreement; and words
 * that all parts of the report use. */
#ifndef HEXID_GAP_SECTIONS_H
#define HEXID_GAP_SECTIONS_H

#include "gap_html.h"
#include "page.h"

/* Writes a map of the disagreement by test, channel and leg, and the list of the gap's places. */
void section_map(FILE *out, const struct gap_report *report);
void section_waveforms(struct page *p, const struct gap_report *report); /* plots of the largest
                                                                          * disagreements */
void section_loops(struct page *p, const struct gap_report *report);     /* plots of force over
                                                                          * velocity, and of
                                                                          * velocity over valve */

/* Writes words such as "dry friction in the cylinders (leg 3 only)". pattern: as in struct
 * gap_effect. legs: the mechanism's number of legs. */
void section_effect_words(FILE *out, int effect, int pattern, int legs);

/* Returns true for an effect that was found, cannot be distinguished from a found one, or contains
 * a found one as a special case. Such an effect is no runner-up. */
bool section_named(const struct gap_result *r, int effect);

/* Returns the words for a channel, such as "leg length"; with one leg "position". */
const char *section_channel_words(int legs, enum gap_channel channel);

/* Returns the words for a feature: "where the velocity reverses" for "velocity_reversal". */
const char *section_feature_words(const char *feature);

#endif
