/* Sections of a gap report below its first screen: plots of the disagreement. */
#ifndef HEXID_GAP_SECTIONS_H
#define HEXID_GAP_SECTIONS_H

#include "gap_html.h"

/* A page being written. */
struct page {
    FILE *out;
    const struct gap_report *report;
    struct error picture;  /* why the first picture was not drawn; status 0: all were */
};

void section_map(struct page *p);         /* tests x channels x legs, and the list of places */
void section_waveforms(struct page *p);   /* the largest disagreements */
void section_loops(struct page *p);       /* force and valve over velocity */

/* Writes words such as "dry friction in the cylinders (leg 3 only)". shape as in gap.h. */
void section_effect_words(FILE *out, int effect, int shape, int legs);

/* Words such as "leg length"; a single axis has a "position". */
const char *section_channel_words(int legs, enum gap_channel channel);

/* Words for a feature: "velocity_reversal" -> "where the velocity reverses". */
const char *section_feature_words(const char *feature);

#endif
