/* Distance of a misspelt word from the known ones. Pure, no heap. */
#ifndef HEXID_EDIT_DISTANCE_H
#define HEXID_EDIT_DISTANCE_H

enum { EDIT_DISTANCE_MAX = 128 }; /* largest length of a word, with its closing zero */

/* Returns the Levenshtein distance: letters inserted, deleted or replaced. Longer words are
 * truncated. */
int edit_distance(const char *a, const char *b);

/* Returns the distance from this word beyond which a suggestion would be a mere guess. */
int edit_distance_too_far(const char *word);

/* Finds the word probably meant among name(0), name(1) ..., ended by NULL: the first one that
 * begins with the given word, if that has three letters or more, else the nearest. Returns NULL if
 * none is near. */
const char *edit_nearest(const char *word, const char *name(int i));

#endif
