/* Writes JSON sequentially into memory that grows, fast enough for thousands of cycles and
 * messages. Documents for people use jansson. JSON has neither NaN nor infinity: a field with such
 * a value is omitted from its message, and such an element of an array is null. Ordinary
 * threads. */
#ifndef HEXID_JSON_TEXT_H
#define HEXID_JSON_TEXT_H

#include <stdbool.h>
#include <stddef.h>

#include "message_fields.h"
#include "types.h"

struct json_text {
    char *text;             /* `size` bytes, without a zero at the end; freed by json_text_free() */
    size_t size, capacity;
    bool failed;             /* memory ran out, so that `text` is not valid JSON */
};

void json_text_free(struct json_text *j);

/* Empties the text and clears `failed`. */
void json_text_restart(struct json_text *j);

/* Append raw bytes, or, for hexid's own names and numbers, a formatted text of at most 199
 * bytes. */
void json_text_add(struct json_text *j, const char *text, size_t length);
__attribute__((format(printf, 2, 3))) void json_text_say(struct json_text *j, const char *format, ...);

/* Appends a string from anywhere, with quotes, backslashes and control characters escaped; bytes
 * that are not UTF-8 become question marks. */
void json_text_string(struct json_text *j, const char *text);

/* Append numbers with the given number of significant digits. */
void json_text_rounded(struct json_text *j, double value, int digits);
void json_text_rounded_array(struct json_text *j, const double *value, int count, int digits);

/* Appends `"name":`, after a comma unless it is the first in the object. */
void json_text_name(struct json_text *j, const char *name);

/* Append a cycle with the names of cycle_columns.h, and a message with the names of its type. */
void json_text_cycle(struct json_text *j, const struct cycle *cycle);
void json_text_message(struct json_text *j, const struct message *message);

#endif
