/* How far a misspelt word is from those that there are. Pure, no heap. */
#ifndef HEXID_EDIT_DISTANCE_H
#define HEXID_EDIT_DISTANCE_H

enum { EDIT_DISTANCE_MAX = 128 }; /* characters of either word, with its zero */

/* Levenshtein distance: letters put in, taken out or replaced. Of longer words the
 * beginnings are compared. */
int edit_distance(const char *a, const char *b);

/* From here on a suggestion is a guess, not a help. */
int edit_distance_too_far(const char *word);

/* The one of name(0), name(1) ... to the NULL behind the last that was meant by this word: that
 * begins with it, else the nearest; NULL: none is near. */
const char *edit_nearest(const char *word, const char *name(int i));

#endif
