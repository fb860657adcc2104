/* The frequency that a CSV file states for its own test. Import writes it into the log before the
 * file's rows, as an event of kind "stated", because it describes the data better than any
 * configuration, and because several files of one axis may each have their own. Pure; any
 * thread. */
#ifndef HEXID_CSV_STATED_H
#define HEXID_CSV_STATED_H

#include "messages.h"
#include "types.h"

enum { CSV_STATED_SIZE = 64 };
extern const char csv_stated_kind[];

/* Writes the text of an event of kind "stated". hz: NaN for a file that states no frequency, so
 * that an earlier file's no longer counts. */
void csv_stated_text(enum dof dof, double hz, char text[CSV_STATED_SIZE]);

/* Decodes an event of kind "stated"; *hz is NaN for a file that states none. Returns false for any
 * other message, and for a frequency outside the range of tests.frequency_hz. */
bool csv_stated_decode(const void *data, int size, enum dof *dof, double *hz);

#endif
