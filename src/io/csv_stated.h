/* The frequency and the amplitude that a CSV file states for its own test. Import writes them into
 * the log before the file's rows, as events of kind "stated", because they describe the data better
 * than any configuration, and because several files of one axis may each have their own. Pure; any
 * thread. */
#ifndef HEXID_CSV_STATED_H
#define HEXID_CSV_STATED_H

#include "messages.h"
#include "params/tests.h"
#include "types.h"

enum { CSV_STATED_SIZE = 64 };
extern const char csv_stated_kind[];

enum csv_stated_key { CSV_STATED_FREQUENCY, CSV_STATED_AMPLITUDE, CSV_STATED_KEYS };

struct csv_stated {
    enum csv_stated_key key;
    enum dof dof;
    double value; /* Hz, m or rad; NaN: the file states no value, and the value of an earlier file
                   * no longer counts */
};

/* Writes the text of an event of kind "stated". */
void csv_stated_text(const struct csv_stated *stated, char text[CSV_STATED_SIZE]);

/* Decodes an event of kind "stated". Returns false for any other message, and for a value outside
 * the range of its key in the configuration. */
bool csv_stated_decode(const void *data, int size, struct csv_stated *stated);

/* Returns the name of the key in a file's head. */
const char *csv_stated_name(enum csv_stated_key key);

/* Puts the value into `tests`; if it is NaN, puts the value from `own` instead, the tests in the
 * log's configuration. */
void csv_stated_take(const struct csv_stated *stated, const struct test_params *own, struct test_params *tests);

#endif
