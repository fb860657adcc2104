/* Sections of a gap report below its first screen: where model and measurement
 * disagree, in pictures. */
#ifndef HEXID_GAP_SECTIONS_H
#define HEXID_GAP_SECTIONS_H

#include "gap_html.h"

/* A page under way. */
struct page {
    FILE *out;
    const struct gap_report *report;
    struct error picture;  /* why the first picture was not drawn; status 0: all were */
};

void section_map(struct page *p);         /* the map: tests x channels x legs, and the list of
                                           * places */
void section_waveforms(struct page *p);   /* where they disagree most */
void section_loops(struct page *p);       /* force and valve against velocity */

/* "dry friction in the cylinders (leg 3 only)". shape as in gap.h. */
void section_effect_words(FILE *out, int effect, int shape, int legs);

/* "leg length"; for a single axis "position". */
const char *section_channel_words(int legs, enum gap_channel channel);

/* Words for a place: "velocity_reversal" -> "where the velocity reverses". */
const char *section_feature_words(const char *feature);

#endif
